"""Plates of infinite inertia: exact values, agreement of the formulations, and wrong input."""

from dataclasses import replace
from math import atan2, cos, exp, inf, pi, sin, sqrt

import numpy as np
import pytest

import cases
import reference
from cases import (
    BadValue,
    Case,
    CoulombFriction,
    DoesNotFit,
    Flight,
    Gravity,
    Impact,
    Load,
    Mode,
    Plate,
    RollingResistance,
    Start,
    Unilateral,
    disc,
)
from cases.library import circle, cosine, ellipse, hill, line
from reference.paper.augmented import fill
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


@pytest.mark.sampled(3)
@METHODS
def test_slider_on_a_spring_loses_the_same_amplitude_in_every_half_swing(method):
    """A half swing about ±μ m g/k lasts π √(m/k); it rests where the spring cannot overcome friction."""
    k, mu, stretch = 40.0, 0.1, 0.2
    case = block(line(), CoulombFriction(mu), Load(fx=f"-{k}*x"), Unilateral(), duration=4.0)
    case = replace(case, start=Start(stretch))
    motion = reference.simulate(case, rtol=1e-13, method=method)
    centre, place = mu * G / k, stretch
    for number, change in enumerate(motion.transitions, start=1):
        place = -np.sign(place) * (abs(place) - 2 * centre)
        assert change.time == pytest.approx(number * pi / sqrt(k), abs=10 * EXACT)
        assert change.xi1 == pytest.approx(place, abs=10 * EXACT)
    assert motion.transitions[-1].after is Mode.REST
    assert abs(place) <= centre


def test_particle_leaves_a_cylinder_at_two_thirds_of_its_height():
    """cos φ = 2/3, as for a particle on the path of its centre."""
    case = Case(hill(1.0), disc(0.1, 1.0, inf), (Gravity(G), Unilateral()), Start(1e-3), 3.0)
    motion = reference.simulate(case, rtol=1e-13)
    assert motion.status == "lift_off"
    assert motion.y[-1] / 1.1 == pytest.approx(2 / 3 * cos(1e-3), abs=EXACT)


def test_stick_slip_on_a_belt_has_its_closed_period():
    """It sticks until k x = μ_s m g; the slip x = c + a cos φ, c = μ m g/k, ends when its speed is again the belt's."""
    speed, k, mu, static = 0.2, 40.0, 0.2, 0.4
    case = cases.load("slider_on_belt", speed=speed, k=k, mu=mu, mu_static=static)
    motion = reference.simulate(case, rtol=1e-13)
    omega, centre, far = sqrt(k), mu * G / k, static * G / k
    # In units of 1/ω: from (far − c, speed/ω) around the circle to (−(far − c), speed/ω).
    phase = atan2(speed / omega, far - centre)
    slips = (pi + 2 * phase) / omega
    sticks = 2 * (far - centre) / speed
    begins = [t.time for t in motion.transitions if t.after is Mode.SLIP_BACKWARD]
    ends = [t.time for t in motion.transitions if t.after is Mode.REST]
    assert [e - b for b, e in zip(begins, ends, strict=False)] == pytest.approx([slips] * len(ends), abs=1e-11)
    assert np.diff(begins) == pytest.approx(np.full(len(begins) - 1, slips + sticks), abs=1e-11)


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


def test_matrix_loses_the_row_and_column_of_the_rotation():
    case = block(circle(1.0), CoulombFriction(0.2), Unilateral(), slip=1.0)
    case = replace(case, start=Start(-1.0, slip=1.0))
    state = (-1.0, -1.0, 1.0 / 0.9, 1.0 / 0.9 * 1.0)
    assert fill(case, Mode.SLIP_FORWARD, state).matrix.shape == (5, 5)
    assert fill(case, Mode.REST, state).matrix.shape == (6, 6)


def test_wrong_plates_are_rejected_with_what_to_give():
    with pytest.raises(BadValue, match="give omega=0"):
        block(line(), CoulombFriction(0.1), omega=1.0)
    with pytest.raises(DoesNotFit, match="leave RollingResistance out"):
        block(line(), CoulombFriction(0.1), RollingResistance(0.01))
    with pytest.raises(BadValue, match="inertia of the plate"):
        Plate(ellipse(0.1, 0.05), 1.0, -inf)


def test_sweep_simulates_them_one_by_one():
    rows = reference.sweep("block_on_ramp", mu=[0.2, 0.4])
    assert list(rows["first_time"]) == pytest.approx([1 / (0.2 * G), 1 / (0.4 * G)], abs=EXACT)


def test_a_valley_of_waves_holds_a_block_on_its_slopes():
    """It rests where the slope of the path of its centre is at most μ."""
    case = Case(
        cosine(0.1, 2.0), disc(0.05, 1.0, inf), (Gravity(G), CoulombFriction(0.15), Unilateral()), Start(-0.6), 5.0
    )
    motion = reference.simulate(case, rtol=1e-13)
    assert motion.transitions[-1].after is Mode.REST
    tangent = case.track.tangent(motion.transitions[-1].xi1)
    assert abs(tangent[1] / tangent[0]) <= 0.15 * (1 + 1e-9)
