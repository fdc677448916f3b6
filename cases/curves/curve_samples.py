"""Samples of a curve, dense enough for its features, and how they are looked up."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..formulas.features import union
from . import Curve
from .chain import Chain
from .corner import Corner

# A hundred thousand points are looked up as quickly as a thousand; more take long to lay out.
MOST = 100_000
# With more coordinates than this to compare, points are looked up in so many parts, each near fewer stretches.
TOGETHER, PARTS = 4_000_000, 32
# The curve is less than this many times as far from osculating circles as it is halfway between samples.
BLURS = 4.0
# Of distances, in parts of them.
ROUNDING = 1e-12


class SampleStretches(NamedTuple):
    """Samples of a curve in stretches of equal length, to look up which is nearest: their points (stretches, length,
    2), a centre (stretches, 2) and the farthest of them from it, m (stretches,).

    (SciPy's trees are as quick, and take a seventh of a second to import, more than a first motion does.)
    """

    points: np.ndarray
    centres: np.ndarray
    radii: np.ndarray

    @classmethod
    def of(cls, points: np.ndarray) -> SampleStretches:
        """Short ones, of the cube root of the samples' number; the last sample (n, 2) fills the last of them up."""
        length = int(np.ceil(np.cbrt(len(points))))
        fill = np.minimum(np.arange(-(-len(points) // length) * length), len(points) - 1)
        stretches = points[fill].reshape(-1, length, 2)
        centres = stretches.mean(axis=1)
        return cls(stretches, centres, np.sqrt(squares(stretches, centres[:, None]).max(axis=1)))

    def nearest(self, there: np.ndarray, ball: tuple[float, float, float] | None = None) -> np.ndarray:
        """Which sample is the nearest to each of the points (m, 2), the first of equal ones; `ball`: the middle and the
        radius of a circle around the points, where they are known.

        Stretches are looked into unless they begin farther away than another ends, whichever of the points one asks.
        """
        if len(there) > PARTS and len(there) * self.points.size > TOGETHER:
            return np.concatenate([self.nearest(part) for part in np.array_split(there, PARTS)])
        if ball is None:
            middle = there.mean(axis=0)
            ball = (*middle.tolist(), float(np.sqrt(squares(there, middle).max())))
        x, y, radius = ball
        away = np.hypot(self.centres[:, 0] - x, self.centres[:, 1] - y)
        most = (float((away + self.radii).min()) + 2.0 * radius) * (1.0 + ROUNDING)
        some = (away - self.radii <= most).nonzero()[0]
        index = squares(self.points[some].reshape(-1, 2), there[:, None]).argmin(axis=1)
        length = self.points.shape[1]
        return some[index // length] * length + index % length


def squares(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Squares of distances of points, m²; coordinates are the last axis."""
    x, y = a[..., 0] - b[..., 0], a[..., 1] - b[..., 1]
    return x * x + y * y


class CurveSamples(NamedTuple):
    """Samples of a curve: parameters, how far from each the next ones are, the same in m, points (n, 2), left normals
    (n, 2), curvatures, the points in stretches to look them up in, and which samples show features."""

    parameters: np.ndarray
    widths: np.ndarray
    spacings: np.ndarray
    points: np.ndarray
    normals: np.ndarray
    bends: np.ndarray
    stretches: SampleStretches
    ball: tuple[float, float, float]
    blur: float

    @classmethod
    def of(cls, curve: Curve, low: float, high: float, count: int) -> CurveSamples:
        """So many samples at even distances along the curve, more for ripples, and what shows its features besides."""
        resolving = _resolving(curve, low, high)
        parameters = curve.even(low, high, max(count, resolving))
        if curve.features and resolving <= count:
            parameters = union(parameters, curve.features.places(low, high))
        corners = [one.middle + one.shift for one in curve.elements if isinstance(one.piece, Corner)]
        parameters = union(parameters, corners) if corners else parameters
        parameters = parameters[np.isfinite(curve.point(parameters)).all(axis=0)]
        gaps = np.diff(parameters)
        widths = np.maximum(np.append(gaps, gaps[-1]), np.insert(gaps, 0, gaps[0]))
        if curve.period:  # the two ends are one point
            parameters, widths = parameters[:-1], widths[:-1]
        points, normals, bends, speeds = course(curve, parameters)
        middle = points.mean(axis=0)
        ball = (*middle.tolist(), float(np.sqrt(squares(points, middle).max())))
        halfway = curve.point(parameters[:-1] + 0.5 * np.diff(parameters)).T
        blur = BLURS * float(np.abs(osculating_distances(halfway - points[:-1], normals[:-1], bends[:-1])).max())
        return cls(parameters, widths, widths * speeds, points, normals, bends, SampleStretches.of(points), ball, blur)

    def off(self, there: np.ndarray, places: np.ndarray) -> np.ndarray:
        """How far (m, positive on the left) the points (m, 2) are off the curve near those samples."""
        return osculating_distances(there - self.points[places], self.normals[places], self.bends[places])


def _resolving(curve: Curve, low: float, high: float) -> int:
    """The number of even samples that resolve features of one scale; 0 if there are several scales."""
    intervals = curve.features.intervals_of_one_scale(low, high) if curve.features else 0
    return min(MOST, intervals + 1) if intervals else 0


def course(curve: Curve, parameters: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Points (n, 2), left normals (n, 2), curvatures (n,) and speeds (n,) of a curve; at corners the curvature is 0."""
    if isinstance(curve, Chain):
        bends = curve.curvature(parameters)
        bends = np.where(np.isfinite(bends), bends, 0.0)
        return curve.point(parameters).T, curve.normal(parameters).T, bends, curve.speed(parameters)
    _, _, xp, yp, xs, ys, _, _ = jets = curve.jets(parameters)
    speed = np.hypot(xp, yp)
    return jets[:2].T, np.column_stack([-yp, xp]) / speed[:, None], (xp * ys - yp * xs) / speed**3, speed


def osculating_distances(from_point: np.ndarray, normals: np.ndarray, bends: np.ndarray) -> np.ndarray:
    """The distances of places, seen from points of a curve (m, 2), from the circles that osculate it there, m, positive
    on its left.

    A sample may be half a sample's distance from the nearest point, so distances along its normal are too small by that
    times the angle between the normals.
    """
    (nx, ny), (dx, dy) = normals.T, from_point.T
    twice = 2.0 * (dx * nx + dy * ny) - bends * (dx * dx + dy * dy)
    return twice / (1.0 + np.sqrt(np.maximum(1.0 - bends * twice, 0.0)))
