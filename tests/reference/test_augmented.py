"""The paper's augmented system (27): against Newton and Euler, against the eliminated form, and running."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import cases
import reference
from cases import (
    Case,
    CoulombFriction,
    Gravity,
    Load,
    Mode,
    PerfectlyRough,
    RollingResistance,
    Start,
    Trajectory,
    Unilateral,
    disc,
)
from cases.contact import velocity
from cases.library import line
from cases.motion.trajectory import State
from cases.scene.contact_limits import touches_by_features
from cases.scene.piece_case import has_pieces
from reference.augmented_integrator import ContactQuantities, LiteralSystem
from reference.minimal.elimination import Elimination
from reference.minimal.modes import Regime, candidates, phase, start_state, state_in, without_slip, without_turning
from reference.paper.augmented import condition, fill, solve_full_system, uniqueness
from reference.paper.kinematics import U, kinematics
from tests.scenes.elliptic import elliptic_scenes, examples


def modes(case):
    """The modes that the case's effects allow."""
    return {regime.mode for regime in candidates(case)}


def _state(case, mode):
    state = start_state(case)
    return (*state[:3], without_slip(case, 0.0, *state[:3])) if mode is Mode.ROLL else state


@given(elliptic_scenes)
@examples(20, 60)
def test_multipliers_satisfy_newton_and_euler(case):
    gravity, m, J = case.effect(Gravity), case.plate.mass, case.plate.inertia
    for mode in modes(case):
        state = _state(case, mode)
        solution, k = solve_full_system(case, mode, state), kinematics(case, *state)
        tangent = k.Rp / np.linalg.norm(k.Rp)
        force = solution.normal_force * (U @ tangent) + solution.friction_force * tangent
        weight = m * gravity.g * np.array([np.cos(gravity.direction), np.sin(gravity.direction)])
        arm = k.R - k.R0
        scale = 1 + np.abs(force).max() + m * gravity.g
        # (15), written with the contact point's position and not with the matrix A.
        assert m * solution.q1_ddot[:2] == pytest.approx(weight + force, abs=1e-12 * scale)
        assert J * solution.q1_ddot[2] == pytest.approx(arm[0] * force[1] - arm[1] * force[0], abs=1e-12 * scale)


@given(elliptic_scenes)
@examples(20, 60)
def test_accelerations_satisfy_the_constraints_differentiated_numerically(case):
    # The derivative of (8) and (9) along the motion by central differences: nothing of (25) is used.
    for mode in modes(case):
        state = np.array(_state(case, mode))
        solution = solve_full_system(case, mode, state)
        h = 1e-5

        def velocities(s, h=h, state=state, acceleration=solution.q2_ddot):
            rates = state[2:] + s * h * acceleration
            place = state[:2] + s * h * state[2:] + 0.5 * (s * h) ** 2 * acceleration
            k = kinematics(case, *place, *rates)
            return np.array([*k.R0_dot, k.theta_dot])

        difference = (velocities(1) - velocities(-1)) / (2 * h)
        scale = 1 + np.abs(solution.q1_ddot).max() + np.abs(state[2:]).max() ** 3
        # Central differences: h² times third derivatives, which the scale's cube of the speeds bounds loosely.
        assert difference == pytest.approx(solution.q1_ddot, abs=1e-6 * scale)


@given(elliptic_scenes)
@examples(20, 60)
def test_eliminated_equations_agree_with_the_literal_matrix(case):
    for mode in modes(case):
        state = _state(case, mode)
        solution, now = solve_full_system(case, mode, state), phase(case, Regime(mode))
        m = now.system.outputs_of_numbers(0.0, state_in(now, state), now.parameters)
        eliminated = type(now.system.outputs)(*m)
        literal = [*solution.q2_ddot, solution.normal_force, solution.friction_force, solution.q1_ddot[2]]
        fast = [eliminated.u1_dot, eliminated.u2_dot, eliminated.normal, eliminated.friction, eliminated.omega_dot]
        # Both lose digits with the literal matrix's condition; 1e-12 of the largest is the bound the suite promises.
        matrix = fill(case, mode, state).matrix
        scale = 1e-12 * (1 + np.abs(literal).max()) * max(1.0, np.linalg.cond(matrix) * 1e-3)
        assert np.array(fast) == pytest.approx(np.array(literal), abs=scale)


@given(elliptic_scenes)
@settings(max_examples=20, deadline=None)
def test_matrix_is_six_by_six_in_slip_and_seven_by_seven_in_roll(case):
    for mode in modes(case):
        size = 7 if mode is Mode.ROLL else 6
        assert fill(case, mode, _state(case, mode)).matrix.shape == (size, size)


# --- loads, resistance, guides, rest ----------------------------------------------------------------------------------

# Every letter that a load may use, with sizes like the weight's; the angle itself, not a whole turn of it.
LOADS = st.sampled_from(
    (
        None,
        Load(fx=5.0),
        Load(fx="-0.7*vx + 3*sin(2*t + 1)", fy="2 - 0.3*vy"),
        Load(fx="-2*x*y", moment="0.05*sin(theta/3) - 0.02*omega"),
    )
)


