"""Friction that depends on the slip speed at several contacts: exact motions, two formulations, the paper's matrix."""

from math import cos, inf, pi, sin

import mpmath
import numpy as np
import pytest
import sympy as sp

import cases
from cases import Belt, Case, CoulombFriction, Gravity, Load, Mode, Plate, Start, StartPose, Support, Unilateral, disc
from cases.library import line
from cases.motion.mechanics import energy
from tests.scenes import second as second_states
from tests.scenes.motions import work_done
from tests.scenes.slip_laws import HYPERBOLIC, PEAK, STRIBECK, G
from tests.scenes.supports import compare_with_matrix, simulated, slow

from .test_belts_and_supports import METHODS, motion_by

# The second formulation takes a second of CPU time for it, and ten for narrower laws.
WIDE_LAW = "0.15 + 0.15*exp(-v/0.5)"
SLIP_STICK = [
    (WIDE_LAW, None),
    *(pytest.param(*law, marks=pytest.mark.slow) for law in ((STRIBECK, None), (HYPERBOLIC, 0.4))),
]
BLOCK, HIGH, WIDE = Plate.rectangle(0.6, 0.4, 1.0), 0.2, 0.3


def block(mu, *effects, mu_static=None, slope=0.0, speed=0.0, end=2.0) -> Case:
    """A block of 1 kg on its lower side, on a slope that rises along +X."""
    c, s = cos(slope), sin(slope)
    start = StartPose(-s * HIGH, c * HIGH, slope, c * speed, s * speed)
    every = (Gravity(G), CoulombFriction(mu, mu_static), Unilateral(), *effects)
    return Case(line(-slope), BLOCK, every, start, end)


def point(mu, *effects, mu_static=None, speed=0.0, end=2.0) -> Case:
    """A particle in the block's place: a plate that does not turn, with one contact."""
    every = (Gravity(G), CoulombFriction(mu, mu_static), Unilateral(), *effects)
    return Case(line(), disc(HIGH, 1.0, inf), every, Start(0.0, slip=speed), end)


def track_times(motion) -> list[float]:
    return [t.time for t in motion.transitions if t.contact == "plate/track"]


def quadrature(mu: str, speed: float, edges=()) -> float:
    """∫ dv/(μ(v) g) from 0 to a speed, by mpmath in parts."""
    law = sp.lambdify(sp.Symbol("v"), sp.sympify(mu, rational=True), "mpmath")
    with mpmath.workdps(25):
        parts = sorted({0.0, 0.02, 0.1, 0.3, *edges, speed})
        return float(mpmath.quad(lambda v: 1 / (law(v) * mpmath.mpf("9.81")), parts))


# --- a block ----------------------------------------------------------------------------------------------------------


@pytest.mark.sampled(2)
@METHODS
def test_a_block_on_a_ramp_under_viscous_friction_slows_down_exponentially(method):
    """Down a slope v̇ = g (sin α − (μ + c v) cos α): v = v_e + (v₀ − v_e) exp(−c g t cos α). Both corners have the
    slip's coefficient, and their normal forces the moment of friction about the centre, h (μ + c v) m g cos α."""
    mu, c, slope, v0 = 0.1, 0.2, 0.25, 1.5
    case = block(f"{mu} + {c}*v", slope=slope, speed=-v0)
    motion = motion_by(case, method)
    assert motion.status == "completed" and not motion.transitions
    rate, final = c * G * cos(slope), (G * sin(slope) / cos(slope) - mu * G) / (c * G)
    times = np.linspace(0.0, 2.0, 9)
    exact = final + (v0 - final) * np.exp(-rate * times)
    way = final * times + (v0 - final) * (1.0 - np.exp(-rate * times)) / rate
    if method == "second":
        x = second_states.poses(case, times[:-1])[0]
        assert -(x + sin(slope) * HIGH) / cos(slope) == pytest.approx(way[:-1], abs=2e-12)
        return
    allowed = 5e-12 if method == "dop853" else 1e-12  # DOP853 at its tolerance of 1e-14 makes 40 steps
    slips = [motion.contact_columns(name, times) for name in motion.contact_names]
    for one in slips:
        assert -one.slip == pytest.approx(exact, abs=allowed)
        assert one.friction_force == pytest.approx((mu + c * exact) * one.normal_force, abs=1e-10)
    lower, upper = (one.normal_force for one in slips)
    assert lower + upper == pytest.approx(G * cos(slope), rel=1e-12)
    assert WIDE * np.abs(lower - upper) == pytest.approx(HIGH * (mu + c * exact) * G * cos(slope), rel=1e-10)


@pytest.mark.sampled(2)
@METHODS
@pytest.mark.parametrize("mu", [WIDE_LAW, *slow(STRIBECK, HYPERBOLIC, PEAK)])
def test_a_belt_takes_a_block_along_when_the_quadrature_says(method, mu):
    """A block is laid on a belt of speed b: its slip b − v falls with μ g, the peak of `PEAK` within 2e-5 s."""
    b, peak = 1.0, [0.5 + k * 1e-4 for k in (-8, -3, -1, 0, 1, 3, 8)]
    motion = motion_by(block(mu, Belt(b)), method)
    assert [t.after for t in motion.transitions] == [Mode.ROLL, Mode.ROLL]
    assert track_times(motion) == pytest.approx([quadrature(mu, b, peak)], abs=1e-12)


