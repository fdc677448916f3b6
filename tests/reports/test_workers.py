"""Calls in processes of their own: told apart, bounded, and nothing left behind."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from reports.running import experiment, workers


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


def run(function, calls, jobs=1, limit=60.0, **how) -> list[tuple[int, workers.Answer]]:
    """What the workers of a pool answer."""
    pool = workers.Pool(jobs)
    try:
        return list(pool.run(function, calls, limit, **how))
    finally:
        pool.close()


@pytest.fixture(scope="module")
def answers() -> dict[str, workers.Answer]:
    # Two seconds are long for every way that ends by itself, and short to wait for the one that does not.
    calls = [(way,) for way in WAYS]
    return {WAYS[index]: answer for index, answer in run(misbehave, calls, jobs=2, limit=2.0)}


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
        ("hang", "timed_out", "still running after 2 s"),
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
    calls = run(misbehave, [("exit",), ("exit",)], skip=lambda index: given)
    assert calls == [(0, given), (1, given)]


def linger(folder: Path) -> None:
    """Tell where it runs, and stay."""
    (folder / "pid").write_text(str(os.getpid()))
    time.sleep(600.0)


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere a worker ends with its own time")
def test_a_worker_ends_with_the_process_that_asked_it(tmp_path):
    asking = f"from tests.reports.test_workers import *; list(run(linger, [(Path({str(tmp_path)!r}),)]))"
    parent = subprocess.Popen([sys.executable, "-c", asking], cwd=Path(__file__).parents[2])
    wait_until(lambda: (tmp_path / "pid").exists() and (tmp_path / "pid").read_text())
    worker = Path("/proc") / (tmp_path / "pid").read_text()
    assert worker.exists()
    parent.kill()
    parent.wait()
    # An ended process nobody has waited for yet stands in the list as a zombie.
    wait_until(lambda: not worker.exists() or "(zombie)" in (worker / "status").read_text())


def wait_until(holds) -> None:
    deadline = time.monotonic() + 60.0
    while not holds():
        assert time.monotonic() < deadline
        time.sleep(0.02)


def whose(thing, number):
    time.sleep(0.3)
    return os.getpid()


def grow(megabytes: int) -> int:
    """Keep so much memory, as a cache would; the process it is kept in."""
    kept.append(b"x" * (megabytes * 2**20))
    return os.getpid()


kept: list[bytes] = []


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="the system does not tell a process's memory")
def test_a_worker_that_has_grown_is_replaced():
    first, second, third = (answer.value for _, answer in run(grow, [(1,), (300,), (2,)]))
    assert first == second != third


def test_calls_on_one_thing_go_to_one_worker_and_nobody_is_left_idle():
    calls = [("a", 1), ("a", 2), ("b", 1), ("a", 3), ("b", 2), ("b", 3)]
    told = {calls[i]: answer.value for i, answer in run(whose, calls, jobs=2)}
    assert len({told["a", n] for n in (1, 2, 3)} | {told["b", n] for n in (1, 2, 3)}) == 2
    assert len({told["a", n] for n in (1, 2)}) == len({told["b", n] for n in (1, 2)}) == 1
    alone = [answer.value for _, answer in run(whose, [("a", n) for n in range(6)], jobs=2)]
    assert len(set(alone)) == 2


def test_rungs_finer_than_one_that_ran_out_of_time_are_not_tried():
    ladder = [("c", "s", "r", f"h={h}", i, None) for i, h in enumerate((1, 2, 3))]
    elsewhere = ("c", "s", "q", "h=1", 0, None)
    slow = [ladder[1]]
    assert experiment.hopeless(ladder[0], slow) is None and experiment.hopeless(elsewhere, slow) is None
    told = experiment.hopeless(ladder[2], slow)
    assert told is not None and told.outcome == "timed_out" and "h=2 had run out of time" in told.reason
    assert not told.lasting
