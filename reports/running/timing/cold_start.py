"""One call from cold: building, running and reading a case for the first time in a process, imports apart.

Each repeat is a process of its own, split off one that has imported all that the call needs and has compiled nothing. A
first call of each route says what that is: engines import late, and what they import is no part of a simulation. That
call is thrown away, unless it had nothing to import. Nothing compiled is taken from disk.
"""

from __future__ import annotations

import importlib
import os
import pickle
import select
import signal
import statistics
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from cases import compile_cache

from ..solvers import solver
from .clock import LEAST_REPEATS, Contestant, Key, calibrate, disturbed_by

# A call from cold derives and compiles; the worst of the catalogue, a measured outline, takes some thirty seconds.
_LIMIT = 60.0


class ColdStart(NamedTuple):
    """CPU seconds of a first call: building, running, reading; medians of so many repeats, and whether each of them was
    disturbed."""

    build_s: float
    run_s: float
    read_s: float
    repeats: int
    disturbed: bool

    @property
    def call_s(self) -> float:
        """The whole call."""
        return self.build_s + self.run_s + self.read_s


class _ColdRepeat(NamedTuple):
    """CPU seconds of a first build, run and read, the slower calibration loop beside them, what modules it imported."""

    build: float
    run: float
    read: float
    loop: float
    modules: tuple[str, ...]


@dataclass
class _ColdEntry:
    """A contestant and its calls so far: `spent` (wall s) is what the next one is expected to take; `importing` the
    first call of its route, if that imported modules, which makes it no repeat."""

    contestant: Contestant
    spent: float
    repeats: list[_ColdRepeat] = field(default_factory=list)
    importing: _ColdRepeat | None = None
    failure: str = ""


def first_calls(who: Sequence[Contestant], budget: float) -> dict[Key, tuple[ColdStart | None, str]]:
    """The first call of each contestant, or None and why there is none, in a sentence.

    All are repeated in turn, up to three times, the cheapest first, within about `budget` wall seconds beyond the calls
    that are made for imports. Where such a call had nothing to import, which another case's had brought before, it is a
    repeat like others. Of those that do not fit in the budget even once the first setting of a route has that call in
    any case: imports weigh nothing beside what takes so long; the others have neither.
    """
    entries = _import_all(who)
    deadline = time.perf_counter() + budget
    for turn in range(1, LEAST_REPEATS + 1):
        for entry in sorted(entries, key=lambda entry: entry.spent):
            done = len(entry.repeats) >= turn
            if done or entry.failure or time.perf_counter() + entry.spent > deadline:
                continue
            began = time.perf_counter()
            answer = _apart(_call, entry.contestant)
            entry.spent = time.perf_counter() - began
            if isinstance(answer, str):
                entry.failure = answer
            else:
                entry.repeats.append(answer)
    for entry in entries:
        if not entry.repeats and entry.importing:
            entry.repeats.append(entry.importing)
    quiet = min((r.loop for entry in entries for r in entry.repeats), default=0.0)
    return {entry.contestant.key: (_median(entry.repeats, quiet), entry.failure) for entry in entries}


def _median(repeats: Sequence[_ColdRepeat], loop: float) -> ColdStart | None:
    calm = [r for r in repeats if not disturbed_by(r.loop, loop)]
    used = calm or repeats
    if not used:
        return None
    build, run = statistics.median(r.build for r in used), statistics.median(r.run for r in used)
    return ColdStart(build, run, statistics.median(r.read for r in used), len(used), not calm)


def _import_all(who: Sequence[Contestant]) -> list[_ColdEntry]:
    """Import, in this process, what the calls import, by making one call of each route; the contestants with what that
    call says of each."""
    entries: list[_ColdEntry] = []
    of_route: dict[tuple[str, str], _ColdEntry] = {}
    for one in who:
        if first := of_route.get(one[1:3]):
            entries.append(_ColdEntry(one, max(first.spent, one.expected_s), failure=first.failure))
            continue
        began = time.perf_counter()
        answer = _apart(_call, one)
        entry = of_route[one[1:3]] = _ColdEntry(one, time.perf_counter() - began)
        entries.append(entry)
        if isinstance(answer, str):
            entry.failure = answer
            continue
        for name in answer.modules:
            with suppress(ImportError):  # some compiled modules have a name that only their package knows
                importlib.import_module(name)
        if answer.modules:
            entry.importing = answer
        else:
            entry.repeats.append(answer)
    for entry in of_route.values():
        entry.spent = max(entry.spent, entry.contestant.expected_s)
    return entries


def _call(one: Contestant) -> _ColdRepeat:
    before, loop, module = set(sys.modules), calibrate(), solver(one.solver)
    with compile_cache.off():
        marks = [time.process_time()]
        model = module.build(one.case, one.route, one.setting)
        marks.append(time.process_time())
        module.run(model)
        marks.append(time.process_time())
        # The samples are asked for: the reference makes them when they are.
        _ = module.read(model).t
        marks.append(time.process_time())
    build, run, read = (after - before for before, after in zip(marks, marks[1:], strict=False))
    # What cannot be found by its name in another process was made, not imported.
    imported = (m for m in sorted(set(sys.modules) - before) if getattr(sys.modules[m], "__spec__", None))
    return _ColdRepeat(build, run, read, max(loop, calibrate()), tuple(imported))


def _apart(function: Callable[[Any], Any], argument: Any) -> Any:
    """What the function returns in a process split off this one; a sentence if it fails there."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reading)
        try:
            signal.alarm(int(_LIMIT) + 1)
            told = pickle.dumps(function(argument))
        except BaseException as problem:  # whatever it is, this process ends here and says so
            told = pickle.dumps(f"{type(problem).__name__}: {problem}")
        with os.fdopen(writing, "wb") as pipe:
            pipe.write(told)
        os._exit(0)
    os.close(writing)
    with os.fdopen(reading, "rb") as pipe:
        told = pipe.read() if select.select([pipe], [], [], _LIMIT)[0] else b""
    if not told:
        os.kill(child, signal.SIGKILL)
    _, status = os.waitpid(child, 0)
    return (
        pickle.loads(told) if told else f"its first call ended its process, or took more than {_LIMIT:g} s ({status})"
    )
