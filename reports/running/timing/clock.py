"""Measures the CPU time of `run` of each solver: in one process, without other load, contestants in turn.

Only `run` is measured (time.process_time). Each run has a new model, whose build is not timed. Contestants take turns,
so that a slower processor clock or other load affects all of them equally; cheap ones repeat before each expensive one,
which costs almost nothing and spreads their repeats over the whole time. A long run soon has its code and data in the
processor's caches. A short one would mainly measure cold caches, so it is run once untimed and then several times in a
row. A calibration loop of fixed work runs before and after each repeat. A repeat is disturbed if its loop was slow, if
other processes were running, or if it waited for the processor. Medians are of the undisturbed repeats; a contestant
with too few of them is marked and not ranked.
"""

from __future__ import annotations

import gc
import os
import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from math import ceil, isnan, nan, sqrt
from pathlib import Path
from typing import Any, NamedTuple

from adapters import Setting
from adapters.processes.worker import reap
from cases import Case
from cases.errors import legible

from ..clocked_run import engine_code
from ..solvers import solver

# The median is precise enough if its relative standard error is below this.
BOUND = 0.02
# Fewest repeats for an interval; beyond the largest count the machine limits the precision.
LEAST_REPEATS, MOST_REPEATS = 3, 60
# With fewer repeats, quantiles are no better than the extremes, which are reported instead: the extremes of six repeats
# contain the median with a probability of 97 %, those of five with 94 %.
_QUANTILES_FROM = 6
# Two processes with the same work take systematically different times, because their memory layouts differ. Medians of
# thirty repeats deviate by 1.3 to 2.9 % between processes (24 settings of three solvers, ten processes; one of them by
# 12 %). With this least half-width of intervals, 99.9 % of the ratios of two processes agree; without it 98 %.
_PROCESS = 0.03
# The time of reading is not ranked by itself, so the fewest repeats suffice.
_MOST_READS = LEAST_REPEATS
# A first run shorter than this is discarded: it may contain late imports.
_FIRST_SECONDS = 0.03
# Runs shorter than this get a warm-up run, because cold caches cost about 0.2 ms.
_SHORT_SECONDS = 1e-2
# Duration (s) and largest number of short runs in a row; each run needs its own model.
_ROW_SECONDS, _ROW_RUNS = 1e-3, 16
# Two timings of the same work on a quiet machine differ by a few per cent, not by a fifth.
_DISTURBANCE_RATIO = 1.2
# Shortest wait that counts: a switch to the kernel and back between two readings of the clocks takes less.
_SWITCH_SECONDS = 5e-4
# Additions in the calibration loop: about a millisecond, long against the clock's resolution, short against a run.
_CALIBRATION = 30_000
# The undisturbed loop time is this quantile of all loops: the fastest may be a short boost of the clock rate.
_QUIET_SHARE = 0.1
# Repeats up to this duration, including set-up, are cheap: twenty of them take half a second.
_CHEAP_SECONDS = 0.025


# Key of a contestant: the case's label, the solver, the route, the setting.
Key = tuple[str, str, str, Setting]


class Contestant(NamedTuple):
    """A setting of a route of a solver on a case, and roughly how long one repeat takes (s, set-up included)."""

    case: Case
    solver: str
    route: str
    setting: Setting
    expected_s: float

    @property
    def key(self) -> Key:
        """The contestant's key in every result; results are never matched by their order."""
        return self.case.label, self.solver, self.route, self.setting


@dataclass(frozen=True)
class Timing:
    """The timing of a setting, in seconds.

    `cpu_s`, `wall_s`: medians of `run` over the undisturbed repeats (over all repeats if fewer than `LEAST_REPEATS` are
    undisturbed; `disturbed` is then set). [cpu_low_s, cpu_high_s]: first to last decile of the CPU time (for few
    repeats, least to greatest), at least 3 % to each side, by which processes differ; NaN for fewer than three repeats.
    Further CPU times: `setup_s`, median of `build`; `compile_s`, additional time of the first `build` (imports,
    derivation, compilation; what several settings share is counted for the first of them); `read_s` of `read`.
    `repeats`: number of repeats in the medians; `disturbed_repeats`: number of discarded ones.
    """

    cpu_s: float
    cpu_low_s: float
    cpu_high_s: float
    wall_s: float
    setup_s: float
    compile_s: float
    read_s: float
    call_s: float
    repeats: int
    disturbed_repeats: int
    disturbed: bool


NO_TIMING = Timing(*8 * (nan,), repeats=0, disturbed_repeats=0, disturbed=False)


class Repeat(NamedTuple):
    """One repeat: CPU and wall time of a `run` (mean of the runs in a row), the slower of the calibration loops before
    and after it, whether other processes were running, and the CPU time of reading (NaN if not measured). Seconds."""

    cpu: float
    wall: float
    loop: float
    beside_others: bool
    read: float = nan


