"""Samples of a track and an outline that are nearest to each other in a pose: where Newton's method begins."""

from __future__ import annotations

from functools import lru_cache
from math import ceil, cos, hypot, inf, log2, sin
from typing import NamedTuple

import numpy as np

from ..curves import Curve
from ..curves.corner import Corner, Piece
from ..curves.curve_samples import MOST, CurveSamples
from ..curves.outline import sizes_of
from .nearest_track_point import PlateFrame

# Number of samples of the outline: so dense that a smooth outline is unlikely to have a nearer point between two of
# them. Newton's method starts at the nearest sample.
OUTLINE_POINTS = 128
# Points of the track to a size of the plate.
POINTS_A_SIZE = 24
# A track without ends is looked at for at least so many sizes of the plate to either side of the start; while the plate
# is nearest to an end of that, for twice as many, so often at most.
AROUND, DOUBLINGS = 16.0, 40
# Around a corner alone samples of a track with ends are about this part of its size apart, times POINTS_A_SIZE.
PARTS = 32


class CurvesInPose(NamedTuple):
    """A track and an outline in a pose, and a parameter of the track near which a track without ends is looked at."""

    track: Curve
    outline: Piece
    x: float
    y: float
    theta: float
    xi1: float

    @property
    def frame(self) -> PlateFrame:
        return PlateFrame(self.x, self.y, cos(self.theta), sin(self.theta))

    @property
    def size(self) -> float:
        """What the track's samples are close to, m: the outline's size; pieces and corners of an outline share those of
        another size."""
        if self.outline.period:
            return sizes_of(self.outline).width
        if self.track.domain is not None or self.track.period:
            return sizes_of(self.track).width / PARTS
        reach = float(np.hypot(*self.outline.point(self.outline.span[0])))
        away = hypot(*(self.track.point(self.xi1) - (self.x, self.y))) + reach
        return 2.0 ** ceil(log2(away)) if away else 1.0  # few sizes, as samples are kept


def nearest_samples(track: Curve, outline: Piece, x: float, y: float, theta: float) -> list[tuple[float, float]]:
    """Parameters of samples of a track and an outline, or a corner of one, that are nearest to each other in a pose:
    each pair with a smaller gap than its neighbours, the one with the least gap along the track's normal first."""
    scene = CurvesInPose(track, outline, x, y, theta, 0.5 * sum(track.span))
    if isinstance(outline, Corner):
        there = scene.frame.place(np.array([[outline.x, outline.y]]))
        samples, places, _ = samples_below(scene, there, (*there[0].tolist(), 0.0))
        return [(float(samples.parameters[places[0]]), 0.5 * sum(outline.span))]
    own, samples, places, _, gaps = sample_gaps(scene)
    before, behind = np.roll(gaps, 1), np.roll(gaps, -1)
    if not outline.period:
        before[0] = behind[-1] = inf
    least = np.flatnonzero((gaps <= before) & (gaps <= behind))
    order = least[np.argsort(gaps[least], kind="stable")]
    return list(zip(samples.parameters[places[order]].tolist(), own.parameters[order].tolist(), strict=True))


def opposite_samples(track: Curve, outline: Curve, x: float, y: float, theta: float) -> list[tuple[float, float]]:
    """Parameters near which a track and a smooth outline have a common normal in a pose, the pair with the least gap
    first: that of the nearest points, and others from which the same pose is as well determined."""
    scene = CurvesInPose(track, outline, x, y, theta, 0.5 * sum(track.span))
    own, samples, *_ = sample_gaps(scene)
    there, normals = scene.frame.place(own.points), samples.normals
    lowest = np.argmin(normals @ there.T, axis=1)  # the point of the outline that is nearest along each normal
    away = there[lowest] - samples.points
    along, gaps = away[:, 0] * normals[:, 1] - away[:, 1] * normals[:, 0], (away * normals).sum(axis=1)
    changes = np.flatnonzero(along[:-1] * along[1:] <= 0.0)
    order = changes[np.argsort(gaps[changes], kind="stable")]
    return [(float(samples.parameters[k]), float(own.parameters[lowest[k]])) for k in order if gaps[k] > 0.0]


def sample_gaps(scene: CurvesInPose) -> tuple[CurveSamples, CurveSamples, np.ndarray, np.ndarray, np.ndarray]:
    """Samples of the outline and of the track, which of these are nearest to each of those, whether they are ends, and
    how far they are apart along the track's normal, m."""
    outline, frame = outline_samples(scene.outline), scene.frame
    there, ((x, y),) = frame.place(outline.points), frame.place(np.array([outline.ball[:2]])).tolist()
    track, places, ends = samples_below(scene, there, (x, y, outline.ball[2]))
    return outline, track, places, ends, track.off(there, places)


def samples_below(
    scene: CurvesInPose, there: np.ndarray, ball: tuple[float, float, float]
) -> tuple[CurveSamples, np.ndarray, np.ndarray]:
    """Samples of the track, which of them are nearest to the points `there` (within that circle), and whether these
    are its ends."""
    curve, size = scene.track, scene.size
    endless = curve.domain is None and not curve.period
    low, high = _around(scene, ball, size) if endless else curve.span
    for _ in range(DOUBLINGS):
        track = track_samples(curve, low, high, size)
        places = track.stretches.nearest(there, ball)
        last = len(track.parameters) - 1
        ends = np.zeros(len(places), dtype=bool) if curve.period else (places == 0) | (places == last)
        whole = not endless or (track.parameters[0] > low and track.parameters[-1] < high)
        if whole or not ends.any():
            break
        low, high = low - 0.5 * (high - low), high + 0.5 * (high - low)
    return track, places, ends


def _around(scene: CurvesInPose, ball: tuple[float, float, float], size: float) -> tuple[float, float]:
    """The stretch of a track without ends that is looked at first: some sizes of the plate to either side of the start,
    as many times doubled as the plate is farther away."""
    xi1, (x, y, _) = scene.xi1, ball
    X, Y, Xp, Yp = scene.track.jet(xi1)[:4]
    away = hypot(x - X, y - Y) / (AROUND * size)
    margin = AROUND * size / hypot(Xp, Yp) * 2.0 ** ceil(log2(max(2.0 * away, 1.0)))
    return xi1 - margin, xi1 + margin


@lru_cache(maxsize=64)
def outline_samples(outline: Curve) -> CurveSamples:
    return CurveSamples.of(outline, *outline.span, OUTLINE_POINTS + 1)


@lru_cache(maxsize=64)
def track_samples(track: Curve, low: float, high: float, size: float) -> CurveSamples:
    length = track.length(low, high)
    return CurveSamples.of(track, low, high, int(min(MOST, max(720, POINTS_A_SIZE * length / size))))
