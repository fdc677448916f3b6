"""Features of plates among free plates: a disc's circle, a polygon's corners, and the regions around a polygon.

A corner is a circle of radius 0. Around a convex polygon, the points next to each edge and to each corner form a
region: the distance of a disc's centre is that from the edge's line, or from the corner.
"""

from __future__ import annotations

from functools import lru_cache
from math import cos, hypot, pi, sin
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..curves.chain import Chain
from ..curves.corner import Corner
from .outline_features import sides

if TYPE_CHECKING:
    from ..scene.plate import Plate


class TouchCircle(NamedTuple):
    """A circle that touches: its centre in the plate's frame and its radius (m); of a corner the direction (rad) of the
    tangent where it starts, half its turn, and its first parameter of the outline."""

    x: float
    y: float
    radius: float
    start: float = 0.0
    half: float = 0.0
    first: float = 0.0

    def arm(self, theta: float) -> tuple[float, float]:
        """The centre from the plate's origin, in the fixed frame, m."""
        c, s = cos(theta), sin(theta)
        return c * self.x - s * self.y, s * self.x + c * self.y

    def outline_parameter(self, direction):
        """The parameter of a corner's outline where its tangent has a direction in the plate's frame, rad."""
        turn = direction - self.start - self.half
        return self.first + self.half + turn - 2.0 * pi * np.round(turn / (2.0 * pi))


class Region(NamedTuple):
    """The points nearest to an edge or a corner of a polygon, in the plate's frame: where `low` and `high`, each
    (u, v, c) with the value u x + v y + c (m), are not negative, outside the polygon.

    `x`, `y`: the edge's start or the corner; `tx`, `ty`: the edge's direction, 0 for a corner; `first`: the first
    parameter of the outline; `corner`: the corner as a circle, None for an edge.
    """

    x: float
    y: float
    tx: float
    ty: float
    first: float
    low: tuple[float, float, float]
    high: tuple[float, float, float]
    corner: TouchCircle | None


def is_polygon(plate: Plate) -> bool:
    """Whether the outline has straight edges only and its corners turn to the left: a convex polygon."""
    return len(sides(plate.outline)) > 5


def size_of_plate(plate: Plate) -> float:
    """The radius of a disc, the reach of another plate, m."""
    return plate.reach if plate.radius is None else float(plate.radius)


@lru_cache(maxsize=256)
def circles(plate: Plate) -> tuple[TouchCircle, ...]:
    """The circles by which a plate touches a line: the disc itself, or the corners in the outline's order."""
    if plate.radius is not None:
        return (TouchCircle(0.0, 0.0, float(plate.radius)),)
    outline = plate.outline
    assert isinstance(outline, Chain)
    return tuple(_corner(one) for one in outline.elements if isinstance(one.piece, Corner))


def _corner(element) -> TouchCircle:
    piece = element.piece
    return TouchCircle(
        float(piece.x), float(piece.y), 0.0, float(piece.start), 0.5 * abs(piece.turn), float(element.start)
    )


@lru_cache(maxsize=256)
def regions(plate: Plate) -> tuple[Region, ...]:
    """The regions around a polygon, counter-clockwise; none around a disc."""
    if plate.radius is not None or not isinstance(plate.outline, Chain):
        return ()
    elements, results = plate.outline.elements, list[Region]()
    for i, element in enumerate(elements):
        if isinstance(element.piece, Corner):
            corner = _corner(element)
            before, after = (_direction(elements[(i + k) % len(elements)].piece) for k in (-1, 1))
            low = (*before, -(before[0] * corner.x + before[1] * corner.y))
            high = (-after[0], -after[1], after[0] * corner.x + after[1] * corner.y)
            results.append(Region(corner.x, corner.y, 0.0, 0.0, corner.first, low, high, corner))
            continue
        (x, y), (u, v) = (float(one) for one in element.piece.point(element.low)), _direction(element.piece)
        along = u * x + v * y
        end = element.piece.point(element.piece.span[1])
        length = hypot(float(end[0]) - x, float(end[1]) - y)
        results.append(Region(x, y, u, v, float(element.start), (u, v, -along), (-u, -v, along + length), None))
    return tuple(results)


def _direction(edge) -> tuple[float, float]:
    u, v = edge.tangent(edge.span[0])
    return float(u), float(v)


def local_centre(base: np.ndarray | list[float], x, y):
    """A point in the frame of a plate with the pose `base` (x, y, θ), numbers or arrays, m."""
    c, s = np.cos(base[2]), np.sin(base[2])
    return c * (x - base[0]) + s * (y - base[1]), c * (y - base[1]) - s * (x - base[0])


def region_of(some: tuple[Region, ...], x, y):
    """The number of the region of a point in the polygon's frame, numbers or arrays."""
    values = []
    for one in some:
        borders = [u * x + v * y + c for u, v, c in (one.low, one.high)]
        outside = [] if one.corner else [(x - one.x) * one.ty - (y - one.y) * one.tx]
        values.append(np.min([*borders, *outside], axis=0))
    return np.argmax(values, axis=0)


def place_in_region(one: Region, x, y, radius: float):
    """Gap (m), outward normal and parameter of the outline of a disc with its centre at a point in the polygon's frame,
    numbers or arrays."""
    dx, dy = x - one.x, y - one.y
    if one.corner is None:
        nx, ny = one.ty + 0.0 * dx, -one.tx + 0.0 * dx
        return dx * one.ty - dy * one.tx - radius, nx, ny, one.first + dx * one.tx + dy * one.ty
    far = np.hypot(dx, dy)
    nx, ny = dx / far, dy / far
    return far - radius, nx, ny, one.corner.outline_parameter(np.arctan2(nx, -ny))


def places_in_regions(some: tuple[Region, ...], u: np.ndarray, v: np.ndarray, radius: float) -> np.ndarray:
    """Gap, outward normal and parameter, rows of shape (4, n), of a disc with its centre at these points in the frame
    of the polygon, each in the region in which it is."""
    which, results = region_of(some, u, v), np.empty((4, len(u)))
    for i in np.unique(which):
        here = which == i
        results[:, here] = place_in_region(some[i], u[here], v[here], radius)
    return results
