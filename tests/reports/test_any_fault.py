"""Any engine, any fault, any part of it, any command: a row, status 0, and every other row as without it."""

import os
import sys
from pathlib import Path

import pandas as pd
import pytest

import adapters
import adapters.laws.__main__ as laws
from adapters.laws import law_process
from reports import build, options, show, studies, study
from reports.running import calls, experiment
from reports.studies import error_parts
from reports.studies.stability import study as stability

from .. import fake_adapter

# What becomes of the rows of an adapter that misbehaves so in that part. Of a version nothing is a row's.
FATES = {
    ("file", "missing"): "",  # it is not installed: no row, and its line says so
    ("file", "syntax"): "crashed",
    ("import", "raises"): "crashed",
    ("import", "exits"): "crashed",
    ("import", "vanishes"): "crashed",
    ("import", "segfault"): "crashed",
    ("import", "hang"): "timed_out",
    ("version", "raises"): "answered",
    ("version", "strange"): "answered",
    ("version", "hang"): "answered",
    ("refuses", "segfault"): "crashed",
    ("refuses", "exits"): "crashed",
    ("refuses", "strange"): "unsupported",
    ("ladder", "raises"): "crashed",
    ("ladder", "strange"): "crashed",
    ("ladder", "many"): "crashed",
    ("ladder", "unwritable"): "crashed",
    ("ladder", "hang"): "timed_out",
    ("grid", "segfault"): "answered",
    ("build", "exits"): "crashed",
    ("build", "vanishes"): "crashed",
    ("run", "segfault"): "crashed",
    ("run", "killed"): "crashed",
    ("run", "hang"): "timed_out",
    **{
        (part, "forks"): "answered"
        for part in ("import", "version", "refuses", "ladder", "grid", "build", "run", "read")
    },
    **{(part, "prints"): "answered" for part in ("import", "version", "refuses", "ladder", "build", "run", "read")},
    ("run", "rounds"): "answered",
    ("run", "sulks"): "answered",
    ("run", "floods"): "crashed",
    ("run", "garbles"): "crashed",
    ("read", "raises"): "crashed",
    ("read", "strange"): "crashed",
    ("read", "own"): "crashed",
    **{("read", way): "crashed" for way in fake_adapter.ODD_STEPS},
}
# Faults that are over at once, of the part that is imported, asked, run and read: each takes workers of its own.
FEW = [("import", "exits"), ("ladder", "unwritable"), ("run", "forks"), ("read", "text")]
# A finite pose so far away that its square is no number: whatever it is called, it is a row.
FAR = ("read", "far")
# A worker needs a second or two to import what an adapter imports: that is no hang.
LIMIT = 6.0
MEASURED = ["cpu_s", "setup_s", "cpu_low_s", "cpu_high_s", "cpu_to_first", "repeats", "disturbed", "run_at"]


def name_of(fault: tuple[str, str]) -> str:
    return "_".join(fault)


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """installed(faults) -> names of copies of the fake engine that misbehave so; a sound one is beside them."""
    for module, what in (
        (calls, "ASKING_SECONDS"), (experiment, "ASKING_SECONDS"), (stability, "_LIMIT"),
        (error_parts, "LIMIT_SECONDS"), (law_process, "LIMIT_SECONDS"),
    ):  # fmt: skip
        monkeypatch.setattr(module, what, LIMIT)
    monkeypatch.setattr(options, "RUN_SECONDS", {"quick": LIMIT, "default": LIMIT})
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.chdir(tmp_path)
    before = {*sys.modules}  # other tests of this process may have adapters of their own

    def install(faults, ladder=("wait 0",)) -> list[str]:
        fake_adapter.install(tmp_path, list(ladder), name="sound")
        for fault in faults:
            fake_adapter.install(tmp_path, list(ladder), name=name_of(fault))
            fake_adapter.break_down(tmp_path, name_of(fault), *fault)
        return [name_of(fault) for fault in faults]

    yield install
    callers = {int(line) for line in (tmp_path / "callers.txt").read_text().split()}
    assert callers and os.getpid() not in callers, "an adapter was called in the parent process"
    assert not any("adapter_of_tests" in name for name in sys.modules.keys() - before)


