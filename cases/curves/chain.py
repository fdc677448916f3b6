"""Chains of smooth curves with corners: tracks with edges, and the outlines of polygons, half discs and gears.

A chain has one parameter: its pieces follow each other, each with the width of its own parameter (an edge's is its
length), and between two pieces whose directions differ lies a corner, whose width is the angle by which the tangent
turns there. So a place at a corner has a direction, and position and direction are continuous along the chain.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from math import floor, pi
from typing import Any

import numpy as np

from ..derivation import derived
from ..errors import BadCurve, BadValue, NotSupported, between, boolean, finite, numbers, whole
from . import Curve
from .corner import Corner, Edge, Piece
from .element import MOST, Element, OneElement

# Positions and directions where pieces meet, relative to the chain's size and in rad: the rounding of a few operations
# with sines and cosines. Two pieces that turn by less than the second meet without a corner.
MEETING, SMOOTH = 1e-12, 1e-12
# A corner turns the tangent by less than half a turn; closer to it than this (rad) its direction is only rounding.
CUSP = 1e-6
# Sides by which a curved piece is replaced when the chain is checked for crossings.
SIDES = 64


class Chain(Curve):
    """A curve of smooth pieces that join at their ends, with corners where their directions differ; closed or open.

    Each piece is a `Curve` with a domain, and begins where the one before it ends. The plate lies on the left of a
    track; an outline runs counter-clockwise around its plate. What needs one formula for the whole curve (`expression`,
    `jet`) raises NotSupported. Raises BadCurve for pieces that do not join, a cusp, and a chain that crosses itself.
    """

    pieces: tuple[Curve, ...]
    is_closed: bool

    def __init__(self, pieces: Sequence[Curve], is_closed: bool = False):
        try:
            some = tuple(pieces)
        except TypeError:
            some = ()
        if not some or not all(isinstance(piece, Curve) and not isinstance(piece, Chain) for piece in some):
            raise BadValue("the pieces of a chain are smooth curves; give a list of Curve")
        for i, piece in enumerate(some):
            if piece.domain is None and not (len(some) == 1 and piece.period):
                raise BadCurve(f"piece {i} of the chain has no ends; give its domain=(a, b)")
        vars(self).update(pieces=some, is_closed=boolean("is_closed", is_closed) or bool(some[0].period), residual=None)
        self._check_joints()
        _check_crossings(self)
        vars(self).update(domain=None if self.is_closed else self.span)

    def __eq__(self, other) -> bool:
        return isinstance(other, Chain) and (self.pieces, self.is_closed) == (other.pieces, other.is_closed)

    def __reduce__(self):
        return _restore, (type(self), self.pieces, self.is_closed)

    def __repr__(self) -> str:
        count = sum(isinstance(element.piece, Corner) for element in self._round)
        form = "closed" if self.is_closed else "open"
        return f"{type(self).__name__}({len(self.pieces)} pieces, {count} corners, {form})"

    def __hash__(self) -> int:
        return self._hash

    @derived
    def _hash(self) -> int:
        return hash((self.pieces, self.is_closed))

    def _no_formula(self) -> Any:
        raise NotSupported("a curve with corners has no single formula; this needs a smooth curve")

    function = property(_no_formula)
    expression = property(_no_formula)
    structure = property(_no_formula)
    constants = ()
    _jet = property(_no_formula)
    _jets = property(_no_formula)
    features = None

    @classmethod
    def polyline(cls, points) -> Chain:
        """Straight edges through points (n, 2) in metres: a track such as a table with two edges, or a staircase."""
        places = corner_points(points, 2)
        return cls(tuple(map(Edge.between, places[:-1], places[1:])))

    def _check_joints(self) -> None:
        for i, piece in enumerate(self.pieces):
            j = (i + 1) % len(self.pieces)
            if (j == 0 and not self.is_closed) or (len(self.pieces) == 1 and piece.period):
                continue
            end, start = piece.point(piece.span[1]), self.pieces[j].point(self.pieces[j].span[0])
            apart = float(np.hypot(*(end - start)))
            if not apart <= MEETING * self.size:
                raise BadCurve(
                    f"piece {i} of the chain ends at ({end[0]:.9g}, {end[1]:.9g}) m and piece {j} begins at "
                    f"({start[0]:.9g}, {start[1]:.9g}) m; give pieces that join"
                )
            if abs(_turn(piece, self.pieces[j])) > pi - CUSP:
                raise BadCurve(f"the chain turns back where piece {i} ends; give pieces that meet at an angle")

    # --- its elements -------------------------------------------------------------------------------------------------

    @derived
    def size(self) -> float:
        """The larger side of the box around the chain, m."""
        points = np.column_stack([piece.point(np.linspace(*piece.span, SIDES + 1)) for piece in self.pieces])
        return float(np.ptp(points, axis=1).max())

    @derived
    def _round(self) -> tuple[Element, ...]:
        """The pieces and corners of the open chain, or of one round of the closed one."""
        elements: list[Element] = []
        start, angle = float(self.pieces[0].span[0]), float(self.pieces[0].tangent_angle(self.pieces[0].span[0]))
        for i, curve in enumerate(self.pieces):
            piece, (low, high) = _as_edge(curve), curve.span
            turns = round((angle - float(piece.tangent_angle(low))) / (2 * pi))
            elements.append(Element(piece, start, low, turns, len(elements)))
            start, angle = start + (high - low), float(piece.tangent_angle(high)) + 2 * pi * turns
            if i + 1 == len(self.pieces) and (not self.is_closed or (i == 0 and curve.period)):
                break
            turn = _turn(curve, self.pieces[(i + 1) % len(self.pieces)])
            if abs(turn) > SMOOTH:
                x, y = (float(value) for value in curve.point(high))
                elements.append(Element(Corner(x, y, angle, turn), start, 0.0, 0, len(elements)))
                start, angle = start + abs(turn), angle + turn
        return tuple(elements)

    @property
    def elements(self) -> tuple[Element, ...]:
        """Its pieces and corners in order (one round of a closed chain)."""
        return self._round

    @property
    def corners(self) -> tuple[Corner, ...]:
        """Its corners in order."""
        return tuple(element.piece for element in self._round if isinstance(element.piece, Corner))

    @derived
    def span(self) -> tuple[float, float]:
        """The range of the chain's parameter (one round of a closed one)."""
        last = self._round[-1]
        return self._round[0].start, last.start + (last.piece.span[1] - last.piece.span[0])

    @derived
    def period(self) -> float | None:
        """The parameter's period of a closed chain, else None."""
        return self.span[1] - self.span[0] if self.is_closed else None

    @derived
    def unit(self) -> float:
        """A length of the parameter over which the chain changes."""
        return min(piece.span[1] - piece.span[0] for piece in self.pieces) / (2 * pi)

    @derived
    def rotation(self) -> int:
        """By how many whole turns the tangent of a closed chain turns in one round (1 if it is counter-clockwise)."""
        first, last = self._round[0], self._round[-1]
        end = float(last.piece.tangent_angle(last.piece.span[1])) + 2 * pi * last.turns
        begin = float(first.piece.tangent_angle(first.low)) + 2 * pi * first.turns
        return round((end - begin) / (2 * pi))

    def element(self, number: int) -> Element | None:
        """An element by its number, which is counted on from round to round of a closed chain, or None."""
        count = len(self._round)
        turn, i = divmod(whole("number of the element", number, -MOST, MOST), count)
        if turn and not self.is_closed:
            return None
        element = self._round[i]
        shift = turn * (self.span[1] - self.span[0])
        return element._replace(start=element.start + shift, turns=element.turns + turn * self.rotation, number=number)

    def element_at(self, s: float) -> Element:
        """The element on which a parameter lies; the earlier one where two meet, but for the chain's start."""
        s, (low, high) = finite("parameter of a curve", s), self.span
        turn = floor((s - low) / (high - low)) if self.is_closed else 0
        starts = [element.start for element in self._round]
        i = max(int(np.searchsorted(starts, s - turn * (high - low))) - 1, 0)
        element = self.element(turn * len(starts) + i)
        assert element is not None
        return element

    # --- evaluation ---------------------------------------------------------------------------------------------------

    def _evaluate(self, s, function: Callable[[Element, np.ndarray], Any], rows: int) -> np.ndarray:
        """A function of elements and their own parameters at chain parameters: shape (rows, n), or (rows,)."""
        values = np.atleast_1d(numbers("parameters of a curve", s))
        result = np.full((rows, *values.shape), np.nan)
        low, high = self.span
        turns = np.floor((values - low) / (high - low)) if self.is_closed else np.zeros(values.shape)
        inside = values - turns * (high - low)
        starts = np.array([element.start for element in self._round])
        which = np.maximum(np.searchsorted(starts, inside) - 1, 0)
        for i, element in enumerate(self._round):
            here = which == i
            if here.any():
                local = inside[here] - element.shift
                result[:, here] = function(element, local)
        return result if np.ndim(s) else result[:, 0]

    def point(self, s) -> np.ndarray:
        """Position, shape (2,) for a number, (2, n) for an array."""
        return self._evaluate(s, lambda element, local: element.piece.point(local), 2)

    def tangent(self, s) -> np.ndarray:
        """Unit tangent, shape (2,) for a number, (2, n) for an array."""
        return self._evaluate(s, lambda element, local: element.piece.tangent(local), 2)

    def speed(self, s):
        """Metres per unit of the parameter: zero at a corner."""
        return self._number(s, lambda element, local: element.piece.speed(local))

    def curvature(self, s):
        """Signed curvature in 1/m, positive where the chain bends to its left; infinite at a corner."""
        return self._number(s, lambda element, local: element.piece.curvature(local))

    def tangent_angle(self, s):
        """Direction of the tangent in radians, continuous along the chain."""
        low, high = self.span
        angle = self._number(s, lambda e, local: e.piece.tangent_angle(local) + 2 * pi * e.turns)
        if self.is_closed:
            s = numbers("parameters of a curve", s)
            angle = angle + 2 * pi * self.rotation * np.floor((s - low) / (high - low))
        return angle if np.ndim(s) else float(angle)

    place = OneElement.place

    def _number(self, s, function: Callable[[Element, np.ndarray], Any]):
        row = self._evaluate(s, function, 1)[0]
        return row if np.ndim(s) else float(row)

    # --- as a polygon -------------------------------------------------------------------------------------------------

    def translate(self, x: float, y: float) -> Chain:
        """The same chain, moved by (x, y) m."""
        x, y = finite("x", x), finite("y", y)
        return _restore(type(self), tuple(translate(piece, x, y) for piece in self.pieces), self.is_closed)

    def vertices(self, longest_turn: float) -> np.ndarray:
        """Parameters of the vertices of a polygon along the chain: all joints, and on curved pieces places between
        which the tangent turns by at most `longest_turn` (rad)."""
        longest_turn, places = between("longest turn", longest_turn, 1e-6, 2 * pi), list[float]()
        for element in self._round:
            low, high = element.piece.span
            places += [value + element.shift for value in _divided(element.piece, low, high, longest_turn)[:-1]]
        return np.array([*places, self.span[1]])

    def _lengths(self, low: float, high: float) -> tuple[np.ndarray, np.ndarray]:
        """Parameters between two that resolve the chain, and the length from the first to each, m."""
        grid = self._grid(low, high)
        return grid, np.insert(np.cumsum(np.hypot(*np.diff(self.point(grid), axis=1))), 0, 0.0)

    def _grid(self, low: float, high: float) -> np.ndarray:
        """Parameters between two that resolve the chain: the vertices of each round, and a few between them."""
        vertices, (first, last) = self.vertices(0.01), self.span
        if self.is_closed and (high - low) / (last - first) * len(vertices) > MOST:
            raise BadValue(f"from {low:g} to {high:g} are too many rounds of the chain; give fewer")
        rounds = range(floor((low - first) / (last - first)), floor((high - first) / (last - first)) + 1)
        all_rounds = np.unique([vertices + turn * (last - first) for turn in (rounds if self.is_closed else (0,))])
        return np.union1d([low, high], all_rounds[(all_rounds > low) & (all_rounds < high)])

    @derived
    def sizes(self) -> tuple[float, float]:
        """The largest distance from the origin, and zero, the radius of a corner, m."""
        return float(np.hypot(*self.point(self.vertices(0.01))).max()), 0.0

    @derived
    def bounds(self) -> tuple[float, float, float, float]:
        """The box around the chain, to 1e-5 of its size: smallest and largest x, smallest and largest y, m."""
        x, y = self.point(self.vertices(0.01))
        return float(x.min()), float(x.max()), float(y.min()), float(y.max())


