"""The chapter "What accuracy costs in time": one table of all routes within the main level, then the measurements."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite, nan
from typing import TYPE_CHECKING, Any

from ..analysis import cost_conclusions
from ..analysis.levels import ONE_SETTING
from ..analysis.number_format import seconds, times
from ..analysis.time_to_accuracy import WITH_TIMES, cost
from ..analysis.work_precision import CostMeasurements, groups
from ..drawing.colours import LineStyles
from ..drawing.figures import LEAST_OFF, against_cost
from ..judging.grades import LEVELS, percent
from .fragments import figure_of, records, switch
from .page_table import Cell, Head, PageRow, PageTable, number_cell

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
        "calls": _calls(time_rows),
        "failed": list(measurements.failures.items()),
        "levels": _levels(time_rows),
        "charts": [chart for case in measurements.cases for chart in _charts(case, points, looks)],
    }


def _charts(case: str, points: Sequence[dict[str, Any]], looks: LineStyles) -> list[dict[str, Any]]:
    """Off and the error of the first transition against the time of every setting of a case."""
    charts = []
    for quantity in ("off", "first_transition_time"):
        rows = [row for row in points if (row["case"], row["quantity"]) == (case, quantity)]
        floor = max([LEAST_OFF if quantity == "off" else 0.0, *(row["floor_error"] for row in rows)])
        chart = figure_of(against_cost(case, rows, quantity=quantity, floor=floor), looks, 300.0)
        charts += [chart] if chart else []
    return charts


def _calls(time_rows: Sequence[dict[str, Any]]) -> PageTable:
    """The routes within the main level, case by case, the fastest first run first: whole calls and the parts of a warm
    run."""
    lines = []
    reaching = [r for r in time_rows if r["reached"] in WITH_TIMES and r["level"] == cost_conclusions.LEVEL]
    for group in groups(reaching, "case").values():
        for row in sorted(group, key=lambda r: (not isfinite(cost(r, 1)), cost(r, 1), r["call_s"])):
            runs = row["break_even_runs"]
            durations = (cost(row, 1), cost(row, 1000), row["call_s"], *(row[name] for name in _PARTS))
            cells = [number_cell(seconds(value) if isfinite(value) else "", value) for value in durations]
            cells.append(number_cell(f"{runs:,.0f}" if isfinite(runs) else "", runs))
            lines.append(_line(row, cells))
    titles = ("first run, cold start", "1,000 runs", "whole call, warm", *_PARTS.values())
    even = "number of whole calls from which on the reference is faster; empty: never, or not known"
    heads = [*_heads(titles), Head("reference faster from", number=True, tip=even)]
    return PageTable("calls", heads, lines, "short calls")


def _levels(time_rows: Sequence[dict[str, Any]]) -> PageTable:
    """Cases and routes against levels of off."""
    lines = []
    for _, group in groups(time_rows, "case", "solver", "route").items():
        by_level = {row["level"]: row for row in group}
        lines.append(_line(group[0], [_level_cell(by_level[level]) for level in LEVELS]))
    heads = _heads([f"≤ {percent(level)}" for level in LEVELS])
    return PageTable("time to a level", heads, lines, "", "time_to_accuracy", len(lines), len(heads))


def _heads(titles: Sequence[str]) -> list[Head]:
    return [Head("case"), Head("route"), *(Head(title, number=True) for title in titles)]


def _line(row: Mapping[str, Any], cells: Sequence[Cell]) -> PageRow:
    """A row of a case and a route."""
    names = [Cell(row["case"]), Cell(f"{row['solver']} {row['route']}")]
    return PageRow([*names, *cells], row["solver"], switch(row["solver"], row["route"]), group=row["case"])


def _level_cell(row: dict[str, Any]) -> Cell:
    if row["reached"] not in WITH_TIMES:
        return number_cell(row["reached"], nan)
    ratio = f" ({times(row['ratio'])})" if isfinite(row["ratio"]) else ""
    mark = "°" if row["reached"] == ONE_SETTING else ""
    return number_cell(f"{seconds(row['cpu_s'])}{mark}{ratio}", row["cpu_s"])
