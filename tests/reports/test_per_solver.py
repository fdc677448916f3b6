"""Results of one solver that no table or figure can show: everything is made without them, says so, and nothing else
changes."""

import json
from dataclasses import dataclass, replace
from math import inf
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import cases
from adapters import Setting
from cases import Cost
from reports import build, studies
from reports.analysis import null_scores
from reports.analysis.work_precision import CostMeasurements
from reports.drawing.figure_files import FigureEntry
from reports.judging.distances import Distance
from reports.page import pictures
from reports.running import experiment, per_solver, tasks
from reports.running.calls import Calls
from reports.running.names import REFERENCE
from reports.running.per_solver import LeftOut
from reports.running.records import Experiment, Run
from reports.running.timing import clock, timed_pass
from reports.studies import Request

from .identical import identical

pytestmark = pytest.mark.builds

CASE = cases.load("disc_on_line", mu=0.1)
# An engine, and one whose rows are the same but where they are spoilt.
SOUND, SPOILT = "pymunk", "spoilt"


# --- what makes something fail ----------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Row:
    solver: str
    number: object = 1


def total(rows) -> dict[str, int]:
    return {row.solver: row.number + 1 for row in rows}


def test_what_does_not_fail_is_made_once_of_all_rows():
    made = []
    result, left = per_solver.make_per_solver(lambda rows: made.append(rows), ([Row("a"), Row("b")],), "ab")
    assert made == [[Row("a"), Row("b")]] and left == []


@pytest.mark.parametrize("spoilt", ["a", "b", "ac", "abc"])
def test_solvers_whose_rows_fail_alone_are_left_out(spoilt):
    rows = [Row(name, "x" if name in spoilt else 1) for name in "abc"]
    result, left = per_solver.make_per_solver(total, (rows,), "abc", "table x")
    assert result == {name: 2 for name in "abc" if name not in spoilt}
    assert [(one.item, one.solver) for one in left] == [("table x", name) for name in spoilt]
    assert all(one.reason.startswith("TypeError: ") for one in left)


def test_a_solver_that_fails_only_beside_others_is_left_out():
    def make(rows):
        if {"a", "b"} <= {row.solver for row in rows}:
            raise ValueError("not these two")
        return len(rows)

    result, left = per_solver.make_per_solver(make, ([Row(name) for name in "abc"],), "abc")
    assert result == 1 and [one.solver for one in left] == ["a", "b"] and left[0].reason == "ValueError: not these two"


def test_what_no_solver_s_rows_are_the_reason_of_is_raised():
    with pytest.raises(ZeroDivisionError):
        per_solver.make_per_solver(lambda rows: 1 / 0, ([Row("a")],), "a")
    with pytest.raises(OSError, match="full"):
        per_solver.make_per_solver(full_disk, ([Row("a", "x")],), "a")


def full_disk(rows):
    raise OSError("the disk is full")


def test_rows_are_taken_out_of_all_that_holds_them():
    run = Run("c", SPOILT, "r", Setting.of(), 1, "answered")
    ran = Experiment((CASE,), {}, (run, replace(run, solver=SOUND)), 0.0, {SPOILT: "1"})
    keys = {("c", name, "r", Setting.of()): clock.NO_TIMING for name in (SPOILT, SOUND)}
    frame = pd.DataFrame({"solver": [SPOILT, SOUND], "x": [1, 2]})
    found = per_solver.without(
        {"ran": ran, "keys": keys, "frame": frame, "pairs": ((run, 1), (replace(run, solver=SOUND), 2))}, {SPOILT}
    )
    assert identical(found["ran"], replace(ran, runs=ran.runs[1:])) and list(found["keys"]) == list(keys)[1:]
    assert list(found["frame"]["x"]) == [2] and [number for _, number in found["pairs"]] == [2]
    assert per_solver.without([{"solver": SPOILT}, {"solver": SOUND}], {SPOILT}) == [{"solver": SOUND}]
    assert per_solver.solvers_of((ran, frame, [{"solver": "other"}])) == [SPOILT, SOUND, "other"]
    assert per_solver.without(CASE, {SPOILT}) is CASE


