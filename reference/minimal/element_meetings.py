"""First meeting of plate and track where one of them has corners: a search by boxes for each pair of their elements.

A smooth piece meets a smooth piece where their tangents are parallel; a corner of the outline meets a piece of the
track like a disc of radius zero; a corner of the track moves, as the plate sees it, towards a piece of the outline.
Straight pieces meet nowhere but at their ends, and a corner that points away from the other curve touches nothing
before its neighbours do. So the pairs searched are all that there are.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from functools import cache
from typing import NamedTuple

import numpy as np

from cases import Case, Curve
from cases.contact.geometry import angle_on
from cases.curves.corner import Corner
from cases.curves.element import Element

from .boxes import Cores, Geometry
from .curve_pieces import Pieces, ReversedPieces
from .gap import facing
from .meetings import Meeting, MeetingSearch
from .windows import DEGREE, Windows, windows

# In a window the plate turns by at most this (rad), so that the path of a corner is a polynomial.
TURN = 1.0
# Windows of one stretch: far more than a motion needs that is not beyond all output.
MOST_WINDOWS = 20_000

Poses = Callable[[np.ndarray], np.ndarray]


class ElementMeeting(NamedTuple):
    """A meeting: its time (s), the elements of track and outline, and the parameters of the whole curves."""

    time: float
    first: Element
    second: Element
    xi1: float
    xi2: float


class _Pair(NamedTuple):
    """A pair of elements, and the search for their meetings."""

    first: Element
    second: Element
    search: MeetingSearch


class ElementSearch:
    """The search for first meetings in the motion of one case with corners."""

    def __init__(self, case: Case):
        self.case, self.reach = case, case.plate.reach
        self.pairs = [
            _Pair(first, second, MeetingSearch(geometry, case.weight / case.plate.mass))
            for first in case.track.elements
            for second in case.plate.outline.elements
            if (geometry := _geometry(case, first, second)) is not None
        ]

    def first(
        self,
        poses: Poses,
        edges: np.ndarray,
        skipped: Collection[tuple[int, int]] = (),
        cores: Callable[[Element, Element, np.ndarray], Sequence[Cores]] | None = None,
    ) -> ElementMeeting | None:
        """The first meeting between the first and the last of the times `edges`; None if there is none.

        `poses`: times (n,) ↦ (x, y, θ), (3, n). `skipped`: numbers of pairs of elements; `cores`: for a pair and edges
        of windows the surroundings of each contact, in the pair's own parameters. Raises TooMuch.
        """
        edges = fine(poses, edges)
        earliest: ElementMeeting | None = None

        @cache
        def motion(first: int | None, second: int | None) -> Windows:
            return windows(self._path(poses, first, second), edges, self.reach, DEGREE)

        for pair in self.pairs:
            if (pair.first.number, pair.second.number) in skipped:
                continue
            key = (
                pair.first.number if isinstance(pair.first.piece, Corner) else None,
                pair.second.number if isinstance(pair.second.piece, Corner) else None,
            )
            some = motion(*key)
            if earliest is not None:
                some = Windows(*(column[some.start < earliest.time] for column in some))
            if not len(some.start):
                continue
            around = cores(pair.first, pair.second, np.array([some.start, some.end])) if cores else ()
            meeting = pair.search.first(some, around)
            if meeting is not None and (earliest is None or meeting.time < earliest.time):
                earliest = self._in_whole(poses, pair, meeting)
        return earliest

    def _path(self, poses: Poses, first: int | None, second: int | None) -> Poses:
        """The motion that a pair's search is about: the plate's, that of a corner of the outline, or that of a corner
        of the track in the plate's frame."""
        if second is not None:
            own = self.case.plate.outline.elements[second].piece
            assert isinstance(own, Corner)
            x, y = own.x, own.y
            return lambda times: points_at(poses(times), x, y)
        if first is not None:
            fixed = self.case.track.elements[first].piece
            assert isinstance(fixed, Corner)
            u, v = fixed.x, fixed.y
            return lambda times: _seen(poses(times), u, v)
        return poses

    def _in_whole(self, poses: Poses, pair: _Pair, meeting: Meeting) -> ElementMeeting:
        first, second = pair.first, pair.second
        theta = float(poses(np.array([meeting.time]))[2, 0])
        if isinstance(first.piece, Corner):
            xi2 = -meeting.xi1
            angle = theta + float(second.piece.tangent_angle(xi2))
            return ElementMeeting(meeting.time, first, second, _within(first, angle), xi2 + second.shift)
        xi1 = meeting.xi1
        along = float(first.piece.tangent_angle(xi1)) - theta
        if isinstance(second.piece, Corner):
            return ElementMeeting(meeting.time, first, second, xi1 + first.shift, _within(second, along))
        xi1 += first.shift
        xi2 = facing(self.case, xi1, theta) if np.isnan(meeting.xi2) else meeting.xi2 + second.shift
        return ElementMeeting(meeting.time, first, second, xi1, xi2)


def _geometry(case: Case, first: Element, second: Element) -> Geometry | None:
    """The curves of a pair's search; None where nothing can meet first."""
    track, outline = first.piece, second.piece
    reach = case.plate.reach
    if isinstance(track, Corner) and isinstance(outline, Corner):
        return None
    if isinstance(track, Corner):
        assert isinstance(outline, Curve)
        return Geometry(ReversedPieces(outline), None, 0.0, reach) if track.turn < 0.0 else None
    if isinstance(outline, Corner):
        return Geometry(Pieces(track), None, 0.0, reach) if outline.turn > 0.0 else None
    if track.features is None and outline.features is None:
        return None
    return Geometry(Pieces(track), Pieces(outline), case.plate.radius, reach)


def points_at(pose: np.ndarray, x: float, y: float) -> np.ndarray:
    """The place of a point of the plate in poses (3, n), as poses that do not turn."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return np.array([pose[0] + c * x - s * y, pose[1] + s * x + c * y, np.zeros_like(pose[2])])


def _seen(pose: np.ndarray, x: float, y: float) -> np.ndarray:
    """The place of a fixed point in the plate's frame, as poses that do not turn."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    dx, dy = x - pose[0], y - pose[1]
    return np.array([c * dx + s * dy, c * dy - s * dx, np.zeros_like(pose[2])])


def _within(element: Element, angle: float) -> float:
    """The parameter of a corner at which its tangent has a direction, inside its range."""
    assert isinstance(element.piece, Corner)
    return element.clip(angle_on(element.piece, angle, element.middle) + element.shift)


def fine(poses: Poses, edges: np.ndarray) -> np.ndarray:
    """The times, and times between them, such that the plate turns by at most TURN between two."""
    turns = np.abs(np.diff(poses(edges)[2]))
    counts = np.minimum(1 + np.floor(turns / TURN), MOST_WINDOWS).astype(int)
    if counts.max(initial=1) == 1:
        return edges
    parts = [np.linspace(a, b, n, endpoint=False) for a, b, n in zip(edges[:-1], edges[1:], counts, strict=True)]
    return np.append(np.concatenate(parts), edges[-1])