def translate(curve: Curve, x: float, y: float) -> Curve:
    """A curve moved by (x, y) m, with the same parameter."""
    if isinstance(curve, Edge):
        (x0, y0), (x1, y1) = curve.point(curve.span[0]), curve.point(curve.span[1])
        return Edge.between((x0 + x, y0 + y), (x1 + x, y1 + y))
    if curve.parts is not None:
        return Curve.in_pieces(curve.parts.translate(x, y), curve.residual, curve.may_cross)

    def place(s):
        here = curve.at(s)
        return here[0] + x, here[1] + y

    return Curve(place, curve.domain)


def corner_points(points, fewest: int) -> list[tuple[float, float]]:
    """Points of a polygon or polyline as pairs of numbers; raises BadValue."""
    try:
        pairs = [(x, y) for x, y in points]
    except (TypeError, ValueError):
        raise BadValue("the points are not pairs of numbers; give a list such as [(0, 0), (1, 0), (1, 1)]") from None
    places = [(finite("x of a point", x), finite("y of a point", y)) for x, y in pairs]
    if len(places) < fewest:
        raise BadValue(f"{len(places)} points are given; give at least {fewest}")
    for i, (first, second) in enumerate(zip(places, places[1:], strict=False)):
        if first == second:
            raise BadValue(f"points {i} and {i + 1} are the same; leave one out")
    return places


