"""The fastest engine and the fastest method of the reference for each level, for the first run and for 1,000 runs."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite, nan
from typing import Any

from ..judging.grades import LEVELS, LIMITS, Grade
from ..running.names import REFERENCE
from .levels import BEYOND
from .time_to_accuracy import WITH_TIMES, break_even, cost
from .work_precision import groups

# One run, as in a first try of an engine, and as many as in a sweep or a training.
RUNS = (1, 1000)
# Levels whose cold starts and time breakdowns are measured: a rough motion is not worth their time.
MEASURED = tuple(level for level in LEVELS if level <= LIMITS[Grade.GOOD])
# A smaller factor counts as a tie: two processes may differ by that much, and cold starts are few.
TIE_BELOW = 1.1
TIE = "tie"
NO_ENGINE = "no engine reaches it"


def cold_start_keys(times: Sequence[dict[str, Any]]) -> set[tuple]:
    """Case, solver, route and setting of all rows whose cold starts and time breakdowns are needed."""
    return {
        (r["case"], r["solver"], r["route"], r["setting"])
        for r in times
        if r["level"] in MEASURED and r["reached"] in WITH_TIMES
    }


def rows(times: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """One row per case, level and number of runs: the fastest engine and the fastest method of the reference, by whole
    calls from Python, the first with a cold start.

    `cheaper` names the faster one, with its `factor`, or is "tie"; it is empty if one of the two has no time, and
    `reason` says why. `engine_alone_s`: the part of the engine's compiled code. `break_even_runs`: the number of runs
    from which on the reference is faster than every engine; empty: never.
    """
    return [
        _answer(case, level, runs, rows_of_level)
        for (case, level), rows_of_level in groups(times, "case", "level").items()
        for runs in RUNS
    ]


def _answer(case: str, level: float, runs: int, rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    candidates = [r for r in rows if isfinite(cost(r, runs))]
    engines, own = ([r for r in candidates if (r["solver"] == REFERENCE) == ours] for ours in (False, True))
    engine, method = (min(group, key=lambda r: cost(r, runs), default=None) for group in (engines, own))
    row: dict[str, Any] = {"case": case, "level": level, "runs": runs}
    row |= _side("engine", engine, runs) | _side("reference", method, runs)
    row["engine_alone_s"] = runs * engine["engine_s"] if engine else nan
    row |= {"cheaper": "", "factor": nan, "break_even_runs": nan, "reason": ""}
    if not engine or not method:
        row["reason"] = "; ".join(_reason(rows, side) for side, one in ((True, engine), (False, method)) if one is None)
        return row
    totals = (row["engine_total_s"], row["reference_total_s"])
    row["factor"] = max(totals) / min(totals)
    faster = row["engine"] if totals[0] < totals[1] else row["reference"]
    row["cheaper"] = TIE if row["factor"] < TIE_BELOW else faster
    row["break_even_runs"] = break_even(engines, own)
    return row


def _side(name: str, row: dict[str, Any] | None, runs: int) -> dict[str, Any]:
    """Route, setting and seconds of the fastest of a side, "engine" or "reference"."""
    if row is None:
        return {name: "", f"{name}_setting": "", f"{name}_total_s": nan}
    route = f"{row['solver']} {row['route']}"
    return {name: route, f"{name}_setting": row["setting"], f"{name}_total_s": cost(row, runs)}


def _reason(rows: Sequence[dict[str, Any]], engines: bool) -> str:
    """Why one side has no time."""
    side = [r for r in rows if (r["solver"] != REFERENCE) == engines]
    if not any(r["reached"] in WITH_TIMES for r in side):
        words = dict.fromkeys(r["reached"] for r in side)
        if engines and set(words) <= {BEYOND}:
            return NO_ENGINE
        return f"{'the engines' if engines else 'the reference'}: {', '.join(words)}" if words else "none was timed"
    return f"{'the engines have' if engines else 'the reference has'} no time of a cold start"
