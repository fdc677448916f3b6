"""What a terminal is shown: one line that moves, in a log next to nothing, and at the end the answer and the path."""

import io
import math

import pandas as pd
from rich.console import Console

from adapters import Setting
from reports.analysis import solver_summary
from reports.judging.ledger import LedgerRow
from reports.running.processes import progress
from reports.running.processes.progress import Display, in_words, usual
from reports.running.records import Experiment, Run, Truth


def test_the_time_left_is_that_of_the_whole_at_the_pace_seen(monkeypatch):
    """Steps of 100, 200 and 100 s as a rule, on a machine half as fast."""
    now = [0.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: now[0])
    display, told = Display({"a": 100.0, "b": 200.0, "c": 100.0}), []
    monkeypatch.setattr(display, "_show", lambda step, done, total, left: told.append((step, done, left)))

    def slowly(count, seconds):
        for i in range(count):
            now[0] += seconds
            yield i

    with display:
        assert list(display("a", 4, slowly(4, 50.0))) == [0, 1, 2, 3]
        assert list(display("b (3 more from the store)", 4, slowly(4, 100.0))) == [0, 1, 2, 3]
        list(display("c", 2, slowly(2, 100.0)))
    left = {(step, done): seconds for step, done, seconds in told}
    assert abs(left["b (3 more from the store)", 2] - (200.0 + 200.0)) < 20.0
    assert abs(left["c", 1] - 100.0) < 10.0 and left["c", 2] == 0.0


def test_a_step_that_had_nothing_to_do_is_not_waited_for():
    display = Display({"a": 1000.0, "b": 10.0})
    with display:
        list(display("b", 1, iter([0])))
        assert display._remaining("b", 1, 1, 1.0) < 1.0


def test_a_log_is_left_quiet_and_hears_of_a_long_step(monkeypatch, capsys):
    with Display(usual(3, True, True), Console(file=io.StringIO())) as display:
        assert list(display("runs", 500, iter(range(500)))) == list(range(500))
        assert capsys.readouterr().err == ""
        monkeypatch.setattr(progress, "LOG_SECONDS", -1.0)
        list(display("figures", 2, iter("ab")))
    assert "figures: 1 of 2" in capsys.readouterr().err


def test_a_terminal_sees_step_count_and_time_left():
    shown = io.StringIO()
    with Display(usual(3, True, True), Console(file=shown, force_terminal=True, width=100)) as display:
        list(display("runs", 2, iter("ab")))
        display._bars.refresh()
    assert "runs 2/2" in shown.getvalue() and "left" in shown.getvalue()


def test_a_duration_is_said_as_one_says_it():
    assert [in_words(s) for s in (1, 43, 89, 200, 7800)] == ["5 s", "45 s", "90 s", "3 min", "2 h 10 min"]


def test_the_answer_has_a_row_for_each_route_with_medians_and_counts():
    def run(case, route, setting, outcome, error=math.nan):
        ledger = (LedgerRow(1, "slip_forward", "roll", 1.0 + error, 1.0, error, "paired"),)
        return Run(case, "pymunk", route, setting, 0, outcome, ledger=ledger)

    default, fine = Setting.of(rung="defaults"), Setting.of(h=1e-4)
    runs = [run("a", "native", default, "wrong", 0.2), run("a", "native", fine, "right", -1e-6)]
    runs += [run("b", "native", default, "right", -0.1), run("b", "native", fine, "crashed")]
    runs += [run(case, "native", fine, "right", error) for case, error in (("c", 3e-6), ("d", 2e-6))]
    runs += [run("a", "assisted", Setting.of(), "refused")]
    hard = pd.DataFrame(
        [{"case": "h", "solver": "pymunk", "route": "native", "outcome": o} for o in ("right", "wrong")]
    )
    truths = {name: Truth() for name in "abcd"}
    native, assisted = solver_summary.rows(Experiment((), truths, tuple(runs), 0.0), {"stability": hard})
    counted = {"cases": 4, "right": 3, "wrong": 0, "failed": 1, "hard_right": 0, "hard_wrong": 1}
    assert {name: native[name] for name in counted} == counted
    assert abs(native["middle_default_error"] - 0.15) < 1e-12 and native["middle_finest_error"] == 2e-6
    assert assisted["refused"] == 1 and math.isnan(assisted["middle_finest_error"])