def _restore(kind: type[Chain], pieces: tuple[Curve, ...], is_closed: bool) -> Chain:
    """A chain that was checked where it was made."""
    chain = object.__new__(kind)
    vars(chain).update(pieces=pieces, is_closed=is_closed, residual=None)
    vars(chain).update(domain=None if is_closed else chain.span)
    return chain


def _as_edge(curve: Curve) -> Curve:
    """A straight piece as an edge, any other as it is."""
    if isinstance(curve, Edge) or curve.features is not None or curve.domain is None:
        return curve
    return Edge.of(curve)


def _turn(before: Curve, after: Curve) -> float:
    """The angle by which the tangent turns where one piece follows another, within half a turn."""
    (ax, ay), (bx, by) = before.tangent(before.span[1]), after.tangent(after.span[0])
    return float(np.arctan2(ax * by - ay * bx, ax * bx + ay * by))


def _divided(piece: Piece, low: float, high: float, longest_turn: float) -> np.ndarray:
    """Parameters from one to the other between which a piece turns by at most `longest_turn`."""
    if isinstance(piece, Corner):
        return np.array([low, high])
    grid = np.linspace(low, high, 721)
    angles = np.insert(np.cumsum(np.abs(np.diff(piece.tangent_angle(grid)))), 0, 0.0)
    count = max(1, int(np.ceil(angles[-1] / longest_turn)))
    if count == 1:
        return np.array([low, high])
    inner = np.interp(np.arange(1, count) / count * angles[-1], angles, grid)
    return np.array([low, *inner, high])


