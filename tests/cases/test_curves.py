"""Curves: the library against what is known of its curves, strings, measured points, and the errors of all three."""

from math import gamma, pi, sinh

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import ellipe

from cases import Curve, library
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


def test_strings_and_a_function_give_one_curve():
    assert Curve(("s", "-0.3*cos(2*s)"), (-3, 3)) == Curve(lambda s: (s, -0.3 * c.cos(2 * s)), (-3, 3))


@pytest.mark.parametrize("curve", [library.ellipse(1.2, 0.8), library.line(0.3), Curve(("s", "sin(s)"), (-3.0, 4.0)),
                                   library.cycloid(0.25)])  # fmt: skip
def test_the_tangents_angle_counts_the_same_turns_for_a_number_as_for_an_array(curve):
    """Also at the ends of the range in which they are tabulated, and far beyond."""
    low, high = curve.span
    s = np.concatenate([np.linspace(low - 3 * (high - low), high + 3 * (high - low), 91), [low, high]])
    s = s if curve.domain is None else s[(low <= s) & (s <= high)]
    # The angle itself comes from two arctangents, of math and of NumPy.
    assert [curve.tangent_angle(float(x)) for x in s] == pytest.approx(curve.tangent_angle(s).tolist(), abs=1e-14)
