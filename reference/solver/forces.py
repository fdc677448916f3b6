"""Forces of contacts that hold a plate at rest: which forces are admissible, and by how much.

A force inside Coulomb's cone is a sum of its two edges n ± μ t with weights that are not negative (a frictionless
contact has the one edge n, one that slips n + ratio t). With rolling resistance each edge has a couple as well: any up
to the arm times the normal force, or that of a rotation. Equilibrium is three equations for the weights, so the
admissible forces are a polytope. A linear program finds whether it is empty, and its vertices give its ranges. Where it
has no bound or too many vertices, linear programs do, and the last step solves the active equations, to rounding. A
plate that belts move in a given way is in equilibrium with its inertial forces.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from itertools import combinations
from math import comb, inf, isinf, nan
from typing import NamedTuple, Protocol

import numpy as np

# Weights below this part of the load count as zero where a linear program (HiGHS: feasible to 1e-9) ends; the active
# equations are then solved again.
ZERO = 1e-7
# Ranges narrower than this part of the load are one value: HiGHS' tolerance is below it.
UNIQUE = 1e-8
# A load has the direction of forces to this part: HiGHS is feasible to it, and states have the error of an integrator.
WITHIN = 1e-9
# Vertices of a polytope: so many bases are tried all at once, in the time of a tenth of one linear program. Bases whose
# determinant is below SINGULAR of their columns' sizes have no vertex (three forces on one line: a rounding); weights
# above −FEASIBLE are positive, as HiGHS takes them.
MOST_BASES, SINGULAR, FEASIBLE = 500, 1e-9, 1e-9


class RowsOfContact(Protocol):
    """What the forces of a contact need: the rows of its lift and slip velocity, and of the rotation it resists."""

    @property
    def lift_row(self) -> np.ndarray: ...
    @property
    def slip_row(self) -> np.ndarray: ...
    @property
    def turning_row(self) -> np.ndarray: ...


class Slipping(NamedTuple):
    """In place of the coefficient of a contact that does not slip: the friction per normal force of one that does. Of
    rolling resistance: in place of the arm of a plate that does not turn, the couple per normal force of one that does.
    """

    ratio: float


# What limits the friction of a contact, or its couple: its coefficient (infinite: no bound) or arm, or the motion that
# determines it.
Limit = float | Slipping


class ForceRanges(NamedTuple):
    """Least and greatest normal and friction force of each contact (N), shape (contacts, 2) each; infinite where
    contacts may press against each other without bound."""

    normal: np.ndarray
    friction: np.ndarray


def _generators(
    now: Sequence[RowsOfContact], sticks: Sequence[Limit], couples: Sequence[Limit] = ()
) -> tuple[np.ndarray, np.ndarray]:
    """The edges of all cones as columns (fx, fy, moment), shape (3, edges), and (normal, friction) of each edge by
    contact, shape (contacts, 2, edges). Without a bound on friction the edges are n, t and −t."""
    edges = [_edges(stick, couple) for stick, couple in zip(sticks, couples or (0.0,) * len(sticks), strict=True)]
    columns: list[np.ndarray] = []
    parts = np.zeros((len(now), 2, sum(map(len, edges))))
    for k, one in enumerate(now):
        for normal, friction, couple in edges[k]:
            parts[k, :, len(columns)] = normal, friction
            column = normal * one.lift_row + friction * one.slip_row
            columns.append(column + couple * one.turning_row if couple else column)
    return np.array(columns).T, parts


def _edges(stick: Limit, couple: Limit) -> list[tuple[float, float, float]]:
    """Normal force, friction and couple of the edges of one cone."""
    couples = (couple.ratio,) if isinstance(couple, Slipping) else (couple, -couple) if couple else (0.0,)
    edges = _edges_of_forces(stick)
    with_normal = [(normal, friction, value) for normal, friction in edges for value in couples if normal]
    return with_normal + [(normal, friction, 0.0) for normal, friction in edges if not normal]


def _edges_of_forces(stick: Limit) -> list[tuple[float, float]]:
    """Normal and friction force of the edges of one cone of forces."""
    if isinstance(stick, Slipping):
        return [(1.0, stick.ratio)]
    if stick == 0.0:
        return [(1.0, 0.0)]
    return [(1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] if isinf(stick) else [(1.0, stick), (1.0, -stick)]


def margin(
    now: Sequence[RowsOfContact],
    load: np.ndarray,
    units: np.ndarray,
    sticks: Sequence[Limit],
    couples: Sequence[Limit] = (),
) -> float:
    """The largest least weight with which the contacts balance a load (fx, fy, moment), in units of the load; −inf if
    the load cannot be balanced with weights of any sign, at most 1.

    It is negative if no admissible forces hold the plate, and its zero is the limit. `units`: factors of the equations
    of equilibrium, which give them one unit; 0 leaves an equation out. `couples`: the limits of rolling resistance, if
    there is any.
    """
    columns, right = _generators(now, sticks, couples)[0] * units[:, None], -load * units
    size = float(np.abs(right).max())
    if size == 0.0:
        return 0.0
    right = right / size
    matrix = np.column_stack([columns, columns.sum(axis=1)])
    independent = _independent(matrix, right, WITHIN)
    if independent is None:
        return -inf
    (rank, count) = independent[0].shape
    if comb(count, rank) <= MOST_BASES:
        return _largest_least(*independent, _choices(count, rank))
    return _margin_by_program(*independent)


def _independent(matrix: np.ndarray, right: np.ndarray, within: float) -> tuple[np.ndarray, np.ndarray] | None:
    """The same equations with independent rows, as a linear program's presolve takes roundings of others for rows; None
    if they contradict each other by more than `within`."""
    basis, sizes, _ = np.linalg.svd(matrix)
    rank = int((sizes > SINGULAR * sizes[0]).sum())
    if np.abs(basis[:, rank:].T @ right).max(initial=0.0) > within:
        return None
    return basis[:, :rank].T @ matrix, basis[:, :rank].T @ right


def _largest_least(matrix: np.ndarray, right: np.ndarray, choices: np.ndarray) -> float:
    """The margin of equations with independent rows: the largest least weight of all vertices. The last column is the
    sum of the others, of the least weight: it is 1 where a choice of columns leaves it out, and the others' weights
    come in addition to it."""
    count, is_one = matrix.shape[1] - 1, (choices < matrix.shape[1] - 1).all(axis=1)
    squares, goals = matrix[:, choices].swapaxes(0, 1), right - is_one[:, None] * matrix[:, count]
    regular = _regular(squares)
    weights = np.zeros((int(regular.sum()), count + 1))
    weights[is_one[regular], count] = 1.0
    solutions = np.linalg.solve(squares[regular], goals[regular][..., None])[..., 0]
    np.put_along_axis(weights, choices[regular], solutions, axis=1)
    least = weights[:, count] + np.minimum(weights[:, :count].min(axis=1), 0.0)
    return min(float(least.max(initial=-inf)), 1.0)


def _regular(squares: np.ndarray) -> np.ndarray:
    """Which of some square matrices (n, k, k) are regular, (n,)."""
    volume = np.prod(np.linalg.norm(squares, axis=1), axis=1)
    return np.asarray(np.abs(np.linalg.det(squares)) > SINGULAR * volume)


def _margin_by_program(matrix: np.ndarray, right: np.ndarray) -> float:
    """The same by a linear program, for many columns."""
    from scipy.optimize import linprog  # slow to import, and most motions never come here

    count = matrix.shape[1] - 1
    answer = linprog(
        np.append(np.zeros(count), -1.0), A_eq=matrix, b_eq=right, bounds=[(0.0, None)] * count + [(None, 1.0)]
    )
    if answer.status != 0:
        return -inf
    if answer.x[-1] >= 1.0 - ZERO:
        return 1.0
    # The program's weights have an error of 1e-9: those of its vertex solve the equations to rounding.
    order = np.append(count, np.argsort(-answer.x[:-1]))
    active = order[:1]
    for k in order[1:]:
        if np.linalg.matrix_rank(matrix[:, [*active, k]], tol=SINGULAR) > len(active):
            active = np.append(active, k)
    exact, *_ = np.linalg.lstsq(matrix[:, active], right, rcond=None)
    is_vertex = np.abs(matrix[:, active] @ exact - right).max() < WITHIN and exact[1:].min(initial=0.0) > -ZERO
    return float(exact[0]) if is_vertex else float(answer.x[-1])


def ranges(
    now: Sequence[RowsOfContact],
    load: np.ndarray,
    units: np.ndarray,
    sticks: Sequence[Limit],
    couples: Sequence[Limit] = (),
) -> ForceRanges:
    """The ranges of the forces with which the contacts balance a load (N, N, N m); NaN if they cannot. `units` and
    `couples` as of `margin`."""
    columns, parts = _generators(now, sticks, couples)
    matrix, right = columns * units[:, None], -load * units
    size = float(np.abs(right).max()) or 1.0
    corners = _corners(matrix, right / size)
    if len(corners):
        forces = size * (parts @ corners.T)
        limits = np.stack([forces.min(axis=2), forces.max(axis=2)], axis=2)
    else:
        limits = _limits_by_programs(matrix, right / size, parts, size)
    return ForceRanges(limits[:, 0], limits[:, 1])


def _corners(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """The vertices (n, weights) of the weights that are not negative and solve the equations; none if the weights have
    no bound, or if there are too many bases."""
    count = matrix.shape[1]
    if comb(count, min(len(matrix) + 1, count // 2)) > MOST_BASES:
        return np.empty((0, count))
    # Weights without bound contain a direction: weights of sum one that balance nothing.
    nothing = np.append(np.zeros(len(matrix)), 1.0)
    if len(_vertices(np.vstack([matrix, np.ones(count)]), nothing)):
        return np.empty((0, count))
    return _vertices(matrix, right)


def _vertices(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """The solutions x ≥ 0 of matrix x = right with as many weights as the equations' rank, shape (n, weights)."""
    count, independent = matrix.shape[1], _independent(matrix, right, FEASIBLE)
    if independent is None:
        return np.empty((0, count))
    (rows, target), rank = independent, len(independent[1])
    choices = _choices(count, rank)
    squares = rows[:, choices].swapaxes(0, 1)
    regular = _regular(squares)
    weights = np.linalg.solve(squares[regular], np.broadcast_to(target[:, None], (int(regular.sum()), rank, 1)))[..., 0]
    admissible = weights.min(axis=1, initial=inf) >= -FEASIBLE
    result = np.zeros((int(admissible.sum()), count))
    np.put_along_axis(result, choices[regular][admissible], weights[admissible], axis=1)
    return result


