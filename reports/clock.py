"""How long `run` of each solver takes: one process, nothing beside it, contestants in turn, again and again.

CPU time of `run` alone (time.process_time), as a median with its interquartile range. The model is built anew for each
repeat, off the clock. Contestants take turns, so that a slower clock or a neighbour's load hits all alike; each turn
begins with a loop of known work, and rows measured while that loop was slow are marked as disturbed.
"""

from __future__ import annotations

import gc
import os
import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from math import nan, sqrt
from pathlib import Path
from typing import Any, NamedTuple

from .records import CaseKey
from .trial import load, solver

# The median is known well enough when its standard error, as a part of it, is below this.
BOUND = 0.02
# No spread is told of fewer repeats; with more than so many the machine, not the count, is the limit.
LEAST_REPEATS, MOST_REPEATS = 3, 60
# A first run shorter than this is taken as warm-up: caches and lazy imports weigh in it. A longer one hardly feels
# them.
_WARM_SECONDS = 0.1
# Two timings of the same work on a quiet machine differ by a few per cent; a fifth is another load or another clock.
_DISTURBED = 1.2
# Additions in the calibration loop: about a millisecond, long against the clock's resolution, short against a run.
_CALIBRATION = 30_000


class Contestant(NamedTuple):
    """A setting of a route of a solver, and roughly how long one repeat takes (s, set-up included)."""

    solver: str
    route: str
    setting: str
    expected_s: float


@dataclass(frozen=True)
class Timing:
    """CPU and wall seconds of `run` (medians), the interquartile range of the former (NaN for fewer than three
    repeats), the longest `build` (the first, which compiles), and whether the machine was disturbed meanwhile."""

    cpu_s: float
    spread_s: float
    wall_s: float
    setup_s: float
    repeats: int
    disturbed: bool


@dataclass
class _Entry:
    contestant: Contestant
    build: Callable[[], Any]
    run: Callable[[Any], None]
    cpu: list[float] = field(default_factory=list)
    wall: list[float] = field(default_factory=list)
    setup: list[float] = field(default_factory=list)
    quiet: list[bool] = field(default_factory=list)

    @property
    def repeat_s(self) -> float:
        """What one more repeat is expected to take."""
        return self.wall[-1] + self.setup[-1] if self.wall else self.contestant.expected_s


def time_case(key: CaseKey, contestants: Sequence[Contestant], budget: float) -> dict[tuple[str, str, str], Timing]:
    """Timings of a case by (solver, route, setting), within about `budget` wall seconds, the cheapest first.

    Who does not fit in the budget even once is left out.
    """
    case, deadline = load(key), time.perf_counter() + budget
    entries = []
    for one in sorted(contestants, key=lambda c: c.expected_s):
        module = solver(one.solver)
        setting = next(s for s in module.ladder(case, one.route) if str(s) == one.setting)
        entries.append(_Entry(one, partial(module.build, case, one.route, setting), module.run))
    take_turns(entries, deadline)
    return {e.contestant[:3]: _timing(e) for e in entries if e.cpu}


def take_turns(entries: Sequence[_Entry], deadline: float) -> None:
    """Repeat all entries in turn until each median is known or `deadline` (of time.perf_counter) is near."""
    least = _calibrate()
    waiting = list(entries)
    while waiting:
        for entry in waiting:
            if time.perf_counter() + entry.repeat_s > deadline:
                continue
            before = _calibrate()
            warming = not entry.cpu
            _repeat(entry)
            after = _calibrate()
            least = min(least, before, after)
            entry.quiet.append(max(before, after) < _DISTURBED * least and not _neighbours())
            if warming and entry.cpu[-1] < _WARM_SECONDS and time.perf_counter() + entry.repeat_s < deadline:
                for record in (entry.cpu, entry.wall, entry.quiet):
                    record.clear()
                _repeat(entry)
                entry.quiet.append(_calibrate() < _DISTURBED * least and not _neighbours())
        waiting = [e for e in waiting if not known(e.cpu) and time.perf_counter() + e.repeat_s < deadline]


def known(seconds: Sequence[float]) -> bool:
    """Whether the median of these repeats is known to `BOUND`, or no more of them would help."""
    if len(seconds) < LEAST_REPEATS:
        return False
    # Standard error of a normal sample's median, its deviation taken from the quartiles: 1.253 σ/√n, σ = IQR/1.349.
    error = 0.929 * spread(seconds) / sqrt(len(seconds))
    return len(seconds) >= MOST_REPEATS or error <= BOUND * statistics.median(seconds)


def spread(seconds: Sequence[float]) -> float:
    """Interquartile range; NaN of fewer than `LEAST_REPEATS`."""
    if len(seconds) < LEAST_REPEATS:
        return nan
    low, _, high = statistics.quantiles(seconds, n=4, method="inclusive")
    return high - low


def _repeat(entry: _Entry) -> None:
    began = time.perf_counter()
    model = entry.build()
    entry.setup.append(time.perf_counter() - began)
    gc.disable()  # as the standard library's timeit does: whose garbage is collected when is chance
    try:
        cpu, wall = time.process_time(), time.perf_counter()
        entry.run(model)
        cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
    finally:
        gc.enable()
    entry.cpu.append(cpu)
    entry.wall.append(wall)


def _timing(entry: _Entry) -> Timing:
    # A run may be unlucky once; a row is disturbed if more than a quarter of its repeats were.
    disturbed = 4 * entry.quiet.count(False) > len(entry.quiet)
    cpu, wall = statistics.median(entry.cpu), statistics.median(entry.wall)
    return Timing(cpu, spread(entry.cpu), wall, max(entry.setup), len(entry.cpu), disturbed)


def _calibrate() -> float:
    """Wall seconds of a loop that is always the same work."""
    began, total = time.perf_counter(), 0
    for i in range(_CALIBRATION):
        total += i
    return time.perf_counter() - began


def _neighbours() -> bool:
    """Whether all cores but this process's are taken, now (Linux; elsewhere the calibration loop alone is asked)."""
    try:
        running = int(Path("/proc/loadavg").read_text().split()[3].partition("/")[0])
    except (OSError, ValueError, IndexError):
        return False
    return running > max(1, (os.cpu_count() or 1) - 1)
