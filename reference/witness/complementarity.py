"""Linear complementarity problems, w = M z + q, w ≥ 0, z ≥ 0, wᵀ z = 0, by Lemke's method; Coulomb's law as one.

(Lemke's complementary pivoting and the planar friction problem with variables N, T⁺, T⁻, σ are known to us from Cottle,
Pang & Stone, The Linear Complementarity Problem, not looked up.)
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from math import inf

import numpy as np

from ..scales import inverse_mass_scale

# A contact closes, slips or accelerates if the speed or acceleration exceeds this part of the motion's.
MOVES = 1e-10
# A force of zero is above minus this.
SMALLEST = 1e-300
# Pivots of a problem of n variables: a multiple of n in practice.
MOST_PIVOTS = 50
# Entries below this part of the largest are roundings, and no pivots.
SMALL = 1e-11
# Inequalities and complementarity of a solution hold to this part of the sums' terms; wrong ones are off by a tenth.
ROUNDING = 1e-8
# Solutions that differ by less than this part are the same.
SAME = 1e-7
# Lemke's method follows one path for each covering vector; different ones may reach different solutions.
COVERS = 6
# All complementary cones of a problem with at most so many variables are tried: 4,096, four variables for each contact.
MOST_VARIABLES = 12
# Beyond this coefficient (a perfectly rough contact has 1e9) a residual of SMALL in a cone no longer shows a solution.
LARGEST_MU = 1e5
# Sweeps of the projected Gauss-Seidel method, the change of rates at which it has converged, and the forces, in units
# of those that the load needs, from which it looks for contacts that press against each other.
SWEEPS, CONVERGED, PRESSED = 300, 1e-12, 100.0
# Sweeps where it is the only method that is left.
MOST_SWEEPS = 20_000


def lemke(matrix: np.ndarray, right: np.ndarray, cover: np.ndarray) -> np.ndarray | None:
    """One solution z, shape (n,); None if the method ends in a ray."""
    n = len(right)
    if right.min(initial=0.0) >= 0.0:
        return np.zeros(n)
    table = np.hstack([np.eye(n), -matrix, -cover[:, None], right[:, None]])
    basis = list(range(n))
    row = int(np.argmin(right / cover))
    entering = 2 * n
    for _ in range(MOST_PIVOTS * n):
        table[row] /= table[row, entering]
        for other in range(n):
            if other != row:
                table[other] -= table[other, entering] * table[row]
        leaving, basis[row] = basis[row], entering
        if leaving == 2 * n:
            z = np.zeros(2 * n + 1)
            z[basis] = table[:, -1]
            return z[n : 2 * n]
        entering = leaving + n if leaving < n else leaving - n
        column = table[:, entering]
        candidates = np.flatnonzero(column > SMALL * np.abs(table[:, :-1]).max())
        if not candidates.size:
            return None
        ratios = table[candidates, -1] / column[candidates]
        near = candidates[ratios <= ratios.min() + SMALL * (np.abs(ratios).max() + 1e-300)]
        artificial = [i for i in near.tolist() if basis[i] == 2 * n]
        row = artificial[0] if artificial else int(near[np.argmax(column[near])])
    return None


def complementary_cones(matrix: np.ndarray, right: np.ndarray) -> list[np.ndarray]:
    """Solutions z, shape (n,), one from each complementary cone that contains one: of each pair w, z one is zero, and
    the others are fitted by nonnegative least squares."""
    from scipy.optimize import nnls

    n, answers = len(right), list[np.ndarray]()
    size = float(np.abs(right).max(initial=0.0)) or 1.0
    for choice in product((False, True), repeat=n):
        z_side = np.array(choice)
        columns = np.where(z_side, -matrix, np.eye(n))
        try:
            values, residual = nnls(columns, right)
        except RuntimeError:  # it has not converged: degenerate columns
            continue
        if residual <= SMALL * size:
            answers.append(np.where(z_side, values, 0.0))
    return answers


def is_solution(matrix: np.ndarray, right: np.ndarray, z: np.ndarray) -> bool:
    """Whether z solves the problem to rounding: pivots that are almost zero may end Lemke's method elsewhere."""
    sizes = np.abs(matrix) @ np.abs(z) + np.abs(right).max(initial=0.0)
    parts = z / (np.abs(z).max(initial=0.0) or 1.0), (matrix @ z + right) / np.where(sizes > 0.0, sizes, 1.0)
    return bool(np.minimum(*parts).min(initial=0.0) >= -ROUNDING and np.minimum(*parts).max(initial=0.0) <= ROUNDING)


