"""What an integrator answers: one phase's motion and what ended it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..modes import Phase

# Stands for a guard where the equations became singular and no step can go on.
BREAKDOWN = "breakdown"
# Stands for a guard where a motion has taken all the steps that it may.
OUT_OF_STEPS = "exhausted"
# The same where looking for landings took all the work that it may.
LOST_SIGHT = "lost sight"
# So many steps a phase takes at most: the compiled loop takes five seconds for them, their record 400 MB.
MOST_STEPS = 400_000
# The same where each step is looked at by itself (a third of a millisecond, with a load in place or velocity up to one:
# half a minute to two).
MOST_LOOKED_AT = 100_000
# A step that is not accepted is repeated with a shorter length, up to fifty times near a pole: so many tries a phase.
MOST_TRIES = 2 * MOST_LOOKED_AT


class Event(NamedTuple):
    """What ended a phase: the guard that reached zero (None: the end of the time span), when, and the state there."""

    guard: str | None
    time: float
    state: tuple[float, ...]


States = Callable[[np.ndarray], np.ndarray]


Record = tuple[np.ndarray, States]


@dataclass(eq=False, slots=True)
class Segment:
    """A phase's motion: when it starts (s), what ends it, the work it took, and `record`: its step times and its dense
    output, t ↦ states of shape (variables, n), or what gives these. What decides a motion seldom asks for them."""

    phase: Phase
    start: float
    event: Event
    evaluations: int
    steps: int
    record: Record | Callable[[], Record]

    @classmethod
    def of(cls, phase: Phase, times: np.ndarray, states: States, event: Event, evaluations: int) -> Segment:
        """A segment whose steps are at hand."""
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
        """A segment travels to another process with all its steps: what would make them again stays here."""
        return Segment, (self.phase, self.start, self.event, self.evaluations, self.steps, self._full_record)

    def until(self, time: float, evaluations: int) -> Segment:
        """The same motion cut at that time, with the work that it took."""
        times = np.append(self.times[self.times < time], time)
        return Segment.of(self.phase, times, self.states, self.event._replace(time=time), evaluations)

    def ended_by(self, guard: str) -> Segment:
        """The same motion, with another reason for its end."""
        return replace(self, event=self.event._replace(guard=guard))


def blocks(starts: np.ndarray, times: np.ndarray) -> Iterator[tuple[int, np.ndarray]]:
    """For pieces of time that begin at `starts`: the number of each piece that is met, and which of `times` lie in it.

    Before the first start counts as the first piece. One sort, so that the cost is linear in pieces and in times.
    """
    which = np.clip(np.searchsorted(starts, times, side="right") - 1, 0, len(starts) - 1)
    order = np.argsort(which, kind="stable")
    for block in np.split(order, np.flatnonzero(np.diff(which[order])) + 1):
        if block.size:
            yield int(which[block[0]]), block
