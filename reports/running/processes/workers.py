"""Calls in processes of their own: a crash, a hang or a flood of output ends a worker and nothing else.

Every call gets an empty scratch directory to work in, has its output captured, and is killed with everything it
started when its time is over; the next call finds a fresh worker. Every answer has its call's number, and no other is
taken. A call whose worker was ended from outside is made once more. POSIX only.
"""

from __future__ import annotations

import io
import itertools
import multiprocessing
import os
import pickle
import signal
import sys
import time
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from multiprocessing import resource_tracker
from multiprocessing.connection import wait
from pathlib import Path
from types import ModuleType
from typing import Any

from adapters.common.supervision import TOO_MUCH_MEMORY
from cases import compile_cache, owned_folder

from .. import versions
from ..records import legible
from ..solvers import groups_of
from ..storage.source_code import is_adapters
from .worker_process import BEGUN, MEMORY_BYTES, CallResult, serve

# A fresh process may take this long, on a busy machine, to come to its first call; that is not the call's fault.
_STARTUP_SECONDS = 60.0
# A worker's supervisor ends it and what it started within so long.
_ENDING_SECONDS = 8.0
# Signals a process brings on itself, by a fault or its own timer; any other came from outside (a user, the system when
# memory ran out).
_OWN_FAULTS = {
    signal.SIGSEGV, signal.SIGABRT, signal.SIGFPE, signal.SIGILL, signal.SIGBUS, signal.SIGSYS, signal.SIGALRM,
    signal.SIGVTALRM, signal.SIGPROF, signal.SIGXCPU,
}  # fmt: skip
# One thread to a worker: runs beside each other must not fight for cores, and CPU time must mean one core's time.
_ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
# Workers beyond those at work: one for the reference and for each of a few engines. Each holds some 150 MB.
_MOST_IDLE = 6
# So few brief calls are over before another process has begun.
_FEW = 40
# The largest answer is a case's figures, some megabytes. What is no answer at all looks like a longer one.
_ANSWER_BYTES = 2**28
_NUMBERS = itertools.count(1)


