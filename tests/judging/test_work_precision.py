"""Tables and sentences from timings: work-precision rows, orders, time to a level, null scores, figures."""

from dataclasses import replace
from math import isfinite, isnan, nan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import cases
from adapters import Setting
from cases import Cost, Mode, Transition
from reports.analysis import (
    cost_conclusions,
    null_scores,
    quantities,
    time_to_accuracy,
    which_engine,
    work_precision,
)
from reports.analysis.convergence import convergence_rows
from reports.analysis.work_precision import CostMeasurements
from reports.judging.distances import Distance
from reports.judging.friction_factor import Losses
from reports.judging.ledger import LedgerRow
from reports.judging.score import Scale, Score
from reports.running.records import Experiment, Run, Truth
from reports.running.timing import timed_pass
from reports.running.timing.clock import Timing
from reports.running.timing.cold_start import ColdStart
from reports.running.timing.time_breakdown import TimeBreakdown

BAR = 1e-14
SCALE = Scale(1.0, 1.0, 1.0, 2.0, (), (), (), 1.0, Losses(1.0, 1.0), "no friction", 1.0, 0.01)


def timing(cpu: float, disturbed=False) -> Timing:
    return Timing(cpu, 0.9 * cpu, 1.1 * cpu, cpu, 0.0, 0.0, 0.0, cpu, 5, 0, disturbed)


def rung(name: str) -> Setting:
    return Setting.of(s=name)


def made(*points: tuple[str, str, float, float | None]) -> tuple[Experiment, CostMeasurements]:
    """An experiment of one case from (solver, setting, error, CPU seconds or None for not timed); the error of all
    quantities, off included, has this size."""
    case = cases.load("disc_on_line", mu=0.1)
    event = Transition(0.3, Mode.SLIP_FORWARD, Mode.ROLL)
    truth = Truth("taylor", (event,), (BAR,), Mode.SLIP_FORWARD, "completed", centre_bar=BAR, scales={"": SCALE})
    runs, times = [], {}
    for place, (solver, setting, error, cpu) in enumerate(points):
        row = LedgerRow(1, Mode.SLIP_FORWARD, Mode.ROLL, 0.3 + error, 0.3, error, "paired")
        distance = Distance(*9 * (abs(error),))
        score = Score(abs(error), 0.0, abs(error), 0.0, 0.0, nan, 0.0, 1e-3, False)
        output = dict(outcome="answered", ledger=(row,), cost=Cost(steps=10 * 4**place), distance=distance, score=score)
        runs.append(Run(case.label, solver, "r", rung(setting), 1, **output))
        if cpu is not None:
            times[case.label, solver, "r", rung(setting)] = timing(cpu)
    null = {"motion": "never moves", **dict.fromkeys(quantities.UNITS, 3e-3)}
    nulls = {case.label: null_scores.Baseline((null,), dict.fromkeys(quantities.UNITS, BAR))}
    return Experiment((case,), {case.label: truth}, tuple(runs)), CostMeasurements((case.label,), times, nulls)


def disturb(measured: CostMeasurements, *solvers: str) -> CostMeasurements:
    output = {who: replace(t, disturbed=t.disturbed or who[1] in solvers) for who, t in measured.timings.items()}
    return measured._replace(timings=output)


def first(rows, level: float) -> dict[str, dict]:
    return {r["solver"]: r for r in rows if r["level"] == level}


def accuracy_rows(*points, disturbed: tuple[str, ...] = ()):
    experiment, measured = made(*points)
    return time_to_accuracy.rows(experiment, disturb(measured, *disturbed))


# --- rows -------------------------------------------------------------------------------------------------------------


def test_cheapest_setting_that_is_accurate_enough_counts():
    rows = accuracy_rows(("a", "coarse", 5e-2, 1.0), ("a", "fine", -1e-9, 4.0), ("b", "only", 5e-4, 2.0))
    assert first(rows, 0.1)["a"]["setting"] == rung("coarse") and first(rows, 1e-3)["a"]["setting"] == rung("fine")
    assert first(rows, 1e-3)["a"]["ratio"] == 2.0 and first(rows, 1e-3)["b"]["ratio"] == 1.0
    output = first(rows, 1e-3)["a"]
    assert output["ratio_low"] < output["ratio"] < output["ratio_high"]
    assert [first(rows, 0.1)[name]["reached"] for name in "ab"] == ["reached", "one setting"]
    assert first(rows, 1e-4)["b"]["reached"] == "not reached" and isnan(first(rows, 1e-4)["b"]["cpu_s"])


