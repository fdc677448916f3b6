"""The point of a track nearest to a closed outline, by lower bounds on the gap of each of its ripples.

Of ripples finer than the samples of the outline, the feet of those samples show only some; and between two samples an
outline is farther from the circle that osculates it than ripples are high. So the points of the track are looked up on
the outline, each by Newton's method, and all remain of which the gap may be the smallest.
"""

from __future__ import annotations

from math import inf
from typing import NamedTuple

import numpy as np

from ..curves import Curve
from ..curves.curve_samples import CurveSamples

# Newton's method for feet on the outline: from half a sample's distance to rounding, of which the gap is the square.
FOOT_STEPS = 5
# Between samples a curvature is less than this many times the largest of three neighbours (five to a ripple: 1.3).
BENDS = 2.0
# While the bounds leave several, each is looked at among so many points, that much closer; so often at most, and until
# bounds are as close as this, in parts of the distances that a gap is the difference of.
CLOSER, ROUNDS, LEVEL = 8, 40, 1e-15


class TrackPoint(NamedTuple):
    """A point of the track, its foot on the outline, and the gap between them (m, negative inside); and how far the
    nearest points looked at are from it: in the track's parameter, and in m."""

    xi1: float
    xi2: float
    gap: float
    width: float
    spacing: float


class _Points(NamedTuple):
    """Points of the track, of arrays (n,): parameters, feet on the outline, gaps (m), how far the next points are (in
    the parameter, and in m), and bounds on the second derivative of the gap along the track (1/m)."""

    xi1: np.ndarray
    xi2: np.ndarray
    gap: np.ndarray
    width: np.ndarray
    spacing: np.ndarray
    bend: np.ndarray

    @property
    def low(self) -> np.ndarray:
        """Bounds on the gap from below as far as halfway to the next points, m: at its minimum its rate vanishes."""
        return self.gap - 0.125 * self.bend * self.spacing**2

    def take(self, which: np.ndarray) -> _Points:
        return _Points(*(column[which] for column in self))


class PlateFrame(NamedTuple):
    """The frame of a plate: its origin, and the cosine and the sine of its angle."""

    x: float
    y: float
    c: float
    s: float

    def place(self, points: np.ndarray) -> np.ndarray:
        """Points (n, 2) of the plate in the plane."""
        u, v = points.T
        return np.column_stack([self.x + self.c * u - self.s * v, self.y + self.s * u + self.c * v])

    def local(self, points: np.ndarray) -> np.ndarray:
        """Points (n, 2) of the plane in the plate's frame."""
        u, v = points[:, 0] - self.x, points[:, 1] - self.y
        return np.column_stack([self.c * u + self.s * v, self.c * v - self.s * u])


def nearest_track_point(
    track: Curve, samples: CurveSamples, outline: Curve, around: CurveSamples, frame: PlateFrame, most: float
) -> TrackPoint | None:
    """The point of the track with the smallest gap to the closed outline, no larger than `most` (m), ends of the track
    excepted; None if there is none.

    `samples` of the track, `around` of the outline: dense enough for their features.
    """
    near = _near(samples, around, frame, most)
    if not track.period:
        near = near[(near > 0) & (near < len(samples.parameters) - 1)]
    if not near.size:
        return None
    local = frame.local(samples.points[near])
    places = around.stretches.nearest(local)
    rough, spacing = -around.off(local, places), samples.spacings[near]
    bend = _bend(samples, near, around, places, rough)
    close = rough - 0.125 * bend * spacing**2 - 2.0 * around.blur <= rough.min()
    near, places = near[close], places[close]
    xi2, gap = _feet(outline, around, local[close], places)
    points = _Points(samples.parameters[near], xi2, gap, samples.widths[near], spacing[close], bend[close])
    points = points.take(_least_of_neighbours(near, gap))
    level = LEVEL * (abs(frame.x) + abs(frame.y) + float(around.spacings.sum()))
    for _ in range(ROUNDS):
        points = points.take(points.low <= points.gap.min())
        if len(points.gap) == 1 or float((points.gap - points.low).max()) <= level:
            break
        points = _closer(track, outline, around, frame, points)
    best = int(np.argmin(points.gap))
    return TrackPoint(*(float(column[best]) for column in points[:5]))