def table(name: str, solvers: list[str]) -> pd.DataFrame:
    """The rows of these solvers in a table of the report, without what differs from run to run."""
    frame = pd.read_csv(Path("report/tables") / f"{name}.csv", dtype=str, keep_default_na=False)
    return frame[frame["solver"].isin(solvers)].drop(columns=MEASURED, errors="ignore").reset_index(drop=True)


def built(*words: str) -> int:
    return build.main([*words, "--fresh"])


def check(words: list[str], broken: list[str], faults) -> None:
    """A build without and one with the broken ones: the others' rows are the same, theirs are what is expected."""
    others = ["reference", "sound"]
    assert built(*words, "--solver", *others) == 0
    clean = {name: table(name, others) for name in ("trajectories", "transitions", "convergence", "headline")}
    assert built(*words, "--solver", "sound", *broken, "reference") == 0
    for name, frame in clean.items():
        by = list(frame.columns)
        again = table(name, others)
        pd.testing.assert_frame_equal(
            again.sort_values(by, ignore_index=True), frame.sort_values(by, ignore_index=True), obj=name
        )
    rows = table("trajectories", broken)
    outcomes = {fault: set(rows[rows["solver"] == name_of(fault)]["outcome"]) for fault in faults}
    assert outcomes == {fault: {FATES[fault]} - {""} if fault in FATES else outcomes[fault] for fault in faults}
    assert not list(Path().glob(".report*")), "nothing is left beside the report"


def test_a_fault_of_an_engine_is_a_row_and_no_other_row_changes(installed, without_figures):
    with without_figures():
        check(["--quick", "--case", fake_adapter.CASE], installed(FEW), FEW)


@pytest.mark.slow
def test_every_fault_is_a_row_of_a_default_report_with_timings(installed):
    # Enough settings for a curve, so that all of them come to the clock.
    faults, ladder = [*FATES, FAR], [f"wait {i}" for i in range(6)]
    check(["--case", fake_adapter.CASE], installed(faults, ladder), faults)
    assert not table("work_precision", ["sound"]).empty


@pytest.mark.slow
@pytest.mark.parametrize("fault", [("import", "segfault"), ("run", "hang"), ("read", "raises")])
def test_a_report_whose_only_engine_fails_is_a_report(fault, installed):
    (name,) = installed([fault], [f"wait {i}" for i in range(6)])
    assert build.main(["--case", fake_adapter.CASE, "--solver", name]) == 3  # the case was named, and nobody ran it
    assert set(table("trajectories", [name])["outcome"]) == {FATES[fault]}
    assert "could not be drawn" not in Path("report/index.html").read_text()


@pytest.mark.slow
@pytest.mark.parametrize("which", [n for n in studies.names() if "solver" in studies.study(n).TAKES])
def test_every_fault_is_a_row_of_a_study(which, installed):
    broken = installed(FATES)
    words = ["--case", fake_adapter.CASE] if "case" in studies.study(which).TAKES else []
    assert study.main([which, *words, "--solver", "sound", *broken]) == 0
    output = pd.read_csv(Path(which) / f"{which}.csv", keep_default_na=False)
    assert set(output["solver"]) == {"sound", *broken} - {"file_missing"}
    assert set(output[output["solver"] == "sound"]["outcome"]) <= {"answered", "done"}


@pytest.mark.slow
def test_commands_that_only_ask_get_through_every_fault(installed, capsys):
    broken = installed(FATES)
    assert build.main(["--list"]) == 0
    listed = capsys.readouterr().out
    assert all(f"  {name}: " in listed for name in ["sound", *broken])
    show.run([fake_adapter.CASE, "--out", "scene.png"])
    shown = capsys.readouterr().out
    assert all(f"  {name}" in shown for name in broken) and "sound, native: runs it" in shown


@pytest.mark.slow
def test_laws_tell_of_every_fault(installed, capsys):
    law = next(iter(adapters.laws.LAWS)).partition("[")[0]
    for name in installed(FATES):
        # No adapter to judge (2), a law not kept (1), or all well (0): never the adapter's own status.
        assert laws.main([name, "--law", law]) in (0, 1, 2), name
        output = "".join(capsys.readouterr())
        assert name in output or "native  " in output, name
