"""Short events: zeros of a guard inside a step whose ends do not show them.

A bound on the second derivative excludes a zero in an interval, or the interval is halved. With g₁, g₂ at its ends and
its length h,

    g ≥ g₁ + (g₂ − g₁) s − (M h²/2) s (1 − s),      0 ≤ s ≤ 1,      |g̈| ≤ M,

and where this parabola is positive, so is g. M follows from second differences at five places: a step is a small part
of the motion's time scale and of every feature's length, so that the second derivative changes little in it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

# Places in a step at which a guard is evaluated for the bound, and the bound over the largest second difference there.
PLACES, MARGIN = 5, 2.0
# Shorter parts of a step are not divided: an excursion of that length is below rounding, (2π/120 · 2⁻²⁰)²/8 = 3e-16.
SHORTEST = 2.0**-20
# Limit on the evaluations in one step: a guard of nothing but rounding is divided everywhere.
MOST_LOOKS = 1000

Guard = Callable[[float, np.ndarray], float]


def excursion(value: Callable[[float], float], start: float, end: float) -> float | None:
    """A time between `start` and `end` at which a quantity that is positive at both is not; None if there is none."""
    times = np.linspace(start, end, PLACES).tolist()
    values = [value(t) for t in times]
    if not values[0] > 0.0:
        return None
    bend = MARGIN * max(abs(a - 2.0 * b + c) for a, b, c in zip(values, values[1:], values[2:], strict=False))
    parts = [*zip(times, values, times[1:], values[1:], strict=False)][::-1]
    spacing, looks = (end - start) / (PLACES - 1), PLACES
    while parts and looks < MOST_LOOKS:
        left, low, right, high = parts.pop()
        if not high > 0.0:
            return right if right < end else None
        if right - left <= SHORTEST * (end - start) or _is_positive(low, high, bend * ((right - left) / spacing) ** 2):
            continue
        middle = 0.5 * (left + right)
        between, looks = value(middle), looks + 1
        if not between > 0.0:
            return middle
        parts += [(middle, between, right, high), (left, low, middle, between)]
    return None


def _is_positive(low: float, high: float, bend: float) -> bool:
    """Whether a quantity with positive values at both ends of an interval is positive between; `bend` is M h²."""
    rise = abs(high - low)
    if 2.0 * rise >= bend:  # the parabola is monotone
        return True
    return 0.5 * (low + high) - bend / 8.0 - rise * rise / (2.0 * bend) > 0.0


class Dips:
    """The search for short events in the steps of a phase, from `watch_from` (s) on."""

    def __init__(self, watch_from: float):
        self.watch_from = watch_from
        self._looks: list[tuple[float, Mapping[Any, float]]] = []  # the last two

    def first(
        self, value: Callable[[Any, float], float], start: float, end: float, values: Mapping[Any, float]
    ) -> float | None:
        """A time in the step from `start` to `end` at which a guard that is positive at both is not, s; None if there
        is none. `value` maps a guard's name and a time to a number; `values` are those at the end, by name."""
        start, time = max(start, self.watch_from), end
        if start >= end:
            return None
        looks = [*self._looks, (end, values)] if self._looks and self._looks[-1][0] == start else [(end, values)]
        for name, last in values.items():
            if last > 0.0 and not _is_far(name, looks):
                time = min(time, excursion(partial(value, name), start, time) or time)
        self._looks = looks[-2:]
        return time if time < end else None


def _is_far(name: Any, looks: Sequence[tuple[float, Mapping[Any, float]]]) -> bool:
    """Whether a guard rises in both steps between three looks, or is farther from zero than it changes in the last one
    or, at the first one's rate, in as long a time. A quadratic function that is lowest inside the last step falls in
    the first, and changes by four times its depth below the step's ends."""
    if len(looks) < 3 or any(name not in values for _, values in looks):
        return False
    (t0, a), (t1, b), (t2, c) = ((t, values[name]) for t, values in looks)
    before, now = (b - a) / (t1 - t0), (c - b) / (t2 - t1)
    return (now > 0.0 and before > 0.0) or min(b, c) > (t2 - t1) * max(abs(now), abs(before))
