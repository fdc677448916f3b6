"""`--trajectory NAME@CASE=FILE.csv`: a motion from elsewhere is a solver of its own in the report, without a time."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

import cases
import reference
from reports import build
from reports.analysis.convergence import convergence_rows
from reports.running import external_motions, tasks
from reports.running.records import Experiment, Truth
from reports.running.timing import timed_pass

LABEL = "disc_on_line[mu=0.1]"
CASE = cases.load(LABEL)


@pytest.fixture(scope="module")
def motion() -> pd.DataFrame:
    exact = reference.simulate(CASE, rtol=1e-12)
    t = np.linspace(0.0, exact.t[-1], 1501)
    columns = ("x", "y", "theta", "vx", "vy", "omega", "slip", "normal_force", "friction_force")
    state = exact(t)
    return pd.DataFrame({"t": t, **{name: getattr(state, name) for name in columns}})


@pytest.fixture
def file(tmp_path, motion):
    path = tmp_path / "mine.csv"
    motion.to_csv(path, index=False)
    return path


@pytest.fixture(scope="module")
def report(tmp_path_factory, motion, in_process):
    """The folder of a report of one case with two trajectories from external."""
    folder = tmp_path_factory.mktemp("elsewhere")
    motion.to_csv(folder / "mine.csv", index=False)
    motion[["t", "x", "y", "theta"]].to_csv(folder / "poses.csv", index=False)
    given = ["--trajectory", f"mine={folder}/mine.csv", "--trajectory", f"theirs@{LABEL}={folder}/poses.csv"]
    out = folder / "report"
    with in_process(), pytest.MonkeyPatch.context() as patch:
        patch.setattr(timed_pass, "BUDGET", 1.0)  # s: who is ranked is asked here, not how surely
        assert build.main(["--case", LABEL, "--solver", "reference", "--out", str(out), *given]) == 0
    return out


def test_trajectory_gets_rows_figures_and_a_verdict_of_its_own(report):
    rows = pd.read_csv(report / "tables" / "trajectories.csv")
    for name, setting in (("mine", "file=mine.csv"), ("theirs", "file=poses.csv")):
        (row,) = rows[rows.solver == name].itertuples()
        assert (row.route, row.setting, row.grade) == ("file", setting, "excellent")
        assert np.isnan(row.cpu_s)
    events = pd.read_csv(report / "tables" / "transitions.csv")
    found = events[events.solver == "mine"]
    assert list(found.pairing) == ["paired"]
    assert abs(found.error.iloc[0]) < 1e-8
    assert {"mine", "theirs"} <= set(pd.read_csv(report / "tables" / "headline.csv").solver)
    # Where it agrees to the last digit there is no distance to draw: that of poses alone is.
    assert "theirs, file" in (report / "figures" / "headline.svg").read_text()
    output = json.loads((report / "manifest.json").read_text())["solvers"]["mine"]
    assert output.startswith("a trajectory from mine.csv (sha256 ")


@pytest.mark.parametrize("table", ["work_precision", "time_to_accuracy"])
def test_trajectory_is_ranked_nowhere_in_time(report, table):
    assert set(pd.read_csv(report / "tables" / f"{table}.csv").solver) == {"reference"}


@pytest.fixture(scope="module")
def nothing_yet() -> Experiment:
    """An experiment that knows the truth of CASE and has no run."""
    return Experiment((CASE,), {LABEL: tasks.find_truth(CASE)}, ())


def test_several_files_of_a_name_are_its_rungs_and_give_an_order(tmp_path, motion, nothing_yet):
    files = []
    for step in (16, 8, 4, 2):
        # A first-order solver's error: the plate is late by a tenth of its step.
        late = motion.assign(slip=np.interp(motion.t - 0.1 * step * 1e-3, motion.t, motion.slip))
        late.iloc[::step].to_csv(tmp_path / f"h{step}.csv", index=False)
        files.append(f"mine={tmp_path / f'h{step}.csv'}")
    joined = external_motions.join_external(nothing_yet, external_motions.from_options(files, [CASE], ()))
    assert [(run.rung, str(run.setting)) for run in joined.runs] == [
        (1, "file=h16.csv"), (2, "file=h8.csv"), (3, "file=h4.csv"), (4, "file=h2.csv"),
    ]  # fmt: skip
    (row,) = [r for r in convergence_rows(joined) if r["quantity"] == "first_transition_time"]
    assert row["order"] == pytest.approx(1.0, abs=0.1)


def test_trajectory_of_a_case_without_truth_is_refused(file, nothing_yet):
    unknown = replace(nothing_yet, truths={LABEL: Truth(failure="the witnesses disagree")})
    (run,) = external_motions.join_external(unknown, external_motions.from_options([f"mine={file}"], [CASE], ())).runs
    assert (run.outcome, run.reason) == ("unsupported", "there is no truth to judge it by: the witnesses disagree")
