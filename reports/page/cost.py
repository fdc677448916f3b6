"""The chapter "What accuracy costs in time": one table of all routes within the main level, then the measurements."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite
from typing import TYPE_CHECKING, Any

from ..analysis import cost_conclusions
from ..analysis.levels import ONE_SETTING
from ..analysis.number_format import seconds, times
from ..analysis.time_to_accuracy import WITH_TIMES, cost
from ..analysis.work_precision import CostMeasurements, groups
from ..drawing.colours import LineStyles
from ..drawing.figures import LEAST_OFF, against_cost
from ..judging.grades import LEVELS, percent
from ..running.names import REFERENCE
from .fragments import figure_of, records, switch

if TYPE_CHECKING:
    import pandas as pd

# Parts of a warm run, with the headings of their columns.
_PARTS = {"cpu_s": "run, warm", "engine_s": "engine", "binding_s": "binding", "callback_s": "our callback",
          "notes_s": "our recording"}  # fmt: skip


def section(
    measurements: CostMeasurements,
    frames: Mapping[str, pd.DataFrame],
    looks: LineStyles,
) -> dict[str, Any] | None:
    """Data for the chapter's template; None if nothing was timed."""
    if not measurements.cases:
        return None
    answers, time_rows, points = (
        records(frames[name]) for name in ("which_engine", "time_to_accuracy", "work_precision")
    )
    headline = cost_conclusions.headline(answers, time_rows)
    return {
        "first": headline.first,
        "rest": f"{headline.rest} {cost_conclusions.set_up(points)}",
        "level": percent(cost_conclusions.LEVEL),
        "parts": list(_PARTS.values()),
        "calls": _calls(time_rows),
        "failed": list(measurements.failures.items()),
        "levels": _levels(time_rows),
        "charts": [chart for case in measurements.cases for chart in _charts(case, points, looks)],
    }


def _charts(case: str, points: Sequence[dict[str, Any]], looks: LineStyles) -> list[dict[str, Any]]:
    """Off and the error of the first transition against the time of every setting of a case."""
    charts = []
    for quantity in ("off", "first_transition_time"):
        own = [row for row in points if (row["case"], row["quantity"]) == (case, quantity)]
        rows = [row | {"error": row["absolute_error"]} for row in own]
        floor = max([LEAST_OFF if quantity == "off" else 0.0, *(row["floor_error"] for row in rows)])
        chart = figure_of(against_cost(case, rows, quantity=quantity, floor=floor), looks, 300.0)
        charts += [chart] if chart else []
    return charts


def _calls(time_rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """The routes within the main level, case by case, the fastest first run first: whole calls and the parts of a warm
    run."""
    table_rows = []
    reaching = [r for r in time_rows if r["reached"] in WITH_TIMES and r["level"] == cost_conclusions.LEVEL]
    for (case,), group in groups(reaching, "case").items():
        for row in sorted(group, key=lambda r: (not isfinite(cost(r, 1)), cost(r, 1), r["call_s"])):
            runs = row["break_even_runs"]
            table_rows.append(
                {
                    "case": case,
                    "solver": row["solver"],
                    "route": row["route"],
                    "switch": switch(row["solver"], row["route"]),
                    "is_reference": row["solver"] == REFERENCE,
                    "first": _time(cost(row, 1)),
                    "thousand": _time(cost(row, 1000)),
                    "call": _time(row["call_s"]),
                    "parts": [_time(row[name]) for name in _PARTS],
                    "even": _number(f"{runs:,.0f}" if isfinite(runs) else "", runs),
                }
            )
    return table_rows


def _levels(time_rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Cases and routes against levels of off."""
    rows = []
    for _, group in groups(time_rows, "case", "solver", "route").items():
        by_level = {row["level"]: row for row in group}
        cells = [_text(group[0]["case"]), _text(f"{group[0]['solver']} {group[0]['route']}")]
        cells += [_level_cell(by_level[level]) for level in LEVELS]
        where = {"solver": group[0]["solver"], "route": switch(group[0]["solver"], group[0]["route"])}
        rows.append(where | {"cells": cells})
    heads = [
        _head(name, place > 1) for place, name in enumerate(("case", "route", *(f"≤ {percent(v)}" for v in LEVELS)))
    ]
    return {"heads": heads, "rows": rows, "count": len(rows), "columns": len(heads), "file": "time_to_accuracy"}


def _level_cell(row: dict[str, Any]) -> dict[str, Any]:
    if row["reached"] not in WITH_TIMES:
        return _number(row["reached"], float("inf"))
    ratio = f" ({times(row['ratio'])})" if isfinite(row["ratio"]) else ""
    mark = "°" if row["reached"] == ONE_SETTING else ""
    return _number(f"{seconds(row['cpu_s'])}{mark}{ratio}", row["cpu_s"])


def _head(name: str, is_number: bool) -> dict[str, Any]:
    return {"title": name, "unit": "", "column": "", "number": is_number, "tip": ""}


def _text(text: str) -> dict[str, Any]:
    return {"text": text, "kind": "", "order": None}


def _time(value: float) -> dict[str, Any]:
    return _number(seconds(value) if isfinite(value) else "", value)


def _number(text: str, value: float) -> dict[str, Any]:
    """A cell that is sorted by a number; a cell without one is sorted last."""
    return {"text": text, "kind": "number", "order": f"{value:.10g}" if isfinite(value) else "1e308"}
