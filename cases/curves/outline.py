"""Outlines with corners, and arcs: closed chains that run counter-clockwise around a plate. The sizes of outlines."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from functools import lru_cache
from math import hypot, pi
from typing import NamedTuple

import numpy as np

from ..errors import BadValue, finite, not_negative, point, positive
from . import Curve, cos, sin
from .chain import MEETING, Chain, corner_points
from .corner import Edge


class Outline(Chain):
    """A closed chain: the outline of a plate with corners, counter-clockwise around it. Pieces in clockwise order are
    taken in the other direction, with a warning: the parameter then counts from the other end."""

    def __init__(self, pieces: Sequence[Curve]):
        super().__init__(pieces, True)
        if self.rotation < 0:
            from .backwards import backwards  # which imports curves

            pieces = [backwards(piece) for piece in reversed(self.pieces)]
            vars(self).clear()  # also what was derived from the pieces
            super().__init__(pieces, True)
            say_turned_round()

    @classmethod
    def of(cls, curve: Curve) -> Outline:
        """A closed smooth curve as an outline of one piece."""
        return cls((curve,))

    @classmethod
    def polygon(cls, points, radius: float = 0.0) -> Outline:
        """A polygon through points (n, 2) in metres, counter-clockwise; else they are taken in the other order from the
        first one on, with a warning. Its corners are rounded with `radius` (m) if one is given. Raises BadValue for an
        edge too short for that radius."""
        places, radius = corner_points(points, 3), not_negative("radius of the corners", radius)
        if places[0] == places[-1]:
            raise BadValue("the last point of the polygon is its first; leave it out")
        if 0.0 < radius < MEETING * max(hypot(*here) for here in places):
            raise BadValue(
                f"the radius of the corners is {radius:g} m, too small for the polygon; give 0 or a larger one"
            )
        x, y = np.array(places).T
        if np.dot(x, np.roll(y, -1)) < np.dot(y, np.roll(x, -1)):  # twice the area inside, by the shoelace formula
            places = [places[0], *places[:0:-1]]
            say_turned_round()
        if not radius:
            return cls(tuple(map(Edge.between, places, [*places[1:], places[0]])))
        return cls(_rounded(places, radius))


def say_turned_round() -> None:
    """Warn that an outline was given clockwise."""
    text = "the outline runs clockwise: it is taken in the other direction, so that the plate is on its left"
    warnings.warn(text, stacklevel=3)


# An edge that remains between two round corners is at least this part of the original one.
SHORTEST = 1e-9


def _rounded(places: list[tuple[float, float]], radius: float) -> tuple[Curve, ...]:
    """Edges and arcs of a polygon with rounded corners."""
    corners = np.array(places)
    along = np.roll(corners, -1, axis=0) - corners
    lengths = np.hypot(*along.T)
    angles = np.arctan2(along[:, 1], along[:, 0])
    turns = (angles - np.roll(angles, 1) + pi) % (2 * pi) - pi
    cuts = radius * np.abs(np.tan(0.5 * turns))
    pieces: list[Curve] = []
    for i, (start, length, angle, turn) in enumerate(zip(corners, lengths, angles, turns, strict=True)):
        if not cuts[i] + cuts[(i + 1) % len(corners)] < length * (1.0 - SHORTEST):
            raise BadValue(
                f"edge {i} of the polygon is {length:.6g} m long, too short for corners of radius {radius:g} m; give a "
                "smaller radius"
            )
        unit = np.array([np.cos(angle), np.sin(angle)])
        side = 1.0 if turn > 0.0 else -1.0
        begin, end = start + cuts[i] * unit, start + (length - cuts[(i + 1) % len(corners)]) * unit
        if turn:
            middle = begin + side * radius * np.array([-unit[1], unit[0]])
            first = angle - turn - side * pi / 2
            pieces.append(arc((middle[0], middle[1]), radius, first, first + turn))
        pieces.append(Edge.between((begin[0], begin[1]), (end[0], end[1])))
    return tuple(pieces)


def arc(centre: tuple[float, float], radius: float, start: float, end: float) -> Curve:
    """An arc of a circle from one polar angle about its centre to another, rad; clockwise if the second is smaller."""
    x, y = point("centre of arc", centre)
    r, start, end = positive("radius of arc", radius), finite("start of arc", start), finite("end of arc", end)
    if start == end:
        raise BadValue(f"the arc begins and ends at {start:g}; give two angles")
    way = 1 if end > start else -1
    return Curve(lambda s: (x + r * cos(way * s), y + r * sin(way * s)), (way * start, way * end))


def samples_around(outline: Curve) -> np.ndarray:
    """Parameters half a degree apart and at corners; distances are stationary at other extremes, so that the error is
    about 1e-5."""
    even = np.linspace(*outline.span, 721)
    return np.union1d(even, outline.vertices(0.01)) if isinstance(outline, Chain) else even


class OutlineSizes(NamedTuple):
    """The least and the greatest distance of an outline from its origin, the larger side of the box about it, and the
    radius of a circle about the origin, None of another outline, m."""

    inner: float
    reach: float
    width: float
    radius: float | None


@lru_cache(maxsize=256)
def sizes_of(outline: Curve) -> OutlineSizes:
    """The sizes of an outline, or of another curve."""
    points = outline.point(samples_around(outline))
    away = np.hypot(*points)
    return OutlineSizes(float(away.min()), float(away.max()), float(np.ptp(points, axis=1).max()), _radius(outline))


def _radius(outline: Curve) -> float | None:
    if isinstance(outline, Chain):
        return None
    s = np.linspace(*outline.span, 17)
    r = np.hypot(*outline.point(s))
    bend = outline.curvature(s)
    # Rounding of a handful of operations; a real outline that round is a disc for every purpose here.
    round_enough = np.ptp(r) <= 1e-13 * r.max() and np.all(np.abs(bend * r - 1.0) <= 1e-12)
    return float(r.mean()) if round_enough and outline.period else None
