"""First meeting of a plate and a boundary: a search by boxes for each pair of their elements.

A smooth piece meets a smooth piece where their tangents are parallel; a corner of the outline meets a piece of the
track like a disc of radius zero; a corner of the track moves, as the plate sees it, towards a piece of the outline.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from functools import cache, lru_cache
from math import floor, pi
from typing import NamedTuple, cast

import numpy as np

from cases import Case, Curve
from cases.contact.geometry import angle_on
from cases.curves.corner import Corner
from cases.curves.curve_pieces import Pieces, ReversedPieces
from cases.scene.piece_case import PieceCase

from .boxes import Cores, Geometry
from .meetings import Meeting, MeetingSearch
from .windows import Windows, windows

# In a window the plate turns by at most this (rad), so that the path of a corner is a polynomial.
TURN = 1.0
# Windows of one stretch: far more than a motion needs that is not beyond all output.
MOST_WINDOWS = 20_000

Poses = Callable[[np.ndarray], np.ndarray]


class ElementMeeting(NamedTuple):
    """A meeting: its time (s), the pair of elements, and their own parameters."""

    time: float
    pair: PieceCase
    xi1: float
    xi2: float


class ElementSearch:
    """The search for first meetings of some pairs of elements of one plate and one boundary."""

    def __init__(self, pairs: Sequence[PieceCase]):
        ways = cache(Pieces), cache(ReversedPieces)  # a curve of many pairs is divided once
        self.searches = [(pair, MeetingSearch(_geometry(pair, *ways), pair.weight / pair.plate.mass)) for pair in pairs]

    def first(
        self, poses: Poses, edges: np.ndarray, skipped: Collection[tuple[int, int]],
        cores: Callable[[PieceCase, np.ndarray], Sequence[Cores]],
    ) -> ElementMeeting | None:  # fmt: skip
        """The first meeting between the first and the last of the times `edges`; None if there is none.

        `poses`: times (n,) ↦ (x, y, θ), (3, n). `skipped`: numbers of pairs of elements; `cores`: for a pair and edges
        of windows the surroundings of each contact, in the pair's own parameters. Raises TooMuch.
        """
        edges, motions = fine(poses, edges), dict[tuple[int | None, ...], Windows]()
        earliest: ElementMeeting | None = None
        for pair, search in self.searches:
            if (pair.first.number, pair.second.number) in skipped:
                continue
            elements = pair.first, pair.second
            key = tuple(one.number if isinstance(one.piece, Corner) else None for one in elements)
            if key not in motions:
                motions[key] = windows(_path(pair, poses), edges, pair.whole.plate.reach)
            some = motions[key]
            if earliest is not None:
                some = Windows(*(column[some.start < earliest.time] for column in some))
            if not len(some.start):
                continue
            meeting = search.first(some, cores(pair, np.array([some.start, some.end])))
            if meeting is not None and (earliest is None or meeting.time < earliest.time):
                theta = float(poses(np.array([meeting.time]))[2, 0])
                earliest = ElementMeeting(meeting.time, pair, *_parameters(pair, meeting, theta))
        return earliest


def _path(pair: PieceCase, poses: Poses) -> Poses:
    """The motion that a pair's search is about: the plate's, that of a corner of the outline, or that of a corner of
    the track in the plate's frame."""
    track, outline = pair.pieces
    if isinstance(outline, Corner):
        return lambda times: points_at(poses(times), outline.x, outline.y)
    if isinstance(track, Corner):
        return lambda times: _in_frame(poses(times), track.x, track.y)
    return poses


def _parameters(pair: PieceCase, meeting: Meeting, theta: float) -> tuple[float, float]:
    """The elements' own parameters at a meeting with the plate at that angle."""
    track, outline = pair.pieces
    if isinstance(track, Corner):
        xi2 = -meeting.xi1
        return _within(track, theta + float(outline.tangent_angle(xi2))), xi2
    if isinstance(outline, Corner):
        return meeting.xi1, _within(outline, float(track.tangent_angle(meeting.xi1)) - theta)
    return meeting.xi1, facing(pair, meeting.xi1, theta) if np.isnan(meeting.xi2) else meeting.xi2


def _geometry(pair: PieceCase, forwards: Callable[[Curve], Pieces], backwards: Callable[[Curve], Pieces]) -> Geometry:
    """The curves of a pair's search; `forwards`, `backwards`: the pieces of a curve."""
    (track, outline), plate = pair.pieces, pair.whole.plate
    if isinstance(track, Corner):
        return Geometry(backwards(cast(Curve, outline)), None, 0.0, plate.reach)
    if isinstance(outline, Corner):
        return Geometry(forwards(cast(Curve, track)), None, 0.0, plate.reach)
    return Geometry(forwards(cast(Curve, track)), forwards(cast(Curve, outline)), plate.radius, plate.reach)


def points_at(pose: np.ndarray, x: float, y: float) -> np.ndarray:
    """The place of a point of the plate in poses (3, n), as poses that do not turn."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return np.array([pose[0] + c * x - s * y, pose[1] + s * x + c * y, np.zeros_like(pose[2])])


def _in_frame(pose: np.ndarray, x: float, y: float) -> np.ndarray:
    """The place of a fixed point in the plate's frame, as poses that do not turn."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    dx, dy = x - pose[0], y - pose[1]
    return np.array([c * dx + s * dy, c * dy - s * dx, np.zeros_like(pose[2])])


def _within(corner: Corner, angle: float) -> float:
    """The parameter of a corner at which its tangent has a direction, inside its range."""
    low, high = corner.span
    return min(max(angle_on(corner, angle, 0.5 * (low + high)), low), high)


def facing(case: Case, xi1: float, theta: float) -> float:
    """Roughly the parameter of a convex outline whose tangent is parallel to the track's at `xi1`."""
    parameters, angles = _angles(case.plate.outline)
    angle = float(case.track.tangent_angle(xi1)) - theta
    if case.plate.outline.period:
        angle -= 2.0 * pi * floor((angle - angles[0]) / (2.0 * pi))
    return float(np.interp(angle, angles, parameters))


@lru_cache(maxsize=64)
def _angles(outline: Curve) -> tuple[np.ndarray, np.ndarray]:
    """Parameters of a convex outline and its tangent's angles there, which rise."""
    parameters = np.linspace(*outline.span, 721)
    return parameters, np.asarray(outline.tangent_angle(parameters))


def fine(poses: Poses, edges: np.ndarray) -> np.ndarray:
    """The times, and times between them, such that the plate turns by at most TURN between two."""
    turns = np.abs(np.diff(poses(edges)[2]))
    counts = np.minimum(1 + np.floor(turns / TURN), MOST_WINDOWS).astype(int)
    if counts.max(initial=1) == 1:
        return edges
    parts = [np.linspace(a, b, n, endpoint=False) for a, b, n in zip(edges[:-1], edges[1:], counts, strict=True)]
    return np.append(np.concatenate(parts), edges[-1])
