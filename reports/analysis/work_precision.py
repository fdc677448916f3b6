"""Accuracy and its cost in time: errors of the experiment and times of the timed pass, as rows.

Runs with an unusable motion are left out; times are of runs alone on a quiet machine.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import inf, isfinite, nan
from typing import Any, NamedTuple

from ..running.records import Experiment, usable
from ..running.timing.clock import NO_TIMING, Timing
from ..running.timing.cold_start import ColdStart
from ..running.timing.time_breakdown import TimeBreakdown
from ..running.timing.timed_pass import Key
from . import quantities
from .null_scores import Baseline
from .quantities import UNITS


class CostMeasurements(NamedTuple):
    """Labels of the timed cases, timings, baselines by case, and reasons for missing timings; for the settings that
    reach a level first also cold starts and time breakdowns."""

    cases: tuple[str, ...] = ()
    timings: Mapping[Key, Timing] = {}
    nulls: Mapping[str, Baseline] = {}
    failures: Mapping[str, str] = {}
    cold: Mapping[Key, ColdStart] = {}
    parts: Mapping[Key, TimeBreakdown] = {}


def floor(experiment: Experiment, measurements: CostMeasurements, label: str, quantity: str) -> float:
    """Ten times the truth's error bar: smaller errors are not known. Infinite if the bar is not known."""
    bar = quantities.bar(experiment.truths[label], quantity, measurements.nulls[label].witness_errors)
    return quantities.ABOVE * bar if isfinite(bar) else inf


def quantities_of(experiment: Experiment, measurements: CostMeasurements, label: str) -> list[str]:
    """The quantities of a case: none of transitions if there are none."""
    return [q for q in UNITS if isfinite(floor(experiment, measurements, label, q))]


def null_error(measurements: CostMeasurements, label: str, quantity: str) -> tuple[float, str]:
    """The smallest error of a null motion, and its name; NaN if none has an error."""
    scores = [(row[quantity], row["motion"]) for row in measurements.nulls[label].rows if isfinite(row[quantity])]
    return min(scores, default=(nan, ""))


def work_precision_rows(experiment: Experiment, measurements: CostMeasurements) -> list[dict[str, Any]]:
    """One row per usable run of a timed case and quantity. Times are empty if the budget left none for the run.

    `below_floor`: the error is below ten times the truth's bar, so its size is not known. `null_error`: the smallest
    error of a null motion, `null_motion`.
    """
    rows = []
    for run in (run for run in experiment.runs if run.case in measurements.cases and usable(run)):
        for quantity in quantities_of(experiment, measurements, run.case):
            error, least = quantities.error(run, quantity), floor(experiment, measurements, run.case, quantity)
            if not isfinite(error):
                continue
            null, motion = null_error(measurements, run.case, quantity)
            rows.append(
                {
                    "case": run.case,
                    "solver": run.solver,
                    "route": run.route,
                    "setting": run.setting,
                    "steps": run.cost.steps,
                    **times_of(measurements, (run.case, run.solver, run.route, run.setting)),
                    "quantity": quantity,
                    "unit": UNITS[quantity],
                    "absolute_error": error,
                    "doubt": quantities.doubt(run, quantity),
                    "floor_error": least,
                    "below_floor": error <= least,
                    "null_error": null,
                    "null_motion": motion,
                }
            )
    return rows


def times_of(measurements: CostMeasurements, key: Key) -> dict[str, Any]:
    """Columns of a setting's times, s: those of the clock, of the first call, and of the parts of a warm run; NaN if
    they were not measured."""
    timing = measurements.timings.get(key, NO_TIMING)
    cold, parts = measurements.cold.get(key), measurements.parts.get(key)
    shares = parts._asdict() if parts else dict.fromkeys(TimeBreakdown._fields, nan)
    first = {"first_call_s": cold.call_s if cold else nan}
    return {**vars(timing), **first, **{f"{name}_s": share * timing.cpu_s for name, share in shares.items()}}


def quiet_cpu(measurements: CostMeasurements, key: Key) -> float:
    """CPU time, s; NaN if it was disturbed or not measured."""
    timing = measurements.timings.get(key, NO_TIMING)
    return nan if timing.disturbed else timing.cpu_s


def groups(rows: Iterable[dict[str, Any]], *columns: str) -> dict[tuple, list[dict[str, Any]]]:
    """Rows by the values of some columns, in their order."""
    rows_by_key: dict[tuple, list[dict[str, Any]]] = {}
    for row in rows:
        rows_by_key.setdefault(tuple(row[c] for c in columns), []).append(row)
    return rows_by_key
