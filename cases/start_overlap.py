"""Whether a plate overlaps its track in one pose, to rounding: by the distance of the track's points from the outline.

`cases.overlap` looks at many poses, and sees what is deeper than the sagitta of a polygon. Here the track is sampled so
closely that curvatures of both curves are resolved, the distances of samples near the outline are exact, and where one
is least Newton's method locates the least distance in between.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from . import geometry
from .chain import Chain
from .curves import Curve
from .errors import DoesNotFit
from .features import POINTS, union
from .overlap import CORNERS, FEWEST, span

# A gap is an overlap if it is more negative than this part of the plate's size and place: the rounding of a pose.
ROUNDING = 1e-12
# The closest even samples of a track, in parts of the plate's reach, the most of them, and those with which its
# stretches near the plate are found.
CLOSEST, MOST, POINTS_A_REACH = 1e-4, 20_000, 64
# Pairs of a point and a corner that are tested together: some megabytes.
TOGETHER = 1_000_000
# Corners of a polygon at parameters closer than this part of the period are one.
SAME = 1e-9
# Newton's steps to the foot of a point that is a sagitta away from the outline: each squares the error.
STEPS = 4
# At most this many of the least distances are looked at, the smallest first: curves that nearly coincide have as many
# as there are samples, by rounding.
TRIES = 32
# The pair that Newton's method finds belongs to a sample if it is no more of the samples' distances away.
NEIGHBOURS = 2.0


class Overlap(NamedTuple):
    """How deep a plate overlaps its track (m), and at which parameter of the track."""

    depth: float
    xi1: float


class _OutlinePolygon(NamedTuple):
    """A polygon that resolves an outline: parameters (n,) and corners (2, n) of its sides' starts, `middle` (2, 1) and
    the rising `angles` (n,) of the corners about it (None where they do not rise), a bound on its distance from the
    outline (m), the outline's largest curvature (1/m), whether it bends to its left everywhere, and the median side and
    the farthest corner (m)."""

    parameters: np.ndarray
    corners: np.ndarray
    middle: np.ndarray
    angles: np.ndarray | None
    sagitta: float
    bend: float
    is_convex: bool
    side: float
    reach: float

    def nearest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """A corner near each of the points (2, m), and a bound on how far outside the polygon they are, m (negative
        inside)."""
        if self.angles is None:
            corner, away = np.zeros(points.shape[1], dtype=int), np.zeros(points.shape[1])
            for some in np.array_split(np.arange(points.shape[1]), 1 + self.corners.size * points.shape[1] // TOGETHER):
                apart = np.hypot(*(points[:, some, None] - self.corners[:, None]))
                corner[some], away[some] = apart.argmin(axis=1), apart.min(axis=1)
            return corner, np.maximum(away - self.side, 0.0)
        (x, y), number = points - self.middle, len(self.angles)
        corner = (np.searchsorted(self.angles, np.arctan2(y, x)) - 1) % number
        (ax, bx), (ay, by) = ((row[corner], row[(corner + 1) % number]) for row in self.corners)
        px, py = points
        return corner, ((px - ax) * (by - ay) - (py - ay) * (bx - ax)) / np.hypot(bx - ax, by - ay)


def deepest_overlap(track: Curve, outline: Curve, x: float, y: float, theta: float, xi1: float) -> Overlap | None:
    """The deepest overlap of a plate in that pose with its track, or None if there is none; `xi1`: where it is near.

    Smooth curves only: None for a curve with corners or an open outline.
    """
    if isinstance(track, Chain) or isinstance(outline, Chain) or not outline.period:
        return None
    polygon, pose, deepest = _polygon(outline), (x, y, theta), None
    rounding = ROUNDING * (abs(x) + abs(y) + polygon.reach)
    for coarse in _stretches(track, polygon, pose, xi1):
        parameters = _finer(track, polygon, *coarse)
        distances, feet = _distances(track, outline, polygon, pose, parameters)
        before, after = np.append(np.inf, distances[:-1]), np.append(distances[1:], np.inf)
        # Evenly spaced samples of a parabola show half of its second difference next to the lowest one, and it is lower
        # between them by at most an eighth.
        is_least = np.isfinite(distances) & (distances < after) & (distances <= before)
        dips = np.maximum(before, after)[is_least] - distances[is_least]
        places = np.flatnonzero(is_least)[distances[is_least] - dips < -rounding]
        for i in places[np.argsort(distances[places])][:TRIES].tolist():
            one = Overlap(-float(distances[i]), float(parameters[i]))
            if np.isfinite(feet[i]):
                width = float(np.ptp(parameters[max(i - 1, 0) : i + 2]))
                one = max(one, _between(track, outline, pose, (one.xi1, float(feet[i])), width) or one)
            if one.depth > rounding and (deepest is None or one > deepest):
                deepest = one
    return deepest


def meets_once(track: Curve, outline: Curve) -> bool:
    """Whether the track is a straight line and the outline so convex that one point of it has the line's direction."""
    smooth = not isinstance(track, Chain) and not isinstance(outline, Chain)
    return smooth and track.features is None and bool(outline.period) and _polygon(outline).is_convex


