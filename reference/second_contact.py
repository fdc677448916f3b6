"""A plate that meets its track in a second place: this formulation has one contact, so the motion ends there.

Where theorems exclude it (a convex outline on a straight line, or on a convex track that it fits: Blaschke's rolling
theorem) nothing is searched.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from math import pi
from typing import NamedTuple

import numpy as np

from cases import Case, Curve, DoesNotFit
from cases.contact import Contact, find, overlap


class Meeting(NamedTuple):
    """When (s) and where (track parameter) the outline meets the track a second time."""

    time: float
    xi1: float


@lru_cache(maxsize=256)
def fits_everywhere(case: Case) -> bool:
    """Whether a second contact is impossible, by the curvatures alone (looked at in 721 places)."""
    outline, track = _bends(case.plate.outline), _bends(case.track)
    if not case.plate.outline.period:
        return True  # an outline without an inside is only its contact arc
    if outline.min() <= max(track.max(), 0.0):
        return False  # not convex, or tighter than the track somewhere
    low, high = case.track.look
    turning = case.track.tangent_angle(high) - case.track.tangent_angle(low)
    convex = track.min() >= 0.0 or track.max() <= 0.0
    # A closed convex track turns once; an open arc that turns by less than half a turn does not come back to itself.
    return bool(convex and (abs(turning) < pi or (case.track.period is not None and abs(turning) < 2.1 * pi)))


def _bends(curve: Curve) -> np.ndarray:
    return np.asarray(curve.curvature(np.linspace(*curve.look, 721)))


def first_meeting(case: Case, times: np.ndarray, pose: Callable[[float], tuple[float, float, float]]) -> Meeting | None:
    """The first second contact along a motion, looked for at the given times and located between them; None if none."""
    before = float(times[0])
    for t in (float(t) for t in times[1:]):
        place = overlap(case, *pose(t))
        if place is not None:
            return _locate(case, before, t, place, pose)
        before = t
    return None


def _locate(case: Case, low: float, high: float, place: float, pose) -> Meeting:
    from scipy.optimize import brentq

    outline = case.plate.outline
    # The overlap is pushed back towards its first appearance, where a gap between two points describes it.
    for _ in range(20):
        middle = 0.5 * (low + high)
        found = overlap(case, *pose(middle))
        low, high, place = (low, middle, found) if found is not None else (middle, high, place)
    x, y, theta = pose(high)
    parameters = np.linspace(*outline.look, 721)[:-1]
    X, Y = case.track.point(place)
    c, s = np.cos(theta), np.sin(theta)
    u, v = outline.point(parameters)
    nearest = float(parameters[np.argmin(np.hypot(x + c * u - s * v - X, y + s * u + c * v - Y))])

    def contact(t: float) -> Contact:
        x, y, theta = pose(t)
        return find(case, x, y, theta, (place, nearest))

    def gap(t: float) -> float:
        return contact(t).gap

    # The polygon that showed the overlap lies inside the outline by up to its sagitta, so contact came a little before.
    try:
        width = high - low
        while gap(high - width) <= 0.0:
            width *= 2.0
        time = brentq(gap, high - width, high, xtol=1e-15, rtol=8.9e-16)
    except (DoesNotFit, ValueError):
        # A contact that is no simple touch (two flat sides): told to the accuracy of the search by halves.
        return Meeting(high, place)
    return Meeting(time, contact(time).xi1)
