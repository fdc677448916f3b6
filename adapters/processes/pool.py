"""Runs calls in separate processes: a crash, a hang or a flood of output ends one worker and nothing else.

Every call works in an empty scratch directory and has its output captured. At its time limit it is killed with all its
child processes, and the next call gets a new worker. Every answer has its call's number; other messages are ignored. A
call that failed by a fault of the machine or of the suite is made once more (`WorkerPool._is_retried`). POSIX only.
"""

from __future__ import annotations

import io
import itertools
import multiprocessing
import os
import pickle
import signal
import sys
import tempfile
import time
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from multiprocessing import resource_tracker
from multiprocessing.connection import wait
from pathlib import Path
from types import ModuleType
from typing import Any

from cases.errors import legible
from cases.files import owned_folder

from ..common.supervision import TOO_MUCH_MEMORY
from ..lookup import is_adapters
from .worker import MEMORY_BYTES, START_MESSAGE, CallResult, NextCall, serve

# Time limit for the start of a process (s), for a busy machine; it does not count towards the call's limit.
_STARTUP_SECONDS = 60.0
# Seconds in which a worker's supervisor ends the worker and its child processes.
_ENDING_SECONDS = 8.0
# Signals that a process causes itself, by a fault or its own timer; all others come from outside (a user, or the system
# when memory runs out).
_OWN_FAULTS = {
    signal.SIGSEGV, signal.SIGABRT, signal.SIGFPE, signal.SIGILL, signal.SIGBUS, signal.SIGSYS, signal.SIGALRM,
    signal.SIGVTALRM, signal.SIGPROF, signal.SIGXCPU,
}  # fmt: skip
# One thread per worker: concurrent runs must not compete for cores, and CPU time must be one core's time.
_ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
# Most idle workers: one for the reference and one for each of a few engines. Each holds about 150 MB.
_MOST_IDLE = 6
# So few brief calls are finished before another process has started.
_FEW = 40
# Size limit of an answer in bytes. The largest, a case's figures, has some megabytes; random bytes look longer.
_ANSWER_BYTES = 2**28
_NUMBERS = itertools.count(1)


