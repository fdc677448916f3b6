"""Combinations of modes that numbers exclude together are those that they exclude one by one."""

import numpy as np
import pytest

import reference
from reference.solver import decide, impact
from reference.solver.accelerations import answer_by_numbers
from reference.solver.decide import shares_of
from reference.solver.exclusion import impact_exclusions, possible_modes
from tests.scenes.walled_plates import random_walled_plates

# Blocks and discs in piles between walls, with two to seven contacts in a group.
PILES = (2474928891, 2474928864 + 131, 2474928864 + 163)


@pytest.mark.parametrize("seed", PILES)
def test_combinations_that_are_left_out_have_no_answer_by_numbers(seed, monkeypatch):
    counts = [0, 0]

    def compare(now, contacts, combinations):
        possible = possible_modes(now, contacts, combinations)
        for modes, turn in set(combinations) - set(possible):
            answer = answer_by_numbers(now, contacts, modes, shares_of(contacts, modes), turn)
            assert answer is not None and not answer.is_possible
        counts[0], counts[1] = counts[0] + len(combinations), counts[1] + len(possible)
        return possible

    monkeypatch.setattr(decide, "possible_modes", compare)
    motion = reference.simulate(random_walled_plates(seed, duration=0.4), method="dop853")
    assert motion.status == "completed"
    assert counts[1] < 0.6 * counts[0]


@pytest.mark.parametrize("seed", PILES)
def test_impacts_that_are_left_out_break_the_law_of_impact(seed, monkeypatch):
    """The velocities after each impact are those of all combinations, tried one by one."""
    alone, counts = impact._collide, [0, 0]

    def count(*arguments):
        without = impact_exclusions(*arguments)
        counts[0], counts[1] = counts[0] + len(without), counts[1] + int((~without).sum())
        return without

    def compare(*arguments):
        outcome, impulses = alone(*arguments)
        with monkeypatch.context() as inside:
            inside.setattr(impact, "impact_exclusions", lambda modes, *_: np.zeros(len(modes.closed), dtype=bool))
            other, _ = alone(*arguments)
        assert (outcome.velocity == other.velocity).all() and (outcome.lift == other.lift).all()
        return outcome, impulses

    monkeypatch.setattr(impact, "impact_exclusions", count)
    monkeypatch.setattr(impact, "_collide", compare)
    motion = reference.simulate(random_walled_plates(seed, duration=0.4), method="dop853")
    assert motion.status == "completed"
    assert 0 < counts[1] < 0.6 * counts[0]
