"""Growth of a motion's cost and memory with its periods, its transitions and its duration."""

from __future__ import annotations

import resource
import time
from typing import NamedTuple

import cases
import reference

RTOL = 1e-9
# The result is the minimum over at least CALLS calls and BRIEF seconds; no call starts after LONG seconds. The limit on
# growth is 15 %, disturbances only add time, and calls of 0.1 ms need many repeats.
CALLS, BRIEF, LONG = 5, 0.3, 10.0


class Growth(NamedTuple):
    """A motion of variable length: the counted quantity, the case and its parameters, the duration of one unit (s), and
    the numbers of units."""

    quantity: str
    case: str
    parameters: dict[str, float]
    unit_s: float
    sizes: tuple[int, ...]
    full: tuple[int, ...]  # additional sizes with --full, which take minutes

    @property
    def all_sizes(self) -> tuple[int, ...]:
        """All sizes of a full study."""
        return (*self.sizes, *self.full)


# The disc swings back and forth in two seconds; the wheel changes its mode four times per turn, 10,000 times in 1120 s;
# the frictionless disc never changes its mode.
GROWTHS = (
    Growth("periods", "disc_in_circle", {"mu": 0.2}, 2.0, (100, 1000, 5000), ()),
    Growth("transitions", "limping_wheel", {}, 0.112, (10, 100, 1000, 10_000), (100_000,)),
    Growth("seconds", "many_swings", {"mu": 0.0}, 1.0, (1, 10, 100, 1000), (10_000,)),
)


def case_of(growth: Growth, size: int) -> cases.Case:
    """The case with a duration of `size` units."""
    case = cases.load(growth.case, **growth.parameters)
    return cases.Case(case.track, case.plate, case.effects, case.start, growth.unit_s * size)


class GrowthRow(NamedTuple):
    """The cost of one size: CPU seconds of the call, CPU seconds of the call and its samples, transitions, steps, and
    growth of the process's memory (MB, including samples)."""

    call_s: float
    sampled_s: float
    transitions: int
    steps: int
    memory_mb: float
    status: str


def _again(calls: int, seconds: float) -> bool:
    """Whether another call is needed after this many calls and seconds."""
    return seconds < LONG and (calls < CALLS or seconds < BRIEF)


def measure(growth: Growth, size: int) -> GrowthRow:
    """Measure one size in the calling process."""
    reference.simulate(case_of(growth, 1), rtol=RTOL).t  # noqa: B018 - compiled and imported before the clock starts
    case = case_of(growth, size)
    memory_before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    calls: list[float] = []
    samples: list[float] = []
    began = time.perf_counter()
    while not calls or _again(len(calls), time.perf_counter() - began):
        motion = None  # otherwise the memory of the previous motion would count for this one
        start = time.process_time()
        motion = reference.simulate(case, rtol=RTOL)
        end = time.process_time()
        len(motion.t)
        calls.append(end - start)
        samples.append(time.process_time() - start)
    memory_mb = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - memory_before) / 1024.0
    assert motion is not None
    return GrowthRow(min(calls), min(samples), len(motion.transitions), motion.cost.steps, memory_mb, motion.status)
