"""Curves: the library against what is known of its curves, strings, measured points, and the errors of all three."""

import re
import time
from math import gamma, pi, prod, sinh

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import ellipe
from sympy.core.cache import clear_cache

import cases
import reference
from cases import BadCurve, BadValue, Curve, library
from cases import curves as c


def length(curve, low, high):
    return quad(lambda s: float(curve.speed(s)), low, high, epsabs=1e-13)[0]


def area(curve):
    def swept(s):
        x, y, xp, yp = curve.jet(s)[:4]
        return 0.5 * (x * yp - y * xp)

    return sum(quad(swept, pi / 4 * i, pi / 4 * (i + 1), epsabs=1e-14)[0] for i in range(8))


# Derived: arcs by ∫ speed in closed form; constant width by ∫ (h + h″) = 2π r; Lamé's curve by Euler's beta integral.
@pytest.mark.parametrize(
    ("measured", "known"),
    [
        (lambda: 2 * length(library.cycloid(0.25), 0.0, 2.5), 8 * 0.25 * np.sin(1.25)),
        (lambda: length(library.catenary(0.5), 0.0, 1.0), 0.5 * sinh(2.0)),
        (lambda: length(library.ellipse(3.0, 2.0), 0.0, 2 * pi), 12 * float(ellipe(5 / 9))),
        (lambda: length(library.rounded_polygon(0.1, 3, 0.8), 0.0, 2 * pi), 0.2 * pi),
        (lambda: length(library.logarithmic_spiral(0.1, 0.2), -1.0, 1.0), 0.1 * 26**0.5 * 2 * sinh(0.2)),
        (lambda: area(library.superellipse(0.2, 0.15)), 4 * 0.2 * 0.15 * gamma(1.25) ** 2 / gamma(1.5)),
        (lambda: 1 / library.parabola(0.4).curvature(0.0), 0.8),
        (lambda: 1 / library.trochoid(0.5, 0.3).curvature(0.0), 0.64 / 0.3),
        (lambda: library.catenary(0.5).curvature(0.7), 0.5 / library.catenary(0.5).point(0.7)[1] ** 2),
        (lambda: 1 / library.cycloid(0.25, 0.1).curvature(0.0), 4 * 0.25 + 0.1),
        (lambda: library.hill(2.0).curvature(0.3), -0.5),
    ],
)
def test_a_library_curve_has_the_size_that_books_give(measured, known):
    assert measured() == pytest.approx(known, rel=1e-12)


def refused(kind, says, make):
    with pytest.raises(kind, match=re.escape(says)) as error:
        make()
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("kind", "says", "make"),
    [
        (BadCurve, "cusps or loops", lambda: library.trochoid(0.3, 0.5)),
        (BadCurve, "cusp", lambda: library.from_support(lambda s: 0.1 + 0.05 * c.cos(3 * s))),
        (BadValue, "even whole number", lambda: library.superellipse(1.0, 1.0, 3)),
        (BadValue, "greater than zero", lambda: library.circle(-1.0)),
        (BadCurve, "crosses itself", lambda: Curve(lambda s: (c.sin(s), c.sin(2 * s)))),
        (BadCurve, "crosses itself", lambda: Curve(lambda s: (s - 2 * c.sin(s), -2 * c.cos(s)), (-4, 4))),
        # Its loops' chords cross in one pair of sides, the curve in the next.
        (BadCurve, "crosses itself", lambda: Curve(("s + 1.2830888*sin(s)", "-1.2830888*cos(s)"), (-10.3993, 10.3993))),
        (BadCurve, "**", lambda: Curve(("s", "s^2"), (-1, 1))),
        (BadCurve, "'t'", lambda: Curve(("s", "cos(t)"))),
        (BadCurve, "more than arithmetic", lambda: Curve(("s", "s.__class__"))),
        (BadCurve, "cannot be read", lambda: Curve(("s", "cos(s"))),
    ],
)
def test_a_wrong_curve_is_refused_in_one_sentence(kind, says, make):
    refused(kind, says, make)


def test_a_product_of_twelve_waves_is_a_curve_with_a_third_derivative():
    """Written out that has over 10,000 parts; equal ones are computed once."""
    curve = Curve(lambda s: (s, prod(1 + 0.1 * c.sin((k + 1.3) * s) for k in range(12))), (-1, 1))
    before, behind = (curve.jet(0.2 + h)[5] for h in (-1e-5, 1e-5))
    # Central differences: their own error is h² times the fifth derivative, 1e5 at most.
    assert curve.jet(0.2)[7] == pytest.approx((behind - before) / 2e-5, rel=1e-6)


