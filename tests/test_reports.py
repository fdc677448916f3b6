"""The experiment's isolation and verdicts, the tables, and the command as a user meets it."""

import json
import os
import re
import signal
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import cases
from adapters import EngineFailure, Setting
from cases import Cost, Mode, NotSupported, State, Trajectory, Transition
from reports import build, experiment, plan, tables, trial, workers
from reports.metrics import LedgerRow
from reports.records import CaseKey, Run

# --- calls in processes of their own ----------------------------------------------------------------------------------


def misbehave(how: str):
    """One way each in which an engine may fail; "work" gives the folder it worked in."""
    if how == "work":
        print("said something")
        return os.getcwd(), os.listdir(".")
    if how == "raise":
        raise RuntimeError("two\nlines")
    if how == "exit":
        sys.exit(3)
    if how == "vanish":
        os._exit(7)
    if how == "segfault":
        os.kill(os.getpid(), signal.SIGSEGV)
    if how == "hang":
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTERM, signal.SIGINT})
        while True:
            time.sleep(1.0)
    if how == "flood":
        for _ in range(50_000):
            os.write(1, b"x" * 1000)
        with open("big", "wb") as file:
            file.write(b"x" * 40_000_000)
    return how


WAYS = ("work", "raise", "exit", "vanish", "segfault", "hang", "flood", "last")


@pytest.fixture(scope="module")
def answers() -> dict[str, workers.Answer]:
    # Three seconds are long for every way that ends by itself, and short to wait for the one that does not.
    calls = [(way,) for way in WAYS]
    return {WAYS[index]: answer for index, answer in workers.run(misbehave, calls, jobs=2, limit=3.0)}


def test_every_call_is_answered_whatever_the_others_do(answers):
    assert set(answers) == set(WAYS)
    assert answers["last"].outcome == "done" and answers["last"].value == "last"


@pytest.mark.parametrize(
    "way, outcome, reason",
    [
        ("raise", "raised", "RuntimeError: two\nlines"),
        ("exit", "raised", "SystemExit: 3"),
        ("vanish", "died", "exit code 7"),
        ("segfault", "died", "SIGSEGV"),
        ("hang", "timed_out", "still running after 3 s"),
        ("flood", "raised", "File too large"),
    ],
)
def test_failures_are_told_apart(answers, way, outcome, reason):
    assert answers[way].outcome == outcome
    assert reason in answers[way].reason


def test_a_call_works_in_an_empty_folder_that_is_gone_afterwards(answers):
    folder, files = answers["work"].value
    assert files in ([], ["output.txt"]) and not Path(folder).exists() and folder != os.getcwd()


def test_output_is_captured_with_the_answer(answers):
    assert answers["work"].output == "said something"


def test_an_answer_may_be_given_instead_of_a_call():
    given = workers.Answer("done", value="given")
    calls = workers.run(misbehave, [("exit",), ("exit",)], instead=lambda index: given)
    assert list(calls) == [(0, given), (1, given)]


def test_rungs_finer_than_one_that_ran_out_of_time_are_not_tried():
    arguments = [("c", "s", "r", f"h={h}", i, None) for i, h in enumerate((1, 2, 3))] + [
        ("c", "s", "q", "h=1", 0, None)
    ]
    answers = {1: workers.Answer("timed_out"), 0: workers.Answer("done")}
    assert experiment.hopeless(arguments, answers, 0) is None and experiment.hopeless(arguments, answers, 3) is None
    told = experiment.hopeless(arguments, answers, 2)
    assert told is not None and told.outcome == "timed_out" and "h=2 had run out of time" in told.reason


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
    v0, mu, g, r = 1.0, 0.1, 9.81, 0.1
    t = np.linspace(0.0, last * case.duration, samples)
    turn = v0 / (3 * mu * g) + delay
    slipping = np.minimum(t, turn)
    slip = np.where(t < turn, v0 - 3 * mu * g * (t - delay), 0.0)
    vx = v0 - mu * g * slipping
    x = v0 * slipping - mu * g * slipping**2 / 2 + (v0 - mu * g * turn) * np.maximum(t - turn, 0.0)
    omega = (slip - vx) / r
    theta = -mu * g * slipping**2 / r - (v0 - mu * g * turn) / r * np.maximum(t - turn, 0.0)
    zero = np.zeros(samples)
    state = State(x, zero + r, theta, vx, zero, omega, slip, zero + g, np.where(t < turn, -mu * g, 0.0), x, x)
    return Trajectory(t=t, **state._asdict())


@pytest.fixture(scope="module")
def line():
    case = cases.load("disc_on_line", mu=0.1)
    key = CaseKey.of(case)
    return key, trial.find_truth(key)


