"""Calls in processes of their own: a crash, a hang or a flood of output ends a worker and nothing else.

Every call gets an empty scratch directory to work in, has its output captured, and is killed with everything it
started when its time is over; the next call finds a fresh worker. POSIX only.
"""

from __future__ import annotations

import itertools
import multiprocessing
import os
import pickle
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from pathlib import Path
from types import ModuleType
from typing import Any

from cases import kept

# An engine that writes more than this to one file is flooding; the largest honest log of one run is a few megabytes.
_FILE_BYTES = 32 * 2**20
# Far above what a plane body needs (compiling in quadruple precision takes a gigabyte and a half of addresses), far
# below what would bring the machine to its knees.
_MEMORY_BYTES = 3 * 2**30
# A worker grows by what it compiles and keeps for later cases. Two that have grown by so much since their first call,
# and the process that asks them, stay well below a gigabyte; a fresh one costs a second or two.
_GROWTH_BYTES = 150 * 2**20
# What is kept of a call's output: enough for the last error message of an engine.
_OUTPUT_CHARACTERS = 2000
# A fresh process may take this long, on a busy machine, to come to its first call; that is not the call's fault.
_STARTUP_SECONDS = 60.0
# What a worker says when it begins with a call; its time runs from then.
_BEGUN = "begun"
# Signals a process brings on itself; any other came from outside (a user, the system when memory ran out).
_OWN_FAULTS = {signal.SIGSEGV, signal.SIGABRT, signal.SIGFPE, signal.SIGILL, signal.SIGBUS, signal.SIGSYS}
# One thread to a worker: runs beside each other must not fight for cores, and CPU time must mean one core's time.
_ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


@dataclass(frozen=True)
class Answer:
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


class Pool:
    """Workers that make calls, `jobs` at a time. Closed, they are killed and their scratch directories gone."""

    def __init__(self, jobs: int):
        self._jobs = jobs
        self._scratch = Path(tempfile.mkdtemp(prefix="slip-to-roll-"))
        self._workers: list[_Worker] = []

    def close(self) -> None:
        """End the workers."""
        for worker in self._workers:
            worker.kill()
        shutil.rmtree(self._scratch, ignore_errors=True)

    def run(
        self,
        function: Callable,
        arguments: Sequence[tuple],
        limit: float = 60.0,
        skip: Callable[[int], Answer | None] = lambda index: None,
    ) -> Generator[tuple[int, Answer]]:
        """Call `function(*arguments[i])` for every i, each for at most `limit` seconds of wall time.

        Calls with the same first argument begin in order, by one worker where that leaves nobody idle: what it
        compiled for a case serves all of the case's runs. Yields (i, answer) as they end; `skip(i)`, called
        just before call i would begin, may give an answer in its place. The function and its arguments travel by
        pickle, so the function lives at the top of a module. Calls that are still running when the iterator
        ends are killed.
        """
        waiting = dict(enumerate(arguments))
        try:
            while waiting or self._busy():
                while waiting and len(self._busy()) < self._jobs:
                    worker = self._idle()
                    index = worker.next_of(waiting, [other.subject for other in self._busy()])
                    args = waiting.pop(index)
                    given = skip(index)
                    if given is not None:
                        yield index, given
                        continue
                    worker.start(index, function, args, limit)
                busy = self._busy()
                if not busy:
                    break
                wait([w.pipe for w in busy], timeout=max(0.0, min(w.deadline for w in busy) - time.monotonic()))
                for worker in busy:
                    answer = worker.answer()
                    if answer is not None:
                        yield worker.index, answer
                self._workers = [worker for worker in self._workers if worker.alive]
        finally:
            for worker in self._busy():
                worker.kill()
            self._workers = [worker for worker in self._workers if worker.alive]

    def _busy(self) -> list[_Worker]:
        return [worker for worker in self._workers if worker.busy]

    def _idle(self) -> _Worker:
        worker = next((w for w in self._workers if not w.busy), None)
        if worker is None:
            self._workers.append(worker := _Worker(self._scratch))
        return worker


