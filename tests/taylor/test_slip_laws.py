"""Friction that depends on the slip velocity: exact motions, both formulations, energy, invariance, and its end."""

from dataclasses import replace
from math import exp, log

import mpmath
import numpy as np
import pytest
import sympy as sp

import cases
import reference
from cases import Case, CoulombFriction, Gravity, Mode, Start, Unilateral
from cases.library import circle, line
from reference.minimal.modes import candidates, phase, start_state, state_in
from reference.paper.augmented import fill, solution
from reports.judging.residuals import examine
from tests.sampling import quick_every
from tests.scenes import second as second_states
from tests.scenes.motions import energy, work_done
from tests.scenes.slip_laws import GAUSSIAN, HYPERBOLIC, PEAK, STRIBECK, G, sliding_disc


def simulate_all(case: Case, rtol: float = 1e-13):
    """The motion by every method of the reference, the second formulation last."""
    return [reference.simulate(case, rtol, method) for method in reference.solve.ROUTES] + [
        second_states.motion(case, rtol=rtol)
    ]


def in_circle(mu, **options) -> Case:
    effects = (Gravity(G), CoulombFriction(mu, **options), Unilateral())
    return Case(circle(1.0), cases.disc(0.1, 1.0), effects, Start(-0.1), 2.5)


# --- exact motions ----------------------------------------------------------------------------------------------------


def test_slip_under_viscous_friction_decays_exponentially():
    """dv/dt = −3 g (μ₀ + c v): v = (v₀ + μ₀/c) exp(−3 g c t) − μ₀/c, zero after log(1 + c v₀/μ₀)/(3 g c)."""
    mu, c, v0 = 0.1, 0.05, 1.0
    case, rate = sliding_disc(f"{mu} + {c}*v"), 3.0 * G * c
    for motion in simulate_all(case):
        assert [t.after for t in motion.transitions] == [Mode.ROLL]
        assert motion.transitions[0].time == pytest.approx(log(1.0 + c * v0 / mu) / rate, abs=1e-12)
    motion = reference.simulate(case, 1e-13)
    for t in np.linspace(0.0, 0.99 * motion.transitions[0].time, 20):
        assert motion(t).slip == pytest.approx((v0 + mu / c) * exp(-rate * t) - mu / c, abs=1e-12)
        assert motion(t).friction_force == pytest.approx(-(mu + c * motion(t).slip) * G, abs=1e-12)


@quick_every(4)
@pytest.mark.parametrize("mu", [STRIBECK, HYPERBOLIC, GAUSSIAN, PEAK])
def test_slip_ends_where_the_quadrature_says(mu):
    """t = ∫ dv/(3 μ(v) g) from 0 to v₀, by mpmath in parts at the places where μ changes."""
    law = sp.lambdify(sp.Symbol("v"), sp.sympify(mu, rational=True), "mpmath")
    peak = [0.5 + k * 1e-4 for k in (-8, -3, -1, 0, 1, 3, 8)]
    with mpmath.workdps(25):
        edges = [0, 0.01, 0.05, 0.1, 0.2, *peak, 0.7, 1]
        exact = float(mpmath.quad(lambda v: 1 / (3 * law(v) * mpmath.mpf("9.81")), edges))
    for motion in simulate_all(sliding_disc(mu)):
        assert motion.transitions[0].time == pytest.approx(exact, abs=1e-12)


def test_a_disc_on_a_ramp_slips_at_the_speed_where_three_coefficients_make_the_slope():
    """v̇ = g (sin α − 3 μ(v) cos α): on a slope steeper than it can roll on, slip tends to μ(v) = tan(α)/3."""
    mu, c, slope = 0.1, 0.05, 0.6
    effects = (Gravity(G, -np.pi / 2 - np.arctan(slope)), CoulombFriction(f"{mu} + {c}*v"), Unilateral())
    case = Case(line(), cases.disc(0.1, 1.0), effects, Start(0.0), 8.0)
    final, rate = -(slope / 3.0 - mu) / c, 3.0 * G * c * np.cos(np.arctan(slope))
    times = np.linspace(0.0, 8.0, 30)
    for method in reference.METHODS:
        motion = reference.simulate(case, 1e-13, method)
        assert motion.first_mode is Mode.SLIP_BACKWARD and not motion.transitions
        allowed = 5e-12 if method == "dop853" else 1e-12  # DOP853 makes 60 steps at its tolerance of 1e-13
        assert motion(times).slip == pytest.approx(final * (1.0 - np.exp(-rate * times)), abs=allowed)


# --- agreement --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("mu", [STRIBECK, HYPERBOLIC, PEAK])
def test_the_eliminated_equations_agree_with_the_literal_matrix(mu):
    case = in_circle(mu)
    for regime in candidates(case):
        now = phase(case, regime)
        for slip in (0.03, 0.5):
            sign = -1.0 if regime.mode is Mode.SLIP_BACKWARD else 1.0
            start = Start(0.3, slip=0.0 if regime.mode is Mode.ROLL else sign * slip, omega=2.0)
            y = start_state(replace(case, start=start))
            outputs = now.system.record(*now.system.outputs_of_numbers(0.0, state_in(now, y), now.parameters))
            literal = solution(fill(case, regime.mode, y))
            assert outputs.u1_dot == pytest.approx(literal.q2_ddot[0], rel=1e-12)
            assert outputs.u2_dot == pytest.approx(literal.q2_ddot[1], rel=1e-12)
            assert outputs.normal == pytest.approx(literal.normal_force, rel=1e-12)
            assert outputs.friction == pytest.approx(literal.friction_force, rel=1e-12)


# --- energy and invariance --------------------------------------------------------------------------------------------


@quick_every(3)
@pytest.mark.parametrize("mu", [STRIBECK, HYPERBOLIC, GAUSSIAN])
def test_the_energy_closes_with_the_work_of_friction(mu):
    motion = reference.simulate(in_circle(mu, mu_static=0.4), 1e-13)
    assert examine(motion.case, motion).energy <= 1e-10
    lost = np.diff(energy(motion.case, motion(np.array([0.0, motion.t[-1]]))))[0]
    assert lost == pytest.approx(work_done(motion.case, motion), abs=1e-10 * abs(lost))
    assert lost < -0.1


# --- endings ----------------------------------------------------------------------------------------------------------


def test_friction_that_grows_as_the_slip_falls_ends_in_painleves_paradox():
    """A rod dragged on its end jams where 1 + 3 cos²φ = 3 μ(v) sin φ cos φ, though μ is small while it is fast."""
    steady = cases.load("sliding_rod", mu=0.3)
    law = CoulombFriction("0.3 + 3*exp(-v/0.5)")
    effects = tuple(law if isinstance(e, CoulombFriction) else e for e in steady.effects)
    case = replace(steady, effects=effects)
    theirs = second_states.motion(case, rtol=1e-12)
    assert theirs.status == "paradox"
    for method in reference.METHODS:
        ours = reference.simulate(case, 1e-12, method)
        assert ours.status == "paradox"
        assert float(ours.t[-1]) == pytest.approx(theirs.end, abs=1e-11)
