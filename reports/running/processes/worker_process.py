"""A worker's own side: it takes calls from a pipe and answers them, each in an empty folder, its output captured.

What a call leaves changed in its process would change later answers: then the process tells so, and is replaced.
"""

from __future__ import annotations

import gc
import importlib
import os
import resource
import shutil
import signal
import sys
import tempfile
import threading
import warnings
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache
from multiprocessing.connection import Connection
from pathlib import Path
from pickle import dumps
from typing import Any

import numpy as np

from adapters.common import supervision
from cases import compile_cache

from ..records import legible
from ..third_party import LIMITS

# An engine that writes more than this to one file is flooding; the largest honest log of one run is a few megabytes.
_FILE_BYTES = 32 * 2**20
# Resident memory of a worker and what it starts: far above what a plane body needs, far below what a machine has.
# Address space is not bounded: WebAssembly engines reserve 10 to 24 GB of it and use little.
MEMORY_BYTES = 3 * 2**30
# A worker grows by what it compiles and keeps for later cases. Two that have grown by so much since their first call,
# and the process that asks them, stay well below a gigabyte; a fresh one costs a second or two.
_GROWTH_BYTES = 150 * 2**20
# What is kept of a call's output: enough for the last error message of an engine.
_OUTPUT_CHARACTERS = 2000
# What a worker says when it begins with a call; its time runs from then.
BEGUN = "begun"
# The engines whose code may run in this process (`solvers.groups_of`): "" for none, None if it is no worker.
group: str | None = None
# Half a unit in the last place, and the least number there is: what becomes of them tells how this process rounds.
_HALVES = (1.0, -1.0, 2.0**-53, 2.0**-54, 5e-324)


@dataclass(frozen=True)
class CallResult:
    """What came of a call: `outcome` is "done" (then `value` holds), "raised", "died" or "timed_out"; `reason` is one
    sentence for the last three; `output` is the end of what the call printed; `lasting` is whether the call itself
    brought it about, so that it would come out the same again; `when` it was made, if that is noted."""

    outcome: str
    value: Any = None
    reason: str = ""
    output: str = ""
    lasting: bool = True
    when: str = ""

    @property
    def failure(self) -> tuple[str, str]:
        """Outcome and reason of the row that stands for a call that did not return."""
        outcome = "timed_out" if self.outcome == "timed_out" else "crashed"
        return outcome, f"{self.reason}; it last printed: {self.output[-200:]}" if self.output else self.reason


def serve(pipe: Connection, scratch: str, parent: int, engines: str, known_run: bool, ahead: str = "") -> None:
    """Take a call, answer it under its number, until the pipe is closed. `engines`: the group whose calls are made
    here; `known_run`: whether one is made after each call of an engine; `ahead`: a module to import before the first
    call."""
    global group
    group = engines
    os.setsid()
    supervision.end_with_parent(parent, by=signal.SIGTERM)
    supervision.supervise(MEMORY_BYTES, first=pipe.close)
    hard = resource.getrlimit(resource.RLIMIT_FSIZE)[1]
    most = _FILE_BYTES if hard == resource.RLIM_INFINITY else min(_FILE_BYTES, hard)
    resource.setrlimit(resource.RLIMIT_FSIZE, (most, hard))
    if ahead:
        importlib.import_module(ahead)
    at_first, canary = None, None
    while True:
        try:
            number, function, args, limit = pipe.recv()
        except (EOFError, OSError):
            return
        if group and canary is None:
            # Made before the first call, when the call's modules have been imported, and no adapter.
            from ..canary import Canary

            canary = Canary(known_run)
        at_first = at_first or _resident()
        pipe.send_bytes(dumps((number, BEGUN)))
        # The system's own alarm ends the process even if the parent is gone and the engine holds the interpreter.
        signal.alarm(int(limit) + 10)
        before, needed = _numerics(), _needed()
        folder = Path(tempfile.mkdtemp(dir=scratch))
        with compile_cache.withheld() as write:
            answer = _call(function, args, folder)
            change = canary.change() if canary else ""
            if change:
                answer = CallResult(
                    "raised", reason=f"it left its process changed, so its result is not used: {change}"
                )
            else:
                write()
        signal.alarm(0)
        spent = (
            bool(change)
            or _resident() - at_first > _GROWTH_BYTES
            or _numerics() != before
            or not needed <= _needed()
            or _has_leftovers()
        )
        try:
            told = dumps((number, answer, spent, compile_cache.counters()))
        except Exception as problem:  # whatever a solver's own object does when it is asked for its content
            answer = CallResult("raised", reason=legible(f"what it returned cannot travel: {problem}"))
            told = dumps((number, answer, spent, compile_cache.counters()))
        pipe.send_bytes(told)


