"""The nearest points of two elements in a pose: boxes of pieces of both, and bounds that exclude a common normal.

At a pair of nearest points the tangents are parallel, and the gap is along their normal. Pairs of pieces in which that
is excluded, or the gap is larger than one that is known, are dropped, and the others halved; where curvatures allow one
pair only, Newton's method finds it. So no ripple is missed, however fine it is. A corner is a piece without length
whose tangent turns; a point is a corner that turns all round.
"""

from __future__ import annotations

from functools import lru_cache
from math import cos, inf, pi, sin
from typing import NamedTuple, cast

import numpy as np

from ..curves import Curve
from ..curves.corner import Corner, Piece
from ..curves.curve_pieces import (
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
    OnePiece,
    Pieces,
    X,
    Y,
    reversed_bounds,
)
from ..errors import DoesNotFit
from .geometry import EPS, Contact, find
from .shapes import guess, shapes

Pose = tuple[float, float, float]

# Pieces of one curve that are kept from pose to pose: a few megabytes.
MOST_KEPT = 20_000
# Halvings after which pieces are as short as roundings, and more boxes than can be distinguished: both curves have
# nearly the same common normals everywhere.
ROUNDS, MOST_BOXES = 50, 20_000
# Newton's method is tried in at most so many boxes of a round, in which the tangents turn by less than STRAIGHT (rad).
MOST_TRIES, STRAIGHT = 4, 0.5
# Of pairs that are found, one outside its box by less than this part of it counts as inside.
BEYOND = 0.5
# A curve without ends reaches so far, m.
FARTHEST = 1e150
# Roundings of a gap, in parts of the numbers that it is a difference of; and gaps that differ by less are equal.
ROUNDING = 64 * EPS


class _Bounds(NamedTuple):
    """For n boxes: the distance of both middles, bounds on the gap (m), whether a common normal with a least gap is
    possible, and whether at most one is."""

    apart: np.ndarray
    low: np.ndarray
    high: np.ndarray
    possible: np.ndarray
    single: np.ndarray


@lru_cache(maxsize=64)
def _pieces(piece: Piece) -> Pieces | OnePiece:
    return OnePiece(piece) if piece.features is None else Pieces(cast(Curve, piece))


def pieces_of(piece: Piece) -> Pieces | OnePiece:
    """The pieces of an element of a curve; few are kept."""
    result = _pieces(piece)
    if result.count > MOST_KEPT:
        _pieces.cache_clear()
        result = _pieces(piece)
    return result


@lru_cache(maxsize=256)
def circles_around(curve: Curve) -> np.ndarray:
    """Circles (x, y, r) around the elements of a curve, (3, elements); of infinite radius without ends, m."""
    rows = list[tuple[float, float, float]]()
    for element in curve.elements:
        pieces = pieces_of(element.piece)
        table = pieces.table(pieces.roots)
        x, y = (float(row.mean()) for row in (table[X], table[Y]))
        is_endless = element.piece.ends is None and not element.piece.period
        radius = inf if is_endless else float((np.hypot(table[X] - x, table[Y] - y) + table[REACH]).max())
        rows.append((x, y, radius))
    return np.array(rows).T


