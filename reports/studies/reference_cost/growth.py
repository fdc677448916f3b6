"""How the cost of a motion grows with its periods, its transitions and its seconds, and what it keeps in memory."""

from __future__ import annotations

import resource
import time
from typing import NamedTuple

import cases
import reference

RTOL = 1e-9
# What is told is the least of so many calls and so many seconds of them, and no more begin after LONG: growth is a
# matter of 15 %, whatever disturbs a call makes it longer, and calls of a tenth of a millisecond need many.
CALLS, BRIEF, LONG = 5, 0.3, 10.0


class Growth(NamedTuple):
    """A motion that can be made longer: what is counted, the case and its parameters, its unit's duration (s), and how
    many units."""

    counted: str
    case: str
    parameters: dict[str, float]
    unit_s: float
    sizes: tuple[int, ...]
    full: tuple[int, ...]  # beyond these with --full: minutes

    @property
    def all_sizes(self) -> tuple[int, ...]:
        return (*self.sizes, *self.full)


# The disc swings to and fro in two seconds; the wheel changes its mode four times a turn, 10,000 times in 1120 s; the
# frictionless disc does not change it at all.
GROWTHS = (
    Growth("periods", "disc_in_circle", {"mu": 0.2}, 2.0, (100, 1000, 5000), ()),
    Growth("transitions", "limping_wheel", {}, 0.112, (10, 100, 1000, 10_000), (100_000,)),
    Growth("seconds", "many_swings", {"mu": 0.0}, 1.0, (1, 10, 100, 1000), (10_000,)),
)


def case_of(growth: Growth, size: int) -> cases.Case:
    """The motion of that many units."""
    made = cases.load(growth.case, **growth.parameters)
    return cases.Case(made.track, made.plate, made.effects, made.start, growth.unit_s * size)


class Grown(NamedTuple):
    """What one size took: CPU s of the call, CPU s of the call and its samples, transitions, steps, and by how much the
    process's memory grew (MB, samples included)."""

    call_s: float
    sampled_s: float
    transitions: int
    steps: int
    memory_mb: float
    status: str


def _again(calls: int, spent: float) -> bool:
    """Whether so many calls in so many seconds are too few."""
    return spent < LONG and (calls < CALLS or spent < BRIEF)


def measure(growth: Growth, size: int) -> Grown:
    """One size, in the process that calls it."""
    reference.simulate(case_of(growth, 1), rtol=RTOL).t  # noqa: B018 - compiled and imported before the clock starts
    case = case_of(growth, size)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    calls: list[float] = []
    samples: list[float] = []
    began = time.perf_counter()
    while not calls or _again(len(calls), time.perf_counter() - began):
        motion = None  # what is kept of the call before would count for this one
        start = time.process_time()
        motion = reference.simulate(case, rtol=RTOL)
        called = time.process_time()
        len(motion.t)
        calls.append(called - start)
        samples.append(time.process_time() - start)
    grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024.0
    assert motion is not None
    return Grown(min(calls), min(samples), len(motion.transitions), motion.cost.steps, grown, motion.status)
