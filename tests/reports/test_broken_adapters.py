"""An adapter that crashes the process, hangs or prints, wherever in it: a row of its own, and the rest is whole."""

import os
import sys

import pytest

import cases
from reports import build, studies
from reports.running import experiment
from reports.running.calls import Calls
from reports.studies.error_parts import measure as error_parts
from reports.studies.stability import measure as stability

from .. import fake_adapter

PARTS = ("import", "version", "refuses", "ladder", "build", "run", "read")
WAYS = ("segfault", "hang", "prints")
OUTCOMES = {"segfault": "crashed", "hang": "timed_out", "prints": "answered"}


@pytest.fixture
def broken(tmp_path, monkeypatch):
    """broken((part, way), …) -> names of copies of the fake engine that fail so, after one that is sound."""
    # A worker needs a second or two to import what an adapter imports: that is no hang.
    monkeypatch.setattr(experiment, "ASKING_SECONDS", 6.0)
    for module, limit in ((stability, "_LIMIT"), (error_parts, "LIMIT_SECONDS")):
        monkeypatch.setattr(module, limit, 6.0)
    monkeypatch.syspath_prepend(tmp_path)

    def install(*faults):
        fake_adapter.install(tmp_path, ["wait 0"], name="sound")
        for part, way in faults:
            fake_adapter.install(tmp_path, ["wait 0"], name=f"{part}_{way}")
            fake_adapter.break_down(tmp_path, f"{part}_{way}", part, way)
        return ("sound", *(f"{part}_{way}" for part, way in faults))

    yield install
    callers = {int(line) for line in (tmp_path / "callers.txt").read_text().split()}
    assert callers and os.getpid() not in callers, "an adapter was called in the parent process"
    assert not any("adapter_of_tests" in name for name in sys.modules)


def expected(name: str, at_version: str = "answered") -> str:
    part, _, way = name.partition("_")
    return at_version if part in ("sound", "version") else OUTCOMES[way]


def check_runs(names, capfd):
    with Calls(2, limit=6.0) as calls:
        found = experiment.run_cases((cases.load(fake_adapter.CASE),), names, calls)
    # A version that cannot be had only keeps what was run from being kept.
    assert {run.solver: run.outcome for run in found.runs} == {name: expected(name) for name in names}
    assert all(run.reason for run in found.runs if run.outcome != "answered")
    assert "all is well" not in "".join(capfd.readouterr())


@pytest.mark.slow  # test_any_fault has a fault of each kind in the quick tests
def test_a_fault_in_any_part_is_a_row(broken, capfd):
    check_runs(broken(("version", "segfault"), ("ladder", "segfault"), ("build", "prints")), capfd)


@pytest.mark.slow
def test_every_fault_in_every_part_is_a_row(broken, capfd):
    check_runs(broken(*((part, way) for part in PARTS for way in WAYS)), capfd)


# The parts of an adapter that a study of runs calls, and those that others do.
OF_RUNS = {"import", "refuses", "ladder", "build", "run", "read"}
CALLED = {"error_parts": OF_RUNS - {"ladder"} | {"grid"}}


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in studies.names() if "solver" in studies.study(name).TAKES])
def test_every_fault_is_a_row_of_every_study(name, broken, capfd):
    names = broken(*((part, way) for part in (*PARTS, "grid") for way in WAYS))
    with Calls(2, limit=6.0) as calls:
        calls.ask_versions(names)
        chosen = (cases.load(fake_adapter.CASE),) if "case" in studies.study(name).TAKES else ()
        result = studies.run_study(name, studies.Request(chosen, names), calls, "")
    assert result.failure == ""
    frame = result.frames[name]
    for solver in names:
        outcomes = set(frame[frame["solver"] == solver]["outcome"])
        part, _, way = solver.partition("_")
        fails = part in CALLED.get(name, OF_RUNS) and way != "prints"
        assert outcomes == {OUTCOMES[way]} if fails else outcomes and outcomes <= {"answered", "done"}, (
            solver,
            outcomes,
        )
    assert "all is well" not in "".join(capfd.readouterr())


@pytest.mark.slow
def test_commands_that_only_ask_get_through(broken, capsys, tmp_path, monkeypatch):
    from reports import show

    monkeypatch.chdir(tmp_path)
    names = broken(("import", "segfault"), ("refuses", "segfault"), ("ladder", "prints"))
    assert build.main(["--list"]) == 0
    listed = capsys.readouterr().out
    assert all(f"  {name}: native" in listed for name in names)
    show.run([fake_adapter.CASE, "--out", "scene.png"])
    shown = capsys.readouterr().out
    assert shown.count("SIGSEGV") == 2 and "sound, native: runs it" in shown