def _check_crossings(chain: Chain) -> None:
    """Raise BadCurve for a chain that crosses or touches itself, to the resolution of SIDES sides for each curved
    piece."""
    for crossing in _crossings(chain):
        raise BadCurve(
            f"the chain crosses itself near ({crossing[0]:.6g}, {crossing[1]:.6g}) m; give pieces that meet only at "
            "their ends"
        )


def _crossings(chain: Chain) -> Iterator[np.ndarray]:
    grids = [np.linspace(*piece.span, SIDES + 1 if piece.features else 2)[:-1] for piece in chain.pieces]
    points = np.column_stack([piece.point(grid) for piece, grid in zip(chain.pieces, grids, strict=True)])
    last = chain.pieces[-1]
    points = np.column_stack([points, last.point(last.span[1])])
    a, b = points[:, :-1], points[:, 1:]
    along, count = b - a, a.shape[1]
    for i in range(count - 2):
        j = np.arange(i + 2, count - 1 if chain.is_closed and i == 0 else count)
        off = a[:, j] - a[:, i : i + 1]
        cross = along[0, i] * along[1, j] - along[1, i] * along[0, j]
        with np.errstate(divide="ignore", invalid="ignore"):
            s = (off[0] * along[1, j] - off[1] * along[0, j]) / cross
            u = (off[0] * along[1, i] - off[1] * along[0, i]) / cross
        hits = (cross != 0.0) & (s >= 0.0) & (s <= 1.0) & (u >= 0.0) & (u <= 1.0)
        if hits.any():
            yield a[:, i] + s[np.argmax(hits)] * along[:, i]
