"""The augmented system (27), literal and eliminated, at random admissible states."""

import numpy as np
import pytest
from hypothesis import given, settings

from cases import Gravity, Mode
from reference.augmented import augmented_system, solve_augmented
from reference.kinematics import U, kinematics, slip_vector, slip_vector_of_plate
from reference.modes import Regime, candidates, phase, start_state, state_in, without_slip
from tests.scenes import elliptic_scenes


def modes(case):
    """The modes that the case's effects allow."""
    return {regime.mode for regime in candidates(case)}


def _state(case, mode):
    state = start_state(case)
    return (*state[:3], without_slip(case, *state[:3])) if mode is Mode.ROLL else state


@given(elliptic_scenes)
@settings(max_examples=60, deadline=None)
def test_multipliers_satisfy_newton_and_euler(case):
    gravity, m, J = case.effect(Gravity), case.plate.mass, case.plate.inertia
    for mode in modes(case):
        state = _state(case, mode)
        solution, k = solve_augmented(case, mode, state), kinematics(case, *state)
        tangent = k.Rp / np.linalg.norm(k.Rp)
        force = solution.normal_force * (U @ tangent) + solution.friction_force * tangent
        weight = m * gravity.g * np.array([np.cos(gravity.direction), np.sin(gravity.direction)])
        arm = k.R - k.R0
        scale = 1 + np.abs(force).max() + m * gravity.g
        # (15), written with the contact point's position and not with the matrix A.
        assert m * solution.q1_ddot[:2] == pytest.approx(weight + force, abs=1e-12 * scale)
        assert J * solution.q1_ddot[2] == pytest.approx(arm[0] * force[1] - arm[1] * force[0], abs=1e-12 * scale)


@given(elliptic_scenes)
@settings(max_examples=60, deadline=None)
def test_accelerations_satisfy_the_constraints_differentiated_numerically(case):
    # The derivative of (8) and (9) along the motion by central differences: nothing of (25) is used.
    for mode in modes(case):
        state = np.array(_state(case, mode))
        solution = solve_augmented(case, mode, state)
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
@settings(max_examples=60, deadline=None)
def test_eliminated_equations_agree_with_the_literal_matrix(case):
    for mode in modes(case):
        state = _state(case, mode)
        solution, now = solve_augmented(case, mode, state), phase(case, Regime(mode))
        m = now.system.observed_of_numbers(0.0, state_in(now, state), now.parameters)
        eliminated = type(now.system.observed)(*m)
        literal = [*solution.q2_ddot, solution.normal_force, solution.friction_force, solution.q1_ddot[2]]
        fast = [eliminated.u1_dot, eliminated.u2_dot, eliminated.normal, eliminated.friction, eliminated.omega_dot]
        # Both lose digits with the literal matrix's condition; 1e-12 of the largest is the bound the suite promises.
        matrix, _ = augmented_system(case, mode, state)
        scale = 1e-12 * (1 + np.abs(literal).max()) * max(1.0, np.linalg.cond(matrix) * 1e-3)
        assert np.array(fast) == pytest.approx(np.array(literal), abs=scale)


@given(elliptic_scenes)
@settings(max_examples=60, deadline=None)
def test_the_two_forms_of_the_slip_velocity_agree(case):
    k = kinematics(case, *start_state(case))
    assert slip_vector(k) == pytest.approx(slip_vector_of_plate(k), abs=1e-12)
    assert slip_vector(k) @ k.Rp / np.linalg.norm(k.Rp) == pytest.approx(case.start.slip, abs=1e-12)
    assert k.theta_dot == pytest.approx(case.start.omega, abs=1e-11)


@given(elliptic_scenes)
@settings(max_examples=20, deadline=None)
def test_matrix_is_six_by_six_in_slip_and_seven_by_seven_in_roll(case):
    for mode in modes(case):
        size = 7 if mode is Mode.ROLL else 6
        assert augmented_system(case, mode, _state(case, mode))[0].shape == (size, size)
