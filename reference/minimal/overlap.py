"""A plate that meets its track in a second place: this formulation has one contact, so the motion ends there.

Where theorems exclude it nothing is searched. A convex outline lies inside the disc that touches it from within its
place and has its smallest curvature (Blaschke's rolling theorem; known to us, not looked up), so that a disc is all
that has to be asked for:

- A closed convex track whose curvature is below the disc's everywhere is the same theorem again.
- On a track that is the graph of a function along some direction, let its angle to that direction be φ(x). By
  d(sin φ)/dx = κ, and the same of the disc's lower arc with its larger curvature, the arc is steeper than the track
  everywhere beyond the contact and less steep before it: the track runs below the arc.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache, partial
from itertools import pairwise
from math import pi
from typing import NamedTuple

import numpy as np

from cases import Case, Curve, DoesNotFit, Transition
from cases.contact import Contact, find, overlap, pose
from cases.overlap import first_overlap, span

from .integrators.segment import Segment
from .modes import FLIGHT

# Looks to a step, at least, and the part of the plate's reach that its points move between two looks, at most: what
# the plate runs into stays inside it for longer.
LOOKS, CLOSE = 4, 0.25
# Looks at once, some hundred megabytes; what goes farther within a quarter of a step is looked at no closer.
AT_ONCE = 200_000


class Meeting(NamedTuple):
    """When (s) and where (track parameter) the outline meets the track a second time."""

    time: float
    xi1: float


Solution = tuple[list[Segment], list[Transition], tuple[str, str]]


def until_second_contact(case: Case, solution: Solution) -> Solution:
    """Arcs, transitions and ending of a motion, cut where the plate meets its track in a second place, if it does."""
    segments, transitions, _ = solution
    touching = [segment for segment in segments if segment.phase.regime != FLIGHT]  # in flight landings are looked for
    if not touching or fits_everywhere(case, touching):
        return solution
    meeting = first_meeting(case, touching)
    if meeting is None:
        return solution
    # It may meet it at its start, before which there is none.
    number = max((i for i, segment in enumerate(segments) if segment.start < meeting.time), default=0)
    # What was integrated beyond the meeting was work all the same.
    work = sum(segment.evaluations for segment in segments[number:])
    kept = [*segments[:number], segments[number].until(meeting.time, work)]
    reason = f"The plate meets its track in a second place, xi1 = {meeting.xi1:.9g}, at t = {meeting.time:.9g} s."
    return kept, [t for t in transitions if t.time < meeting.time], ("second_contact", reason)


def fits_everywhere(case: Case, segments: Sequence[Segment]) -> bool:
    """Whether a second contact is impossible on the way, by the curvatures alone."""
    track, outline = case.track, case.plate.outline
    xi1 = np.array([case.start.xi1])
    if track.domain is None and not track.period:  # a stretch of it, as long as the motion
        xi1 = np.concatenate([segment.states(segment.times)[0] for segment in segments])
    return fits(track, outline, *span(track, xi1, _reach(outline)))


@lru_cache(maxsize=256)
def fits(track: Curve, outline: Curve, low: float, high: float) -> bool:
    """The same on a stretch of the track."""
    if not outline.period:
        return True  # an outline without an inside is only its contact arc
    places = _places(track, low, high)
    bend, bends = track.curvature(places), outline.curvature(_places(outline, *outline.span))
    if np.min(bends) <= max(np.max(bend), 0.0):
        return False  # not convex, or tighter than the track somewhere
    angles = track.tangent_angle(places)
    if np.ptp(angles) < pi:
        return True  # a graph over the direction half-way between the extremes
    convex = np.min(bend) >= 0.0 or np.max(bend) <= 0.0
    return bool(convex and track.period is not None and abs(angles[-1] - angles[0]) < 2.1 * pi)


@lru_cache(maxsize=256)
def _reach(outline: Curve) -> float:
    """The farthest point of the outline from the centre of mass, m."""
    return float(np.hypot(*outline.point(np.linspace(*outline.span, 65))).max())


def _places(curve: Curve, low: float, high: float) -> np.ndarray:
    """Parameters that show how the curve bends, (n,)."""
    places = np.linspace(low, high, 721)
    return np.union1d(places, curve.features.places(low, high)) if curve.features else places


def first_meeting(case: Case, segments: Sequence[Segment]) -> Meeting | None:
    """The first second contact along segments of contact, looked for between their steps and located; None if none."""
    for segment in segments:
        for times, poses in _looks(case, segment):
            found = first_overlap(case.track, case.plate.outline, *poses)
            if found is not None:
                before = float(times[max(found[0] - 1, 0)])
                return _locate(case, before, float(times[found[0]]), found[1], partial(_pose, case, segment))
    return None


def _looks(case: Case, segment: Segment) -> Iterator[tuple[np.ndarray, tuple]]:
    """Times to look at a segment of contact, and the poses then: close enough, not too many at once; each lot begins
    where one ended."""
    reach = _reach(case.plate.outline)
    times = _divided(segment.times, np.full(len(segment.times) - 1, LOOKS))
    poses = _poses(case, segment, times)
    x, y, theta, _ = poses
    way = np.hypot(np.diff(x), np.diff(y))
    if case.plate.radius is None:  # a disc that turns about its centre stays where it is
        way += reach * np.abs(np.diff(theta))
    parts = np.minimum(np.maximum(np.ceil(way / (CLOSE * reach)), 1.0), AT_ONCE).astype(int)
    if len(times) <= AT_ONCE and not np.any(parts > 1):
        yield times, poses
        return
    lots = np.cumsum(parts) // AT_ONCE
    edges = [0, *(np.flatnonzero(np.diff(lots)) + 1).tolist(), len(parts)]
    for first, last in pairwise(edges):
        some = _divided(times[first : last + 1], parts[first:last])
        yield some, _poses(case, segment, some)


def _divided(times: np.ndarray, parts: np.ndarray) -> np.ndarray:
    """The times with each interval divided into so many parts."""
    if not len(parts):
        return times
    starts = np.cumsum(parts) - parts
    number = np.arange(parts.sum()) - np.repeat(starts, parts)
    inside = np.repeat(times[:-1], parts) + number * np.repeat(np.diff(times) / parts, parts)
    return np.append(inside, times[-1])


def _poses(case: Case, segment: Segment, times: np.ndarray):
    """(x, y, θ, ξ₁) of the plate in contact, each of shape (n,)."""
    states = segment.states(times)
    return *pose(case, states[0], states[1]), states[0]


def _pose(case: Case, segment: Segment, t: float) -> tuple[float, float, float]:
    x, y, theta, _ = _poses(case, segment, np.array([t]))
    return float(x[0]), float(y[0]), float(theta[0])


def _locate(
    case: Case, low: float, high: float, place: float, pose_at: Callable[[float], tuple[float, float, float]]
) -> Meeting:
    from scipy.optimize import brentq

    outline = case.plate.outline
    # The overlap is pushed back towards its first appearance, where a gap between two points describes it.
    for _ in range(20):
        middle = 0.5 * (low + high)
        found = overlap(case, *pose_at(middle), near=place)
        low, high, place = (low, middle, found) if found is not None else (middle, high, place)
    x, y, theta = pose_at(high)
    parameters = np.linspace(*outline.span, 721)[:-1]
    X, Y = case.track.point(place)
    c, s = np.cos(theta), np.sin(theta)
    u, v = outline.point(parameters)
    nearest = float(parameters[np.argmin(np.hypot(x + c * u - s * v - X, y + s * u + c * v - Y))])

    def contact(t: float) -> Contact:
        x, y, theta = pose_at(t)
        return find(case, x, y, theta, (place, nearest))

    def gap(t: float) -> float:
        return contact(t).gap

    # The polygon that showed the overlap lies inside the outline by up to its sagitta, so contact came a little before.
    try:
        width = max(high - low, np.spacing(high))  # the halves may have come to nothing
        while gap(high - width) <= 0.0:
            width *= 2.0
        time = brentq(gap, high - width, high, xtol=1e-15, rtol=8.9e-16)
    except (DoesNotFit, ValueError):
        # A contact that is no simple touch (two flat sides): told to the accuracy of the search by halves.
        return Meeting(high, place)
    return Meeting(time, contact(time).xi1)