@st.composite
def scenes_with_effects(draw):
    """Elliptic scenes with loads, rolling resistance, bilateral guides and perfectly rough contact."""
    case, load, arm = draw(elliptic_scenes), draw(LOADS), draw(st.sampled_from((0.0, 0.01)))
    friction = PerfectlyRough() if draw(st.booleans()) else case.effect(CoulombFriction)
    effects = [case.effect(Gravity), *([friction] if friction else []), *([load] if load else [])]
    effects += [Unilateral()] if draw(st.booleans()) else []
    effects += [RollingResistance(arm)] if arm and friction else []
    start = replace(case.start, slip=0.0) if isinstance(friction, PerfectlyRough) else case.start
    return replace(case, effects=tuple(effects), start=start)


def phases(case):
    """Each regime that the case allows, with its equations and a state that fits its constraints."""
    y = start_state(case)
    for regime in candidates(case):
        now = phase(case, regime)
        yield now, state_in(now, without_turning(case, y) if regime.turn == 0 else y)


TIME = 0.3


@pytest.mark.slow
@given(scenes_with_effects())
@settings(max_examples=150, deadline=None)
def test_every_mode_and_effect_agrees_with_the_eliminated_equations(case):
    _agrees(case)


def _agrees(case):
    for now, y in phases(case):
        literal = LiteralSystem(case, now)
        matrix = literal.system_at(TIME, y).matrix
        observed = dict(zip(Elimination._fields, now.system.outputs_of_numbers(TIME, y, now.parameters), strict=True))
        forces = [abs(observed[name]) for name in ("normal", "friction", "couple", "slip_dot", "omega_dot")]
        rates = np.array(now.system.rates_of_numbers(TIME, y, now.parameters))
        scale = 1e-12 * (1 + max(*forces, *np.abs(rates))) * max(1.0, np.linalg.cond(matrix) * 1e-3)
        assert np.array(literal.rates_of_numbers(TIME, y)) == pytest.approx(rates, abs=scale)
        output = ContactQuantities(*(float(column[0]) for column in literal.outputs_of_arrays(*_at_once(y))))
        assert output == pytest.approx([observed[name] for name in ContactQuantities._fields], abs=scale)
        # The paradox's guard has another scale (1 without friction) and the same sign; all others are the same number.
        theirs = dict(zip(now.system.guards, now.system.guards_of_numbers(TIME, y, now.parameters), strict=True))
        ours = dict(zip(literal.guards, literal.guards_of_numbers(TIME, y), strict=True))
        assert (theirs.pop("painleve", 1.0) > 0.0) == (ours.pop("painleve", 1.0) > 0.0)
        assert ours == pytest.approx(
            theirs, abs=10 * scale
        )  # couples are over a radius of gyration of a tenth of a metre


SEVERAL_TIMES = (0.0, 0.3, 0.7)


def check_at_once(case):
    """Asserts that (27) gives at many instants at once what it gives at each alone."""
    for now, y in phases(case):
        literal = LiteralSystem(case, now)
        states = np.array([y, *(np.array(y) * share for share in (1.01, 0.98))])
        alone = np.array(
            [literal.outputs_of_numbers(t, y) for t, y in zip(SEVERAL_TIMES, states.tolist(), strict=True)]
        ).T
        at_once = literal.outputs_of_arrays(np.array(SEVERAL_TIMES), states.T)
        slip = now.system.record(*now.system.outputs_of_numbers(0.0, y, now.parameters)).slip
        assert alone[0, 0] == pytest.approx(slip, abs=1e-12)  # of speeds of some m/s
        # The same sums in the same order, of functions of arrays.
        force = np.abs(alone[2:]).sum(axis=0)
        for name, own, other in zip(ContactQuantities._fields, at_once, alone, strict=True):
            size = force if name in ("normal", "friction") else 1e-2
            assert np.all(np.abs(own - other) <= 1e-10 * size), name
        guards_alone = zip(*(map(literal.guards_of_numbers, SEVERAL_TIMES, states.tolist())), strict=True)
        guards_at_once = literal.guards_of_arrays(np.array(SEVERAL_TIMES), states.T)
        for name, own, values in zip(literal.guards, guards_at_once, guards_alone, strict=True):
            # Most are forces per mass (1 kg or 2 kg here), the others of order one.
            assert np.all(np.abs(own - np.array(values)) <= 1e-10 * (1.0 + np.abs(values) + force)), name


@pytest.mark.parametrize(
    "name", ["block_on_viscous_ramp", "disc_on_conveyor", "ellipse_on_surging_belt", "stribeck_disc", "slider_on_belt"]
)
def test_many_instants_at_once_on_belts_with_friction_by_speed_and_without_rotation(name):
    check_at_once(cases.select(name)[0])


def _at_once(y):
    return np.array([TIME]), np.array(y, dtype=float)[:, None]


