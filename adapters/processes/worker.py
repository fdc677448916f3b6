"""The worker process: it reads calls from a pipe and answers them, each in an empty folder with its output captured.

A call that leaves its process changed could change later answers: the process then reports it and is replaced.
"""

from __future__ import annotations

import gc
import importlib
import os
import resource
import select
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
from pickle import dumps, loads
from typing import Any

import numpy as np

from cases.errors import legible

from ..common import supervision

# Size limit of a file that an engine writes, in bytes; the largest normal log of one run has a few megabytes.
_FILE_BYTES = 32 * 2**20
# Limit of the resident memory of a worker and its child processes, in bytes: far above the need of a plane body, far
# below a machine's memory. Address space is not bounded: WebAssembly engines reserve 10 to 24 GB of it and use little.
MEMORY_BYTES = 3 * 2**30
# A worker that has grown by more than this since its first call (by compiled code) is replaced. Imports of engines and
# of SciPy's integrators take 110 MB of it, the first run of each 40 MB. A new worker costs one or two seconds; two of
# this size and the main process take less than 1.5 GB.
_GROWTH_BYTES = 300 * 2**20
# Characters kept of a call's output: enough for the last error message of an engine.
_OUTPUT_CHARACTERS = 2000
# A worker sends this when it starts a call; the time limit runs from then.
START_MESSAGE = "begun"
# The group of the engines whose code may run in this process: "" for none, None in a process that is no worker.
group: str | None = None
# The folder of the pool that this worker belongs to; None in other processes.
pool_folder: Path | None = None
_LIMITS = [getattr(resource, name) for name in dir(resource) if name.startswith("RLIMIT_")]


@dataclass(frozen=True)
class CallResult:
    """The result of a call.

    `outcome`: "done" (then `value` is valid), "raised", "died", "timed_out", or "lost" if the worker could not make it
    (a pool makes it again); `reason`: one sentence for the last four; `output`: the end of what the call printed;
    `lasting`: whether the call itself caused the outcome, so that it would occur again; `when`: the time of the call,
    or ""."""

    outcome: str
    value: Any = None
    reason: str = ""
    output: str = ""
    lasting: bool = True
    when: str = ""

    @property
    def failure(self) -> tuple[str, str]:
        """Outcome and reason in the row of a call that did not return."""
        outcome = "timed_out" if self.outcome == "timed_out" else "crashed"
        return outcome, f"{self.reason}; it last printed: {self.output[-200:]}" if self.output else self.reason


@dataclass(frozen=True)
class NextCall:
    """The rest of a call, which its pool makes in a process without engines; the answer is that of the rest."""

    function: Callable
    arguments: tuple


def without_engines(function: Callable, *arguments: Any) -> Any:
    """`function(*arguments)` as a call's value, computed where no engine's code has run; at once outside workers."""
    return NextCall(function, arguments) if group else function(*arguments)


def at_once(value: Any) -> Any:
    """A call's value with its rest made in this process, too, where a call of many runs cannot wait for others."""
    return value.function(*value.arguments) if isinstance(value, NextCall) else value


