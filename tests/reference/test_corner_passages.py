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
    Flight,
    FreePlate,
    Gravity,
    Impact,
    Load,
    Mode,
    Outline,
    PerfectlyRough,
    Plate,
    StartPose,
    Support,
    Unilateral,
    disc,
)
from cases.library import line

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


@METHOD
@pytest.mark.parametrize("angle", [0.08, 0.2, 0.3, 0.31, 0.7])
def test_a_side_that_slides_off_an_edge_falls_freely(angle, method):
    """A box that does not turn slides down by g sin a, its side on the edge, and then flies on."""
    table = Chain.polyline([(-3.0, 0.0), (0.0, 0.0), (0.0, -3.0)])
    x, y = 0.02, 0.05  # of the centre from the edge, along the side and across
    start = StartPose(x * cos(angle) + y * sin(angle), y * cos(angle) - x * sin(angle), -angle)
    case = Case(table, replace(BOX, inertia=inf), INELASTIC, start, 0.5)
    motion = reference.simulate(case, method=method)
    leaves = sqrt(2.0 * (0.1 - x) / (G * sin(angle)))
    assert (motion.status, [one.after for one in motion.transitions]) == ("completed", [Mode.FLIGHT])
    assert motion.transitions[0].time == pytest.approx(leaves, abs=1e-10)
    speed, rest = G * sin(angle) * leaves, 0.5 - leaves
    assert motion.vx[-1] == pytest.approx(speed * cos(angle), abs=1e-9)
    assert motion.vy[-1] == pytest.approx(-speed * sin(angle) - G * rest, abs=1e-9)


@METHOD
@pytest.mark.parametrize("height", [0.3, 0.31, 0.447])
def test_a_disc_floats_on_a_rough_box_that_a_load_pushes_as_both_fall(height, method):
    """Nothing presses them together, so that no friction acts: the box moves by f t²/2m, the disc falls straight."""
    effects = (Gravity(G), Unilateral(), Flight(), Impact(0.0, "moreau"), PerfectlyRough(), Load(fx=2.5))
    others = (FreePlate(disc(0.06, 2.0), StartPose(0.0, height + 0.11), "disc"),)
    case = Case(line(), BOX, effects, StartPose(0.0, height), 0.2, others=others)
    motion = reference.simulate(case, method=method)
    assert (motion.status, motion.transitions) == ("completed", ())
    assert motion.x[-1] == pytest.approx(0.5 * 2.5 * 0.2**2, abs=1e-12)
    assert motion.plate("disc").x[-1] == 0.0


@METHOD
@pytest.mark.parametrize("inertia", [inf, 1.0 / 240.0])
@pytest.mark.parametrize("wall", [-0.1, -0.3])
def test_a_block_without_friction_moves_as_soon_as_a_load_begins(wall, inertia, method):
    """From rest, on a table and next to a wall that it leaves at once: x = 4 t/3 − 4 sin(3 t)/9 under 4 sin 3t."""
    support, load = Support(Curve((repr(wall), "-s")), "wall"), Load(fx="4*sin(3*t)")
    plate = replace(BOX, inertia=inertia)
    case = Case(line(), plate, (*INELASTIC, load), StartPose(0.0, 0.05), 1.2, supports=(support,))
    motion = reference.simulate(case, method=method)
    assert motion.status == "completed"
    assert {one.contact.partition(" ")[0] for one in motion.transitions} <= {"plate/wall"}
    assert all(type(one.time) is float and one.time == 0.0 for one in motion.transitions)
    assert motion.x[-1] == pytest.approx(4.0 / 3.0 * 1.2 - 4.0 / 9.0 * sin(3.6), abs=1e-9)
