"""The order of convergence of an error with its confidence interval, and where and why the error saturates."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite, nan
from typing import Any, NamedTuple

import numpy as np

from ..running.records import Experiment, Run, finest, is_default, is_truth, routes, usable
from . import quantities
from .work_precision import CostMeasurements, quiet_cpu

# An error counts if it is this many times the doubts by truth, reading and rounding: a tenth of it may then be theirs.
ABOVE = quantities.ABOVE
# With fewer rungs, or rungs that differ less in steps, a slope would be noise.
LEAST_RUNGS, LEAST_SPAN = 3, 4.0
CONFIDENCE = 0.95
# A ladder's last rungs are level if the finest is better than the worst of them by no more than this factor, over at
# least LEAST_SPAN in steps: a method of order one half would have gained a factor of two.
_FLAT = 1.5
# Causes of saturation: the truth's error bar, the reading from samples, rounding, or a property of the engine that the
# ladder does not refine.
TRUTH, READING, ROUNDING, MODEL = "truth", "reading", "rounding", "model"


class ConvergencePoint(NamedTuple):
    """A rung: its cost (steps, or seconds), its error, and the doubts of the error by truth, reading and rounding."""

    setting: str
    cost: float
    error: float
    truth: float = 0.0
    reading: float = 0.0
    rounding: float = 0.0

    @property
    def limit(self) -> str:
        """The doubt that the error does not exceed clearly; "" if it exceeds all of them."""
        limits = ((TRUTH, self.truth), (READING, self.reading), (ROUNDING, self.rounding))
        return next((name for name, size in limits if not self.error > ABOVE * size), "")


class Saturation(NamedTuple):
    """Why the finest rungs of a ladder no longer improve ("": they do), from which setting on, and the error there."""

    cause: str = ""
    setting: str = ""
    error: float = nan


class Order(NamedTuple):
    """p of error ~ spent**-p with its confidence interval and the settings of the fit; NaN if there is none, with the
    reason in `note`."""

    order: float
    low: float
    high: float
    settings: tuple[str, ...]
    note: str


def saturation(ladder: Sequence[ConvergencePoint]) -> Saturation:
    """The saturation of a ladder from coarse to fine; rungs without an error are left out.

    The cause is the doubt that the finest rung's error is within (truth, reading, rounding), else the model if the
    errors of the last three rungs or more are equal. It begins at the first of the rungs with the same cause.
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
        if level[-1].cost < LEAST_SPAN * level[0].cost:
            break
        if max(p.error for p in level) <= _FLAT * level[-1].error:
            return Saturation(MODEL, level[0].setting, level[0].error)
    return Saturation()


def order(ladder: Sequence[ConvergencePoint]) -> Order:
    """Least-squares slope of log error against log spent over the convergent rungs, with Student's interval.

    Convergent: clear above truth, reading and rounding, and not beyond the rung where the ladder saturates.
    """
    plateau = saturation(ladder)
    names = [p.setting for p in ladder]
    convergent = ladder[: names.index(plateau.setting) + 1] if plateau.cause == MODEL else ladder
    used = [p for p in convergent if isfinite(p.error) and isfinite(p.cost) and p.cost > 0 and not p.limit]
    settings = tuple(p.setting for p in used)
    if len(used) < LEAST_RUNGS:
        note = f"no order: {len(used)} of {len(ladder)} rungs are above the floor, {LEAST_RUNGS} are needed"
        return Order(nan, nan, nan, settings, note)
    cost, sizes = np.array([p.cost for p in used], dtype=float), np.array([p.error for p in used])
    if cost.max() < LEAST_SPAN * cost.min():
        return Order(nan, nan, nan, settings, f"no order: steps differ by less than a factor {LEAST_SPAN:g}")
    slope, half = _line(np.log(cost), np.log(sizes))
    return Order(-slope, -slope - half, -slope + half, settings, "")


def _line(x: np.ndarray, y: np.ndarray) -> tuple[float, float]:
    """Slope of the least-squares line and the half-width of its confidence interval."""
    from scipy.special import stdtrit  # as scipy.stats.t.ppf, whose import takes as long as a quick report's tables

    off = x - x.mean()
    slope = float(off @ y / (off @ off))
    left = y - y.mean() - slope * off
    freedom = len(x) - 2
    return slope, float(stdtrit(freedom, 0.5 + CONFIDENCE / 2) * np.sqrt(left @ left / freedom / (off @ off)))


# --- rows -------------------------------------------------------------------------------------------------------------


def ladder_of(runs: Sequence[Run], quantity: str, bar: float) -> list[ConvergencePoint]:
    """The points of runs, coarse to fine; `bar`: the truth's error bar of the quantity."""
    return [
        ConvergencePoint(
            str(run.setting),
            run.cost.steps,
            quantities.error(run, quantity),
            bar,
            quantities.doubt(run, quantity),
            quantities.rounding(run, quantity),
        )
        for run in runs
    ]


# Quantities of cases that were not timed.
_QUANTITIES = ("off", "first_transition_time", "centre_max")


def convergence_rows(experiment: Experiment, costs: CostMeasurements | None = None) -> list[dict[str, Any]]:
    """One row per case, route and quantity: the observed orders in steps and in CPU time with their confidence
    intervals, the error of the finest rung, and why the finest rungs do not improve (`saturation`). All quantities of
    the timed cases, three of the others. Disturbed times are left out."""
    costs = costs or CostMeasurements()
    rows = []
    for (case, solver, route), group in routes(experiment.runs).items():
        fine, truth, is_timed = finest(group), experiment.truths[case], case in costs.cases
        if fine is None:
            continue
        runs = [run for run in group if not is_truth(run, truth) and usable(run) and not is_default(run)]
        witnessed = costs.nulls[case].witness_errors if is_timed else {}
        for quantity in dict.fromkeys((*_QUANTITIES, *(quantities.UNITS if is_timed else ()))):
            bar = quantities.bar(truth, quantity, witnessed)
            if not isfinite(bar):
                continue
            points = ladder_of(runs, quantity, bar)
            cpu = [quiet_cpu(costs, (case, solver, route, run.setting)) for run in runs]
            by_time = order([p._replace(cost=seconds) for p, seconds in zip(points, cpu, strict=True)])
            fit, plateau = order(points), saturation(points)
            rows.append(
                {
                    "case": case, "solver": solver, "route": route, "quantity": quantity,
                    "order": fit.order, "order_low": fit.low, "order_high": fit.high,
                    "finest_error": quantities.error(fine, quantity),
                    "settings_used": " | ".join(fit.settings), "note": fit.note,
                    "saturation": plateau.cause, "saturated_from": plateau.setting, "saturated_error": plateau.error,
                    "settings": len(points), "order_in_time": by_time.order, "order_in_time_low": by_time.low,
                    "order_in_time_high": by_time.high,
                }
            )  # fmt: skip
    return rows
