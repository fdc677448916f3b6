"""What accuracy costs in time: errors of the experiment beside timings of the clock, as rows.

Only right runs count, and only times taken alone on a quiet machine are ranked.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from math import inf, isfinite, nan
from typing import TYPE_CHECKING, Any, NamedTuple

from ..running.clock import UNTIMED, Timing
from ..running.records import Experiment, Run, is_default, routes
from ..running.timings import Key
from . import convergence, quantities
from .baselines import Baseline
from .quantities import UNITS, error
from .tables import Table

if TYPE_CHECKING:
    import pandas as pd

ACCURACIES = (1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
NEVER, NOT_TIMED, NOT_KNOWN, DISTURBED = "never", "not timed", "not known", "disturbed"


class Measured(NamedTuple):
    """Labels of the cases timed, timings, baselines by case, and what could not be timed, with the reason."""

    cases: tuple[str, ...] = ()
    timings: Mapping[Key, Timing] = {}
    nulls: Mapping[str, Baseline] = {}
    failures: Mapping[str, str] = {}


def floor(experiment: Experiment, measured: Measured, label: str, quantity: str) -> float:
    """Ten times the truth's error bar: below it no error is told. Infinite where the bar is not known."""
    bar = quantities.bar(experiment.truths[label], quantity, measured.nulls[label].witnessed)
    return convergence.ABOVE * bar if isfinite(bar) else inf


def asked(experiment: Experiment, measured: Measured, label: str) -> list[str]:
    """What can be asked of a case: nothing about transitions where there are none."""
    return [q for q in UNITS if isfinite(floor(experiment, measured, label, q))]


def _timed_runs(experiment: Experiment, measured: Measured) -> list[Run]:
    """The right runs of the timed cases."""
    return [run for run in experiment.runs if run.case in measured.cases and run.outcome == "right"]


def null_error(measured: Measured, label: str, quantity: str) -> tuple[float, str]:
    """The best that a null motion scores, and which; NaN where none scores anything."""
    scores = [(row[quantity], row["motion"]) for row in measured.nulls[label].rows if isfinite(row[quantity])]
    return min(scores, default=(nan, ""))


def work_precision_rows(experiment: Experiment, measured: Measured) -> list[dict[str, Any]]:
    """One row per right run of a timed case and quantity it tells. Times are empty where the budget left none for it.

    `below_floor`: the error is below ten times the truth's bar, so that its size is not known. `null_error`: what the
    best of the null motions scores, `null_motion`.
    """
    rows = []
    for run in _timed_runs(experiment, measured):
        timing = measured.timings.get((run.case, run.solver, run.route, run.setting), UNTIMED)
        for quantity in asked(experiment, measured, run.case):
            size, least = error(run, quantity), floor(experiment, measured, run.case, quantity)
            null, motion = null_error(measured, run.case, quantity)
            if not isfinite(size):
                continue
            rows.append(
                {
                    "case": run.case,
                    "solver": run.solver,
                    "route": run.route,
                    "setting": run.setting,
                    **vars(timing),
                    "steps": run.cost.steps,
                    "error": size,
                    "quantity": quantity,
                    "floor_error": least,
                    "below_floor": size <= least,
                    "null_error": null,
                    "null_motion": motion,
                }
            )
    return rows


