"""What a motion is asked for: the error of a run in each quantity, and how sure truth and reading are of it."""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite, nan

import numpy as np

from ..judging.distances import Distance
from ..running.records import Run, Truth, first_error
from .convergence import ABOVE as ABOVE
from .convergence import rounding as step_rounding

# The unit of each quantity's error. Force and energy are parts of the true motion's own (`distances.differences`).
UNITS = {
    "first_transition_time": "s",
    "all_transitions": "s",
    "final_pose": "m",
    "centre_rms": "m",
    "normal_force_mean": "part",
    "energy_mean": "part",
}
TIMES = ("first_transition_time", "all_transitions")
# A single event may be met by chance; several of them, or a pose, are not.
_SEVERAL = 2

_SHARES = ("normal_force_mean", "energy_mean")
# No share of a force or an energy is known better than to a few units in the last place of its terms.
_LEAST_SHARE = 1e-15


def lead(truth: Truth) -> str:
    """What a case is judged by first: all its transitions where there are several, else where the plate ends."""
    return "all_transitions" if len(truth.transitions) >= _SEVERAL else "final_pose"


def error(run: Run, quantity: str) -> float:
    """The run's error, at least zero; NaN where there is none (a missed transition, a force that is not told)."""
    if quantity == "first_transition_time":
        return abs(first_error(run))
    if quantity == "all_transitions":
        if any(row.verdict in ("missed", "spurious") for row in run.ledger):
            return nan
        # A rebound that no sample resolves has no time to be wrong by.
        return max((abs(row.error) for row in run.ledger if isfinite(row.error)), default=nan)
    return from_distance(run.distance, quantity)


def from_distance(distance: Distance, quantity: str) -> float:
    """The error of a quantity that is no time of a transition."""
    return float(getattr(distance, quantity))


def bar(truth: Truth, quantity: str, witnessed: Mapping[str, float]) -> float:
    """How sure the truth is of the quantity; NaN where it has none (no transitions) or it is not known.

    Times and the centre have certified bars; `witnessed` holds how far the reference's second method is from the
    truth's, for what the certificate does not keep.
    """
    if quantity in TIMES:
        bars = truth.error_bars[:1] if quantity == "first_transition_time" else truth.error_bars
        return max(bars, default=nan)
    if quantity in _SHARES:
        return max(witnessed.get(quantity, nan), _LEAST_SHARE)
    return max(truth.centre_bar, witnessed.get(quantity, 0.0)) if isfinite(truth.centre_bar) else nan


def doubt(run: Run, quantity: str) -> float:
    """How sure the reading of the run's transitions from its samples is, s; 0 where nothing is read."""
    if quantity not in TIMES:
        return 0.0
    spreads = run.spreads[:1] if quantity == "first_transition_time" else run.spreads
    return max((spread for spread in spreads if isfinite(spread)), default=0.0)


def rounding(run: Run, quantity: str) -> float:
    """What rounding alone makes of the quantity in a run of so many steps, all sizes being of the order one."""
    if quantity == "normal_force_mean":
        # A step's force is a difference of velocities over the step.
        return float(np.finfo(float).eps) * max(run.cost.steps, 1)
    return step_rounding(run)