def performed(monkeypatch, line, read, **more) -> Run:
    key, truth = line
    monkeypatch.setattr(trial, "solver", lambda name: fake_engine(read, **more))
    return trial.perform(key, "fake", "native", Setting.of(h=0.01), 1, truth)


def test_truth_of_bowling_is_the_textbook_time(line):
    _, truth = line
    assert truth.failure == "" and len(truth.witnesses) >= 3
    assert [event.time for event in truth.transitions] == pytest.approx([1.0 / (3 * 0.1 * 9.81)], abs=1e-14)
    assert 0.0 < truth.error_bars[0] < 1e-12


def test_exact_motion_is_right_to_rounding(monkeypatch, line):
    run = performed(monkeypatch, line, bowling)
    assert (run.outcome, run.reason) == ("right", "")
    assert abs(tables.first_error(run)) < 1e-13
    assert max(run.distance) < 1e-13


def test_late_transition_is_right_with_its_error_told(monkeypatch, line):
    run = performed(monkeypatch, line, lambda case: bowling(case, delay=2e-3))
    assert run.outcome == "right"
    assert tables.first_error(run) == pytest.approx(2e-3, abs=1e-9)


def slipping_for_ever(case) -> Trajectory:
    motion = bowling(case)
    return Trajectory(**{**{n: getattr(motion, n) for n in ("t", *State._fields)}, "slip": motion.slip + 0.5})


@pytest.mark.parametrize(
    "read, reason",
    [
        (slipping_for_ever, "1 missed (slip_forward to roll)"),
        (lambda case: bowling(case, last=0.6), "ends at"),
    ],
)
def test_motion_of_another_kind_is_wrong_with_a_reason(monkeypatch, line, read, reason):
    run = performed(monkeypatch, line, read)
    assert run.outcome == "wrong" and reason in run.reason


def with_nan(case) -> Trajectory:
    motion = bowling(case)
    motion.x[5] = np.nan
    return motion


def failing(error):
    def read(case):
        raise error

    return read


@pytest.mark.parametrize(
    "read, outcome, reason",
    [
        (with_nan, "crashed", "not finite"),
        (failing(EngineFailure("Newton gave up")), "crashed", "Newton gave up"),
        (failing(ZeroDivisionError("by zero")), "crashed", "ZeroDivisionError: by zero"),
        (failing(NotSupported("no curves here")), "refused", "no curves here"),
    ],
)
def test_failing_engines_give_rows(monkeypatch, line, read, outcome, reason):
    run = performed(monkeypatch, line, read)
    assert run.outcome == outcome and reason in run.reason


def test_clock_is_around_run_alone(monkeypatch, line):
    def slow(case):
        time.sleep(0.2)
        return bowling(case)

    run = performed(monkeypatch, line, slow, run=lambda model: sum(range(200_000)))
    assert 0.0 < run.cost.cpu_s and run.cost.wall_s < 0.2 <= run.cost.setup_s


def test_transitions_of_a_solver_that_locates_them_are_taken_as_they_are(line):
    own = (Transition(0.25, Mode.SLIP_FORWARD, Mode.ROLL),)
    case = trial.load(line[0])
    motion = bowling(case)
    located = Trajectory(
        **{n: getattr(motion, n) for n in ("t", *State._fields)}, transitions=own, first_mode=Mode.ROLL
    )
    assert trial.read(case, located).transitions == own and trial.read(case, located).first_mode is Mode.ROLL


def test_survey_gives_reasons_for_routes_and_engines_that_refuse(monkeypatch, line):
    monkeypatch.setattr(trial, "solver", lambda name: fake_engine(bowling, routes=("native", "shy")))
    native, shy = trial.survey(line[0], "fake")
    assert native.settings and (shy.outcome, shy.reason) == ("refused", "it cannot")

    def missing(name):
        raise ImportError("No module named 'fake'")

    monkeypatch.setattr(trial, "solver", missing)
    (offer,) = trial.survey(line[0], "fake")
    assert offer.outcome == "refused" and "not installed" in offer.reason


# --- tables -----------------------------------------------------------------------------------------------------------


def rung(steps: int, error: float, **more) -> Run:
    row = LedgerRow(1, Mode.SLIP_FORWARD, Mode.ROLL, 0.3 + error, 0.3, error, "matched")
    told = dict(case="c", solver="s", route="r", setting=f"n={steps}", rung=1, outcome="right", ledger=(row,))
    return Run(**{**told, "cost": Cost(steps=steps), **more})


def fitted(ladder, floor=1e-15) -> tables.Order:
    return tables.order(ladder, [tables.first_error(run) for run in ladder], floor)


def test_order_of_a_clean_ladder_is_its_power():
    fit = fitted([rung(n, -3.0 / n**2) for n in (100, 200, 400, 800)])
    assert (fit.order, fit.low, fit.high) == pytest.approx((2.0, 2.0, 2.0))
    assert len(fit.settings) == 4 and fit.note == ""


