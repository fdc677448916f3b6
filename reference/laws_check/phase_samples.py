"""Samples of a motion with one contact, from the coefficients of its phases: without its dense output, which would take
as long as the motion.

Phases of the same equations are evaluated together; pose and velocities come from the contact's parameters, slip and
spin by (5), (6) and (11).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cases import Case
from cases.piece_case import PieceCase
from cases.supports import TRACK
from cases.trajectory import CONTACT

from ..minimal.bouncing import StraightStates
from ..minimal.integrators.segment import Segment
from ..minimal.integrators.taylor import TaylorSteps
from ..minimal.modes import FLIGHT
from .samples import NODES, ContactSamples, MotionSamples, PlateSamples, law_at, point_and_tangent

# Steps that are sampled: all of a motion of so many; of more, the last of each phase and a part of the others. A step
# of the Taylor method takes 2 µs and its samples 1 µs, a phase takes 40 µs.
FEW, EVERY = 48, 16


class _ChosenStep(NamedTuple):
    """A step: its segment, start and end (s), and the coefficients (variables, powers) of its Taylor polynomial."""

    segment: Segment
    start: float
    end: float
    coefficients: np.ndarray | None


def of_phases(case: Case, segments: Sequence[Segment], most: int | None = FEW) -> MotionSamples | None:
    """The samples of a motion of one contact, or None without steps; all steps, or about `most`."""
    steps = _steps(segments, most)
    if not steps:
        return None
    start, end = np.array([step.start for step in steps]), np.array([step.end for step in steps])
    length, count = end - start, len(steps)
    times = start[:, None] + length[:, None] * NODES
    groups = defaultdict[tuple, list[int]](list)
    for i, step in enumerate(steps):
        phase = step.segment.phase
        groups[id(phase.system), phase.parts, step.coefficients is None].append(i)
    place, turn, velocity = (np.empty((count, 5), dtype=complex) for _ in range(3))
    spin, closed, columns = np.empty((count, 5)), list[np.ndarray](), list[tuple[np.ndarray, ...]]()
    for where in groups.values():
        here = slice(None) if len(where) == count else np.array(where)
        some = [steps[i] for i in where]
        y = _states(some, length[here], times[here])
        if some[0].segment.phase.regime == FLIGHT:
            place[here], turn[here], velocity[here], spin[here] = y[0] + 1j * y[1], np.exp(1j * y[2]), y[3] + 1j * y[4], y[5]
            continue
        one, *contact = _in_contact(case, some, times[here], y)
        place[here], turn[here], velocity[here], spin[here] = one
        closed.append(np.array(where))
        columns.append(tuple(contact))
    contacts = _contact(case, steps, closed, columns)
    is_straight = np.array([isinstance(step.segment.record, tuple) and isinstance(step.segment.states, StraightStates) for step in steps])
    is_next = np.insert(start[1:] == end[:-1], 0, False)
    near = {TRACK: np.array([case.start.xi1, *(value for c in columns for value in (c[-1].min(), c[-1].max()))])}
    return MotionSamples(case, start, length, times, (PlateSamples(place, turn, velocity, spin),), contacts, is_next, is_straight, near)


def _steps(segments: Sequence[Segment], most: int | None) -> list[_ChosenStep]:
    """The steps that are sampled, in order of time."""
    total = sum(segment.steps for segment in segments)
    every = 1 if most is None or total <= most else max(1, total // (most + total // EVERY))
    chosen = list[_ChosenStep]()
    for segment in segments:
        record = segment.record
        if isinstance(record, TaylorSteps):
            times, coefficients = record.times, record.coefficients
        else:
            times, coefficients = segment.times.tolist(), None
        last = len(times) - 2
        for i in range(last % every, last + 1, every):
            if times[i + 1] > times[i]:
                chosen.append(_ChosenStep(segment, times[i], times[i + 1], coefficients and coefficients[i]))
    return chosen


def _states(some: list[_ChosenStep], length: np.ndarray, times: np.ndarray) -> np.ndarray:
    """The states (variables, steps, 5) at the nodes of some steps of one system of equations."""
    if some[0].coefficients is None:
        by_segment = defaultdict[int, list[int]](list)
        for i, step in enumerate(some):
            by_segment[id(step.segment)].append(i)
        parts = [some[where[0]].segment.states(times[where].ravel()) for where in by_segment.values()]
        order = np.argsort([i for where in by_segment.values() for i in where])
        every = [part.reshape(len(part), -1, 5) for part in parts]
        return np.concatenate(every, axis=1)[:, order]
    stack = np.array([step.coefficients for step in some])
    powers = stack.shape[2]
    scaled = stack * np.vander(length, powers, increasing=True)[:, None]
    return (scaled @ _powers(powers)).transpose(1, 0, 2)


_POWERS = dict[int, np.ndarray]()


def _powers(count: int) -> np.ndarray:
    """Powers of the nodes, (count, 5)."""
    if count not in _POWERS:
        _POWERS[count] = np.vander(NODES, count, increasing=True).T
    return _POWERS[count]


def _in_contact(case: Case, some: list[_ChosenStep], times: np.ndarray, y: np.ndarray):
    """The plate, and point, tangent, slip, normal and friction force and parameter of its contact, arrays (steps, 5)."""
    phase = some[0].segment.phase
    every = [step.segment.phase.parameters for step in some]
    parameters = every[0] if all(one is every[0] for one in every) else tuple(np.array(every).T[:, :, None])
    outputs = phase.system.record(*phase.system.outputs_of_arrays(times, y, parameters))
    slip, spin, normal, friction = (
        np.broadcast_to(row, times.shape) for row in (outputs.slip, outputs.omega, outputs.normal, outputs.friction)
    )
    base, tangent = point_and_tangent(phase.case.track, y[0])
    own, along = point_and_tangent(phase.case.plate.outline, y[1])
    turn = tangent * along.conj()
    place = base - turn * own
    belt = law_at(case, CONTACT).belt
    carried = slip if belt is None else slip + belt.at_arrays(times.ravel()).reshape(times.shape)
    velocity = carried * tangent + 1j * spin * (place - base)
    mass = case.plate.mass
    xi1 = phase.case.to_whole(y[0], y[1])[0] if isinstance(phase.case, PieceCase) else y[0]
    return (place, turn, velocity, spin), base, tangent, slip, mass * normal, mass * friction, xi1


def _contact(
    case: Case, steps: list[_ChosenStep], closed: list[np.ndarray], columns: list[tuple[np.ndarray, ...]]
) -> tuple[ContactSamples, ...]:
    """The contact in all steps in which it is closed."""
    if not closed:
        return ()
    if len(closed) == 1:
        numbers, rows = closed[0], columns[0]
    else:
        numbers = np.concatenate(closed)
        order = np.argsort(numbers)
        numbers = numbers[order]
        rows = tuple(np.concatenate(parts)[order] for parts in zip(*columns, strict=True))
    base, tangent, slip, normal, friction, _ = rows
    modes = np.array([steps[i].segment.phase.regime.mode for i in numbers.tolist()], dtype=object)
    return (ContactSamples(law_at(case, CONTACT), numbers, base, tangent, slip, normal, friction, base, modes),)
