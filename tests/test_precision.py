"""The clock, and what becomes of its timings: work-precision rows, time to accuracy, null scores, the sentence."""

import time
from dataclasses import replace
from functools import partial
from math import isnan, nan

import pytest

import cases
from cases import Cost, Mode, Transition
from reports import clock, precision, trial
from reports.clock import Contestant, Timing
from reports.metrics import Distance, LedgerRow
from reports.precision import Measured
from reports.records import CaseKey, Experiment, Run, Truth

# --- the clock --------------------------------------------------------------------------------------------------------


def work(amount: int, model=None) -> int:
    return sum(range(amount))


def entry(name: str, build, run) -> clock._Entry:
    return clock._Entry(Contestant(name, "r", "s", 0.01), build, run)


def test_set_up_is_off_the_clock():
    one = entry("slow to build", lambda: work(2_000_000), partial(work, 50_000))
    clock.take_turns([one], time.perf_counter() + 1.0)
    timing = clock._timing(one)
    assert 0.0 < timing.cpu_s < timing.setup_s / 4
    assert timing.repeats >= clock.LEAST_REPEATS


def test_ratio_of_timings_is_the_ratio_of_work():
    entries = [entry(str(n), lambda: None, partial(work, n)) for n in (100_000, 400_000)]
    clock.take_turns(entries, time.perf_counter() + 2.0)
    small, large = (clock._timing(e).cpu_s for e in entries)
    # Four times the work; half of that and twice that leave room for a busy machine.
    assert 2.0 < large / small < 8.0


def test_contestants_take_turns():
    order: list[str] = []
    entries = [entry(name, lambda: None, lambda model, name=name: order.append(name)) for name in "ab"]
    clock.take_turns(entries, time.perf_counter() + 0.5)
    # The first repeat of each is a warm-up that is thrown away; then they alternate.
    assert order[:8] == ["a", "a", "b", "b", "a", "b", "a", "b"]


def test_what_does_not_fit_in_the_budget_is_left_out():
    dear = clock._Entry(Contestant("s", "r", "dear", 100.0), lambda: None, lambda model: None)
    cheap = clock._Entry(Contestant("s", "r", "cheap", 0.001), lambda: None, lambda model: None)
    clock.take_turns([cheap, dear], time.perf_counter() + 0.3)
    assert cheap.cpu and not dear.cpu


def test_median_is_known_when_its_spread_is_small():
    assert not clock.known([1.0, 1.0])
    assert clock.known([1.0, 1.0, 1.0])
    assert not clock.known([1.0, 1.5, 2.0])
    assert clock.known([1.0, 1.5, 2.0] * clock.MOST_REPEATS)
    assert isnan(clock.spread([1.0, 2.0]))


def test_row_is_disturbed_if_more_than_a_quarter_of_its_repeats_were():
    one = entry("x", lambda: None, lambda model: None)
    one.cpu, one.wall, one.setup = [1.0] * 4, [1.0] * 4, [0.0]
    one.quiet = [True, True, True, False]
    assert not clock._timing(one).disturbed
    one.quiet = [True, True, False, False]
    assert clock._timing(one).disturbed


def test_reference_is_timed_without_its_sampling():
    case = cases.load("disc_on_line", mu=0.1)
    module = trial.solver("reference")
    route = module.routes[0]
    model = module.build(case, route, module.ladder(case, route)[3])
    module.run(model)
    assert model.result is not None and not hasattr(model, "motion")
    assert module.read(model).transitions[0].time == pytest.approx(1.0 / (3 * 0.1 * 9.81), abs=1e-12)


def test_a_case_is_timed_by_solver_route_and_setting():
    key = CaseKey.of(cases.load("disc_on_line", mu=0.1))
    module = trial.solver("reference")
    route = module.routes[-1]
    setting = str(module.ladder(trial.load(key), route)[0])
    timings = clock.time_case(key, [Contestant("reference", route, setting, 0.01)], 1.0)
    assert timings.keys() == {("reference", route, setting)}
    assert 0.0 < timings["reference", route, setting].cpu_s < 1.0


# --- rows -------------------------------------------------------------------------------------------------------------

BAR = 1e-14


def made(*points: tuple[str, str, float, float | None]) -> tuple[Experiment, Measured]:
    """An experiment of one case from (solver, setting, error, CPU seconds or None for not timed)."""
    case = cases.load("disc_on_line", mu=0.1)
    event = Transition(0.3, Mode.SLIP_FORWARD, Mode.ROLL)
    truth = Truth("taylor", (event,), (BAR,), Mode.SLIP_FORWARD, "completed", centre_bar=BAR)
    runs, timings = [], {}
    for solver, setting, error, cpu in points:
        row = LedgerRow(1, Mode.SLIP_FORWARD, Mode.ROLL, 0.3 + error, 0.3, error, "matched")
        distance = Distance(*6 * (abs(error),))
        told = dict(outcome="right", ledger=(row,), cost=Cost(steps=10), distance=distance)
        runs.append(Run(case.label, solver, "r", setting, 1, **told))
        if cpu is not None:
            timings[case.label, solver, "r", setting] = Timing(cpu, 0.1 * cpu, cpu, 0.0, 5, False)
    return Experiment((case,), {case.label: truth}, tuple(runs), 0.0), Measured((case.label,), timings)


def first(rows, accuracy: float) -> dict[str, dict]:
    return {r["solver"]: r for r in rows if r["quantity"] == "first_transition_time" and r["accuracy"] == accuracy}


