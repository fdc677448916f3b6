"""Plane curves, authored as one expression: derivatives to third order, curvature, direction of the tangent.

Orientation (as (31) implies with λ > 0): the plate lies on the left of a track's increasing parameter, so the normal
force on it points along U·R_p; an outline runs counter-clockwise around its plate. Curvature is positive where a curve
bends to its left: a plate can touch where its outline's curvature exceeds the track's.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Any, Self, TypeVar

import numpy as np

from ..derivation import derived, in_one_thread
from ..errors import BadCurve, BadValue, NotSupported, between, boolean, instance, positive, whole
from ..formulas import expressions, formula_symbols
from ..formulas import late_sympy as sp
from ..formulas.expression_graph import (
    Node,
    from_sympy,
    integral_depth,
    lift_numbers,
    node,
    substitute,
    symbol,
)
from ..formulas.expressions import __getattr__ as __getattr__
from ..formulas.expressions import acos, asin, atan, cos, cosh, exp, integral, log, sin, sinh, sqrt, tan, tanh
from . import curve_formula, point_sources
from .curve_checks import check_regular, check_simple
from .jets import S, Structure
from .pieces import CurvePart, CurvePieces
from .plane_curve import PlaneCurve
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

# A closed curve's pieces are counted in whole numbers that doubles have.
MOST_PIECES = 2**53


@dataclass(frozen=True, eq=False, repr=False)
class Curve(PlaneCurve):
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

    # --- its formulas ------------------------------------------------------------------------------------------------

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
