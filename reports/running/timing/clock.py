"""How long `run` of each solver takes: one process, nothing beside it, contestants in turn, again and again.

CPU time of `run` alone (time.process_time). The model is built anew for each run, off the clock. Contestants take
turns, so that a slower clock or a neighbour's load hits all alike; the cheap ones take theirs again before each dear
one, which costs next to nothing and has them seen beside all of it. A long run soon has its code and data in the
processor's caches; a short one would only pay for what the others left there, so that it is run once off the clock and
then several times in a row. Around each repeat stands a loop of known work; a repeat beside a slow loop, beside other
running processes, or that had to wait for its processor is a disturbed one. Medians are of the undisturbed repeats; a
contestant with too few of them is marked, and ranks nowhere.
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
from cases import Case, compile_cache

from ..processes.worker_process import reap
from ..records import legible
from ..solvers import solver
from ..third_party import third_party

# The median is known well enough when its standard error, as a part of it, is below this.
BOUND = 0.02
# No spread is told of fewer repeats; with more than so many the machine, not the count, is the limit.
LEAST_REPEATS, MOST_REPEATS = 3, 60
# Of fewer repeats than these quantiles are no better known than the extremes, which are told in their place: the
# extremes of six hold the median with a chance of 97 %, those of five with 94 %.
_QUANTILES_FROM = 6
# Two processes that do the same work take unlike times, each always its own: their code and data lie elsewhere. Medians
# of thirty repeats deviate by 1.3 to 2.9 % from process to process (24 settings of three solvers, ten processes; one of
# them by 12 %). With intervals no narrower than this, 99.9 % of the ratios of two processes agree; without, 98 %.
_PROCESS = 0.03
# Reading ranks nobody by itself: the least repeats tell it well enough, where it takes longer than the run.
_MOST_READS = LEAST_REPEATS
# The first run of a contestant is thrown away if it is shorter than this: lazy imports weigh in it.
_FIRST_SECONDS = 0.03
# Cold caches cost some 0.2 ms: shorter runs than this feel it, and are warmed up in place.
_SHORT_SECONDS = 1e-2
# So long do short runs take in a row, and so many they are at most: each needs a model of its own.
_ROW_SECONDS, _ROW_RUNS = 1e-3, 16
# Two timings of the same work on a quiet machine differ by a few per cent; a fifth is another load or another clock.
_DISTURBED = 1.2
# A switch to the kernel and back between two readings of the clocks; a shorter wait is none.
_SWITCH_SECONDS = 5e-4
# Additions in the calibration loop: about a millisecond, long against the clock's resolution, short against a run.
_CALIBRATION = 30_000
# The undisturbed loop is the one that only a tenth of all loops beat: the very fastest may be a clock's short boost.
_UNDISTURBED = 0.1
# A repeat that takes no more than this, set-up included, is cheap: the turns of twenty such take half a second.
_CHEAP_SECONDS = 0.025


# Names a contestant: the case's label, the solver, the route, the setting.
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
        """The contestant's name in every result: results are never matched by their order."""
        return self.case.label, self.solver, self.route, self.setting


