"""Where a command's time goes: wall and CPU seconds of its phases, those of its workers included."""

from __future__ import annotations

import os
import resource
import time
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import NamedTuple

# Phases that a line of the terminal names; the others are in the manifest.
_NAMED = 5


class PhaseTime(NamedTuple):
    """What a phase took, s; CPU of this process and of all that it started."""

    wall: float
    cpu: float


class PhaseTimes:
    """A ledger that books what passed since the last booking to a phase, so that nothing is counted twice or left out.

    `clock` tells wall and CPU seconds, from any beginning.
    """

    def __init__(self, clock=lambda: PhaseTime(time.monotonic(), _cpu_seconds())):
        self._clock, self._last = clock, clock()
        self.phases: dict[str, PhaseTime] = {}

    def book(self, phase: str) -> None:
        """What has passed since the last booking was the phase's; one that comes again adds up."""
        now, before = self._clock(), self.phases.get(phase, PhaseTime(0.0, 0.0))
        # A worker's end may hide the time of something that it had started and left.
        cpu = max(now.cpu - self._last.cpu, 0.0)
        self.phases[phase] = PhaseTime(before.wall + now.wall - self._last.wall, before.cpu + cpu)
        self._last = now


def time_summary(phases: Mapping[str, PhaseTime]) -> dict[str, dict[str, float]]:
    """The same for a manifest, to a hundredth of a second."""
    return {name: {"wall_s": round(s.wall, 2), "cpu_s": round(s.cpu, 2)} for name, s in phases.items()}


def total(phases: Mapping[str, PhaseTime]) -> PhaseTime:
    """Wall and CPU time of all phases, s."""
    return PhaseTime(sum(s.wall for s in phases.values()), sum(s.cpu for s in phases.values()))


def words(phases: Mapping[str, PhaseTime]) -> str:
    """The time of the whole report, and the wall time of its longest phases, in a line."""
    longest = sorted(phases.items(), key=lambda pair: -pair[1].wall)
    named = [f"{name} {s.wall:.0f} s" for name, s in longest[:_NAMED] if s.wall >= 0.5]
    whole = total(phases)
    others = whole.wall - sum(s.wall for _, s in longest[: len(named)])
    more = [f"all else {others:.0f} s"] if len(named) < len(phases) else []
    parts = ", ".join([*named, *more])
    return f"the report took {whole.wall:.0f} s, {whole.cpu:.0f} s of CPU time{': ' if parts else ''}{parts}"


# --- CPU time ---------------------------------------------------------------------------------------------------------


def _cpu_seconds() -> float:
    """CPU seconds of this process and of its children; of those that still run only where the system tells (Linux)."""
    ended = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + ended.ru_utime + ended.ru_stime + sum(map(_of_process, _children()))


def _children() -> Iterable[int]:
    try:
        return [
            int(number) for file in Path("/proc/self/task").glob("*/children") for number in file.read_text().split()
        ]
    except OSError:
        return []


def _of_process(number: int) -> float:
    """CPU seconds of a process and of those of its own that have ended; 0 if it is gone or the system does not tell."""
    try:
        # After the name, which may hold anything: the 14th to 17th fields are user and system time, and the children's.
        fields = Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()[11:15]
        return sum(map(int, fields)) / os.sysconf("SC_CLK_TCK")
    except (OSError, ValueError):
        return 0.0
