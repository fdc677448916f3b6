"""How far a motion is from the truth: distances of known displacements, forces and energy in the true motion's own."""

from dataclasses import replace

import numpy as np
import pytest

import cases
import reference
from cases import Trajectory
from reports.judging import distances

PAPER = cases.load("disc_in_circle", mu=0.2)


@pytest.fixture(scope="module")
def exact() -> Trajectory:
    """The paper's application at rtol 1e-13."""
    return reference.simulate(PAPER, rtol=1e-13)


def test_distance_measures_a_known_displacement(exact):
    t = np.linspace(0.0, 3.0, 301)  # longer than the truth: only the common span counts
    inside = t <= exact.t[-1]
    state = exact(np.minimum(t, exact.t[-1]))
    moved = state._replace(x=state.x + 3e-3, y=state.y - 4e-3, theta=state.theta + 2e-3 + 4 * np.pi)
    off = distances.differences(Trajectory(t=t, **moved._asdict()), exact, PAPER)
    assert len(off["t"]) == inside.sum()
    far = distances.distance(off)
    assert (far.centre_max, far.centre_rms) == pytest.approx((5e-3, 5e-3))
    # Two whole turns are a matter of where rotation is counted from, 2e-3 rad are not.
    assert (far.angle_max, far.slip_max) == pytest.approx((2e-3, 0.0), abs=1e-12)
    # A disc's radius of gyration is r/√2; r is 0.1 m.
    assert far.final_pose == pytest.approx(np.hypot(5e-3, 2e-3 * 0.1 / np.sqrt(2)))


def test_force_and_energy_are_measured_in_the_true_motion_s_own(exact):
    t = np.linspace(0.0, exact.t[-1], 2001)
    state = exact(t)
    stronger = state._replace(normal_force=1.01 * state.normal_force, vx=1.01 * state.vx, vy=1.01 * state.vy)
    far = distances.distance(distances.differences(Trajectory(t=t, **stronger._asdict()), exact, PAPER))
    assert far.normal_force_mean == pytest.approx(0.01)
    speed = state.vx**2 + state.vy**2
    largest = np.max(0.5 * speed + 0.25 * 0.1**2 * state.omega**2)
    assert far.energy_mean == pytest.approx(0.5 * (1.01**2 - 1) * speed.mean() / largest)


def test_a_jump_of_the_force_at_a_transition_is_no_error_of_a_motion_known_between_its_steps():
    case = cases.load("ellipse_in_circle")
    exact, coarse = (reference.simulate(case, rtol=rtol) for rtol in (1e-13, 1e-9))

    def scored(motion: Trajectory) -> float:
        return distances.distance(distances.differences(motion, exact, case)).normal_force_mean

    # Its steps are few and doubled at the transitions: there one of the two is on the other side of the jump.
    assert scored(replace(coarse, dense=None)) > 1e-4
    assert scored(coarse) < 1e-8


def test_a_force_told_for_a_few_samples_is_not_told(exact):
    t = np.linspace(0.0, exact.t[-1], 100)
    state = exact(t)

    def scored(first_told: int) -> float:
        force = np.where(np.arange(100) < first_told, np.nan, state.normal_force + 1.0)
        off = distances.differences(Trajectory(t=t, **state._replace(normal_force=force)._asdict()), exact, PAPER)
        return distances.distance(off).normal_force_mean

    assert scored(3) == pytest.approx(1.0 / np.abs(state.normal_force).mean())
    assert np.isnan(scored(60))