class WorkerPool:
    """Workers that make calls, `jobs` at a time. Closed, they are killed and their scratch directories gone; what is
    left of a process that was killed itself is removed by the next. `known_run`: whether a worker makes a known run
    after each call of an engine; not where that would change what is measured."""

    def __init__(self, jobs: int, known_run: bool = True):
        self._jobs, self._known_run = jobs, known_run
        owned_folder.remove_leftovers()
        self._scratch = owned_folder.TemporaryFolder()
        self._workers: list[_Worker] = []

    def begin(self, groups: Sequence[str]) -> None:
        """Start a worker of each group, which imports what a report's calls need while nobody waits for it."""
        ahead = "reports.running.tasks"
        self._workers += [_Worker(self._scratch.path, group, self._known_run, ahead) for group in groups]

    def close(self) -> None:
        """End the workers."""
        for worker in self._workers:
            worker.kill()
        self._scratch.remove()

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

        Calls with the same first argument begin in order, by one worker where that leaves nobody idle: what it
        compiled for a case serves all of the case's runs. Calls of unlike `groups` (by default: `groups_of` them) never
        share a worker; one that is called as a solver with a version is run with that version. Yields
        (i, answer) as they end; `skip(i)`, called just before call i would begin, may give an answer in its place. The
        function and its arguments travel by pickle, so the function lives at the top of a module. Calls that are still
        running when the iterator ends are killed. `brief`: each takes milliseconds, and no more workers are started
        than calls of so few need.
        """
        groups = groups or groups_of(arguments)
        waiting = dict(enumerate(arguments))
        once_more = set(waiting)
        try:
            while waiting or self._busy():
                while waiting and len(self._busy()) < self._jobs:
                    found = self._next(waiting, groups, brief)
                    if found is None:
                        break
                    worker, index = found
                    args = waiting.pop(index)
                    given = skip(index)
                    if given is not None:
                        yield index, given
                        continue
                    try:
                        worker.start(index, function, args, limit)
                    except (pickle.PicklingError, TypeError, AttributeError) as problem:
                        yield index, CallResult("raised", reason=legible(f"what it is given cannot travel: {problem}"))
                busy = self._busy()
                if not busy:
                    break
                wait([w.pipe for w in busy], timeout=max(0.0, min(w.deadline for w in busy) - time.monotonic()))
                for worker in busy:
                    answer = worker.answer()
                    if answer is None:
                        continue
                    if answer.outcome == "died" and not answer.lasting and worker.index in once_more:
                        once_more.remove(worker.index)
                        waiting = {worker.index: arguments[worker.index], **waiting}
                        continue
                    yield worker.index, answer
                self._workers = [worker for worker in self._workers if worker.alive]
        finally:
            for worker in self._busy():
                worker.kill()
            self._workers = [worker for worker in self._workers if worker.alive]

    def _busy(self) -> list[_Worker]:
        return [worker for worker in self._workers if worker.busy]

    def _next(self, waiting: Mapping[int, tuple], groups: Sequence[str], brief: bool) -> tuple[_Worker, int] | None:
        """A worker that has nothing to do, an idle one of a group that waits or a new one, and its next call; None
        where those at work will soon have made the few that wait."""
        busy = self._busy()
        taken = [worker.subject for worker in busy]
        for worker in self._workers:
            if not worker.busy:
                own = {i: args for i, args in waiting.items() if groups[i] == worker.group}
                if own:
                    return worker, worker.next_of(own, taken)
        at_work = {worker.group for worker in busy}
        if brief and len(waiting) <= _FEW and all(groups[i] in at_work for i in waiting):
            return None
        group = groups[next((i for i in waiting if groups[i] not in at_work), next(iter(waiting)))]
        self._make_room({groups[i] for i in waiting})
        self._workers.append(worker := _Worker(self._scratch.path, group, self._known_run))
        return worker, worker.next_of({i: args for i, args in waiting.items() if groups[i] == group}, taken)

    def _make_room(self, wanted: set[str]) -> None:
        """End idle workers beyond the number that is kept, first those of groups that no call waits for."""
        idle = [worker for worker in self._workers if not worker.busy]
        excess = len(self._workers) - self._jobs - _MOST_IDLE + 1
        for worker in sorted(idle, key=lambda worker: worker.group in wanted)[: max(0, excess)]:
            worker.kill()
        self._workers = [worker for worker in self._workers if worker.alive]


class _Worker:
    """One process and the pipe to it."""

    def __init__(self, folder: Path, group: str, known_run: bool, ahead: str = ""):
        context = multiprocessing.get_context("spawn")  # fork would copy the parent's threads and open figures
        self.pipe, far_end = context.Pipe()
        given = far_end, str(folder), os.getpid(), group, known_run, ahead
        self.process = context.Process(target=serve, args=given, daemon=True)
        with _start_environment(versions.paths(group)):
            self.process.start()
        far_end.close()
        self.group = group
        self.busy, self.begun, self.alive, self.index, self.deadline = False, False, True, -1, 0.0
        self.subject: tuple = ()  # the first argument of its last call

    def next_of(self, waiting: Mapping[int, tuple], taken: Sequence[tuple]) -> int:
        """The first call on what it worked on last, else on what nobody works on, else the first."""
        own = (i for i, args in waiting.items() if args[:1] == self.subject)
        free = (i for i, args in waiting.items() if args[:1] not in taken)
        return next(itertools.chain(own, free, waiting))

    def start(self, index: int, function: Callable, args: tuple, limit: float) -> None:
        """Hand the process a call; raises PicklingError, TypeError or AttributeError for what cannot travel."""
        self.number = next(_NUMBERS)
        message = pickle.dumps((self.number, function, args, limit))
        self.index, self.busy, self.begun, self.limit, self.subject = index, True, False, limit, args[:1]
        self.deadline = time.monotonic() + _STARTUP_SECONDS
        with suppress(BrokenPipeError, ConnectionResetError):
            # Where it died while idle the closed pipe says so when the answer is asked for.
            self.pipe.send_bytes(message)

    def answer(self) -> CallResult | None:
        """The call's answer, or None while it is running within its time."""
        if self.pipe.poll():
            result = self._told()
        elif time.monotonic() >= self.deadline:
            # A process that it left behind may hold the pipe open after its end.
            result = self._ended(0.0) or self._late()
            self.kill()
        else:
            return None
        self.busy = result is None
        return result

    def _late(self) -> CallResult:
        if self.begun:
            return CallResult("timed_out", reason=f"it was still running after {self.limit:g} s")
        return CallResult("died", reason=f"its process had not begun after {_STARTUP_SECONDS:g} s", lasting=False)

    def _told(self) -> CallResult | None:
        """What stands in the pipe, if it is the call's answer; None for another message."""
        try:
            message = self.pipe.recv_bytes(_ANSWER_BYTES)
        except (EOFError, OSError):
            gone = self._ended(5.0) or CallResult(
                "died", reason="its process closed its pipe, or wrote no answer into it"
            )
            self.kill()
            return gone
        try:
            number, result, *more = read(message)
            if number != self.number:
                return None  # a process that an earlier call left behind has spoken
            if result == BEGUN:
                self.begun, self.deadline = True, time.monotonic() + self.limit
                return None
            spent, (taken, made) = more
            compile_cache.hits.update(taken)
            compile_cache.misses.update(made)
        except Exception as problem:  # whatever was written in an answer's place
            result, spent = CallResult("raised", reason=legible(f"its answer cannot be read: {problem}")), True
        if spent:
            self.kill()
        return result

    def kill(self) -> None:
        """End the process and what it started."""
        self.alive = False
        if self.process.pid is not None and self.process.exitcode is None:
            self.process.terminate()  # its supervisor ends all that is below it
            self._ended(_ENDING_SECONDS)
            if self.process.exitcode is None:
                self._end_group()
                self.process.kill()
        self.process.join(5.0)
        self.pipe.close()

    def _ended(self, patience: float) -> CallResult | None:
        """What its end says, once it has come within so many seconds; what it started ends with it."""
        until = time.monotonic() + patience
        ways = os.WEXITED | os.WNOHANG | os.WNOWAIT  # its number stays its own as long as nobody has asked for its end
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
    """What a process that is started in the block inherits: one thread for each library, no program to run again, and
    no Ctrl-C, which is for the process that asks. It looks for packages in the folders `first`."""
    resource_tracker.ensure_running()  # it lets Ctrl-C through again once it has begun
    before, main, path = dict(os.environ), sys.modules["__main__"], sys.path
    os.environ.update(_ONE_THREAD)
    sys.path = [*first, *path]  # multiprocessing hands it on
    # A fresh process would run the program's file again, to know what is defined there: a script that makes a
    # report would begin to make another one. Nothing that is called lives there.
    sys.modules["__main__"] = ModuleType("__main__")
    blocked = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        sys.modules["__main__"], sys.path = main, path
        os.environ.clear()
        os.environ.update(before)
        signal.pthread_sigmask(signal.SIG_SETMASK, blocked)


class _Reader(pickle.Unpickler):
    """Reads an answer without importing an adapter: to load one is to run it in this process."""

    def find_class(self, module: str, name: str) -> Any:
        if module not in sys.modules and is_adapters(module):
            raise pickle.UnpicklingError(f"it holds a {module}.{name}, which only its adapter knows")
        return super().find_class(module, name)


def read(message: bytes) -> Any:
    """What came from a worker; raises whatever may be wrong with it."""
    return _Reader(io.BytesIO(message)).load()


def _death(exitcode: int | None) -> CallResult:
    if exitcode == -TOO_MUCH_MEMORY:
        return CallResult("died", reason=f"it held more than {MEMORY_BYTES / 2**30:g} GB of resident memory")
    if exitcode is None or exitcode >= 0:
        return CallResult("died", reason=f"the process ended with exit code {exitcode}")
    own = -exitcode in _OWN_FAULTS
    named = -exitcode in set(signal.Signals)
    reason = f"the process was ended by signal {signal.Signals(-exitcode).name if named else -exitcode}"
    return CallResult("died", reason=reason + ("" if own else ", from outside"), lasting=own)
