"""Measures cold starts: the first building, running and reading of a case in a process, without imports.

Each repeat is a child process, forked from one that has imported all modules of the call and has compiled nothing. A
first call of each route shows which modules these are: engines import late, and imports are not part of a simulation.
That call is discarded unless it imported nothing.
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

from ..solvers import solver
from .clock import LEAST_REPEATS, Contestant, Key, calibrate, is_slow_loop

# Time limit of a cold start, s. It derives and compiles; the slowest of the catalogue, a measured outline, takes 30 s.
_LIMIT = 60.0

# s. Imports take up to half a second of CPU time (SciPy's integrators): less than a tenth of a longer call. A shorter
# call that imported modules is repeated without them, whatever is left of the budget.
_LONG = 5.0


class ColdStart(NamedTuple):
    """CPU seconds of a cold start: building, running and reading; medians of `repeats`, and whether all of them were
    disturbed."""

    build_s: float
    run_s: float
    read_s: float
    repeats: int
    disturbed: bool

    @property
    def call_s(self) -> float:
        """CPU seconds of the whole call."""
        return self.build_s + self.run_s + self.read_s


class _ColdRepeat(NamedTuple):
    """CPU seconds of a first build, run and read, time of the slower calibration loop, and the modules it imported."""

    build: float
    run: float
    read: float
    loop: float
    modules: tuple[str, ...]

    @property
    def call(self) -> float:
        """CPU seconds of the whole call."""
        return self.build + self.run + self.read


@dataclass
class _ColdEntry:
    """A contestant and its calls so far.

    `next_call_s`: expected wall time of the next call; `importing`: the first call of its route if that imported
    modules, in which case it is not a repeat."""

    contestant: Contestant
    next_call_s: float
    repeats: list[_ColdRepeat] = field(default_factory=list)
    importing: _ColdRepeat | None = None
    failure: str = ""


def first_calls(contestants: Sequence[Contestant], budget: float) -> dict[Key, tuple[ColdStart | None, str]]:
    """Measure the cold start of each contestant; returns it, or None and the reason of its failure.

    All are repeated in turn, up to three times, the cheapest first, within about `budget` wall seconds in addition to
    the calls made for imports. If such a call imported nothing, because an earlier call had, it counts as a repeat. If
    no repeat fits into the budget, the first setting of a route is repeated once if its importing call was short, and
    uses that call if it was long, because imports are negligible there; the other settings have neither a result nor a
    reason.
    """
    entries = _import_all(contestants)
    deadline = time.perf_counter() + budget
    for turn in range(1, LEAST_REPEATS + 1):
        for entry in sorted(entries, key=lambda entry: entry.next_call_s):
            is_done = len(entry.repeats) >= turn
            is_needed = turn == 1 and entry.importing is not None and entry.importing.call < _LONG
            is_late = time.perf_counter() + entry.next_call_s > deadline
            if is_done or entry.failure or (is_late and not is_needed):
                continue
            began = time.perf_counter()
            answer = _in_child(_call, entry.contestant)
            entry.next_call_s = time.perf_counter() - began
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
    calm = [r for r in repeats if not is_slow_loop(r.loop, loop)]
    used = calm or repeats
    if not used:
        return None
    build, run = statistics.median(r.build for r in used), statistics.median(r.run for r in used)
    return ColdStart(build, run, statistics.median(r.read for r in used), len(used), not calm)


def _import_all(contestants: Sequence[Contestant]) -> list[_ColdEntry]:
    """Import the modules of the calls into this process, by one call of each route; returns an entry per contestant."""
    entries: list[_ColdEntry] = []
    of_route: dict[tuple[str, str], _ColdEntry] = {}
    for one in contestants:
        if first := of_route.get(one[1:3]):
            entries.append(_ColdEntry(one, max(first.next_call_s, one.expected_s), failure=first.failure))
            continue
        began = time.perf_counter()
        answer = _in_child(_call, one)
        entry = of_route[one[1:3]] = _ColdEntry(one, time.perf_counter() - began)
        entries.append(entry)
        if isinstance(answer, str):
            entry.failure = answer
            continue
        for name in answer.modules:
            with suppress(ImportError):  # some compiled modules can be imported only by their package
                importlib.import_module(name)
        if answer.modules:
            entry.importing = answer
        else:
            entry.repeats.append(answer)
    for entry in of_route.values():
        entry.next_call_s = max(entry.next_call_s, entry.contestant.expected_s)
    return entries


def _call(one: Contestant) -> _ColdRepeat:
    before, loop, module = set(sys.modules), calibrate(), solver(one.solver)
    marks = [time.process_time()]
    model = module.build(one.case, one.route, one.setting)
    marks.append(time.process_time())
    module.run(model)
    marks.append(time.process_time())
    # Access to the samples is timed too: the reference computes them on access.
    _ = module.read(model).t
    marks.append(time.process_time())
    build, run, read = (after - before for before, after in zip(marks, marks[1:], strict=False))
    # A module without a spec was created at run time, not imported.
    new_modules = (m for m in sorted(set(sys.modules) - before) if getattr(sys.modules[m], "__spec__", None))
    return _ColdRepeat(build, run, read, max(loop, calibrate()), tuple(new_modules))


def _in_child(function: Callable[[Any], Any], argument: Any) -> Any:
    """Call the function in a forked child process; returns its result, or a sentence if it fails there."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reading)
        try:
            signal.alarm(int(_LIMIT) + 1)
            message = pickle.dumps(function(argument))
        except BaseException as problem:  # the child must end here and report any failure
            message = pickle.dumps(f"{type(problem).__name__}: {problem}")
        with os.fdopen(writing, "wb") as pipe:
            pipe.write(message)
        os._exit(0)
    os.close(writing)
    with os.fdopen(reading, "rb") as pipe:
        message = pipe.read() if select.select([pipe], [], [], _LIMIT)[0] else b""
    if not message:
        os.kill(child, signal.SIGKILL)
    _, status = os.waitpid(child, 0)
    return (
        pickle.loads(message)
        if message
        else f"its first call ended its process, or took more than {_LIMIT:g} s ({status})"
    )