@dataclass
class ClockEntry:
    """A contestant with its functions and its measurements so far."""

    contestant: Contestant
    build: Callable[[], Any]
    run: Callable[[Any], None]
    read: Callable[[Any], Any] = lambda model: None
    repeats: list[Repeat] = field(default_factory=list)
    setup: list[float] = field(default_factory=list)
    run_s: float = 0.0  # wall time of the last build and run
    failure: str = ""

    @property
    def repeat_s(self) -> float:
        """Expected wall time of one more repeat, s."""
        if not self.repeats:
            return self.contestant.expected_s
        return (self.warm_ups + self.row) * self.run_s

    @property
    def warm_ups(self) -> int:
        """Number of untimed runs before a repeat."""
        return int(bool(self.repeats) and self.repeats[-1].cpu < _SHORT_SECONDS)

    @property
    def row(self) -> int:
        """Number of runs in a row in a repeat."""
        if not self.repeats:
            return 1
        return max(1, min(_ROW_RUNS, ceil(_ROW_SECONDS / max(self.repeats[-1].cpu, 1e-9))))

    def new_model(self) -> Any:
        """Build a model and record the CPU time."""
        start = time.process_time()
        model = self.build()
        self.setup.append(time.process_time() - start)
        return model

    def quiet_repeats(self, loop: float) -> list[Repeat]:
        """The undisturbed repeats; `loop`: undisturbed time of the calibration loop, s."""
        return [r for r in self.repeats if not is_disturbed(r, loop)]


def is_disturbed(repeat: Repeat, loop: float) -> bool:
    """Whether other load disturbed a repeat; `loop`: undisturbed time of the calibration loop, s."""
    has_waited = repeat.wall > _DISTURBANCE_RATIO * repeat.cpu + _SWITCH_SECONDS
    return has_waited or repeat.beside_others or is_slow_loop(repeat.loop, loop)


def is_slow_loop(seconds: float, loop: float) -> bool:
    """Whether a calibration loop of `seconds` was disturbed; `loop`: its undisturbed time, s."""
    return seconds > _DISTURBANCE_RATIO * loop


def time_all(contestants: Sequence[Contestant], budget: float) -> dict[Key, tuple[Timing | None, str]]:
    """Time all contestants; returns each one's timing, or None and the reason of its failure.

    They take turns, the cheapest first, within about `budget` wall seconds after the imports. A contestant that does
    not fit into the budget once has neither a timing nor a reason.
    """
    entries = [_entry(one) for one in contestants]
    in_turn = sorted(entries, key=lambda entry: entry.contestant.expected_s)
    for first in {e.contestant[1:3]: e for e in reversed(in_turn)}.values():
        _import(first)
    loop = take_turns(in_turn, time.perf_counter() + budget)
    return {e.contestant.key: (timing(e, loop) if e.repeats else None, e.failure) for e in entries}


def _entry(one: Contestant) -> ClockEntry:
    module = solver(one.solver)
    return ClockEntry(one, partial(module.build, one.case, one.route, one.setting), module.run, module.read)


@engine_code()
def _import(entry: ClockEntry) -> None:
    """Build once before the budget starts: importing an engine takes seconds with a cold disk cache."""
    try:
        entry.new_model()
    except (Exception, SystemExit) as problem:
        entry.failure = legible(f"{type(problem).__name__}: {problem}")


def take_turns(entries: Sequence[ClockEntry], deadline: float) -> float:
    """Repeat all entries in turn until each median is precise or `deadline` (of time.perf_counter) is near.

    Returns the undisturbed time of the calibration loop, s."""
    loops = [calibrate()]

    def fits(entry: ClockEntry) -> bool:
        return not entry.failure and time.perf_counter() + entry.repeat_s < deadline

    def turn(entry: ClockEntry) -> None:
        if not fits(entry):
            return
        first = not entry.repeats
        _repeat(entry, loops)
        if first and entry.repeats and entry.repeats[0].cpu < _FIRST_SECONDS and fits(entry):
            _repeat(entry, loops)
            if not entry.failure:
                del entry.repeats[0]

    def remaining() -> list[ClockEntry]:
        loop = _without_disturbance(loops)
        return [e for e in entries if fits(e) and not _enough(e, loop)]

    waiting = remaining()
    while waiting:
        for entry in waiting:
            if entry.repeat_s > _CHEAP_SECONDS:
                for cheap in remaining():
                    if cheap.repeats and cheap.repeat_s <= _CHEAP_SECONDS:
                        turn(cheap)
            turn(entry)
        waiting = remaining()
    return _without_disturbance(loops)


def _enough(entry: ClockEntry, loop: float) -> bool:
    return len(entry.repeats) >= MOST_REPEATS or is_precise([r.cpu for r in entry.quiet_repeats(loop)])


