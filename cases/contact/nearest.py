"""Where a plate off its track is nearest to it, over the whole of both curves: what a landing is looked for with."""

from __future__ import annotations

from math import cos, hypot, inf, pi, remainder, sin
from typing import Any

import numpy as np

from ..curves import Curve
from ..curves.outline import sizes_of
from .element_pairs import SAME_PLACE, common_normals, nearest_on_elements
from .geometry import Contact

# Where no track is any more, m: squares of distances overflow there.
FARTHEST = 1e150
# Steps of Newton's method for a direction of the outline's tangent, from anywhere: of a circle the first is exact.
NEWTON = 32
# From so many times a closed track's size away it is a point: which of its points is the nearest drowns in rounding.
SIGHT = 1e12


def nearest(case: Any, x: float, y: float, theta: float) -> Contact | None:
    """`nearest_pair` of a case."""
    return nearest_pair(case.track, case.plate.outline, x, y, theta)


def nearest_pair(track: Curve, outline: Curve, x: float, y: float, theta: float) -> Contact | None:
    """The pair of points of outline and track with the smallest gap (m, signed), between the ends of both; None if
    there is none, or the track is out of sight: there is nothing to land on."""
    if max(abs(x), abs(y)) > FARTHEST or _out_of_sight(track, outline, x, y):
        return None
    some = nearest_on_elements(track, outline, x, y, theta)
    return some[0] if some else None


def contacts(track: Curve, outline: Curve, x: float, y: float, theta: float) -> list[Contact]:
    """Pairs of nearest points of elements of the track and of the outline, between the ends of both; where there are
    none, other pairs with a common normal, from which the pose is as well determined."""
    curves, pose = (track, outline), (x, y, theta)
    some = nearest_on_elements(*curves, *pose) or common_normals(*curves, *pose, inf)
    is_smooth = len(track.elements) == len(outline.elements) == 1
    return some or (_equidistant(*curves, *pose) if is_smooth else [])


def _equidistant(track: Curve, outline: Curve, x: float, y: float, theta: float) -> list[Contact]:
    """The middle of a track whose normals all meet the outline's in this pose, as at the centre of a round bowl, where
    no nearest point is the only one; none on another track."""
    xi1 = 0.5 * sum(track.span)
    direction, xi2 = float(track.tangent_angle(xi1)) - theta, float(outline.span[0])
    for _ in range(NEWTON):
        off = remainder(direction - float(outline.tangent_angle(xi2)), 2.0 * pi)
        xi2 += off / float(outline.curvature(xi2) * outline.speed(xi2))
    (u, v), c, s = outline.point(xi2), cos(theta), sin(theta)
    away = np.array([x + c * u - s * v, y + s * u + c * v]) - track.point(xi1)
    aside, gap = float(away @ track.tangent(xi1)), float(away @ track.normal(xi1))
    size = abs(x) + abs(y) + outline.sizes[0]
    return [Contact(xi1, xi2, gap)] if abs(aside) <= SAME_PLACE * size and gap > 0.0 else []


def _out_of_sight(track: Curve, outline: Curve, x: float, y: float) -> bool:
    """Whether a closed track is so far away that it has no sides any more."""
    size = sizes_of(track).width + sizes_of(outline).width
    return bool(track.period) and hypot(*(track.point(track.span[0]) - (x, y))) > SIGHT * size
