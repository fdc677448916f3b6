"""Measures cold starts: the first building, running and reading of a case in a process, without imports.

Each repeat is a child process, forked from one that has imported all modules of the call and has compiled nothing. A
first call of each route, which is discarded, shows which modules these are: engines import late, and imports are not
part of a simulation.
"""

from __future__ import annotations

import importlib
import statistics
import sys
import time
from collections.abc import Sequence
from contextlib import suppress
from typing import NamedTuple

from adapters.processes.worker import call_in_copy

from ..solvers import solver
from .clock import LEAST_REPEATS, Contestant, Key, calibrate, is_slow_loop

# Time limit of a cold start, s. It derives and compiles; the slowest of the catalogue, a measured outline, takes 30 s.
_LIMIT = 60.0


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


def first_calls(contestants: Sequence[Contestant], budget: float) -> dict[Key, tuple[ColdStart | None, str]]:
    """Measure the cold start of each contestant; returns it, or None and the reason of its failure.

    All are repeated in turn, up to three times, the cheapest first, within about `budget` wall seconds in addition to
    one call of each route, whose imports are made here. What does not fit has neither a result nor a reason.
    """
    repeats: dict[Key, list[_ColdRepeat]] = {one.key: [] for one in contestants}
    seconds, failures = dict[tuple, float](), dict[tuple, str]()  # of the last call of each route; of routes and keys

    def call(one: Contestant, failing: tuple) -> _ColdRepeat | None:
        began = time.perf_counter()
        answer = call_in_copy(_call, one, _LIMIT)
        seconds[one[1:3]] = time.perf_counter() - began
        if answer.outcome != "done":
            failures[failing] = answer.reason
        return answer.value

    def failure(one: Contestant) -> str:
        return failures.get(one[1:3]) or failures.get(one.key, "")

    for one in contestants:
        if one[1:3] not in seconds and (answer := call(one, one[1:3])):
            for name in answer.modules:
                with suppress(ImportError):  # some compiled modules can be imported only by their package
                    importlib.import_module(name)
    deadline = time.perf_counter() + budget
    for one in LEAST_REPEATS * sorted(contestants, key=lambda one: one.expected_s):
        is_late = time.perf_counter() + max(seconds[one[1:3]], one.expected_s) > deadline
        if not failure(one) and not is_late and (answer := call(one, one.key)):
            repeats[one.key].append(answer)
    quiet = min((r.loop for some in repeats.values() for r in some), default=0.0)
    return {one.key: (_median(repeats[one.key], quiet), failure(one)) for one in contestants}


def _median(repeats: Sequence[_ColdRepeat], loop: float) -> ColdStart | None:
    calm = [r for r in repeats if not is_slow_loop(r.loop, loop)]
    used = calm or repeats
    if not used:
        return None
    build, run = statistics.median(r.build for r in used), statistics.median(r.run for r in used)
    return ColdStart(build, run, statistics.median(r.read for r in used), len(used), not calm)


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