class WorkerPool:
    """Worker processes that make calls, `jobs` at a time. Raises OSError if they can have no folder for their files.

    `groups_of`: the groups of calls by their arguments, "" for calls that load no engine; calls of different groups
    never share a worker. `paths_of`: folders that the workers of a group search first for packages. `close`, at the end
    of a `with` block too, kills them and removes their scratch directories; leftovers of a killed main process are
    removed by the next pool."""

    def __init__(
        self,
        jobs: int,
        groups_of: Callable[[Sequence[tuple]], Sequence[str]] = lambda calls: [""] * len(calls),
        paths_of: Callable[[str], list[str]] = lambda group: [],
    ):
        self._jobs, self._groups_of, self._paths_of = jobs, groups_of, paths_of
        owned_folder.remove_leftovers()
        self._scratch: owned_folder.TemporaryFolder | None = None
        self._workers: list[_Worker] = []
        self._require_folder()

    def __enter__(self) -> WorkerPool:
        return self

    def __exit__(self, *_) -> None:
        self.close()

    def begin(self, groups: Sequence[str], preload: str) -> None:
        """Start a worker for each group; it imports the module `preload` in the background."""
        self._workers += [self._new_worker(group, preload) for group in groups]

    def _new_worker(self, group: str, preload: str = "") -> _Worker:
        return _Worker(self._require_folder(), group, self._paths_of(group), preload)

    def close(self) -> None:
        """End the workers."""
        for worker in self._workers:
            worker.kill()
        if self._scratch is not None:
            self._scratch.remove()

    def _require_folder(self) -> Path:
        """The folder of the workers' folders, made again if it is gone; raises OSError if nothing can be written."""
        try:
            if self._scratch is None or not self._scratch.path.is_dir():
                self._scratch = owned_folder.TemporaryFolder()
            owned_folder.check_usable(self._scratch.path)
        except OSError as problem:
            raise OSError(
                f"the folder for temporary files, {tempfile.gettempdir()}, cannot be written to ({problem.strerror}); "
                "give it room or set TMPDIR to another folder, and repeat the command"
            ) from problem
        return self._scratch.path

    def _is_retried(self, worker: _Worker, answer: CallResult, is_first: bool) -> bool:
        """Whether the call is made once more because the machine or the suite caused its failure.

        These faults are a worker that ended before the call began, a folder that is gone or full, and a signal from
        outside. Raises OSError if the machine lets no worker begin: then nothing is known about the call.
        """
        if answer.outcome in ("done", "timed_out") or not (worker.is_lost(answer) or not answer.lasting):
            return False
        worker.kill()
        self._require_folder()
        if not is_first and (answer.outcome == "lost" or not (worker.group or worker.has_begun)):
            raise OSError(f"no process can make a call: {answer.reason}; repeat the command when the machine allows it")
        return is_first

    def call(self, function: Callable, *arguments: Any, limit: float = 60.0) -> CallResult:
        """The answer to one call."""
        ((_, answer),) = self.run(function, [arguments], limit)
        return answer

    def run(
        self,
        function: Callable,
        arguments: Sequence[tuple],
        limit: float = 60.0,
        skip: Callable[[int], CallResult | None] = lambda index: None,
        groups: Sequence[str] = (),
        brief: bool = False,
    ) -> Generator[tuple[int, CallResult]]:
        """Call `function(*arguments[i])` for every i, each for at most `limit` seconds of wall time.

        Calls with the same first argument start in order, in one worker if no other worker would be idle: code compiled
        for a case serves all runs of the case. `groups`: those of the calls, not by `groups_of`. Yields (i, answer) as
        calls end; `skip(i)`, called just before call i would start, may return an answer instead. The function and
        its arguments are pickled, so the function must be at the top level of a module. Calls still running when the
        iterator is closed are killed. The rest of a call (`worker.without_engines`) is made before others, so that few
        motions wait. `brief`: each call takes milliseconds, so that few calls start no additional workers.
        """
        groups = list(groups or self._groups_of(arguments))
        calls = [NextCall(function, args) for args in arguments]
        waiting = dict(enumerate(arguments))
        once_more, rest_indices = set(waiting), set[int]()
        try:
            while waiting or self._busy():
                while waiting and len(self._busy()) < self._jobs:
                    rests = {i: args for i, args in waiting.items() if i in rest_indices}
                    choice = self._next(rests or waiting, groups, brief)
                    if choice is None:
                        break
                    worker, index = choice
                    args = waiting.pop(index)
                    substitute = None if index in rest_indices else skip(index)
                    if substitute is not None:
                        yield index, substitute
                        continue
                    try:
                        worker.start(index, calls[index].function, args, limit)
                    except (pickle.PicklingError, TypeError, AttributeError) as problem:
                        yield index, CallResult("raised", reason=legible(f"its arguments cannot be pickled: {problem}"))
                busy = self._busy()
                if not busy:
                    break
                wait([w.pipe for w in busy], timeout=max(0.0, min(w.deadline for w in busy) - time.monotonic()))
                for worker in busy:
                    answer = worker.answer()
                    if answer is None:
                        continue
                    if self._is_retried(worker, answer, worker.index in once_more):
                        once_more.remove(worker.index)
                        waiting = {worker.index: calls[worker.index].arguments, **waiting}
                        continue
                    if isinstance(answer.value, NextCall):
                        calls[worker.index], groups[worker.index] = answer.value, ""
                        waiting = {worker.index: answer.value.arguments, **waiting}
                        rest_indices.add(worker.index)
                        once_more.add(worker.index)
                        continue
                    if worker.is_lost(answer):  # twice: by the call itself, or not for certain by the machine
                        answer = replace(answer, outcome="died", lasting=False)
                    yield worker.index, answer
                self._workers = [worker for worker in self._workers if worker.alive]
        finally:
            for worker in self._busy():
                worker.kill()
            self._workers = [worker for worker in self._workers if worker.alive]

    def _busy(self) -> list[_Worker]:
        return [worker for worker in self._workers if worker.busy]

    def _next(self, waiting: Mapping[int, tuple], groups: Sequence[str], brief: bool) -> tuple[_Worker, int] | None:
        """An idle or new worker and its next call; None if the busy workers will soon finish the few waiting calls."""
        busy = self._busy()
        subjects = [worker.subject for worker in busy]
        for worker in self._workers:
            if not worker.busy:
                own = {i: args for i, args in waiting.items() if groups[i] == worker.group}
                if own:
                    return worker, worker.next_of(own, subjects)
        at_work = {worker.group for worker in busy}
        if brief and len(waiting) <= _FEW and all(groups[i] in at_work for i in waiting):
            return None
        group = groups[next((i for i in waiting if groups[i] not in at_work), next(iter(waiting)))]
        self._make_room({groups[i] for i in waiting})
        self._workers.append(worker := self._new_worker(group))
        return worker, worker.next_of({i: args for i, args in waiting.items() if groups[i] == group}, subjects)

    def _make_room(self, groups: set[str]) -> None:
        """End idle workers beyond the limit, first those outside `groups`, the groups of waiting calls."""
        idle = [worker for worker in self._workers if not worker.busy]
        excess = len(self._workers) - self._jobs - _MOST_IDLE + 1
        for worker in sorted(idle, key=lambda worker: worker.group in groups)[: max(0, excess)]:
            worker.kill()
        self._workers = [worker for worker in self._workers if worker.alive]


