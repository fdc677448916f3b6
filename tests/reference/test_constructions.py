"""Curves by integrals, special functions, polar form, curvature, and in pieces: exact values, and motions on them."""

import pickle

import numpy as np
import pytest
import sympy as sp
from scipy.special import ellipeinc, ellipkinc, erf, fresnel

import reference
from cases import Case, CoulombFriction, Curve, Gravity, NotSupported, Plate, Start, Unilateral, disc
from cases.constructions import natural, piecewise, polar
from cases.curves import cos, exp, integral, sin
from cases.library import line
from tests.scenes.agreement import agree

GRIP = (Gravity(9.81), CoulombFriction(0.1), Unilateral())


# --- integrals and special functions ----------------------------------------------------------------------------------

HEIGHTS = {
    "fresnels": (sp.fresnels, lambda s: fresnel(s)[0]),
    "fresnelc": (sp.fresnelc, lambda s: fresnel(s)[1]),
    "erf": (sp.erf, erf),
    "elliptic_f": (lambda s: sp.elliptic_f(s, 0.6), lambda s: ellipkinc(s, 0.6)),
    "elliptic_e": (lambda s: sp.elliptic_e(s, 0.6), lambda s: ellipeinc(s, 0.6)),
    "integral of a formula": (lambda s: integral(lambda u: exp(u), s**2, lower=1), lambda s: np.exp(s**2) - np.e),
}


@pytest.mark.parametrize("name", HEIGHTS)
def test_special_functions_have_scipys_values_and_elementary_derivatives(name):
    formula, value = HEIGHTS[name]
    curve = Curve(lambda s: (s, formula(s)), (-1.4, 1.4))
    s = np.linspace(-1.4, 1.4, 301)
    assert np.abs(curve.point(s)[1] - value(s)).max() <= 4e-15 * max(1.0, np.abs(value(s)).max())
    h = 1e-4  # a central difference of the values, with the error h²
    slope = (value(s[1:-1] + h) - value(s[1:-1] - h)) / (2 * h)
    assert np.abs(curve.jets(s[1:-1])[3] - slope).max() <= 1e-6
    assert curve.point(0.3)[1] == curve.point(np.array([0.3]))[1, 0]
    assert pickle.loads(pickle.dumps(curve)) == curve


def test_a_curve_by_its_curvature_has_it():
    curve = natural(lambda s: 2.0 / (1 + s**2), length=3.0, start=(1.0, 2.0), angle=0.3)
    s = np.linspace(0.0, 3.0, 200)
    assert np.abs(curve.curvature(s) - 2.0 / (1 + s**2)).max() <= 1e-14
    assert np.abs(curve.speed(s) - 1.0).max() <= 1e-15
    assert np.abs(curve.tangent_angle(s) - 0.3 - 2.0 * np.arctan(s)).max() <= 1e-14
    assert curve.point(0.0) == pytest.approx([1.0, 2.0])
    circle = natural(lambda s: 4.0 + 0 * s, length=float(np.pi / 2))
    assert circle.point(circle.domain[1]) == pytest.approx([0.0, 0.0], abs=1e-15)


def test_an_outline_by_integrals_is_simulated_by_dop853():
    """A circle by the integrals of its tangent; the Taylor method has no such function, and says what to use."""
    r = 0.1
    outline = Curve(
        lambda s: (r + integral(lambda u: -r * sin(u), s), integral(lambda u: r * cos(u), s)), (0.0, 2 * np.pi)
    )
    cases = [Case(line(0.3), plate, GRIP, Start(0.0, xi2, omega=-3.0), 1.0) for plate, xi2 in (
        (Plate(outline, 1.0, 0.005), 1.5 * np.pi), (disc(r, 1.0), -np.pi / 2)
    )]  # fmt: skip
    ends = [reference.simulate(case, 1e-12, "dop853")(1.0) for case in cases]
    assert ends[0].x == pytest.approx(ends[1].x, abs=1e-11)
    assert reference.simulate(cases[0], 1e-12)(1.0).x == ends[0].x  # what `simulate` chooses
    if "taylor" not in reference.METHODS:
        return
    with pytest.raises(NotSupported, match="give method='dop853'"):
        reference.simulate(cases[0], method="taylor")


# --- polar form and pieces --------------------------------------------------------------------------------------------


def test_polar_form_is_the_logarithmic_spiral_of_the_library():
    spiral = polar(lambda a: 0.1 * exp(0.2 * a), (0.0, 3.0))
    s = np.linspace(0.0, 3.0, 50)
    assert np.abs(np.hypot(*spiral.point(s)) - 0.1 * np.exp(0.2 * s)).max() <= 1e-15
    assert np.abs(spiral.curvature(s) - 1 / (np.hypot(1.0, 0.2) * np.hypot(*spiral.point(s)))).max() <= 1e-12


def ramp_and_arc(radius=0.5, sign=1.0):
    """A level metre, and an arc that rises (or falls) from its end."""
    level = Curve(("s", "0.0"), (0.0, 1.0))
    arc = Curve(lambda s: (1 + radius * sin(s), sign * (radius - radius * cos(s))), (0.0, 1.2))
    return piecewise([level, arc])


def test_a_disc_rolls_onto_an_arc_where_the_curvature_jumps():
    """It has the speed v at the joint: the normal force jumps from m g to m (g + v²/(R − r)), and nothing else does."""
    track, r, v = ramp_and_arc(), 0.1, 1.5
    case = Case(track, disc(r, 1.0), (Gravity(9.81), CoulombFriction(1.0), Unilateral()), Start(0.3, omega=-v / r), 1.0)
    motion = agree(case)
    assert agree(case, method="dop853").transitions == motion.transitions == ()
    joint = (1.0 - 0.3) / v
    before, after = motion(joint - 1e-9), motion(joint + 1e-9)
    assert before.normal_force == pytest.approx(9.81, rel=1e-12)
    assert after.normal_force == pytest.approx(9.81 + v**2 / 0.4, rel=1e-6)
    assert after.omega == pytest.approx(before.omega, abs=1e-7) and after.slip == before.slip == 0.0
