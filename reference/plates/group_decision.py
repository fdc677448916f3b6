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
from ..several.contact_law import slip_modes
from ..several.decision import BALANCED
from .held_plates import held_sets, inner_contacts, margin, pressing_forces
from .plate_places import PlateContactPlace, flush, numbers_of, places, plates_in, regions_of
from .plates_phase import PlatesPhase, PlatesRegime, moving_contacts, plates_phase, regime_of

# Velocities below this part of the motion's largest speed are the roundings of a constraint that has just begun.
STILL = 1e-11
# Accelerations that differ by less than this part of the largest are the same motion: series decide with 1e-12.
SAME = 1e-7
# Numbers exclude a combination of modes that violates a condition by this part of the largest force or acceleration.
VIOLATED = 1e-6
# Rows are dependent if one is the sum of others to this part.
DEPENDENT = 1e-9


class GroupDecision(NamedTuple):
    """The modes of a group's contacts that follow, the plates that rest, and the contacts whose force vanishes; None if
    there are none or several.

    `motions`: how many different motions are consistent; `is_singular`: whether modes were left out because their
    forces are not unique.
    """

    modes: tuple[Mode, ...] | None
    resting: frozenset[int]
    idle: frozenset[int]
    motions: tuple[tuple[Mode, ...], ...]
    is_singular: bool


class _Consistent(NamedTuple):
    """Modes that hold just after an instant, the plates that rest in them, and the accelerations (3n,)."""

    modes: tuple[Mode, ...]
    resting: frozenset[int]
    acceleration: np.ndarray


