"""Run an author's code first in a copy of this process, and report it in one sentence if it fails there.

The code may end the process, never return, or leave threads behind.
"""

from __future__ import annotations

import os
import select
import signal
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import IO, Any

from ..errors import BadValue, describe

# Seconds. A case of the catalogue takes milliseconds, the worst formula that is accepted half a minute to derive.
SECONDS = 60.0
# Seconds in which an author's thread has to end after the author's code has returned.
_THREAD_SECONDS = 1.0
# Characters that are quoted of the last line printed before a process ends itself.
_QUOTE_CHARACTERS = 200


def trial(
    what: str,
    make: Callable[[], Any],
    seconds: float | None = None,
    explain: Callable[[BaseException], str] = describe,
) -> None:
    """Call `make` in a forked copy of this process, without a terminal; its result and its output are discarded.

    Raises BadValue in one sentence if it raises (the sentence is `explain(problem)`), ends the process, does not end
    within `seconds` (None: SECONDS), or leaves a thread that would keep the command from ending. Where processes do not
    fork (Windows) nothing is tried.
    """
    seconds = SECONDS if seconds is None else seconds
    if not hasattr(os, "fork"):
        return
    for stream in (sys.stdout, sys.stderr):
        stream.flush()
    with tempfile.TemporaryFile() as output:
        reading, writing = os.pipe()
        child = os.fork()
        if child == 0:
            os.close(reading)
            _child(writing, output, seconds, make, explain)
        os.close(writing)
        try:
            with open(reading, "rb", buffering=0) as pipe:
                answer, late = _answer(pipe, child, time.monotonic() + seconds)
        finally:
            with suppress(ProcessLookupError, PermissionError):  # it may have no process group yet
                os.killpg(child, signal.SIGKILL)
            os.kill(child, signal.SIGKILL)
            code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        if late:
            answer = f"{what} does not end within {seconds:g} s; look for a loop without end in it"
        elif answer is None:
            how = f"signal {signal.Signals(-code).name}" if -code in set(signal.Signals) else f"exit status {code}"
            answer = f"{what} ends the process ({how}) instead of returning a case{_last_line(output)}"
    if answer:
        raise BadValue(answer)


def _child(
    writing: int, output: IO[bytes], seconds: float, make: Callable[[], Any], explain: Callable[[BaseException], str]
) -> None:
    """Run in the copy: write one byte and the sentence to raise, "" for none, and end the process."""
    sentence = "its problem cannot be described"
    try:
        os.setsid()
        signal.signal(signal.SIGTERM, signal.SIG_DFL)  # a command makes it an interruption, which is not for this copy
        signal.alarm(int(seconds) + 10)  # in case the parent has ended
        nothing = os.open(os.devnull, os.O_RDONLY)
        for own, standard in ((nothing, 0), (output.fileno(), 1), (output.fileno(), 2)):
            os.dup2(own, standard)
        sys.stdin = open(nothing, closefd=False)  # input buffered from a terminal is not for the author's code
        sys.stdout = sys.stderr = open(output.fileno(), "w", 1, errors="backslashreplace", closefd=False)
        make()
        sentence = _threads()
    except BaseException as problem:  # the author's code may raise anything
        sentence = explain(problem)
    finally:
        os.write(writing, b"." + sentence.encode("utf-8", "backslashreplace")[:4000])
        os._exit(0)


def _threads() -> str:
    """A sentence if a running thread would keep Python from ending; "" else."""
    for thread in threading.enumerate():
        if thread is not threading.current_thread() and not thread.daemon:
            thread.join(_THREAD_SECONDS)
            if thread.is_alive():
                return f"the case file leaves the thread {thread.name!r} running; end it, or give it daemon=True"
    return ""


def _answer(pipe: IO[bytes], child: int, deadline: float) -> tuple[str | None, bool]:
    """The sentence that the copy wrote, None if it ended without one; and whether the deadline has passed."""
    while time.monotonic() < deadline:
        # A process that the copy left behind may hold the pipe open, so check also whether the copy has ended.
        is_over = os.waitid(os.P_PID, child, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None
        if select.select([pipe], [], [], 0.0 if is_over else 0.05)[0] and (message := pipe.read(5000)):
            return message[1:].decode(), False
        if is_over:
            return None, False
    return None, True


def _last_line(output: IO[bytes]) -> str:
    """The last line of what was printed, to append to a sentence."""
    output.seek(0)
    lines = output.read(2**20).decode(errors="replace").strip().splitlines()
    return f"; it last printed: {lines[-1][-_QUOTE_CHARACTERS:]}" if lines else ""
