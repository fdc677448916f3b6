"""Checks laws in a separate process: an adapter that crashes, hangs or prints affects only its own verdict."""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import tempfile
import time
from collections.abc import Iterable, Iterator
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection
from typing import Any, NamedTuple

from cases import CaseError
from cases.files.owned_folder import TemporaryFolder

from .. import gate
from ..interface import ReturnsOnce, returns_once
from ..lookup import find

# Wall seconds that a law may take on a route, and (always) an import: a hundred times the slowest of the suite's.
LIMIT_SECONDS = 300.0
# After so many time-outs on a route its other laws are not checked; each would take as long.
MOST_LATE = 3

# Longer answers are invalid.
_ANSWER_BYTES = 2**20

_SPAWN = multiprocessing.get_context("spawn")


class AdapterInfo(NamedTuple):
    """An adapter's name and routes."""

    name: str
    routes: tuple[str, ...]


class AdapterProcess:
    """An adapter in a separate process, which is started again if it has ended. A context manager.

    Raises CaseError or ImportError, as `find` does, for an adapter that does not exist.
    """

    def __init__(self, name: str, limit: float | None = None):
        self.name, self.limit = name, limit or LIMIT_SECONDS
        self.process = _SPAWN.Process()  # not started yet
        # Temporary files of an engine whose process is ended; another command removes those of a killed command.
        self._folder = TemporaryFolder()
        try:
            self.face = self._begin()
        except BaseException:
            self._end()
            self._folder.remove()
            raise

    def __enter__(self) -> AdapterProcess:
        return self

    def __exit__(self, *_) -> None:
        self._end()
        self._folder.remove()

    def try_laws(self, route: str, laws: Iterable[str], seed: int = 0) -> Iterator[tuple[str, str, str]]:
        """Each law with its outcome and reason: those of `judge`, or "crashed" or "timed_out"."""
        late = 0
        for law in laws:
            if late == MOST_LATE:
                yield law, "timed_out", f"not checked: {late} other laws timed out on this route"
                continue
            outcome, reason = self._ask(route, law, seed)
            late += outcome == "timed_out"
            yield law, outcome, reason

    def _begin(self) -> AdapterInfo:
        self.number = 0
        self.here, there = _SPAWN.Pipe()
        self.process = _SPAWN.Process(target=_serve, args=(self.name, there, str(self._folder.path)), daemon=True)
        resource_tracker.ensure_running()  # starting it later would unblock Ctrl-C
        mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})  # Ctrl-C is for the process that asks
        try:
            self.process.start()
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        there.close()
        answer = self._answer(LIMIT_SECONDS)
        if isinstance(answer, Exception):
            self._end()
            raise answer
        if isinstance(answer, AdapterInfo):
            return answer
        self._end()
        raise ImportError(f"the adapter {self.name} {answer[0]} while it is imported: {answer[1]}")

    def _ask(self, route: str, law: str, seed: int) -> tuple[str, str]:
        try:
            if not self.process.is_alive():
                self._begin()
            self.number += 1
            self.here.send((self.number, route, law, seed))
        except (ImportError, CaseError, OSError) as problem:
            return "crashed", f"its process could not be started again: {problem}"
        return self._answer(self.limit)

    def _answer(self, limit: float) -> Any:
        """The answer with the number of the last request."""
        until = time.monotonic() + limit
        try:
            while self.here.poll(max(0.0, until - time.monotonic())):
                number, answer = pickle.loads(self.here.recv_bytes(_ANSWER_BYTES))
                if number == self.number:
                    return answer
            self._end()
            return "timed_out", f"no answer within {limit:g} s"
        except Exception:  # the pipe is closed, or holds an invalid answer
            self.process.join(1.0)
            self._end()
            return "crashed", f"its process ended with exit code {self.process.exitcode}"

    def _end(self) -> None:
        if self.process.pid is not None:
            self.process.kill()
            self.process.join()


def _serve(name: str, there: Connection, folder: str) -> None:
    """The adapter's process: report the adapter's name and routes, then check the requested laws; temporary files go to
    the folder."""
    tempfile.tempdir = os.environ["TMPDIR"] = folder
    quiet = os.open(os.devnull, os.O_WRONLY)
    os.dup2(quiet, 1)  # the output of an engine is discarded
    os.dup2(quiet, 2)
    own, number = os.getpid(), 0

    def say(answer: Any) -> None:
        if os.getpid() != own:
            os._exit(0)  # a process that the adapter forked came back as well: it has nothing to say
        there.send((number, answer))

    try:
        adapter = ReturnsOnce(returns_once(find)(name))
        say(AdapterInfo(str(adapter.NAME), gate.routes(adapter.routes)))
    except (CaseError, ImportError) as problem:
        say(problem)
        return
    except (Exception, SystemExit) as problem:
        say(ImportError(f"the adapter {name} fails while it is imported: {type(problem).__name__}: {problem}"))
        return
    from . import judge  # a slow import, which a name that is no adapter's does not need

    while True:
        try:
            number, route, law, seed = there.recv()
        except EOFError:
            return
        (verdict,) = judge(adapter, [law], [route], seed)
        say((verdict.outcome, verdict.reason.encode("utf-8", "backslashreplace").decode()))