def close_pairs(track: Piece, outline: Piece, pose: Pose, most: float | None = None) -> list[Contact]:
    """The pairs of points of two elements with a common normal in a pose, and a smaller gap than next to them, the
    nearest first: all with a gap (m, signed) of at most `most`, or, with None, all that may be the nearest."""
    some, other = pieces_of(track), pieces_of(outline)
    # Of lines and corners Newton's method is exact; of circles, from their middles.
    is_exact, form = isinstance(some, OnePiece) and isinstance(other, OnePiece), None
    if is_exact or (form := shapes(track, outline)):
        middles = 0.5 * sum(track.span), 0.5 * sum(outline.span)
        try:
            return [find(track, outline, *pose, guess(track, outline, form, *pose) if form else middles)]
        except DoesNotFit:  # far away, or all points are as near
            return []
    i, j, reach = _roots(some, other, pose)
    best, results = inf, list[Contact]()
    for _ in range(ROUNDS):
        t, o = some.table(i), other.table(j)
        with np.errstate(all="ignore"):
            bounds = _bounds(t, o, pose) if not isinstance(track, Corner) else _bounds_from_outline(t, o, pose)
        rounding = ROUNDING * (abs(pose[0]) + abs(pose[1]) + reach + bounds.apart.min())
        best = min(best, float(bounds.apart.min()))
        # A point of the outline that is farther behind the track than it is wide has a nearer one in front.
        limit, deepest = best if most is None else most, best + 2.0 * reach
        rest = np.flatnonzero(bounds.possible & ~(bounds.low > limit + rounding) & ~(bounds.high < -deepest))
        rest = rest[np.argsort(bounds.low[rest], kind="stable")]
        complete, is_crowded = np.zeros(len(rest), dtype=bool), len(rest) > MOST_BOXES
        for k in np.flatnonzero(bounds.single[rest] | is_crowded)[:MOST_TRIES].tolist():
            contact = _inside(track, outline, pose, t[:, rest[k]], o[:, rest[k]])
            if contact is not None:
                complete[k] = True
                results.append(contact)
                best = min(best, contact.gap if contact.gap >= 0.0 else inf)
        rest = rest[~complete]
        if not len(rest) or is_crowded:
            break
        i, j = i[rest], j[rest]
        if isinstance(some, Pieces):
            i = some.halves(i)
            i, j = np.append(i, i + 1), np.append(j, j)
        if isinstance(other, Pieces):
            j = other.halves(j)
            i, j = np.append(i, i), np.append(j, j + 1)
    return sorted(results, key=lambda one: one.gap)


def _roots(some: Pieces | OnePiece, other: Pieces | OnePiece, pose: Pose) -> tuple[np.ndarray, np.ndarray, float]:
    """The first pieces of all boxes, and how far the outline reaches from the plate's origin, m."""
    own, roots = other.table(other.roots), some.roots
    reach = float((np.hypot(own[X], own[Y]) + np.minimum(own[REACH], FARTHEST)).max())
    if isinstance(some, Pieces):
        near = some.table(roots)
        away = float(np.hypot(near[X] - pose[0], near[Y] - pose[1]).min()) + 2.0 * reach
        roots = some.around(*np.array([[pose[0]], [pose[1]], [away]]))
    return np.repeat(roots, len(other.roots)), np.tile(other.roots, len(roots)), reach


def _bounds_from_outline(t: np.ndarray, o: np.ndarray, pose: Pose) -> _Bounds:
    """The same with a corner of the track as a point that moves around the outline, whose right side is outside."""
    x, y, theta = pose
    c, s = cos(theta), sin(theta)
    return _bounds(reversed_bounds(o), reversed_bounds(t), (-c * x - s * y, s * x - c * y, -theta))


