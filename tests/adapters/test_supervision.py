"""What an engine starts ends with it, and its resident memory is bounded; shared pages count once."""

import signal
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

from adapters.common import supervision

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="elsewhere memory is not bounded")
BEGIN = """\
import mmap, os, signal, sys, time
sys.path.append("adapters/common")  # by itself: importing the suite takes a second
from supervision import end_with_parent, supervise
end_with_parent(os.getppid(), by=signal.SIGTERM)
supervise({memory} * 2**20)
"""


def started(code: str, memory: int) -> subprocess.Popen:
    """A process that is supervised, with so many MB, and then runs the code."""
    words = [sys.executable, "-c", BEGIN.format(memory=memory) + textwrap.dedent(code)]
    return subprocess.Popen(words, cwd=ROOT, stdout=subprocess.PIPE, text=True)


def supervised(code: str, memory: int = 1000) -> int:
    """How it ends."""
    with started(code, memory) as process:
        return process.wait(60)


def gone(process: int) -> bool:
    status = Path("/proc") / str(process) / "status"
    return not status.exists() or "(zombie)" in status.read_text()


@pytest.mark.parametrize(
    ("code", "ended"),
    [("sys.exit(7)", 7), ("pass", 0), ("os.kill(os.getpid(), 9)", -9), ("os.abort()", -signal.SIGABRT)],
)
def test_a_supervisor_ends_as_what_it_supervises(code, ended):
    assert supervised(code) == ended


def test_memory_that_is_used_is_bounded_and_memory_that_is_reserved_is_not():
    reserve = "space = mmap.mmap(-1, 2**35, mmap.MAP_PRIVATE | 0x4000)\ntime.sleep(1.5)"  # MAP_NORESERVE
    assert supervised(reserve, memory=300) == 0
    use = "held = b'x' * (600 * 2**20)\ntime.sleep(60)"
    assert supervised(use, memory=300) == -supervision.TOO_MUCH_MEMORY


CHILDREN = """
    held = b"x" * (150 * 2**20)
    for _ in range(4):
        if os.fork() == 0:
            {own}
            time.sleep(2.5)
            os._exit(0)
    time.sleep(3.0)
    """


@pytest.mark.slow
def test_the_memory_of_what_it_starts_counts_and_shared_pages_count_once():
    assert supervised(CHILDREN.format(own="pass"), memory=450) == 0
    assert supervised(CHILDREN.format(own='own = b"y" * len(held)'), memory=450) == -supervision.TOO_MUCH_MEMORY


DAEMON = """
    if os.fork() == 0:
        os.setsid()
        if os.fork() == 0:
            print(os.getpid(), flush=True)
            os.close(1)
            time.sleep(600)
        os._exit(0)
    time.sleep(0.5)
    {then}
    """


@pytest.mark.parametrize("then", ["sys.exit()", "os.kill(os.getpid(), 9)", "time.sleep(600)"])
def test_what_opens_a_session_of_its_own_ends_too(then):
    with started(DAEMON.format(then=then), memory=1000) as process:
        daemon = int(process.stdout.readline())
        assert not gone(daemon)
        if "600" in then:
            process.terminate()
        process.wait(60)
        assert gone(daemon)
