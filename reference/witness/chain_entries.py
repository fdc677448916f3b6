"""Where a plate enters a track, by polygons along both: for curves with corners."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cases import Chain, Curve, DoesNotFit
from cases.contact.geometry import EPS
from cases.contact.piece_contact import Entry, piece_gap
from cases.curves.corner import Corner
from cases.curves.element import Element

# A plate enters its track if a vertex of one lies deeper than this part of the plate's size inside the other: far above
# the rounding of a pose. Sides of curved pieces turn by at most FINE, rad.
DEPTH, FINE = 1e-9, 0.01

# How far back a zero of a gap is searched, in times between two samples.
GOES_BACK = 4.0
# Times at which it is looked for, each twice as far back as the one before.
MOST_TIMES = 50

Pose = Callable[[float], tuple[float, float, float]]


class Chains:
    """Track and outline as polygons, to see where a plate enters its track apart from its contact."""

    def __init__(self, track: Curve, outline: Curve, low: float, high: float):
        self.track, self.outline = track, outline
        self.s1 = _polygon(track, low, high)
        self.s2 = _polygon(outline, *outline.span)[:-1]
        self.points1 = track.point(self.s1)
        lengths = np.hypot(*np.diff(self.points1, axis=1))
        # An arc that turns by φ over a chord ℓ rises above it by ℓ φ/8.
        self.rises = lengths * np.abs(np.diff(track.tangent_angle(self.s1))) / 4
        # A vertex inside a straight piece is no place where the track could enter a plate first.
        self.bent1 = np.zeros(len(self.s1), dtype=bool)
        self.bent1[1:-1] = (
            np.abs(np.diff(np.diff(track.tangent_angle(self.s1)))) + self.rises[1:] + self.rises[:-1] > 0.0
        )
        self.points2 = outline.point(self.s2)
        self.size = float(np.ptp(self.points2, axis=1).max())
        self.reach = float(np.hypot(*self.points2).max())
        self.longest = float(lengths.max())  # side of the track's polygon, m

    def entry(self, x: float, y: float, theta: float, xi1: float | None = None) -> Entry | None:
        """A place where the plate is inside its track, or None; `xi1`: where it touches, which does not count."""
        c, s = np.cos(theta), np.sin(theta)
        ends = np.array([x + c * self.points2[0] - s * self.points2[1], y + s * self.points2[0] + c * self.points2[1]])
        deep = DEPTH * self.size
        contact = self.track.point(xi1) if xi1 is not None else np.array([np.inf, np.inf])
        centre = np.array([[x], [y]])
        return self._corner_in_track(ends, centre, contact, deep) or self._corner_in_plate(ends, centre, contact, deep)

    def _corner_in_track(self, ends: np.ndarray, centre: np.ndarray, contact: np.ndarray, deep: float) -> Entry | None:
        """A vertex of the outline below a side of the track."""
        a, way = self.points1[:, :-1], np.diff(self.points1, axis=1)
        square = (way**2).sum(axis=0)
        with np.errstate(divide="ignore", invalid="ignore"):
            part = np.clip(((centre - a) * way).sum(axis=0) / square, 0.0, 1.0)
        sides = np.flatnonzero((square > 0.0) & (np.hypot(*(a + part * way - centre)) <= self.reach))
        if not sides.size:
            return None
        depth, along = _below(self.points1[:, sides], self.points1[:, sides + 1], ends)
        # A vertex that has just gone through a side is also on the inner side of its neighbour, at that one's very end.
        length = np.hypot(*(self.points1[:, sides + 1] - self.points1[:, sides]))[:, None]
        inside = (along * length > 2.0 * deep) & ((1.0 - along) * length > 2.0 * deep)
        inside &= (depth > deep + self.rises[sides, None]) & (depth < 0.25 * self.size)
        inside &= (np.hypot(*(ends - contact[:, None])) > deep)[None]
        if not inside.any():
            return None
        # At a convex corner of the track a vertex lies below both sides: the nearer one is what it went through.
        below = np.where(inside, depth, np.inf)
        least = below.min(axis=0)
        vertex = int(np.argmax(np.where(np.isfinite(least), least, -np.inf)))
        side = int(np.argmin(below[:, vertex]))
        start = self.s1[sides[side]]
        s1 = start + along[side, vertex] * (self.s1[sides[side] + 1] - start)
        return Entry(_element(self.track, s1), _element(self.outline, self.s2[vertex]), float(s1), self.s2[vertex])

    def _corner_in_plate(self, ends: np.ndarray, centre: np.ndarray, contact: np.ndarray, deep: float) -> Entry | None:
        """A vertex of the track inside the outline."""
        starts, points = ends, np.roll(ends, -1, axis=1)
        near = np.hypot(*(self.points1 - centre)) <= self.reach
        places = np.flatnonzero(near & self.bent1 & (np.hypot(*(self.points1 - contact[:, None])) > deep))
        if not places.size:
            return None
        # Positive outside: to the right of a side of the outline.
        depth, along = _below(starts, points, self.points1[:, places])
        length = np.hypot(*(points - starts))
        real = length > deep  # at a corner two vertices coincide, to rounding
        winding = np.where(real[:, None], -depth, np.inf)
        inside = winding.min(axis=0) > deep  # of a convex outline; others are seen by their vertices
        if not inside.any():
            return None
        place = int(np.flatnonzero(inside)[0])
        side = int(np.argmin(winding[:, place]))
        s2 = self.s2[side] + float(np.clip(along[side, place], 0.0, 1.0)) * (
            (self.s2[side + 1] if side + 1 < len(self.s2) else self.outline.span[1]) - self.s2[side]
        )
        s1 = float(self.s1[places[place]])
        return Entry(_element(self.track, s1), _element(self.outline, s2), s1, float(s2))


def _below(a: np.ndarray, b: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How far points (2, n) lie to the right of sides from a to b (2, m), and where along them: shapes (m, n)."""
    way = b - a
    length = np.hypot(*way)
    with np.errstate(divide="ignore", invalid="ignore"):
        tx, ty = way / length
    dx, dy = points[0][None] - a[0][:, None], points[1][None] - a[1][:, None]
    return dx * ty[:, None] - dy * tx[:, None], (dx * tx[:, None] + dy * ty[:, None]) / length[:, None]


