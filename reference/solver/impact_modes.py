"""One combination of modes of an impact: its impulses, and whether they and the velocities after it obey the law."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from math import inf
from typing import NamedTuple, Protocol

import numpy as np

from .plate_numbers import Sides, Turns, rigid_pairs, turning_row

# Velocities and impulses below this part of the largest are roundings of a solution by least squares.
ROUNDING = 1e-10
# A linear program's tolerance, and its status if nothing obeys its inequalities (manual of scipy.optimize.linprog).
WITHIN, INFEASIBLE = 1e-7, 2
# Impulses that change nothing at closed contacts turn the plate if they change its velocity by more than this part.
TURNS = 1e-9
STICK, FORWARD, BACKWARD, OPEN = "stick", "forward", "backward", "open"
SIGN = {FORWARD: 1.0, BACKWARD: -1.0}
# In place of a contact's number, less the number of a pair of plates: the couple that ends their rotation.
COUPLE = -1


# Of contacts with no more than their least impulse: their numbers, and the sense of their slip after it (0: none).
LeastSenses = tuple[tuple[int, float], ...]


class ImpactVelocities(NamedTuple):
    """Velocities (vx, vy, ω) of each body after an impact, and lift and slip velocity of every touched contact, zeros
    exact; `still`: plates whose rotation against each other rolling resistance has ended."""

    velocity: np.ndarray
    lift: np.ndarray
    slip: np.ndarray
    still: tuple[Sides, ...] = ()


class TouchedContact(Protocol):
    """What the law of impact needs of a contact: the plates that touch, the rows of its lift and slip velocity and
    of the rotation that it resists, and its restitution."""

    @property
    def sides(self) -> Sides: ...
    @property
    def turning_row(self) -> np.ndarray: ...
    @property
    def lift_row(self) -> np.ndarray: ...
    @property
    def slip_row(self) -> np.ndarray: ...
    @property
    def restitution(self) -> float: ...


class ImpactLaw(NamedTuple):
    """Restitution, least normal impulse and coefficient of friction of each contact, the speed of its support's
    surface (m/s), and the arm of its rolling resistance (m; 0: none). `turns`: the senses of the rotations after the
    impact that contacts resist. `gyration`: a length that makes rotations velocities, m."""

    restitution: np.ndarray
    least: np.ndarray
    mu: list[float]
    belts: np.ndarray
    arms: np.ndarray
    turns: Turns = ()
    gyration: float = 1.0

    def couple(self, at: TouchedContact, k: int) -> np.ndarray | float:
        """The couple (3n,) per normal impulse of contact k against the rotation; 0 if there is none."""
        sense = dict(self.turns).get(at.sides) if self.turns else 0
        return -sense * self.arms[k] * at.turning_row if sense else 0.0


def senses_of_least(modes: Sequence[str], law: ImpactLaw) -> Iterator[LeastSenses]:
    """The senses that the friction of least impulses may have: each has one of its own, against the slip after the
    impact."""
    rubbing = [k for k, mode in enumerate(modes) if mode == OPEN and law.least[k] > 0.0 and law.mu[k] > 0.0]
    for values in product(*((0.0,) if law.mu[k] == inf else (1.0, -1.0, 0.0) for k in rubbing)):
        yield tuple(zip(rubbing, values, strict=True))


def in_modes(
    modes, before, places_hit, law: ImpactLaw, least: LeastSenses, compliance, speed
) -> list[tuple[ImpactVelocities, np.ndarray]]:
    """The outcomes in these modes that are consistent: the extreme ones where impulses may differ that change no
    velocity of a closed contact, but the plate's."""
    senses = dict(least)
    rows, columns, goals, which, change = _impulses(modes, before, places_hit, law, senses)
    solution = _solve(rows, columns, goals, change, compliance, speed)
    if solution is None:
        return []
    turning = compliance[:, None] * (np.array(columns).T @ solution[2]) if rows else np.zeros((len(before), 0))
    members = [solution]
    if not senses and turning.size and np.abs(turning).max() > TURNS * np.abs(compliance).max():
        members = _extremes(modes, before, places_hit, law, speed, solution, which, turning)
    outcomes = [_check(modes, before, places_hit, law, speed, one, which, senses) for one in members]
    return [one for one in outcomes if one is not None]


