"""Corners that pass ends and corners, sides that lie flat, and plates that float: exact motions."""

from dataclasses import replace
from math import cos, inf, sin, sqrt

import pytest
from scipy.integrate import quad

import reference
from cases import (
    Case,
    Chain,
    Curve,
    Outline,
    Plate,
    StartPose,
    Support,
)

from .test_compositions import BOX, INELASTIC, METHOD, G


@METHOD
@pytest.mark.parametrize("support", [False, True])
@pytest.mark.parametrize("corner", [-0.05, -0.3])
def test_a_side_that_turns_flat_over_the_end_of_a_shelf_reaches_it(corner, support, method):
    """A box turns about its corner, which slides without friction: by energy, ω² (y′² + I/m)/2 + g y is constant, with
    its centre at y = (w sin θ + h cos θ)/2. The side is 0.2 m long: from −0.3 its next corner lands on the shelf."""
    inertia, tilt, spin = (0.2**2 + 0.1**2) / 12.0, 0.4, -1.0

    def height(theta: float) -> tuple[float, float]:
        return 0.1 * sin(theta) + 0.05 * cos(theta), 0.1 * cos(theta) - 0.05 * sin(theta)

    def energy(theta: float, omega: float) -> float:
        y, arm = height(theta)
        return 0.5 * omega**2 * (arm**2 + inertia) + G * y

    def speed(theta: float) -> float:
        return sqrt(2.0 * (energy(tilt, spin) - energy(theta, 0.0)) / (height(theta)[1] ** 2 + inertia))

    flat = quad(lambda theta: 1.0 / speed(theta), 0.0, tilt, epsabs=1e-14)[0]
    y, arm = height(tilt)
    start = StartPose(corner + 0.1 * cos(tilt) - 0.05 * sin(tilt), y, tilt, vy=arm * spin, omega=spin)
    shelf, wall = Curve(lambda s: (s, 0 * s), (-3.0, 0.0)), Support(Curve(("2.0", "s")), "wall")
    case = Case(shelf, BOX, INELASTIC, start, 0.5, supports=(wall,) if support else ())
    motion = reference.simulate(case, method=method)
    assert not reference.check(case, motion)
    if corner == -0.05:
        assert (motion.status, motion.transitions) == ("track_end", ())
        assert motion.t[-1] == pytest.approx(flat, abs=2e-9)  # a side is flat to 1e-9 rad
    else:
        assert motion.status == "completed"
        assert motion.transitions[0].time == pytest.approx(flat, abs=1e-10)


@METHOD
@pytest.mark.parametrize("length", [0.3, 0.31, 0.7])
def test_a_corner_that_slides_into_an_inner_corner_climbs_the_other_flank(length, method):
    """Without friction, turning or rebound, of the speed V the part along the other flank remains, V cos 2a."""
    a, tip = (
        0.5,
        Plate.homogeneous(
            Outline.polygon([(0.0, 0.0), (0.05, 0.2), (-0.05, 0.2)]),
            1.0,
        ),
    )
    speed = sqrt(2.0 * G * sin(a) * length)
    arrival, climb = speed / (G * sin(a)), 2.0 * speed * cos(2.0 * a) / (G * sin(a))
    valley = Chain.polyline([(-3.0 * cos(a), 3.0 * sin(a)), (0.0, 0.0), (3.0 * cos(a), 3.0 * sin(a))])
    start = StartPose(-length * cos(a), length * sin(a) + 2.0 * 0.2 / 3.0)
    case = Case(valley, replace(tip, inertia=inf), INELASTIC, start, arrival + 0.3)
    motion = reference.simulate(case, method=method)
    assert motion.status == "completed"
    assert not reference.check(case, motion)
    assert motion.transitions[0].time == pytest.approx(arrival, abs=1e-9)
    after = motion(arrival + 0.5 * min(climb, 0.2))
    expected = speed * cos(2.0 * a) - G * sin(a) * 0.5 * min(climb, 0.2)
    assert (after.vx, after.vy) == pytest.approx((expected * cos(a), expected * sin(a)), abs=1e-8)