def test_rungs_at_the_floor_do_not_count_towards_the_order():
    ladder = [rung(n, 3.0 / n**2) for n in (100, 200, 400, 800)] + [rung(1600, 1e-9), rung(3200, 2e-9)]
    assert fitted(ladder, floor=1e-9).order == pytest.approx(2.0)
    unsure = [rung(n, 3.0 / n**2, spreads=(1.0,)) for n in (100, 200, 400)]
    assert np.isnan(fitted(unsure).order)


@pytest.mark.parametrize(
    "ladder, note",
    [
        ([rung(100, 1e-3), rung(200, 1e-4)], "2 of 2 right rungs"),
        ([rung(n, 1e-3 / n) for n in (100, 110, 120)], "steps differ by less"),
    ],
)
def test_where_no_order_can_be_fitted_the_table_says_why(ladder, note):
    fit = fitted(ladder)
    assert np.isnan(fit.order) and note in fit.note


def test_no_more_is_claimed_than_the_truth_allows():
    row = dict(is_truth=False, finest_error=3e-15, finest_outcome="right", transitions=1, truth_error_bar=1e-12)
    assert tables.error_text(row, "finest_error") == "< 1.0e-12"
    assert tables.error_text({**row, "finest_error": -3e-5}, "finest_error") == "-3.0e-05"
    assert tables.error_text({**row, "finest_error": float("nan")}, "finest_error") == "missed"


# --- the command ------------------------------------------------------------------------------------------------------


@pytest.fixture
def case_file(tmp_path, monkeypatch):
    monkeypatch.setattr(cases.registry, "_entries", dict(cases.registry._entries))
    file = tmp_path / "broken.py"
    file.write_text("from cases import case\n\n\n@case\ndef broken_case():\n    return 1 / 0\n")
    return str(file)


