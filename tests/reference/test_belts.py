"""A belt: exact values, agreement of three assemblies of the equations, the work that it does, and wrong input."""

from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest

import cases
import reference
from cases import Belt, Case, CoulombFriction, Flight, Gravity, Impact, Mode, Plate, Start, Unilateral, disc
from cases.library import circle, ellipse, line
from tests.sampling import quick_every
from tests.scenes.agreement import agree
from tests.scenes.moving import EXACT, METHODS, G, M, R, on_line


@quick_every(5)
@METHODS
@pytest.mark.parametrize("speed", [0.7, -1.3])
def test_disc_set_down_on_a_conveyor_rolls_after_its_speed_over_3_mu_g(method, speed):
    """Friction μ m g drives the centre with μ g and the spin with μ m g r/J = 2 μ g/r: the slip changes by 3 μ g."""
    motion = reference.simulate(on_line(Belt(speed), slip=-speed), rtol=1e-13, method=method)
    (change,) = motion.transitions
    assert change.time == pytest.approx(abs(speed) / (3 * 0.2 * G), abs=EXACT)
    assert change.after is Mode.ROLL
    end = motion(2.0)
    assert end.vx == pytest.approx(speed / 3, abs=EXACT)
    assert end.omega == pytest.approx(2 * speed / (3 * R), abs=10 * EXACT)
    assert end.friction_force == pytest.approx(0.0, abs=EXACT)


@METHODS
def test_disc_on_a_belt_that_accelerates_more_and_more_rolls_until_three_mu_g(method):
    """Rolling on a belt of acceleration a: J ω̇ = T r, m v̇ = T and v̇ + r ω̇ = a give T = m a/3 ≤ μ m g."""
    mu, jerk = 0.2, 4.0
    motion = reference.simulate(on_line(Belt(f"{jerk / 2}*t**2"), mu=mu), rtol=1e-13, method=method)
    (change,) = motion.transitions
    assert (change.before, change.after) == (Mode.ROLL, Mode.SLIP_BACKWARD)
    assert change.time == pytest.approx(3 * mu * G / jerk, abs=EXACT)
    at = motion(1.0)
    assert at.friction_force == pytest.approx(M * jerk / 3, abs=10 * EXACT)
    assert at.vx == pytest.approx(jerk / 6, abs=EXACT)


@quick_every(3)
@METHODS
def test_belt_of_constant_speed_changes_nothing_for_a_rolling_pendulum(method):
    """In v = b the belt's acceleration does not occur: (3/2) (R − r) φ̈ = −g sin φ, with the period of its swing."""
    swing, length = 0.5, 1.5 * 0.9
    effects = (Gravity(G), CoulombFriction(0.8), Unilateral(), Belt(1.7))
    case = Case(circle(1.0), disc(R, M), effects, Start(-pi / 2 + swing, omega=17.0), 2.0)
    motion = reference.simulate(case, rtol=1e-13, method=method)
    assert not motion.transitions
    # The period of a pendulum by the arithmetic-geometric mean.
    a, b = 1.0, np.cos(swing / 2)
    while abs(a - b) > 1e-16:
        a, b = (a + b) / 2, sqrt(a * b)
    quarter = pi / (2 * a) * sqrt(length / G)
    assert motion(quarter).xi1 == pytest.approx(-pi / 2, abs=10 * EXACT)


@quick_every(2, first=1)
@pytest.mark.parametrize("speed", [0.8, -2.0])
def test_uniform_belt_on_a_line_is_the_scene_without_it_in_a_moving_frame(speed):
    """Galilei: subtract the belt's speed from all velocities."""
    effects = (Gravity(G), CoulombFriction(0.4), Unilateral(), Flight(), Impact(0.4))
    plate = Plate(ellipse(0.1, 0.06), M, 0.004)
    still = Case(line(0.2), plate, effects, Start(0.0, 1.0, slip=1.0, omega=9.0), 1.0)
    moving = replace(still, effects=(*effects, Belt(speed)))
    here, there = (reference.simulate(case, rtol=1e-13) for case in (still, moving))
    assert len(here.transitions) > 3
    assert [(t.before, t.after) for t in here.transitions] == [(t.before, t.after) for t in there.transitions]
    times = np.linspace(0.0, 1.0, 50)
    a, b = here(times), there(times)
    assert [t.time for t in there.transitions] == pytest.approx([t.time for t in here.transitions], abs=1e-11)
    assert b.x - a.x == pytest.approx(
        speed * np.cos(0.2) * times * np.sign(b.x[-1] - a.x[-1]) * np.sign(speed), abs=1e-9
    )
    assert b.theta == pytest.approx(a.theta, abs=1e-8)


def test_pulse_of_a_belt_is_not_stepped_over():
    """A belt that jerks for a microsecond at t = 1 s, otherwise at rest, sets a rolling disc in motion."""
    case = on_line(Belt("0.5*(1 + tanh((t - 1)/1e-6))"), mu=0.3)
    motion = reference.simulate(case, rtol=1e-12)
    assert [t.after for t in motion.transitions] == [Mode.SLIP_BACKWARD, Mode.ROLL]
    assert motion.transitions[0].time == pytest.approx(1.0, abs=1e-5)
    assert motion.transitions[1].time == pytest.approx(1.0 + 1.0 / (3 * 0.3 * G), abs=1e-5)
    agree(case)


@pytest.mark.parametrize("method", reference.METHODS)
@pytest.mark.parametrize("name", ["block_on_conveyor", "block_on_conveyor[speed=0.8,mu_static=0,stiffness=0]"])
def test_a_block_that_lies_flat_does_not_turn(name, method):
    """Its acceleration ω̇ is exactly zero while both corners slip or stick; roundings of it would add up to 1e-13 rad/s.
    What is left are impacts' roundings of a velocity that is set to zero."""
    motion = reference.simulate(cases.load(name), method=method)
    assert motion.status == "completed"
    assert np.abs(motion(np.linspace(0.0, float(motion.t[-1]), 301)).omega).max() <= 1e-30
