"""A corner of a chain of curves, the end of an open curve as a corner, and a straight edge: pieces that are no formula
of a user.

Any piece has a parameter u with R'(u) = ρ(u) τ and a tangent angle φ with φ'(u) = k(u). On a smooth curve ρ = |R_p| and
k = κρ. At a corner ρ = 0 and k = ±1: the point is fixed, and the parameter is the angle by which the tangent turned.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot, inf, pi

import numpy as np

from ..errors import BadCurve
from ..formulas.expression_graph import symbol
from ..formulas.expressions import LARGEST_NUMBER
from . import Curve, restore
from .curve_formula import check_domain
from .element import OneElement
from .jets import S, Structure

# Not named like the sizes of a formula (c0, c1, …), which are positive.
_X, _Y, _ALONG_X, _ALONG_Y = map(symbol, ("e0", "e1", "e2", "e3"))


@dataclass(frozen=True)
class Corner(OneElement):
    """A corner at (x, y), m, where the tangent turns from the angle `start` by `turn` (rad, positive to the left).

    Its parameter runs from 0 to |turn|. It has the methods of a `Curve` that describe a place on it.
    """

    x: float
    y: float
    start: float
    turn: float

    period = None
    features = None
    parts = None
    knots = ()

    @property
    def sign(self) -> int:
        """1 if the tangent turns to the left, −1 if to the right: its rate of turn per unit of the parameter."""
        return 1 if self.turn > 0.0 else -1

    @property
    def domain(self) -> tuple[float, float]:
        """The range of its parameter, rad."""
        return 0.0, abs(self.turn)

    span = ends = domain

    @property
    def constants(self) -> tuple[float, float, float]:
        """What distinguishes it from another corner that turns to the same side: x, y and the angle of its start."""
        return self.x, self.y, self.start

    def part(self, number: int) -> Corner:
        """Its only part."""
        return self

    def jet(self, s: float) -> tuple[float, ...]:
        """Position, and derivatives by the parameter, which are zero."""
        return self.x, self.y, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0

    def tangent_angle(self, s):
        """The tangent's direction, rad."""
        return self.start + self.sign * s

    def point(self, s) -> np.ndarray:
        """Its position, shape (2,) for a number, (2, n) for an array."""
        s = np.asarray(s, dtype=float)
        return np.array([np.full(s.shape, self.x), np.full(s.shape, self.y)])

    def tangent(self, s) -> np.ndarray:
        """Unit tangent, shape (2,) for a number, (2, n) for an array."""
        angle = self.tangent_angle(s)
        return np.array([np.cos(angle), np.sin(angle)])

    def speed(self, s):
        """Zero: the point does not move."""
        return np.zeros(np.shape(s)) if np.ndim(s) else 0.0

    def curvature(self, s):
        """Infinite, with the sign of the turn."""
        return np.full(np.shape(s), self.sign * inf) if np.ndim(s) else self.sign * inf


def end_corners(curve: Curve) -> tuple[tuple[float, Corner], ...]:
    """The parameters of both ends of an open curve, each with the end as a corner at which the curve turns back: its
    normal goes from the curve's left one over the end to the right one, or back. None of another curve."""
    corners = list[tuple[float, Corner]]()
    for end, back in zip(curve.ends or (), (pi, 0.0), strict=False):
        x, y = map(float, curve.point(end))
        corners.append((end, Corner(x, y, float(curve.tangent_angle(end)) + back, -pi)))
    return tuple(corners)


class Edge(Curve):
    """A straight edge between two points of a chain; all edges share one compiled system, wherever they lie: their
    `constants` are the point at the parameter zero and the direction, of any signs."""

    structure: Structure = (_X + _ALONG_X * S, _Y + _ALONG_Y * S), (_X, _Y, _ALONG_X, _ALONG_Y)

    @classmethod
    def between(cls, start: tuple[float, float], end: tuple[float, float]) -> Edge:
        """The edge from one point to another, m; its parameter is the length from its start."""
        start, end = (float(start[0]), float(start[1])), (float(end[0]), float(end[1]))
        length = hypot(end[0] - start[0], end[1] - start[1])
        if not length > 0.0:
            raise BadCurve(f"an edge at ({start[0]:g}, {start[1]:g}) m has no length; give points that differ")
        along = (end[0] - start[0]) / length, (end[1] - start[1]) / length

        def function(s):
            return start[0] + along[0] * s, start[1] + along[1] * s

        if not max(map(abs, (*start, *end))) <= LARGEST_NUMBER:
            return cls(function, (0.0, length))  # which says so
        edge = cls.of_facts(function, check_domain((0.0, length)), constants=_unsigned_zeros(*start, *along))
        edge._check()
        return edge

    @classmethod
    def of(cls, curve: Curve) -> Edge:
        """A straight curve with ends as an edge, with the same parameter."""
        facts = {name: vars(curve)[name] for name in ("residual", "expression") if name in vars(curve)}
        return cls.of_facts(curve.function, curve.domain, **facts, constants=_unsigned_zeros(*curve.jet(0.0)[:4]))

    def __reduce__(self):
        return _unpickle, (super().__reduce__()[1],)

    def __eq__(self, other) -> bool:
        return isinstance(other, Edge) and (self.constants, self.domain) == (other.constants, other.domain)

    def __hash__(self) -> int:
        return hash(("edge", self._hash))


def _unsigned_zeros(*numbers: float) -> tuple[float, ...]:
    return tuple(number + 0.0 for number in numbers)


def _unpickle(facts: tuple) -> Edge:
    return Edge.of(restore(*facts))


Piece = Curve | Corner


def turning(piece: Piece, s: float) -> float:
    """The rate at which the tangent turns, rad per unit of the parameter: k = κρ, or ±1 at a corner."""
    if isinstance(piece, Corner):
        return float(piece.sign)
    return float(piece.curvature(s)) * float(piece.speed(s))
