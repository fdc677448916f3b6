"""Wall and CPU time of the phases of a command, including its workers."""

from __future__ import annotations

import os
import resource
import time
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from adapters.common.supervision import descendants

# Largest number of phases in the line on the terminal; the manifest has all.
_MOST_PHASES = 5


class PhaseTime(NamedTuple):
    """Wall and CPU time of a phase, s; CPU of this process and all its child processes."""

    wall: float
    cpu: float


class PhaseTimes:
    """Adds the time since the last booking to a phase, so that nothing is counted twice or omitted.

    `clock` returns wall and CPU seconds since an arbitrary time.
    """

    def __init__(self, clock=lambda: PhaseTime(time.monotonic(), _cpu_seconds())):
        self._clock, self._last = clock, clock()
        self.phases: dict[str, PhaseTime] = {}

    def book(self, phase: str) -> None:
        """Add the time since the last booking to the phase."""
        now, before = self._clock(), self.phases.get(phase, PhaseTime(0.0, 0.0))
        # CPU time of a worker's orphaned child processes can disappear at the worker's end.
        cpu = max(now.cpu - self._last.cpu, 0.0)
        self.phases[phase] = PhaseTime(before.wall + now.wall - self._last.wall, before.cpu + cpu)
        self._last = now


def time_summary(phases: Mapping[str, PhaseTime]) -> dict[str, dict[str, float]]:
    """The times of the phases for the manifest, to a hundredth of a second."""
    return {name: {"wall_s": round(s.wall, 2), "cpu_s": round(s.cpu, 2)} for name, s in phases.items()}


def total(phases: Mapping[str, PhaseTime]) -> PhaseTime:
    """Wall and CPU time of all phases, s."""
    return PhaseTime(sum(s.wall for s in phases.values()), sum(s.cpu for s in phases.values()))


def total_words(phases: Mapping[str, PhaseTime]) -> str:
    """Wall and CPU time of all phases, for the terminal and the page."""
    whole = total(phases)
    return f"{whole.wall:.0f} s, {whole.cpu:.0f} s of CPU time"


def parts_words(phases: Mapping[str, PhaseTime]) -> str:
    """The wall times of the longest phases, and that of the others; "" if none took half a second."""
    longest = sorted(phases.items(), key=lambda pair: -pair[1].wall)
    items = [f"{name} {s.wall:.0f} s" for name, s in longest[:_MOST_PHASES] if s.wall >= 0.5]
    others = total(phases).wall - sum(s.wall for _, s in longest[: len(items)])
    more = [f"all else {others:.0f} s"] if len(items) < len(phases) else []
    return ", ".join([*items, *more])


# --- CPU time ---------------------------------------------------------------------------------------------------------


def _cpu_seconds() -> float:
    """CPU seconds of this process and its descendants; of running ones only if the system reports them (Linux).

    A worker is a child of its supervisor, which is this process's child."""
    ended = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + ended.ru_utime + ended.ru_stime + sum(map(_of_process, descendants(os.getpid())))


def _of_process(number: int) -> float:
    """CPU seconds of a process and its ended child processes; 0 if it is gone or the system does not report them."""
    try:
        # After the name, which may hold anything: the 14th to 17th fields are user and system time, and the children's.
        fields = Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()[11:15]
        return sum(map(int, fields)) / os.sysconf("SC_CLK_TCK")
    except (OSError, ValueError):
        return 0.0
