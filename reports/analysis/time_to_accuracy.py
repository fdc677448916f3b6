"""What each route takes to an accuracy, from rows of `work_precision`: only what stands is awarded (`reached`)."""

from __future__ import annotations

from collections.abc import Sequence
from math import floor, isfinite, nan
from typing import Any

from ..running.records import REFERENCE
from .accuracy_levels import ACCURACIES
from .work_precision import groups

# What came of asking for an accuracy: only the first has a time.
YES, BY_CHANCE, NEVER = "reached", "by chance", "never"
NOT_TIMED, NOT_KNOWN, DISTURBED = "not timed", "not known", "disturbed"
# What is told of the setting that reaches it.
_OF_SETTING = (
    "setting", "finer_rungs", "cpu_s", "cpu_low_s", "cpu_high_s", "call_s", "first_call_s", "engine_s", "binding_s",
    "callback_s", "notes_s",
)  # fmt: skip
_RELATIVE = ("ratio", "ratio_low", "ratio_high", "rank", "break_even_runs")


def rows(points: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """The cheapest setting of each route for each accuracy, and its ratio to the fastest route's.

    `award` is reached, or why there is no time: by chance (a setting is as accurate, and a finer one or the doubt of
    the reading contradicts it), never (no setting is), not timed (it is reached, and the budget did not come to it),
    not known (the truth itself is not that sure), disturbed (the machine was, so that nothing is ranked by it). The
    ratio's interval is that of both times. `rank` counts the routes that are faster for sure, their intervals being
    apart, and one: routes that share it cannot be told apart; who has too few repeats for an interval has none.
    `null_reaches`: a null motion is as accurate.
    """
    told = []
    for (_, _), of_quantity in groups(points, "case", "quantity").items():
        for accuracy in ACCURACIES:
            told += _at(of_quantity, accuracy)
    return told


def _at(points: Sequence[dict[str, Any]], accuracy: float) -> list[dict[str, Any]]:
    """The rows of one case, quantity and accuracy."""
    best = {who: award(group, accuracy) for who, group in groups(points, "solver", "route").items()}
    found = [point for _, point in best.values() if point]
    ranked = [p for p in found if not p["disturbed"] and isfinite(p["cpu_low_s"])]
    fastest = min(found, key=lambda p: p["cpu_s"], default=None)
    own = [p for p in ranked if p["solver"] == REFERENCE]
    told = []
    for (solver, route), (word, point) in best.items():
        row: dict[str, Any] = {name: points[0][name] for name in ("case", "quantity", "unit", "lead")}
        row |= {"accuracy": accuracy, "solver": solver, "route": route, "award": word}
        row |= {name: point[name] if point and word == YES else _nothing(name) for name in _OF_SETTING}
        row |= dict.fromkeys(_RELATIVE, nan)
        if point and word == YES:
            if isfinite(point["cpu_low_s"]):
                row["rank"] = 1.0 + sum(other["cpu_high_s"] < point["cpu_low_s"] for other in ranked)
            # Who is the fastest is not known if it may be one that was disturbed.
            if fastest is not None and not fastest["disturbed"]:
                row |= dict(zip(("ratio_low", "ratio", "ratio_high"), ratio_of_intervals(point, fastest), strict=True))
            if solver != REFERENCE:
                row["break_even_runs"] = break_even([point], own)
        told.append({**row, "null_reaches": points[0]["null_error"] <= accuracy})
    return told


def _nothing(name: str) -> Any:
    return "" if name == "setting" else nan


def award(group: Sequence[dict[str, Any]], accuracy: float) -> tuple[str, dict[str, Any] | None]:
    """The word for a route's rows (one quantity) at an accuracy, and the cheapest timed row that stands within it."""
    if group[0]["floor_error"] > accuracy:
        return NOT_KNOWN, None
    able = [row for row in group if max(row["standing_error"], row["floor_error"]) <= accuracy]
    timed = [row for row in able if isfinite(row["cpu_s"])]
    if timed:
        cheapest = min(timed, key=lambda row: row["cpu_s"])
        return DISTURBED if cheapest["disturbed"] else YES, cheapest
    if able:
        return NOT_TIMED, None
    return BY_CHANCE if any(row["absolute_error"] <= accuracy for row in group) else NEVER, None


def ratio_of_intervals(one: dict[str, Any], other: dict[str, Any]) -> tuple[float, float, float]:
    """CPU time of one row in units of the other's: least, of medians, greatest that both intervals allow."""
    if one is other:
        return 1.0, 1.0, 1.0
    return (
        one["cpu_low_s"] / other["cpu_high_s"],
        one["cpu_s"] / other["cpu_s"],
        one["cpu_high_s"] / other["cpu_low_s"],
    )


def cost(row: dict[str, Any], runs: int) -> float:
    """CPU seconds of so many whole calls one after the other, the first from cold; NaN where one was not timed."""
    return row["first_call_s"] + (runs - 1) * row["call_s"]


def break_even(engines: Sequence[dict[str, Any]], own: Sequence[dict[str, Any]]) -> float:
    """From how many whole calls on the cheapest method of the reference is cheaper than every one of these rows; NaN
    if it never is, or calls were not timed."""
    engines = [row for row in engines if isfinite(cost(row, 1))]
    counts = [max((_crossing(e, method) for e in engines), default=nan) for method in own if isfinite(cost(method, 1))]
    return min((count for count in counts if isfinite(count)), default=nan)


def _crossing(engine: dict[str, Any], method: dict[str, Any]) -> float:
    """From how many calls on the method is cheaper than the engine, infinite if never."""
    dearer, saved = cost(method, 1) - cost(engine, 1), engine["call_s"] - method["call_s"]
    if dearer <= 0.0:
        return 1.0 if saved >= 0.0 else float("inf")
    return float(floor(dearer / saved) + 2) if saved > 0.0 else float("inf")
