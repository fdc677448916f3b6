"""What an integrator answers: one phase's motion and what ended it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..modes import Phase

# Stands for a guard where the equations became singular and no step can go on.
BREAKDOWN = "breakdown"


class Event(NamedTuple):
    """What ended a phase: the guard that reached zero (None: the end of the time span), when, and the state there."""

    guard: str | None
    time: float
    state: tuple[float, ...]


@dataclass(frozen=True)
class Segment:
    """A phase's motion: its step times, a dense output t ↦ states of shape (variables, n), and the work it took."""

    phase: Phase
    times: np.ndarray
    states: Callable[[np.ndarray], np.ndarray]
    event: Event
    evaluations: int
