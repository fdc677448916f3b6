"""Calls in processes of their own: distinguished, bounded, and nothing left behind."""

import os
import shutil
import subprocess
import sys
import tempfile
import time
from contextlib import nullcontext
from pathlib import Path

import pytest

from adapters.processes import pool as pools

from ..full_disk import full_disk
from .called import (
    ends_itself_at_first,
    group_of_rest,
    grow,
    leave_behind,
    misbehave,
    remove_and_fail,
    remove_folder_above,
    reserve,
    whose,
)

# How a call misbehaves, what becomes of it, and a part of the reason, or of the value.
WAYS = {
    "work": ("done", ""),
    "raise": ("raised", "RuntimeError: two\nlines"),
    "exit": ("raised", "SystemExit: 3"),
    "vanish": ("died", "exit code 7"),
    "segfault": ("died", "SIGSEGV"),
    "hang": ("timed_out", "still running after 2 s"),
    "flood": ("raised", "File too large"),
    "forks": ("done", "forks"),  # and comes back twice: it answers once, and not to the next call
    "garbage": ("died", "wrote no answer into it"),
    "closes": ("died", "exit code 1"),
    "mumbles": ("raised", r"\ud800 \x00 \x1b[31mxxx"),
    "unpicklable": ("raised", "its result cannot be pickled"),
    "last": ("done", "last"),
}


def run(function, calls, jobs=1, limit=60.0, **how) -> list[tuple[int, pools.CallResult]]:
    """What the workers of a pool answer."""
    pool = pools.WorkerPool(jobs)
    try:
        return list(pool.run(function, calls, limit, **how))
    finally:
        pool.close()


@pytest.fixture(scope="module")
def answers() -> dict[str, pools.CallResult]:
    # Two seconds are long for every way that ends by itself, and short to wait for the one that does not.
    calls = [(way,) for way in WAYS]
    return {[*WAYS][index]: answer for index, answer in run(misbehave, calls, jobs=2, limit=2.0)}


@pytest.mark.parametrize("way", WAYS)
def test_every_call_is_answered_whatever_the_others_do(answers, way):
    outcome, part = WAYS[way]
    answer = answers[way]
    assert answer.outcome == outcome and part in (str(answer.value) if outcome == "done" else answer.reason)
    # It fits in every file.
    assert len(answer.reason) < 3000
    assert way == "raise" or answer.reason.encode() is not None and answer.reason.isprintable()


def test_a_call_works_in_an_empty_folder_that_is_gone_afterwards_and_its_output_is_captured(answers):
    folder, files = answers["work"].value
    assert files in ([], ["output.txt"]) and not Path(folder).exists() and folder != os.getcwd()
    assert answers["work"].output == "said something"


def test_address_space_is_not_bounded():
    """A WebAssembly engine reserves 24 GB and uses little."""
    ((_, answer),) = run(reserve, [(24,)])
    assert answer.value == 24 * 2**30, answer


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere a process that leaves its group is not found")
@pytest.mark.parametrize(
    "then", ["return", "hang", *(pytest.param(t, marks=pytest.mark.slow) for t in ("segfault", "vanish"))]
)
def test_a_process_with_a_session_of_its_own_ends_with_the_call_that_left_it(then, tmp_path, monkeypatch):
    monkeypatch.setenv("LEFT_BEHIND", str(tmp_path))
    pool = pools.WorkerPool(1)
    try:
        ((_, answer),) = pool.run(leave_behind, [(then,)], limit=2.0)
        assert answer.outcome == {"return": "done", "hang": "timed_out"}.get(then, "died")
        left = Path("/proc") / (tmp_path / then).read_text()
        # The pool itself lives on: what is ended is ended with the call.
        wait_until(lambda: not left.exists() or "(zombie)" in (left / "status").read_text())
    finally:
        pool.close()


