"""Plane curves, authored as one expression: derivatives to third order, curvature, direction of the tangent.

Orientation (as (31) implies with λ > 0): the plate lies on the left of a track's increasing parameter, so the normal
force on it points along U·R_p; an outline runs counter-clockwise around its plate. Curvature is positive where a curve
bends to its left: a plate can touch where its outline's curvature exceeds the track's.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from math import atan2, floor, hypot, isfinite, nan
from typing import Any, Self, TypeVar

import numpy as np

from ..derivation import derived, in_one_thread
from ..errors import (
    BadCurve,
    BadValue,
    CaseError,
    NotSupported,
    between,
    boolean,
    finite,
    instance,
    numbers,
    point,
    positive,
    real,
    whole,
)
from ..formulas import expressions, features, formula_symbols
from ..formulas import late_sympy as sp
from ..formulas.expression_graph import (
    Node,
    derivatives,
    from_sympy,
    integral_depth,
    lift_numbers,
    node,
    substitute,
    symbol,
)
from ..formulas.expressions import __getattr__ as __getattr__
from ..formulas.expressions import acos, asin, atan, cos, cosh, exp, integral, log, sin, sinh, sqrt, tan, tanh
from . import curve_formula, parametrisation, point_sources
from . import curve_tables as tables
from .curve_checks import check_regular, check_simple
from .element import OneElement
from .jets import S, Structure, jet_function
from .pieces import CurvePart, CurvePieces
from .splines import spline

__all__ = [
    "Curve",
    "acos",
    "asin",
    "atan",
    "cos",
    "cosh",
    "exp",
    "integral",
    "log",
    "pi",  # noqa: F822 - by __getattr__
    "sin",
    "sinh",
    "sqrt",
    "tan",
    "tanh",
]

T = TypeVar("T")

# The range looked at when a curve without a domain has no period, in units in which it changes: a hundred of them
# either way would already overflow a cosh; ten are what a drawing shows.
UNBOUNDED_SPAN = (-10.0, 10.0)

# A closed curve's pieces are counted in whole numbers that doubles have.
MOST_PIECES = 2**53


@dataclass(frozen=True, eq=False, repr=False)
class Curve(OneElement):
    """A smooth plane curve s ↦ (X(s), Y(s)), in metres.

    `function` takes a SymPy symbol and returns a pair of expressions made with the functions of `cases.curves`
    (sin, cos, exp, …), or is a pair of strings such as ("s", "-0.3*cos(2*s)"). `domain` is the
    parameter's range (a, b), or None for all real numbers. Floating-point constants of the expression are its sizes:
    curves that differ only in them share one compiled system. A curve that crosses itself needs `may_cross`.

    Raises BadCurve for a cusp (R_p = 0), a curve that crosses itself, a value that is not finite or an expression
    without derivatives, BadValue for a bad domain.
    """

    function: Callable[[Any], tuple[Any, Any]] | tuple[str, str]
    domain: tuple[float, float] | None = None
    # Of a curve through measured points: the largest distance of a point from it, m.
    residual: float | None = None
    may_cross: bool = False
    # Of a curve in pieces: these; such a curve has no single formula.
    parts: CurvePieces | None = field(init=False, default=None)

    @in_one_thread
    def __post_init__(self):
        object.__setattr__(self, "domain", curve_formula.check_domain(self.domain))
        object.__setattr__(self, "may_cross", boolean("may_cross", self.may_cross))
        _ = self.expression  # raises what is wrong with it
        self._check()

    @classmethod
    @in_one_thread
    def of_nodes(cls, function: Callable[[Any], tuple[Any, Any]], domain: tuple[float, float] | None = None) -> Curve:
        """A curve of the library: its function takes a node as well as a symbol of SymPy, which it does not need then.

        What it makes of a node is what `from_sympy` makes of its expression, in the same order.
        """
        nodes, sizes, constants = lift_numbers(function(S))
        if not all(size <= expressions.LARGEST_NUMBER for size in constants):
            return cls(function, domain)  # which says so
        structure = _the_one(((nodes[0], nodes[1]), sizes))
        curve = cls.of_facts(function, curve_formula.check_domain(domain), structure=structure, constants=constants)
        curve._check()
        return curve

    @classmethod
    def of_facts(cls, function: Any, domain: tuple[float, float] | None, **facts: Any) -> Self:
        """A curve with what is known of it, unchecked; without a function that of its expression."""
        curve = object.__new__(cls)
        facts = dict(residual=None, may_cross=False, parts=None) | facts
        vars(curve).update(facts, function=function or curve.at, domain=domain)
        return curve

    def _check(self) -> None:
        """Check the curve, unless an equal one was checked: then share what is known of that."""
        # Values too large or too small for a double are not finite here; the checks report them.
        with np.errstate(all="ignore"):
            first = _first(self)
        if first is not self:
            vars(self).update({name: fact for name, fact in vars(first).items() if name not in _NO_DOMAIN})

    @classmethod
    def in_pieces(cls, pieces: CurvePieces, residual: float | None = None, may_cross: bool = False) -> Curve:
        """A curve made of pieces with formulas of their own."""
        instance("argument of in_pieces", pieces, CurvePieces)
        curve = _restore_pieces(pieces, residual, boolean("may_cross", may_cross))
        curve._check()
        return curve

    @derived
    def expression(self) -> tuple[sp.Expr, sp.Expr]:
        """(X, Y) as expressions in the parameter. Raises NotSupported for a curve in pieces."""
        if self.parts is not None:
            raise NotSupported("the curve is in pieces and has no single formula; use its points, or its pieces")
        return _the_one(curve_formula.as_expression(self.function))

    @in_one_thread
    def __repr__(self) -> str:
        where = "" if self.domain is None else f", {self.domain[0]:g} <= s <= {self.domain[1]:g}"
        if self.parts is not None:
            return f"Curve({self.parts.count} pieces{where})"
        parts = [curve_formula.shorten(str(part)) for part in self.expression]
        return f"Curve({', '.join(parts)}{where})"

    def __eq__(self, other) -> bool:
        return isinstance(other, Curve) and self._hash == other._hash and self._key == other._key

    def __hash__(self) -> int:
        return self._hash

    @property
    def _key(self) -> tuple:
        """What equal curves share."""
        return self.rows if self.parts is None else self.parts.key, self.domain, self.may_cross

    @cached_property
    def _hash(self) -> int:
        return hash(self._key)

    def __reduce__(self):
        """A curve travels to another process as its expression, a tree of SymPy objects; no text is read back."""
        if self.parts is not None:
            return _restore_pieces, (self.parts, self.residual, self.may_cross)
        trees = [expressions.as_tree(part) for part in self.expression]
        return restore, (trees, self.domain, self.residual, self.may_cross)

    @in_one_thread
    def at(self, s) -> tuple[sp.Expr, sp.Expr]:
        """(X, Y) as expressions, with another expression for the parameter: how a curve is written into another."""
        place = expressions.as_expression(s)
        if place is None:
            raise BadValue(f"the parameter of a curve is {s!r}; give an expression")
        x, y = (part.xreplace({formula_symbols.PARAMETER: place}) for part in self.expression)
        return x, y

    @classmethod
    def spline(
        cls, points, smoothing: float = 0.0, closed: bool = False, scale: float = 1.0, may_cross: bool = False
    ) -> Curve:
        """A curve with four continuous derivatives through points (n, 2) in metres, in order along it.

        Its parameter is the length of the chords between the points. `smoothing` (m): how far a point may be from the
        curve, for points with errors; `residual` is the largest distance. Points may be an array, a pandas frame with
        columns x and y, the name of a CSV file with two columns (in a case file its path counts from there), or SVG
        path data; `scale`: metres per unit of the points. Raises BadValue or BadCurve.
        """
        places = positive("scale", scale) * point_sources.as_points(points)
        result = spline(
            places, between("smoothing", smoothing, 0.0, expressions.LARGEST_NUMBER), boolean("closed", closed)
        )
        try:
            return cls.in_pieces(result.pieces, result.residual, may_cross)
        except BadCurve as problem:
            if smoothing or "crosses" not in str(problem):
                raise
            raise BadCurve(f"{problem}; if the points have errors, give their size in metres as smoothing=") from None

    def plot(self, points=None):
        """The curve as a figure, with the given points and their largest distance from it."""
        from ..pictures.curve_plot import plot

        return plot(self, None if points is None else point_sources.as_points(points))

    # --- evaluation -------------------------------------------------------------------------------------------------

    @derived
    def structure(self) -> Structure:
        """The formulas as nodes, with ±c0, ±c1, … (all positive) for their floating-point constants, and those symbols.

        Curves of one structure share their compiled systems, whatever their sizes.
        """
        (x, y), sizes = expressions.lift_constants(self.expression)
        return _the_one(((from_sympy(x), from_sympy(y)), tuple(symbol(size.name) for size in sizes)))

    @derived
    def constants(self) -> tuple[float, ...]:
        """The values of `structure`'s symbols: the sizes in the order in which the expression names them. None for a
        curve in pieces, whose parts have them."""
        return expressions.constants(self.expression) if self.parts is None else ()

    @derived
    def rows(self) -> tuple[Node, Node]:
        """The formulas as nodes, with their constants."""
        formulas, sizes = self.structure
        x, y = substitute(formulas, dict(zip(sizes, map(node, self.constants), strict=True)))
        return x, y

    @derived
    def integrals(self) -> int:
        """How many integrals contain each other in its formulas: 0 without any."""
        forms = [self.structure] if self.parts is None else self.parts.forms
        return max(integral_depth(from_sympy(row)) for rows, _ in forms for row in rows)

    @property
    def knots(self) -> tuple[float, ...]:
        """The parameters at which a curve in pieces changes its formula, with both ends; none for any other curve."""
        return self.parts.breaks if self.parts is not None else ()

    def part(self, number: int) -> Curve | CurvePart:
        """One piece of a curve in pieces as a curve with ends; any other curve is its only part. The pieces of a closed
        curve are counted on from round to round, forwards and backwards."""
        if self.parts is None:
            return self
        low, high = (-MOST_PIECES, MOST_PIECES) if self.parts.period else (0, self.parts.count - 1)
        return self.parts.part(whole("number of the piece", number, low, high))

    @derived
    def _jet(self) -> Callable:
        if self.parts is not None:
            at = self.parts.jet
            return lambda s, constants: at(s)
        return jet_function(self.structure, on_arrays=False)

    @derived
    def _jets(self) -> Callable:
        return jet_function(self.structure, on_arrays=True)

    def jet(self, s: float) -> tuple[float, ...]:
        """(x, y, x_p, y_p, x_s, y_s, x_t, y_t) at one parameter: position and the first three derivatives. Raises
        BadValue where the formula has no value that fits a double."""
        number = s if isinstance(s, float) else finite("parameter of a curve", s)
        function, constants = self._jet, self.constants
        try:
            return function(number, constants)
        except CaseError:
            raise
        except (ArithmeticError, ValueError) as problem:
            raise BadValue(f"the curve has no place at the parameter {number:g} ({problem}); give another") from None

    def jets(self, s) -> np.ndarray:
        """The same for an array of parameters, shape (8, n)."""
        s = np.atleast_1d(numbers("parameters of a curve", s))
        if self.parts is not None:
            return self.parts.jets(s)
        jets = np.empty((8, *s.shape))
        for row, values in zip(jets, self._jets(s, self.constants), strict=True):
            row[...] = values  # a constant one is a number
        return jets

    def jets_of(self, s: Any, constants: tuple) -> list:
        """The same rows for curves of this structure with sizes of their own, each of the parameters' shape (n,); a
        constant row may be a number. Parameters may be anything that NumPy's functions take, such as intervals; of a
        curve in pieces they are arrays, and it has no sizes."""
        if self.parts is not None:
            return list(self.parts.jets(s))
        return self._jets(s, constants)

    def point(self, s) -> np.ndarray:
        """Position, shape (2,) for a number, (2, n) for an array."""
        return np.array(self.jet(s)[:2]) if _is_number(s) else self.jets(s)[:2]

    def tangent(self, s) -> np.ndarray:
        """Unit tangent, shape (2,) for a number, (2, n) for an array."""
        d = np.array(self.jet(s)[2:4]) if _is_number(s) else self.jets(s)[2:4]
        return d / np.hypot(d[0], d[1])

    def normal(self, s) -> np.ndarray:
        """Left unit normal U·tangent, shape (2,) for a number, (2, n) for an array."""
        t = self.tangent(s)
        return np.array([-t[1], t[0]])

    def speed(self, s):
        """|R_p| in metres per unit of the parameter."""
        if _is_number(s):
            return hypot(*self.jet(s)[2:4])
        return np.hypot(*self.jets(s)[2:4])

    def curvature(self, s):
        """Signed curvature in 1/m, positive where the curve bends to its left."""
        _, _, xp, yp, xs, ys, _, _ = self.jet(s) if _is_number(s) else self.jets(s)
        return (xp * ys - yp * xs) / np.hypot(xp, yp) ** 3

    def length(self, low: float, high: float) -> float:
        """The length of the curve between two parameters, m, to a part in a thousand or so: what samples need."""
        return float(tables.lengths(self, finite("low", low), finite("high", high))[1][-1])

    def even(self, low: float, high: float, count: int) -> np.ndarray:
        """So many parameters from `low` to `high` at nearly even distances along the curve."""
        count = whole("count of parameters", count, 1, tables.MOST_ANGLES)
        grid, lengths = tables.lengths(self, finite("low", low), finite("high", high))
        return np.interp(np.linspace(0.0, lengths[-1], count), lengths, grid)

    @derived
    def sizes(self) -> tuple[float, float]:
        """The largest distance from the origin, and that or the smallest radius of curvature if it is smaller, m."""
        return tables.sizes(self)

    # --- the curve as a whole ---------------------------------------------------------------------------------------

    @property
    def ends(self) -> tuple[float, float] | None:
        """The parameters of both ends of the curve; None if it is closed, or has no domain."""
        return None if self.period else self.domain

    @derived
    def period(self) -> float | None:
        """The parameter's period of a closed curve, else None.

        A curve with a domain is closed if position and three derivatives agree at both ends; one without a domain if
        its formulas have a common period: the shortest part of that after which it repeats itself (looked at in a few
        places, to rounding).
        """
        if self.parts is not None:
            return self.parts.period
        return tables.period(self)

    @derived
    def unit(self) -> float:
        """How much of the parameter makes the curve change: what windows and samples of a curve without ends count in.

        A period over 2π for a closed curve.
        """
        if self.domain is not None or self.period:
            low, high = self.span
            return (high - low) / (2 * np.pi)
        places = parametrisation.places(self.centres)
        with np.errstate(all="ignore"):
            return parametrisation.unit(places, self.jets(places))

    @derived
    def span(self) -> tuple[float, float]:
        """A range of the parameter that shows the whole curve (one turn of a closed one)."""
        if self.domain is not None:
            return self.domain
        if self.period:
            return 0.0, self.period
        low, high = UNBOUNDED_SPAN
        return low * self.unit, high * self.unit

    @derived
    def centres(self) -> tuple[float, ...]:
        """Special points of the formula: centres of bumps and steps, poles, knots."""
        return features.centres(self.rows, S) if self.parts is None else self.parts.breaks[1:-1]

    @derived
    def features(self) -> features.Features | None:
        """Where its curvature and speed change, and how finely; None for a straight line run through evenly."""
        if self.parts is not None:
            return features.Features.of_edges(self.parts.edges, bool(self.period))
        if not any(S in slope.symbols for slope in derivatives(self.structure[0], S)):
            return None
        return tables.features_of(self)

    def tangent_angle(self, s):
        """Direction of the tangent in radians, continuous along the curve (it gains 2π in each turn of a closed one).

        For a number or an array; this is what makes the plate's rotation θ a function of (ξ₁, ξ₂) alone, by (6).
        """
        if _is_number(s):
            number = real(s) or 0.0
            return self._angle_of(number, *self.jet(number)[2:4])
        s = numbers("parameters of a curve", s)
        return self._angles_of(s, self.jets(s)[2:4])

    def place(self, s) -> tuple[Any, Any]:
        """`point` (of a number: a pair of numbers) and `tangent_angle` from one evaluation."""
        if _is_number(s):
            number = real(s) or 0.0
            x, y, xp, yp = self.jet(number)[:4]
            return (x, y), self._angle_of(number, xp, yp)
        s = numbers("parameters of a curve", s)
        jets = self.jets(s)
        return jets[:2], self._angles_of(s, jets[2:4])

    def _angle_of(self, s: float, xp: float, yp: float) -> float:
        """The tangent's direction where the curve runs along (xp, yp)."""
        angle, near = atan2(yp, xp), self._rough_tangent_angle_at(s)
        turns = (near - angle) / (2 * np.pi)
        return angle + 2 * np.pi * round(turns) if isfinite(turns) else nan

    def _angles_of(self, s: np.ndarray, d: np.ndarray) -> np.ndarray:
        """The same for arrays."""
        principal = np.arctan2(d[1], d[0]).reshape(s.shape)
        rough = self._rough_tangent_angle(s)
        return principal + 2 * np.pi * np.round((rough - principal) / (2 * np.pi))

    def _rough_tangent_angle(self, s: np.ndarray) -> np.ndarray:
        """The continuous tangent angle to within much less than half a turn, from a table."""
        if self.period:
            start = self.span[0]
            turns = np.floor((s - start) / self.period)
            grid, angles = self.angle_table(self.span)
            return np.interp(s - turns * self.period, grid, angles) + turns * (angles[-1] - angles[0])
        low, high = self.span
        if self.domain is None and s.size:
            while s.min() < low or s.max() > high:
                low, high = 2 * low, 2 * high
        grid, angles = self.angle_table((low, high))
        return np.interp(s, grid, angles)

    def _rough_tangent_angle_at(self, s: float) -> float:
        """The same at one parameter, without arrays, which take ten times as long."""
        low, high = self.span
        turns = 0
        if not isfinite(s) or (not self.period and self.domain is None and not low <= s <= high):
            return float(self._rough_tangent_angle(np.asarray(s)))
        if self.period:
            turns = floor((s - low) / self.period)
            s -= turns * self.period
        grid, angles = self._angle_lists
        after = bisect_right(grid, s)
        if after == 0 or after == len(grid):  # only by rounding, or outside the domain
            angle = angles[0 if after == 0 else -1]
        else:
            slope = (angles[after] - angles[after - 1]) / (grid[after] - grid[after - 1])
            angle = slope * (s - grid[after - 1]) + angles[after - 1]
        return angle + turns * (angles[-1] - angles[0]) if self.period else angle

    @derived
    def _angle_lists(self) -> tuple[list[float], list[float]]:
        grid, angles = self.angle_table(self.span)
        return grid.tolist(), angles.tolist()

    def angle_table(self, span: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
        """Parameters on that range, and the tangent's continuous angle there: what `tangent_angle` counts turns by."""
        return self._angle_table(point("range of the parameter", span))

    @lru_cache(maxsize=64)  # noqa: B019 - curves are few, small and live as long as their case
    def _angle_table(self, span: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
        return tables.angles(self, span)


def _is_number(s) -> bool:
    """Whether it is one parameter, not an array of them; the most common type is tested first. Raises BadValue for
    what is no number."""
    if isinstance(s, float):
        return True
    if np.ndim(s):
        return False
    if real(s) is None:
        raise BadValue(f"the parameter of a curve is {s!r}; give a number or an array")
    return True


@in_one_thread
def restore(trees, domain, residual, may_cross) -> Curve:
    """The curve that a process sent. It was checked there, so it is not checked again."""
    expression = _the_one(tuple(map(expressions.from_tree, trees)))
    return Curve.of_facts(None, domain, residual=residual, may_cross=may_cross, expression=expression)


def _restore_pieces(pieces: CurvePieces, residual: float | None, may_cross: bool) -> Curve:
    """The same for a curve in pieces."""
    ends = pieces.breaks[0], pieces.breaks[-1]
    return Curve.of_facts(None, ends, residual=residual, may_cross=may_cross, parts=pieces)


@lru_cache(maxsize=4096)
def _the_one(expressions: T) -> T:
    """The first of all that are equal: what is kept by curve is then found by identity, not by comparing formulas."""
    return expressions


# What a curve does not share with one that is equal to it.
_NO_DOMAIN = ("function", "domain", "residual", "may_cross", "parts", "expression")


@lru_cache(maxsize=512)
def _first(curve: Curve) -> Curve:
    """The first of all curves that are equal, checked: the others take over what is known of it."""
    check_regular(curve)
    check_simple(curve)
    return curve