@lru_cache(maxsize=64)
def _choices(count: int, size: int) -> np.ndarray:
    """All choices of so many columns, shape (choices, size)."""
    return np.array(list(combinations(range(count), size)), dtype=int).reshape(-1, size)


def _limits_by_programs(matrix: np.ndarray, right: np.ndarray, parts: np.ndarray, size: float) -> np.ndarray:
    """The limits (contacts, 2, 2) of normal and friction force by linear programs."""
    from scipy.optimize import linprog

    limits = np.full((len(parts), 2, 2), nan)
    for k in range(len(parts)):
        for which in range(2):
            for end, sign in enumerate((1.0, -1.0)):
                goal = sign * parts[k, which]
                answer = linprog(goal, A_eq=matrix, b_eq=right, bounds=(0.0, None))
                if answer.status == 0:
                    active = answer.x > ZERO
                    exact, *_ = np.linalg.lstsq(matrix[:, active], right, rcond=None)
                    close = np.abs(exact - answer.x[active]).max(initial=0.0) <= ZERO
                    limits[k, which, end] = size * (parts[k, which, active] @ (exact if close else answer.x[active]))
                elif answer.status == 3:
                    limits[k, which, end] = -sign * inf
    return limits


def values(ranges_of: np.ndarray, size: float) -> np.ndarray:
    """The forces of ranges (contacts, 2) that are one value, NaN where they are not unique."""
    narrow = ranges_of[:, 1] - ranges_of[:, 0] <= UNIQUE * size
    with np.errstate(invalid="ignore"):  # limits of either sign may be infinite
        return np.where(narrow, 0.5 * (ranges_of[:, 0] + ranges_of[:, 1]), nan)
