"""Boxes of time, track and outline, and bounds that exclude a meeting of plate and track in a box.

At a meeting the two points coincide, their tangents are parallel, the outline bends more than the track and the gap
closes. Over a box each of these is bounded by its value in the middle and its possible change, to second order in the
lengths of the pieces. For a disc the centre is used instead of the outline.
"""

from __future__ import annotations

from math import pi
from typing import NamedTuple

import numpy as np

from cases import Case, Curve
from cases.curves.corner import Corner, Piece
from cases.curves.curve_pieces import (
    ABOVE,
    AHEAD,
    BACK,
    BELOW,
    BEND_HIGH,
    BEND_LOW,
    HIGH,
    LOW,
    REACH,
    TURN,
    TX,
    TY,
    Pieces,
    X,
    Y,
    piece_bounds,
)

from ..scales import EPS
from .windows import Windows

# Roundings in the gap, which is computed from places in some tens of operations.
ROUNDINGS = 32
# In a box with at most one meeting the tangents turn by less than this, rad.
STRAIGHT = 0.5
# A halved direction contributes about this part of what it contributed to the uncertainty of the gap: pieces of curves
# do so with the square of their length.
HALF_BLUR = 0.25


Range = tuple[np.ndarray, np.ndarray]
# Number of tried stretches on each side of a pair: from half of the plate's reach, each half as long as the last.
MOST_TRIES = 20
# If no such stretch is found, as near a place where the plate no longer fits, points closer to the pair than this part
# of the reach count as the pair.
SAME = 1e-6
# A corner is a circle of the radius of a rounding, in parts of its distance from the centre of mass.
SHARPEST = 1e16
# Where the pair moves by less than this part of the shortest stretch, a shorter range would prove no more.
STILL = 0.1


class Boxes(NamedTuple):
    """n boxes: the numbers of their windows and of their pieces of track and outline, and their stretches of time."""

    window: np.ndarray
    track: np.ndarray
    outline: np.ndarray
    start: np.ndarray
    end: np.ndarray

    def some(self, which: np.ndarray) -> Boxes:
        return Boxes(*(column[which] for column in self))

    @property
    def number(self) -> int:
        return len(self.window)


class Cores(NamedTuple):
    """For each of n windows the stretches of track and outline, (2, n) each, around a known pair of points: no other
    pair in them meets."""

    track: np.ndarray
    outline: np.ndarray


class Bounds(NamedTuple):
    """Bounds for n boxes: which may contain a meeting, and its time range; the contributions of time, track and outline
    to the uncertainty of the gap, m (3, n); which contain at most one meeting; and the gap's rounding, m."""

    possible: np.ndarray
    start: np.ndarray
    end: np.ndarray
    blur: np.ndarray
    single: np.ndarray
    rounding: np.ndarray


class _PieceView(NamedTuple):
    """The outline's pieces relative to the middles of the track's pieces.

    The offset of their middles along the tangent and the normal, and its rate; their extent from there along both; the
    distance of their points from their middle, and of that from the centre of mass; bounds on their curvature; the
    angle by which the tangents of both pieces turn; whether they may be parallel; the contributions of time, track and
    outline to the uncertainty of the gap.
    """

    off: np.ndarray
    gap: np.ndarray
    slip: np.ndarray
    lift: np.ndarray
    back: np.ndarray
    ahead: np.ndarray
    below: np.ndarray
    above: np.ndarray
    loose: np.ndarray
    lever: np.ndarray
    bend_low: np.ndarray
    bend_high: np.ndarray
    bent: np.ndarray
    parallel: np.ndarray
    blur: np.ndarray