def test_an_accurate_setting_without_a_timing_is_not_timed():
    rows = accuracy_rows(("a", "fine", 1e-9, None), ("b", "only", 1e-5, 2.0))
    assert first(rows, 1e-4)["a"]["reached"] == time_to_accuracy.NOT_TIMED


def test_an_error_below_ten_bars_of_the_truth_is_not_known():
    experiment, measured = made(("a", "s", 0.0, 1.0))
    rows = work_precision.work_precision_rows(experiment, measured)
    assert all(row["below_floor"] for row in rows if row["quantity"] == "first_transition_time")
    label = experiment.cases[0].label
    unsure = {label: replace(experiment.truths[label], error_bars=(5e-4,))}
    rows = time_to_accuracy.rows(replace(experiment, truths=unsure), measured)
    assert first(rows, 1e-3)["a"]["cpu_s"] == 1.0 and first(rows, 1e-4)["a"]["reached"] == "not known"


def test_disturbed_timings_rank_nothing():
    points = ("a", "s", 1e-9, 1.0), ("b", "s", 1e-9, 2.0), ("c", "s", 1e-9, 3.0)
    rows = first(accuracy_rows(*points, disturbed=("b",)), 1e-2)
    assert rows["b"]["reached"] == time_to_accuracy.DISTURBED and isnan(rows["b"]["rank"]) and isnan(rows["b"]["ratio"])
    # The other two are compared with each other alone.
    assert (rows["a"]["rank"], rows["c"]["rank"], rows["c"]["ratio"]) == (1.0, 2.0, 3.0)


def test_routes_whose_intervals_meet_share_a_rank():
    rows = first(accuracy_rows(("a", "s", 1e-9, 1.0), ("b", "s", 1e-9, 1.1), ("c", "s", 1e-9, 9.0)), 1e-2)
    assert [rows[name]["rank"] for name in "abc"] == [1.0, 1.0, 3.0]


def test_unusable_runs_have_no_rows():
    experiment, measured = made(("a", "s", 0.6, 1.0))
    assert work_precision.work_precision_rows(experiment, measured) == []
    assert {row["reached"] for row in time_to_accuracy.rows(experiment, measured)} == {"not reached"}


def test_orders_in_steps_and_in_time_are_fitted():
    # Four times the steps and twice the time a rung; second order in steps is fourth order in time.
    ladder = [("a", f"h={i}", 1e-2 * 16.0**-i, 2.0**i) for i in range(4)]
    experiment, measured = made(*ladder)
    rows = {row["quantity"]: row for row in convergence_rows(experiment, measured)}
    assert rows.keys() == {*quantities.UNITS, "centre_max"}
    assert {row["quantity"] for row in convergence_rows(experiment)} == {"off", "first_transition_time", "centre_max"}
    for row in rows.values():
        assert (row["order"], row["order_in_time"]) == pytest.approx((2.0, 4.0))
        assert row["saturation"] == "" and row["settings"] == 4
    rows = convergence_rows(experiment, disturb(measured, "a"))
    assert all(isnan(row["order_in_time"]) and isfinite(row["order"]) for row in rows)


def test_a_default_report_runs_whole_ladders_of_one_variant_of_each_family_that_it_times():
    from reports.running.ladder_selection import WHOLE_LADDERS

    variants = [cases.select(label)[0] for label in WHOLE_LADDERS]
    assert [case.label for case in variants] == [*WHOLE_LADDERS]
    assert len({case.name for case in variants}) == len(variants) == timed_pass.MOST_CASES


# --- null scores ------------------------------------------------------------------------------------------------------


def test_null_scores_of_bowling_are_the_textbook_ones():
    v0, mu, g = 1.0, 0.1, 9.81
    output = null_scores.baseline(cases.load("disc_on_line", mu=mu))
    scores = {row["motion"]: row for row in output.rows}
    turn = v0 / (3 * mu * g)
    # It lasts twice as long: it slows down to 2/3 v0 and takes up spin, evenly, and then rolls.
    travelled = v0 * turn - mu * g * turn**2 / 2 + (2 / 3) * v0 * turn
    turned = 1.5 * (2 / 3) * v0 / 0.1 * turn
    assert scores["never moves"]["final_pose"] == pytest.approx(np.hypot(travelled, turned * 0.1 / np.sqrt(2)))
    # The level line keeps the normal force whatever friction does; a disc that never moves tells none.
    assert scores["no friction"]["normal_force_mean"] == pytest.approx(0.0, abs=1e-12)
    assert isnan(scores["never moves"]["normal_force_mean"])
    # Friction takes a third of the kinetic energy, ½ m v² + ½ J ω² = ¾ m (⅔ v₀)²; on the way there, a parabola in time,
    # less of it: in the mean over the slip ⅔ of that third. Who never moves has none of what is left.
    lost = (2 / 3 + 1) / 2 / 3
    assert scores["no friction"]["energy_mean"] == pytest.approx(lost, rel=1e-3)
    assert scores["never moves"]["energy_mean"] == pytest.approx(1 - lost, rel=1e-3)
    assert scores["rolls from the start"]["first_transition_time"] == pytest.approx(turn)
    assert scores["no friction"]["centre_rms"] == pytest.approx(scores["rolls from the start"]["centre_rms"])


