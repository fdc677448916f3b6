"""Samples of a motion with one contact, from the coefficients of its phases: without its dense output, which would take
as long as the motion.

Phases of the same equations are evaluated together; pose and velocities come from the contact's parameters, slip and
spin by (5), (6) and (11).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cases import Case
from cases.trajectory import CONTACT

from ..minimal.bouncing import StraightStates
from ..minimal.integrators.segment import Segment
from ..minimal.integrators.taylor import steps_taken
from ..minimal.modes import FLIGHT
from .samples import NODES, law_at, point_and_tangent

# Steps that are sampled: all of a motion of so few; of more, the last of each phase, the first after a flight, which an
# impact may begin, and a part of the others. A step of the Taylor method takes 2 µs and its samples 1 µs, a phase takes
# 40 µs.
FEW, EVERY = 10, 16
# The rows of `PhaseSamples.motion`.
PLACE, TURN, VELOCITY, SPIN = range(4)
# The rows of `PhaseSamples.contact`.
SLIP, NORMAL, FRICTION = range(3)


class PhaseSamples(NamedTuple):
    """n steps at five instants each: starts, lengths (s) and times (n, 5); segments; the plate's `motion` (4, n, 5) as
    in `PlateSamples`, complex; slip, normal and friction force (3, n, 5), 0 in flight; the contact's point and tangent
    (n, 5), complex; which steps have a contact (n,), and which but the first begin where the one before ends (n - 1,);
    the least and the greatest parameter of the track."""

    start: np.ndarray
    length: np.ndarray
    times: np.ndarray
    segments: list[Segment]
    motion: np.ndarray
    contact: np.ndarray
    base: np.ndarray
    tangent: np.ndarray
    is_closed: np.ndarray
    is_next: np.ndarray
    near: tuple[float, ...]


class _ChosenStep(NamedTuple):
    """A step: its segment, start and end (s), and the coefficients (variables, powers) of its Taylor polynomial."""

    segment: Segment
    start: float
    end: float
    coefficients: np.ndarray | None


def of_phases(case: Case, segments: Sequence[Segment], few: int = FEW) -> PhaseSamples | None:
    """The samples of a motion of one contact of smooth curves; None without steps."""
    steps = _steps(segments, few)
    if not steps:
        return None
    count = len(steps)
    start, end = np.array([step.start for step in steps]), np.array([step.end for step in steps])
    length = end - start
    times = start[:, None] + length[:, None] * NODES
    motion, contact = np.empty((4, count, 5), dtype=complex), np.zeros((3, count, 5))
    parameters, is_closed = np.empty((2, count, 5)), np.zeros(count, dtype=bool)
    spin = np.empty((count, 5))
    groups: dict[tuple[int, int], list[int]] = {}
    for i, step in enumerate(steps):
        powers = 0 if step.coefficients is None else step.coefficients.shape[1]
        groups.setdefault((id(step.segment.phase.system), powers), []).append(i)
    for where in groups.values():
        here = slice(None) if len(where) == count else where
        some = steps if len(where) == count else [steps[i] for i in where]
        y = _states(some, length[here], times[here])
        if some[0].segment.phase.regime == FLIGHT:
            motion[PLACE, here], motion[VELOCITY, here] = y[0] + 1j * y[1], y[3] + 1j * y[4]
            motion[TURN, here], spin[here] = np.exp(1j * y[2]), y[5]
            continue
        phase = some[0].segment.phase
        every = [step.segment.phase.parameters for step in some]
        shared = every[0] if all(one is every[0] for one in every) else np.array(every).T.repeat(len(NODES), axis=1)
        rows = phase.system.outputs_of_arrays(times[here].ravel(), y.reshape(len(y), -1), shared)
        outputs = phase.system.record(*(np.broadcast_to(row, times[here].size).reshape(-1, len(NODES)) for row in rows))
        parameters[:, here], is_closed[here], spin[here] = y[:2], True, outputs.omega
        contact[SLIP, here], contact[NORMAL, here], contact[FRICTION, here] = (
            outputs.slip, outputs.normal, outputs.friction,
        )  # fmt: skip
    contact[NORMAL:] *= case.plate.mass
    motion[SPIN] = spin
    base = tangent = motion[PLACE]
    near: tuple[float, ...] = ()
    if is_closed.any():
        near = float(parameters[0, is_closed].min()), float(parameters[0, is_closed].max())
        base, tangent = _place_in_contact(case, times, motion, contact[SLIP], parameters, is_closed, spin)
    is_next = start[1:] == end[:-1]
    return PhaseSamples(
        start, length, times, [step.segment for step in steps], motion, contact, base, tangent, is_closed, is_next, near
    )


def _place_in_contact(
    case: Case, times: np.ndarray, motion: np.ndarray, slip: np.ndarray, parameters: np.ndarray, is_closed: np.ndarray,
    spin: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Write the plate's pose and velocity in the steps with contact; returns point and tangent of the track."""
    here = slice(None) if is_closed.all() else is_closed
    base, tangent = point_and_tangent(case.track, parameters[0, here])
    own, along = point_and_tangent(case.plate.outline, parameters[1, here])
    turn = tangent * along.conj()
    arm = turn * own
    belt = law_at(case, CONTACT).belt
    carried = slip[here]
    if belt is not None:
        carried = carried + belt.at_arrays(times[here].ravel()).reshape(carried.shape)
    motion[PLACE, here], motion[TURN, here] = base - arm, turn
    motion[VELOCITY, here] = carried * tangent - 1j * spin[here] * arm
    if isinstance(here, slice):
        return base, tangent
    points, tangents = motion[PLACE].copy(), motion[TURN].copy()
    points[here], tangents[here] = base, tangent
    return points, tangents


def _steps(segments: Sequence[Segment], few: int) -> list[_ChosenStep]:
    """The steps that are sampled, in order of time."""
    total = sum([segment.steps for segment in segments])
    every = max(1, total // (few + total // EVERY))
    chosen, flew = list[_ChosenStep](), False
    for segment in segments:
        if isinstance(segment.record, tuple) and isinstance(segment.record[1], StraightStates):
            continue
        times, coefficients = steps_taken(segment)
        last = len(times) - 2
        first = [0] if flew and last % every else []
        flew = segment.phase.regime == FLIGHT
        for i in (*first, *range(last % every, last + 1, every)):
            if times[i + 1] > times[i]:
                chosen.append(_ChosenStep(segment, times[i], times[i + 1], coefficients[i] if coefficients else None))
    return chosen


def _states(some: list[_ChosenStep], length: np.ndarray, times: np.ndarray) -> np.ndarray:
    """The states (variables, steps, 5) at the nodes of some steps of one system of equations."""
    if some[0].coefficients is None:
        numbers: dict[int, list[int]] = {}
        for i, step in enumerate(some):
            numbers.setdefault(id(step.segment), []).append(i)
        y = None
        for where in numbers.values():
            part = some[where[0]].segment.states(times[where].ravel())
            if y is None:
                y = np.empty((len(part), *times.shape))
            y[:, where] = part.reshape(len(part), -1, 5)
        assert y is not None
        return y
    stack = np.array([step.coefficients for step in some])
    count = stack.shape[2]
    scaled = stack * np.vander(length, count, increasing=True)[:, None]
    return (scaled @ _powers(count)).transpose(1, 0, 2)


_POWERS = dict[int, np.ndarray]()


def _powers(count: int) -> np.ndarray:
    """Powers of the nodes, (count, 5)."""
    if count not in _POWERS:
        _POWERS[count] = np.ascontiguousarray(np.vander(NODES, count, increasing=True).T)
    return _POWERS[count]
