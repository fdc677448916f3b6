"""What a call does not do: nothing is derived, sampled or integrated that its answer does not need. No clock here."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest

import cases
import reference
from cases import State
from reference import solve
from reference.minimal.integrators import taylor
from reference.minimal.modes import Regime, phase

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


def test_a_motion_asked_for_its_transitions_alone_makes_no_samples(monkeypatch):
    observed = counted(monkeypatch, solve.solver, "observe")
    motion = reference.simulate(cases.load("disc_in_circle", mu=0.2))
    assert len(motion.transitions) == 4 and motion.cost.steps > 0 and not observed
    assert len(motion.x) == len(motion.t) and observed
    made = len(observed)
    assert np.isfinite(motion.theta).all() and len(observed) == made


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
def test_dense_output_of_many_instants_is_that_of_each():
    case = cases.load("disc_in_circle", mu=0.2, duration=20.0)
    now = phase(case, Regime(cases.Mode.ROLL))
    segment = taylor.integrate(now, 0.0, [0.3, 3.0, 0.0][: len(now.system.variables)], 20.0, 1e-10)
    times = np.sort(np.concatenate([segment.times, np.linspace(0.0, segment.times[-1], 997)]))[::-1]
    each = np.column_stack([segment.states(np.array([t]))[:, 0] for t in times])
    np.testing.assert_array_equal(segment.states(times), each)