def _between(
    track: Curve, outline: Curve, pose: tuple[float, float, float], near: tuple[float, float], width: float
) -> Overlap | None:
    """The depth at the nearest pair of points next to a pair of samples; None if there is none within the samples'
    distance on the track."""
    try:
        contact = geometry.find(track, outline, *pose, near)
    except DoesNotFit:
        return None
    low, high = track.ends or (-np.inf, np.inf)
    is_near = abs(contact.xi1 - near[0]) <= NEIGHBOURS * width and low <= contact.xi1 <= high
    return Overlap(-contact.gap, contact.xi1) if is_near else None


def _stretches(
    track: Curve, polygon: _OutlinePolygon, pose: tuple[float, float, float], xi1: float
) -> list[tuple[np.ndarray, float]]:
    """The stretches of the track that may be inside the plate, by their coarse samples (n,), and the largest distance
    of two of these, m: none of them is farther from the plate than the next one from it."""
    parameters, points = _coarse(track, *span(track, np.array([xi1]), polygon.reach), polygon.reach)
    apart = np.hypot(*np.diff(points, axis=1))
    spacing = np.maximum(np.append(apart, 0.0), np.append(0.0, apart))
    near = np.flatnonzero(np.hypot(points[0] - pose[0], points[1] - pose[1]) <= polygon.reach + spacing)
    near = near[polygon.nearest(_in_plate(points[:, near], pose))[1] <= spacing[near] + polygon.sagitta]
    runs = np.split(near, np.flatnonzero(np.diff(near) > 2) + 1) if near.size else []
    ends = [(max(run[0] - 1, 0), run[-1] + 2) for run in runs]
    return [(parameters[first:last], float(apart[first : last - 1].max())) for first, last in ends]


def _in_plate(points: np.ndarray, pose: tuple[float, float, float]) -> np.ndarray:
    """Points (2, n) in the plate's frame."""
    (x, y, theta), (px, py) = pose, points
    c, s = np.cos(theta), np.sin(theta)
    return np.array([c * (px - x) + s * (py - y), c * (py - y) - s * (px - x)])


def _finer(track: Curve, polygon: _OutlinePolygon, coarse: np.ndarray, apart: float) -> np.ndarray:
    """Parameters on a stretch of the track that resolve both curves, evenly between its coarse samples."""
    parts = apart / max(polygon.side, CLOSEST * polygon.reach)
    if track.features:
        low, high = float(coarse[0]), float(coarse[-1])
        inner = np.diff(track.features.edges(low, high)[1:-1])
        finest = min(track.features.piece_length(low), track.features.piece_length(high), *inner.tolist())
        parts = max(parts, float(np.diff(coarse).max()) * POINTS / finest)
    count = int(np.ceil(min(parts, MOST / len(coarse)))) if parts > 1.0 else 1
    return np.interp(np.arange((len(coarse) - 1) * count + 1) / count, np.arange(len(coarse)), coarse)


