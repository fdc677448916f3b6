"""A cluster's worker: what it says of itself, and the calls it makes, in processes of its own as on any machine.

So a call that crashes, hangs or floods is the same row here and there, and ends no worker of the cluster.
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

from ..solvers import version
from ..storage import fingerprint, source_code
from .worker_process import CallResult
from .workers import WorkerPool

# What a machine says of itself: names and values.
Identity = tuple[tuple[str, str], ...]
PROCESSOR = "processor"

# A worker is one core: what of it has several threads takes turns.
_ONE = threading.Lock()
# Set once this process has said what it is.
_said = threading.Event()


class UnknownWorker(Exception):
    """A worker that has not said what it is: it came in the place of one that had."""


def identity(versions: Mapping[str, str], files: Sequence[str] = ()) -> Identity:
    """What decides the answers of a machine: its packages, processor and code, the versions of solvers as it has told
    them, and case files."""
    import reference  # not by a worker itself, which would hold what its process holds

    around = fingerprint.surroundings()
    told = {"python": around["python"], PROCESSOR: fingerprint.processor(), **around["packages"]}
    told |= {"method of the reference": reference.METHODS[0], "code of the suite": _suite(), **versions}
    return tuple(sorted((told | {f"the file {file}": _digest(Path(file)) for file in files}).items()))


def difference(mine: Identity, ask_identity: Identity) -> str:
    """What of a machine is not what was asked for, in a phrase; "" if it is the same."""
    here = dict(mine)
    others = [(name, here.get(name, "unknown"), value) for name, value in ask_identity if here.get(name) != value]
    return "; ".join(f"{name} is {own}, not {value}" for name, own, value in others)


@lru_cache(maxsize=1)
def _suite() -> str:
    """The code of the suite, in a few letters."""
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
    """The identity of this machine, or in a phrase why it has none."""
    with _ONE:
        said = dict(_own().run(version, [(name,) for name in solvers]))
        for i, answer in said.items():
            if answer.outcome != "done":
                return f"{solvers[i]} does not say its version ({answer.reason})"
        versions = {solvers[i]: answer.value for i, answer in said.items()}
        ((_, whole),) = _own().run(identity, [(versions, files)])
    if whole.outcome != "done":
        return f"it has not all of the suite ({whole.reason})"
    _said.set()
    return whole.value


def make(call: bytes, limit: float, group: str) -> CallResult:
    """The answer to a pickled function and its arguments; its value is pickled. Raises Unasked."""
    with _ONE:
        if not _said.is_set():
            raise UnknownWorker
        ((_, answer),) = _own().run(call_pickled, [(_PickledCall(call),)], limit, groups=[group])
    return answer


class _PickledCall:
    """A pickled call on its way: it arrives as what it holds, so that nobody before loads what it names."""

    def __init__(self, call: bytes):
        self.call = call

    def __reduce__(self):
        return pickle.loads, (self.call,)


def call_pickled(call: tuple[Callable, tuple]) -> bytes:
    """The pickled value of a function and its arguments, in the process that makes the call."""
    function, arguments = call
    return pickle.dumps(function(*arguments))


@lru_cache(maxsize=1)
def _own() -> WorkerPool:
    # A worker that has a nanny is a daemon, which may start no processes lest they outlive it: these end with it.
    multiprocessing.current_process().daemon = False
    return WorkerPool(1)
