"""The motion's own time scales: short and long are relative to them, never to the duration of the case."""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt

from .modes import Phase


def frequency(phase: Phase, t: float, y: Sequence[float]) -> float:
    """How fast a state changes, 1/s: the largest of `frequencies`; 0 without motion and acceleration; infinite or NaN
    if the state is not finite."""
    return max(frequencies(phase, t, y), default=0.0)


def frequencies(phase: Phase, t: float, y: Sequence[float]) -> list[float]:
    """How fast each position changes, 1/s: the larger of speed over size and √(acceleration over size)."""
    rates = phase.system.rates_of_numbers(t, tuple(y), phase.parameters)
    p = phase.system.positions
    # A motion from rest covers its own size in √(size/acceleration).
    return [
        max(abs(u) / size, sqrt(abs(u_dot) / size))
        for u, u_dot, size in zip(y[p:], rates[p:], phase.lengths, strict=False)
    ]
