"""The reference against the second formulation, over random scenes."""

import numpy as np
import pytest
from hypothesis import given, settings

import cases
import reference
from cases import Case, Start
from reference import contact_frame
from tests.scenes import ellipse_in_ellipse, elliptic_scenes


def sequence(transitions):
    return [(t.before, t.after) for t in transitions]


def moved(case: Case, by: float) -> Case:
    """The same case with its start moved a little."""
    s = case.start
    start = Start(s.xi1 * (1 + by) + by, s.xi2, s.slip * (1 + by), s.omega * (1 - by))
    return Case(case.track, case.plate, case.effects, start, case.duration)


def ill_conditioned(case: Case, by: float = 1e-9) -> bool:
    """Whether the sequence of transitions changes when the start is moved by a billionth, either way."""
    sequences = [sequence(reference.simulate(moved(case, d), rtol=1e-11).transitions) for d in (-by, 0.0, by)]
    return not sequences[0] == sequences[1] == sequences[2]


def check_agreement(case: Case) -> bool:
    """Asserts agreement; true if the sequences differ because the scene is ill-conditioned."""
    ours = reference.simulate(case, rtol=1e-11)
    theirs = contact_frame.solve(case, rtol=1e-11)
    if sequence(ours.transitions) != sequence(theirs.transitions):
        # The second formulation sees events at its steps' ends only; a closer look costs more and misses less.
        theirs = contact_frame.solve(case, rtol=1e-11, looks=2000)
    if sequence(ours.transitions) == sequence(theirs.transitions):
        assert ours.status == theirs.status
        for a, b in zip(ours.transitions, theirs.transitions, strict=True):
            # Grazing events amplify the integrators' 1e-11; 1e-6 s still tells one event from the next.
            assert a.time == pytest.approx(b.time, abs=1e-6)
        return False
    assert ill_conditioned(case), (sequence(ours.transitions), sequence(theirs.transitions))
    return True


@given(elliptic_scenes)
@settings(max_examples=40, deadline=None)
def test_both_formulations_give_the_same_sequence_of_transitions(case):
    check_agreement(case)


@pytest.mark.parametrize("name", cases.names(hard=False))
def test_both_formulations_agree_on_every_case_of_the_catalogue(name, accuracy):
    for case in cases.select(name):
        ours = reference.simulate(case, rtol=1e-12)
        times = np.linspace(0.0, ours.t[-1], 50)
        theirs = contact_frame.solve(case, rtol=1e-12, times=times)
        assert sequence(theirs.transitions) == sequence(ours.transitions)
        assert theirs.status == ours.status
        state = ours(times)
        common = dict(case=case.label, solver="reference", route="contact_frame")
        worst = np.nanmax(np.abs(theirs.states - np.array([state.xi1, state.xi2, state.omega, state.slip])))
        # Two integrations at 1e-12 over a few seconds, with spins of up to a hundred radians per second.
        accuracy(**common, quantity="largest difference of states", error=worst, tolerance=1e-8)


@pytest.mark.slow
def test_both_formulations_agree_on_twenty_thousand_random_scenes():
    rng = np.random.default_rng(20261121)
    flagged = 0
    for _ in range(20_000):
        shape = dict(A=(1.0, 1.2), B=(0.8, 1.0), a=(0.18, 0.3), b=(0.18, 0.3), shift=(-0.05, 0.05))
        motion = dict(xi1=(-3, 3), xi2=(-3, 3), mu=(0.0, 1.0), omega=(-5, 5), direction=(-3, 3))
        values = {name: rng.uniform(*span) for name, span in (shape | motion).items()}
        slip = rng.choice([0.0, rng.uniform(-2.0, 2.0)])
        flagged += check_agreement(ellipse_in_ellipse(**values, slip=slip))
    assert flagged < 200  # one per cent
