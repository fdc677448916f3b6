"""The first meeting of a plate and a boundary at a place that is not watched, in a phase's dense output.

An end of an open curve is searched as a corner; the motion ends where a plate meets it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import inf

import numpy as np

from cases import Case
from cases.contact.element_pairs import in_frame
from cases.contact.overlap_search import OVERLAPS, depth_inside
from cases.contact.shapes import Poses
from cases.scene.couples import CurveEnd, couples, curve_ends
from cases.scene.piece_case import PieceCase

from ..endings import Ending, end_of_curve
from ..minimal.element_meetings import ElementMeeting
from ..minimal.integrators.segment import Segment
from ..scales import EPS, TOUCHES
from .couple_search import CoupleSearch, couple_rests, looks, place_inside, stays_apart, until
from .places import couple_of, place, who_and_which
from .segment_view import SegmentView, remember
from .touching import SAME_PLACE, place_on_track, touching_of

# When a plate that begins to move is seen to go into an end that it touches: in parts of a step.
START = np.array([0.0, 1e-6, 1e-5, 1e-4, 1e-3])
# Meetings that differ by less than this part of their time are at one instant: each is located to 1e-12.
TIE = 1e-11
# The times of meetings inside steps are corrected so often, by less than this part of the segment: by the error of its
# dense output; and no more where it is rounding, in parts of the time.
CORRECTIONS, NEWTON, FINEST = 3, 1e-3, 4 * EPS


class Meetings:
    """The search for meetings in one motion; counts its work."""

    def __init__(self, case: Case):
        self.case = case
        self.searches = [CoupleSearch(couple) for couple in couples(case)]
        self.ends = [EndSearch(end) for end in curve_ends(case)]

    def first(self, view: SegmentView) -> ElementMeeting | None:
        """The first meeting in a segment; None if there is none. Raises TooMuch at the limit on work."""
        edges, poses = np.unique(view.times), remember(view.poses)
        end = _first_of(self.ends, view, poses, edges)
        if end is not None:
            edges = until(edges, min(end.time * (1.0 + TIE), float(edges[-1])))
        meeting = _first_of(self.searches, view, poses, edges)
        if end is None or meeting is None:
            return meeting or end
        if meeting.time < end.time * (1.0 - TIE):
            return meeting
        # A side that falls flat across a joint meets both curves and both their ends at one instant.
        number = couple_of(end.pair).number
        own = _first_of([one for one in self.searches if one.couple.number == number], view, poses, edges)
        return meeting if own is not None and _is_beside(end, own.pair, own.xi1) else end

    def past_of(self, state: Sequence[float], resting: frozenset[int]) -> Callable[[Sequence[float]], bool]:
        """Whether a plate is, in the variables of a phase, beyond a line or circle from which it is apart in a state of
        all plates: they have met before, and more steps would be cut off."""
        half = len(state) // 2
        apart = [
            (search.couple, pairs) for search in self.searches
            if not couple_rests(search.couple, resting) and (pairs := search.far_pairs(np.array(state[:half])))
        ]  # fmt: skip

        def is_past(y: Sequence[float]) -> bool:
            poses = np.array(y[:half])
            for couple, pairs in apart:
                pose = couple.relative_pose(poses)
                for pair, some in pairs:
                    if some.gap(*some.centre(*pose)) < 0.0 and place_inside(pair, some, *pose) is not None:
                        return True
            return False

        return is_past


def _first_of(
    searches: Sequence[CoupleSearch], view: SegmentView, poses: Poses, edges: np.ndarray
) -> ElementMeeting | None:
    """The first meeting that some searches find between these times."""
    earliest: ElementMeeting | None = None
    for search in [one for one in searches if not one.excludes_all(view.pairs, view.resting)]:
        some = edges if earliest is None else until(edges, earliest.time)
        meeting = search.first(view, poses, some) if len(some) > 1 else None
        if meeting is not None and (earliest is None or meeting.time < earliest.time):
            earliest = meeting
    return earliest


def until_meeting(
    segment: Segment, meeting: ElementMeeting, integrate: Callable[..., Segment], rtol: float,
    state_of: Callable[[Segment], Sequence[float]],
) -> Segment:  # fmt: skip
    """A segment until elements meet. Where their gap at the end of a step is another one than inside it, the time is
    corrected by Newton's method. `integrate` (t, y, end, rtol); `state_of`: the plates' state at a segment's end."""
    result, time = segment.cut(meeting.time, None), meeting.time
    for _ in range(CORRECTIONS if segment.ends_in_steps() else 0):
        again = segment.step_to(time, lambda t, y, end: integrate(t, y, end, rtol))
        if again is None:
            break
        result, state = again, state_of(again)
        at = place(meeting.pair, state, (meeting.xi1, meeting.xi2))
        closing = float(at.lift_row @ np.array(state[len(state) // 2 :]))
        change = -at.gap / closing if closing < 0.0 else 0.0
        if not FINEST * abs(time) < abs(change) < NEWTON * (time - segment.start):
            break
        time += change
    return result


class EndSearch(CoupleSearch):
    """The search for meetings of one plate and an end of a curve: as of a couple whose track is a corner, and which has
    no contact."""

    def __init__(self, end: CurveEnd):
        super().__init__(end)
        self.place = np.array([[end.corner.x], [end.corner.y]])

    def excludes_all(self, in_view: Sequence[PieceCase], resting: frozenset[int]) -> bool:
        """Whether a plate at rest excludes every meeting."""
        return couple_rests(self.couple, resting)

    def first(self, view: SegmentView, places: Poses, edges: np.ndarray) -> ElementMeeting | None:
        """The first meeting in a segment between these times; where the plate touches the end without a velocity, and
        goes on into it, that is the start."""
        if self._is_far(places, edges):
            return None
        begin = places(edges[0] + START * (edges[1] - edges[0])).T
        x, y, _ = self.couple.relative_pose(begin[0])
        extent = abs(float(x)) + abs(float(y)) + self.couple.plate.reach
        least, touches = TOUCHES * extent, self._depth(begin[0]) >= -TOUCHES * extent
        depths = [self._depth(poses) for poses in begin[1:]] if touches else [-inf]
        if min(depths) >= -least and depths[-1] > least:
            for pair, points in touching_of(self.couple, begin[0], least, OVERLAPS * extent):
                meeting = ElementMeeting(float(edges[0]), pair, *points)
                if not self._is_in_view(view, meeting, also_flat=False):
                    return meeting
        return super().first(view, places, edges)

    def _depth(self, poses: np.ndarray) -> float:
        """How deep the end lies in the plate, m, in poses of all plates."""
        pose, (x, y) = self.couple.relative_pose(poses), self.place[:, 0].tolist()
        return depth_inside(self.couple.plate.outline, *in_frame(x, y, pose))

    def _is_far(self, places: Poses, edges: np.ndarray) -> bool:
        own = 3 * self.couple.body
        return stays_apart(places(looks(edges))[own : own + 2] - self.place, self.couple.plate.reach)

    def _in_view(self, view: SegmentView) -> list[tuple[int, PieceCase]]:
        return []

    def _is_in_view(self, view: SegmentView, meeting: ElementMeeting, also_flat: bool = True) -> bool:
        """Whether a contact of the plate is at that place, or, `also_flat`, a side lies flat on the end's own curve."""
        time, least = np.array([meeting.time]), SAME_PLACE * self.couple.plate.reach
        return any(
            couple.body == self.couple.body
            and couple.base is None
            and view.gap(k, time)[0] <= least
            and _is_beside(meeting, pair, view.points(k, time)[0, 0], also_flat and couple.number == self.couple.number)
            for k, pair in enumerate(view.pairs)
            for couple in (couple_of(pair),)
        )


def ending_at(meeting: ElementMeeting) -> Ending | None:
    """How a motion ends where a plate meets an end of a curve; None for another meeting."""
    couple = couple_of(meeting.pair)
    return end_of_curve(meeting.time, *who_and_which(couple), couple.end) if isinstance(couple, CurveEnd) else None


def _is_beside(end: ElementMeeting, pair: PieceCase, xi1: float, also_flat: bool = True) -> bool:
    """Whether a contact is at the end of a curve that its plate meets, or, `also_flat`, has the same direction."""
    off = np.abs(place_on_track(pair, xi1) - place_on_track(end.pair, end.xi1))
    is_there = off[:2].max() <= SAME_PLACE or (also_flat and off[2:].max() <= SAME_PLACE)
    return bool(is_there)
