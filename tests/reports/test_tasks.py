"""One run and its verdict, and the tables."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

import cases
from adapters import EngineFailure, Setting
from adapters.processes.worker import CallResult
from cases import Mode, NotSupported, Start, Trajectory, Transition
from reports.analysis import columns, tables
from reports.judging import several_contacts
from reports.page import table_files
from reports.running import clocked_run, experiment, tasks
from reports.running.calls import Calls
from reports.running.records import Run, first_error
from reports.running.true_motions import true_motion
from tests.fake_adapter import bowled

# --- one run and its verdict ------------------------------------------------------------------------------------------


def fake_engine(read, routes=("native",), run=lambda model: None):
    """An adapter that gives the trajectory `read(case)` whatever its setting."""
    return SimpleNamespace(
        NAME="fake",
        routes=routes,
        refuses=lambda case, route: "it cannot" if route == "shy" else None,
        ladder=lambda case, route: (Setting.of(h=0.01),),
        build=lambda case, route, setting: case,
        run=run,
        read=read,
        version=lambda: "1.0",
    )


def bowling(case, delay=0.0, samples=300, last=1.0) -> Trajectory:
    """The exact motion of `disc_on_line`, its transition late by `delay` seconds."""
    return bowled(case, np.linspace(0.0, last * case.duration, samples), delay)


@pytest.fixture(scope="module")
def line():
    case = cases.load("disc_on_line", mu=0.1)
    return case, tasks.find_truth(case)


def performed(monkeypatch, line, read, **more) -> Run:
    case, truth = line
    monkeypatch.setattr(tasks, "solver", lambda name: fake_engine(read, **more))
    return tasks.measure(case, "fake", "native", Setting.of(h=0.01), 1, truth)


def test_truth_of_bowling_is_the_textbook_time(line):
    _, truth = line
    assert truth.failure == "" and len(truth.witnesses) >= 3
    assert [event.time for event in truth.transitions] == pytest.approx([1.0 / (3 * 0.1 * 9.81)], abs=1e-14)
    assert 0.0 < truth.error_bars[0] < 1e-12


def test_truth_of_a_plate_at_rest_is_a_row_that_can_be_written(tmp_path):
    """Its path is 0, so the error of ignoring friction is no share of it: an infinite share once ended a report."""
    case = replace(cases.load("disc_on_line"), start=Start(xi1=0.0))
    rows = tables.truth_rows(SimpleNamespace(truths={case.label: tasks.find_truth(case)}))
    frames = {"truth": pd.DataFrame(rows)}
    words = {"truth": columns.describe_column("truth", map(str, frames["truth"].columns))}
    assert table_files.write(table_files.Tables(frames, words), tmp_path, "make it")
    assert frames["truth"].friction_share.isna().all()


def test_exact_motion_is_right_to_rounding(monkeypatch, line):
    run = performed(monkeypatch, line, bowling)
    assert (run.outcome, run.grade, run.sequence) == ("answered", "excellent", "same sequence")
    assert run.score.off <= run.score.doubt + 1e-12
    assert abs(first_error(run)) < 1e-13
    assert max(run.distance) < 1e-13


def test_late_transition_has_its_error_in_the_ledger(monkeypatch, line):
    run = performed(monkeypatch, line, lambda case: bowling(case, delay=2e-3))
    assert first_error(run) == pytest.approx(2e-3, abs=1e-9)
    assert run.score.mode == pytest.approx(2e-3 / line[1].scale.time, rel=1e-3)


def failing(error):
    def read(case):
        raise error

    return read


@pytest.mark.parametrize(
    "read, outcome, reason",
    [
        (failing(EngineFailure("Newton gave up")), "crashed", "Newton gave up"),
        (failing(ZeroDivisionError("by zero")), "crashed", "ZeroDivisionError: by zero"),
        (failing(NotSupported("no curves here")), "unsupported", "no curves here"),
    ],
)
def test_failing_engines_give_rows(monkeypatch, line, read, outcome, reason):
    run = performed(monkeypatch, line, read)
    assert run.outcome == outcome and reason in run.reason


def test_clock_is_around_run_alone(monkeypatch, line):
    """By a clock that building and running alone move on."""
    now = [0.0]
    for name in ("process_time", "perf_counter"):
        monkeypatch.setattr(clocked_run, name, lambda: now[0])

    def takes(seconds, result):
        def work(case):
            now[0] += seconds
            return result(case)

        return work

    run = performed(monkeypatch, line, takes(5.0, bowling), run=takes(1.0, lambda model: None))
    assert (run.cost.cpu_s, run.cost.wall_s, run.cost.setup_s) == (1.0, 1.0, 5.0)


def test_transitions_of_a_solver_that_locates_them_are_taken_as_they_are(line):
    case, truth = line
    own = (Transition(truth.transitions[0].time, Mode.SLIP_FORWARD, Mode.ROLL, cause="told"),)
    true, motion = true_motion(case, truth.method), bowling(case)
    located = replace(motion, transitions=own, first_mode=Mode.SLIP_FORWARD)
    judgement = several_contacts.judge(case, located, true, truth.scales, truth.transitions)
    assert judgement.transitions == own and judgement.first_mode is Mode.SLIP_FORWARD
    read = several_contacts.judge(case, motion, true, truth.scales, truth.transitions)
    assert read.transitions[0].cause != "told"


def test_survey_gives_reasons_for_routes_and_engines_that_refuse(monkeypatch, line):
    monkeypatch.setattr(tasks, "solver", lambda name: fake_engine(bowling, routes=("native", "shy")))
    native, shy = tasks.survey(line[0], "fake")
    assert native.settings and (shy.outcome, shy.reason) == ("unsupported", "it cannot")

    def missing(name):
        raise ImportError("No module named 'fake'")

    monkeypatch.setattr(tasks, "solver", missing)
    (offer,) = tasks.survey(line[0], "fake")
    assert offer.outcome == "not_installed" and "fake" in offer.reason


class InThisProcess(Calls):
    """Makes calls here; those about the case `broken` end their process."""

    broken: cases.Case | None = None

    def each(self, step, function, arguments, **how):
        self.made = [*getattr(self, "made", ()), *arguments]
        for index, call in enumerate(arguments):
            subjects = call[0] if isinstance(call[0], tuple) else call[:1]
            died = any(case is self.broken for case in subjects)
            yield index, CallResult("died", reason="gone") if died else CallResult("done", value=function(*call))


@pytest.mark.parametrize("place", ["routes", "ladder", "run"])
def test_an_engine_that_fails_since_its_folder_is_gone_has_no_row(place, monkeypatch, line, tmp_path):
    """The error reaches the pool, which decides whose fault it is."""
    case, truth = line
    (tmp_path / "scratch").mkdir()
    monkeypatch.chdir(tmp_path / "scratch")

    def fail(*_):
        (tmp_path / "scratch").rmdir()
        raise ValueError("an error of the engine's own")

    engine = fake_engine(bowling)
    if place == "routes":
        engine.routes = (type("Route", (), {"__str__": fail})(),)
    else:
        setattr(engine, place, fail)
    monkeypatch.setattr(tasks, "solver", lambda name: engine)
    with pytest.raises(OSError, match="scratch|No such file"):
        if place == "run":
            tasks.measure(case, "fake", "native", Setting.of(h=0.01), 1, truth)
        else:
            tasks.survey(case, "fake")


def test_a_solver_that_fails_for_one_of_many_cases_is_asked_about_the_others():
    some = [cases.load("disc_in_circle", mu=mu) for mu in (0.1, 0.2, 0.3)]
    usual, broken = InThisProcess(), InThisProcess()
    broken.broken = some[1]
    expected = {(case.label, "reference"): tasks.survey(case, "reference") for case in some}
    assert experiment.offers(some, ["reference"], usual) == expected
    offers = experiment.offers(some, ["reference"], broken)
    (failed,) = offers.pop((some[1].label, "reference"))
    assert (failed.outcome, failed.reason) == ("crashed", "asking for its ladder: gone")
    assert list(offers) == [key for key in expected if key[0] != some[1].label]
    assert offers.items() <= expected.items()
