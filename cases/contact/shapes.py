"""Pairs of elements that are parts of lines and circles: their gap is one distance, and has a formula in the pose.

A corner is a circle of radius zero. A circle or corner moves in the frame of the other element, which is a line or a
circle there; what is a circle on both sides is seen from the base.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from ..curves import Curve
from ..curves.corner import Corner, Piece
from ..curves.line_or_circle import as_circle, as_line

Poses = Callable[[np.ndarray], np.ndarray]


class Ring(NamedTuple):
    """A circle or corner in the frame of its body: centre and radius (m), and whether the other curve lies inside."""

    x: float
    y: float
    radius: float
    is_hollow: bool = False


class Straight(NamedTuple):
    """A line: a point of it and its unit normal to the other curve, in the frame of its body."""

    x: float
    y: float
    nx: float
    ny: float


class Shapes(NamedTuple):
    """A pair of elements as a moving circle, seen from the other one's body, and that one. `from_base`: whether the
    circle is the plate's, seen from the base."""

    moving: Ring
    still: Ring | Straight
    from_base: bool

    def centre(self, x, y, theta) -> tuple[Any, Any]:
        """The circle's centre in the frame of the other body, in a pose of the plate in the frame of the base; numbers
        or arrays."""
        u, v = self.moving.x, self.moving.y
        c, s, dx, dy = np.cos(theta), np.sin(theta), u - x, v - y
        return (x + c * u - s * v, y + s * u + c * v) if self.from_base else (c * dx + s * dy, c * dy - s * dx)

    def path(self, poses: Poses) -> Poses:
        """The same at times, (x, y, 0) as poses (3, n); `poses` are those of the plate in the frame of the base."""

        def centre(times: np.ndarray) -> np.ndarray:
            x, y = self.centre(*poses(times))
            return np.array([x, y, np.zeros_like(x)])

        return centre

    def gap(self, x, y) -> Any:
        """The distance of both curves (m) with the circle's centre there; numbers or arrays."""
        still, r = self.still, self.moving.radius
        if isinstance(still, Straight):
            return (x - still.x) * still.nx + (y - still.y) * still.ny - r
        away = np.hypot(x - still.x, y - still.y)
        return still.radius - away - r if still.is_hollow else away - still.radius - r


@lru_cache(maxsize=4096)
def shapes(track: Piece, outline: Piece) -> Shapes | None:
    """The shapes of two elements, or None if they are no lines and circles, or do not touch in one place."""
    base, plate = _shape(track), _shape(outline)
    if isinstance(plate, Ring) and not plate.is_hollow:
        return None  # an outline that bends inwards
    if own := ring_of(outline):
        if isinstance(base, Ring) and base.is_hollow and base.radius <= own.radius:
            return None
        return None if base is None else Shapes(own, base, True)
    if isinstance(plate, Straight) and isinstance(base, Ring) and not base.is_hollow:
        # Outside an outline is its right side.
        return Shapes(base, Straight(plate.x, plate.y, -plate.nx, -plate.ny), False)
    return None


def ring_of(outline: Piece) -> Ring | None:
    """An element of an outline that bulges as a circle or corner; None if it is another."""
    shape = _shape(outline)
    return shape._replace(is_hollow=False) if isinstance(shape, Ring) and shape.is_hollow else None


def _shape(piece: Piece) -> Ring | Straight | None:
    """An element as a line with the normal to its left, or as a circle, hollow if its left side is inside."""
    if isinstance(piece, Corner):
        return Ring(piece.x, piece.y, 0.0, piece.sign > 0)
    assert isinstance(piece, Curve)
    if piece.parts is not None:
        return None
    if line := as_line(piece):
        (x, y), (tx, ty) = line.point.tolist(), line.direction.tolist()
        return Straight(x, y, -ty, tx)
    if circle := as_circle(piece):
        x, y = circle.centre.tolist()
        return Ring(x, y, circle.radius, circle.left)
    return None


def guess(track: Piece, outline: Piece, some: Shapes, x, y, theta) -> tuple[Any, Any]:
    """The elements' own parameters at the nearest points in a pose of the plate in the frame of the base; numbers or
    arrays."""
    cx, cy = some.centre(x, y, theta)
    if isinstance(some.still, Straight):
        nx, ny = some.still.nx, some.still.ny
    else:
        far = np.hypot(cx - some.still.x, cy - some.still.y)
        far = far + (far == 0.0)
        sign = -1.0 if some.still.is_hollow else 1.0
        nx, ny = sign * (cx - some.still.x) / far, sign * (cy - some.still.y) / far
    px, py = cx - some.moving.radius * nx, cy - some.moving.radius * ny
    if not some.from_base:  # the frame is the plate's, whose tangent is opposite to this normal's
        along = np.arctan2(nx, -ny)
        return with_direction(track, along + theta), parameter_at(outline, px, py, along)
    along = np.arctan2(-nx, ny)
    return parameter_at(track, px, py, along), with_direction(outline, along - theta)


def parameter_at(piece: Piece, x, y, direction=0.0) -> Any:
    """The parameter of a line nearest to a point, or that of a circle or corner whose tangent has a direction."""
    line = None if isinstance(piece, Corner) else as_line(piece)
    if line is None:
        return with_direction(piece, direction)
    low, (px, py), (tx, ty) = float(piece.span[0]), line.point.tolist(), line.direction.tolist()
    return low + ((x - px) * tx + (y - py) * ty) / float(piece.speed(low))


def with_direction(piece: Piece, direction) -> Any:
    """The parameter of a circle or corner whose tangent has that direction (rad), in the round of its middle."""
    middle = 0.5 * sum(piece.span)
    rate = piece.sign if isinstance(piece, Corner) else float(piece.curvature(middle) * piece.speed(middle))
    off = direction - float(piece.tangent_angle(middle))
    return middle + np.arctan2(np.sin(off), np.cos(off)) / rate
