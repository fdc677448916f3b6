"""Whose time a run takes: the engine's, its binding's, that of our callback in it, or that of our taking notes.

By difference, where an adapter can leave its parts out one after the other (`bare_run`); else by profile: the time in
the engine's own compiled functions, without the Python that they call back, is the engine's and its binding's together,
and the rest is ours. Both are measured beside whole runs, in turn, and told as shares of one.
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

# What a bare run leaves out, each in addition to those before it.
LAYERS = ("notes", "callback", "binding")
_LEAST_TURNS, _MOST_TURNS = 3, 15
# Many short runs tell as much as one long: no more than this (CPU s) is spent on a contestant's turns after the third.
_SECONDS = 0.25
# Passages from an engine into Python and back by which the profiler's own time is measured.
_PASSAGES = 20_000


class TimeBreakdown(NamedTuple):
    """Shares of the CPU time of `run`, NaN where a part cannot be told from the one before it: the engine's compiled
    code; its binding (Python and conversions of the engine's package); our callback, with what it asks of the binding;
    our loop and its notes."""

    engine: float
    binding: float
    callback: float
    notes: float


def parts_of_all(who: Sequence[Contestant], budget: float) -> dict[Key, tuple[TimeBreakdown | None, str]]:
    """The parts of each contestant's run, or None and why they are not known; within about `budget` wall s."""
    deadline = time.perf_counter() + budget
    found: dict[Key, tuple[TimeBreakdown | None, str]] = {}
    for number, one in enumerate(sorted(who, key=lambda one: one.expected_s)):
        left = deadline - time.perf_counter()
        if (1 + len(LAYERS)) * one.expected_s > left:
            found[one.key] = None, "the time budget did not reach it"
            continue
        try:
            # A contestant that needs more than its share of the remaining time ends after the least turns.
            found[one.key] = parts(one, time.perf_counter() + left / (len(who) - number)), ""
        except (Exception, SystemExit) as problem:  # an engine that fails now and then loses its parts, not everyone's
            found[one.key] = None, f"{type(problem).__name__}: {problem}"
    return found


def parts(one: Contestant, deadline: float) -> TimeBreakdown | None:
    """The parts of a contestant's run, by the deadline or after the least turns; None where no compiled engine has a
    part in it."""
    module = solver(one.solver)
    if hasattr(module, "bare_run"):
        return by_difference(module, one, deadline)
    return by_profile(module, one, deadline)


def by_difference(module: ModuleType, one: Contestant, deadline: float) -> TimeBreakdown:
    """Whole runs in turn with bare ones: what each is cheaper by is the share of what it is without."""

    def ready(without: str) -> Callable[[], None]:
        if without:
            return returns_once(module.bare_run(one.case, one.route, one.setting, without))
        model = module.build(one.case, one.route, one.setting)
        return lambda: module.run(model)

    seconds = _in_turns([lambda w=w: _cpu(ready(w)) for w in ("", *LAYERS)], deadline)  # type: ignore[misc]
    whole, unnoted, hollow, bare = (statistics.median(taken) for taken in seconds)
    # Differences of nearly equal times may come out below nothing.
    told = (bare, hollow - bare, unnoted - hollow, whole - unnoted)
    return TimeBreakdown(*(max(0.0, part) / whole for part in told))


def by_profile(module: ModuleType, one: Contestant, deadline: float) -> TimeBreakdown | None:
    """Whole runs in turn with profiled ones. Python's profiler slows down our part alone, so that ours is the rest."""
    package = str(getattr(module, "ENGINE", module.NAME))

    def whole() -> float:
        model = module.build(one.case, one.route, one.setting)
        return _cpu(lambda: module.run(model))

    def profiled() -> float:
        model = module.build(one.case, one.route, one.setting)
        return engine_seconds(package, lambda: module.run(model))

    if isnan(profiled()):
        return None
    taken, engine = (statistics.median(s) for s in _in_turns([whole, profiled], deadline))
    if engine == 0.0:
        return None
    share = min(engine / taken, 1.0)
    return TimeBreakdown(share, nan, 1.0 - share, nan)


def _in_turns(measures: Sequence[Callable[[], float]], deadline: float) -> list[list[float]]:
    """What each measures, turn by turn; the first turn, in which things are imported, does not count."""
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
    """Seconds of a run in compiled functions of a package, without the Python they call back; NaN if it calls none."""
    stays = _BorderProfiler(package)
    sys.setprofile(stays)
    try:
        run()
    finally:
        sys.setprofile(None)
    return stays.seconds()


class _BorderProfiler:
    """A profiler that notes when a compiled function of a package is entered and left, and when it calls Python."""

    def __init__(self, package: str):
        self.package = package
        self.stays: list[float] = []  # seconds between two passages of the engine's border, within the engine
        self.outer: Any = None  # the engine's function that runs
        self.depth = 0  # of Python functions within it
        self.since = 0.0  # CPU time: a neighbour's share of the processor is no part of it

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
        """The stays together, without the profiler's own time in each; NaN if there is none."""
        return max(0.0, sum(self.stays) - len(self.stays) * _own_seconds()) if self.stays else nan


def _own_seconds() -> float:
    """What two passages of the profiler add to a stay: that of an engine which takes no time."""
    stays = _BorderProfiler("")
    nothing = abs
    for _ in range(_PASSAGES // 10):
        stays(None, "c_call", nothing)
        stays(None, "c_return", nothing)
    return float(np.median(stays.stays))
