"""The chapter "What accuracy costs in time": the answer first, then the measurements behind it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..analysis import cost_conclusions, cost_tables, which_engine
from ..analysis.levels import ONE_SETTING
from ..analysis.number_format import seconds, times
from ..analysis.time_to_accuracy import WITH_TIMES
from ..analysis.work_precision import CostMeasurements, groups
from ..drawing.figure_files import FigureEntry
from ..judging.grades import LEVELS, percent
from .fragments import picture, records, switch, table

if TYPE_CHECKING:
    import pandas as pd

# Parts of a warm run, and whole calls, with the headings of their columns.
_PARTS = {
    "engine_s": "engine", "binding_s": "its binding", "callback_s": "our callback", "notes_s": "our recording",
    "cpu_s": "run, warm", "call_s": "whole call, warm", "first_call_s": "whole call, cold start",
}  # fmt: skip
# Columns of the fits that the page leaves out.
_OMITTED_COLUMNS = ("settings_used", "settings")


def section(
    measurements: CostMeasurements,
    frames: Mapping[str, pd.DataFrame],
    figure_entries: Sequence[FigureEntry],
    figures: Path,
) -> dict[str, Any] | None:
    """Data for the chapter's template; None if nothing was timed."""
    if not measurements.cases:
        return None
    answers, time_rows, points = (
        records(frames[name]) for name in ("which_engine", "time_to_accuracy", "work_precision")
    )
    headline = cost_conclusions.headline(answers, time_rows)
    fits = frames["work_precision_fits"]
    fits = fits[fits["quantity"] == "off"] if len(fits) else fits
    return {
        "first": headline.first,
        "rest": f"{headline.rest} {cost_conclusions.set_up(points)}",
        "level": percent(cost_conclusions.LEVEL),
        "runs": ["first run (cold start)" if runs == 1 else f"{runs:,} runs" for runs in which_engine.RUNS],
        "answers": _answers(answers),
        "failed": list(measurements.failures.items()),
        "shares": _shares(time_rows),
        "levels": _levels(time_rows),
        "pictures": [picture(d, figures) for d in figure_entries if d.name == "work_precision"],
        "fits": table(fits, _name(fits)),
        "nulls": table(frames["null_scores"], _name(frames["null_scores"])),
        "tables": list(cost_tables.HOLDS),
    }


def _name(frame: pd.DataFrame) -> dict[str, str]:
    return {c: c.replace("_", " ") for c in map(str, frame.columns) if c not in _OMITTED_COLUMNS}


def _answers(answers: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """A row for each case at the main level: first run and 1,000 runs, engine and reference."""
    table_rows = []
    for (case,), rows in groups([r for r in answers if r["level"] == cost_conclusions.LEVEL], "case").items():
        runs = rows[0]["break_even_runs"]
        even = f"{runs:,.0f} runs" if isfinite(runs) else ("never" if rows[0]["cheaper"] else "")
        sides = [
            _side(row, party) for row in sorted(rows, key=lambda r: r["runs"]) for party in ("engine", "reference")
        ]
        table_rows.append({"case": case, "sides": sides, "even": even, "order": _order(runs)})
    return table_rows


def _side(row: dict[str, Any], party: str) -> dict[str, Any]:
    """The fastest route of the engines or of the reference with its time, or the reason why there is none."""
    if not row[party]:
        # If there are two reasons, the engines' is the first.
        return {"reason": row["reason"].split("; ")[0 if party == "engine" else -1], "order": ""}
    total = row[f"{party}_total_s"]
    side = {"reason": "", "route": row[party], "time": seconds(total), "order": _order(total)}
    ahead = row["cheaper"] == row[party]
    return side | {"ahead": ahead, "factor": times(row["factor"]) if ahead else ""}


def _shares(time_rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Settings within the main level: the parts of a warm run, the whole call, the cold start."""
    rows = []
    reaching = [r for r in time_rows if r["reached"] in WITH_TIMES and r["level"] == cost_conclusions.LEVEL]
    for (case,), group in groups(reaching, "case").items():
        for row in sorted(group, key=lambda r: r["call_s"]):
            cells = [_text(case), _text(_who(row))]
            cells += [_time(row[name]) for name in _PARTS]
            runs = row["break_even_runs"]
            cells.append(_number(f"{runs:,.0f}" if isfinite(runs) else "", runs))
            rows.append(_row(row, cells))
    return {"heads": _heads("case", "route", *_PARTS.values(), "reference faster from, runs"), "rows": rows}


def _levels(time_rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Cases and routes against levels of off."""
    rows = []
    for _, group in groups(time_rows, "case", "solver", "route").items():
        by_level = {row["level"]: row for row in group}
        cells = [_text(group[0]["case"]), _text(_who(group[0]))]
        rows.append(_row(group[0], [*cells, *(_level_cell(by_level[level]) for level in LEVELS)]))
    return {"heads": _heads("case", "route", *(f"≤ {percent(level)}" for level in LEVELS)), "rows": rows}


def _level_cell(row: dict[str, Any]) -> dict[str, Any]:
    if row["reached"] not in WITH_TIMES:
        return _number(row["reached"], float("inf"))
    ratio = f" ({times(row['ratio'])})" if isfinite(row["ratio"]) else ""
    mark = "°" if row["reached"] == ONE_SETTING else ""
    return _number(f"{seconds(row['cpu_s'])}{mark}{ratio}", row["cpu_s"])


def _who(row: Mapping[str, Any]) -> str:
    return f"{row['solver']} {row['route']}"


def _heads(*names: str) -> list[dict[str, Any]]:
    """Headings of a table whose first two columns are text and whose others are numbers."""
    return [{"title": name, "number": place > 1, "tip": ""} for place, name in enumerate(names)]


def _row(row: Mapping[str, Any], cells: list[dict[str, Any]]) -> dict[str, Any]:
    return {"solver": row["solver"], "route": switch(row["solver"], row["route"]), "cells": cells}


def _text(text: str) -> dict[str, Any]:
    return {"text": text, "kind": "", "order": None}


def _time(value: float) -> dict[str, Any]:
    return _number(seconds(value) if isfinite(value) else "", value)


def _number(text: str, value: float) -> dict[str, Any]:
    """A cell that is sorted by a number; a cell without one is sorted last."""
    return {"text": text, "kind": "number", "order": _order(value) or "1e308"}


def _order(value: float) -> str:
    return f"{value:.10g}" if isfinite(value) else ""