def _distances(
    track: Curve, outline: Curve, polygon: _OutlinePolygon, pose: tuple[float, float, float], parameters: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The distances (m, negative inside) of the track's points from the outline, and the outline's parameters there.

    Points that are so far outside that none next to them is inside have the distance infinity, points far inside one to
    a polygon, and both have no parameter.
    """
    points = _in_plate(track.point(parameters), pose)
    spacing = float(np.hypot(*np.diff(points, axis=1)).max())
    bend = polygon.bend + float(np.abs(track.curvature(parameters)).max())
    corner, distances = polygon.nearest(points)
    # A parabola through samples is lower between two of them by at most an eighth of bend · spacing².
    near = 2.0 * (polygon.sagitta + bend * spacing**2 / 8.0)
    some, feet = np.flatnonzero(np.abs(distances) <= near + CLOSEST * polygon.reach), np.full(len(parameters), np.nan)
    distances[distances > near] = np.inf
    own, px, py = polygon.parameters[corner[some]], *points[:, some]
    for _ in range(STEPS):
        u, v, up, vp, us, vs, _, _ = outline.jets(own)
        own = own - ((px - u) * up + (py - v) * vp) / ((px - u) * us + (py - v) * vs - up * up - vp * vp)
    u, v, up, vp, *_ = outline.jets(own)
    distances[some], feet[some] = ((px - u) * vp - (py - v) * up) / np.hypot(up, vp), own
    return distances, feet


@lru_cache(maxsize=64)
def _polygon(outline: Curve) -> _OutlinePolygon:
    low, high = outline.span
    parameters = np.linspace(low, high, CORNERS + 1)
    if outline.features:
        parameters = union(parameters, outline.features.nodes(low, high))
        parameters = parameters[np.append(True, np.diff(parameters) > SAME * (high - low))]
    points, angles = outline.point(parameters), outline.tangent_angle(parameters)
    sides = np.hypot(*np.diff(points, axis=1))
    sagitta = float((sides * np.abs(np.diff(angles))).max()) / 4.0
    bends = outline.curvature(parameters)
    parameters, corners = parameters[:-1], points[:, :-1]
    middle = corners[:, :: max(1, len(parameters) // CORNERS)].mean(axis=1, keepdims=True)
    polar = np.arctan2(corners[1] - middle[1], corners[0] - middle[0])
    first = int(np.argmin(polar))
    parameters, corners, polar = (np.roll(row, -first, axis=-1) for row in (parameters, corners, polar))
    rises = bool(np.all(np.diff(polar) > 0.0))
    reach = float(np.hypot(*corners).max())
    return _OutlinePolygon(
        parameters, corners, middle, polar if rises else None, sagitta, float(np.abs(bends).max()),
        bool(bends.min() > 0.0), _middle(sides), reach,
    )  # fmt: skip


def _middle(values: np.ndarray) -> float:
    """The median. (`np.median` imports NumPy's masked arrays, which takes as long as the rest of a first start.)"""
    return float(np.sort(values)[[(len(values) - 1) // 2, len(values) // 2]].mean())


@lru_cache(maxsize=64)
def _coarse(track: Curve, low: float, high: float, reach: float) -> tuple[np.ndarray, np.ndarray]:
    """Parameters (n,) and points (2, n) of a track, some to a size of the plate."""
    length = track.length(low, high)
    parameters = track.even(low, high, int(min(MOST, max(FEWEST, POINTS_A_REACH * length / reach))))
    points = track.point(parameters)
    # Far out on a track without ends its points may be too large for a double: nothing meets them.
    there = np.isfinite(points).all(axis=0)
    return parameters[there], points[:, there]
