"""Plates of infinite inertia: exact values, agreement of the formulations, and wrong input."""

from math import cos, exp, inf, sin, sqrt

import numpy as np
import pytest
from scipy.optimize import brentq

import reference
from cases import (
    Case,
    CoulombFriction,
    Drive,
    Flight,
    Gravity,
    Impact,
    Mode,
    NotSupported,
    Start,
    Unilateral,
    disc,
)
from cases.library import circle, line
from reference.certification.certificate import NotCertified
from tests.scenes.moving import EXACT, METHODS, G


def block(track, *effects, duration=2.0, plate=None, **start):
    return Case(track, plate or disc(0.1, 1.0, inf), (Gravity(G), *effects), Start(0.0, **start), duration)


@pytest.mark.sampled(5)
@METHODS
@pytest.mark.parametrize("slope", [-0.3, -0.1, 0.0, 0.2])
@pytest.mark.parametrize("mu", [0.25, 0.6])
def test_block_on_a_ramp_stops_at_v_squared_over_twice_its_deceleration(method, slope, mu):
    """v̇ = g sin(slope) − μ g cos(slope) downhill; it stays where tan(slope) ≤ μ."""
    down = G * (sin(slope) - mu * cos(slope))
    case = block(line(slope), CoulombFriction(mu), Unilateral(), duration=4.0, slip=1.2)
    motion = reference.simulate(case, rtol=1e-13, method=method)
    change = motion.transitions[0]
    assert change.time == pytest.approx(-1.2 / down, abs=EXACT)
    assert change.xi1 == pytest.approx(-(1.2**2) / (2 * down), abs=EXACT)
    assert change.after is (Mode.REST if abs(np.tan(slope)) <= mu else Mode.SLIP_BACKWARD)
    assert np.all(motion.omega == 0.0)
    if change.after is Mode.REST:
        assert motion(4.0).friction_force == pytest.approx(-G * sin(slope), abs=EXACT)


@METHODS
def test_speed_around_a_capstan_falls_exponentially_with_the_angle(method):
    """Without gravity N = m v²/L presses, so m v dv/ds = −μ m v²/L."""
    case = Case(circle(1.0), disc(0.1, 1.0, inf), (CoulombFriction(0.2), Unilateral()), Start(0.0, slip=2.0), 4.0)
    end = reference.simulate(case, rtol=1e-13, method=method)(4.0)
    assert end.slip == pytest.approx(2.0 * exp(-0.2 * end.xi1), abs=EXACT)
    assert end.slip == pytest.approx(2.0 / (1 + 0.2 * 2.0 * 4.0 / 0.9), abs=EXACT)
    assert end.normal_force == pytest.approx(end.slip**2 / 0.9, abs=EXACT)


def test_impact_of_a_plate_that_does_not_turn():
    """v_n turns to −e v_n and friction takes μ (1 + e) of it from the slip: there is no rotation to share it."""
    effects = (CoulombFriction(0.1), Unilateral(), Flight(), Impact(0.5))
    case = block(line(), *effects, duration=0.3, slip=2.0, gap=0.2)
    motion = reference.simulate(case, rtol=1e-13)
    time = motion.transitions[0].time
    assert time == pytest.approx(sqrt(2 * 0.2 / G), abs=EXACT)
    after = motion(0.29)
    assert after.vx == pytest.approx(2.0 - 0.1 * 1.5 * G * time, abs=EXACT)
    assert after.vy == pytest.approx(0.5 * G * time - G * (0.29 - time), abs=EXACT)


# --- on a track that turns --------------------------------------------------------------------------------------------

TILT = 0.2
IN_POSES = pytest.mark.parametrize("method", reference.METHODS)


def on_table(*effects, plate=None, start=None, angle=f"-{TILT}*t", duration=2.0):
    """A disc of 0.1 m that does not turn, 0.5 m from the pivot of a table that tilts by 0.2 rad/s."""
    lands = Unilateral(), Flight(), Impact(0.0, "moreau")
    effects = (Gravity(G), Drive(angle=angle), *lands, *effects)
    return Case(line(), plate or disc(0.1, 1.0, inf), effects, start or Start(0.5), duration)


def in_fixed_frame(s, angle):
    """The disc's centre, s along the table and 0.1 m above it."""
    return s * cos(angle) - 0.1 * sin(angle), s * sin(angle) + 0.1 * cos(angle)


@IN_POSES
def test_a_disc_that_does_not_turn_rolls_on_a_tilting_table_until_friction_s_cone(method):
    """Without slip the disc turns by w t against the table and moves along it by −r w t. Its acceleration is −w² s
    along the table and w² r across it, so that T = −w² s − g sin(w t) and N = g cos(w t) + w² r per mass."""
    mu, r, w = 0.3, 0.1, TILT

    def margin(t):
        return mu * (G * cos(w * t) + w**2 * r) - (G * sin(w * t) + w**2 * (0.5 - r * w * t))

    motion = reference.simulate(on_table(CoulombFriction(mu)), rtol=1e-13, method=method)
    change = motion.transitions[0]
    assert change.time == pytest.approx(brentq(margin, 1.0, 2.0, xtol=1e-15), abs=EXACT)
    assert (change.before, change.after) == (Mode.ROLL, Mode.SLIP_FORWARD)
    at = motion(1.0)
    assert (at.x, at.y) == pytest.approx(in_fixed_frame(0.5 - r * w, -w), abs=EXACT)
    assert at.friction_force == pytest.approx(-(w**2) * (0.5 - r * w) - G * sin(w), abs=EXACT)
    assert np.abs(motion.omega).max() < EXACT and reference.check(on_table(CoulombFriction(mu)), motion) == ()


def test_rolling_without_turning_on_a_table_that_swings_has_no_second_formulation():
    case = on_table(CoulombFriction(0.3), angle="0.1*sin(5*t)", duration=0.5)
    assert reference.check(case, reference.simulate(case)) == ()
    try:
        missing = reference.certify(case).missing
    except NotCertified as problem:  # without heyoka it would have been the second witness
        missing = (str(problem),)
    assert any("a plate of infinite inertia is on a track that turns" in text for text in missing)
    with pytest.raises(NotSupported, match="one contact"):
        reference.simulate(case, method="augmented")
