"""The reference against the second formulation, over random scenes (over the catalogue: test_catalogue)."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import reference
from cases import Case, Flight, Impact, Load, RollingResistance
from tests.scenes import second as second_states
from tests.scenes.elliptic import ellipse_in_ellipse, elliptic_scenes, examples, numbers


def sequence(transitions):
    return [(t.before, t.after) for t in transitions]


def moved(case: Case, by: float) -> Case:
    """The same case with its start moved a little."""
    s = case.start
    start = replace(
        s, xi1=s.xi1 * (1 + by) + by, slip=s.slip * (1 + by), omega=s.omega * (1 - by), gap=s.gap * (1 + by)
    )
    return replace(case, start=start)


def ill_conditioned(case: Case, by: float = 1e-9) -> bool:
    """Whether the sequence of transitions changes when the start is moved by a billionth, either way."""
    sequences = [sequence(reference.simulate(moved(case, d), rtol=1e-11).transitions) for d in (-by, 0.0, by)]
    return not sequences[0] == sequences[1] == sequences[2]


def output(answer) -> tuple:
    """What is to be the same: the sequence of transitions and how the motion ended."""
    return sequence(answer.transitions), answer.status


def differ(ours, theirs) -> list[tuple[float, float]]:
    """The times of the transitions that are not the same."""
    # Grazing events amplify the integrators' 1e-11; 1e-6 s still tells one event from the next.
    times = [(a.time, b.time) for a, b in zip(ours.transitions, theirs.transitions, strict=False)]
    return [(one, other) for one, other in times if one != pytest.approx(other, abs=1e-6)]


def check_agreement(case: Case) -> bool:
    """Asserts agreement; true if the sequences differ because the scene is ill-conditioned."""
    ours = reference.simulate(case, rtol=1e-11)
    theirs = second_states.motion(case, rtol=1e-11)
    if output(ours) != output(theirs) or differ(ours, theirs):
        # The second formulation sees events at its steps' ends only; a closer look costs more and misses less.
        theirs = second_states.motion(case, rtol=1e-11)
    if sequence(ours.transitions) == sequence(theirs.transitions):
        assert ours.status == theirs.status
        assert not differ(ours, theirs)
        return False
    assert ill_conditioned(case), (output(ours), output(theirs))
    return True


@given(elliptic_scenes)
@examples(6, 20)
def test_both_formulations_give_the_same_sequence_of_transitions(case):
    check_agreement(case)


def bouncing(case: Case, gap: float, restitution: float, law: str) -> Case:
    """The scene let go above its track, with impacts."""
    return replace(
        case,
        effects=(*case.effects, Flight(), Impact(restitution, law)),
        start=replace(case.start, gap=gap),
        duration=0.8,
    )


# Newton's law rather often ends a scene with an energy that grows, so that most scenes have Poisson's.
LAWS = st.sampled_from(["poisson", "poisson", "newton", "moreau"])


@given(elliptic_scenes.filter(lambda case: case.effects[1:]), numbers(0.01, 0.1), numbers(0.0, 0.85), LAWS)
@examples(4, 6)
def test_both_formulations_bounce_alike(case, gap, restitution, law):
    check_agreement(bouncing(case, gap, restitution, law))


@given(elliptic_scenes.filter(lambda case: len(case.effects) == 3), numbers(1e-3, 0.02), numbers(-20.0, 20.0))
@examples(1, 6)
def test_both_formulations_agree_under_a_spring_a_wind_and_rolling_resistance(case, arm, stiffness):
    more = (Load(fx=f"{-stiffness!r}*x + 3.0*sin(5.0*t)", moment="-0.01*omega"), RollingResistance(arm))
    check_agreement(replace(case, effects=(*case.effects, *more)))


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
