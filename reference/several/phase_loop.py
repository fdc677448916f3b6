"""The loop over phases that a simulation of several contacts and one of several plates share, with its limits."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np

from cases import DoesNotFit, Mode

from ..minimal.decision import Undecidable
from ..minimal.hybrid import MOST_PHASES
from ..minimal.integrators.segment import BREAKDOWN, Segment
from ..minimal.phase_end import LOCATION_ERROR, MOST_STEPS, ROUGH, Ending, undecidable, work_limit_ending
from ..time_limit import check_time
from .watched_plate import MotionEnds

# This many phases of zero length in a row: values near a bound count as being at it; then the motion ends.
IDLE, STUCK = 4, 50


class PhaseLoop(ABC):
    """Phases one after another until an ending. A subclass sets `t` (s), `segments`, and `work` and `idle` to 0."""

    t: float
    segments: list[Segment]
    work: int
    idle: int

    @abstractmethod
    def _begin(self) -> None:
        """Remove the roundings of the start."""

    @abstractmethod
    def _next_phase(self) -> Ending | None:
        """Decide, integrate one phase and apply its event; returns an ending, or None."""

    def simulate_phases(self) -> Ending:
        """Simulate phases until the end."""
        try:
            self._begin()
            for _ in range(MOST_PHASES):
                check_time()
                ending = self._next_phase()
                if ending:
                    return ending
                if self.work >= MOST_STEPS:
                    return work_limit_ending(self.t, self.work)
        except MotionEnds as end:
            return end.ending
        except Undecidable:
            return undecidable(self.t)
        except (DoesNotFit, np.linalg.LinAlgError) as problem:
            return BREAKDOWN, f"After t = {self.t:.9g} s {problem}."
        return "unfinished", f"The modes changed {MOST_PHASES} times until t = {self.t:.9g} s, the limit of a run."

    def _decision_error(self) -> float:
        """The part of a bound within which values are at it."""
        return LOCATION_ERROR if self.idle <= IDLE else ROUGH

    def _count(self, segment: Segment) -> None:
        """Add a segment to the motion. Raises MotionEnds where too many in a row took no time."""
        self.segments.append(segment)
        self.work += segment.steps
        self.idle = self.idle + 1 if segment.event.time == self.t else 0
        if self.idle > STUCK:
            raise MotionEnds(("accumulation", f"{STUCK} changes of mode took no time at t = {self.t:.9g} s."))


def several_motions(t: float, names: Sequence[str], motions: Sequence[Sequence[Mode]]) -> Ending:
    """The ending where several motions are consistent, each given by the modes of the contacts with these names."""
    choices = "; ".join(
        ", ".join(f"{name} {mode}" for name, mode in zip(names, modes, strict=True)) for modes in motions
    )
    return "not_unique", (f"{len(motions)} motions of rigid Coulomb contact are consistent at {t:.9g} s: {choices}.")
