"""Whether a plate overlaps its track anywhere, in many poses at once, or in one pose to rounding.

In many poses the plate is replaced by a polygon inside its convex outline, so a reported overlap is real and deeper
than the polygon's sagitta. In one pose the nearest points decide. An open outline encloses nothing and overlaps
nothing. Polygons and samples are cached by curve.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import ceil, floor, hypot, inf, log2, nan
from typing import NamedTuple

import numpy as np

from ..curves import Curve
from ..curves.chain import Chain
from ..curves.corner import Corner
from ..curves.outline import sizes_of
from ..formulas.features import union
from .close_pairs import nearest_on
from .element_pairs import in_frame, nearest_on_elements
from .geometry import Contact
from .nearest import nearest_pair

# Number of corners of the polygon, in addition to those that resolve the outline's features.
CORNERS = 720
# Between two corners of a chain's polygon the tangent turns by at most this, rad.
CHAIN_TURN = 0.01
# Number of track samples per size of the plate, the fewest and the most, in addition to those for the track's features.
POINTS_A_SIZE, FEWEST, MOST = 16, 720, 20_000
# Number of pairs of a pose and a track point that are tested together: some megabytes.
TOGETHER = 100_000
# Cells of a column are counted within this.
COLUMN = 2**31
# A gap is an overlap if it is more negative than this part of the plate's size and place: the rounding of a pose.
ROUNDING = 1e-12
# An overlap below this part of the plates' size and place is the error of a motion that begins again in one of its
# states, and the plates touch: three times the largest in 60 motions of several plates at the default tolerance.
OVERLAPS = 1e-9
# An outline's reach is known by its samples: it is at most BEYOND times that. Points farther away than FARTHER times it
# have bounds on their distances.
BEYOND, FARTHER = 1.001, 2.0


class SeenPolygon(NamedTuple):
    """Corners (2, n) about `middle` (2, 1), seen from there at rising `angles` (n,); None where these do not rise."""

    corners: np.ndarray
    middle: np.ndarray
    angles: np.ndarray | None
    reach: float
    size: float

    def holds(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Whether points in the plate's frame lie inside."""
        x, y = x - self.middle[0], y - self.middle[1]
        if self.angles is None:
            return _even_odd(x, y, self.corners)
        sector = np.searchsorted(self.angles, np.arctan2(y, x)) % len(self.angles)
        (ax, bx), (ay, by) = ((row[sector - 1], row[sector]) for row in self.corners)
        return (bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0.0


@dataclass(frozen=True, eq=False)
class _OutlineSamples:
    """Track parameters (n,) and their points (2, n), sorted into square cells of that size, m."""

    parameters: np.ndarray
    points: np.ndarray
    cell: float

    def _cells(self, points: np.ndarray) -> np.ndarray:
        """Column and row of points' cells, whole numbers; far out several share one, and distances separate them."""
        return np.clip(np.floor(points / self.cell), -COLUMN / 4, COLUMN / 4).astype(np.int64)

    @cached_property
    def _sorted(self) -> tuple[np.ndarray, np.ndarray]:
        """The cells' numbers in rising order, column by column, and which sample each belongs to."""
        column, row = self._cells(self.points)
        cells = column * COLUMN + row
        order = np.argsort(cells, kind="stable")
        return cells[order], order

    def around(self, centres: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """For centres (2, m): where the samples in the three cells of three columns begin and end, each (m, 3)."""
        cells, _ = self._sorted
        column, row = self._cells(centres)
        middle = (column[:, None] + np.array([-1, 0, 1])) * COLUMN + row[:, None]
        return np.searchsorted(cells, middle - 1), np.searchsorted(cells, middle + 1, side="right")

    def of(self, starts: np.ndarray, counts: np.ndarray) -> np.ndarray:
        """The samples of stretches of the order of cells, one after the other."""
        stretch = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
        return self._sorted[1][np.repeat(starts, counts) + stretch]


def first_overlap(
    track: Curve, outline: Curve, x: np.ndarray, y: np.ndarray, theta: np.ndarray, xi1: np.ndarray
) -> tuple[int, float] | None:
    """The first of n poses in which the plate overlaps its track, with a track parameter inside the plate; or None.

    `xi1` (n,): where it touches or is near, which says how far to look on a track without ends.
    """
    if not outline.period:
        return None
    polygon = polygon_of(outline)
    samples = _samples(track, *span(track, xi1, polygon.reach), polygon.size, polygon.reach)
    c, s = np.cos(theta), np.sin(theta)
    mx, my = polygon.middle
    centres = np.array([x + c * mx - s * my, y + s * mx + c * my])
    starts, ends = samples.around(centres)
    batch = np.cumsum((ends - starts).sum(axis=1)) // TOGETHER
    for number in union(batch):
        some = np.flatnonzero(batch == number)
        counts = (ends[some] - starts[some]).ravel()
        point = samples.of(starts[some].ravel(), counts)
        pose = np.repeat(np.repeat(some, 3), counts)
        # Squares, and row by row: most pairs end here.
        off_x, off_y = (row[point] - middle[pose] for row, middle in zip(samples.points, centres, strict=True))
        near = np.flatnonzero(off_x * off_x + off_y * off_y <= polygon.reach**2)
        pose, point = pose[near], point[near]
        u, v = samples.points[0, point] - x[pose], samples.points[1, point] - y[pose]
        inside = polygon.holds(c[pose] * u + s[pose] * v, c[pose] * v - s[pose] * u)
        if inside.any():
            first = pose[inside].min()
            return int(first), float(samples.parameters[point[inside & (pose == first)].min()])
    return None


def deepest_overlap(track: Curve, outline: Curve, x: float, y: float, theta: float, xi1: float) -> Contact | None:
    """The deepest overlap of a plate in that pose with its track, or None if there is none; `xi1`: where it is near.

    None for an open outline, and where the nearest points are at an end of the track. Raises DoesNotFit if the nearest
    points are not found.
    """
    if not outline.period:
        return None
    rounding = ROUNDING * (abs(x) + abs(y) + sizes_of(outline).reach)
    some = nearest_on_elements(track, outline, x, y, theta, -rounding)
    return some[0] if some and some[0].gap < -rounding else None


def overlaps(curve: Curve, outline: Curve, x: float, y: float, theta: float) -> bool:
    """Whether a plate in a pose overlaps a curve, on whose left it belongs, by more than the error of a motion."""
    if isinstance(curve, Chain) or curve.features is not None or curve.domain is not None:
        pose = (np.array([value]) for value in (x, y, theta, nearest_on(curve, x, y)))
        if first_overlap(curve, outline, *pose) is not None:
            return True
    pair, least = nearest_pair(curve, outline, x, y, theta), OVERLAPS * (abs(x) + abs(y) + sizes_of(outline).reach)
    return (pair is not None and pair.gap < -least) or deepest_end(curve, outline, x, y, theta)[0] > least


def deepest_end(curve: Curve, outline: Curve, x: float, y: float, theta: float) -> tuple[float, float]:
    """How deep an end of an open curve lies inside a plate in a pose (m, negative: outside), and the curve's parameter
    there, of the end that is deepest; −∞ and NaN of a curve without ends, or an outline without inside."""
    depths = [(-inf, nan)]
    for end in (curve.ends or ()) if outline.period else ():
        u, v = map(float, curve.point(end))
        depths.append((depth_inside(outline, *in_frame(u, v, (x, y, theta))), float(end)))
    return max(depths)


def depth_inside(outline: Curve, u: float, v: float) -> float:
    """How deep a point in the plate's frame lies inside a closed outline: its distance from it (m), negative outside.
    Of a point that is farther from the origin than FARTHER times the outline a bound."""
    if (far := hypot(u, v)) > FARTHER * (reach := sizes_of(outline).reach):
        return BEYOND * reach - far
    foot = nearest_on(outline, u, v)
    away, element = outline.point(foot) - (u, v), outline.element_at(foot)
    following = outline.element(element.number + 1)
    if following is not None and isinstance(following.piece, Corner) and foot >= np.nextafter(following.start, -inf):
        element = following
    if isinstance(element.piece, Corner):  # seen from the middle of its angle: from anywhere next to it
        foot = element.middle + element.shift
    return float(np.copysign(np.hypot(*away), -away @ outline.normal(foot)))


@lru_cache(maxsize=64)
def polygon_of(outline: Curve) -> SeenPolygon:
    """A polygon inside a closed outline: its corners, and more where it has features."""
    low, high = outline.span
    if isinstance(outline, Chain):
        places = outline.vertices(CHAIN_TURN)
        places = places[np.insert(np.hypot(*np.diff(outline.point(places), axis=1)) > 0.0, 0, True)]
    else:
        places = np.linspace(low, high, CORNERS + 1)
    if outline.features:
        places = union(places, outline.features.places(low, high))
    corners = outline.point(places[:-1])
    # In a hollow a chord is outside by its sagitta, and this moves it inside.
    bends, sides = outline.curvature(places[:-1]), np.hypot(*(np.roll(corners, -1, axis=1) - corners))
    hollow = np.where(np.isfinite(bends), np.maximum(-bends, 0.0), 0.0)
    corners = corners + outline.normal(places[:-1]) * hollow * np.maximum(sides, np.roll(sides, 1)) ** 2 / 7.0
    middle = corners[:, :: max(1, len(corners[0]) // CORNERS)].mean(axis=1, keepdims=True)
    # The contact point itself may be a corner; a billionth of the size keeps it outside whatever its rounding.
    corners = (1 - 1e-9) * (corners - middle)
    angles = np.arctan2(corners[1], corners[0])
    first = int(np.argmin(angles))
    corners, angles = np.roll(corners, -first, axis=1), np.roll(angles, -first)
    reach = float(np.hypot(*corners).max())
    size = float(np.ptp(corners, axis=1).max())
    return SeenPolygon(corners, middle, angles if np.all(np.diff(angles) > 0.0) else None, reach, size)


@lru_cache(maxsize=64)
def _samples(track: Curve, low: float, high: float, size: float, reach: float) -> _OutlineSamples:
    """Track parameters about a sixteenth of `size` apart, within what stays quick to look at, in cells of `reach`."""
    length = float(np.mean(track.speed(np.linspace(low, high, 65)))) * (high - low)
    resolving = track.features.intervals_of_one_scale(low, high) if track.features else 0
    count = max(FEWEST, POINTS_A_SIZE * length / size, resolving)
    places = np.linspace(low, high, int(min(MOST, count)))
    if isinstance(track, Chain):
        places = union(places, track.vertices(CHAIN_TURN))
    if track.features:
        places = union(places, track.features.places(low, high))
    points = track.point(places)
    # Far out on a track without ends its points may be too large for a double: nothing meets them.
    there = np.isfinite(points).all(axis=0)
    return _OutlineSamples(places[there], points[:, there], reach)


def span(track: Curve, xi1, reach: float) -> tuple[float, float]:
    """The stretch of the track that a plate may meet which touches it at `xi1` (n,) and reaches so far (m).

    Of a track without ends it is rounded up to powers of two, so that what is worked out for it is kept.
    """
    if track.domain is not None or track.period:
        return track.span
    first, last = float(np.min(xi1)), float(np.max(xi1))
    first -= 4.0 * reach / float(track.speed(first))
    last += 4.0 * reach / float(track.speed(last))
    width = 2.0 ** ceil(log2(last - first))
    low = width * floor(first / width)
    return low, low + 2.0 * width


def _even_odd(px: np.ndarray, py: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Even–odd rule for many points and one polygon of shape (2, n); only points in its box are looked at closely."""
    box = (px >= corners[0].min()) & (px <= corners[0].max()) & (py >= corners[1].min()) & (py <= corners[1].max())
    result = np.zeros(px.shape, dtype=bool)
    (ax, ay), (bx, by) = corners, np.roll(corners, -1, axis=1)
    for some in np.array_split(np.flatnonzero(box), 1 + box.sum() * len(ax) // 4_000_000):
        u, v = px[some, None], py[some, None]
        spans = (ay > v) != (by > v)
        with np.errstate(divide="ignore", invalid="ignore"):
            crosses = spans & (u < ax + (v - ay) / (by - ay) * (bx - ax))
        result[some] = crosses.sum(axis=1) % 2 == 1
    return result
