"""Short events: slips, sticks and lift-offs of microseconds inside a step, found by the second formulation."""

from dataclasses import replace
from math import cos, pi, sin, sqrt

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import ellipk

import cases
import reference
from cases import Mode, Start
from reference.witness.dips import SHORTEST, excursion
from tests.scenes import second as second_states

G = 9.81


def solve(case, **options):
    return second_states.motion(case, rtol=1e-13, **options)


# --- the bound --------------------------------------------------------------------------------------------------------


@example(place=0.02, bend=5.0, skew=0.0, depth=-12.0)
@example(place=0.02, bend=10.0, skew=-0.5, depth=-12.0)
@given(place=st.floats(0.01, 0.99), bend=st.floats(0.1, 10.0), skew=st.floats(-0.5, 0.5), depth=st.floats(-12.0, -4.0))
def test_the_bound_separates_a_dip_from_a_miss_of_the_same_depth(place, bend, skew, depth):
    # A parabola whose curvature changes by up to a half across the step, lowest at `place`.
    def value(t: float, lowest: float) -> float:
        return bend * (t - place) ** 2 * (1.0 + skew * (t - place)) + lowest

    # A dip at least as long as the shortest part of a step contains an end of one; a shorter one may lie between two.
    shallowest = bend * (0.51 * SHORTEST) ** 2
    lowest = min(max(10.0**depth, shallowest), 0.1 * value(0.0, 0.0), 0.1 * value(1.0, 0.0))
    time = excursion(lambda t: value(t, -lowest), 0.0, 1.0)
    assert time is not None and value(time, -lowest) <= 0.0
    assert excursion(lambda t: value(t, lowest), 0.0, 1.0) is None


# --- exact scenes -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("part", [-1e-9, -1e-7])
def test_a_pendulum_slips_at_each_end_of_its_swing_for_as_long_as_friction_is_over_its_cone(part):
    """A disc rolls in a circle, sin φ = μ (7 cos φ − 4 cos A) at the cone, which it reaches δ before it rests at A.

    About the instant of rest friction exceeds its bound by c (δ² − τ²), so a slip from −δ on has the velocity
    c ∫(δ² − τ²) dτ, which is zero again at 2 δ; one that begins at rest ends at √3 δ.
    """
    answer = solve(replace(cases.load("pendulum_at_the_cone", part=part), duration=2.5))
    half, before = swing(part)
    exact = [sqrt(3.0) * before, *(n * half + way * before for n in (1, 2) for way in (-1.0, 2.0))]
    assert [t.after for t in answer.transitions] == [
        Mode.ROLL, Mode.SLIP_BACKWARD, Mode.ROLL, Mode.SLIP_FORWARD, Mode.ROLL,
    ]  # fmt: skip
    # Friction is known to 1e-15 of itself, and δ is the root of its excess: 1e-15/(2e-9) of 1e-5 s; with an excess of
    # 1e-7, terms of the next order in δ (1e-4 s) are δ³ over the squared time scale of 0.3 s. A pose off by 9e-15 rad
    # shifts a slip by 1e-10 s, and roundings of 2.4 s of poses add up to 2e-14 rad (DOP853 of the first: 2.9e-10 s).
    assert [t.time for t in answer.transitions] == pytest.approx(exact, abs=5e-10)


@pytest.mark.parametrize("method", [*reference.METHODS, "second"])
def test_a_slip_that_begins_and_ends_in_the_first_step_of_a_phase_is_found(method):
    case, (_, before) = cases.load("pendulum_at_the_cone", part=-1e-9), swing(-1e-9)
    # A start off by 9e-15 rad, as of a motion at a tolerance of 1e-14, shifts the first slip by 1e-10 s.
    angle = brentq(lambda d: time_to_rest(d) - before - 1e-5, 1e-12, 1e-3, xtol=1e-20, rtol=1e-15)
    speed = sqrt(2 * RATE * sin(AMPLITUDE - angle / 2) * sin(angle / 2))
    start = Start(xi1=-pi / 2 + AMPLITUDE - angle, omega=-speed * LENGTH / case.plate.radius)
    case = replace(case, start=start, duration=1e-3)
    motion = solve(case) if method == "second" else reference.simulate(case, rtol=1e-13, method=method)
    assert [t.after for t in motion.transitions] == [Mode.SLIP_BACKWARD, Mode.ROLL]
    assert [t.time for t in motion.transitions] == pytest.approx([1e-5, 1e-5 + 3.0 * before], abs=2e-10)


# The rolling disc of `pendulum_at_the_cone`: φ̇² = (4 g/3 L)(cos φ − cos A).
AMPLITUDE, LENGTH = 0.8, 0.9
RATE = 4 * G / (3 * LENGTH)


def swing(part: float) -> tuple[float, float]:
    """The pendulum's half period, and how long before it rests friction reaches its cone, s."""
    mu = np.tan(AMPLITUDE) / 3 * (1 + part)
    cone = brentq(
        lambda d: sin(AMPLITUDE - d) - mu * (7 * cos(AMPLITUDE - d) - 4 * cos(AMPLITUDE)), 0.0, 1e-3, xtol=1e-16
    )
    return 2 * sqrt(1.5 * LENGTH / G) * float(ellipk(sin(AMPLITUDE / 2) ** 2)), time_to_rest(cone)


def time_to_rest(angle: float) -> float:
    """The time (s) in which the pendulum rests, from that angle (rad) before its amplitude."""
    # With φ = A − w² there is no singularity in w.
    return quad(
        lambda w: 2 * w / sqrt(2 * RATE * sin(AMPLITUDE - w * w / 2) * sin(w * w / 2)), 1e-12, sqrt(angle), epsabs=0.0
    )[0]


def test_a_slip_that_falls_below_zero_by_a_nanometre_per_second_sticks_for_eight_microseconds():
    # v has its least value, -1e-9 m/s, where v' = 0: the disc sticks from √(2e-9/v'') before it, and then friction is
    # at its bound again.
    first = reference.simulate(cases.load("touching_slip[above=1e-09]"), rtol=1e-14)
    lowest = brentq(lambda t: float(first(t + 1e-4).slip - first(t - 1e-4).slip), 0.31, 0.33, xtol=1e-15)
    bend = (first(lowest + 1e-3).slip - 2 * first(lowest).slip + first(lowest - 1e-3).slip) / 1e-6
    answer = solve(cases.load("touching_slip[above=-1e-09]"))
    assert [t.after for t in answer.transitions] == [Mode.ROLL, Mode.SLIP_FORWARD]
    sticks, slips = (t.time for t in answer.transitions)
    assert slips == pytest.approx(lowest, abs=1e-8)
    assert slips - sticks == pytest.approx(sqrt(2e-9 / bend), rel=1e-2)
