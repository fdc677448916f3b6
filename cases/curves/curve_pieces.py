"""A curve in pieces, with bounds on the place, direction and curvature of each; divided as finely as necessary.

The bounds come from interval arithmetic on the curve's own formula: the mean value theorem and Taylor's theorem about
the middle of a piece, whichever is narrower. A piece of half the length has a quarter of the sagitta. Halves are stored
only for the rest of a search: so the limit on the work of a motion does not depend on earlier motions.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..formulas.features import union
from ..formulas.intervals import Interval, bounds
from . import Curve

# Rows of a table of pieces: the parameter's range; the middle's place and unit tangent; how far the piece reaches from
# there along the tangent and along the left normal; by how much its tangent turns from the middle's at most (rad); its
# curvature; its greatest distance from the middle.
LOW, HIGH, X, Y, TX, TY, BACK, AHEAD, BELOW, ABOVE, TURN, BEND_LOW, BEND_HIGH, REACH = range(14)
ROWS = 14
# Initial pieces of a closed or bounded curve, and of each doubling of one without ends on each side.
FIRST = 16
# This many pieces of one curve take a hundred megabytes; a plate farther away than this many doublings is out of range.
MOST_PIECES, MOST_DOUBLINGS = 1_000_000, 60


class TooMuch(Exception):
    """A search reached its limit on work, or a curve has more detail than the limit on pieces allows."""


class Pieces:
    """The pieces of one curve. A piece is a number; its bounds are a column of `table`."""

    def __init__(self, curve: Any):
        self.curve = curve
        self._table = np.empty((ROWS, 64))
        self._halves = np.full(64, -1)
        self._count = 0
        low, high = self._span()
        # The first pieces; for a curve without ends also those of each doubling of the searched range.
        self._roots = [self._add(*_split(low, high, FIRST))]
        self._ends = [(low, high)]

    def jet(self, s: float) -> tuple[float, ...]:
        """Place and derivatives of the curve at one parameter."""
        return self.curve.jet(s)

    def _span(self) -> tuple[float, float]:
        return self.curve.span

    def _bounds(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        return piece_bounds(self.curve, low, high)

    @property
    def count(self) -> int:
        """The number of all pieces so far."""
        return self._count

    @property
    def roots(self) -> np.ndarray:
        """The initial pieces: they cover the curve's span."""
        return self._roots[0]

    def table(self, some: np.ndarray) -> np.ndarray:
        """The bounds of some pieces, shape (ROWS, n)."""
        return self._table[:, some]

    def halves(self, some: np.ndarray) -> np.ndarray:
        """The first halves of some pieces; the second half's number is one more. Raises TooMuch."""
        first = self._halves[some]
        missing = first < 0
        if missing.any():
            whole = union(some[missing])
            if self._count + 2 * len(whole) > MOST_PIECES:
                raise TooMuch
            low, high = self._table[LOW, whole], self._table[HIGH, whole]
            middle = 0.5 * (low + high)
            numbers = self._add(np.column_stack([low, middle]).ravel(), np.column_stack([middle, high]).ravel())
            self._halves[whole] = numbers[::2]
            first = self._halves[some]
        return first

    def around(self, x: np.ndarray, y: np.ndarray, reach: np.ndarray) -> np.ndarray:
        """Pieces that cover the curve; for one without ends, all parts within `reach` of the places (x, y), each of
        shape (n,). Raises TooMuch.

        The range is doubled as long as its outer half comes within `reach`, or nearer than the inner half.
        """
        roots = self._roots[0]
        if self.curve.domain is not None or self.curve.period:
            return roots
        for doublings in range(MOST_DOUBLINGS):
            if doublings:
                roots = np.concatenate([self._doubling(doublings)[:FIRST], roots, self._doubling(doublings)[FIRST:]])
            if not self._ends_near(roots, self._ends[doublings], x, y, reach):
                return roots
        raise TooMuch

    def _ends_near(
        self, roots: np.ndarray, ends: tuple[float, float], x: np.ndarray, y: np.ndarray, reach: np.ndarray
    ) -> bool:
        table = self.table(roots)
        away = np.hypot(x[:, None] - table[X], y[:, None] - table[Y]) - table[REACH]
        middle, width = 0.5 * (ends[0] + ends[1]), ends[1] - ends[0]
        inner = np.abs(0.5 * (table[LOW] + table[HIGH]) - middle) < 0.25 * width
        outside, inside = away[:, ~inner].min(axis=1), away[:, inner].min(axis=1)
        return bool((outside < np.maximum(reach, inside)).any())

    def _doubling(self, number: int) -> np.ndarray:
        """The pieces that a doubling adds, on the left and on the right."""
        while len(self._roots) <= number:
            low, high = self._ends[-1]
            half = 0.5 * (high - low)
            left, right = _split(low - half, low, FIRST), _split(high, high + half, FIRST)
            self._roots.append(np.concatenate([self._add(*left), self._add(*right)]))
            self._ends.append((low - half, high + half))
        return self._roots[number]

    def _add(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """Add pieces to the table; returns their numbers."""
        numbers = np.arange(self._count, self._count + len(low))
        while self._count + len(low) > self._table.shape[1]:
            self._table = np.concatenate([self._table, np.empty_like(self._table)], axis=1)
            self._halves = np.concatenate([self._halves, np.full_like(self._halves, -1)])
        self._table[:, numbers] = self._bounds(low, high)
        self._count += len(low)
        return numbers


class OnePiece:
    """A corner, or a straight curve, in one piece."""

    def __init__(self, piece: Any):
        low, high = (np.array([end]) for end in piece.span)
        table, middle = np.zeros((ROWS, 1)), 0.5 * (low + high)
        table[[LOW, HIGH]], table[[X, Y]], table[[TX, TY]] = (low, high), piece.point(middle), piece.tangent(middle)
        bend = piece.curvature(middle)
        if np.isinf(bend).all():
            table[TURN], table[[BEND_LOW, BEND_HIGH]] = 0.5 * (high - low), bend
        else:
            reach = 0.5 * piece.speed(middle) * (high - low) if piece.ends else np.inf
            table[BACK], table[[AHEAD, REACH]] = -reach, reach
        self._table, self.roots, self.count = table, np.array([0]), 1

    def table(self, some: np.ndarray) -> np.ndarray:
        """Its bounds, so many times."""
        return self._table[:, some]


class ReversedPieces(Pieces):
    """The same for a curve run through backwards, so that its right side becomes its left: an outline as seen from
    outside. Its parameter is that of the curve with the opposite sign."""

    def jet(self, s: float) -> tuple[float, ...]:
        """Place and derivatives by the reversed parameter."""
        x, y, xp, yp, xs, ys, xt, yt = self.curve.jet(-s)
        return x, y, -xp, -yp, xs, ys, -xt, -yt

    def _span(self) -> tuple[float, float]:
        low, high = self.curve.span
        return -high, -low

    def _bounds(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        table = reversed_bounds(piece_bounds(self.curve, -high, -low))
        table[[LOW, HIGH]] = low, high
        return table


def reversed_bounds(table: np.ndarray) -> np.ndarray:
    """The bounds on pieces that are run through backwards."""
    table = table.copy()
    table[[TX, TY]] = -table[[TX, TY]]
    for one, other in ((BACK, AHEAD), (BELOW, ABOVE), (BEND_LOW, BEND_HIGH)):
        table[[one, other]] = -table[[other, one]]
    return table


def _split(low: float, high: float, parts: int) -> tuple[np.ndarray, np.ndarray]:
    edges = np.linspace(low, high, parts + 1)
    return edges[:-1], edges[1:]


def _ranges(curve: Curve, low: np.ndarray, high: np.ndarray) -> list[Interval]:
    """Bounds on place and two derivatives between `low` and `high`, (n,): six rows."""
    if curve.parts is None:
        return [bounds(row, low) for row in curve.jets_of(Interval(low, high), curve.constants)[:6]]
    # Every range in its parts between knots, by the formula of each.
    first, last = curve.parts.numbers(low), curve.parts.numbers(high)
    counts = np.maximum(last - first, 0) + 1
    which = np.repeat(np.arange(len(low)), counts)
    numbers = first[which] + np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    start, end = curve.parts.ends(numbers)
    # The first and the last piece are continued to the range's ends, which may lie beyond those of the curve.
    start = np.where(numbers == first[which], low[which], start)
    end = np.where(numbers == last[which], high[which], end)
    rows = np.empty((2, 6, len(numbers)))
    forms = curve.parts.form(numbers)
    for form in np.unique(forms):
        some = forms == form
        values = curve.parts.rows_on(Interval(start[some], end[some]), numbers[some])[:6]
        for i, value in enumerate(values):
            own = bounds(value, start[some])
            rows[0, i, some], rows[1, i, some] = own.low, own.high
    starts = np.cumsum(counts) - counts
    return [
        Interval(np.minimum.reduceat(rows[0, i], starts), np.maximum.reduceat(rows[1, i], starts)) for i in range(6)
    ]


def piece_bounds(curve: Curve, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """The bounds on the pieces of a curve between `low` and `high`, shape (ROWS, n): infinite where there are none."""
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    with np.errstate(all="ignore"):
        at = curve.jets(middle)
        speed = np.hypot(at[2], at[3])
        tx, ty = at[2] / speed, at[3] / speed
        x, y, xp, yp, xs, ys = _ranges(curve, low, high)
        both = Interval(-half, half)

        def along(u: Interval, v: Interval) -> Interval:
            return u * tx + v * ty

        def across(u: Interval, v: Interval) -> Interval:
            return v * tx - u * ty

        second = along(xs, ys), across(xs, ys)
        # The speed along the middle's tangent and across it: the formula's own bounds, and Taylor's.
        ahead = along(xp, yp).within(second[0] * both + speed)
        aside = across(xp, yp).within(second[1] * both)
        offset = x - at[0], y - at[1]
        reach = along(*offset).within(ahead * both)
        sagitta = second[1] * (0.5 * half * half)
        rise = across(*offset).within(aside * both)
        rise = rise.within(Interval(np.minimum(sagitta.low, 0.0), np.maximum(sagitta.high, 0.0)))
        turn = np.where(ahead.low > 0.0, np.arctan(aside.size / ahead.low), np.pi)
        bend = (ahead * second[1] - aside * second[0]) / (ahead**2 + aside**2) ** 1.5
        table = np.array([
            low, high, at[0], at[1], tx, ty, reach.low, reach.high, rise.low, rise.high, turn, bend.low, bend.high,
            np.hypot(reach.size, rise.size),
        ])  # fmt: skip
    without_value = ~np.isfinite(table[[X, Y, TX, TY]]).all(axis=0)
    table[X:TX, without_value], table[TX, without_value], table[TY, without_value] = 0.0, 1.0, 0.0
    for row, value in ((BACK, -np.inf), (AHEAD, np.inf), (BELOW, -np.inf), (ABOVE, np.inf), (TURN, np.pi)):
        table[row, without_value | np.isnan(table[row])] = value
    for row, value in ((BEND_LOW, -np.inf), (BEND_HIGH, np.inf), (REACH, np.inf)):
        table[row, without_value | np.isnan(table[row])] = value
    return table
