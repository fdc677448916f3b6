"""Curves by their polar form, by their curvature, and in pieces with formulas of their own."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from .curves import Curve, cos, integral, sin
from .curves.matching import matched
from .errors import finite, instance, items, point
from .formulas import late_sympy as sp
from .formulas.expressions import value_of


def polar(radius: Callable, domain: tuple[float, float] | None = None) -> Curve:
    """A curve in polar form: its radius (m) as a formula of the angle, which is its parameter (rad)."""
    return Curve(lambda s: (radius(s) * cos(s), radius(s) * sin(s)), domain)


def natural(curvature: Callable, length: float, start=(0.0, 0.0), angle: float = 0.0, may_cross: bool = False) -> Curve:
    """A curve of that length (m), by its curvature (1/m, positive to the left) as a formula of the distance along it.

    The distance is its parameter. It begins at `start` (m) in the direction `angle` (rad). A clothoid is
    `natural(lambda s: 2 * s, length=1.5)`.
    """
    x, y = point("start of the curve", start)
    angle = finite("angle of the curve", angle)

    def direction(s):
        bend = value_of(curvature, s)
        if bend.is_polynomial(s):  # a formula instead of a table
            return angle + sp.integrate(bend, (s, 0, s))
        return angle + integral(curvature, s)

    def place(s):
        return x + integral(lambda u: cos(direction(u)), s), y + integral(lambda u: sin(direction(u)), s)

    return Curve(place, (0.0, length), may_cross=may_cross)


def piecewise(curves: Iterable[Curve], may_cross: bool = False) -> Curve:
    """The curve that runs through some curves with ends, one after the other; closed if its ends meet.

    Its parameter runs on from piece to piece. The pieces join without corners; where the curvature jumps, forces do.
    Raises BadValue or BadCurve.
    """
    pieces = items("curves of piecewise", curves)
    for number, curve in enumerate(pieces, start=1):
        instance(f"curve {number} of piecewise", curve, Curve)
    return Curve.in_pieces(matched(pieces), may_cross=may_cross)
