"""What ends a regime or a motion, away from the paper's application."""

import subprocess
import sys
from dataclasses import replace
from math import atan2, cos, pi, sin

import numpy as np
import pytest

import cases
import reference
from cases import (
    Case,
    CoulombFriction,
    Curve,
    Flight,
    Gravity,
    Impact,
    Load,
    Mode,
    Plate,
    Start,
    Unilateral,
    disc,
    library,
)  # fmt: skip
from cases import curves as c
from reference.minimal.elimination import Elimination
from reference.minimal.modes import Regime, phase
from tests.scenes import second as second_states
from tests.scenes.elliptic import ellipse

pytestmark = pytest.mark.taylor


def valley(depth: float) -> Curve:
    return Curve(lambda s: (s, -depth * c.cos(2 * s)), domain=(-3, 3))


@pytest.mark.parametrize("method", reference.METHODS)
def test_a_disc_too_wide_for_the_bottom_of_a_valley_stops_at_its_second_contact(method):
    # Curvature 2 1/m at the bottom, so a disc of 0.6 m touches both flanks at once when its centre is above the bottom.
    case = Case(valley(0.5), disc(0.6, 1.0), (Gravity(9.81), CoulombFriction(0.2), Unilateral()), Start(-1.2), 3.0)
    motion = reference.simulate(case, method=method)
    assert motion.status == "second_contact"
    assert motion.x[-1] == pytest.approx(0.0, abs=1e-9)
    assert f"{-motion.xi1[-1]:.6g}"[:6] in motion.reason


def test_a_disc_that_fits_the_valley_crosses_its_inflections():
    case = Case(valley(0.3), disc(0.1, 1.0), (Gravity(9.81), CoulombFriction(0.1), Unilateral()), Start(-1.0), 3.0)
    motion = reference.simulate(case)
    assert motion.status == "completed"
    assert np.sign(case.track.curvature(motion.xi1)).min() < 0 < np.sign(case.track.curvature(motion.xi1)).max()


@pytest.mark.parametrize("method", reference.METHODS)
def test_the_end_of_an_open_track_is_told_with_its_time(method):
    track = Curve(lambda s: (s, 0), domain=(-0.5, 0.7))
    case = Case(track, disc(0.1, 1.0), (Gravity(9.81),), Start(0.0, slip=1.0, omega=0.0), 3.0)
    motion = reference.simulate(case, method=method)
    assert motion.status == "track_end"
    assert motion.t[-1] == pytest.approx(0.7, abs=1e-12)  # at 1 m/s, without friction


@pytest.mark.parametrize("rtol", [1e-3, 1e-4, 1e-5])
@pytest.mark.parametrize("method", reference.METHODS)
def test_a_guide_presses_from_its_other_side_at_a_coarse_tolerance(method, rtol):
    """Where the force vanishes along the step's polynomial, it has what the tolerance leaves: no paradox."""
    motion = reference.simulate(cases.load("guided_loop"), rtol=rtol, method=method)
    assert motion.status == "completed", motion.reason
    (only,) = motion.transitions
    assert only.after is Mode.SLIP_BACKWARD
    assert only.time == pytest.approx(0.558574238439291, rel=rtol)  # proved, see reference/proofs/catalogue.json


@pytest.mark.parametrize(
    ("method", "mu"),
    [("dop853", 0.3), *(pytest.param("taylor", mu, marks=pytest.mark.slow) for mu in (0.3, 0.5))],
)
def test_a_guide_changes_its_side_while_the_plate_slips_slowly(method, mu):
    """The slip is then less than the tolerance's part of the spin, but not zero: the plate continues to slip."""
    case = cases.load("guided_loop", ratio=8.0, mu=mu)
    rough, fine = reference.simulate(case, rtol=1e-2, method=method), reference.simulate(case, rtol=1e-12)
    assert rough.status == "completed", rough.reason
    assert [(e.before, e.after) for e in rough.transitions] == [(e.before, e.after) for e in fine.transitions]
    assert [e.time for e in rough.transitions] == pytest.approx([e.time for e in fine.transitions], rel=1e-2)


def swinging(spin: float) -> Case:
    """A disc spun up and let go on the flank of a circle: its slip r·omega + L·ξ̇₁ is smallest at the bottom."""
    circle = Curve(lambda s: (c.cos(s), c.sin(s)))
    effects = (Gravity(9.81, pi / 2), CoulombFriction(0.01), Unilateral())
    return Case(circle, disc(0.1, 1.0), effects, Start(pi / 2 + 1.0, slip=0.1 * spin, omega=spin), 1.0)