class _Worker:
    """A worker process and the pipe to it."""

    def __init__(self, folder: Path, group: str, paths: list[str], preload: str = ""):
        context = multiprocessing.get_context("spawn")  # fork would copy the parent's threads and open figures
        self._scratch = owned_folder.TemporaryFolder(folder)
        self.pipe, far_end = context.Pipe()
        process_args = far_end, str(self._scratch.path), os.getpid(), group, preload
        self.process = context.Process(target=serve, args=process_args, daemon=True)
        with _start_environment(paths):
            self.process.start()
        far_end.close()
        self.group = group
        self.busy, self.has_begun, self.alive, self.index, self.deadline = False, False, True, -1, 0.0
        self.subject: tuple = ()  # the first argument of its last call

    def next_of(self, waiting: Mapping[int, tuple], subjects: Sequence[tuple]) -> int:
        """The first waiting call with the worker's last subject, else with one that is not in work, else the first."""
        own = (i for i, args in waiting.items() if args[:1] == self.subject)
        free = (i for i, args in waiting.items() if args[:1] not in subjects)
        return next(itertools.chain(own, free, waiting))

    def start(self, index: int, function: Callable, args: tuple, limit: float) -> None:
        """Send the process a call; raises PicklingError, TypeError or AttributeError if it cannot be pickled."""
        self.number = next(_NUMBERS)
        message = pickle.dumps((self.number, function, args, limit))
        self.index, self.busy, self.has_begun, self.limit, self.subject = index, True, False, limit, args[:1]
        self.deadline = time.monotonic() + _STARTUP_SECONDS
        with suppress(BrokenPipeError, ConnectionResetError):
            # If the process has ended while idle, `answer` finds the pipe closed.
            self.pipe.send_bytes(message)

    def answer(self) -> CallResult | None:
        """The call's answer, or None while it runs within its time limit."""
        if self.pipe.poll():
            result = self._receive()
        elif time.monotonic() >= self.deadline:
            # A child process of the worker may hold the pipe open after the worker's end.
            result = self._wait_for_end(0.0) or self._late()
            self.kill()
        else:
            return None
        self.busy = result is None
        return result

    def is_lost(self, answer: CallResult) -> bool:
        """Whether a call without an answer or a time-out had not begun, or its folder is gone or full."""
        if answer.outcome in ("done", "timed_out"):
            return False
        return answer.outcome == "lost" or not self.has_begun or not self._has_folder()

    def _has_folder(self) -> bool:
        """Whether its folder can be written to; of a killed worker, whether it could then."""
        if self.alive:
            self.had_folder = False
            with suppress(OSError):
                owned_folder.check_usable(self._scratch.path)
                self.had_folder = True
        return self.had_folder

    def _late(self) -> CallResult:
        if self.has_begun:
            return CallResult("timed_out", reason=f"it was still running after {self.limit:g} s")
        return CallResult("died", reason=f"its process had not begun after {_STARTUP_SECONDS:g} s", lasting=False)

    def _receive(self) -> CallResult | None:
        """Read a message; returns the call's answer, or None for another message."""
        try:
            message = self.pipe.recv_bytes(_ANSWER_BYTES)
        except (EOFError, OSError):
            death = self._wait_for_end(5.0) or CallResult(
                "died", reason="its process closed its pipe, or wrote no answer into it"
            )
            self.kill()
            return death
        try:
            number, result, *more = read(message)
            if number != self.number:
                return None  # sent by a child process of an earlier call
            if result == START_MESSAGE:
                self.has_begun, self.deadline = True, time.monotonic() + self.limit
                return None
            (retire,) = more
        except Exception as problem:  # the bytes of a broken answer can raise anything
            result, retire = CallResult("raised", reason=legible(f"its answer cannot be read: {problem}")), True
        if retire:
            self.kill()
        return result

    def kill(self) -> None:
        """End the process and its child processes, and remove its files."""
        self._has_folder()
        self.alive = False
        if self.process.pid is not None and self.process.exitcode is None:
            self.process.terminate()  # its supervisor ends its child processes
            self._wait_for_end(_ENDING_SECONDS)
            if self.process.exitcode is None:
                self._end_group()
                self.process.kill()
        self.process.join(5.0)
        self.pipe.close()
        self._scratch.remove()

    def _wait_for_end(self, patience: float) -> CallResult | None:
        """Wait for the process's end, at most `patience` seconds, and end its group; None if it still runs."""
        until = time.monotonic() + patience
        ways = os.WEXITED | os.WNOHANG | os.WNOWAIT  # WNOWAIT keeps the process id reserved
        with suppress(ChildProcessError):
            while os.waitid(os.P_PID, self.process.pid or 0, ways) is None:
                if time.monotonic() >= until:
                    return None
                time.sleep(0.005)
            self._end_group()
        self.process.join(5.0)
        return _death(self.process.exitcode)

    def _end_group(self) -> None:
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(self.process.pid or 0, signal.SIGKILL)


