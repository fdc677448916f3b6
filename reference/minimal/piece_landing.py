"""Landings of a plate where track or outline has corners: the first meeting of any pair of their elements."""

from __future__ import annotations

from functools import cached_property, partial

import numpy as np

from cases import Chain, Curve
from cases.corner import Corner

from .element_meetings import ElementMeeting, ElementSearch
from .gap import Look, state
from .integrators.segment import Segment
from .landing import Landing, Landings, poses
from .meetings import Meeting
from .windows import windows

# A flight in which a corner has just passed a corner is searched from the time at which the plate has moved by this
# part of its size: far above the rounding of places, far below any other motion.
PASSED = 1e-9


class PieceLandings(Landings):
    """The search for landings in a motion over corners; contact parameters are those of the whole curves."""

    @cached_property
    def elements(self) -> ElementSearch:
        """The search for meetings by pairs of elements."""
        return ElementSearch(self.case)

    def first(self, segment: Segment, place: tuple[float, float], under_way: bool = False) -> Landing | None:
        """The first landing of a flight's segment; None if it flies on. Raises TooMuch at the limit on work."""
        start, end = float(segment.times[0]), float(segment.times[-1])
        self.flies_until = since = start
        if not under_way:
            before = self.looks.at(segment, start, place)
            if before is None or self._corners_pass(before):
                since = self._passed(segment, start, end)
            elif before.gap <= 1e-12 * self.size:  # to the rounding of positions
                landing, look = self._leave(segment, before, place[0])
                if landing:
                    return landing
                since = look.time
        motion = windows(partial(poses, segment), segment.times, self.size, self.degree)
        for some in self._stretches(segment, motion, since):
            self.flies_until = float(some.start[0])
            edges = np.append(some.start, some.end[-1])
            # A meeting may be found a millionth of a window before its start.
            soon = since + (since - start) * 1e3 ** np.arange(1, 5) if since > start else edges
            edges = np.union1d(edges, soon[(soon > edges[0]) & (soon < edges[-1])])
            meeting = self.elements.first(partial(poses, segment), edges)
            if meeting is not None:
                return self._landing_at(segment, _pair(meeting), place[0])
        return None

    def _corners_pass(self, look: Look) -> bool:
        """Whether a flight begins with a corner at a corner of the other curve."""
        curves = self.case.track, self.case.plate.outline
        return all(
            isinstance(curve, Chain)
            and any(
                isinstance(element.piece, Corner) and np.hypot(*(element.piece.point(0.0) - curve.point(s))) <= reach
                for element in (curve.elements[i % len(curve.elements)] for i in near(curve, s))
            )
            for reach in (1e-12 * self.size,)
            for curve, s in zip(curves, look.pair, strict=True)
        )

    def _passed(self, segment: Segment, start: float, end: float) -> float:
        """The time from which a flight is searched that begins where a corner passes a corner."""
        _, _, _, vx, vy, omega = state(segment, start)
        speed = abs(vx) + abs(vy) + abs(omega) * self.size
        return min(start + PASSED * self.size / speed, end) if speed else start

    def _elsewhere(self, segment: Segment, start: Look, look: Look) -> Meeting | None:
        """A meeting before a look of elements that are not next to those of the contact; None if there is none."""
        if not look.time > start.time:
            return None
        skipped = {
            (i, j)
            for pair in (start.pair, look.pair)
            for i in near(self.case.track, pair[0])
            for j in near(self.case.plate.outline, pair[1])
        }
        meeting = self.elements.first(partial(poses, segment), np.array([start.time, look.time]), skipped)
        return _pair(meeting) if meeting is not None else None


def near(curve: Curve, s: float) -> set[int]:
    """The numbers of the element of a curve at a parameter and of both neighbours, within one round."""
    if not isinstance(curve, Chain):
        return {0}
    number, count = curve.element_at(s).number, len(curve.elements)
    return {(number + i) % count if curve.is_closed else number + i for i in (-1, 0, 1)}


def _pair(meeting: ElementMeeting) -> Meeting:
    return Meeting(meeting.time, meeting.xi1, meeting.xi2)
