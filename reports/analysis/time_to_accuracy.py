"""CPU time of each route to each level of accuracy, by the settings that stay within it (`levels`)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import floor, isfinite, nan
from typing import Any

from ..judging.grades import LEVELS
from ..running.names import REFERENCE
from ..running.records import Experiment
from .levels import ONE_SETTING, WITHIN, LevelResult, level_results
from .work_precision import CostMeasurements, times_of

# Further values of the column `reached`: the level is reached, but there is no time, or none to rank by.
NOT_TIMED, DISTURBED = "not timed", "disturbed"
# Values with a time.
WITH_TIMES = (WITHIN, ONE_SETTING)
# Columns of the setting.
_OF_SETTING = (
    "setting", "settings_within", "cpu_s", "cpu_low_s", "cpu_high_s", "call_s", "first_call_s", "engine_s", "binding_s",
    "callback_s", "notes_s",
)  # fmt: skip
_RELATIVE = ("ratio", "ratio_low", "ratio_high", "rank", "break_even_runs")


def rows(experiment: Experiment, measurements: CostMeasurements) -> list[dict[str, Any]]:
    """The fastest setting of each route within each level, and its ratio to the fastest route's.

    `reached` is that of `levels`; or not timed (the time budget did not suffice), or disturbed (by other load, so that
    it is not ranked). `settings_within`: the number of settings within the level, this one included, that are as fine
    or finer. The ratio's interval follows from those of both times. `rank` is 1 + the number of routes that are faster
    with separate intervals; routes of equal rank cannot be distinguished, and a route without an interval has none.
    """
    results = [one for one in level_results(experiment) if one.case in measurements.cases]
    return [row for case in measurements.cases for level in LEVELS for row in _at(case, level, results, measurements)]


def _at(
    case: str, level: float, results: Sequence[LevelResult], measurements: CostMeasurements
) -> list[dict[str, Any]]:
    """The rows of one case and level."""
    entrants = [one for one in results if (one.case, one.level) == (case, level)]
    best = [(one, _fastest_setting(one, measurements)) for one in entrants]
    points = [point for _, point in best if point]
    competitors = [p for p in points if not p["disturbed"] and isfinite(p["cpu_low_s"])]
    fastest = min(points, key=lambda p: p["cpu_s"], default=None)
    own = [p for p in competitors if p["solver"] == REFERENCE]
    table_rows = []
    for one, point in best:
        word = (
            one.word if not one.settings else NOT_TIMED if not point else DISTURBED if point["disturbed"] else one.word
        )
        row: dict[str, Any] = {"case": case, "level": level, "solver": one.solver, "route": one.route, "reached": word}
        row |= {name: point[name] if point and word in WITH_TIMES else _nothing(name) for name in _OF_SETTING}
        row |= dict.fromkeys(_RELATIVE, nan)
        if point and word in WITH_TIMES:
            if isfinite(point["cpu_low_s"]):
                row["rank"] = 1.0 + sum(other["cpu_high_s"] < point["cpu_low_s"] for other in competitors)
            # If the fastest is disturbed, it is not known whether it is the fastest.
            if fastest is not None and not fastest["disturbed"]:
                row |= dict(zip(("ratio_low", "ratio", "ratio_high"), ratio_of_intervals(point, fastest), strict=True))
            if one.solver != REFERENCE:
                row["break_even_runs"] = break_even([point], own)
        table_rows.append(row)
    return table_rows


def _nothing(name: str) -> Any:
    return {"setting": "", "settings_within": 0}.get(name, nan)


def _fastest_setting(one: LevelResult, measurements: CostMeasurements) -> dict[str, Any] | None:
    """The times of the fastest timed setting within the level, with its solver; None if none was timed."""
    points: list[dict[str, Any]] = [
        {"solver": one.solver, "setting": setting, "settings_within": len(one.settings) - place}
        | times_of(measurements, (one.case, one.solver, one.route, setting))
        for place, setting in enumerate(one.settings)
    ]
    return min((point for point in points if isfinite(point["cpu_s"])), key=lambda p: p["cpu_s"], default=None)


def ratio_of_intervals(one: dict[str, Any], other: dict[str, Any]) -> tuple[float, float, float]:
    """CPU time of one row in units of the other's: least, of medians, greatest that both intervals allow."""
    if one is other:
        return 1.0, 1.0, 1.0
    return (
        one["cpu_low_s"] / other["cpu_high_s"],
        one["cpu_s"] / other["cpu_s"],
        one["cpu_high_s"] / other["cpu_low_s"],
    )


def cost(row: Mapping[str, Any], runs: int) -> float:
    """CPU seconds of so many whole calls in sequence, the first with a cold start; NaN if one was not timed."""
    return row["first_call_s"] + (runs - 1) * row["call_s"]


def break_even(engines: Sequence[dict[str, Any]], own: Sequence[dict[str, Any]]) -> float:
    """The number of whole calls from which on the cheapest method of the reference is cheaper than all of these rows;
    NaN if it never is, or if calls were not timed."""
    engines = [row for row in engines if isfinite(cost(row, 1))]
    counts = [max((_crossing(e, method) for e in engines), default=nan) for method in own if isfinite(cost(method, 1))]
    return min((count for count in counts if isfinite(count)), default=nan)


def _crossing(engine: dict[str, Any], method: dict[str, Any]) -> float:
    """The number of calls from which on the method is cheaper than the engine; infinite if it never is."""
    dearer, saving = cost(method, 1) - cost(engine, 1), engine["call_s"] - method["call_s"]
    if dearer <= 0.0:
        return 1.0 if saving >= 0.0 else float("inf")
    return float(floor(dearer / saving) + 2) if saving > 0.0 else float("inf")
