"""`python -m reports.sweep`: rows in parts, a sweep that goes on, boundaries, a sentence for what makes no sense."""

from __future__ import annotations

import json
import re
import time

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import parquet

import adapters
import cases
import reference
from adapters.processes.pool import WorkerPool
from reference.paper.application import slip_end
from reference.sweeping import plan, table
from reports import sweep
from reports.running import cluster, tasks
from reports.sweeping import boundary_search, parts
from reports.sweeping.computation import Part, run_parts
from reports.sweeping.parts import SweepWork
from reports.sweeping.sweep_folder import Folder

VARY = ["disc_in_circle", "--vary", "mu=0.05:0.25:6", "--vary", "xi1=0:1.2:5"]


@pytest.fixture
def at_once(in_process):
    """Parts of a sweep are computed in this process."""
    with in_process():
        yield


def rows_of(folder) -> pa.Table:
    return pa.concat_tables(Folder(folder).rows("rows"))


def test_a_sweep_writes_rows_and_a_map_and_goes_on_where_it_was(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert sweep.main([*VARY, "--out", "map"]) == 0
    out = tmp_path / "map"
    assert {"rows", "sweep.json", "map.svg", "map.png"} <= {file.name for file in out.iterdir()}
    rows = rows_of(out)
    assert rows.schema.names == ["scenario", "mu", "xi1", *table.COLUMNS]
    same = reference.sweep("disc_in_circle", mu="0.05:0.25:6", xi1="0:1.2:5")
    assert rows.column("sequence").to_pylist() == same.sequence.tolist()
    before = {file: file.stat().st_mtime_ns for file in out.glob("rows/*")}
    capsys.readouterr()
    assert sweep.main([*VARY, "--out", "map"]) == 0
    assert "0 of them made now" in capsys.readouterr().out
    assert before == {file: file.stat().st_mtime_ns for file in out.glob("rows/*")}
    # Another question into the same folder is refused, and nothing is touched.
    assert sweep.main([*VARY[:-1], "xi1=0:1.2:7", "--out", "map"]) == 2
    assert "holds another sweep" in capsys.readouterr().err
    assert before == {file: file.stat().st_mtime_ns for file in out.glob("rows/*")}


@pytest.mark.filterwarnings("ignore")  # Dask's own, of a connection that nobody answers
def test_where_no_scheduler_answers_it_is_said(tmp_path, monkeypatch, capsys):
    pytest.importorskip("distributed")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(cluster, "ANSWERS", 1.0)
    assert sweep.main([*VARY, "--dask", "tcp://127.0.0.1:9"]) == 2
    assert "no scheduler answers at --dask tcp://127.0.0.1:9" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


FATAL = '''
import os
from cases import case, load

@case
def fatal(mu=0.1, xi1=0.2):
    """A disc in a circle whose scene ends the process for one coefficient."""
    if abs(mu - 0.3) < 1e-9:
        os.abort()
    return load("disc_in_circle", mu=mu, xi1=xi1)
'''


def test_a_scenario_that_ends_its_process_is_a_row(tmp_path):
    file = tmp_path / "fatal.py"
    file.write_text(FATAL)
    import cases

    cases.load_file(file)
    asked = plan("fatal", dict(mu="0.2:0.4:3"), files=[str(file)])
    coming = dict(run_parts(SweepWork(asked), [Part(0, 3)], WorkerPool(1)))
    rows = [row for part in sorted(coming) for row in parquet.read_table(pa.BufferReader(coming[part])).to_pylist()]
    assert [row["scenario"] for row in rows] == [0, 1, 2]
    assert [row["outcome"] for row in rows] == ["completed", "crashed", "completed"]
    assert "SIGABRT" in rows[1]["reason"] and rows[1]["mu"] == pytest.approx(0.3)


def test_refinement_finds_the_boundary_where_the_inequality_has_it(accuracy):
    """Between reversing and rolling |T| = μ₀ N at the exact zero of v; ten digits of μ₀ in a few hundred scenarios."""
    asked = plan("disc_in_circle", dict(mu="0.05:0.2:4", xi1=0.3))
    found = boundary_search.find_boundaries(asked, 1e-10)
    assert found.points == 1 and found.width.max() <= 1e-10 and found.scenarios < 400
    assert [kind.rpartition(" ")[2] for kind in found.kinds[0]] == ["backward", "rolls"]
    mu, step = float(found.x[0]), 1e-6
    slope = (slip_end(mu + step, 0.3).demand - slip_end(mu - step, 0.3).demand) / (2 * step)
    error = (slip_end(mu, 0.3).demand - 1.0) / slope
    accuracy(
        case="disc_in_circle", solver="sweep", route="refine", quantity="boundary in mu", error=error, tolerance=1e-10
    )


@pytest.mark.slow
def test_forty_thousand_scenarios_take_seconds():
    """3.3 phases a scenario, some 7 µs each at best: a CPU second or two of one core. Twice that for a busy machine."""
    asked = plan("disc_in_circle", dict(mu="0.01:0.5:200", xi1="0:1.5:200"), rtol=1e-9)
    table.scenario_rows(asked, 0, 400, optimised=True)
    began = time.process_time()
    rows = [table.scenario_rows(asked, start, start + 4000, optimised=True) for start in range(0, 40_000, 4000)]
    assert time.process_time() - began < 3.0
    assert sum(map(len, rows)) == 40_000 and np.sum(rows[0].column("alone")) == 0


def test_an_engines_rows_have_the_grades_of_a_report():
    sweep_plan = plan("disc_in_circle", {"mu": [0.1, 0.2]}, "grid")
    rows = parts.of_engine(SweepWork(sweep_plan, "pymunk", "native"), 0, 2).to_pylist()
    for mu, row in zip((0.1, 0.2), rows, strict=True):
        case = cases.load("disc_in_circle", mu=mu)
        setting = adapters.engine("pymunk").ladder(case, "native")[0]
        run = tasks.measure(case, "pymunk", "native", setting, 1, tasks.find_truth(case))
        assert (row["outcome"], row["grade"], row["setting"]) == ("answered", run.grade, str(setting))
        # The sweep's truth has a tolerance of 1e-10.
        assert row["off"] == pytest.approx(run.score.off, rel=1e-5)
        assert row["friction_factor"] == pytest.approx(run.friction_factor, rel=1e-5)
        assert row["reason"] == run.reason


OWN = '''
from cases import case, disc, load

@case
def thin(mu=0.1, slip=0.2):
    """A disc whose radius is negative for every parameter."""
    disc(-1.0 - mu, 1.0)

@case
def half(mu=0.1, v0=1.0):
    """A disc on a line that is a scene for some coefficients alone."""
    if mu < 0.15:
        disc(-1.0 - mu, 1.0)
    return load("disc_on_line", mu=mu, v0=v0)
'''


def test_what_applies_to_all_scenarios_ends_the_sweep_at_once(tmp_path, monkeypatch, capsys, at_once):
    """It took 5 minutes to say "no such scene" 10,000 times, with exit status 0."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own.py").write_text(OWN.replace("half", "some"))
    began = time.process_time()
    assert sweep.main(["own.py:thin", "--vary", "mu=0.1:0.2:1000", "--vary", "slip=0:1:1000"]) == 2
    assert time.process_time() - began < 20.0
    (line,) = [line for line in capsys.readouterr().err.splitlines() if "none of" in line]
    assert "none of 127 scenarios tried, of 1,000,000: radius of the disc is -1." in line
    # The folder takes the next sweep.
    assert sweep.main(["own.py:some", "--vary", "mu=0.1:0.2:2", "--vary", "v0=1:2:2"]) == 0


def test_a_summary_has_the_reasons_with_their_counts(tmp_path, monkeypatch, capsys, at_once, catalogue):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "half.py").write_text(OWN.replace("thin", "none"))
    words = ["half.py:half", "--vary", "mu=0.1:0.2:5", "--vary", "v0=1:2:2"]
    assert sweep.main(words) == 0
    said = capsys.readouterr()
    assert "6  slips forward, then rolls" in said.out
    assert "4  bad_case: radius of the disc is -1.1; give a number greater than zero" in said.out
    assert re.search("reference: .* of CPU time per scenario; 10 take about 5 s with ", said.err)
    assert sweep.main([*words, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["kinds"] == {"slips forward, then rolls": 6, "no such scene": 4} and found["made_now"] == 0
    assert [(one["outcome"], one["scenarios"]) for one in found["reasons"]] == [("bad_case", 4)]


def test_engines_are_summarised_and_none_that_answers_is_status_3(tmp_path, monkeypatch, capsys, at_once):
    monkeypatch.chdir(tmp_path)
    few = ["--vary", "mu=0.1:0.2:2", "--vary", "v0=1:2:2", "--solver", "pymunk"]
    assert sweep.main(["disc_on_line", *few]) == 0
    (line,) = [line for line in capsys.readouterr().out.splitlines() if "median" in line and "assisted" in line]
    answers, off = line.removeprefix("pymunk, assisted: ").split("; median off ")
    assert sum(int(number) for number in re.findall("[0-9]+", answers)) == 4 and off.endswith(" %")
    refused = "the engine has no such wheel"
    monkeypatch.setattr(parts, "refusal", lambda *_: refused)
    assert sweep.main(["disc_on_line", *few, "--fresh"]) == 3
    said = capsys.readouterr().out
    assert "pymunk, native: 4 unsupported" in said and f"4  unsupported: {refused}" in said


@pytest.mark.parametrize(
    ("case", "vary", "one_by_one"),
    [("disc_in_circle", "xi1=0.1:0.5:100", False), ("stribeck_disc", "low=0.1:0.2:100", True),
     ("sliding_box", "mu=0.1:0.2:100", True), ("driven_disc", "mu=0.1:0.3:100", True)],
)  # fmt: skip
def test_every_effect_is_swept_and_the_trial_says_how(case, vary, one_by_one):
    name, _, values = vary.partition("=")
    tried = parts.pilot(SweepWork(plan(case, {name: values})))
    assert tried.one_by_one == one_by_one and not tried.no_scene and 0.0 < tried.seconds < 10.0


@pytest.mark.parametrize("more", [["--vary", "slope=0.1:0.2:2"], []])
def test_a_sweep_of_several_contacts_is_mapped_and_summed_up(more, tmp_path, monkeypatch, capsys, at_once):
    """The phases of its sequences name their contacts."""
    monkeypatch.chdir(tmp_path)
    assert sweep.main(["sliding_box", "--vary", "mu=0.2:0.4:2", "--certify", *more]) == 0
    said, rows = capsys.readouterr().out, rows_of(tmp_path / "sweep").to_pylist()
    assert (tmp_path / "sweep" / "map.svg").exists() and "  slips forward, then rolls (plate/track" in said
    changes = [row["sequence"].split(table.ARROW)[1:] for row in rows]
    assert any(changes) and all(": " in change for one in changes for change in one)
    assert [len(row["error_bars"]) for row in rows] == [len(one) for one in changes]