def test_a_null_motion_that_makes_no_sense_is_told():
    output = null_scores.baseline(cases.load("frictionless_pendulum"))
    rows = {row["motion"]: row for row in output.rows}
    assert isnan(rows["no friction"]["final_pose"]) and rows["no friction"]["note"]
    assert isfinite(rows["never moves"]["final_pose"])


def test_second_method_witnesses_what_is_not_certified():
    output = null_scores.baseline(cases.load("frictionless_pendulum"))
    assert output.witness_errors.keys() == set(quantities.DISTANCES)
    # Two integrators at rtol 1e-13 over a second and a half of a pendulum.
    assert all(0.0 <= far < 1e-11 for far in output.witness_errors.values())


# --- in words and pictures --------------------------------------------------------------------------------------------


def answered(*points, disturbed: tuple[str, ...] = (), cold: dict[str, float] | None = None, share: float = 0.25):
    """The first sentence and the rest, and the rows behind them; `cold`: seconds of a first call, by solver."""
    experiment, measured = made(*points)
    measured = disturb(measured, *disturbed)
    firsts = {key: ColdStart((cold or {}).get(key[1], 1.0), 0.0, 0.0, 3, False) for key in measured.timings}
    parts = {key: TimeBreakdown(share, 0.0, 1.0 - share, 0.0) for key in measured.timings}
    output = time_to_accuracy.rows(experiment, measured._replace(cold=firsts, parts=parts))
    answers = which_engine.rows(output)
    return cost_conclusions.headline(answers, output), answers, output


REFERENCE, ENGINE = ("reference", "s", 1e-13, 0.001), ("a", "s", 1e-7, 0.1)


def test_first_sentence_says_who_is_cheaper_by_what_once_and_a_thousand_times():
    # From cold the engine 0.05 s and the reference 0.4; a thousand: 0.05 + 999 · 0.1 s and 0.4 + 0.999 s.
    said, answers, _ = answered(REFERENCE, ENGINE, cold={"reference": 0.4, "a": 0.05})
    assert said.first == (
        "Called from Python, within 1 % in disc_on_line[mu=0.1]: the first run takes 50 ms with a r and 400 ms with "
        "reference r (a r is faster, by 8 ×); 1,000 runs take 1.4 s with reference r and 100 s with a r (reference r "
        "is faster, by 71 ×)."
    )
    # 0.35 s more from cold, 0.099 s less a run: after 3.5 further runs.
    assert "The reference is faster there from 5 runs on." in said.rest
    assert {row["break_even_runs"] for row in answers} == {5.0}
    assert "an engine is faster in" not in said.rest  # of one case the first sentence says it


def test_an_accuracy_that_no_engine_reaches_is_answered_so():
    _, answers, _ = answered(REFERENCE, ("a", "s", 5e-3, 0.1))
    (row,) = (r for r in answers if r["level"] == 1e-4 and r["runs"] == 1)
    assert row["engine"] == row["cheaper"] == "" and row["reason"] == which_engine.NO_ENGINE
    assert row["reference"] == "reference r" and row["reference_total_s"] == 1.0


@given(st.floats(1e-3, 10.0), st.floats(1e-3, 10.0), st.floats(1e-4, 1.0), st.floats(1e-4, 1.0))
def test_break_even_is_the_first_count_from_which_the_reference_is_cheaper(cold_a, cold_r, call_a, call_r):
    engine, own = ({"first_call_s": f, "call_s": c} for f, c in ((cold_a, call_a), (cold_r, call_r)))
    runs = time_to_accuracy.break_even([engine], [own])

    def saved(n: float) -> float:
        return time_to_accuracy.cost(engine, int(n)) - time_to_accuracy.cost(own, int(n))

    rounding = 1e-9 * (cold_a + cold_r)
    if isnan(runs):
        assert call_r >= call_a
    else:
        assert saved(runs) > -rounding and saved(10 * runs) > -10 * runs * rounding
        assert runs == 1.0 or saved(runs - 1.0) < rounding * runs