def _bounds(t: np.ndarray, o: np.ndarray, pose: Pose) -> _Bounds:
    """Bounds for pairs of pieces, columns of the tables of both. An infinite bound excludes nothing."""
    c, s = cos(pose[2]), sin(pose[2])
    dx, dy = pose[0] + c * o[X] - s * o[Y] - t[X], pose[1] + s * o[X] + c * o[Y] - t[Y]
    ox, oy = c * o[TX] - s * o[TY], s * o[TX] + c * o[TY]
    cosine, sine = t[TX] * ox + t[TY] * oy, t[TX] * oy - t[TY] * ox
    off, gap = dx * t[TX] + dy * t[TY], dy * t[TX] - dx * t[TY]
    ends, sides = np.array([o[BACK], o[AHEAD]]), np.array([o[BELOW], o[ABOVE]])
    along, across = _range(ends * cosine) - _range(sides * sine)[::-1], _range(ends * sine) + _range(sides * cosine)
    # The difference of both points in the frame of the track's middle, which turns by up to `turn` from there.
    level, aside = across + gap - t[[ABOVE, BELOW]], along + off - t[[AHEAD, BACK]]
    turn = np.minimum(t[TURN], 0.5 * pi)
    tilt = np.abs(level).max(axis=0) * np.tan(turn)
    bent = t[TURN] + np.where(o[REACH] > 0.0, o[TURN], 0.0)  # a corner turns at one point
    possible = ~(
        (aside[0] > tilt) | (aside[1] < -tilt) | (np.abs(np.arctan2(sine, cosine)) > t[TURN] + o[TURN] + ROUNDING)
    )
    low, high = (
        np.where(sign * side > 0.0, side / np.cos(turn), side) for sign, side in zip((-1, 1), level, strict=True)
    )
    steep = np.cos(np.minimum(bent, STRAIGHT)) ** -3
    # Both as graphs over the middle's tangent; the outline is grown by the gap.
    least, largest = (
        _graph(_grown(o[BEND_LOW], high, -inf), steep, -1),
        _graph(_grown(o[BEND_HIGH], low, inf), steep, 1),
    )
    is_straight = bent < STRAIGHT
    single = is_straight & (least > _graph(t[BEND_HIGH], steep, 1))
    possible &= ~(is_straight & (largest < _graph(t[BEND_LOW], steep, -1)))
    return _Bounds(np.where(np.isinf(t[REACH]), np.abs(gap), np.hypot(dx, dy)), low, high, possible, single)


def _range(ends: np.ndarray) -> np.ndarray:
    return np.array([ends.min(axis=0), ends.max(axis=0)])


def _grown(bend: np.ndarray, gap: np.ndarray, beyond: float) -> np.ndarray:
    """The curvature of a curve at a distance outside one of curvature `bend`; `beyond` where the centre of that is
    passed."""
    radius = 1.0 / bend + gap
    return np.where(bend == 0.0, 0.0, np.where(radius * bend > 0.0, 1.0 / radius, np.where(bend > 0.0, inf, beyond)))


def _graph(bend: np.ndarray, steep: np.ndarray, sign: int) -> np.ndarray:
    """A bound (from above: sign 1) on y'' from one on the curvature."""
    return bend * np.where(sign * bend > 0.0, steep, 1.0)


def _inside(track: Piece, outline: Piece, pose: Pose, t: np.ndarray, o: np.ndarray) -> Contact | None:
    """The pair of nearest points in a box, by Newton's method; None if it does not find it there."""
    middles = 0.5 * (t[LOW] + t[HIGH]), 0.5 * (o[LOW] + o[HIGH])
    try:
        contact = find(track, outline, *pose, middles)
    except DoesNotFit:
        return None
    offs = zip(contact[:2], middles, (t, o), strict=True)
    # The whole of a line or a corner is one piece, and its ends are the caller's.
    is_inside = all(
        abs(s - middle) <= (0.5 + BEYOND) * (row[HIGH] - row[LOW])
        for (s, middle, row), piece in zip(offs, (track, outline), strict=True)
        if piece.features is not None
    )
    return contact if is_inside else None


def nearest_on(curve: Curve, x: float, y: float) -> float:
    """The parameter of a curve's point that is nearest to a place, m."""
    point, places = Corner(x, y, 0.0, 2.0 * pi), list[float]()
    for element in curve.elements:
        piece = element.piece
        feet = [] if isinstance(piece, Corner) else [one.xi1 for one in close_pairs(piece, point, (0.0, 0.0, 0.0))]
        low, high = piece.ends or (-inf, inf)
        ends = [element.middle] if isinstance(piece, Corner) else piece.ends or ()
        places += [s + element.shift for s in (*(s for s in feet if low <= s <= high), *ends)]
    return min(places, key=lambda s: float(np.hypot(*(curve.point(s) - (x, y)))))