@pytest.mark.slow
@METHODS
@pytest.mark.parametrize(("mu", "static"), SLIP_STICK)
def test_a_block_held_by_a_spring_on_a_belt_sticks_and_slips_as_a_particle(method, mu, static):
    """It does not tip, and both corners have the same slip: the sequence is that of one contact of infinite inertia."""
    effects = Belt(0.3), Load(fx="-20*x")
    alone = simulated(point(mu, *effects, mu_static=static, speed=-0.3, end=3.0))
    motion = motion_by(block(mu, *effects, mu_static=static, end=3.0), method)
    assert len(alone.transitions) >= 3
    # The second formulation notices a limit when accelerations exceed 1e-12 of their terms.
    # DOP853 at its finest tolerance is 3.6e-12 s off after the slip in which friction falls fastest (`test_slip_laws`).
    within = {"second": 1e-10, "dop853": 5e-12}.get(method, 2e-12)
    assert track_times(motion) == pytest.approx([t.time for t in alone.transitions], abs=within)
    both = [t.contact for t in motion.transitions]
    assert both[::2] == ["plate/track"] * len(alone.transitions) and len(both) == 2 * len(alone.transitions)


@pytest.mark.slow
def test_the_block_of_the_catalogue_rides_slips_and_overtakes_the_belt_as_a_particle():
    case = cases.load("block_on_stribeck_belt")
    law, belt, load = (case.effect(kind) for kind in (CoulombFriction, Belt, Load))
    alone = simulated(point(law.mu, belt, load, end=case.duration))
    motion = simulated(case)
    assert track_times(motion) == pytest.approx([t.time for t in alone.transitions], abs=1e-12)
    assert len(alone.transitions) == 10 and alone.transitions[0].time == pytest.approx(0.4 * G / 200.0, abs=1e-13)


@pytest.mark.slow
def test_a_law_that_is_a_number_is_the_same_motion():
    """μ + 0·v is no formula any more; exp(−v/10¹²) is one, and 1 to rounding."""
    numbers = simulated(block(0.2, Belt(0.5), slope=0.1))
    formula = simulated(block("0.1 + 0.1*exp(-v/1e12)", Belt(0.5), slope=0.1))
    assert track_times(formula) == pytest.approx(track_times(numbers), abs=1e-12)
    assert formula(1.9).x == pytest.approx(numbers(1.9).x, abs=1e-12)


# --- two supports -----------------------------------------------------------------------------------------------------

R, PRESS = 0.5, 3.0


def disc_at_wall(b: float, end: float = 2.0) -> Case:
    """A disc on a belt that runs towards a wall, against which a load presses it."""
    wall = Support(line(pi / 2), "wall", (CoulombFriction("0.1 + 0.3*v"),))
    effects = (Gravity(G), Unilateral(), CoulombFriction("0.2 + 0.2*exp(-v/0.5)"), Belt(-b), Load(fx=-PRESS))
    return Case(line(), disc(R, 1.0), effects, StartPose(R, R), end, supports=(wall,))


@pytest.mark.sampled(2)
@METHODS
def test_each_contact_has_the_coefficient_of_its_own_slip(method):
    """With u = r ω the slips are b − u on the belt and u at the wall: F₁ = μ₁ N₁, N₂ = P + F₁, F₂ = μ₂ N₂,
    N₁ = m g + F₂, and m u̇/2 = F₁ − F₂. The disc rolls on the belt at t = ∫ du/u̇ from 0 to b."""
    b = 0.4
    with mpmath.workdps(30):

        def rate(u):
            one = mpmath.mpf("0.2") + mpmath.mpf("0.2") * mpmath.exp(-(b - u) / mpmath.mpf("0.5"))
            two = mpmath.mpf("0.1") + mpmath.mpf("0.3") * u
            first = one * (mpmath.mpf("9.81") + two * PRESS) / (1 - one * two)
            return 2 * (first - two * (PRESS + first))

        exact = float(mpmath.quad(lambda u: 1 / rate(u), [0, 0.1, 0.2, 0.3, b]))
    motion = motion_by(disc_at_wall(b), method)
    assert [(t.contact, t.after) for t in motion.transitions] == [("plate/track", Mode.ROLL)]
    assert motion.transitions[0].time == pytest.approx(exact, abs=1e-12)


def test_the_energy_closes_with_the_work_of_belts_and_friction():
    for case in (disc_at_wall(0.4), block(STRIBECK, slope=0.2, speed=-1.0)):
        motion = simulated(case)
        total = energy(case, motion)
        assert total[-1] - total[0] == pytest.approx(work_done(case, motion), abs=1e-10)


def test_a_law_by_the_slip_speed_ends_at_an_impact_and_says_what_to_give():
    wall = Support(line(pi / 2), "wall", ())
    effects = (Gravity(G), Unilateral(), CoulombFriction(WIDE_LAW))
    case = Case(line(), disc(R, 1.0), effects, StartPose(2.0 * R, R, vx=-3.0), 1.0, supports=(wall,))
    motion = simulated(case)
    assert motion.status == "second_contact"
    assert "add Flight() and Impact(0.0)" in motion.reason


# --- both formulations and the paper's matrix -------------------------------------------------------------------------


@pytest.mark.slow
def test_the_papers_matrix_gives_the_same_accelerations_and_forces():
    scenes = disc_at_wall(0.4), block(STRIBECK, Belt("0.3 + sin(3*t)"), slope=0.1)
    modes = compare_with_matrix(scenes)
    assert sum(mode in (Mode.SLIP_FORWARD, Mode.SLIP_BACKWARD) for each in modes for mode in each) >= 5