class _Worker:
    """One process and the pipe to it."""

    def __init__(self, scratch: Path):
        context = multiprocessing.get_context("spawn")  # fork would copy the parent's threads and open figures
        self.pipe, far_end = context.Pipe()
        self.process = context.Process(target=_serve, args=(far_end, str(scratch), os.getpid()), daemon=True)
        before, main = dict(os.environ), sys.modules["__main__"]
        os.environ.update(_ONE_THREAD)
        # A fresh process would run the program's file again, to know what is defined there: a script that makes a
        # report would begin to make another one. Nothing that is called lives there.
        sys.modules["__main__"] = ModuleType("__main__")
        try:
            self.process.start()
        finally:
            sys.modules["__main__"] = main
            os.environ.clear()
            os.environ.update(before)
        far_end.close()
        self.busy, self.begun, self.alive, self.index, self.deadline = False, False, True, -1, 0.0
        self.subject: tuple = ()  # the first argument of its last call

    def next_of(self, waiting: Mapping[int, tuple], taken: Sequence[tuple]) -> int:
        """The first call on what it worked on last, else on what nobody works on, else the first."""
        own = (i for i, args in waiting.items() if args[:1] == self.subject)
        free = (i for i, args in waiting.items() if args[:1] not in taken)
        return next(itertools.chain(own, free, waiting))

    def start(self, index: int, function: Callable, args: tuple, limit: float) -> None:
        """Hand the process a call."""
        self.index, self.busy, self.begun, self.limit, self.subject = index, True, False, limit, args[:1]
        self.deadline = time.monotonic() + _STARTUP_SECONDS
        try:
            self.pipe.send((function, args, limit))
        except (BrokenPipeError, ConnectionResetError):
            pass  # it died while idle; the closed pipe says so when the answer is asked for

    def answer(self) -> Answer | None:
        """The call's answer, or None while it is running within its time."""
        result: Answer | None = None
        if self.pipe.poll():
            try:
                told = self.pipe.recv()
                if told == _BEGUN:
                    self.begun, self.deadline = True, time.monotonic() + self.limit
                    return None
                result, grown, (taken, made) = told
                kept.taken.update(taken)
                kept.made.update(made)
                if grown > _GROWTH_BYTES:
                    self.kill()
            except (EOFError, ConnectionResetError):
                self.process.join(5.0)
                result = _death(self.process.exitcode)
                self.kill()
        elif time.monotonic() >= self.deadline:
            self.kill()
            result = Answer("timed_out", reason=f"it was still running after {self.limit:g} s")
            if not self.begun:
                result = Answer("died", reason=f"its process had not begun after {_STARTUP_SECONDS:g} s", lasting=False)
        self.busy = result is None
        return result

    def kill(self) -> None:
        """End the process and what it started."""
        self.alive = False
        if self.process.pid is not None and self.process.exitcode is None:
            try:
                os.killpg(self.process.pid, signal.SIGKILL)
            except (ProcessLookupError, PermissionError):
                self.process.kill()  # it has not come as far as having a group of its own
        self.process.join(5.0)
        self.pipe.close()


def _death(exitcode: int | None) -> Answer:
    if exitcode is None or exitcode >= 0:
        return Answer("died", reason=f"the process ended with exit code {exitcode}")
    own = -exitcode in _OWN_FAULTS
    named = -exitcode in set(signal.Signals)
    reason = f"the process was ended by signal {signal.Signals(-exitcode).name if named else -exitcode}"
    return Answer("died", reason=reason + ("" if own else ", from outside"), lasting=own)


def _serve(pipe: Connection, scratch: str, parent: int) -> None:
    """The worker's loop: take a call, answer it, until the pipe is closed."""
    import resource

    os.setsid()
    _end_with(parent)
    for what, most in ((resource.RLIMIT_FSIZE, _FILE_BYTES), (resource.RLIMIT_AS, _MEMORY_BYTES)):
        hard = resource.getrlimit(what)[1]
        resource.setrlimit(what, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))
    at_first = None
    while True:
        try:
            function, args, limit = pipe.recv()
        except (EOFError, OSError):
            return
        at_first = at_first or _resident()
        pipe.send(_BEGUN)
        # The system's own alarm ends the process even if the parent is gone and the engine holds the interpreter.
        signal.alarm(int(limit) + 10)
        answer = _call(function, args, Path(tempfile.mkdtemp(dir=scratch)))
        signal.alarm(0)
        try:
            pipe.send((answer, _resident() - at_first, kept.counted()))
        except (TypeError, AttributeError, pickle.PicklingError) as problem:
            pipe.send((Answer("raised", reason=f"what it returned cannot travel: {problem}"), 0, kept.counted()))


def _end_with(parent: int) -> None:
    """Let the system kill this process when its parent is killed: nobody waits for its answer (Linux)."""
    if sys.platform == "linux":
        import ctypes

        PR_SET_PDEATHSIG = 1  # <linux/prctl.h>
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != parent:
            os._exit(1)  # it died before it could be asked for


def _resident() -> int:
    """Bytes of memory this process holds; 0 where the system does not tell (it is then never too much)."""
    try:
        return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except (OSError, ValueError, IndexError):
        return 0


def _call(function: Callable, args: tuple, folder: Path) -> Answer:
    home = os.getcwd()
    os.chdir(folder)
    try:
        with _captured(folder / "output.txt") as output:
            try:
                answer = Answer("done", value=function(*args))
            except BaseException as problem:  # SystemExit too: an engine may try to leave
                answer = Answer("raised", reason=f"{type(problem).__name__}: {problem}".strip())
        return Answer(answer.outcome, answer.value, answer.reason, output.text)
    finally:
        os.chdir(home)
        shutil.rmtree(folder, ignore_errors=True)


class _captured:
    """Standard output and error of this process, C code's included, into a file while the block runs."""

    def __init__(self, path: Path):
        self.path, self.text = path, ""

    def __enter__(self) -> _captured:
        self._file = open(self.path, "w+b")
        self._saved = [os.dup(1), os.dup(2)]
        for stream in (1, 2):
            os.dup2(self._file.fileno(), stream)
        return self

    def __exit__(self, *_):
        for python_stream in (sys.stdout, sys.stderr):
            try:
                python_stream.flush()
            except (OSError, ValueError):
                pass  # the file is full or closed: what is lost is output nobody asked for
        for stream, saved in zip((1, 2), self._saved, strict=True):
            os.dup2(saved, stream)
            os.close(saved)
        self._file.seek(0, os.SEEK_END)
        self._file.seek(max(0, self._file.tell() - 4 * _OUTPUT_CHARACTERS))
        self.text = self._file.read().decode(errors="replace")[-_OUTPUT_CHARACTERS:].strip()
        self._file.close()