@contextmanager
def _start_environment(first: list[str]) -> Iterator[None]:
    """Sets what processes started in the block inherit.

    One thread per library, an empty main module, Ctrl-C blocked (the main process handles it), and the folders `first`
    at the head of the module search path."""
    resource_tracker.ensure_running()  # started here, because it unblocks Ctrl-C at its start
    before, main, path = dict(os.environ), sys.modules["__main__"], sys.path
    os.environ.update(_ONE_THREAD)
    sys.path = [*first, *path]  # multiprocessing passes it on
    # A new process would run the program's file again for its definitions: a script that makes a report would start
    # another report. No function that is called is defined there.
    sys.modules["__main__"] = ModuleType("__main__")
    old_mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        sys.modules["__main__"], sys.path = main, path
        os.environ.clear()
        os.environ.update(before)
        signal.pthread_sigmask(signal.SIG_SETMASK, old_mask)


class _Reader(pickle.Unpickler):
    """Unpickles an answer without importing an adapter, whose code would then run in this process."""

    def find_class(self, module: str, name: str) -> Any:
        if module not in sys.modules and is_adapters(module):
            raise pickle.UnpicklingError(f"it holds a {module}.{name}, which only its adapter defines")
        return super().find_class(module, name)


def read(message: bytes) -> Any:
    """Unpickle a worker's message; a broken message can raise anything."""
    return _Reader(io.BytesIO(message)).load()


def _death(exitcode: int | None) -> CallResult:
    if exitcode == -TOO_MUCH_MEMORY:
        return CallResult("died", reason=f"it held more than {MEMORY_BYTES / 2**30:g} GB of resident memory")
    if exitcode is None or exitcode >= 0:
        return CallResult("died", reason=f"the process ended with exit code {exitcode}")
    own = -exitcode in _OWN_FAULTS
    has_name = -exitcode in set(signal.Signals)
    reason = f"the process was ended by signal {signal.Signals(-exitcode).name if has_name else -exitcode}"
    return CallResult("died", reason=reason + ("" if own else ", from outside"), lasting=own)
