"""How an error falls with what is spent: the order, its confidence interval, and where it no longer falls and why."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite, nan
from typing import Any, NamedTuple

import numpy as np

from ..running.records import Experiment, Run, Truth, finest, first_error, is_default, is_truth, routes

# An error counts where it stands this far above what truth, reading and arithmetic can tell: there a tenth of it is
# theirs.
ABOVE = 10.0
# Fewer rungs, or rungs that differ less in steps, make a slope of noise.
LEAST_RUNGS, LEAST_SPAN = 3, 4.0
CONFIDENCE = 0.95
# A ladder's last rungs are level if the finest is better than the worst of them by no more than this factor, over at
# least LEAST_SPAN in steps: a method of order one half would have gained a factor of two.
_FLAT = 1.5
# Rounding of a time read at the end of a run of very many steps, in units of its last place.
_ULPS = 16
# What stops an error from falling: the truth's own bar, the reading from samples, rounding, or something of the
# engine's that the ladder does not refine.
TRUTH, READING, ROUNDING, MODEL = "truth", "reading", "rounding", "model"


class ConvergencePoint(NamedTuple):
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


def saturation(ladder: Sequence[ConvergencePoint]) -> Saturation:
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


def order(ladder: Sequence[ConvergencePoint]) -> Order:
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
    from scipy.special import stdtrit  # as scipy.stats.t.ppf, whose import takes as long as a quick report's tables

    off = x - x.mean()
    slope = float(off @ y / (off @ off))
    left = y - y.mean() - slope * off
    freedom = len(x) - 2
    return slope, float(stdtrit(freedom, 0.5 + CONFIDENCE / 2) * np.sqrt(left @ left / freedom / (off @ off)))


# --- rows -------------------------------------------------------------------------------------------------------------


def convergence_rows(experiment: Experiment) -> list[dict[str, Any]]:
    """One row per route and quantity: the observed order with its confidence interval, the error of the finest rung,
    and what keeps the finest rungs from improving (`saturation`)."""
    rows = []
    for (case, solver, route), group in routes(experiment.runs).items():
        fine = finest(group)
        if fine is None:
            continue
        truth = experiment.truths[case]
        ladder = [run for run in group if run.outcome == "right" and not is_default(run) and not is_truth(run, truth)]
        quantities = [("centre_max", [run.distance.centre_max for run in ladder], 0.0, fine.distance.centre_max)]
        if truth.transitions:
            errors = [first_error(run) for run in ladder]
            quantities.insert(0, ("first_transition_time", errors, _floor(truth), first_error(fine)))
        for quantity, errors, floor, finest_error in quantities:
            points = _points(ladder, errors, floor)
            fit, settled = order(points), saturation(points)
            rows.append(
                {
                    "case": case,
                    "solver": solver,
                    "route": route,
                    "quantity": quantity,
                    "order": fit.order,
                    "order_low": fit.low,
                    "order_high": fit.high,
                    "finest_error": finest_error,
                    "settings_used": " | ".join(fit.settings),
                    "note": fit.note,
                    "saturation": settled.cause,
                    "saturated_from": settled.setting,
                }
            )
    return rows


def _floor(truth: Truth) -> float:
    return max(truth.error_bars[0], _ULPS * float(np.spacing(truth.transitions[0].time)))


def _points(ladder: Sequence[Run], errors: Sequence[float], floor: float) -> list[ConvergencePoint]:
    return [
        ConvergencePoint(str(run.setting), run.cost.steps, abs(size), floor, _doubt(run), rounding(run))
        for run, size in zip(ladder, errors, strict=True)
    ]


def _doubt(run: Run) -> float:
    """How sure the reading of the first transition is, s."""
    return run.spreads[0] if run.spreads and isfinite(run.spreads[0]) else 0.0


def rounding(run: Run) -> float:
    """Rounding of a sum of as many terms as the run has steps, of the order one."""
    return float(np.finfo(float).eps) * max(run.cost.steps, 1) ** 0.5
