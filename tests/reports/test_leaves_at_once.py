"""A plate that leaves its track at time zero: a motion of one instant, and an exact one."""

from __future__ import annotations

import numpy as np
import pytest

import reference
from cases import Case, CoulombFriction, Flight, Gravity, Mode, Start, State, Trajectory, Unilateral, disc
from cases.library import hill
from reports.running import tasks
from tests.reports.test_tasks import performed


def over_the_top(speed: float, *more) -> Case:
    """A disc that slides over the top of a hill; beyond the root of g (R + r), 3.2850 m/s, nothing presses it down."""
    effects = (Gravity(9.81), CoulombFriction(0.3), Unilateral(), *more)
    return Case(hill(1.0), disc(0.1, 1.0), effects, Start(xi1=0.0, slip=speed), duration=0.3)


@pytest.fixture(scope="module")
def scene():
    case = over_the_top(4.0)
    return case, tasks.find_truth(case)


def test_the_reference_says_that_it_flies_from_the_first_instant():
    for method in (*reference.METHODS, "augmented"):
        motion = reference.simulate(over_the_top(4.0), method=method)
        assert (motion.status, motion.first_mode, motion.transitions, motion.t.tolist()) == (
            "lift_off", Mode.FLIGHT, (), [0.0],
        )  # fmt: skip
        assert (motion(0.0).x, motion(0.0).vx) == (0.0, 4.0)
    assert reference.simulate(over_the_top(4.0, Flight())).first_mode == Mode.FLIGHT
    assert reference.simulate(over_the_top(3.2851)).status == "lift_off"
    assert reference.simulate(over_the_top(3.2849)).first_mode == Mode.SLIP_FORWARD


@pytest.mark.parametrize("name", ["reference", "exudyn", "pymunk"])
def test_a_solver_that_lets_go_at_once_is_exact(scene, name):
    case, truth = scene
    assert (truth.failure, truth.status, truth.first_mode) == ("", "lift_off", Mode.FLIGHT)
    offers = [offer for offer in tasks.survey(case, name) if offer.settings]
    if not offers and name != "reference":
        pytest.skip(f"{name} is not installed")
    for offer in offers:
        run = tasks.measure(case, name, offer.route, offer.settings[0], 1, truth)
        assert (run.outcome, run.grade, run.first_mode, run.status) == ("answered", "excellent", "flight", "lift_off")
        assert run.distance.centre_max < 1e-12


def sliding_on(case: Case, count: int, status: str = "completed") -> Trajectory:
    """A plate that never lets go, as `count` samples show it."""
    t = np.linspace(0.0, case.duration, count)
    xi1, zero = 4.0 / 1.1 * t, np.zeros(count)
    state = State(1.1 * np.sin(xi1), 1.1 * np.cos(xi1), -xi1, 4.0 + zero, zero, zero, 4.0 + zero, zero, zero, xi1, zero)
    return Trajectory(t=t, **state._asdict(), status=status)


def test_one_that_slides_on_is_unusable(monkeypatch, scene):
    run = performed(monkeypatch, scene, lambda case: sliding_on(case, 100))
    assert (run.outcome, run.grade, run.first_mode) == ("answered", "unusable", "slip_forward")
