"""Which accuracy counts as reached: not what a lucky rung met, nor what the reading cannot tell."""

from math import inf, isnan

import pytest

import cases
from adapters import Setting
from cases import Mode, Transition
from reports.analysis import accuracy_levels, quantities
from reports.judging.distances import Distance
from reports.judging.ledger import LedgerRow
from reports.running.records import Run, Truth

CASE = cases.load("disc_on_line", mu=0.1)
FIRST = "first_transition_time"
TRUTH = Truth(error_bars=(1e-14,), transitions=(Transition(0.3, Mode.SLIP_FORWARD, Mode.ROLL),), centre_bar=1e-14)


def ladder(errors, doubts=None, outcomes=None) -> list[Run]:
    """Runs from coarse to fine with these errors of their first transition, and of their last pose."""
    runs = []
    for place, size in enumerate(errors):
        row = LedgerRow(1, Mode.SLIP_FORWARD, Mode.ROLL, 0.3 + size, 0.3, size, "paired")
        told = dict(ledger=(row,), distance=Distance(*9 * (abs(size),)), spreads=(doubts[place] if doubts else 0.0,))
        outcome = outcomes[place] if outcomes else "right"
        runs.append(Run(CASE.label, "a", "r", Setting.of(h=0.5**place), place, outcome, **told))
    return runs


def first_standing(runs, accuracy: float) -> int | None:
    """The first rung that stands within the accuracy."""
    rungs = accuracy_levels.rungs(runs, FIRST)
    return next((i for i, rung in enumerate(rungs) if rung and rung.standing <= accuracy), None)


def test_a_converging_ladder_reaches_each_accuracy_where_it_comes_below():
    runs = ladder([1e-2, -1e-3, 1e-4, -1e-5, 1e-6])
    assert [first_standing(runs, a) for a in (1e-2, 1e-3, 5e-5, 1e-6, 1e-7)] == [0, 1, 3, 4, None]
    assert accuracy_levels.finest_level(runs, FIRST, TRUTH) == 1e-6


def test_a_lucky_rung_reaches_nothing_that_a_finer_one_contradicts():
    runs = ladder([1e-2, 1e-7, 3e-3, 1e-3, 8e-4])
    assert first_standing(runs, 1e-6) is None and first_standing(runs, 1e-2) == 0
    # 3e-3 comes after it: what it is worth is that.
    assert accuracy_levels.rungs(runs, FIRST)[1].standing == 3e-3


def test_a_scattering_ladder_reaches_what_all_its_finer_rungs_keep():
    # Errors and doubts of a game engine's first transition in a circle, as they were measured.
    errors = [6.8e-4, 2.0e-5, 1.3e-4, 3.5e-5, 2.9e-7, 8.0e-7, 4.2e-6]
    runs = ladder(errors)
    assert first_standing(runs, 1e-4) == 3 and first_standing(runs, 1e-6) is None
    doubted = ladder(errors, [0.0, 0.0, 0.0, 0.0, 2.2e-4, 1.5e-5, 0.0])
    assert first_standing(doubted, 1e-4) == 5 and accuracy_levels.rungs(doubted, FIRST)[4].doubt == 2.2e-4


def test_a_saturated_ladder_stays_where_it_is():
    runs = ladder([1e-2, 1e-4, 1.1e-5, 0.9e-5, 1.2e-5])
    assert first_standing(runs, 1e-5) is None and first_standing(runs, 2e-5) == 2
    assert accuracy_levels.finest_level(runs, FIRST, TRUTH) == 1e-4


def test_error_and_doubt_count_together():
    runs = ladder([6e-5, 6e-5], [0.0, 6e-5])
    assert first_standing(runs, 1e-4) is None and first_standing(runs, 1.3e-4) == 0


def test_doubt_of_a_later_transition_is_none_of_the_first():
    (run,) = ladder([1e-5])
    run = Run(**{**vars(run), "spreads": (float("nan"), 1.0)})
    assert quantities.doubt(run, FIRST) == 0.0 and quantities.doubt(run, "all_transitions") == 1.0


def test_a_finer_motion_that_is_wrong_contradicts_and_one_that_is_none_does_not():
    errors = [1e-3, 1e-5, 1e-6]
    wrong = ladder(errors, outcomes=["right", "right", "wrong"])
    assert first_standing(wrong, 1.0) is None and accuracy_levels.rungs(wrong, FIRST)[0].standing == inf
    for outcome in ("refused", "crashed", "timed_out"):
        silent = ladder(errors, outcomes=["right", "right", outcome])
        assert first_standing(silent, 1e-5) == 1 and accuracy_levels.rungs(silent, FIRST)[2] is None
    coarse = ladder(errors, outcomes=["wrong", "right", "right"])
    assert first_standing(coarse, 1e-5) == 1


def test_how_many_finer_rungs_confirm_is_told():
    runs = ladder([1e-3, 1e-4, 1e-5], outcomes=["right", "crashed", "right"])
    assert [rung and rung.finer for rung in accuracy_levels.rungs(runs, FIRST)] == [1, None, 0]


def test_nothing_is_reached_below_ten_bars_of_the_truth():
    unsure = Truth(error_bars=(1e-6,), transitions=TRUTH.transitions)
    assert accuracy_levels.finest_level(ladder([1e-9]), FIRST, unsure) == 1e-4
    assert isnan(accuracy_levels.finest_level([], FIRST, TRUTH))


@pytest.mark.parametrize("count, lead", [(0, "final_pose"), (1, "final_pose"), (2, "all_transitions")])
def test_a_case_is_led_by_what_chance_cannot_meet(count, lead):
    assert quantities.lead(Truth(transitions=TRUTH.transitions * count)) == lead
