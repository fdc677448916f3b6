"""The quantities whose error is reported: the error of a run in each, and its doubts by the truth and the reading."""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite, nan

import numpy as np

from ..judging.distances import Distance
from ..running.records import Run, Truth, first_error

# Unit of each quantity's error. Off is a share of the error of ignoring friction's law (`judging.score`); force and
# energy are relative to the true motion's own (`distances.differences`).
UNITS = {
    "off": "share",
    "first_transition_time": "s",
    "all_transitions": "s",
    "final_pose": "m",
    "centre_rms": "m",
    "normal_force_mean": "share",
    "energy_mean": "share",
}
# An error below this many error bars of the truth is not reported.
ABOVE = 10.0
# Rounding of a time at the end of a run of very many steps, in units of its last place.
_ULPS = 16
TIMES = ("first_transition_time", "all_transitions")
# Quantities that are in a `Distance`.
DISTANCES = tuple(name for name in UNITS if name not in ("off", *TIMES))

_SHARES = ("normal_force_mean", "energy_mean")
# A share of a force or an energy is known to a few units in the last place of its terms at best.
_LEAST_SHARE = 1e-15


def error(run: Run, quantity: str) -> float:
    """The run's error, at least zero; NaN if it has none (a missed transition, a force that is not reported)."""
    if quantity == "off":
        return run.score.off if run.score else nan
    if quantity == "first_transition_time":
        return abs(first_error(run))
    if quantity == "all_transitions":
        if any(row.pairing in ("missed", "spurious") for row in run.ledger):
            return nan
        # A rebound that the samples do not resolve has no time, so no error.
        return max((abs(row.error) for row in run.ledger if isfinite(row.error)), default=nan)
    return from_distance(run.distance, quantity)


def from_distance(distance: Distance, quantity: str) -> float:
    """The error of a quantity of `DISTANCES`."""
    return float(getattr(distance, quantity))


def bar(truth: Truth, quantity: str, uncertainty: Mapping[str, float]) -> float:
    """The truth's error bar of the quantity; NaN if there is none (no transitions) or it is not known.

    Times and the centre have certified bars; `witnessed` holds the distance of the reference's second method from the
    truth's, for quantities that the certificate does not contain.
    """
    if quantity == "off":
        if truth.scale is None:
            return nan
        centre = truth.centre_bar / truth.scale.pose if isfinite(truth.centre_bar) else 0.0
        return max(centre, sum(truth.error_bars) / truth.scale.time)
    if quantity in TIMES:
        count = 1 if quantity == "first_transition_time" else len(truth.error_bars)
        bars = zip(truth.error_bars[:count], truth.transitions[:count], strict=True)
        return max((max(bar, _ULPS * float(np.spacing(event.time))) for bar, event in bars), default=nan)
    if quantity in _SHARES:
        return max(uncertainty.get(quantity, nan), _LEAST_SHARE)
    return max(truth.centre_bar, uncertainty.get(quantity, 0.0)) if isfinite(truth.centre_bar) else nan


def doubt(run: Run, quantity: str) -> float:
    """How much of the run's error may be due to its samples, in the quantity's unit; 0 if nothing is read from them."""
    if quantity == "off":
        return run.score.doubt if run.score else nan
    if quantity not in TIMES:
        return 0.0
    spreads = run.spreads[:1] if quantity == "first_transition_time" else run.spreads
    return max((spread for spread in spreads if isfinite(spread)), default=0.0)


def rounding(run: Run, quantity: str) -> float:
    """The error of the quantity by rounding alone in a run of so many steps, for sizes of the order one."""
    if quantity == "normal_force_mean":
        # A step's force is a difference of velocities over the step.
        return float(np.finfo(float).eps) * max(run.cost.steps, 1)
    return float(np.finfo(float).eps) * max(run.cost.steps, 1) ** 0.5
