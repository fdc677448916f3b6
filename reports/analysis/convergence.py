"""How an error falls with what is spent: the order, its confidence interval, and where it no longer falls and why."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite, nan
from typing import NamedTuple

import numpy as np

# An error counts where it stands this far above what truth, reading and arithmetic can tell: there a tenth of it is
# theirs.
ABOVE = 10.0
# Fewer rungs, or rungs that differ less in steps, make a slope of noise.
LEAST_RUNGS, LEAST_SPAN = 3, 4.0
CONFIDENCE = 0.95
# A ladder's last rungs are level if the finest is better than the worst of them by no more than this factor, over at
# least LEAST_SPAN in steps: a method of order one half would have gained a factor of two.
_FLAT = 1.5
# What stops an error from falling: the truth's own bar, the reading from samples, rounding, or something of the
# engine's that the ladder does not refine.
TRUTH, READING, ROUNDING, MODEL = "truth", "reading", "rounding", "model"


class Point(NamedTuple):
    """A rung: what it spent (steps, or seconds), its error, and how sure truth, reading and arithmetic are of it."""

    setting: str
    spent: float
    error: float
    truth: float = 0.0
    reading: float = 0.0
    rounding: float = 0.0

    @property
    def limit(self) -> str:
        """What does not let the error be told; "" where it stands clear above all of it."""
        limits = ((TRUTH, self.truth), (READING, self.reading), (ROUNDING, self.rounding))
        return next((name for name, size in limits if not self.error > ABOVE * size), "")


class Saturation(NamedTuple):
    """Why the finest rungs of a ladder no longer improve ("": they do), since which setting, and at what error."""

    cause: str = ""
    setting: str = ""
    error: float = nan


class Order(NamedTuple):
    """p of error ~ spent**-p with its confidence interval, the settings it was fitted to, and why there is none (then
    NaN)."""

    order: float
    low: float
    high: float
    settings: tuple[str, ...]
    note: str


def saturation(ladder: Sequence[Point]) -> Saturation:
    """Of a ladder from coarse to fine; rungs without an error are left out.

    First what the finest rung's error is within (truth's bar, reading, rounding), else whether the last three rungs or
    more are level. The first of the rungs with the same cause is where it begins.
    """
    points = [p for p in ladder if isfinite(p.error)]
    if not points:
        return Saturation()
    cause = points[-1].limit
    if cause:
        begin = next((i + 1 for i in reversed(range(len(points))) if not points[i].limit), 0)
        return Saturation(cause, points[begin].setting, points[begin].error)
    for begin in range(len(points) - LEAST_RUNGS + 1):
        level = points[begin:]
        if level[-1].spent < LEAST_SPAN * level[0].spent:
            break
        if max(p.error for p in level) <= _FLAT * level[-1].error:
            return Saturation(MODEL, level[0].setting, level[0].error)
    return Saturation()


def order(ladder: Sequence[Point]) -> Order:
    """Least-squares slope of log error against log spent over the convergent rungs, with Student's interval.

    Convergent: clear above truth, reading and rounding, and not beyond the rung where the ladder saturates.
    """
    settled = saturation(ladder)
    names = [p.setting for p in ladder]
    convergent = ladder[: names.index(settled.setting) + 1] if settled.cause == MODEL else ladder
    used = [p for p in convergent if isfinite(p.error) and isfinite(p.spent) and p.spent > 0 and not p.limit]
    settings = tuple(p.setting for p in used)
    if len(used) < LEAST_RUNGS:
        note = f"no order: {len(used)} of {len(ladder)} right rungs stand above the floor, {LEAST_RUNGS} are needed"
        return Order(nan, nan, nan, settings, note)
    spent, sizes = np.array([p.spent for p in used], dtype=float), np.array([p.error for p in used])
    if spent.max() < LEAST_SPAN * spent.min():
        return Order(nan, nan, nan, settings, f"no order: steps differ by less than a factor {LEAST_SPAN:g}")
    slope, half = _line(np.log(spent), np.log(sizes))
    return Order(-slope, -slope - half, -slope + half, settings, "")


def _line(x: np.ndarray, y: np.ndarray) -> tuple[float, float]:
    """Slope of the least-squares line and the half-width of its confidence interval."""
    from scipy.stats import t

    off = x - x.mean()
    slope = float(off @ y / (off @ off))
    left = y - y.mean() - slope * off
    freedom = len(x) - 2
    return slope, float(t.ppf(0.5 + CONFIDENCE / 2, freedom) * np.sqrt(left @ left / freedom / (off @ off)))
