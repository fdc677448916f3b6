"""How a run's time splits between engine, binding, callback and recording.

By differences if the adapter can omit its parts one after another (`bare_run`). Otherwise by a profile: the time in the
engine's compiled functions, without the Python code that they call back, belongs to engine and binding together, the
rest to the adapter. Both alternate with whole runs and are reported as shares of a whole run.
"""

from __future__ import annotations

import gc
import statistics
import sys
import time
from collections.abc import Callable, Sequence
from math import isnan, nan
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from adapters.interface import returns_once

from ..solvers import solver
from .clock import Contestant, Key

# Layers that a bare run omits, each in addition to the earlier ones.
LAYERS = ("notes", "callback", "binding")
_LEAST_TURNS, _MOST_TURNS = 3, 15
# Limit (CPU s) of a contestant's turns after the third: many short runs are as precise as one long run.
_SECONDS = 0.25
# Number of transitions from an engine into Python and back for the measurement of the profiler's own time.
_PASSAGES = 20_000


class TimeBreakdown(NamedTuple):
    """Shares of the CPU time of `run`; NaN if a part cannot be separated from the one before it.

    `engine`: the engine's compiled code; `binding`: Python code and conversions of the engine's package; `callback`:
    the adapter's callback with its calls of the binding; `notes`: the adapter's loop and recording."""

    engine: float
    binding: float
    callback: float
    notes: float


def parts_of_all(contestants: Sequence[Contestant], budget: float) -> dict[Key, tuple[TimeBreakdown | None, str]]:
    """The time breakdown of each contestant, or None and the reason; within about `budget` wall seconds."""
    deadline = time.perf_counter() + budget
    results: dict[Key, tuple[TimeBreakdown | None, str]] = {}
    for number, one in enumerate(sorted(contestants, key=lambda one: one.expected_s)):
        remaining = deadline - time.perf_counter()
        if (1 + len(LAYERS)) * one.expected_s > remaining:
            results[one.key] = None, "the time budget was used up before"
            continue
        try:
            # A contestant that needs more than its share of the remaining time ends after the least number of turns.
            results[one.key] = parts(one, time.perf_counter() + remaining / (len(contestants) - number)), ""
        except (Exception, SystemExit) as problem:  # the failure of one engine must not affect the others
            results[one.key] = None, f"{type(problem).__name__}: {problem}"
    return results


def parts(one: Contestant, deadline: float) -> TimeBreakdown | None:
    """The time breakdown of a contestant's run, by the deadline or after the least number of turns.

    None if the run contains no compiled engine."""
    module = solver(one.solver)
    if hasattr(module, "bare_run"):
        return by_difference(module, one, deadline)
    return by_profile(module, one, deadline)


def by_difference(module: ModuleType, one: Contestant, deadline: float) -> TimeBreakdown:
    """Alternate whole and bare runs: the share of an omitted layer is the difference of their times."""

    def ready(without: str) -> Callable[[], None]:
        if without:
            return returns_once(module.bare_run(one.case, one.route, one.setting, without))
        model = module.build(one.case, one.route, one.setting)
        return lambda: module.run(model)

    seconds = _in_turns([lambda w=w: _cpu(ready(w)) for w in ("", *LAYERS)], deadline)  # type: ignore[misc]
    whole, without_notes, without_callback, bare = (statistics.median(duration) for duration in seconds)
    # Differences of nearly equal times can be negative.
    differences = (bare, without_callback - bare, without_notes - without_callback, whole - without_notes)
    return TimeBreakdown(*(max(0.0, part) / whole for part in differences))


def by_profile(module: ModuleType, one: Contestant, deadline: float) -> TimeBreakdown | None:
    """Alternate whole and profiled runs. The profiler slows down the adapter's part only, so that part is the rest."""
    package = str(getattr(module, "ENGINE", module.NAME))

    def whole() -> float:
        model = module.build(one.case, one.route, one.setting)
        return _cpu(lambda: module.run(model))

    def profile() -> float:
        model = module.build(one.case, one.route, one.setting)
        return engine_seconds(package, lambda: module.run(model))

    if isnan(profile()):
        return None
    duration, engine = (statistics.median(s) for s in _in_turns([whole, profile], deadline))
    if engine == 0.0:
        return None
    share = min(engine / duration, 1.0)
    return TimeBreakdown(share, nan, 1.0 - share, nan)


def _in_turns(measures: Sequence[Callable[[], float]], deadline: float) -> list[list[float]]:
    """The measurements of each function, turn by turn; the first turn, which imports modules, does not count."""
    turns: list[list[float]] = []
    while len(turns) <= _LEAST_TURNS or (
        len(turns) < _MOST_TURNS and sum(map(sum, turns)) < _SECONDS and time.perf_counter() < deadline
    ):
        turns.append([measure() for measure in measures])
    return [list(column) for column in zip(*turns[1:], strict=True)]


def _cpu(run: Callable[[], None]) -> float:
    gc.disable()
    try:
        began = time.process_time()
        run()
        return time.process_time() - began
    finally:
        gc.enable()


def engine_seconds(package: str, run: Callable[[], None]) -> float:
    """Seconds of a run in compiled functions of a package, without Python code they call back; NaN if it calls none."""
    stays = _BorderProfiler(package)
    sys.setprofile(stays)
    try:
        run()
    finally:
        sys.setprofile(None)
    return stays.seconds()


class _BorderProfiler:
    """A profiler that records entry and exit of a package's compiled functions, and their calls of Python."""

    def __init__(self, package: str):
        self.package = package
        self.stays: list[float] = []  # durations of the stays inside the engine, s
        self.outer: Any = None  # the engine's running function
        self.depth = 0  # of Python functions called by it
        self.since = 0.0  # CPU time, so that other processes do not count

    def __call__(self, frame: Any, event: str, function: Any) -> None:
        now = time.thread_time()
        if self.outer is None:
            if event == "c_call" and self._is_engine(function):
                self.outer, self.since = function, time.thread_time()
        elif event in ("call", "return"):
            if event == "call":
                if self.depth == 0:
                    self.stays.append(now - self.since)
                self.depth += 1
            else:
                self.depth -= 1
                if self.depth == 0:
                    self.since = time.thread_time()
        elif self.depth == 0 and event in ("c_return", "c_exception"):
            self.stays.append(now - self.since)
            self.outer = None

    def _is_engine(self, function: Any) -> bool:
        owner = getattr(function, "__self__", None)
        modules = (getattr(function, "__module__", None), owner.__name__ if isinstance(owner, ModuleType) else None,
                   type(owner).__module__)  # fmt: skip
        return any(str(m or "").lower().startswith(self.package) for m in modules)

    def seconds(self) -> float:
        """The sum of the stays, without the profiler's own time in each; NaN if there are none."""
        return max(0.0, sum(self.stays) - len(self.stays) * _own_seconds()) if self.stays else nan


def _own_seconds() -> float:
    """The profiler's own time per stay, measured on an engine that takes no time."""
    stays = _BorderProfiler("")
    nothing = abs
    for _ in range(_PASSAGES // 10):
        stays(None, "c_call", nothing)
        stays(None, "c_return", nothing)
    return float(np.median(stays.stays))