def fit_rows(experiment: Experiment, measured: Measured) -> list[dict[str, Any]]:
    """One row per route and quantity of a timed case: order in steps and in CPU time, each with its 95 % interval, and
    where and why the error saturates (`convergence`). The engine's own defaults are no rung; disturbed times do not
    count."""
    rows = []
    ladders = routes(run for run in _timed_runs(experiment, measured) if not is_default(run))
    for (case, solver, route), group in ladders.items():
        for quantity in asked(experiment, measured, case):
            bar = floor(experiment, measured, case, quantity) / convergence.ABOVE
            ladder = [
                convergence.Point(
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
            spent = [_ranked_cpu(measured, (case, solver, route, run.setting)) for run in group]
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


def _ranked_cpu(measured: Measured, key: Key) -> float:
    """CPU time, s, or NaN if there is none to be ranked by."""
    timing = measured.timings.get(key, UNTIMED)
    return nan if timing.disturbed else timing.cpu_s


def time_to_accuracy_rows(points: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """The cheapest setting of each route for each accuracy, and its ratio to the fastest route's.

    `cpu_s` is a number, or: never (no setting is as accurate), not timed (one is, and the budget did not reach it),
    not known (the truth itself is not that sure), disturbed (the machine was, so that nothing is ranked by it). The
    ratio's interval is that of both times. `rank` counts the routes that are faster for sure, their intervals being
    apart, and one: routes that share it cannot be told apart; who has too few repeats for an interval has none.
    `null_reaches`: a null motion is as accurate.
    """
    rows = []
    for (case, quantity), of_quantity in groups(points, "case", "quantity").items():
        for accuracy in ACCURACIES:
            best = {who: _cheapest(group, accuracy) for who, group in groups(of_quantity, "solver", "route").items()}
            found = [p for p in best.values() if not isinstance(p, str)]
            ranked = [p for p in found if not p["disturbed"] and isfinite(p["cpu_low_s"])]
            fastest = min(found, key=lambda p: p["cpu_s"], default=None)
            for (solver, route), point in best.items():
                who = {"case": case, "quantity": quantity, "accuracy": accuracy, "solver": solver, "route": route}
                times = {"cpu_s": DISTURBED, "cpu_low_s": nan, "cpu_high_s": nan, "setting": ""}
                told: dict[str, Any] = who | times | dict.fromkeys(("ratio", "ratio_low", "ratio_high", "rank"), nan)
                if isinstance(point, str):
                    told["cpu_s"] = point
                elif not point["disturbed"]:
                    told |= {name: point[name] for name in times}
                    if isfinite(point["cpu_low_s"]):
                        told["rank"] = 1.0 + sum(other["cpu_high_s"] < point["cpu_low_s"] for other in ranked)
                    # Who is the fastest is not known if it may be one that was disturbed.
                    if fastest is not None and not fastest["disturbed"]:
                        told |= dict(
                            zip(("ratio_low", "ratio", "ratio_high"), ratio_of_intervals(point, fastest), strict=True)
                        )
                rows.append({**told, "null_reaches": of_quantity[0]["null_error"] <= accuracy})
    return rows


def ratio_of_intervals(one: dict[str, Any], other: dict[str, Any]) -> tuple[float, float, float]:
    """CPU time of one row in units of the other's: least, of medians, greatest that both intervals allow."""
    if one is other:
        return 1.0, 1.0, 1.0
    return (
        one["cpu_low_s"] / other["cpu_high_s"],
        one["cpu_s"] / other["cpu_s"],
        one["cpu_high_s"] / other["cpu_low_s"],
    )


def _cheapest(group: Sequence[dict[str, Any]], accuracy: float) -> dict[str, Any] | str:
    """The cheapest timed row that is accurate enough, or the word why there is none."""
    if group[0]["floor_error"] > accuracy:
        return NOT_KNOWN
    able = [row for row in group if max(row["error"], row["floor_error"]) <= accuracy]
    timed = [row for row in able if isfinite(row["cpu_s"])]
    if timed:
        return min(timed, key=lambda row: row["cpu_s"])
    return NOT_TIMED if able else NEVER


def groups(rows: Iterable[dict[str, Any]], *columns: str) -> dict[tuple, list[dict[str, Any]]]:
    """Rows by the values of some columns, in the order in which they come."""
    found: dict[tuple, list[dict[str, Any]]] = {}
    for row in rows:
        found.setdefault(tuple(row[c] for c in columns), []).append(row)
    return found


def frames(experiment: Experiment, measured: Measured) -> dict[str, pd.DataFrame]:
    """The tables of this section by name; none if nothing was timed."""
    import pandas as pd

    if not measured.cases:
        return {}
    points = work_precision_rows(experiment, measured)
    return {
        "work_precision": pd.DataFrame(points),
        "work_precision_fits": pd.DataFrame(fit_rows(experiment, measured)),
        "time_to_accuracy": pd.DataFrame(time_to_accuracy_rows(points)),
        "null_scores": pd.DataFrame([row for told in measured.nulls.values() for row in told.rows]),
    }


WORDS = {
    "work_precision": Table("Error and CPU time of every right run of the timed cases"),
    "work_precision_fits": Table("Orders in steps and in CPU time, and where and why the error saturates"),
    "time_to_accuracy": Table("CPU time to each accuracy, and its ratio to the fastest route"),
    "null_scores": Table("What motions that know nothing of friction's law would score"),
}