def _polygon(curve: Curve, low: float, high: float) -> np.ndarray:
    """Parameters of a polygon along a curve whose sides turn by FINE rad at most, its joints included."""
    if isinstance(curve, Chain):
        return curve.vertices(FINE)
    grid = np.linspace(low, high, 1441)
    if curve.features is None:
        return grid
    angles = np.insert(np.cumsum(np.abs(np.diff(curve.tangent_angle(grid)))), 0, 0.0)
    count = int(np.ceil(angles[-1] / FINE)) + 1
    return np.union1d(grid, np.interp(np.linspace(0.0, angles[-1], count), angles, grid))


def _element(curve: Curve, s: float) -> Element:
    """The element at a vertex of the polygon: the corner where there is one, else the piece; of two pieces that join
    smoothly the one that is more bent, as the end of an edge is nearest only if the contact is beyond it."""
    element = curve.element_at(float(s))
    (low, high), place = element.piece.span, float(s) - element.shift
    rounding = 16 * EPS * (abs(float(s)) + abs(element.shift))
    for is_there, step in ((place <= low + rounding, -1), (place >= high - rounding, 1)):
        near = curve.element(element.number + step)
        if is_there and near is not None and (isinstance(near.piece, Corner) or _bend(near, s) > _bend(element, s)):
            return near
    return element


def _bend(element: Element, s: float) -> float:
    """The curvature of a piece at its end next to a parameter of the chain, 1/m, without sign."""
    return abs(float(element.piece.curvature(element.clip(float(s)) - element.shift)))


def entry_time(pose: Pose, entry: Entry, before: float, inside: float, earliest: float) -> float:
    """The instant at which a gap closed, between a time without an entry and one at which it was seen, s.

    At the first time the plate may already be inside by less than DEPTH, so that it goes back from there, by some times
    the time between both, at most to the time `earliest`: farther away the pieces, which go on beyond their ends, may
    have other zeros. Raises DoesNotFit if the gap does not close.
    """
    earliest = max(earliest, before - GOES_BACK * (inside - before))

    def gap(t: float) -> float:
        return piece_gap(entry, *pose(t)).gap

    step = inside - before
    for _ in range(MOST_TIMES):
        if gap(before) > 0.0:
            return _zero(gap, before, inside)
        if before <= earliest:
            break
        before, step = max(before - step, earliest), 2.0 * step
    raise DoesNotFit("the gap does not close")


def _zero(gap: Callable[[float], float], low: float, high: float) -> float:
    """The zero of a falling gap by halves: at most 60 of them leave a rounding of the time."""
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if gap(middle) > 0.0 else (low, middle)
    return 0.5 * (low + high)
