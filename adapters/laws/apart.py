"""Laws tried in a process of its own: an adapter that crashes, hangs or prints costs its own verdict and no other."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Iterable, Iterator
from multiprocessing.connection import Connection
from typing import Any, NamedTuple

from cases import CaseError

from ..interface import find

# Wall seconds that a law may take on a route, and (always) an import: a hundred times what the slowest of ours takes.
LIMIT_SECONDS = 300.0

_SPAWN = multiprocessing.get_context("spawn")


class Face(NamedTuple):
    """What an adapter says of itself."""

    name: str
    routes: tuple[str, ...]


class Apart:
    """An adapter in a process of its own, which is begun again when it ended. A context manager.

    Raises CaseError or ImportError, as `find` does, for an adapter that is not there.
    """

    def __init__(self, name: str, limit: float = LIMIT_SECONDS):
        self.name, self.limit = name, limit
        self.face = self._begin()

    def __enter__(self) -> Apart:
        return self

    def __exit__(self, *_) -> None:
        self._end()

    def tried(self, route: str, laws: Iterable[str]) -> Iterator[tuple[str, str, str]]:
        """Each law with its outcome and reason: those of `judge`, or "crashed" or "timed_out"."""
        for law in laws:
            yield law, *self._ask(route, law)

    def _begin(self) -> Face:
        self.here, there = _SPAWN.Pipe()
        self.process = _SPAWN.Process(target=_serve, args=(self.name, there), daemon=True)
        self.process.start()
        there.close()
        answer = self._answer(LIMIT_SECONDS)
        if isinstance(answer, Exception):
            self._end()
            raise answer
        if isinstance(answer, Face):
            return answer
        self._end()
        raise ImportError(f"the adapter {self.name} {answer[0]} while it is imported: {answer[1]}")

    def _ask(self, route: str, law: str) -> tuple[str, str]:
        if not self.process.is_alive():
            self._begin()
        self.here.send((route, law))
        return self._answer(self.limit)

    def _answer(self, limit: float) -> Any:
        try:
            if self.here.poll(limit):
                return self.here.recv()
            self._end()
            return "timed_out", f"no answer within {limit:g} s"
        except (EOFError, ConnectionError):
            self.process.join()
            return "crashed", f"its process ended with exit code {self.process.exitcode}"

    def _end(self) -> None:
        self.process.kill()
        self.process.join()


def _serve(name: str, there: Connection) -> None:
    """The adapter's process: says what there is, then tries what it is asked to."""
    from . import judge

    quiet = os.open(os.devnull, os.O_WRONLY)
    os.dup2(quiet, 1)  # what an engine prints is no verdict
    os.dup2(quiet, 2)
    try:
        adapter = find(name)
        there.send(Face(adapter.NAME, tuple(adapter.routes)))
    except (CaseError, ImportError) as problem:
        there.send(problem)
        return
    while True:
        try:
            route, law = there.recv()
        except EOFError:
            return
        (verdict,) = judge(adapter, [law], [route])
        there.send((verdict.outcome, verdict.reason))