def _impulses(modes, before, places_hit, law: ImpactLaw, senses: dict[int, float]) -> tuple:
    """The rows whose velocities impulses determine, the columns of these impulses, the changes of velocity that they
    have to make, (contact, is normal) of each, and the least impulses of contacts that open. `senses`: of the slips of
    those with friction, 0: they stick."""
    rows, columns, goals, which, change = [], [], [], [], np.zeros(len(before))
    for k, (at, mode) in enumerate(zip(places_hit, modes, strict=True)):
        sense = senses.get(k, 0.0) if mode == OPEN else SIGN.get(mode, 0.0)
        column = at.lift_row - (sense * law.mu[k] if sense else 0.0) * at.slip_row + law.couple(at, k)
        if mode == OPEN:
            change = change + law.least[k] * column
        else:
            rows.append(at.lift_row)
            goals.append(-(1.0 + law.restitution[k]) * float(at.lift_row @ before))
            columns.append(column)
            which.append((k, True))
        if mode == STICK or senses.get(k) == 0.0:
            rows.append(at.slip_row)
            goals.append(-float(at.slip_row @ before - law.belts[k]))
            columns.append(at.slip_row)
            which.append((k, False))
    for number, (sides, sense) in enumerate(law.turns):
        if sense == 0:  # rolling resistance ends the rotation
            row = law.gyration * turning_row(sides, len(before))
            rows.append(row)
            columns.append(row)
            goals.append(-float(row @ before))
            which.append((COUPLE - number, False))
    return rows, columns, goals, which, change


def _impulse_bounds(
    law: ImpactLaw, places_hit: Sequence[TouchedContact], which: list
) -> list[tuple[np.ndarray, float]]:
    """Rows of the impulses in `which` that must not be below a bound, and that bound: normal impulses, friction within
    its cone, and couples, which end rotations and are at most the sum of the normal impulses of the contacts that
    resist them times their arms."""
    result, closed = list[tuple[np.ndarray, float]](), {k for k, is_normal in which if is_normal}
    for (k, is_normal), row in zip(which, np.eye(len(which)), strict=True):
        if is_normal:
            result.append((row, float(law.least[k])))
            continue
        if k <= COUPLE:
            sides, _ = law.turns[COUPLE - k]
            arms = {j: law.arms[j] for j, at in enumerate(places_hit) if at.sides == sides}
            row = law.gyration * row
        elif law.mu[k] == inf:
            continue
        else:
            arms = {k: law.mu[k]}
        limit = np.array([arms.get(j, 0.0) if of_normal else 0.0 for j, of_normal in which])
        bound = -sum(arm * float(law.least[j]) for j, arm in arms.items() if j not in closed)
        result += [(limit + row, bound), (limit - row, bound)]
    return result


def _extremes(modes, before, places_hit, law: ImpactLaw, speed, solution, which, turning) -> list:
    """The extreme solutions along each change of the plate's velocity by impulses that the closed contacts do not
    notice: two corners of one side and a wall, for example, let the plate turn about the wall's corner."""
    from scipy.optimize import linprog

    change, impulses, free = solution
    after, small, rows, bounds = before + change, ROUNDING * speed, list[np.ndarray](), list[float]()
    for row, bound in _impulse_bounds(law, places_hit, which):
        rows.append(row @ free)
        bounds.append(bound - float(row @ impulses))
    for k, (at, mode) in enumerate(zip(places_hit, modes, strict=True)):
        if mode == OPEN:
            rows.append(at.lift_row @ turning)
            bounds.append(-float(at.lift_row @ after) - law.restitution[k] * float(at.lift_row @ before))
        elif mode in SIGN and law.mu[k]:
            rows.append(SIGN[mode] * (at.slip_row @ turning))
            bounds.append(-SIGN[mode] * float(at.slip_row @ after - law.belts[k]))
    for sides, sense in law.turns:
        if sense:
            rotation = sense * turning_row(sides, len(before))
            rows.append(rotation @ turning)
            bounds.append(-float(rotation @ after))
    members = []
    for goal in (*turning, *-turning):
        answer = linprog(goal, A_ub=-np.array(rows), b_ub=small - np.array(bounds), bounds=(None, None))
        if answer.status == INFEASIBLE:
            return []
        if answer.status == 0:
            members.append((change + turning @ answer.x, impulses + free @ answer.x, np.zeros((0, 0))))
    return members


