"""Random scenes that are hard on purpose: no NaN, no hang, and two formulations that agree on what happens."""

from collections import Counter

import numpy as np
import pytest

import reference
from tests.reference.test_atlas import within
from tests.reference.test_two_formulations import ill_conditioned, sequence
from tests.scenes import second as second_states
from tests.scenes.hard import KINDS, hard_scene

# Seconds for one scene by both formulations; ordinary ones take a tenth of one.
PATIENCE = 60


def check(case) -> str:
    """ "" if both formulations agree, or why the scene is flagged; asserts what must hold in every scene."""
    with within(PATIENCE):
        ours = reference.simulate(case, rtol=1e-12)
    for name in ("x", "y", "theta", "slip", "omega", "normal_force", "friction_force"):
        assert np.all(np.isfinite(getattr(ours, name))), name
    with within(PATIENCE):
        theirs = second_states.motion(case, rtol=1e-12)
    if (sequence(theirs.transitions), theirs.status) == (sequence(ours.transitions), ours.status):
        return ""
    if ill_conditioned(case):
        return "moved by a billionth it does something else"
    raise AssertionError(
        f"{ours.status}, {theirs.status}\n{[(t.time, str(t.after)) for t in ours.transitions]}\n"
        f"{[(t.time, str(t.after)) for t in theirs.transitions]}\n{case.effects}\n{case.start}"
    )


def check_many(count: int, seed: int) -> Counter:
    rng, flagged = np.random.default_rng(seed), Counter()
    for _ in range(count):
        kind, case = hard_scene(rng)
        flagged[kind] += bool(check(case))
    return flagged


@pytest.mark.slow
def test_both_formulations_agree_on_a_few_hard_random_scenes():
    assert sum(check_many(5, seed=1).values()) == 0


@pytest.mark.slow
def test_both_formulations_agree_on_two_thousand_hard_random_scenes():
    flagged = check_many(2000, seed=20261121)
    assert set(flagged) == set(KINDS)
    assert sum(flagged.values()) < 20, flagged  # one per cent