def call_in_copy(function: Callable, argument: Any, limit: float) -> CallResult:
    """The result of a call in a copy of this process, which has what this one has imported, within `limit` seconds."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reading)
        try:
            signal.alarm(int(limit) + 1)
            message = dumps(CallResult("done", function(argument)))
        except BaseException as problem:  # the copy must end here and report any failure
            message = dumps(CallResult("raised", reason=f"{type(problem).__name__}: {problem}"))
        with os.fdopen(writing, "wb") as pipe:
            pipe.write(message)
        os._exit(0)
    os.close(writing)
    with os.fdopen(reading, "rb") as pipe:
        message = pipe.read() if select.select([pipe], [], [], limit)[0] else b""
    if not message:
        os.kill(child, signal.SIGKILL)
    _, status = os.waitpid(child, 0)
    ended = f"its process ended, or took more than {limit:g} s ({status})"
    return loads(message) if message else CallResult("died", reason=ended)


def serve(pipe: Connection, scratch: str, parent: int, engines: str, preload: str = "") -> None:
    """Receive calls and send each answer with the call's number, until the pipe is closed.

    `scratch`: the worker's folder, inside the pool's; temporary files of engines and their processes go there, too.
    `engines`: the worker group; `preload`: a module to import before the first call."""
    global group, pool_folder
    group, pool_folder = engines, Path(scratch).parent
    tempfile.tempdir = os.environ["TMPDIR"] = scratch
    os.setsid()
    supervision.end_with_parent(parent, by=signal.SIGTERM)
    supervision.supervise(MEMORY_BYTES, first=pipe.close)
    hard = resource.getrlimit(resource.RLIMIT_FSIZE)[1]
    most = _FILE_BYTES if hard == resource.RLIM_INFINITY else min(_FILE_BYTES, hard)
    resource.setrlimit(resource.RLIMIT_FSIZE, (most, hard))
    if preload:
        importlib.import_module(preload)
    at_first = None
    while True:
        try:
            number, function, args, limit = pipe.recv()
        except (EOFError, OSError):
            return
        at_first = at_first or _resident()
        pipe.send_bytes(dumps((number, START_MESSAGE)))
        # The system's alarm ends the process even if the parent is gone and the engine blocks the interpreter.
        signal.alarm(int(limit) + 10)
        state = _required_state()
        try:
            answer = _call(function, args, Path(tempfile.mkdtemp(dir=scratch)))
        except OSError as problem:
            answer = CallResult("lost", reason=legible(f"its folder cannot be used: {problem}"))
        signal.alarm(0)
        retire = (
            _resident() - at_first > _GROWTH_BYTES
            or not state <= _required_state()
            or _has_leftovers()
            or answer.outcome == "lost"
        )
        try:
            message = dumps((number, answer, retire))
        except Exception as problem:  # a solver's object can raise anything when it is pickled
            answer = CallResult("raised", reason=legible(f"its result cannot be pickled: {problem}"))
            message = dumps((number, answer, retire))
        pipe.send_bytes(message)


def _required_state() -> set[tuple[str, Any]]:
    """The state that later calls need and an engine may remove; additions are allowed.

    It consists of the module search path, standard streams and hard limits, which cannot be raised again."""
    return {
        *(("path", place) for place in sys.path),
        *(("finder", id(each)) for each in (*sys.path_hooks, *sys.meta_path)),
        *(("stream", number) for number in (0, 1, 2) if _is_open(number)),
        *(
            ("stream", name)
            for name in ("stdin", "stdout", "stderr")
            if not getattr(getattr(sys, name, None), "closed", True)
        ),
        *((f"limit {limit}", resource.getrlimit(limit)[1]) for limit in _LIMITS),
    }


def _is_open(number: int) -> bool:
    try:
        os.fstat(number)
    except OSError:
        return False
    return True


def _has_leftovers() -> bool:
    """Whether a thread or process that the call started still runs."""
    return threading.active_count() > 1 or reap()


@lru_cache(maxsize=64)
def settle(what: str) -> None:
    """Exclude all present objects from garbage collection; has an effect at the first call for each `what`.

    Imports for later calls stay in memory anyway, and to search them for garbage takes a twentieth of a run's time and
    a sixth of a figure's. Not used in timed runs."""
    gc.freeze()


def reap() -> bool:
    """Reap ended child processes; returns whether other child processes still run.

    An engine that forks in each of thousands of runs would otherwise fill the system's process table."""
    try:
        while os.waitpid(-1, os.WNOHANG)[0]:
            pass
    except ChildProcessError:
        return False
    return True


def _resident() -> int:
    """Resident memory of this process in bytes; 0 if the system does not report it (then no limit applies)."""
    try:
        return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except (OSError, ValueError, IndexError):
        return 0


def _call(function: Callable, args: tuple, folder: Path) -> CallResult:
    home, own = os.getcwd(), os.getpid()
    os.chdir(folder)
    try:
        with _OutputCapture(folder / "output.txt") as output:
            try:
                with warnings.catch_warnings(), np.errstate():  # so that an engine's settings end with its call
                    answer = CallResult("done", value=function(*args))
            except BaseException as problem:  # SystemExit too: an engine may try to exit
                answer = CallResult("raised", reason=legible(f"{type(problem).__name__}: {_text(problem)}".strip()))
            if os.getpid() != own:
                os._exit(0)  # a forked child returned here
        return replace(answer, output=output.text)
    finally:
        os.chdir(home)
        shutil.rmtree(folder, ignore_errors=True)


def _text(problem: BaseException) -> str:
    try:
        return str(problem)
    except Exception:
        return "(no message)"


class _OutputCapture:
    """Redirects standard output and error of this process, including C code, to a file while the block runs."""

    def __init__(self, path: Path):
        self.path, self.text = path, ""

    def __enter__(self) -> _OutputCapture:
        self._file = open(self.path, "w+b")
        self._streams = sys.stdout, sys.stderr
        self._copies = [os.dup(1), os.dup(2)]
        for stream in (1, 2):
            os.dup2(self._file.fileno(), stream)
        return self

    def __exit__(self, *_):
        for python_stream in (sys.stdout, sys.stderr, *self._streams):
            with suppress(Exception):  # the file is full or closed: only captured output is lost
                python_stream.flush()
        sys.stdout, sys.stderr = self._streams
        for stream, copy in zip((1, 2), self._copies, strict=True):
            with suppress(OSError):  # the engine closed one, or no more files may be opened: the worker then ends
                os.dup2(copy, stream)
                os.close(copy)
        with suppress(OSError), self._file:
            self._file.seek(0, os.SEEK_END)
            self._file.seek(max(0, self._file.tell() - 4 * _OUTPUT_CHARACTERS))
            self.text = legible(self._file.read().decode(errors="replace")[-_OUTPUT_CHARACTERS:].strip())
