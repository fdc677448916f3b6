"""Touches of curves with corners in a step, away from their contact: where the plate enters its track in a pose.

Between two samples no point of the plate moves farther than a small part of its size, or than its distance from the
track. Where a pair of elements overlaps that was apart, its gap has closed: the zero is located on the curves.
"""

from __future__ import annotations

from collections.abc import Callable
from math import ceil

import numpy as np

from cases import Case, DoesNotFit
from cases.contact import Contact
from cases.contact.close_pairs import nearest_on
from cases.contact.nearest import contacts
from cases.contact.overlap_search import polygon_of
from cases.contact.piece_contact import Entry, excludes_second, find_from, piece_gap
from cases.curves.corner import Corner
from cases.curves.outline import sizes_of

from .pairs import Touch, in_round
from .plate_motion import Motion, limits
from .touches import Places

# Between two samples the plate's points move by this part of its size, or by so much of the distance from the track; at
# most MOST samples are taken in a step.
STEP, OF_DISTANCE, MOST = 0.02, 0.5, 2000
# Next to a contact the distance counts up to this part of the size.
FARTHEST = 0.2
# Pairs that are tried as the first.
MOST_PAIRS = 25
# A plate has entered its track if it lies deeper than this part of its size inside: far above the rounding of a pose.
DEPTH = 1e-9
# How far back a zero of a gap is searched, in times between two samples.
GOES_BACK = 4.0
# Times at which it is looked for, each twice as far back as the one before.
MOST_TIMES = 50

Pose = Callable[[float], tuple[float, float, float]]


class ChainTouches:
    """The search for touches of the curves of a case."""

    def __init__(self, case: Case, xi1: float):
        self.case, self.size = case, sizes_of(case.plate.outline).width
        corners = [element for element in case.track.elements if isinstance(element.piece, Corner)]
        self.corners = [element.middle + element.shift for element in corners]
        self.points = np.array([(e.piece.x, e.piece.y) for e in corners if isinstance(e.piece, Corner)]).T

    def first(self, motion: Motion, ends: tuple[float, float], places: Places, closed: bool) -> Touch | None:
        """The first touch between two times away from contacts at `places`, if there is one; `closed`: whether one of
        them touches."""
        track, outline = self.case.track, self.case.plate.outline
        if not outline.period or (closed and excludes_second(track, outline)):
            return None

        def pose_at(t: float) -> tuple[float, float, float]:
            x, y, theta = motion.bodies(np.array([t]))[:3, 0].tolist()
            return x, y, theta

        bounds, (before, end) = limits(motion, *ends), ends
        fastest, count = bounds.speed + bounds.spin * self.case.plate.reach, 0
        away, _ = self._inside(pose_at, before, places)
        while before < end:
            way = max(STEP * self.size, OF_DISTANCE * away)
            steps = min(ceil(fastest * (end - before) / way), MOST - count)
            after = before + (end - before) / steps if steps > 1 else end
            away, entry = self._inside(pose_at, after, places)
            if entry is not None:
                touch = self._touch(motion, pose_at, entry, (before, after), places)
                if touch is not None:
                    return touch
            before, count = after, count + 1
        return None

    def _inside(self, pose: Pose, t: float, places: Places) -> tuple[float, Contact | None]:
        """The least gap (m) in a pose apart from its contact, next to which there may be nearer points, and the deepest
        place where the plate is inside its track, or None."""
        track, deep = self.case.track, DEPTH * self.size
        own = [track.point(xi1) for xi1 in places(np.array([t]))[:, 0, 0].tolist()]
        every = contacts(track, self.case.plate.outline, *pose(t)) + self._corners_inside(*pose(t))
        apart = [one for one in every if all(np.hypot(*(track.point(one.xi1) - place)) > deep for place in own)]
        away = min((one.gap for one in apart), default=0.0)
        least = min(apart, key=lambda one: one.gap, default=None)
        return min(away, FARTHEST * self.size) if own else away, least if away < -deep else None

    def _corners_inside(self, x: float, y: float, theta: float) -> list[Contact]:
        """Corners of the track inside the plate: one that meets a corner of the plate has no other nearest points."""
        if not self.corners:
            return []
        outline, (px, py), c, s = self.case.plate.outline, self.points, np.cos(theta), np.sin(theta)
        u, v, results = c * (px - x) + s * (py - y), c * (py - y) - s * (px - x), list[Contact]()
        for k in np.flatnonzero(polygon_of(outline).holds(u, v)).tolist():
            xi2 = nearest_on(outline, float(u[k]), float(v[k]))
            results.append(Contact(self.corners[k], xi2, -float(np.hypot(*(outline.point(xi2) - (u[k], v[k]))))))
        return results

    def _touch(
        self, motion: Motion, pose: Pose, entry: Contact, times: tuple[float, float], places: Places
    ) -> Touch | None:
        """The touch by which the plate has entered its track between two times; None beyond an open track's ends."""
        track, outline = self.case.track, self.case.plate.outline
        (start, time), found = times, entry
        for _ in range(MOST_PAIRS):  # another pair may have touched before
            pair = Entry(track.element_at(found.xi1), outline.element_at(found.xi2), found.xi1, found.xi2)
            try:
                time = _entry_time(pose, pair, start, time, float(motion.edges[0]))
            except DoesNotFit:
                pass
            _, earlier = self._inside(pose, time, places)
            if earlier is None:
                break
            found = earlier
        body = motion.bodies(np.array([time]))[:, 0].tolist()
        try:
            xi1, xi2, _ = find_from(track, outline, body[0], body[1], body[2], pair)
            if all(isinstance(e.piece, Corner) for e in (track.element_at(xi1), outline.element_at(xi2))):
                raise DoesNotFit("a corner on a corner")
        except DoesNotFit:
            return Touch(time, body, np.nan, np.nan, 0.0)
        if track.ends and not track.ends[0] <= xi1 <= track.ends[1]:
            return None
        return Touch(time, body, xi1, in_round(self.case, body[2], xi1, xi2), 0.0)


def _entry_time(pose: Pose, pair: Entry, before: float, inside: float, earliest: float) -> float:
    """The instant at which a gap closed, between a time without an entry and one at which it was seen, s.

    At the first time the plate may already be inside by less than DEPTH, so that it goes back from there, by some times
    the time between both, at most to the time `earliest`: farther away the pieces, which go on beyond their ends, may
    have other zeros. Raises DoesNotFit if the gap does not close.
    """
    earliest, step = max(earliest, before - GOES_BACK * (inside - before)), inside - before
    for _ in range(MOST_TIMES):
        if piece_gap(pair, *pose(before)).gap > 0.0:
            break
        if before <= earliest:
            raise DoesNotFit("the gap does not close")
        before, step = max(before - step, earliest), 2.0 * step
    else:
        raise DoesNotFit("the gap does not close")
    for _ in range(60):  # halves: at most 60 of them leave a rounding of the time
        middle = 0.5 * (before + inside)
        before, inside = (middle, inside) if piece_gap(pair, *pose(middle)).gap > 0.0 else (before, middle)
    return 0.5 * (before + inside)