def _solve(rows, columns, goals, change, compliance, speed) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """Change of the velocities, impulses, and a basis of the impulses that change nothing; None if there is none."""
    if not rows:
        return compliance * change, np.zeros(0), np.zeros((0, 0))
    matrix = np.array(rows) @ (compliance[:, None] * np.array(columns).T)
    right = np.array(goals) - np.array(rows) @ (compliance * change)
    impulses, *_ = np.linalg.lstsq(matrix, right, rcond=1e-11)
    if np.abs(matrix @ impulses - right).max() > ROUNDING * speed:
        return None
    _, sizes, basis = np.linalg.svd(matrix)
    rank = int((sizes > 1e-10 * sizes[0]).sum())
    return compliance * (change + np.array(columns).T @ impulses), impulses, basis[rank:].T


def _check(
    modes, before, places_hit, law: ImpactLaw, speed, solution, which, senses: dict[int, float]
) -> tuple[ImpactVelocities, np.ndarray] | None:
    """The outcome of a solution if its impulses and velocities agree with the law."""
    change, impulses, free = solution
    after = before + change
    lift, slip = (
        np.array([row @ after for row in rows])
        for rows in zip(*((a.lift_row, a.slip_row) for a in places_hit), strict=True)
    )
    slip = slip - law.belts
    small = ROUNDING * speed
    normal = law.least.copy()
    for impulse, (k, is_normal) in zip(impulses, which, strict=True):
        if is_normal:
            normal[k] = impulse
    for k, mode in enumerate(modes):
        rebound = lift[k] + law.restitution[k] * (places_hit[k].lift_row @ before)
        if mode == OPEN:
            if rebound < -small:
                return None
            sense = senses.get(k)
            if sense and sense * slip[k] < -small:
                return None
            slip[k] = 0.0 if sense == 0.0 else slip[k]
        elif mode == STICK:
            slip[k] = 0.0
        elif law.mu[k] and SIGN[mode] * slip[k] < -small:
            return None
        if mode != OPEN and law.restitution[k] * (places_hit[k].lift_row @ before) == 0.0:
            lift[k] = 0.0
    lift[np.abs(lift) <= small] = 0.0
    rotations = [(sense, law.gyration * float(turning_row(sides, len(after)) @ after)) for sides, sense in law.turns]
    if any(sense * rotation < -small for sense, rotation in rotations):
        return None
    bounds = _impulse_bounds(law, places_hit, which)
    if not _is_admissible(bounds, impulses, free, small):  # last, as it may be a linear program
        return None
    still = rigid_pairs(law.turns)
    for sides in still:
        if len(sides) == 1:
            after[3 * sides[0] + 2] = 0.0
    return ImpactVelocities(after, lift, slip, tuple(still)), normal


def _is_admissible(bounds: list[tuple[np.ndarray, float]], impulses, free, small: float) -> bool:
    """Whether impulses, or some that differ by what changes nothing, are not below the bounds of rows."""
    if not bounds:
        return True
    matrix = np.array([row for row, _ in bounds])
    room = matrix @ impulses - [bound for _, bound in bounds] + small
    if not free.size:
        return bool((room >= 0.0).all())
    # The solver's tolerance is 1e-7 in the units that it gets: those of the impulses.
    scale, gains = float(np.abs(room).max()), matrix @ free
    gains = np.where(np.abs(gains) > ROUNDING * np.abs(matrix).max(), gains, 0.0)  # the basis has length 1
    if free.shape[1] == 1:  # gains x >= -room: an interval
        gains, room = gains[:, 0], room / scale + WITHIN
        up, down = gains > 0.0, gains < 0.0
        least = (-room[up] / gains[up]).max(initial=-inf)
        return bool((room[~up & ~down] >= 0.0).all() and least <= (-room[down] / gains[down]).min(initial=inf))
    from scipy.optimize import linprog

    answer = linprog(np.zeros(free.shape[1]), A_ub=-gains, b_ub=room / scale, bounds=(None, None))
    return bool(answer.status == 0)
