"""Which modes follow: for each group of plates that touch, every combination of modes is tried.

Numbers exclude most combinations; those that are left must hold just after the instant along their own motion
(`minimal.decision`, by series where values vanish). Several combinations that give the same accelerations are one
motion; different ones are reported, none is chosen.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from typing import NamedTuple, cast

import numpy as np

from cases import Case, Mode

from ..minimal.decision import ORDER, Undecidable, _by_series, _leading_signs, follows
from ..minimal.effects import SLIP_SIGN
from ..several import forces
from ..several.contact_law import slip_modes
from .plate_places import PlateContactPlace, flush, numbers_of, places, plates_in, regions_of
from .plates_phase import PlatesRegime, plates_phase

# Velocities below this part of the motion's largest speed are the roundings of a constraint that has just begun.
STILL = 1e-11
# Accelerations that differ by less than this part of the largest are the same motion: series decide with 1e-12.
SAME = 1e-7
# Numbers exclude a combination of modes that violates a condition by this part of the largest force or acceleration.
VIOLATED = 1e-6
# A load is balanced if the least weight is no more negative than its rounding.
BALANCED = -1e-11
# Rows are dependent if one is the sum of others to this part.
DEPENDENT = 1e-9


class GroupDecision(NamedTuple):
    """The modes of a group's contacts that follow, whether its plates rest, and the contacts whose force vanishes; None
    if there are none or several.

    `motions`: how many different motions are consistent; `is_singular`: whether modes were left out because their
    forces are not unique.
    """

    modes: tuple[Mode, ...] | None
    rests: bool
    idle: frozenset[int]
    motions: tuple[tuple[Mode, ...], ...]
    is_singular: bool


def decide(
    case: Case, t: float, state: tuple[float, ...], group: Sequence[int], speed: float, error: float,
    fixed: Mapping[int, tuple[Mode, ...]],
) -> GroupDecision:  # fmt: skip
    """The modes of one group's contacts that follow. `speed` (m/s): the largest of the motion so far; `error`: the
    relative error of the state; `fixed` limits the modes of some contacts. Raises Undecidable."""
    now = places(case, group, state)
    motions: list[tuple[tuple[Mode, ...], bool, np.ndarray]] = []
    plates, is_singular = plates_in(case, group), False
    own = np.repeat([b in plates for b in range(len(state) // 6)], 3)
    if _rests(case, state, now, plates):
        still = tuple(Mode.ROLL if at.stick > 0.0 else Mode.SLIDE for at in now)
        motions.append((still, True, np.zeros(len(state) // 2)))
    pairs = [(group.index(one), group.index(other)) for one, other in flush(case, group).items()]
    for modes in product(*_options(state, group, now, speed, fixed)):
        if any(modes[i] is not modes[j] and Mode.FLIGHT not in (modes[i], modes[j]) for i, j in pairs):
            continue
        answer = _by_numbers(case, now, modes, {i: j for i, j in pairs if modes[i] is Mode.ROLL is modes[j]})
        if answer is None:
            is_singular = True
            continue
        if not answer.is_possible:
            continue
        phase = plates_phase(case, PlatesRegime(tuple(group), modes, regions=regions_of(case, group, now)))
        near = any(mode is Mode.FLIGHT for mode in modes)
        holds = _by_series(phase, t, state, error) if near else follows(case, phase, t, state, error)
        if holds:
            motions.append((modes, False, np.where(own, answer.acceleration, 0.0)))
    if any(at.stick > at.mu for at in now):
        # With static friction a contact that may stick does.
        most = max((_sticking(modes) for modes, _, _ in motions), default=0)
        motions = [motion for motion in motions if _sticking(motion[0]) == most]
    clusters = _clusters(case, motions)
    if len(clusters) != 1:
        return GroupDecision(None, False, frozenset(), tuple(some[0][0] for some in clusters), is_singular)
    modes, rests, _ = max(
        clusters[0], key=lambda one: (one[1], len(one[0]) - one[0].count(Mode.FLIGHT), _sticking(one[0]))
    )
    idle = frozenset[int]() if rests else _idle(case, t, state, group, modes, error)
    return GroupDecision(modes, rests, idle, (modes,), is_singular)


def _idle(
    case: Case, t: float, state: tuple[float, ...], group: Sequence[int], modes: tuple[Mode, ...], error: float
) -> frozenset[int]:
    """The closed contacts whose normal force vanishes along the motion, as far as its series shows."""
    own = regions_of(case, group, places(case, group, state))
    signs = _leading_signs(plates_phase(case, PlatesRegime(tuple(group), modes, regions=own)), t, state, error, ORDER)
    return frozenset(
        number
        for k, number in enumerate(group)
        if modes[k] is not Mode.FLIGHT
        and not any(signs.get(f"{name}:{k}", 0) for name in ("normal", "cone_forward", "cone_backward"))
    )


def _sticking(modes: Sequence[Mode]) -> int:
    return sum(mode is Mode.ROLL for mode in modes)


def _options(
    state: tuple[float, ...], group: Sequence[int], now: Sequence[PlateContactPlace], speed: float,
    fixed: Mapping[int, tuple[Mode, ...]],
) -> list[tuple[Mode, ...]]:  # fmt: skip
    """The modes that each contact may have."""
    velocity, options = np.array(state[len(state) // 2 :]), list[tuple[Mode, ...]]()
    for number, at in zip(group, now, strict=True):
        slip, slipping = float(at.slip_row @ velocity), slip_modes(cast(Case, at.contact))
        rolling: tuple[Mode, ...] = (Mode.ROLL,) if at.stick > 0.0 else ()
        if number in fixed:
            options.append(fixed[number])
        elif abs(slip) <= STILL * speed or len(slipping) < 2:
            options.append((*rolling, *slipping, Mode.FLIGHT))
        else:
            options.append((slipping[0] if slip > 0.0 else slipping[1], Mode.FLIGHT))
    return options


class _Answer(NamedTuple):
    """Accelerations (3n,) in some modes, and whether numbers exclude them."""

    acceleration: np.ndarray
    is_possible: bool


def _by_numbers(
    case: Case, now: Sequence[PlateContactPlace], modes: Sequence[Mode], shares: Mapping[int, int]
) -> _Answer | None:
    """The accelerations in these modes; None if the forces are not unique. `shares`: corners that stick, with the one
    that has the friction force of both."""
    numbers = numbers_of(case)
    rows, columns, biases = list[np.ndarray](), list[np.ndarray](), list[float]()
    for i, (at, mode) in enumerate(zip(now, modes, strict=True)):
        if mode is Mode.FLIGHT:
            continue
        ratio = -SLIP_SIGN.get(mode, 0.0)
        column = at.lift_row + (ratio * at.mu * at.slip_row if ratio else 0.0)
        rows, columns, biases = [*rows, at.lift_row], [*columns, column], [*biases, at.lift_bias]
        if mode is Mode.ROLL and i not in shares:
            rows, columns, biases = [*rows, at.slip_row], [*columns, at.slip_row], [*biases, at.slip_bias]
    acceleration, values = numbers.load, np.zeros(0)
    if rows:
        matrix = np.array(rows) * numbers.inverse @ np.array(columns).T
        sizes = np.sqrt(np.abs(matrix.diagonal()))
        if np.linalg.matrix_rank(matrix / np.outer(sizes, sizes), tol=DEPENDENT) < len(rows):
            return None
        values = np.linalg.solve(matrix, -(np.array(rows) @ numbers.load + biases))
        acceleration = numbers.load + numbers.inverse * (np.array(columns).T @ values)
    weight = float((np.abs(numbers.load) / np.where(numbers.inverse, numbers.inverse, np.inf)).max())
    force = VIOLATED * max(weight, float(np.abs(values).max(initial=0.0)))
    rate = VIOLATED * max(float(np.abs(numbers.load).max()), float(np.abs(acceleration * numbers.lengths).max()))
    forces_left, possible = iter(values.tolist()), True
    frictions, bounds = dict[int, float](), dict[int, float]()
    for i, (at, mode) in enumerate(zip(now, modes, strict=True)):
        if mode is Mode.FLIGHT:
            possible &= float(at.lift_row @ acceleration) + at.lift_bias >= -rate
            continue
        normal = next(forces_left)
        possible &= normal >= -force
        if mode is Mode.ROLL:
            holder = shares.get(i, i)
            bounds[holder] = bounds.get(holder, 0.0) + at.stick * max(normal, 0.0) + force * (1.0 + min(at.stick, 1e3))
            if holder == i:
                frictions[i] = next(forces_left)
    possible &= all(not abs(friction) > bounds[i] for i, friction in frictions.items())
    return _Answer(acceleration, bool(possible))


def _rests(case: Case, state: tuple[float, ...], now: Sequence[PlateContactPlace], plates: frozenset[int]) -> bool:
    """Whether these plates are still, and forces of their contacts balance the load."""
    half = len(state) // 2
    if any(state[half + 3 * b + c] for b in plates for c in range(3)):
        return False
    load, units = load_and_units(case, plates)
    if not np.isfinite(load).all():
        raise Undecidable
    return forces.margin(now, load, units, [at.stick for at in now]) >= BALANCED


def load_and_units(case: Case, plates: frozenset[int]) -> tuple[np.ndarray, np.ndarray]:
    """The load (3n,) on some plates (N, N, N m), and the units of the equations of their equilibrium: 0 for those of
    other plates, and for the moment of a plate that cannot turn."""
    numbers = numbers_of(case)
    own = np.repeat([b in plates for b in range(len(numbers.radii))], 3) & (numbers.inverse > 0.0)
    mass = np.divide(1.0, numbers.inverse, out=np.zeros(len(own)), where=own)
    return numbers.load * mass, own / numbers.lengths


def _clusters(case: Case, motions) -> list[list]:
    """Modes with the same accelerations together."""
    numbers, clusters = numbers_of(case), list[list]()
    for motion in motions:
        for some in clusters:
            largest = max(float(np.abs(one * numbers.lengths).max()) for one in (numbers.load, motion[2], some[0][2]))
            if np.abs((motion[2] - some[0][2]) * numbers.lengths).max() <= SAME * largest:
                some.append(motion)
                break
        else:
            clusters.append([motion])
    return clusters