# --- a report ---------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def ran() -> Experiment:
    """The reference and an engine on a case, six settings each."""
    truth = tasks.find_truth(CASE)
    runs: list[Run] = []
    for name in (REFERENCE, SOUND):
        (offer, *_) = tasks.survey(CASE, name)
        for rung, setting in enumerate(offer.settings[:6], 1):
            runs.append(tasks.perform(CASE, name, offer.route, setting, rung, truth))
    assert {run.outcome for run in runs} <= {"answered"}
    return Experiment((CASE,), {CASE.label: truth}, tuple(runs), 1.0, {REFERENCE: "1", SOUND: "2"})


@pytest.fixture(scope="module")
def measured(ran) -> CostMeasurements:
    """Timings as if each step took a microsecond."""
    times = {
        (run.case, run.solver, run.route, run.setting): replace(
            clock.NO_TIMING, cpu_s=1e-6 * run.cost.steps, cpu_low_s=0.9e-6 * run.cost.steps,
            cpu_high_s=1.1e-6 * run.cost.steps, wall_s=1.0, setup_s=1e-3, read_s=1e-3, call_s=1.0, repeats=5,
        )
        for run in ran.runs
    }  # fmt: skip
    return CostMeasurements((CASE.label,), times, {CASE.label: null_scores.baseline(CASE)})


def spoilt(ran: Experiment, *changes: dict) -> Experiment:
    """With the engine's runs once more for each change, by other engines' names, the last two changed so."""
    mine = [run for run in ran.runs if run.solver == SOUND]
    more: list[Run] = []
    for i, change in enumerate(changes):
        copies = [replace(run, solver=f"{SPOILT}_{i}") for run in mine]
        more += [*copies[:-2], *(replace(run, **change) for run in copies[-2:])]
    return replace(ran, runs=(*ran.runs, *more))


SHORT = {"t": np.array([0.0, 1.0]), "slip": np.array([1.0])}
CHANGES = {
    "a text for a count": dict(cost=Cost(steps="12")),
    "a number beyond all sizes": dict(cost=Cost(cpu_s=10**400, steps=10**400)),
    "an array for a count": dict(cost=Cost(steps=np.arange(3))),
    "no cost": dict(cost=None),
    "infinite": dict(distance=Distance(*6 * (inf,))),
    "no distance": dict(distance=None),
    "no ledger": dict(ledger=(None,)),
    "words for spreads": dict(spreads=("much",)),
    "an array for a status": dict(status=np.zeros((2, 2))),
    "no setting": dict(setting=None),
    "samples too short": dict(samples=SHORT, off=SHORT),
    "no samples": dict(samples=None, off=None),
    "an outcome that is none": dict(outcome="splendid"),
}


@pytest.fixture(scope="module")
def written(ran, measured, tmp_path_factory):
    """written(changes) -> folder of a report of these runs, made by the command without figures."""

    def write(monkeypatch, *changes: dict) -> Path:
        folder = tmp_path_factory.mktemp("report")
        monkeypatch.chdir(folder)
        monkeypatch.setattr(experiment, "run_cases", lambda *given: spoilt(ran, *changes))
        monkeypatch.setattr(build, "_measure", lambda *given: measured)
        monkeypatch.setattr(build, "_study", lambda *given: [])
        monkeypatch.setattr(pictures, "draw", lambda *given: ([], {}))
        assert build.main(["--case", CASE.label, "--quick", "--solver", REFERENCE, SOUND, "--store", "store"]) == 0
        return folder / "report"

    return write


def rows_of_others(report: Path) -> dict[str, list]:
    """All rows of all tables but those of engines whose rows are spoilt, and what is left out."""
    found = {}
    for file in sorted((report / "tables").glob("*.csv")):
        frame = pd.read_csv(file, dtype=str, keep_default_na=False)
        if file.stem != "left_out":
            of = frame["solver"] if "solver" in frame.columns else pd.Series([""] * len(frame), dtype=str)
            spoilt = of.str.startswith(SPOILT)
            if "other_solver" in frame:  # a pair is of both
                spoilt |= frame["other_solver"].str.startswith(SPOILT)
            found[file.stem] = frame[~spoilt].to_dict("records")
    return found


@pytest.fixture(scope="module")
def clean(written):
    with pytest.MonkeyPatch.context() as patch:
        return rows_of_others(written(patch))