def test_calls_of_unlike_groups_never_share_a_worker():
    calls = [("a", n) for n in range(6)]
    outcome_text = {i: answer.value for i, answer in run(whose, calls, jobs=2, groups=["", "engines"] * 3)}
    assert {outcome_text[0], outcome_text[2], outcome_text[4]}.isdisjoint(
        {outcome_text[1], outcome_text[3], outcome_text[5]}
    )


@pytest.mark.parametrize(("times", "outcome"), [(1, "done"), (2, "died")])
def test_a_call_whose_worker_is_ended_from_outside_is_made_once_more(times, outcome, tmp_path):
    ((_, answer),) = run(ends_itself_at_first, [(tmp_path, times)])
    assert answer.outcome == outcome and len(list(tmp_path.iterdir())) == times
    assert answer.lasting == (outcome == "done")


def test_an_engine_that_removes_its_folders_removes_no_other_calls():
    calls = run(remove_folder_above, [(), ()], groups=["box2d", "box2d"]) + run(misbehave, [("work",)])
    assert [answer.outcome for _, answer in calls] == ["done"] * 3


@pytest.mark.parametrize("fault", ["gone", "full", "gone in a call"])
def test_a_fault_of_the_folder_for_temporary_files_is_no_answer(fault, tmp_path, monkeypatch):
    """It ends the command with one line; a failure that is an answer would be stored, and shown by the next report."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "folder"))
    (tmp_path / "folder").mkdir()
    pool = pools.WorkerPool(1)
    try:
        if fault == "gone":
            shutil.rmtree(tmp_path / "folder")
        with full_disk() if fault == "full" else nullcontext(), pytest.raises(OSError, match="TMPDIR"):
            list(
                pool.run(remove_and_fail, [(tmp_path / "folder",)])
                if "call" in fault
                else pool.run(misbehave, [("work",)])
            )
    finally:
        pool.close()


def test_the_rest_of_a_call_is_made_where_no_engine_has_run():
    """Its failure is the call's; what is skipped is asked before a call begins, once."""
    indices: list[int] = []
    arguments = [("work",), ("raise",), ("vanish",), ("work",)]
    calls = run(group_of_rest, arguments, groups=["pymunk"] * 4, skip=indices.append)
    assert sorted(indices) == [0, 1, 2, 3]
    assert [answer.value for _, answer in sorted(calls)][::3] == ["", ""]
    assert [answer.outcome for _, answer in sorted(calls)] == ["done", "raised", "died", "done"]


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere a worker ends with its own time")
def test_a_worker_ends_with_the_process_that_asked_it(tmp_path):
    asked = f"list(WorkerPool(1).run(linger, [(Path({str(tmp_path)!r}),)]))"
    asking = f"from adapters.processes.pool import WorkerPool; from tests.reports.called import *; {asked}"
    parent = subprocess.Popen([sys.executable, "-c", asking], cwd=Path(__file__).parents[2])
    wait_until(lambda: (tmp_path / "pid").exists() and (tmp_path / "pid").read_text())
    worker = Path("/proc") / (tmp_path / "pid").read_text()
    assert worker.exists()
    left = Path((tmp_path / "cwd").read_text()).parent
    parent.kill()
    parent.wait()
    wait_until(lambda: has_ended(worker))
    assert left.exists()
    pools.WorkerPool(1).close()
    assert not left.exists(), "the next one sweeps what a killed one left"


def has_ended(process: Path) -> bool:
    """Whether a process of /proc has ended; one that nobody has waited for yet stands in the list as a zombie."""
    try:
        return "(zombie)" in (process / "status").read_text()
    except (FileNotFoundError, ProcessLookupError):  # it may go between opening and reading
        return True


def wait_until(holds) -> None:
    deadline = time.monotonic() + 60.0
    while not holds():
        assert time.monotonic() < deadline
        time.sleep(0.02)


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="the system does not report a process's memory")
def test_a_worker_that_has_grown_is_replaced():
    first, second, third = (answer.value for _, answer in run(grow, [(1,), (400,), (2,)]))
    assert first == second != third