@pytest.mark.parametrize(
    "argv, hint",
    [
        (["--case", "disc_in_circel"], "disc_in_circle"),
        (["--case", "disc_in_circle[mu=nan]"], "finite"),
        (["--case", "disc_in_circle[m=-1]"], "greater than zero"),
        (["--case", "disc_in_circle[mass=1]"], "parameter"),
        (["--case", "disc_in_circle[mu]"], "parameter=number"),
        (["--case", "disc_in_circle[r=2]"], "smaller plate"),
        (["--solver", "exudin"], "exudyn"),
        (["--solvr", "exudyn"], "--solver"),
        (["--jobs", "many"], "whole number"),
        (["--jobs", "0"], "at least 1"),
        (["--quick", "--full"], "not allowed with"),
        (["--case-file", "nowhere.py"], "nowhere.py"),
        (["--case"], "expected at least one"),
        (["--out", "."], "inside it"),
    ],
)
def test_nonsense_is_told_in_one_line_and_nothing_is_written(argv, hint, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert build.main(argv) == 2
    told = capsys.readouterr()
    assert told.out == "" and told.err.count("\n") == 1 and hint in told.err
    assert list(tmp_path.iterdir()) == []


def test_failing_case_file_is_told_in_one_line(case_file, tmp_path, capsys):
    out = tmp_path / "out"
    assert build.main(["--case-file", case_file, "--out", str(out)]) == 2
    told = capsys.readouterr().err
    assert told.count("\n") == 1 and "ZeroDivisionError" in told and not out.exists()


@pytest.mark.parametrize("manifest", [None, "[]", "{", '{"made_by": "someone else", "files": ["mine.txt"]}'])
def test_a_folder_that_is_no_report_is_left_alone(manifest, tmp_path, capsys):
    (tmp_path / "mine.txt").write_text("precious")
    if manifest is not None:
        (tmp_path / "manifest.json").write_text(manifest)
    before = sorted(tmp_path.iterdir())
    assert build.main(["--out", str(tmp_path)]) == 2
    assert "no part of a report" in capsys.readouterr().err
    assert sorted(tmp_path.iterdir()) == before and (tmp_path / "mine.txt").read_text() == "precious"


def test_out_that_is_a_file_is_left_alone(tmp_path, capsys):
    (tmp_path / "report").write_text("precious")
    assert build.main(["--out", str(tmp_path / "report")]) == 2
    assert "which is a file" in capsys.readouterr().err


def test_list_tells_of_a_case_that_fails_and_goes_on(case_file, capsys):
    assert build.main(["--list", "--case-file", case_file]) == 0
    told = capsys.readouterr().out
    assert "ZeroDivisionError" in told and "disc_in_circle[mu=0.2]" in told


def test_list_names_every_case_and_solver(capsys):
    assert build.main(["--list"]) == 0
    told = capsys.readouterr().out
    assert all(name in told for name in (*cases.names(), "reference", "exudyn", "pymunk", "disc_in_circle[mu=0.2]"))


def test_ladders_are_thinned_in_quick_reports_and_in_the_breadth_of_the_catalogue():
    settings = (Setting.of(rung="defaults"), *(Setting.of(h=10.0**-i) for i in range(7)))
    few = (settings[0], settings[1], settings[3], settings[5])

    def kept(effort, asked, case):
        return plan.Plan(Path("x"), (), (), (), effort, 1, (), asked).thin(case, settings)

    assert kept("quick", True, "disc_in_circle") == few
    assert kept("default", False, "disc_in_circle") == settings
    assert kept("default", False, "littlewood_hoop") == few
    assert kept("default", True, "littlewood_hoop") == settings
    assert kept("full", False, "littlewood_hoop") == settings


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """A small report of two solvers, made by the command."""
    out = tmp_path_factory.mktemp("made") / "deep" / "report"
    argv = [
        "--out",
        str(out),
        "--quick",
        "--case",
        "disc_on_line",
        "disc_on_incline",
        "--solver",
        "reference",
        "pymunk",
    ]
    assert build.main(argv) == 0
    return out


def test_report_has_every_promised_file_and_no_other(report):
    manifest = json.loads((report / "manifest.json").read_text())
    files = {p.relative_to(report).as_posix() for p in report.rglob("*") if p.is_file()}
    assert files == set(manifest["files"])
    promised = {"index.html", "manifest.json", "figures/headline.png"}
    promised |= {f"tables/{name}.{kind}" for name in tables.TABLES for kind in ("csv", "md")}
    assert promised <= files
    assert [p.name for p in report.parent.iterdir()] == ["report"]  # no partial report is left beside it


def test_manifest_tells_how_it_was_made(report):
    manifest = json.loads((report / "manifest.json").read_text())
    assert manifest["made_by"] == plan.MADE_BY and "--quick" in manifest["command"]
    assert {"numpy", "scipy"} <= manifest["packages"].keys() and manifest["python"].startswith("3.")
    assert set(manifest["solvers"]) == {"reference", "pymunk"}


def test_tables_have_the_promised_columns(report):
    promised = {
        "transitions": "case,solver,route,setting,event,before,after,time,reference_time,error,truth_error_bar,verdict",
        "trajectories": "case,solver,route,setting,outcome,reason,status,first_mode,transitions_true,matched,missed,"
        "spurious,centre_max,centre_rms,angle_max,angle_rms,slip_max,slip_rms,cpu_s,setup_s,steps",
        "convergence": "case,solver,route,quantity,order,order_low,order_high,finest_error,settings_used,note",
    }
    for name, columns in promised.items():
        assert (report / "tables" / f"{name}.csv").read_text().splitlines()[0] == columns


def test_reference_is_right_on_the_textbook_cases(report):
    import pandas as pd

    rows = pd.read_csv(report / "tables" / "trajectories.csv")
    own = rows[rows["solver"] == "reference"]
    assert len(own) >= 6 and set(own["outcome"]) == {"right"}


def test_page_is_self_contained_and_tells_how_to_make_it_again(report):
    page = (report / "index.html").read_text()
    assert not re.search(r"<script|https?://(?!www\.w3\.org)|@import|url\(", page)
    pictures = re.findall(r'<img[^>]*src="([^"]{0,30})', page)
    assert len(pictures) == 7 and all(source.startswith("data:image/svg+xml;base64,") for source in pictures)
    for target in re.findall(r'href="([^#"][^"]*)"', page):
        assert (report / target).is_file(), target
    for target in re.findall(r'href="#([^"]+)"', page):
        assert f'id="{target}"' in page, target
    remake = "python -m reports.build --quick --solver reference pymunk --case &quot;disc_on_line[mu=0.3]&quot;"
    assert remake in page


def test_a_report_that_fails_half_way_leaves_the_old_one_standing(report, monkeypatch, capsys):
    before = (report / "index.html").read_bytes()

    def full(*_):
        raise OSError("no space left on device")

    monkeypatch.setattr(tables, "write", full)
    argv = ["--out", str(report), "--quick", "--case", "disc_on_incline[slope=0.2]", "--solver", "reference"]
    assert build.main(argv) == 1
    assert "no space left" in capsys.readouterr().err
    assert (report / "index.html").read_bytes() == before
    assert [p.name for p in report.parent.iterdir()] == ["report"]


def test_a_report_takes_the_place_of_an_older_one(report, tmp_path):
    import shutil

    out = tmp_path / "report"
    shutil.copytree(report, out)
    argv = ["--out", str(out), "--quick", "--case", "disc_on_incline[slope=0.2]", "--solver", "reference"]
    assert build.main(argv) == 0
    assert "disc_on_line" not in (out / "tables" / "truth.csv").read_text()
    assert [p.name for p in tmp_path.iterdir()] == ["report"]