def check(report: Path, output: str, clean: dict[str, list]) -> set[str]:
    """Nothing but rows of the spoilt engines is missing; those that are left out, everywhere the same."""
    assert (report / "index.html").stat().st_size > 100_000
    assert rows_of_others(report) == clean
    manifest = json.loads((report / "manifest.json").read_text())
    if not (report / "tables" / "left_out.csv").exists():
        assert manifest["left_out"] == [] and "made without" not in output
        return set()
    left = pd.read_csv(report / "tables" / "left_out.csv", dtype=str, keep_default_na=False)
    assert all(left["item"]) and all(left["reason"]) and all(left["solver"].str.startswith(SPOILT))
    assert [one["item"] for one in manifest["left_out"]] == list(left["item"])
    assert f"{left['item'][0]} made without {left['solver'][0]}: {left['reason'][0]}" in output.splitlines()
    assert "Tables and figures without the results of a solver" in (report / "index.html").read_text()
    return set(left["solver"])


def test_rows_that_no_table_can_show_cost_no_other_solver_a_row(written, clean, monkeypatch, capsys):
    """All of them at once."""
    report = written(monkeypatch, *CHANGES.values())
    out = check(report, capsys.readouterr().out, clean)
    shown = [name for i, name in enumerate(CHANGES) if f"{SPOILT}_{i}" not in out]
    assert set(shown) <= {"an outcome that is none", "a text for a count", "an array for a status"}


@pytest.mark.slow
@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
def test_each_row_that_no_table_can_show_costs_no_other_solver_a_row(change, written, clean, monkeypatch, capsys):
    check(written(monkeypatch, change), capsys.readouterr().out, clean)


def test_a_sound_report_says_nothing_of_this(written, monkeypatch, capsys):
    report = written(monkeypatch)
    output = capsys.readouterr().out
    assert not (report / "tables" / "left_out.csv").exists() and "made without" not in output
    assert "without the results of a solver" not in (report / "index.html").read_text()


# --- timings ----------------------------------------------------------------------------------------------------------


def test_timings_are_made_without_a_solver_whose_runs_cannot_be_planned(ran, monkeypatch):
    timed = []
    monkeypatch.setattr(timed_pass, "time_together", lambda who, *given: timed.extend(who) or ([], []))
    with Calls(1) as calls:
        found = timed_pass.measure(spoilt(ran, dict(cost=Cost(wall_s="long"))), True, calls)
    assert {one.solver for one in timed} == {REFERENCE, SOUND}
    assert list(found.failures) == [f"all cases, {SPOILT}_0"] and all(found.failures.values())


# --- studies ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("fails", ["rows", "run", "infinite"])
def test_a_study_that_fails_with_a_solver_is_made_without_it(fails, monkeypatch):
    class Study:
        """Rows of two solvers."""

        TITLE = QUESTION = ""
        TABLES = {"x": None}

        @staticmethod
        def run(request, calls):
            if fails == "run" and SPOILT in request.solvers:
                raise ValueError("no such run")
            return [{"solver": name, "number": name == SPOILT and fails} for name in request.solvers]

        @staticmethod
        def rows(found):
            if any(row["number"] == "rows" for row in found):
                raise TypeError("no such row")
            spoilt = {"infinite": inf}
            return {"x": [row | {"number": spoilt.get(row["number"], 1.0)} for row in found]}

    monkeypatch.setattr(studies, "study", lambda name: Study)
    with Calls(1, versions={SOUND: "1", SPOILT: "1"}) as calls:
        result = studies.run_study("x", Request(solvers=(SOUND, SPOILT)), calls, "")
    assert result.failure == "" and list(result.frames["x"]["solver"]) == [SOUND]
    assert [row["solver"] for row in result.findings] == [SOUND]
    assert [one[:2] for one in result.left_out] == [("study x", SPOILT)]


def test_pictures_of_a_study_are_drawn_without_a_solver_that_fails(tmp_path):
    def drawn(found, folder):
        if any(row["number"] is None for row in found):
            raise TypeError("no number")
        yield FigureEntry("a", "", "A", "")

    found = [{"solver": SOUND, "number": 1}, {"solver": SPOILT, "number": None}]
    (one,) = studies.draw("x", drawn, (found,), tmp_path)
    assert one.left_out == (LeftOut("figures of x", SPOILT, "TypeError: no number"),)