@dataclass(frozen=True)
class Timing:
    """What a setting took, in seconds.

    Medians over the undisturbed repeats (over all if there are fewer than `LEAST_REPEATS`: then `disturbed`) of `run`:
    CPU and wall; [cpu_low_s, cpu_high_s] runs from the first to the last decile of the CPU time, of few repeats from
    the least to the greatest, and at least 3 % to either side, by which processes differ (NaN of fewer than three
    repeats). CPU seconds apart from those: `setup_s` of `build`, the median; `compile_s`
    what the first `build` took beyond that (imports, derivation, compilation; what settings share is paid by the first
    of them); `read_s` of `read`. `repeats` counts what the medians are of, `disturbed_repeats` what was thrown away.
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


UNTIMED = Timing(*8 * (nan,), repeats=0, disturbed_repeats=0, disturbed=False)


class Repeat(NamedTuple):
    """One repeat: CPU and wall seconds of a `run` (the mean of those in a row); the slower of the calibration loops
    before and after it, s; whether other processes were seen to run; CPU seconds of reading back, NaN where that was
    known already."""

    cpu: float
    wall: float
    loop: float
    beside_others: bool
    read: float = nan


@dataclass
class ClockEntry:
    """A contestant at the clock: how it builds, runs and reads back, and what that took so far."""

    contestant: Contestant
    build: Callable[[], Any]
    run: Callable[[Any], None]
    read: Callable[[Any], Any] = lambda model: None
    repeats: list[Repeat] = field(default_factory=list)
    setup: list[float] = field(default_factory=list)
    run_s: float = 0.0  # wall seconds of a build and a run, the last time
    failure: str = ""

    @property
    def repeat_s(self) -> float:
        """Wall seconds that one more repeat is expected to take."""
        if not self.repeats:
            return self.contestant.expected_s
        return (self.warm_ups + self.row) * self.run_s

    @property
    def warm_ups(self) -> int:
        """Runs off the clock before a repeat."""
        return int(bool(self.repeats) and self.repeats[-1].cpu < _SHORT_SECONDS)

    @property
    def row(self) -> int:
        """Runs in a row of a repeat."""
        if not self.repeats:
            return 1
        return max(1, min(_ROW_RUNS, ceil(_ROW_SECONDS / max(self.repeats[-1].cpu, 1e-9))))

    def built(self) -> Any:
        """A new model; what that took is noted, compiled anew the first time."""
        with compile_cache.off():
            spent = time.process_time()
            model = self.build()
            self.setup.append(time.process_time() - spent)
        return model

    def undisturbed(self, loop: float) -> list[Repeat]:
        """The repeats of a quiet machine, whose calibration loop takes `loop` seconds."""
        return [r for r in self.repeats if not disturbed(r, loop)]


def disturbed(repeat: Repeat, loop: float) -> bool:
    """Whether something else had a part in a repeat; an undisturbed calibration loop takes `loop` seconds."""
    waited = repeat.wall > _DISTURBED * repeat.cpu + _SWITCH_SECONDS
    return waited or repeat.beside_others or disturbed_by(repeat.loop, loop)


def disturbed_by(seen: float, loop: float) -> bool:
    """Whether a calibration loop of `seen` seconds was disturbed, if it takes `loop` seconds undisturbed."""
    return seen > _DISTURBED * loop


def time_all(contestants: Sequence[Contestant], budget: float) -> dict[Key, tuple[Timing | None, str]]:
    """The timing of each contestant, or None and why it failed, in a sentence.

    All take their turns together, the cheapest first, within about `budget` wall seconds beyond imports: who does not
    fit in it even once has neither.
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


@third_party()
def _import(entry: ClockEntry) -> None:
    """Build once, before the budget runs: importing an engine takes seconds where the disk is cold."""
    try:
        entry.built()
    except (Exception, SystemExit) as problem:
        entry.failure = legible(f"{type(problem).__name__}: {problem}")


def take_turns(entries: Sequence[ClockEntry], deadline: float) -> float:
    """Repeat all entries in turn until each median is known or `deadline` (of time.perf_counter) is near; returns how
    long the calibration loop takes undisturbed, s."""
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

    def left() -> list[ClockEntry]:
        loop = _without_disturbance(loops)
        return [e for e in entries if fits(e) and not _enough(e, loop)]

    waiting = left()
    while waiting:
        for entry in waiting:
            if entry.repeat_s > _CHEAP_SECONDS:
                for cheap in left():
                    if cheap.repeats and cheap.repeat_s <= _CHEAP_SECONDS:
                        turn(cheap)
            turn(entry)
        waiting = left()
    return _without_disturbance(loops)