def accuracy_rows(*points):
    return precision.time_to_accuracy_rows(precision.work_precision_rows(*made(*points)))


def test_cheapest_setting_that_is_accurate_enough_counts():
    rows = accuracy_rows(("a", "coarse", 1e-3, 1.0), ("a", "fine", -1e-9, 4.0), ("b", "only", 1e-5, 2.0))
    assert first(rows, 1e-2)["a"]["setting"] == "coarse" and first(rows, 1e-4)["a"]["setting"] == "fine"
    assert first(rows, 1e-4)["a"]["ratio"] == 2.0 and first(rows, 1e-4)["b"]["ratio"] == 1.0
    told = first(rows, 1e-4)["a"]
    assert told["ratio_low"] < told["ratio"] < told["ratio_high"]
    assert first(rows, 1e-6)["b"]["cpu_s"] == precision.NEVER


def test_an_accurate_setting_without_a_timing_is_not_called_never():
    rows = accuracy_rows(("a", "fine", 1e-9, None), ("b", "only", 1e-5, 2.0))
    assert first(rows, 1e-8)["a"]["cpu_s"] == precision.NOT_TIMED


def test_no_accuracy_is_told_below_ten_bars_of_the_truth():
    experiment, measured = made(("a", "s", 0.0, 1.0))
    rows = precision.work_precision_rows(experiment, measured)
    assert all(row["below_floor"] for row in rows if row["quantity"] == "first_transition_time")
    label = experiment.cases[0].label
    unsure = {label: replace(experiment.truths[label], error_bars=(1e-6,))}
    rows = precision.time_to_accuracy_rows(precision.work_precision_rows(replace(experiment, truths=unsure), measured))
    assert first(rows, 1e-4)["a"]["cpu_s"] == 1.0 and first(rows, 1e-6)["a"]["cpu_s"] == precision.NOT_KNOWN


def test_wrong_runs_are_praised_for_nothing():
    experiment, measured = made(("a", "s", 1e-9, 1.0))
    wrong = replace(experiment, runs=(replace(experiment.runs[0], outcome="wrong"),))
    assert precision.work_precision_rows(wrong, measured) == []


def test_sentence_says_plainly_where_the_reference_is_dearer():
    cheap = accuracy_rows(("reference", "s", 1e-13, 0.01), ("a", "s", 1e-7, 3.0))
    assert "r 3e+02 times" in precision.headline(cheap) and "not the cheaper" not in precision.headline(cheap)
    dear = accuracy_rows(("reference", "s", 1e-13, 2.0), ("a", "s", 1e-7, 0.5))
    assert "not the cheaper one on: disc_on_line[mu=0.1] at 1e-06 s (a r takes 0.25" in precision.headline(dear)


def test_sentence_tells_of_a_disturbed_machine():
    experiment, measured = made(("reference", "s", 1e-13, 0.01), ("a", "s", 1e-7, 3.0))
    loud = {who: replace(timing, disturbed=True) for who, timing in measured.timings.items()}
    points = precision.work_precision_rows(experiment, measured._replace(timings=loud))
    assert "disturbed during 100%" in precision.headline(precision.time_to_accuracy_rows(points))


def test_figures_draw_nothing_below_ten_bars_of_the_truth(tmp_path):
    from reports import precision_figures
    from reports.figures import _Looks

    experiment, measured = made(("reference", "s", 1e-15, 0.01), ("a", "s", 1e-7, 3.0))
    points = precision.work_precision_rows(experiment, measured)
    figure = precision_figures.work_precision(experiment, experiment.cases[0].label, points[:], _Looks(experiment))
    heights = [y for line in figure.axes[0].lines for y in line.get_ydata()]
    assert min(y for y in heights if not isnan(y)) >= 10 * BAR and 1e-7 in heights
    drawn = list(precision_figures.draw(experiment, measured, tmp_path))
    assert [d.name for d in drawn] == ["work_precision", "work_precision_disc_on_line_mu_0.1"]


def test_all_transitions_are_as_wrong_as_the_worst():
    experiment, _ = made(("a", "s", 1e-9, 1.0))
    run = experiment.runs[0]
    later = replace(run.ledger[0], event=2, error=-2e-5)
    assert precision.error(replace(run, ledger=(run.ledger[0], later)), "all_transitions") == 2e-5
    assert isnan(precision.error(replace(run, ledger=()), "all_transitions"))


# --- null scores ------------------------------------------------------------------------------------------------------


def test_null_scores_of_bowling_are_the_textbook_ones():
    v0, mu, g = 1.0, 0.1, 9.81
    key = CaseKey.of(cases.load("disc_on_line", mu=mu))
    scores = {row["motion"]: row["final_centre_error"] for row in precision.null_scores(key)}
    turn = v0 / (3 * mu * g)
    travelled = v0 * turn - mu * g * turn**2 / 2 + (2 / 3) * v0 * turn
    assert scores["never moves"] == pytest.approx(travelled, rel=1e-9)
    for motion in ("no friction", "rolls from the start"):
        assert scores[motion] == pytest.approx(2 * turn * v0 - travelled, rel=1e-9)


def test_a_null_motion_that_makes_no_sense_is_told():
    rows = precision.null_scores(CaseKey.of(cases.load("frictionless_pendulum")))
    told = {row["motion"]: row for row in rows}
    assert isnan(told["no friction"]["final_centre_error"]) and told["no friction"]["note"]
    assert told["never moves"]["final_centre_error"] != nan