def _numerics() -> tuple[float, ...]:
    """What arithmetic does here with halves of a unit in the last place and with the least numbers."""
    one, minus, half, quarter, least = _HALVES
    return one + half, minus - half, one - quarter, least * one


def _needed() -> set[tuple[str, Any]]:
    """What later calls need of their process and an engine may take away: where modules are found, standard streams,
    and hard limits, which cannot be raised again. What it adds is no harm."""
    return {
        *(("path", place) for place in sys.path),
        *(("finder", id(each)) for each in (*sys.path_hooks, *sys.meta_path)),
        *(("stream", number) for number in (0, 1, 2) if _is_open(number)),
        *(
            ("stream", name)
            for name in ("stdin", "stdout", "stderr")
            if not getattr(getattr(sys, name, None), "closed", True)
        ),
        *((f"limit {limit}", resource.getrlimit(limit)[1]) for limit in LIMITS),
    }


def _is_open(number: int) -> bool:
    try:
        os.fstat(number)
    except OSError:
        return False
    return True


def _has_leftovers() -> bool:
    """Whether something that the call started goes on."""
    return threading.active_count() > 1 or reap()


@lru_cache(maxsize=64)
def settle(what: str) -> None:
    """Once for each thing (`what`) that a process has imported for calls to come: it stays. To look through it again
    and again for garbage takes a twentieth of a run's time, and a sixth of a figure's. Not for what is timed."""
    gc.freeze()


def reap() -> bool:
    """Let processes that engines started and that have ended be gone; whether others still run. A copy that an engine
    makes of its process in each of thousands of runs would else stay in the system's table until the last."""
    try:
        while os.waitpid(-1, os.WNOHANG)[0]:
            pass
    except ChildProcessError:
        return False
    return True


def _resident() -> int:
    """Bytes of memory this process holds; 0 where the system does not tell (it is then never too much)."""
    try:
        return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except (OSError, ValueError, IndexError):
        return 0


def _call(function: Callable, args: tuple, folder: Path) -> CallResult:
    home, own = os.getcwd(), os.getpid()
    os.chdir(folder)
    try:
        with _Captured(folder / "output.txt") as output:
            try:
                with warnings.catch_warnings(), np.errstate():  # what an engine asks of them is its own
                    answer = CallResult("done", value=function(*args))
            except BaseException as problem:  # SystemExit too: an engine may try to leave
                answer = CallResult("raised", reason=legible(f"{type(problem).__name__}: {_text(problem)}".strip()))
            if os.getpid() != own:
                os._exit(0)  # an engine's copy of this process came back as well: it has nothing to say
        return replace(answer, output=output.text)
    finally:
        os.chdir(home)
        shutil.rmtree(folder, ignore_errors=True)


def _text(problem: BaseException) -> str:
    try:
        return str(problem)
    except Exception:
        return "(it cannot say why)"


class _Captured:
    """Standard output and error of this process, C code's included, into a file while the block runs."""

    def __init__(self, path: Path):
        self.path, self.text = path, ""

    def __enter__(self) -> _Captured:
        self._file = open(self.path, "w+b")
        self._streams = sys.stdout, sys.stderr
        self._saved = [os.dup(1), os.dup(2)]
        for stream in (1, 2):
            os.dup2(self._file.fileno(), stream)
        return self

    def __exit__(self, *_):
        for python_stream in (sys.stdout, sys.stderr, *self._streams):
            with suppress(Exception):  # the file is full or closed: what is lost is output nobody asked for
                python_stream.flush()
        sys.stdout, sys.stderr = self._streams
        for stream, saved in zip((1, 2), self._saved, strict=True):
            with suppress(OSError):  # the engine closed one, or allows no more open files: the worker ends after it
                os.dup2(saved, stream)
                os.close(saved)
        with suppress(OSError), self._file:
            self._file.seek(0, os.SEEK_END)
            self._file.seek(max(0, self._file.tell() - 4 * _OUTPUT_CHARACTERS))
            self.text = legible(self._file.read().decode(errors="replace")[-_OUTPUT_CHARACTERS:].strip())
