"""Features of plates among free plates: a disc's circle, and a polygon's corners, which are circles of radius 0."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from math import cos, sin
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..curves.chain import Chain
from .outline_features import sides

if TYPE_CHECKING:
    from ..scene.plate import Plate


class TouchCircle(NamedTuple):
    """A circle that touches: its centre in the plate's frame and its radius, m; of a corner 0."""

    x: float
    y: float
    radius: float

    def arm(self, theta: float) -> tuple[float, float]:
        """The centre from the plate's origin, in the fixed frame, m."""
        c, s = cos(theta), sin(theta)
        return c * self.x - s * self.y, s * self.x + c * self.y


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
    return tuple(TouchCircle(corner.x, corner.y, 0.0) for corner in outline.corners)


def local_centre(base: np.ndarray | list[float], x, y):
    """A point in the frame of a plate with the pose `base` (x, y, θ), numbers or arrays, m."""
    c, s = np.cos(base[2]), np.sin(base[2])
    return c * (x - base[0]) + s * (y - base[1]), c * (y - base[1]) - s * (x - base[0])


def polygon_distance(corners: Sequence[TouchCircle], u: float, v: float) -> float:
    """The distance (m) of a point from a convex polygon in its frame, negative inside; corners counter-clockwise."""
    points = np.array([corner[:2] for corner in corners])
    along, off = np.roll(points, -1, axis=0) - points, np.array([u, v]) - points
    share = np.clip((off * along).sum(axis=1) / (along * along).sum(axis=1), 0.0, 1.0)
    far = float(np.hypot(*(off - share[:, None] * along).T).min())
    is_inside = (along[:, 0] * off[:, 1] >= along[:, 1] * off[:, 0]).all()
    return -far if is_inside else far
