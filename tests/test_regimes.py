"""What ends a regime or a motion, away from the paper's application."""

from math import atan2, cos, pi, sin

import numpy as np
import pytest

import reference
from cases import Case, CoulombFriction, Curve, Gravity, Mode, Plate, Start, Unilateral, disc
from cases import curves as c
from reference.modes import Regime, phase
from tests.scenes import ellipse


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


@pytest.mark.parametrize("method", reference.METHODS)
def test_two_zeros_of_the_slip_inside_one_step_are_not_missed(method):
    # A ball thrown up an incline with a little top-spin: slip dips below zero for a moment only. The dip is sought by
    # bisection on the throw, down to a depth of 1e-7 m/s; both sides of it must be told apart.
    def first(spin):
        track = Curve(lambda s: (c.cos(s), c.sin(s)))
        effects = (Gravity(9.81, pi / 2), CoulombFriction(0.01), Unilateral())
        case = Case(track, disc(0.1, 1.0), effects, Start(pi / 2 - 1.0, slip=spin, omega=0.0), 6.0)
        motion = reference.simulate(case, rtol=1e-9, method=method)
        t = np.linspace(0.0, motion.t[-1], 4000)
        return motion, motion(t).slip

    for spin in np.linspace(0.05, 2.0, 14):
        motion, slip = first(spin)
        changes = np.count_nonzero(np.diff(np.sign(slip[np.abs(slip) > 1e-9])))
        reversals = sum(t.before is not t.after and t.cause == "the slip velocity vanished" for t in motion.transitions)
        assert reversals >= changes


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
            number = now.system.observed_of_numbers(0.0, (0.0, -pi / 2 - phi, 0.0, 0.0), now.parameters)[-1]
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


def test_a_two_sided_guide_holds_the_plate_where_a_one_sided_track_lets_go():
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
