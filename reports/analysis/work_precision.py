"""What accuracy costs in time: errors of the experiment beside timings of the clock, as rows.

Only right runs count, and only times taken alone on a quiet machine are ranked.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import inf, isfinite, nan
from typing import Any, NamedTuple

from ..running.records import Experiment, Run, is_default, routes
from ..running.timing.clock import UNTIMED, Timing
from ..running.timing.cold_start import ColdStart
from ..running.timing.time_breakdown import TimeBreakdown
from ..running.timing.timings import Key
from . import accuracy_levels, convergence, quantities
from .baselines import Baseline
from .quantities import UNITS, error


class CostMeasurements(NamedTuple):
    """Labels of the cases timed, timings, baselines by case, and what could not be timed, with the reason; of the
    settings that reach an accuracy first also one call from cold, and the parts of a run."""

    cases: tuple[str, ...] = ()
    timings: Mapping[Key, Timing] = {}
    nulls: Mapping[str, Baseline] = {}
    failures: Mapping[str, str] = {}
    cold: Mapping[Key, ColdStart] = {}
    parts: Mapping[Key, TimeBreakdown] = {}


def floor(experiment: Experiment, measured: CostMeasurements, label: str, quantity: str) -> float:
    """Ten times the truth's error bar: below it no error is told. Infinite where the bar is not known."""
    bar = quantities.bar(experiment.truths[label], quantity, measured.nulls[label].witnessed)
    return convergence.ABOVE * bar if isfinite(bar) else inf


def quantities_of(experiment: Experiment, measured: CostMeasurements, label: str) -> list[str]:
    """What can be asked of a case: nothing about transitions where there are none."""
    return [q for q in UNITS if isfinite(floor(experiment, measured, label, q))]


def _runs_with_times(experiment: Experiment, measured: CostMeasurements) -> list[Run]:
    """The right runs of the timed cases."""
    return [run for run in experiment.runs if run.case in measured.cases and run.outcome == "right"]


def null_error(measured: CostMeasurements, label: str, quantity: str) -> tuple[float, str]:
    """The best that a null motion scores, and which; NaN where none scores anything."""
    scores = [(row[quantity], row["motion"]) for row in measured.nulls[label].rows if isfinite(row[quantity])]
    return min(scores, default=(nan, ""))


def work_precision_rows(experiment: Experiment, measured: CostMeasurements) -> list[dict[str, Any]]:
    """One row per right run of a timed case and quantity it tells. Times are empty where the budget left none for it.

    `standing_error`: the largest error, doubt included, of this rung and all finer ones (`reached`), empty where a
    finer motion is wrong. `below_floor`: the error is below ten times the truth's bar, so that its size is not known.
    `null_error`: what the best of the null motions scores, `null_motion`.
    """
    rows = []
    for (case, solver, route), ladder in routes(r for r in experiment.runs if r.case in measured.cases).items():
        told = {
            quantity: accuracy_levels.rungs(ladder, quantity) for quantity in quantities_of(experiment, measured, case)
        }
        lead = quantities.lead(experiment.truths[case])
        lead = lead if lead in told else next(iter(told), "")
        for place, run in enumerate(ladder):
            timing = measured.timings.get((case, solver, route, run.setting), UNTIMED)
            for quantity, rungs in told.items():
                rung, least = rungs[place], floor(experiment, measured, case, quantity)
                if rung is None:
                    continue
                null, motion = null_error(measured, case, quantity)
                rows.append(
                    {
                        "case": case,
                        "solver": solver,
                        "route": route,
                        "setting": run.setting,
                        **vars(timing),
                        "steps": run.cost.steps,
                        **_parts(measured, (case, solver, route, run.setting), timing.cpu_s),
                        "quantity": quantity,
                        "unit": UNITS[quantity],
                        "lead": quantity == lead,
                        "absolute_error": rung.error,
                        "doubt": rung.doubt,
                        "standing_error": rung.standing if isfinite(rung.standing) else nan,
                        "finer_rungs": rung.finer,
                        "floor_error": least,
                        "below_floor": rung.error <= least,
                        "null_error": null,
                        "null_motion": motion,
                    }
                )
    return rows


def _parts(measured: CostMeasurements, key: Key, cpu: float) -> dict[str, float]:
    """What one call from cold takes, and the parts of a warm run, s; NaN where they were not measured."""
    cold, parts = measured.cold.get(key), measured.parts.get(key)
    shares = parts._asdict() if parts else dict.fromkeys(TimeBreakdown._fields, nan)
    return {"first_call_s": cold.call_s if cold else nan} | {f"{n}_s": share * cpu for n, share in shares.items()}


def fit_rows(experiment: Experiment, measured: CostMeasurements) -> list[dict[str, Any]]:
    """One row per route and quantity of a timed case: order in steps and in CPU time, each with its 95 % interval, and
    where and why the error saturates (`convergence`). The engine's own defaults are no rung; disturbed times do not
    count."""
    rows = []
    ladders = routes(run for run in _runs_with_times(experiment, measured) if not is_default(run))
    for (case, solver, route), group in ladders.items():
        for quantity in quantities_of(experiment, measured, case):
            bar = floor(experiment, measured, case, quantity) / convergence.ABOVE
            ladder = [
                convergence.ConvergencePoint(
                    str(run.setting),
                    run.cost.steps,
                    error(run, quantity),
                    bar,
                    quantities.doubt(run, quantity),
                    quantities.rounding(run, quantity),
                )
                for run in group
            ]
            if not any(isfinite(point.error) for point in ladder):
                continue
            by_steps, settled = convergence.order(ladder), convergence.saturation(ladder)
            spent = [_rank_by_cpu(measured, (case, solver, route, run.setting)) for run in group]
            by_time = convergence.order([p._replace(spent=s) for p, s in zip(ladder, spent, strict=True)])
            rows.append(
                {
                    "case": case,
                    "solver": solver,
                    "route": route,
                    "quantity": quantity,
                    "settings": len(ladder),
                    "order": by_steps.order,
                    "order_low": by_steps.low,
                    "order_high": by_steps.high,
                    "order_in_time": by_time.order,
                    "order_in_time_low": by_time.low,
                    "order_in_time_high": by_time.high,
                    "saturation": settled.cause,
                    "saturated_from": settled.setting,
                    "saturated_error": settled.error,
                    "settings_used": " | ".join(by_steps.settings),
                    "note": by_steps.note,
                }
            )
    return rows


def _rank_by_cpu(measured: CostMeasurements, key: Key) -> float:
    """CPU time, s, or NaN if there is none to be ranked by."""
    timing = measured.timings.get(key, UNTIMED)
    return nan if timing.disturbed else timing.cpu_s


def groups(rows: Iterable[dict[str, Any]], *columns: str) -> dict[tuple, list[dict[str, Any]]]:
    """Rows by the values of some columns, in the order in which they come."""
    found: dict[tuple, list[dict[str, Any]]] = {}
    for row in rows:
        found.setdefault(tuple(row[c] for c in columns), []).append(row)
    return found
