"""What a call does not do: nothing is derived, sampled or integrated that its answer does not need. No clock here."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest

import cases
import reference
from cases import State
from cases.contact import geometry
from reference import solve
from reference.minimal import modes
from reference.minimal.integrators import taylor
from reference.minimal.integrators.segment import blocks
from reference.minimal.modes import Regime, phase, start_state

pytestmark = pytest.mark.taylor

needs_heyoka = pytest.mark.skipif(not taylor.AVAILABLE, reason="heyoka is not installed")


def counted(monkeypatch, module, name: str) -> list[int]:
    """A list that grows by one with every call of that function."""
    function, calls = getattr(module, name), []

    def call(*args, **named):
        calls.append(1)
        return function(*args, **named)

    monkeypatch.setattr(module, name, call)
    return calls


def test_the_level_of_a_start_is_searched_once_for_all_frictions(monkeypatch):
    asked = counted(monkeypatch, geometry, "level_parameter")
    for mu in (0.11, 0.12, 0.13):
        reference.simulate(cases.load("disc_in_circle", mu=mu, xi1=0.0123456))
    assert len(asked) == 1


def test_a_motion_asked_for_its_transitions_alone_makes_no_samples(monkeypatch):
    observed = counted(monkeypatch, solve.solver, "observe")
    motion = reference.simulate(cases.load("disc_in_circle", mu=0.2))
    assert len(motion.transitions) == 4 and motion.cost.steps > 0 and not observed
    assert len(motion.x) == len(motion.t) and observed
    made = len(observed)
    assert np.isfinite(motion.theta).all() and len(observed) == made


@needs_heyoka
def test_a_motion_asked_for_its_transitions_alone_keeps_no_steps(monkeypatch):
    again = counted(monkeypatch, taylor, "_one_by_one")
    motion = reference.simulate(cases.load("disc_in_circle", mu=0.2), method="taylor")
    assert motion.transitions and not again
    assert len(motion.t) == motion.cost.steps + 5 and len(again) == 5  # one segment after the other


def test_samples_on_demand_are_a_trajectory_like_any_other():
    motion = reference.simulate(cases.load("disc_in_circle", mu=0.2))
    copy = pickle.loads(pickle.dumps(replace(motion, dense=None)))
    whole = motion(motion.t[:-1])
    for name in ("t", *State._fields):
        np.testing.assert_array_equal(getattr(copy, name), getattr(motion, name))
    assert copy.transitions == motion.transitions and whole.x.shape == motion.t[:-1].shape
    with pytest.raises(AttributeError, match="no_such"):
        motion.no_such  # noqa: B018
    with pytest.raises(AttributeError, match="no_such"):
        reference.simulate(cases.load("disc_in_circle", mu=0.2)).no_such  # noqa: B018


@needs_heyoka
@pytest.mark.parametrize("mu", [0.01, 0.1, 0.2])
def test_steps_taken_again_are_those_that_led_to_the_event(mu):
    case = cases.load("disc_in_circle", mu=mu)
    now = phase(case, Regime(cases.Mode.SLIP_FORWARD))
    segment = taylor.integrate(now, 0.0, start_state(case), case.duration, 1e-9)
    assert segment.event.guard == "slip" and segment.times[-1] == segment.event.time
    assert len(segment.times) == segment.steps + 1
    end = segment.states(np.array([segment.event.time]))[:, 0]
    # The last polynomial at its end, as the integrator's own evaluation of it: a few roundings.
    np.testing.assert_allclose(end, segment.event.state, rtol=1e-14, atol=1e-14)


@needs_heyoka
def test_dense_output_of_many_instants_is_that_of_each():
    case = cases.load("disc_in_circle", mu=0.2, duration=20.0)
    now = phase(case, Regime(cases.Mode.ROLL))
    segment = taylor.integrate(now, 0.0, [0.3, 3.0, 0.0][: len(now.system.variables)], 20.0, 1e-10)
    times = np.sort(np.concatenate([segment.times, np.linspace(0.0, segment.times[-1], 997)]))[::-1]
    each = np.column_stack([segment.states(np.array([t]))[:, 0] for t in times])
    np.testing.assert_array_equal(segment.states(times), each)


def test_blocks_meet_every_instant_once_and_in_its_piece():
    starts, times = np.array([0.0, 1.0, 1.0, 2.5, 9.0]), np.array([3.0, -1.0, 0.5, 1.0, 2.5, 0.0, 2.4999])
    found = dict(blocks(starts, times))
    assert sorted(np.concatenate(list(found.values())).tolist()) == list(range(len(times)))
    assert {i: sorted(times[block].tolist()) for i, block in found.items()} == {
        0: [-1.0, 0.0, 0.5],
        2: [1.0, 2.4999],
        3: [2.5, 3.0],
    }
    assert not list(blocks(starts, np.array([])))


def test_a_plate_at_the_level_parameter_has_no_angle():
    case = cases.load("ellipse_in_circle")
    for xi1 in (-1.3, 0.0, 0.7, 2.0):
        xi2 = geometry.level_parameter(case.track, case.plate.outline, xi1)
        assert abs(geometry.pose(case.track, case.plate.outline, xi1, xi2)[2]) <= 1e-14


def test_a_scene_with_another_friction_derives_no_equations_and_no_sizes(monkeypatch):
    reference.simulate(cases.load("disc_in_circle", mu=0.171))
    systems, sizes = (counted(monkeypatch, modes, name) for name in ("contact_system", "sizes_of"))
    motions = [reference.simulate(cases.load("disc_in_circle", mu=mu)) for mu in (0.172, 0.173)]
    assert motions[0].transitions != motions[1].transitions and not systems and not sizes
    reference.simulate(cases.load("disc_in_circle", mu=0.172, r=0.11))
    assert systems and sizes


def test_names_of_a_package_are_attributes_after_their_first_use(monkeypatch):
    assert cases.Case and reference.simulate
    monkeypatch.delattr(cases, "__getattr__")
    monkeypatch.delattr(reference, "__getattr__")
    assert cases.Case and reference.simulate


def test_an_effect_is_found_by_its_class_and_by_a_base_class():
    case = cases.load("disc_in_circle")
    assert [case.effect(kind) for kind in (cases.Gravity, cases.CoulombFriction)] == list(case.effects[:2])
    assert case.effect(cases.Flight) is None and case.effect(object) is case.effects[0]