def decide(
    case: Case, t: float, state: tuple[float, ...], group: Sequence[int], speed: float, error: float,
    fixed: Mapping[int, tuple[Mode, ...]], loose: frozenset[int] = frozenset(),
    opening: frozenset[int] = frozenset(),
) -> GroupDecision:  # fmt: skip
    """The modes of one group's contacts that follow. `speed` (m/s): the largest of the motion so far; `error`: the
    relative error of the state; `fixed` limits the modes of some contacts; `loose`: plates that their contacts no
    longer hold all at once; `opening`: contacts that are known to open, whatever the error of the instant. Raises
    Undecidable."""
    now = places(case, group, state)
    motions: list[_Consistent] = []
    plates = plates_in(case, group)
    if _rests(case, state, group, plates):
        still = tuple(_still_mode(at) for at in now)
        motions.append(_Consistent(still, plates, np.zeros(len(state) // 2)))
    moving, is_singular = _consistent_modes(case, t, state, group, now, speed, error, fixed, frozenset(), opening)
    motions += moving
    if is_singular:  # forces of contacts that do not move may be the reason
        for anchors in held_sets(case, state, group):
            if not loose or not loose <= anchors:
                motions += _consistent_modes(case, t, state, group, now, speed, error, fixed, anchors, opening)[0]
    if any(at.stick > at.mu for at in now):
        # With static friction a contact that may stick does.
        most = max((_sticking(one.modes) for one in motions), default=0)
        motions = [one for one in motions if _sticking(one.modes) == most]
    clusters = _clusters(case, motions)
    if len(clusters) != 1:
        none = frozenset[int]()
        return GroupDecision(None, none, none, tuple(some[0].modes for some in clusters), is_singular)
    # Of equations of one motion: those of a rest, or else those in which most forces are unique.
    modes, resting, _ = max(
        clusters[0],
        key=lambda one: (
            one.resting == plates, -len(one.resting), len(group) - one.modes.count(Mode.FLIGHT), _sticking(one.modes)
        ),
    )  # fmt: skip
    idle = frozenset[int]() if resting == plates else _idle(case, t, state, group, modes, error, resting)
    return GroupDecision(modes, resting, idle, (modes,), is_singular)


def _consistent_modes(
    case: Case, t: float, state: tuple[float, ...], group: Sequence[int], now: Sequence[PlateContactPlace],
    speed: float, error: float, fixed: Mapping[int, tuple[Mode, ...]], anchors: frozenset[int], opening: frozenset[int],
) -> tuple[list[_Consistent], bool]:  # fmt: skip
    """The modes that follow while some plates are held at rest, and whether some were left out because their forces are
    not unique."""
    results, is_singular = list[_Consistent](), False
    own = np.repeat([b in plates_in(case, group) - anchors for b in range(len(state) // 6)], 3)
    inner = inner_contacts(case, group, anchors)
    pairs = [(group.index(one), group.index(other)) for one, other in flush(case, group).items() if one not in inner]
    options = _options(state, group, now, speed, fixed)
    for i, number in enumerate(group):
        options[i] = (_still_mode(now[i]),) if number in inner else options[i]
    for modes in product(*options):
        if any(modes[i] is not modes[j] and Mode.FLIGHT not in (modes[i], modes[j]) for i, j in pairs):
            continue
        rows = [Mode.FLIGHT if number in inner else mode for number, mode in zip(group, modes, strict=True)]
        answer = _by_numbers(case, now, rows, {i: j for i, j in pairs if modes[i] is Mode.ROLL is modes[j]}, own)
        if answer is None:
            is_singular = True
            continue
        if not answer.is_possible:
            continue
        phase = plates_phase(case, PlatesRegime(tuple(group), modes, anchors, regions=regions_of(case, group, now)))
        near = any(mode is Mode.FLIGHT for mode in modes)
        order = enumerate(moving_contacts(case, regime_of(phase)))
        positive = frozenset(f"gap:{k}" for k, (number, _) in order if number in opening)
        holds = _by_series(phase, t, state, error, positive) if near else follows(case, phase, t, state, error)
        if holds and (not anchors or _is_held(phase, t, state, inner, anchors)):
            results.append(_Consistent(modes, anchors, np.where(own, answer.acceleration, 0.0)))
    return results, is_singular


def _still_mode(at: PlateContactPlace) -> Mode:
    """The mode of a contact of plates at rest."""
    return Mode.ROLL if at.stick > 0.0 else Mode.SLIDE


def _is_held(
    phase: PlatesPhase, t: float, state: tuple[float, ...], inner: Sequence[int], anchors: frozenset[int]
) -> bool:
    """Whether inner contacts hold plates on which others press."""
    return margin(phase.case, state, inner, anchors, pressing_forces(phase, t, state, anchors)) >= BALANCED


def _idle(
    case: Case, t: float, state: tuple[float, ...], group: Sequence[int], modes: tuple[Mode, ...], error: float,
    resting: frozenset[int],
) -> frozenset[int]:  # fmt: skip
    """The closed contacts whose normal force vanishes along the motion, as far as its series shows."""
    own = regions_of(case, group, places(case, group, state))
    phase = plates_phase(case, PlatesRegime(tuple(group), modes, resting, regions=own))
    signs = _leading_signs(phase, t, state, error, ORDER)
    return frozenset(
        number
        for k, (number, mode) in enumerate(moving_contacts(case, regime_of(phase)))
        if mode is not Mode.FLIGHT
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
    case: Case, now: Sequence[PlateContactPlace], modes: Sequence[Mode], shares: Mapping[int, int], moves: np.ndarray
) -> _Answer | None:
    """The accelerations in these modes; None if the forces are not unique. `shares`: corners that stick, with the one
    that has the friction force of both; `moves` (3n,): which velocities of all may change."""
    every = numbers_of(case)
    numbers = every._replace(inverse=np.where(moves, every.inverse, 0.0), load=np.where(moves, every.load, 0.0))
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


def _rests(case: Case, state: tuple[float, ...], group: Sequence[int], plates: frozenset[int]) -> bool:
    """Whether these plates are still, and forces of their contacts balance the load."""
    half = len(state) // 2
    if any(state[half + 3 * b + c] for b in plates for c in range(3)):
        return False
    if not np.isfinite(numbers_of(case).load).all():
        raise Undecidable
    return margin(case, state, group, plates) >= BALANCED


def _clusters(case: Case, motions: Sequence[_Consistent]) -> list[list[_Consistent]]:
    """Modes with the same accelerations together."""
    numbers, clusters = numbers_of(case), list[list[_Consistent]]()
    for motion in motions:
        for some in clusters:
            largest = max(
                float(np.abs(one * numbers.lengths).max())
                for one in (numbers.load, motion.acceleration, some[0].acceleration)
            )
            if np.abs((motion.acceleration - some[0].acceleration) * numbers.lengths).max() <= SAME * largest:
                some.append(motion)
                break
        else:
            clusters.append([motion])
    return clusters