def test_rolling_resistance_and_rest_are_rows_and_columns_of_their_own():
    # A disc that rolls on a level line with a lever arm f: ω̇ = f g / (r² + J/m) against ω (moments about the contact).
    effects = (Gravity(9.81), CoulombFriction(0.5), RollingResistance(0.01), Unilateral())
    case = Case(line(), disc(0.1, 2.0), effects, Start(0.0, omega=-3.0), 1.0)
    y = start_state(case)
    rolling = solve_full_system(case, Mode.ROLL, y)
    assert rolling.q1_ddot[2] == pytest.approx(0.01 * 9.81 / 0.015, rel=1e-13)
    assert rolling.couple == pytest.approx(0.01 * 2.0 * 9.81, rel=1e-13)
    resting = solve_full_system(case, Mode.REST, (*y[:2], 0.0, 0.0))
    assert [*resting.q1_ddot, *resting.q2_ddot, resting.friction_force, resting.couple] == pytest.approx([0.0] * 7)
    assert resting.normal_force == pytest.approx(2.0 * 9.81, rel=1e-14)
    sizes = {mode: len(fill(case, mode, y).matrix) for mode in (Mode.SLIP_FORWARD, Mode.ROLL, Mode.REST)}
    assert sizes == {Mode.SLIP_FORWARD: 6, Mode.ROLL: 7, Mode.REST: 8}


def test_determinant_vanishes_where_the_rod_meets_the_paradox():
    # A uniform rod on its end: 1 + 3 cos²φ − 3 μ sin φ cos φ = 0 (derived in tests/taylor/test_atlas.py).
    case = cases.load("rod_into_the_paradox", mu=2)
    motion = reference.simulate(case, method="augmented")
    assert motion.status == "paradox"
    assert "nearly singular" in motion.reason
    last = LiteralSystem(case, phase(case, Regime(motion.first_mode)))
    rates = velocity(case, motion.xi1[-1], motion.xi2[-1], motion.slip[-1], motion.omega[-1])
    filled = last.system_at(motion.t[-1], (rates.xi1, rates.xi2, rates.xi1_dot, rates.xi2_dot))
    assert abs(uniqueness(filled)) < 1e-7
    assert condition(case, filled) > 1e8


# --- the paper's matrix, running --------------------------------------------------------------------------------------

# One case for every mode and effect is quick, one is slow for each other case of the catalogue.
SAMPLE = ("disc_in_circle[mu=0.2]", "disc_rolling_to_rest", "guided_loop", "hopping_hoop")
CATALOGUE = [
    pytest.param(case, id=case.label, marks=() if case.label in SAMPLE else pytest.mark.slow)
    for name in cases.names()
    for case in cases.select(name)
    if not (has_pieces(case) or case.others or touches_by_features(case))
]


def _same_motion(case):
    taylor, literal = (reference.simulate(case, rtol=1e-10, method=method) for method in (None, "augmented"))
    assert literal.status == taylor.status
    assert literal.first_mode == taylor.first_mode
    whole = [[(t.before, t.after, t.cause) for t in motion.transitions] for motion in (literal, taylor)]
    assert whole[0] == whole[1]
    return taylor, literal


def _off(one, other) -> float:
    """The largest difference of two motions' transitions, s; over hours, in parts of the time."""
    pairs = zip(one.transitions, other.transitions, strict=True)
    return max((abs(a.time - b.time) / max(1.0, a.time) for a, b in pairs), default=0.0)


@pytest.mark.parametrize("case", CATALOGUE)
def test_the_papers_matrix_makes_the_same_motion(case):
    taylor, literal = _same_motion(case)
    # Some hard scenes turn the integrator's own error of 1e-10 into more than 1e-9 s; there DOP853 on the eliminated
    # equations is off by as much, and what the matrix adds is below the bound.
    eliminated = reference.simulate(case, rtol=1e-10, method="dop853")
    assert _off(literal, eliminated) < 1e-9
    assert _off(taylor, literal) < max(1e-9, 2 * _off(taylor, eliminated))
    if case.label not in SAMPLE:
        return
    times = np.linspace(0.0, min(taylor.t[-1], literal.t[-1]), 50)
    # Away from events, where forces jump, states and forces agree to a thousand times the tolerance.
    far = np.all([np.abs(times - t.time) > 1e-6 for t in taylor.transitions] or [times >= 0.0], axis=0)
    for name, one, other in zip(State._fields, taylor(times[far]), literal(times[far]), strict=True):
        assert other == pytest.approx(one, abs=1e-7 * (1 + np.nanmax(np.abs(one), initial=0.0)), nan_ok=True), name


def test_a_matrix_that_is_nearly_singular_is_reported_and_others_are_not():
    case = cases.load("nearly_conforming[gap=1e-08]")
    tight = reference.simulate(replace(case, duration=0.1 * case.duration), method="augmented")
    assert tight.status == "completed"
    assert "nearly singular: its condition reached" in tight.reason
    assert reference.simulate(cases.load("disc_in_circle"), method="augmented").reason == Trajectory.reason
