"""A cluster's worker: its identity, and its calls, which run in separate processes as on this machine.

A call that crashes, hangs or floods its output gives the same row as on this machine and does not end the cluster's
worker.
"""

from __future__ import annotations

import hashlib
import multiprocessing
import pickle
import threading
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from importlib import import_module
from pathlib import Path

from adapters.processes.pool import WorkerPool
from adapters.processes.worker import CallResult, NextCall, without_engines

from .solvers import pool, version
from .storage import fingerprint, source_code

# Names and values that decide the answers of a machine.
Identity = tuple[tuple[str, str], ...]
PROCESSOR = "processor"

# A worker is one core: its threads run one at a time.
_ONE = threading.Lock()
# Set when this process has sent its identity.
_ready = threading.Event()


class UnknownWorker(Exception):
    """The worker has not sent its identity: it replaced one that had."""


def identity(versions: Mapping[str, str], files: Sequence[str] = ()) -> Identity:
    """The identity of this machine: its packages, processor and code, the versions of the solvers, and case files."""
    import reference  # here, so that the worker process itself stays small

    around = fingerprint.surroundings()
    facts = {"python": around["python"], PROCESSOR: fingerprint.processor(), **around["packages"]}
    facts |= {"method of the reference": reference.METHODS[0], "code of the suite": _suite(), **versions}
    return tuple(sorted((facts | {f"the file {file}": _digest(Path(file)) for file in files}).items()))


def difference(mine: Identity, theirs: Identity) -> str:
    """How an identity differs from the required one (`theirs`), as a phrase; "" if they are equal."""
    here = dict(mine)
    others = [(name, here.get(name, "unknown"), value) for name, value in theirs if here.get(name) != value]
    return "; ".join(f"{name} is {own}, not {value}" for name, own, value in others)


@lru_cache(maxsize=1)
def _suite() -> str:
    """A short digest of the suite's code and of the stored truths."""
    rooms = [Path(place) for room in source_code.SUITE for place in import_module(room).__path__]
    files = [(str(file.relative_to(room.parent)), file) for room in rooms for file in sorted(room.rglob("*.py"))]
    return fingerprint.digest([fingerprint.truth_key(), *((name, _digest(file)) for name, file in files)])[:16]


def _digest(file: Path) -> str:
    try:
        return hashlib.sha256(file.read_bytes()).hexdigest()[:16]
    except OSError as problem:
        return f"not to be read ({problem.strerror})"


# --- on the worker ----------------------------------------------------------------------------------------------------


def ask_identity(solvers: tuple[str, ...], files: tuple[str, ...]) -> Identity | str:
    """The identity of this machine, or the reason why it has none."""
    with _ONE:
        answers = dict(_own().run(version, [(name,) for name in solvers]))
        for i, answer in answers.items():
            if answer.outcome != "done":
                return f"{solvers[i]} does not report its version ({answer.reason})"
        versions = {solvers[i]: answer.value for i, answer in answers.items()}
        whole = _own().call(identity, versions, files)
    if whole.outcome != "done":
        return f"the suite is incomplete ({whole.reason})"
    _ready.set()
    return whole.value


def make(call: bytes, limit: float, group: str) -> CallResult:
    """Make a pickled call; the answer's value is pickled. Raises UnknownWorker if the identity was not requested."""
    with _ONE:
        if not _ready.is_set():
            raise UnknownWorker
        ((_, answer),) = _own().run(run_pickle, [(_PickledCall(call),)], limit, groups=[group])
    return answer


class _PickledCall:
    """A pickled call as an argument: it is unpickled only in the process that makes the call."""

    def __init__(self, call: bytes):
        self.call = call

    def __reduce__(self):
        return pickle.loads, (self.call,)


def run_pickle(call: tuple[Callable, tuple]) -> bytes:
    """Make the call in this process; returns the pickled value."""
    function, arguments = call
    value = function(*arguments)
    if isinstance(value, NextCall):
        return without_engines(run_pickle, (value.function, value.arguments))
    return pickle.dumps(value)


@lru_cache(maxsize=1)
def _own() -> WorkerPool:
    # A worker with a nanny is a daemon, which may not start processes that might outlive it. These end with it.
    multiprocessing.current_process().daemon = False
    return pool(1)