def is_precise(seconds: Sequence[float]) -> bool:
    """Whether the median of these repeats is known to `BOUND`, or their number is at its limit."""
    if len(seconds) < LEAST_REPEATS:
        return False
    low, high = _middle(seconds, 4)
    # Standard error of a normal sample's median, its deviation taken from the quartiles: 1.253 σ/√n, σ = IQR/1.349.
    error = 0.929 * (high - low) / sqrt(len(seconds))
    return len(seconds) >= MOST_REPEATS or error <= BOUND * statistics.median(seconds)


def interval(seconds: Sequence[float]) -> tuple[float, float]:
    """Interval expected for the median of another process; NaN for fewer than `LEAST_REPEATS`."""
    if len(seconds) < LEAST_REPEATS:
        return nan, nan
    low, high = _middle(seconds, 10)
    median = statistics.median(seconds)
    return min(low, (1.0 - _PROCESS) * median), max(high, (1.0 + _PROCESS) * median)


def _middle(seconds: Sequence[float], parts: int) -> tuple[float, float]:
    """First and last of the quantiles that divide the values into `parts`; the extremes if there are few values."""
    if len(seconds) < _QUANTILES_FROM:
        return min(seconds), max(seconds)
    cuts = statistics.quantiles(seconds, n=parts, method="inclusive")
    return cuts[0], cuts[-1]


def timing(entry: ClockEntry, loop: float) -> Timing:
    """The timing from an entry's repeats; `loop`: undisturbed time of the calibration loop, s."""
    quiet = entry.quiet_repeats(loop)
    few = len(quiet) < LEAST_REPEATS
    used = entry.repeats if few else quiet
    setup = statistics.median(entry.setup[1:] or entry.setup)
    # Other load disturbs reading like running, so the same repeats count, if reading was measured in one of them.
    reads = [r.read for r in used if not isnan(r.read)] or [r.read for r in entry.repeats if not isnan(r.read)]
    cpu, read = statistics.median(r.cpu for r in used), statistics.median(reads) if reads else nan
    low, high = interval([r.cpu for r in used])
    return Timing(
        cpu_s=cpu,
        cpu_low_s=low,
        cpu_high_s=high,
        wall_s=statistics.median(r.wall for r in used),
        setup_s=setup,
        compile_s=max(0.0, entry.setup[0] - setup) if len(entry.setup) > 1 else nan,
        read_s=read,
        call_s=setup + cpu + read,
        repeats=len(used),
        disturbed_repeats=len(entry.repeats) - len(quiet),
        disturbed=few and len(quiet) < len(entry.repeats),
    )


@engine_code()
def _repeat(entry: ClockEntry, loops: list[float]) -> None:
    """Build, run and (until its time is precise) read; appends the calibration loops' times to `loops`."""
    try:
        began, warm_ups = time.perf_counter(), entry.warm_ups
        models = [entry.new_model() for _ in range(warm_ups + entry.row)]
        before, others = calibrate(), neighbours()
        for model in models[:warm_ups]:
            entry.run(model)
        row = models[warm_ups:]
        gc.disable()  # as the standard library's timeit does, because the time of a collection is arbitrary
        try:
            cpu, wall = time.process_time(), time.perf_counter()
            for model in row:
                entry.run(model)
            cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
        finally:
            gc.enable()
        reap()
        others, after = others or neighbours(), calibrate()
        entry.run_s = (time.perf_counter() - began) / len(models)
        read = _read(entry, row[-1])
    except (Exception, SystemExit) as problem:  # the failure of one engine must not affect the others
        entry.failure = legible(f"{type(problem).__name__}: {problem}")
        return
    loops += [before, after]
    entry.repeats.append(Repeat(cpu / len(row), wall / len(row), max(before, after), others, read))


def _read(entry: ClockEntry, model: Any) -> float:
    """CPU seconds of reading a model; NaN if the earlier measurements are precise enough."""
    reads = [r.read for r in entry.repeats if not isnan(r.read)]
    if is_precise(reads) or len(reads) >= _MOST_READS:
        return nan
    start = time.process_time()
    # Access to the samples is timed too: the reference computes them on access.
    getattr(entry.read(model), "t", None)
    return time.process_time() - start


def calibrate() -> float:
    """Wall seconds of the calibration loop, whose work is fixed."""
    began, total = time.perf_counter(), 0
    for i in range(_CALIBRATION):
        total += i
    return time.perf_counter() - began


def _without_disturbance(loops: Sequence[float]) -> float:
    return sorted(loops)[int(_QUIET_SHARE * len(loops))]


def neighbours() -> bool:
    """Whether other processes now occupy all other cores (Linux; on other systems only the calibration loop counts)."""
    try:
        running = int(Path("/proc/loadavg").read_text().split()[3].partition("/")[0])
    except (OSError, ValueError, IndexError):
        return False
    return running > max(1, (os.cpu_count() or 1) - 1)