def covers(n: int) -> list[np.ndarray]:
    """Covering vectors of positive entries, the first of ones."""
    numbers = np.random.default_rng(0)
    return [np.ones(n), *(numbers.uniform(0.1, 10.0, n) for _ in range(COVERS - 1))]


def friction_problem(
    delassus: np.ndarray,
    free: np.ndarray,
    slips: Sequence[float | None],
    mu: np.ndarray,
    stick: np.ndarray,
    least: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Coulomb's law at K contacts as a problem: its matrix and vector, and the matrix from z to the contact forces.

    `delassus` (2K, 2K) maps forces (N₁ … N_K, T₁ … T_K) to the rates of lift and slip, `free` (2K,) are those without
    forces. `slips`: the sign of each slip, None where friction resists its beginning. `least`: normal forces that act
    in any case. `mu`, `stick` (K,): the coefficients of friction with and without slip.

    Rolling resistance has the same law: with it there are 3K forces and rates, the last K those of couples and of the
    rotation, and 2K slips and coefficients, the last K those of the rotation.
    """
    count = len(free) - len(slips)
    open_cone = [k for k, sign in enumerate(slips) if sign is None and mu[k] > 0.0]
    columns = np.zeros((len(free), count + 3 * len(open_cone)))
    rows = np.zeros((count + 3 * len(open_cone), len(free)))
    extra = np.zeros((len(rows), len(rows)))
    base = np.zeros(len(free))
    least = np.zeros(count) if least is None else least
    base[:count] = least
    for k, sign in enumerate(slips):
        own = k % count
        columns[own, own] = rows[own, own] = 1.0
        if sign is not None and mu[k] > 0.0:
            columns[count + k, own] = -sign * mu[k]
            base[count + k] = -sign * mu[k] * least[own]
    constant = np.zeros(len(rows))
    for i, k in enumerate(open_cone):
        forward, backward, bound = (count + 3 * i + j for j in range(3))
        columns[count + k, forward], columns[count + k, backward] = 1.0, -1.0
        rows[forward, count + k], rows[backward, count + k] = 1.0, -1.0
        extra[forward, bound] = extra[backward, bound] = 1.0
        extra[bound, k % count], extra[bound, forward], extra[bound, backward] = stick[k], -1.0, -1.0
        constant[bound] = stick[k] * least[k % count]
    matrix = rows @ delassus @ columns + extra
    return matrix, rows @ (free + delassus @ base) + constant, np.column_stack([columns, base])


def gauss_seidel(
    delassus: np.ndarray,
    free: np.ndarray,
    slips: Sequence[float | None],
    mu: np.ndarray,
    stick: np.ndarray,
    start: np.ndarray,
    sweeps: int = SWEEPS,
    precision: float = CONVERGED,
) -> np.ndarray | None:
    """Contact forces by projection, contact after contact, from `start`; None if it does not converge: if rates still
    change by more than the part `precision` of those without forces, or forces grow that cancel each other. Arguments
    as of `friction_problem`."""
    force, count = start.copy(), len(free) - len(slips)
    size = np.abs(free).max() or 1.0
    for _ in range(sweeps):
        before = force.copy()
        for k, sign in enumerate(slips):
            t, own = count + k, k % count
            if k == own:
                force[k] = max(0.0, force[k] - (delassus[k] @ force + free[k]) / delassus[k, k])
            if sign is not None or mu[k] == 0.0:
                force[t] = -(sign or 0.0) * mu[k] * force[own]
                continue
            bound = stick[k] * force[own]
            force[t] = min(bound, max(-bound, force[t] - (delassus[t] @ force + free[t]) / delassus[t, t]))
        change = force - before
        if np.abs(delassus @ change).max() <= precision * size:
            grows = np.abs(delassus.diagonal() * change).max() > ROUNDING * size
            return None if grows else force
        if not np.isfinite(force).all():
            return None
    return None


def refine_solution(delassus: np.ndarray, free: np.ndarray, force: np.ndarray, mu: np.ndarray) -> np.ndarray:
    """A solution with perfectly rough contacts, whose coefficient multiplies its roundings, again from the equations
    that hold in it: no lift where a contact presses, and no slip inside its cone. The same if these are dependent."""
    count = len(free) - len(mu)
    parts = len(mu) // count
    normal, friction = force[:count], force[count:]
    presses = normal > ROUNDING * np.abs(normal).max(initial=0.0)
    every = np.tile(presses, parts)
    sticks = every & (mu > 0.0) & (np.abs(friction) < (1.0 - ROUNDING) * mu * np.tile(normal, parts))
    columns = np.eye(len(free))
    for i, share in enumerate(np.split(np.where(sticks, 0.0, np.sign(friction) * mu), parts), 1):
        columns[i * count : (i + 1) * count, :count] = np.diag(share)
    rows = np.flatnonzero(np.concatenate([presses, sticks]))
    matrix = (delassus @ columns)[np.ix_(rows, rows)]
    if parts > 1:  # several contacts resist the same rotation
        return columns[:, rows] @ np.linalg.lstsq(matrix, -free[rows], rcond=SMALL)[0]
    try:
        values = np.linalg.solve(matrix, -free[rows])
    except np.linalg.LinAlgError:
        return force
    return columns[:, rows] @ values


def least_rate(
    delassus: np.ndarray,
    free: np.ndarray,
    slips: Sequence[float | None],
    mu: np.ndarray,
    stick: np.ndarray,
    rows: Sequence[int] | slice,
    none: float,
) -> float:
    """The least of the greatest rates in these rows that forces of Coulomb's law leave, as a part of the greatest rate
    without forces; infinite without a solution. Lemke's method takes what is below SMALL for zero: forces whose rates
    exceed the part `none` are made more precise by projection."""
    size, least = float(np.abs(free).max()) or 1.0, inf
    for force in solutions(delassus, free, slips, mu, stick):
        force = _within_cones(force, slips, stick)
        rate = float(np.abs((delassus @ force + free)[rows]).max())
        if none * size < rate <= ROUNDING * size:
            finer = gauss_seidel(delassus, free, slips, mu, stick, force, precision=0.1 * none)
            rate = rate if finer is None else min(rate, float(np.abs((delassus @ finer + free)[rows]).max()))
        least = min(least, rate / size)
    return least


def _within_cones(force: np.ndarray, slips: Sequence[float | None], stick: np.ndarray) -> np.ndarray:
    """Forces that Lemke's method leaves a little outside their cones, at their bounds."""
    inside, count = force.copy(), len(force) - len(slips)
    for k, sign in enumerate(slips):
        if sign is None:
            bound = stick[k] * max(force[k % count], 0.0)
            inside[count + k] = min(bound, max(-bound, force[count + k]))
    return inside


def solutions(
    delassus: np.ndarray,
    free: np.ndarray,
    slips: Sequence[float | None],
    mu: np.ndarray,
    stick: np.ndarray,
    least: np.ndarray | None = None,
) -> list[np.ndarray]:
    """Contact forces that satisfy Coulomb's law, one for each different set of rates among those found from several
    covering vectors. Arguments as of `friction_problem`. They are computed in units of the plates' mass: pivots are
    compared with those of the cones, which are ones."""
    unit = inverse_mass_scale(delassus)
    inside = None if least is None else least * unit
    return [force / unit for force in _solutions_in_unit(delassus / unit, free, slips, mu, stick, inside)]


def _solutions_in_unit(
    delassus: np.ndarray,
    free: np.ndarray,
    slips: Sequence[float | None],
    mu: np.ndarray,
    stick: np.ndarray,
    least: np.ndarray | None,
) -> list[np.ndarray]:
    """The same with a matrix whose largest diagonal entry is one."""
    matrix, right, to_forces = friction_problem(delassus, free, slips, mu, stick, least)
    size = np.abs(right).max(initial=0.0)
    scale = np.abs(delassus).max(initial=0.0)
    count = len(free) - len(slips)
    results: list[tuple[np.ndarray, np.ndarray]] = []
    answers = [lemke(matrix, right, cover) for cover in covers(len(right))]
    is_scaled = mu.max(initial=0.0) <= LARGEST_MU
    if 1 < count and len(right) <= MOST_VARIABLES and least is not None and is_scaled:
        answers += complementary_cones(matrix, right)
    forces = [to_forces @ np.append(z, 1.0) for z in answers if z is not None and is_solution(matrix, right, z)]
    if count > 1 and mu.any() and least is None:
        # Contacts that press against each other may hold a plate that others would let go: start from large forces.
        large = PRESSED * size / min(delassus.diagonal()) * np.repeat([1.0, 0.0], [count, len(slips)])
        pressed = gauss_seidel(delassus, free, slips, mu, stick, large)
        forces += [pressed] if pressed is not None else []
    if not forces and len(slips) > count and not (least is not None and least.any()):
        # Pivots fail where perfectly rough contacts resist one rotation: their couples are not unique.
        projected = gauss_seidel(delassus, free, slips, mu, stick, np.zeros(len(free)), MOST_SWEEPS)
        forces = [projected] if projected is not None else []
    for force in forces:
        rates = delassus @ force + free
        if all(np.abs(rates - other).max() > SAME * max(size, scale * np.abs(force).max()) for _, other in results):
            results.append((force, rates))
    return [force for force, _ in results]


# --- perfectly rough contacts, whose coefficient is a large number ----------------------------------------------------


def slips_at_rough_contact(delassus: np.ndarray, free: np.ndarray, force: np.ndarray, rough: np.ndarray) -> bool:
    """Whether a perfectly rough contact, whose coefficient is a large number here, would slip with these forces: it
    would have to pull in order not to."""
    rates = np.abs(delassus @ force + free)
    small = MOVES * max(float(np.abs(free).max()), float(np.abs(delassus).max() * np.abs(force).max()))
    count = len(rough)
    return bool((rough & (rates[:count] <= small) & (rates[count : 2 * count] > small)).any())


def pressing_forces(
    delassus: np.ndarray, free: np.ndarray, senses: Sequence[float | None], arms: np.ndarray, may_vanish: bool = False
) -> list[np.ndarray]:
    """The forces with which a contact presses and does not slip; with rolling resistance, of one sense of the rotation
    and one arm (over the radius of gyration), that also resist it, and prevent it where they can. `may_vanish`: also
    without a normal force, as a guide holds."""
    least = -SMALLEST if may_vanish else 0.0
    if not senses:
        pressure = -np.linalg.solve(delassus, free)
        return [pressure] if pressure[0] > least else []
    (sense,), answers = senses, list[np.ndarray]()
    for turn in (0.0, 1.0, -1.0) if sense is None else (sense,):
        columns = np.eye(3) if turn == 0.0 else np.array([[1.0, 0.0], [0.0, 1.0], [-turn * arms[0], 0.0]])
        rows = columns.shape[1]
        force = -columns @ np.linalg.solve((delassus @ columns)[:rows], free[:rows])
        begins = turn * float((delassus @ force + free)[2]) > 0.0 if turn else abs(force[2]) <= arms[0] * force[0]
        if force[0] > least and (begins or sense is not None):
            answers.append(force)
    return answers
