"""Proof by curvatures alone that a plate that touches or nearly touches its track meets it nowhere else.

A convex outline lies inside the disc that touches it at the contact and has its smallest curvature (Blaschke's rolling
theorem; known to us, not looked up), so that it is enough to consider a disc:

- For a closed convex track whose curvature is below the disc's everywhere, the same theorem applies.
- On a track that is the graph of a function along some direction, let its angle to that direction be φ(x). By
  d(sin φ)/dx = κ, and the same of the disc's lower arc with its larger curvature, the arc is steeper than the track
  everywhere beyond the contact and less steep before it: the track runs below the arc.

If the track bends to its right or not at all, the disc may be a half-plane: the tangent separates it from the plate.

A plate at a distance g from its track touches it if it is enlarged by g, to curvatures κ/(1 + κ g). While that is above
the track's curvature, the plate is nowhere nearer to its track than g: one pair of points with parallel tangents is the
nearest, and only this pair has to be followed.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from math import inf, pi
from typing import NamedTuple

import numpy as np

from cases import Curve

# A parabola through three evenly spaced values exceeds the middle one by up to an eighth of their second difference.
BETWEEN = 0.25
# Bounds on curvatures are as narrow as this part of the largest.
BEND_PRECISION = 1e-7
# Stretches around an extremum are sampled again CLOSER times, at PARTS places: the remaining error is 1e-8 of the
# range.
CLOSER, PARTS = 3, 17


class Room(NamedTuple):
    """The gap (m) up to which a plate is nearest to its track in one place only; the ranges of the curvatures, 1/m."""

    gap: float
    track: tuple[float, float]
    outline: tuple[float, float]


def fits(track: Curve, outline: Curve, low: float, high: float) -> bool:
    """Whether they exclude it on a stretch of the track. An open outline has no inside and is only the contact arc."""
    return not outline.period or room(track, outline, low, high).gap > 0.0


@lru_cache(maxsize=256)
def room(track: Curve, outline: Curve, low: float, high: float) -> Room:
    """The room on a stretch of the track; a gap of 0 means that nothing is proven."""
    places = _places(track, low, high)
    bend, bends = _range(track, places), curvatures(outline)
    flat = BEND_PRECISION * bends[1]  # the computed curvature of a flat side may be slightly negative
    convex = bends[0] > max(bend[1], 0.0) or (bends[0] >= -flat and bend[1] < -flat)
    if not outline.period or not convex:
        return Room(0.0, bend, bends)  # not convex, or tighter than the track somewhere
    angles = track.tangent_angle(places)
    # A graph over the direction half-way between the extremes, or closed and convex.
    closed = track.period is not None and (bend[0] >= 0.0 or bend[1] <= 0.0)
    if not np.ptp(angles) < pi and not (closed and abs(angles[-1] - angles[0]) < 2.1 * pi):
        return Room(0.0, bend, bends)
    return Room(1.0 / bend[1] - 1.0 / bends[0] if bend[1] > 0.0 else inf, bend, bends)


def curvatures(curve: Curve) -> tuple[float, float]:
    """Bounds on the curvature of all of a curve, 1/m, however fine its features are."""
    return _range(curve, _places(curve, *curve.span))


def _places(curve: Curve, low: float, high: float) -> np.ndarray:
    """Parameters that show how the curve bends, (n,)."""
    return curve.features.nodes(low, high) if curve.features else np.array([low, high])


def _range(curve: Curve, places: np.ndarray) -> tuple[float, float]:
    """Bounds on the curvature."""
    return -_greatest(lambda s: -curve.curvature(s), places), _greatest(curve.curvature, places)


def _greatest(function: Callable[[np.ndarray], np.ndarray], places: np.ndarray) -> float:
    """An upper bound on a function that the places resolve: between two of them it exceeds both values by a part of the
    change of its slope. Intervals that may contain its maximum are sampled more finely."""
    stretches = places.reshape(1, -1)
    for _ in range(CLOSER):
        values = np.asarray(function(stretches.ravel())).reshape(stretches.shape)
        swing = np.zeros_like(values)
        if values.shape[1] > 2:
            swing[:, 1:-1] = BETWEEN * np.abs(np.diff(values, 2, axis=1))
            swing[:, [0, -1]] = swing[:, [1, -2]]
        bounds = np.maximum(values[:, :-1], values[:, 1:]) + np.maximum(swing[:, :-1], swing[:, 1:])
        if bounds.max() <= values.max():
            break
        row, first = np.nonzero(bounds > values.max())
        low, high = stretches[row, first], stretches[row, first + 1]
        stretches = low[:, None] + (high - low)[:, None] * np.linspace(0.0, 1.0, PARTS)
    return float(bounds.max())
