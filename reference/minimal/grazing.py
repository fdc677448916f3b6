"""Grazing: a normal force that vanishes and grows again at once, within the motion's accuracy, is no lift-off, and a
friction force that reaches its cone so begins no slip.

A frictionless disc that returns to the height of its release has N = 0 and v = 0 there at the same time; whether the
computed N dips below zero depends on the error of the integration.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt

import numpy as np

from .integrators.segment import Event, Segment
from .modes import Phase
from .series import Series

# The greatest value of a guard in a segment is at most this many times what its series at the end says: most dips are
# too deep by far, and the segment's steps are not made for them.
LARGER = 100.0
# Terms of the motion's series across a dip, which lasts at most about the square root of the tolerance of its own time.
ORDER = 8
# A part of a segment in which a guard is nearly straight; and a guard that only touches zero, to a tolerance of 1e-6 at
# most, has a slope below this part of its value at the start over the segment's length: the root of the tolerance.
ALMOST, SLOWLY = 1e-6, 1e-2


def may_touch(now: Phase, segment: Segment, guard: str, begin: Sequence[float]) -> bool:
    """Whether a guard reaches zero so slowly, measured by its value at the segment's start, in the state `begin`, and
    the segment's length, that it may only touch it: series, which decide, take longer than most segments. `now` as of
    `over_touch`."""
    event = segment.event
    length, index = event.time - segment.start, list(now.system.guards).index(guard)
    soon = ALMOST * length
    rates = now.system.rates_of_numbers(event.time, event.state, now.parameters)
    later = [value + soon * rate for value, rate in zip(event.state, rates, strict=True)]
    first, beyond = (
        now.system.guards_of_numbers(t, y, now.parameters)[index]
        for t, y in ((segment.start, begin), (event.time + soon, later))
    )
    return not abs(beyond) > SLOWLY * ALMOST * abs(first)  # it is zero at the event


def over_touch(now: Phase, segment: Segment, guard: str, error: float, end: float) -> Segment | None:
    """Continue the motion across a dip of a force that ended the segment; None if the mode really ends.

    `guard` is the normal force, or the distance of a static friction or couple from its bound. A dip is ignored if it
    is no deeper than the relative `error` of the guard's greatest value in the segment. The motion across has zero
    length if the guard only reaches zero, and does not go beyond the time `end`. `now`: the segment's phase, whose
    system has series, whatever equations integrated the segment.
    """
    t, y = segment.event.time, segment.event.state
    value, slope, bend = _series_of(now, guard, t, y, 2)[1]
    if not bend > 0.0:
        return None
    depth, length = slope * slope / (4.0 * bend) - value, t - segment.start
    if depth > error * LARGER * (abs(value) + abs(slope) * length + bend * length * length):
        return None
    index = list(now.system.guards).index(guard)
    along = now.system.guards_of_arrays(segment.times, segment.states(segment.times), now.parameters)[index]
    if depth > error * np.max(np.abs(along)):
        return None
    motion, _ = _series_of(now, guard, t, y, ORDER)
    # To the dip's end and as far again: there the force is well above zero.
    lasts = 2.0 * (sqrt(max(depth, 0.0) / bend) + max(-slope, 0.0) / (2.0 * bend))
    lasts = min(lasts, end - t)
    last = np.polynomial.polynomial.polyval(lasts, motion.T)
    guards = now.system.guards_of_numbers(t + lasts, last.tolist(), now.parameters)
    if t < t + lasts < end and not all(value > 0.0 for value in guards):
        return None  # another guard reaches zero there, too

    def states(times: np.ndarray) -> np.ndarray:
        return np.polynomial.polynomial.polyval(times - t, motion.T)

    return Segment.of(now, np.array([t, t + lasts]), states, Event(None, t + lasts, tuple(last.tolist())), 1)


def _series_of(now: Phase, guard: str, t: float, y, order: int) -> tuple[np.ndarray, list[float]]:
    """The coefficients in time of the state, shape (variables, order + 1), and of the guard."""
    state, conditions = now.system.expand(t, y, [0.0] * len(y), now.parameters, order)
    force = conditions[list(now.system.conditions).index(guard)]
    terms = force.c if isinstance(force, Series) else [force]
    return np.array([component.c for component in state]), [*terms, *[0.0] * (order + 1 - len(terms))]