def _near(samples: CurveSamples, around: CurveSamples, frame: PlateFrame, most: float) -> np.ndarray:
    """Which samples lie in stretches whose gap to the outline may be the smallest, and is at most that (m)."""
    stretches, (mx, my, radius) = samples.stretches, around.ball
    local = frame.local(stretches.centres)
    some = np.flatnonzero(np.hypot(local[:, 0] - mx, local[:, 1] - my) <= radius + stretches.radii + most)
    if not some.size:
        return some
    gap, reach = -around.off(local[some], around.stretches.nearest(local[some])), stretches.radii[some] + around.blur
    some = some[gap - reach <= min(most, float((gap + reach).min()))]
    length = stretches.points.shape[1]
    near = (some[:, None] * length + np.arange(length)).ravel()
    return near[near < len(samples.parameters)]


def _bend(samples: CurveSamples, near, around: CurveSamples, places, gap) -> np.ndarray:
    """Bounds on the second derivative of the gap along the track, 1/m: its curvature, and that of a curve at a constant
    distance from the outline."""
    along = BENDS * _largest_of_three(np.abs(samples.bends), near)
    level = BENDS * _largest_of_three(np.maximum(around.bends, 0.0), places)
    return along + level / (1.0 + level * np.maximum(gap, 0.0))


def _largest_of_three(values: np.ndarray, places: np.ndarray) -> np.ndarray:
    return np.maximum(np.maximum(values[places - 1], values[places]), values[(places + 1) % len(values)])


def _feet(outline: Curve, around: CurveSamples, local: np.ndarray, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The outline's parameters nearest to points in its frame (n, 2), starting at samples, and the gaps, m."""
    start, width = around.parameters[places], around.widths[places]
    xi2 = start
    for _ in range(FOOT_STEPS):
        u, v, up, vp, us, vs, _, _ = outline.jets(xi2)
        du, dv = u - local[:, 0], v - local[:, 1]
        slope, bend = du * up + dv * vp, up * up + vp * vp + du * us + dv * vs
        step = np.divide(slope, bend, out=np.zeros_like(slope), where=bend > 0.0)
        xi2 = np.clip(xi2 - step, start - width, start + width)
    u, v, up, vp, *_ = outline.jets(xi2)
    du, dv = u - local[:, 0], v - local[:, 1]
    return xi2, np.copysign(np.hypot(du, dv), du * -vp + dv * up)


def _least_of_neighbours(near: np.ndarray, gap: np.ndarray) -> np.ndarray:
    """Which of the samples are not farther than the one before and the one behind them, if these are there."""
    together = np.diff(near) == 1
    before = np.where(np.append(False, together), np.append(inf, gap[:-1]), inf)
    behind = np.where(np.append(together, False), np.append(gap[1:], inf), inf)
    return (gap <= before) & (gap <= behind)


def _closer(track: Curve, outline: Curve, around: CurveSamples, frame: PlateFrame, points: _Points) -> _Points:
    """The nearest of closer points around each one."""
    xi1 = points.xi1[:, None] + points.width[:, None] * np.linspace(-1.0, 1.0, 2 * CLOSER + 1)
    if track.ends:
        xi1 = np.clip(xi1, *track.ends)
    local = frame.local(track.point(xi1.ravel()).T)
    xi2, gap = (column.reshape(xi1.shape) for column in _feet(outline, around, local, around.stretches.nearest(local)))
    best = np.arange(len(xi1)), gap.argmin(axis=1)
    return _Points(xi1[best], xi2[best], gap[best], points.width / CLOSER, points.spacing / CLOSER, points.bend)