def test_strings_and_a_function_give_one_curve():
    assert Curve(("s", "-0.3*cos(2*s)"), (-3, 3)) == Curve(lambda s: (s, -0.3 * c.cos(2 * s)), (-3, 3))


def test_a_file_with_a_bad_line_is_told_with_the_line(tmp_path):
    file = tmp_path / "points.csv"
    file.write_text("x,y\n0,0\n1,zero\n")
    refused(BadValue, "points.csv:3", lambda: Curve.spline(file, closed=True))


def test_equal_curves_in_different_parametrisations_give_equal_motions():
    here = cases.load("disc_in_parabola")
    other = Curve(lambda s: (c.sinh(s), c.sinh(s) ** 2 / 1.6), (-1.8, 1.8))
    there = cases.Case(other, here.plate, here.effects, cases.Start(float(np.arcsinh(here.start.xi1))), here.duration)
    a, b = reference.simulate(here, rtol=1e-12), reference.simulate(there, rtol=1e-12)
    assert [t.time for t in b.transitions] == pytest.approx([t.time for t in a.transitions], abs=1e-10)
    times = np.linspace(0, here.duration, 20)
    assert b(times).x == pytest.approx(a(times).x, abs=1e-9)


def test_equal_curves_share_their_formulas_whatever_sympy_remembers():
    """What is kept by curve is looked up millions of times in a run: by identity, not by comparing formulas."""
    one = Curve(lambda s: (2.0 * c.cos(s), 3.0 * c.sin(s)))
    clear_cache()
    same, other = Curve(lambda s: (2.0 * c.cos(s), 3.0 * c.sin(s))), Curve(lambda s: (4.0 * c.cos(s), 5.0 * c.sin(s)))
    assert all(a is b for a, b in zip(one.expression, same.expression, strict=True))
    assert one.structure is same.structure is other.structure and one.constants != other.constants


@pytest.mark.parametrize("curve", [library.ellipse(1.2, 0.8), library.line(0.3), Curve(("s", "sin(s)"), (-3.0, 4.0)),
                                   library.cycloid(0.25)])  # fmt: skip
def test_the_tangents_angle_counts_the_same_turns_for_a_number_as_for_an_array(curve):
    """Also at the ends of the range in which they are tabulated, and far beyond."""
    low, high = curve.span
    s = np.concatenate([np.linspace(low - 3 * (high - low), high + 3 * (high - low), 91), [low, high]])
    s = s if curve.domain is None else s[(low <= s) & (s <= high)]
    # The angle itself comes from two arctangents, of math and of NumPy.
    assert [curve.tangent_angle(float(x)) for x in s] == pytest.approx(curve.tangent_angle(s).tolist(), abs=1e-14)


@pytest.mark.parametrize(
    "make",
    [
        lambda: Curve(("s", "sin(1e6*s)"), domain=(-1.0, 1.0)),
        lambda: Curve(("s", "sin(1e9*s)"), domain=(-1.0, 1.0)),
        lambda: Curve(("s", "sin(5e3*s)"), domain=(-1.0, 1.0)),
        lambda: Curve(("cos(1e6*s)", "sin(1e6*s)"), domain=(-1.0, 1.0), may_cross=True),
        lambda: Curve(("cos(s)*(1 + 0.1*sin(1e6*s))", "sin(s)*(1 + 0.1*sin(1e6*s))")),
        lambda: library.logarithmic_spiral(1.0, 0.1, 5e-324),
        lambda: Curve(("s", "s**2"), domain=(1.0, 1.0 + 1e-14)),
    ],
)
def test_what_no_table_resolves_is_refused_at_once(make):
    """Within a second; before, the first four took 30 s to minutes."""
    began = time.process_time()
    with pytest.raises(cases.CaseError, match="give a (shorter|wider)"):
        make()
    assert time.process_time() - began < 1.0


def test_a_thousand_arches_are_resolved():
    arches = library.trochoid(1.0, 0.5, 1000)
    assert arches.point(1000.0)[0] == pytest.approx(1000.0 + 0.5 * np.sin(1000.0), rel=1e-15)
