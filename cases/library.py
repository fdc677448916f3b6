"""Curves by name. Each is a `Curve` of one expression; lengths in metres, angles in radians.

The plate lies on the left of increasing s: valleys and hills run to the right with the plate above them, `circle` and
`ellipse` are tracks seen from inside and, equally, outlines; `hill` is a circle seen from outside. Sizes must be
greater than zero (BadValue). The curves' own facts are derived where they are stated, or tested by quadrature.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from functools import lru_cache, wraps
from math import pi
from typing import Any, ParamSpec

from .curves import Curve
from .derivation import in_one_thread
from .errors import BadCurve, BadValue, finite, positive, whole
from .formulas import formula_symbols
from .formulas import late_sympy as sp
from .formulas.expression_code import ON_FLOATS, function_of
from .formulas.expression_graph import HALF
from .formulas.expressions import admissible, cos, cosh, exp, sin, value_of

P = ParamSpec("P")


def _memoise(curve: Callable[P, Curve]) -> Callable[P, Curve]:
    """The same curve for the same arguments: what is known of it is worked out once."""
    memo: Any = lru_cache(maxsize=256, typed=True)(curve)

    @wraps(curve)
    def call(*sizes: P.args, **keywords: P.kwargs) -> Curve:
        try:
            return memo(*sizes, **keywords)
        except TypeError:  # what cannot be kept by is no number; the curve says so itself
            return curve(*sizes, **keywords)

    return call


@_memoise
def line(slope: float = 0.0) -> Curve:
    """A straight line that falls to the right at the angle `slope`; s is arc length."""
    angle = finite("slope of line", slope)
    if not angle:
        return Curve.of_nodes(lambda s: (s, 0))
    return Curve(lambda s: (s * cos(angle), -s * sin(angle)))


@_memoise
def circle(radius: float) -> Curve:
    """A circle about the origin, counter-clockwise; s is the polar angle."""
    R = positive("radius of circle", radius)
    return Curve.of_nodes(lambda s: (R * cos(s), R * sin(s)))


@_memoise
def hill(radius: float) -> Curve:
    """The outside of a circle about the origin; s is the angle from its top, to the right."""
    R = positive("radius of hill", radius)
    return Curve.of_nodes(lambda s: (R * sin(s), R * cos(s)))


@_memoise
def ellipse(a: float, b: float) -> Curve:
    """An ellipse about the origin with half-axes a (along X) and b, counter-clockwise."""
    a, b = positive("a of ellipse", a), positive("b of ellipse", b)
    return Curve.of_nodes(lambda s: (a * cos(s), b * sin(s)))


@_memoise
def parabola(focus: float, reach: float = 3.0) -> Curve:
    """The valley y = x²/(4·focus) for |x| ≤ reach; s = x. Radius of curvature 2·focus at the bottom."""
    bend, reach = 1.0 / (4 * positive("focus of parabola", focus)), positive("reach of parabola", reach)
    return Curve.of_nodes(lambda s: (s, bend * s**2), (-reach, reach))


@_memoise
def cosine(depth: float, wavenumber: float, reach: float = 3.0) -> Curve:
    """The wave y = −depth·cos(wavenumber·x) for |x| ≤ reach, a valley at s = x = 0."""
    d, k, reach = (
        positive("depth of cosine", depth),
        positive("wavenumber of cosine", wavenumber),
        finite("reach", reach),
    )
    return Curve.of_nodes(lambda s: (s, -d * cos(s * k)), (-reach, reach))


@_memoise
def catenary(a: float, reach: float = 3.0) -> Curve:
    """The hanging chain y = a cosh(x/a) for |x| ≤ reach; s = x. Its curvature is a/y²."""
    a, reach = positive("a of catenary", a), positive("reach of catenary", reach)
    return Curve.of_nodes(lambda s: (s, a * cosh(s * (1 / a))), (-reach, reach))


@_memoise
def catenary_hill(a: float, reach: float) -> Curve:
    """The same chain upside down, y = −a cosh(x/a): the road on which a straight edge rolls level."""
    a, reach = positive("a of catenary_hill", a), positive("reach of catenary_hill", reach)
    return Curve.of_nodes(lambda s: (s, -a * cosh(s * (1 / a))), (-reach, reach))


@_memoise
def cycloid(a: float, offset: float = 0.0) -> Curve:
    """The valley x = a(s + sin s), y = −a cos s, moved down its normal by `offset`.

    A disc of radius `offset` on it has its *centre* on the cycloid itself. The domain |s| ≤ 2.9 leaves out the cusps
    at ±π. One arch from cusp to cusp is 8a long.
    """
    a = positive("a of cycloid", a)
    r = finite("offset of cycloid", offset) or 0
    make = Curve if r else Curve.of_nodes  # SymPy has an order of its own for the terms
    return make(lambda s: (s * a + a * sin(s) + r * sin(HALF * s), -a * cos(s) - r * cos(HALF * s)), (-2.9, 2.9))


@_memoise
def trochoid(a: float, arm: float, arches: int = 2) -> Curve:
    """x = a s + arm·sin s, y = −arm·cos s: a point at distance `arm` from the centre of a wheel of radius a.

    A valley at s = 0, `arches` arches to each side. BadCurve for arm = a (the cycloid's cusps) and arm > a (loops).
    """
    a, d = positive("a of trochoid", a), positive("arm of trochoid", arm)
    arches = whole("arches of trochoid", arches, 1, 1000)
    if d >= a:
        raise BadCurve(f"arm = {d:g} of trochoid is not below a = {a:g}: it has cusps or loops; give a shorter arm")
    return Curve.of_nodes(lambda s: (s * a + d * sin(s), -d * cos(s)), (-2 * pi * arches, 2 * pi * arches))


@_memoise
def superellipse(a: float, b: float, exponent: int = 4) -> Curve:
    """|x/a|ⁿ + |y/b|ⁿ = 1 for an even whole number n ≥ 2; s is the polar angle of (x/a, y/b).

    For n > 2 its four flat points have curvature zero: it fits on a hill, and touches a straight line there only at
    the limit of fitting.
    """
    a, b = positive("a of superellipse", a), positive("b of superellipse", b)
    n = whole("exponent of superellipse", exponent, 2, 64)
    if n % 2:
        raise BadValue(f"exponent of superellipse is {n}; give an even whole number")

    def point(s):
        # A root of a root of cosines to whole powers is smooth all round; |cos s|^(2/n), the usual form, is not.
        root = (cos(s) ** n + sin(s) ** n) ** Fraction(1, n)
        return a * cos(s) / root, b * sin(s) / root

    return Curve.of_nodes(point)


@_memoise
def logarithmic_spiral(start: float, growth: float, turns: float = 0.5) -> Curve:
    """r = start·e^(growth·s) about the origin for |s| ≤ 2π·turns, counter-clockwise.

    It meets every radius at the same angle, whose cotangent is `growth`.
    """
    a, b = positive("start of logarithmic_spiral", start), finite("growth of logarithmic_spiral", growth)
    reach = 2 * pi * positive("turns of logarithmic_spiral", turns)
    make = Curve.of_nodes if b else Curve
    return make(lambda s: (a * cos(s) * exp(s * b), a * exp(s * b) * sin(s)), (-reach, reach))


@in_one_thread
def from_support(support: Callable[[Any], Any]) -> Curve:
    """The outline whose tangent with outward normal (cos s, sin s) lies at the distance h(s) from the origin.

    `support` takes a symbol and returns h in metres. Its radius of curvature is h + h″, which must stay positive
    (BadCurve where it reaches zero: the outline has a cusp there).
    """
    parameter = formula_symbols.PARAMETER
    h = admissible(value_of(support, parameter), (parameter,), "the support function", BadCurve)
    h1 = sp.diff(h, parameter)
    outline = Curve(lambda s: (h * cos(s) - h1 * sin(s), h * sin(s) + h1 * cos(s)))
    radius_of = function_of([parameter], [h + sp.diff(h1, parameter)], ON_FLOATS)

    def radius(s: float) -> float:
        return radius_of(s)[0]

    worst = min((2 * pi * i / 720 for i in range(720)), key=radius)
    if radius(worst) <= 0.0:
        raise BadCurve(f"h + h'' is {radius(worst):.6g} m at s = {worst:.6g}, so the outline has a cusp; add to h")
    return outline


@_memoise
def rounded_polygon(radius: float, corners: int, sharpness: float = 0.5) -> Curve:
    """h = radius·(1 + sharpness·cos(n s)/(n² − 1)): an outline with n rounded corners, `sharpness` from 0 to below 1.

    For odd n its width is 2·radius in every direction.
    """
    r, k = positive("radius of rounded_polygon", radius), finite("sharpness of rounded_polygon", sharpness)
    n = whole("corners of rounded_polygon", corners, 2, 1000)
    if not 0 <= k < 1:
        raise BadValue(f"sharpness of rounded_polygon is {k:g}; give a number from 0 to below 1")
    swell = r * k / (n * n - 1) or 0

    def point(s):  # of a support h as in `from_support`
        h, fall = r + swell * cos(n * s), n * swell
        return h * cos(s) + fall * sin(s) * sin(n * s), h * sin(s) - fall * cos(s) * sin(n * s)

    return Curve.of_nodes(point)


__all__ = [
    "catenary",
    "catenary_hill",
    "circle",
    "cosine",
    "cycloid",
    "ellipse",
    "from_support",
    "hill",
    "line",
    "logarithmic_spiral",
    "parabola",
    "rounded_polygon",
    "superellipse",
    "trochoid",
]