def _enough(entry: ClockEntry, loop: float) -> bool:
    return len(entry.repeats) >= MOST_REPEATS or is_precise([r.cpu for r in entry.undisturbed(loop)])


def is_precise(seconds: Sequence[float]) -> bool:
    """Whether the median of these repeats is known to `BOUND`, or no more of them would help."""
    if len(seconds) < LEAST_REPEATS:
        return False
    low, high = _middle(seconds, 4)
    # Standard error of a normal sample's median, its deviation taken from the quartiles: 1.253 σ/√n, σ = IQR/1.349.
    error = 0.929 * (high - low) / sqrt(len(seconds))
    return len(seconds) >= MOST_REPEATS or error <= BOUND * statistics.median(seconds)


def interval(seconds: Sequence[float]) -> tuple[float, float]:
    """Where the median of another process is expected; NaN of fewer than `LEAST_REPEATS`."""
    if len(seconds) < LEAST_REPEATS:
        return nan, nan
    low, high = _middle(seconds, 10)
    median = statistics.median(seconds)
    return min(low, (1.0 - _PROCESS) * median), max(high, (1.0 + _PROCESS) * median)


def _middle(seconds: Sequence[float], parts: int) -> tuple[float, float]:
    """What lies between the first and the last of so many equal parts; of few, between the extremes."""
    if len(seconds) < _QUANTILES_FROM:
        return min(seconds), max(seconds)
    cuts = statistics.quantiles(seconds, n=parts, method="inclusive")
    return cuts[0], cuts[-1]


def timing(entry: ClockEntry, loop: float) -> Timing:
    """What the entry's repeats say; an undisturbed calibration loop takes `loop` seconds."""
    quiet = entry.undisturbed(loop)
    few = len(quiet) < LEAST_REPEATS
    used = entry.repeats if few else quiet
    setup = statistics.median(entry.setup[1:] or entry.setup)
    # Beside what runs, reading is disturbed like running: the same repeats count, if it was read in one of them.
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


@third_party()
def _repeat(entry: ClockEntry, loops: list[float]) -> None:
    """Build, run and (until it is known) read back; the calibration loops' times go into `loops`."""
    try:
        began, warm_ups = time.perf_counter(), entry.warm_ups
        models = [entry.built() for _ in range(warm_ups + entry.row)]
        before, others = calibrate(), neighbours()
        for model in models[:warm_ups]:
            entry.run(model)
        row = models[warm_ups:]
        gc.disable()  # as the standard library's timeit does: whose garbage is collected when is chance
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
    except (Exception, SystemExit) as problem:  # an engine that fails now and then loses its row, not everyone's
        entry.failure = legible(f"{type(problem).__name__}: {problem}")
        return
    loops += [before, after]
    entry.repeats.append(Repeat(cpu / len(row), wall / len(row), max(before, after), others, read))


def _read(entry: ClockEntry, model: Any) -> float:
    """CPU seconds of reading a model back; NaN once that is known well enough."""
    reads = [r.read for r in entry.repeats if not isnan(r.read)]
    if is_precise(reads) or len(reads) >= _MOST_READS:
        return nan
    spent = time.process_time()
    # The samples are asked for: the reference makes them when they are.
    getattr(entry.read(model), "t", None)
    return time.process_time() - spent


def calibrate() -> float:
    """Wall seconds of a loop that is always the same work."""
    began, total = time.perf_counter(), 0
    for i in range(_CALIBRATION):
        total += i
    return time.perf_counter() - began


def _without_disturbance(loops: Sequence[float]) -> float:
    return sorted(loops)[int(_UNDISTURBED * len(loops))]


def neighbours() -> bool:
    """Whether all cores but this process's are taken, now (Linux; elsewhere the calibration loop alone is asked)."""
    try:
        running = int(Path("/proc/loadavg").read_text().split()[3].partition("/")[0])
    except (OSError, ValueError, IndexError):
        return False
    return running > max(1, (os.cpu_count() or 1) - 1)