@pytest.fixture(scope="module")
def critical_spin():
    """The spin at which the slip just touches zero, by bisection to rounding; the slope is one part in ten."""
    low, high = 25.0, 35.0
    while high - low > 1e-11:
        middle = 0.5 * (low + high)
        crosses = bool(reference.simulate(swinging(middle), rtol=1e-13).transitions)
        low, high = (middle, high) if crosses else (low, middle)
    return high


@pytest.mark.parametrize("method", reference.METHODS)
@pytest.mark.parametrize("depth", [1e-5, 1e-7])
def test_two_zeros_of_the_slip_inside_one_step_are_not_missed(critical_spin, method, depth):
    # The slip would dip below zero by about `depth`, for milliseconds, inside steps of a tenth of a second. Where it
    # touches zero its rate vanishes too, so rolling takes exactly the cone's friction: a shallow dip is a short roll.
    motion = reference.simulate(swinging(critical_spin - 10 * depth), rtol=1e-10, method=method)
    assert [t.after for t in motion.transitions] == [Mode.ROLL, Mode.SLIP_FORWARD]
    assert motion.transitions[1].time - motion.transitions[0].time < 5 * depth**0.5


@pytest.mark.parametrize("method", reference.METHODS)
def test_slip_that_comes_near_zero_without_reaching_it_is_no_transition(critical_spin, method):
    motion = reference.simulate(swinging(critical_spin + 1e-6), rtol=1e-10, method=method)
    assert motion.transitions == ()
    assert 0 < motion(np.linspace(0, 1, 2001)).slip.min() < 1e-4


def test_painleve_number_is_that_of_the_sliding_rod():
    # A slender rod of length 2l sliding on a small round end: the textbook threshold is that of a point.
    length, end = 1.0, 1e-9
    outline = Curve(lambda s: (-length / 2 + end * c.cos(s), end * c.sin(s)))
    rod = Plate(outline, 1.0, length**2 / 12)
    for phi in (0.4, atan2(2, 1), 1.3):
        for mu in (0.5, 4 / 3, 2.0):
            # Sliding backwards with its centre of mass ahead of the contact, the rod digs its end in.
            effects = (Gravity(9.81), CoulombFriction(mu), Unilateral())
            case = Case(Curve(lambda s: (s, 0)), rod, effects, Start(0.0, xi2=-pi / 2 - phi, slip=-1.0), 0.1)
            now = phase(case, Regime(Mode.SLIP_BACKWARD))
            state = (0.0, -pi / 2 - phi, 0.0, 0.0)
            number = Elimination(*now.system.outputs_of_numbers(0.0, state, now.parameters)).inverse_mass
            textbook = 1 + 3 * cos(phi) ** 2 - 3 * mu * sin(phi) * cos(phi)
            assert number == pytest.approx(textbook, abs=1e-7)  # the end's radius, 1e-9, is what differs


def test_a_motion_into_the_paradox_is_told_as_such():
    outline = Curve(lambda s: (-0.5 + 0.01 * c.cos(s), 0.01 * c.sin(s)))
    rod = Plate(outline, 1.0, 1 / 12)
    effects = (Gravity(9.81), CoulombFriction(3.0), Unilateral())
    statuses = set()
    for omega in (-2.0, 0.0, 2.0):
        for slip in (-2.0, 2.0):
            case = Case(
                Curve(lambda s: (s, 0)), rod, effects, Start(0.0, xi2=-pi / 2 - 1.1, slip=slip, omega=omega), 1.0
            )
            motion = reference.simulate(case)
            assert np.all(np.isfinite(motion.x))
            statuses.add(motion.status)
    assert "paradox" in statuses


def test_static_friction_above_kinetic_holds_up_to_its_own_cone():
    # A disc at rest inside a circle where rolling needs more than kinetic but less than static friction.
    xi1 = pi / 2 + 0.5
    need = (9.81 / 3 * abs(cos(xi1))) / (9.81 * sin(xi1))
    effects = (Gravity(9.81, pi / 2), CoulombFriction(0.5 * need, mu_static=1.01 * need), Unilateral())
    case = Case(ellipse(1.0, 1.0), disc(0.1, 1.0), effects, Start(xi1), 0.05)
    assert reference.simulate(case).first_mode is Mode.ROLL
    slips = (Gravity(9.81, pi / 2), CoulombFriction(0.5 * need, mu_static=0.99 * need), Unilateral())
    assert (
        reference.simulate(Case(ellipse(1.0, 1.0), disc(0.1, 1.0), slips, Start(xi1), 0.05)).first_mode is not Mode.ROLL
    )


