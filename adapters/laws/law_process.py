"""Checks laws in a process apart: an adapter that crashes, hangs or prints affects only its own verdict."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from contextlib import chdir
from functools import lru_cache
from typing import Any, NamedTuple

from cases import CaseError

from .. import gate
from ..interface import ReturnsOnce, returns_once
from ..lookup import find
from ..processes.pool import WorkerPool
from ..processes.worker import CallResult

# Wall seconds that a law may take on a route, and (always) an import: a hundred times the slowest of the suite's.
LIMIT_SECONDS = 300.0
# After so many time-outs on a route its other laws are not checked; each would take as long.
MOST_LATE = 3


class AdapterInfo(NamedTuple):
    """An adapter's name and routes."""

    name: str
    routes: tuple[str, ...]


class AdapterProcess:
    """An adapter in a process apart, which is started again if it has ended. A context manager.

    Raises CaseError or ImportError, as `find` does, for an adapter that does not exist.
    """

    def __init__(self, name: str, limit: float | None = None):
        self.name, self.limit, self.folder = name, limit or LIMIT_SECONDS, os.getcwd()
        self._pool = WorkerPool(1, lambda calls: [name] * len(calls))
        try:
            self.face = self._begin()
        except BaseException:
            self._pool.close()
            raise

    def __enter__(self) -> AdapterProcess:
        return self

    def __exit__(self, *_) -> None:
        self._pool.close()

    def _begin(self) -> AdapterInfo:
        answer = self._pool.call(info, self.name, self.folder, limit=LIMIT_SECONDS)
        if isinstance(answer.value, Exception):
            raise answer.value
        if answer.outcome != "done":
            outcome, reason = answer.failure
            raise ImportError(f"the adapter {self.name} {outcome} while it is imported: {reason}")
        return answer.value

    def try_laws(self, route: str, laws: Iterable[str], seed: int = 0) -> Iterator[tuple[str, str, str]]:
        """Each law with its outcome and reason: those of `judge`, or "crashed" or "timed_out"."""
        selection, late = tuple(laws), list[str]()

        def skip(index: int) -> CallResult | None:
            if len(late) < MOST_LATE:
                return None
            return CallResult("timed_out", reason=f"not checked: {MOST_LATE} other laws timed out on this route")

        calls: Sequence[tuple] = [(self.name, self.folder, route, law, seed) for law in selection]
        for index, answer in self._pool.run(verdict, calls, self.limit, skip):
            outcome, reason = answer.value if answer.outcome == "done" else answer.failure
            late += [selection[index]] if outcome == "timed_out" else []
            yield selection[index], outcome, reason


# --- in the adapter's process -----------------------------------------------------------------------------------------


@lru_cache(maxsize=1)
def _adapter(name: str, folder: str) -> Any:
    """The adapter of a name, as it is found in a working folder."""
    with chdir(folder):
        return ReturnsOnce(returns_once(find)(name))


def info(name: str, folder: str) -> AdapterInfo | Exception:
    """The adapter's name and routes, or the error of `find`."""
    try:
        adapter = _adapter(name, folder)
        return AdapterInfo(str(adapter.NAME), gate.routes(adapter.routes))
    except (CaseError, ImportError) as problem:
        return problem
    except (Exception, SystemExit) as problem:
        return ImportError(f"the adapter {name} fails while it is imported: {type(problem).__name__}: {problem}")


def verdict(name: str, folder: str, route: str, law: str, seed: int) -> tuple[str, str]:
    """Outcome and reason of a law."""
    from . import judge  # a slow import, which a name that is no adapter's does not need

    (own,) = judge(_adapter(name, folder), [law], [route], seed)
    return own.outcome, own.reason.encode("utf-8", "backslashreplace").decode()