class Geometry:
    """The curves of a case in pieces, and the bounds on boxes of them."""

    def __init__(self, track: Pieces, outline: Pieces | None, radius: float | None, reach: float):
        """`outline`: None for a point, a disc of radius 0; `radius`: of a disc, else None; `reach` (m): the largest
        distance of the plate's points from its centre of mass."""
        self.track, self.radius, self.reach = track, radius, reach
        self.outline = outline or track  # of a point: not used
        self.farthest = float(radius or 0.0)  # point of the outline, m
        if outline is not None:
            whole = outline.table(outline.roots)
            self.farthest = float((np.hypot(whole[X], whole[Y]) + whole[REACH]).max())

    def bounds(self, motion: Windows, boxes: Boxes) -> Bounds:
        """Bounds that may exclude a meeting, for each box. An infinite bound excludes nothing."""
        with np.errstate(all="ignore"):
            return self._bounds(motion, boxes)

    def _bounds(self, motion: Windows, boxes: Boxes) -> Bounds:
        w, t = boxes.window, self.track.table(boxes.track)
        middle, half = 0.5 * (boxes.start + boxes.end), 0.5 * (boxes.end - boxes.start)
        place, rate = motion.at(w, middle)
        spin = motion.spin[w]
        o = self._disc(t, place, rate) if self.radius is not None else self._outline(t, boxes, place, rate, spin * half)
        rounding = motion.error[w] + ROUNDINGS * EPS * (np.abs(place[0]) + np.abs(place[1]) + self.reach)
        pull = motion.pull[w] + (motion.swing[w] + spin * spin) * o.lever
        later = 0.5 * pull * half * half
        rest = later + rounding
        closest = o.gap + o.below - t[ABOVE] - rest, o.gap + o.above - t[BELOW] + rest
        aside = o.off + o.back - t[AHEAD] - rest, o.off + o.ahead - t[BACK] + rest
        start, end = -half, half
        for offset, speed in ((closest, o.lift), (aside, o.slip)):
            start, end = _while_across(*offset, speed, start, end)
        # The gap's rate is that of the middles, changed by the normal's turn, the spin of the outline's piece, and
        # time.
        tilt = np.abs(o.slip) * _sine(t[TURN]) + spin * o.loose + pull * half
        level = o.lift * np.cos(np.minimum(t[TURN], pi))
        opens, closes = np.minimum(o.lift, level) > tilt, np.maximum(o.lift, level) < -tilt
        possible = ~((start > end) | opens | (o.bend_high < t[BEND_LOW]) | ~o.parallel)
        # Both as graphs over the tangent of the track's middle, where y'' is the curvature over cos³ of the angle.
        steep = np.cos(np.minimum(o.bent, STRAIGHT)) ** -3
        bends = _graph_bend(-o.bend_low, steep), _graph_bend(t[BEND_HIGH], steep)
        single = closes & (o.bent < STRAIGHT) & (-bends[0] > bends[1])
        blur = o.blur + np.array([np.abs(o.lift) * half + later, t[ABOVE] - t[BELOW], 0.0 * half])
        return Bounds(possible, middle + start, middle + end, blur, single, rounding)

    def _disc(self, t: np.ndarray, place: np.ndarray, rate: np.ndarray) -> _PieceView:
        """The view of a disc: its point with the track's tangent is one radius from its centre along the normal."""
        dx, dy, r, none = place[0] - t[X], place[1] - t[Y], float(self.radius or 0.0), np.zeros(t.shape[1])
        level, side = r * np.cos(np.minimum(t[TURN], pi)), r * _sine(t[TURN])
        bend = none + (1.0 / r if r else np.inf)
        return _PieceView(
            dx * t[TX] + dy * t[TY], dy * t[TX] - dx * t[TY],
            rate[0] * t[TX] + rate[1] * t[TY], rate[1] * t[TX] - rate[0] * t[TY],
            -side, side, none - r, -level, none, none, bend, bend, 2.0 * t[TURN], none == 0.0,
            np.array([none, r - level, none]),
        )  # fmt: skip

    def _outline(
        self, t: np.ndarray, boxes: Boxes, place: np.ndarray, rate: np.ndarray, turn: np.ndarray
    ) -> _PieceView:
        """Pieces of the outline, which turn by up to `turned` (rad) with the plate."""
        o = self.outline.table(boxes.outline)
        (x, y, theta), (vx, vy, omega) = place, rate
        c, s = np.cos(theta), np.sin(theta)
        rx, ry = c * o[X] - s * o[Y], s * o[X] + c * o[Y]
        ox, oy = c * o[TX] - s * o[TY], s * o[TX] + c * o[TY]
        dx, dy, ux, uy = x + rx - t[X], y + ry - t[Y], vx - omega * ry, vy + omega * rx
        cosine, sine = t[TX] * ox + t[TY] * oy, t[TX] * oy - t[TY] * ox
        bent = t[TURN] + o[TURN] + turn
        loose = o[REACH] * np.minimum(turn, 2.0)
        long, wide = (o[BACK], o[AHEAD]), (o[BELOW], o[ABOVE])
        along, across = _sum(_times(long, cosine), _times(wide, -sine)), _sum(_times(long, sine), _times(wide, cosine))
        return _PieceView(
            dx * t[TX] + dy * t[TY], dy * t[TX] - dx * t[TY], ux * t[TX] + uy * t[TY], uy * t[TX] - ux * t[TY],
            along[0] - loose, along[1] + loose, across[0] - loose, across[1] + loose,
            o[REACH], np.hypot(o[X], o[Y]), o[BEND_LOW], o[BEND_HIGH], bent,
            ~(np.abs(np.arctan2(sine, cosine)) > bent + ROUNDINGS * EPS),
            np.array([
                loose,
                o[REACH] * np.minimum(t[TURN], 1.0),
                o[ABOVE] - o[BELOW] + o[REACH] * np.minimum(o[TURN], 1.0),
            ]),
        )  # fmt: skip

    def against(self, boxes: Boxes, cores: Cores) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Which boxes lie in their window's core; which overlap it partly; and the contributions of the latter's pieces
        to the uncertainty of the gap next to the contact, m (3, n)."""
        w = boxes.window
        places = [(self.track.curve, self.track.table(boxes.track), cores.track)]
        if self.radius is None:
            places.append((self.outline.curve, self.outline.table(boxes.outline), cores.outline))
        inside, meets = np.ones(boxes.number, dtype=bool), np.ones(boxes.number, dtype=bool)
        blur = np.zeros((3, boxes.number))
        for i, (curve, table, core) in enumerate(places):
            within, outside = _core_membership(curve, table[LOW], table[HIGH], core[:, w])
            inside &= within
            meets &= ~outside
            blur[1 + i] = np.where(within, 0.0, table[REACH] ** 2 / self.reach)
        return inside, meets & ~inside, blur

    def divide(self, boxes: Boxes, blur: np.ndarray) -> tuple[Boxes, np.ndarray]:
        """The boxes, halved in the direction that contributes most to the gap's uncertainty, and the contributions that
        are expected of the halves. Raises `pieces.TooMuch`."""
        widest = np.argmax(blur, axis=0)
        time, track, outline = (np.flatnonzero(widest == which) for which in range(3))
        lots = []
        if time.size:
            some = boxes.some(time)
            middle = 0.5 * (some.start + some.end)
            lots += [some._replace(end=middle), some._replace(start=middle)]
        if track.size:
            some = boxes.some(track)
            first = self.track.halves(some.track)
            lots += [some._replace(track=first), some._replace(track=first + 1)]
        if outline.size:
            some = boxes.some(outline)
            first = self.outline.halves(some.outline)
            lots += [some._replace(outline=first), some._replace(outline=first + 1)]
        less = np.where(np.arange(3)[:, None] == widest, HALF_BLUR * blur, blur)
        order = np.concatenate([some for some in (time, track, outline) for _ in range(2)])
        return Boxes(*(np.concatenate(columns) for columns in zip(*lots, strict=True))), less[:, order]


def _sine(turn: np.ndarray) -> np.ndarray:
    """The greatest sine of an angle up to `turn`."""
    return np.where(turn < 0.5 * pi, np.sin(turn), 1.0)


def _graph_bend(bend: np.ndarray, steep: np.ndarray) -> np.ndarray:
    """A bound on y'' above, from one on the curvature."""
    return bend * np.where(bend > 0.0, steep, 1.0)


def _times(one: Range, factor: np.ndarray) -> Range:
    ends = one[0] * factor, one[1] * factor
    return np.minimum(*ends), np.maximum(*ends)


def _sum(one: Range, other: Range) -> Range:
    return one[0] + other[0], one[1] + other[1]


def _while_across(
    lowest: np.ndarray, highest: np.ndarray, speed: np.ndarray, start: np.ndarray, end: np.ndarray
) -> Range:
    """The part of (start, end) in which zero lies between two offsets that both change with the same speed."""
    first, last = -highest / speed, -lowest / speed
    first, last = np.where(speed > 0.0, first, last), np.where(speed > 0.0, last, first)
    still = ~(np.abs(speed) > 0.0)
    never = still & ((lowest > 0.0) | (highest < 0.0))
    return (
        np.where(never, np.inf, np.where(still, start, np.fmax(start, first))),
        np.where(still, end, np.fmin(end, last)),
    )


def _core_membership(curve: Curve, low: np.ndarray, high: np.ndarray, core: np.ndarray) -> Range:
    """Which parameter ranges lie in a core, and which are disjoint from it, modulo the period."""
    if curve.period:
        turns = np.round((core.mean(axis=0) - 0.5 * (low + high)) / curve.period)
        low, high = low + turns * curve.period, high + turns * curve.period
    return (core[0] <= low) & (high <= core[1]), (high < core[0]) | (core[1] < low)


def cores(case: Case, xi1: np.ndarray, xi2: np.ndarray, gap: np.ndarray) -> tuple[Cores, np.ndarray]:
    """The cores around n pairs whose parameters stay within `xi1` and `xi2`, (2, n), and whose gap (m) is at most that,
    (n,); and which of them shorter ranges may still prove. Cores that are not proven contain only the pair itself.

    Where the outline, grown by the gap, bends more than the track, and both turn little, the outline lies above the
    track like a convex graph above a line: it is nearest in one place."""
    n, reach = len(gap), case.plate.reach
    lengths = np.append(reach * 0.5 ** np.arange(1, MOST_TRIES + 1), SAME * reach)
    track, outline = (_widen(curve, ends, lengths) for curve, ends in ((case.track, xi1), (case.plate.outline, xi2)))
    t = piece_bounds(case.track, *track.reshape(2, -1))
    if isinstance(case.plate.outline, Corner):
        turns, bend = 2.0 * t[TURN], np.full(t.shape[1], SHARPEST / reach)
    elif case.plate.radius is not None:
        turns, bend = 2.0 * t[TURN], np.full(t.shape[1], 1.0 / case.plate.radius)
    else:
        o = piece_bounds(case.plate.outline, *outline.reshape(2, -1))
        turns, bend = t[TURN] + o[TURN], o[BEND_LOW]
    gaps = np.tile(gap, len(lengths))
    with np.errstate(all="ignore"):
        steep = np.cos(np.minimum(turns, STRAIGHT)) ** -3
        outer_bend = np.where(bend * gaps > -1.0, bend / (1.0 + bend * gaps), -np.inf)
        alone = outer_bend * np.where(outer_bend < 0.0, steep, 1.0) > t[BEND_HIGH] * np.where(
            t[BEND_HIGH] > 0.0, steep, 1.0
        )
    alone = (alone & (turns < STRAIGHT)).reshape(len(lengths), n)
    proven = alone.any(axis=0)
    first = np.where(proven, np.argmax(alone, axis=0), len(lengths) - 1)
    which = np.arange(n)
    moves = np.maximum(_lengths(case.track, xi1), _lengths(case.plate.outline, xi2)) > STILL * lengths.min()
    return Cores(track[:, first, which], outline[:, first, which]), moves & ~proven


def _lengths(curve: Piece, ends: np.ndarray) -> np.ndarray:
    """The lengths (m) of ranges (2, n) of a parameter."""
    return np.asarray((ends[1] - ends[0]) * curve.speed(ends.mean(axis=0)))


def _widen(curve: Piece, ends: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """Ranges (2, n) of a parameter, widened on both sides by each of some lengths (m): (2, lengths, n). A corner has no
    length."""
    speed = np.ones(ends.shape[1]) if isinstance(curve, Corner) else np.asarray(curve.speed(ends.mean(axis=0)))
    wide = lengths[:, None] / speed
    return np.array([ends[0] - wide, ends[1] + wide])