def test_a_bilateral_guide_holds_the_plate_where_a_unilateral_track_lets_go():
    hill = Curve(lambda s: (c.sin(s), c.cos(s)), domain=(-3.0, 3.0))
    one = Case(hill, disc(0.1, 1.0), (Gravity(9.81), CoulombFriction(0.2), Unilateral()), Start(0.3, slip=1.0), 1.2)
    two = Case(hill, disc(0.1, 1.0), (Gravity(9.81), CoulombFriction(0.2)), Start(0.3, slip=1.0), 1.2)
    assert reference.simulate(one).status == "lift_off"
    guided = reference.simulate(two)
    assert guided.t[-1] > reference.simulate(one).t[-1]
    t = np.linspace(0.0, guided.t[-1], 200)
    state = guided(t)
    assert state.normal_force.min() < 0 < state.normal_force.max()
    slips = np.abs(state.slip) > 1e-9
    ratio = state.friction_force[slips] / np.abs(state.normal_force[slips])
    assert ratio == pytest.approx(-0.2 * np.sign(state.slip[slips]), abs=1e-9)


@pytest.mark.slow
def test_without_heyoka_everything_works_and_says_once_which_method_it_used():
    program = (
        "import sys, logging; sys.modules['heyoka'] = None\n"
        "logging.basicConfig(format='%(message)s')\n"
        "import cases, reference\n"
        "for _ in range(2): motion = reference.simulate(cases.load('disc_in_circle', mu=0.2))\n"
        "print(reference.METHODS, motion.transitions[0].time)\n"
        "reference.simulate(cases.load('disc_in_circle'), method='dop853')\n"
    )
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert run.stdout.startswith("('dop853',) 0.63005376")
    assert run.stderr.count("dop853") == 1


@pytest.mark.sampled(2, first=1)
@pytest.mark.parametrize("method", reference.METHODS)
def test_a_loose_tolerance_does_not_change_what_follows_a_transition(method):
    # An elliptic plate in a cosine valley: its slip reverses, and a coarse motion must not mistake that for a lift-off.
    plate = Plate(ellipse(0.15, 0.1), 1.0, 0.008)
    case = Case(valley(0.3), plate, (Gravity(9.81), CoulombFriction(0.1), Unilateral()), Start(-1.0), 3.0)
    fine = [t.after for t in reference.simulate(case, rtol=1e-10, method=method).transitions]
    coarse = reference.simulate(case, rtol=1e-3, method=method)
    assert [t.after for t in coarse.transitions] == fine


def test_a_growing_load_lifts_a_disc_off_that_rolls_without_friction():
    """N = m g − 30 t vanishes at g/30 s together with the bounds on a friction that is not needed. A slip was listed
    there first, and on a track with corners the first formulation slipped and rolled in turn 2,000 times, and ended."""
    lift = (Load(fy="30*t"), Flight(), Impact(0.3))
    kept = tuple(e for e in cases.load("disc_over_edge").effects if not isinstance(e, Flight | Impact))
    for case in (
        Case(
            library.line(), disc(0.1, 1.0), (Gravity(9.81), CoulombFriction(0.2), Unilateral(), *lift), Start(0.0), 2.0
        ),
        replace(cases.load("disc_over_edge"), effects=(*kept, *lift)),
    ):
        for motion in (
            *(reference.simulate(case, method=method) for method in reference.METHODS), second_states.motion(case)
        ):  # fmt: skip
            assert motion.status == "completed"
            assert [t.after for t in motion.transitions] == [Mode.FLIGHT]
            assert motion.transitions[0].time == pytest.approx(9.81 / 30.0, abs=1e-12)


def test_a_plate_with_corners_that_a_load_lifts_from_the_start_flies():
    """Its start was rejected, as "a curve with corners has no single formula"."""
    case = cases.load("half_disc_rocking")
    kept = tuple(e for e in case.effects if not isinstance(e, Flight | Impact))
    case = replace(case, effects=(*kept, Load(fy="30"), Flight(), Impact(0.3)))
    motion, other = reference.simulate(case), second_states.motion(case, until=1.0)
    assert motion.first_mode is Mode.FLIGHT and not motion.transitions and not other.transitions
    assert motion(1.0).y == pytest.approx(other.last.motion[1], abs=1e-9)
    # Weightless but for 30 N upwards.
    assert motion(1.0).vy == pytest.approx(30.0 / case.plate.mass - 9.81 + motion(0.0).vy, abs=1e-11)
