"""Samples of a track and an outline that are nearest to each other in a pose: where Newton's method begins."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import cos, hypot, sin

import numpy as np

from .corner import Corner, Piece
from .curves import Curve

# Samples of a track and of a smooth outline.
TRACK_SAMPLES, OUTLINE_SAMPLES = 2_000, 721


@dataclass(frozen=True, eq=False)
class TrackSamples:
    """Parameters (n,) of a track and their points (2, n)."""

    parameters: np.ndarray
    points: np.ndarray

    def nearest(self, point: np.ndarray) -> int:
        """The number of the sample that is nearest to a point."""
        return int(np.argmin(np.hypot(*(point[:, None] - self.points))))

    def nearest_to_all(self, points: np.ndarray) -> np.ndarray:
        """The same of many points (2, n)."""
        return np.asarray(self._tree.query(points.T)[1])

    @cached_property
    def _tree(self):
        from scipy.spatial import cKDTree  # slow to import, and many motions never come here

        return cKDTree(self.points.T)


def track_samples(track: Curve, x: float, y: float, size: float) -> TrackSamples:
    """Samples of the whole track; of one without ends those that a plate of that size (m) at a place may reach."""
    if track.domain or track.period:
        return _of_all(track)
    middle = 0.5 * sum(track.span)
    away = hypot(*(track.point(middle) - np.array([x, y]))) + 4.0 * size
    wide = 2.0 * away / float(track.speed(middle))
    return _between(track, middle - wide, middle + wide)


@lru_cache(maxsize=64)
def _of_all(track: Curve) -> TrackSamples:
    return _between(track, *track.span)


def _between(track: Curve, low: float, high: float) -> TrackSamples:
    parameters = np.linspace(low, high, TRACK_SAMPLES)
    return TrackSamples(parameters, track.point(parameters))


def nearest_samples(track: Curve, outline: Piece, x: float, y: float, theta: float) -> list[tuple[float, float]]:
    """Parameters of samples of a track and an outline, or a corner of one, that are nearest to each other in a pose:
    each pair with a smaller gap than its neighbours, the one with the least gap along the track's normal first."""
    c, s = cos(theta), sin(theta)
    if isinstance(outline, Corner):
        point = np.array([x + c * outline.x - s * outline.y, y + s * outline.x + c * outline.y])
        samples = track_samples(track, x, y, hypot(outline.x, outline.y))
        return [(float(samples.parameters[samples.nearest(point)]), 0.5 * sum(outline.span))]
    own = np.linspace(*outline.span, OUTLINE_SAMPLES)
    u, v = outline.point(own)
    points = np.array([x + c * u - s * v, y + s * u + c * v])
    samples = track_samples(track, x, y, outline.sizes[0])
    numbers = samples.nearest_to_all(points)
    near = samples.parameters[numbers]
    gaps = ((points - samples.points[:, numbers]) * track.normal(near)).sum(axis=0)
    padded = np.concatenate([[np.inf], gaps, [np.inf]])
    if outline.period:  # the last sample is the first one
        padded[[0, -1]] = gaps[-2], gaps[1]
    least = np.flatnonzero((gaps <= padded[:-2]) & (gaps <= padded[2:]))
    return [(float(near[i]), float(own[i])) for i in least[np.argsort(gaps[least], kind="stable")]]


def opposite_samples(track: Curve, outline: Curve, x: float, y: float, theta: float) -> list[tuple[float, float]]:
    """Parameters near which a track and a smooth outline have a common normal in a pose, the pair with the least gap
    first: that of the nearest points, and others from which the same pose is as well determined."""
    c, s = cos(theta), sin(theta)
    own = np.linspace(*outline.span, OUTLINE_SAMPLES)
    u, v = outline.point(own)
    points = np.array([x + c * u - s * v, y + s * u + c * v])
    samples = track_samples(track, x, y, outline.sizes[0])
    normals, tangents = track.normal(samples.parameters), track.tangent(samples.parameters)
    lowest = np.argmin(normals.T @ points, axis=1)  # the point of the outline that is nearest along each normal
    away = points[:, lowest] - samples.points
    along, gaps = (away * tangents).sum(axis=0), (away * normals).sum(axis=0)
    changes = np.flatnonzero(along[:-1] * along[1:] <= 0.0)
    order = changes[np.argsort(gaps[changes], kind="stable")]
    return [(float(samples.parameters[k]), float(own[lowest[k]])) for k in order if gaps[k] > 0.0]
