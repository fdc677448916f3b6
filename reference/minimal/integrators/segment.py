"""The result of an integrator: one phase's motion and the event that ended it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple, cast

import numpy as np

from ..modes import Phase

# Used instead of a guard's name if a motion reached its limit on steps.
OUT_OF_STEPS = "exhausted"
# Limit on the steps of a phase: the compiled loop takes five seconds for them, their record 400 MB.
MOST_STEPS = 400_000
# The limit if each step is processed separately (a third of a millisecond, with a load in place or velocity up to one:
# half a minute to two).
MOST_LOOKED_AT = 100_000
# A rejected step is repeated with a shorter length, up to fifty times near a pole: limit on the tries of a phase.
MOST_TRIES = 2 * MOST_LOOKED_AT


class Event(NamedTuple):
    """The end of a phase: the guard that reached zero (None: the end of the time span), the time, and the state."""

    guard: str | None
    time: float
    state: tuple[float, ...]


States = Callable[[np.ndarray], np.ndarray]
# A time (s) and the state there.
Instant = tuple[float, Sequence[float]]


Record = tuple[np.ndarray, States]


@dataclass(eq=False, slots=True)
class Segment:
    """A phase's motion: start (s), event, work, and `record`: its step times and its dense output, t ↦ states of shape
    (variables, n), or a function that returns these. Simulating a motion seldom needs them. `first`: the states, with
    their times, at its start and after its first step, of a phase without a record."""

    phase: Phase
    start: float
    event: Event
    evaluations: int
    steps: int
    record: Record | Callable[[], Record]
    first: tuple[Instant, ...] = ()

    @classmethod
    def of(cls, phase: Phase, times: np.ndarray, states: States, event: Event, evaluations: int) -> Segment:
        """A segment from its steps."""
        return cls(phase, float(times[0]), event, evaluations, len(times) - 1, (times, states))

    @property
    def _full_record(self) -> Record:
        if not isinstance(self.record, tuple):
            self.record = self.record()
        return self.record

    @property
    def times(self) -> np.ndarray:
        """The steps' ends and the start, s."""
        return self._full_record[0]

    @property
    def states(self) -> States:
        """The dense output."""
        return self._full_record[1]

    def __reduce__(self):
        """Pickle the segment with all its steps, without the function that would compute them."""
        return Segment, (self.phase, self.start, self.event, self.evaluations, self.steps, self._full_record)

    def instants(self, inside: bool = True) -> list[Instant]:
        """The states at the start and the end, and one between them, where it costs no further step: at the end of a
        step, or, of a single one, inside it."""
        last = self.event.time, self.event.state
        if not isinstance(self.record, tuple):
            return [*self.first[: 1 + inside], last]
        times, states = self.record
        steps: Any = states
        if not hasattr(states, "at_step"):
            some = np.array([self.start, 0.5 * (self.start + self.event.time)][: 1 + inside])
            return [*zip(some.tolist(), states(some).T.tolist(), strict=True), last]
        if not inside:
            return [steps.at_step(0), last]
        if len(times) < 3:
            return [steps.at_step(0), steps.inside(0, 0.5 * (self.event.time - self.start)), last]
        return [steps.at_step(0), steps.at_step(len(times) // 2), last]

    def cut(self, time: float, guard: str | None) -> Segment:
        """The same motion that ends at a time (s) by that guard, in its state there."""
        times = np.append(self.times[self.times < time], time)
        event = Event(guard, time, tuple(self.states(np.array([time]))[:, 0].tolist()))
        return Segment.of(self.phase, times, self.states, event, self.evaluations)

    def ends_in_steps(self) -> bool:
        """Whether a step's end is more accurate than its inside: not where steps are Taylor polynomials."""
        return hasattr(self.states, "pieces")

    def step_to(self, time: float, integrate: Callable[[float, Sequence[float], float], Segment]) -> Segment | None:
        """The same motion until a time (s), which is the end of a step: the last one is made again by `integrate`
        (t, y, end). None if that does not reach the time."""
        times, states = self.times[self.times < time], cast(Any, self.states)
        if not len(times):
            return None
        start = float(times[-1])
        rest = integrate(start, states(times[-1:])[:, 0].tolist(), time)
        if rest.event.guard is not None or rest.event.time != time or not rest.ends_in_steps():
            return None
        output = type(states).of(times.tolist(), states.pieces[: len(times) - 1], rest.states)
        record = np.append(times, rest.times[1:])
        return Segment.of(self.phase, record, output, rest.event, self.evaluations + rest.evaluations)


class Segments(list[Segment]):
    """The segments of a motion so far, and the number of their steps."""

    steps = 0

    def add(self, segment: Segment) -> None:
        """Add the next one."""
        self.append(segment)
        self.steps += segment.steps


def blocks(starts: np.ndarray, times: np.ndarray) -> Iterator[tuple[int, np.ndarray]]:
    """For pieces of time that begin at `starts`: the number of each piece with `times` in it, and their indices.

    Times before the first start belong to the first piece. It sorts once, so that the cost is linear in pieces and
    times.
    """
    which = np.maximum(starts.searchsorted(times, side="right") - 1, 0)
    order = which.argsort(kind="stable")
    ordered = which[order]
    # Slices: NumPy's split takes longer than all the rest.
    bounds = [0, *((ordered[1:] != ordered[:-1]).nonzero()[0] + 1).tolist(), len(order)]
    for first, end in pairwise(bounds):
        if end > first:
            yield int(ordered[first]), order[first:end]
