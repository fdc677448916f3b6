"""Data for the templates of the chapters: cases by family, summary of all cases, failures, provenance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import cases as catalogue
from cases import Case

from ..drawing.figure_files import FigureEntry, short_digest
from ..judging.grades import Grade
from ..running.records import REFERENCE, Experiment, finest, routes
from ..running.solvers import NOT_INSTALLED
from . import motions
from .fragments import command_of, picture, records, switch, table, verbatim
from .text import default_text, first_error_text, level_text, off_text

if TYPE_CHECKING:
    import pandas as pd

# Stands for the report's total time, which is known only when the page is complete.
TOTAL_TIME = "{total time}"
# Tables of the chapter on failures, by severity: an unusable motion is the worst, because the solver does not report
# it. "Not installed" lists requested versions only; an engine that is not installed has a line above the tables.
_FAILURES = {
    Grade.UNUSABLE: "Unusable",
    "crashed": "Crashed",
    "timed_out": "Timed out",
    "unsupported": "Unsupported",
    NOT_INSTALLED: "Not installed",
}


def anchor(label: str) -> str:
    """The HTML anchor of a case on the page; with a digest of the label where characters of it are replaced, so that no
    two cases have the same."""
    readable = "".join(c if c.isalnum() or c == "_" else "-" for c in label)
    return f"case-{readable}" if readable == label else f"case-{readable.strip('-')}-{short_digest(label)}"


def case_summary(case: Case | None) -> str:
    """The first line of a case function's docstring; empty for a case that is not in the catalogue."""
    return catalogue.entry(case.name).summary if case and case.name in catalogue.names() else ""


def cases(
    experiment: Experiment,
    frames: Mapping[str, pd.DataFrame],
    figure_entries: Sequence[FigureEntry],
    figures: Path,
    manifest: dict[str, Any],
    moving: set[str],
) -> dict[str, Any]:
    """The cases, and their index by family."""
    entries: list[dict[str, Any]] = []
    families: dict[str, list[dict[str, Any]]] = {}
    for case in experiment.cases:
        label, family = case.label, motions.family(case)
        case_figures = [d for d in figure_entries if d.case == label and d.name != "headline"]
        # The player replaces the figures of the motion. Without scripts these figures are read from the folder.
        motion_figures = [d for d in case_figures if label in moving and d.name.startswith(("motion_", "scene_"))]
        entry = {
            "label": label,
            "anchor": anchor(label),
            "said": case_summary(case),
            "words": f"{label} {family} {case_summary(case)}".lower(),
            "failure": experiment.truths[label].failure,
            "moving": label in moving,
            "static": [picture(d, figures, inside=False) for d in motion_figures],
            "pictures": [picture(d, figures) for d in case_figures if d not in motion_figures],
            "command": command_of(label, manifest),
            "tables": _case_tables(experiment, label, frames),
        }
        entries.append(entry)
        families.setdefault(family, []).append(entry)
    return {"cases": entries, "families": list(families.items())}


def _case_tables(experiment: Experiment, label: str, frames: Mapping[str, pd.DataFrame]) -> list[dict[str, Any]]:
    groups = routes(run for run in experiment.runs if run.case == label).values()
    finest_keys = {(r.solver, r.route, r.setting) for r in map(finest, groups) if r}
    case_tables = []
    events = frames["transitions"]
    events = events[events["case"] == label] if len(events) else events
    if len(events):
        table_rows = events[[(r["solver"], r["route"], r["setting"]) in finest_keys for r in records(events)]]
        if len(table_rows):
            # The reference comes last.
            table_rows = table_rows.sort_values("solver", key=lambda names: names == REFERENCE, kind="stable")
            case_tables.append(
                _table("Transitions at the finest setting", table_rows, ("case", "setting", "version"), True)
            )
    orders = frames["convergence"]
    table_rows = orders[orders["case"] == label] if len(orders) else orders
    if len(table_rows):
        case_tables.append(_table("Observed orders", table_rows, ("case", "settings_used", "version"), False))
    return case_tables


def _table(title: str, frame: pd.DataFrame, without: Sequence[str], is_open: bool) -> dict[str, Any]:
    columns = {c: c.replace("_", " ") for c in map(str, frame.columns) if c not in without}
    return {"title": title, "open": is_open, **table(frame, columns)}


def headline(frame: pd.DataFrame, figure_entries: Sequence[FigureEntry], figures: Path) -> dict[str, Any]:
    """All cases against all routes: off at the finest setting run, and the error of the first transition."""
    rows = {(str(r["case"]), str(r["solver"]), str(r["route"])): r for r in records(frame)}
    solver_routes = [route_key for route_key in dict.fromkeys(key[1:] for key in rows) if route_key[1]]
    return {
        "pictures": [picture(d, figures) for d in figure_entries if d.name == "headline"],
        "routes": [
            {"solver": solver, "route": route, "switch": switch(solver, route)} for solver, route in solver_routes
        ],
        "rows": [
            {
                "case": case,
                "anchor": anchor(case),
                "cells": [_cell(rows.get((case, *route_key)), *route_key) for route_key in solver_routes],
            }
            for case in dict.fromkeys(key[0] for key in rows)
        ],
    }


def _cell(row: dict[str, Any] | None, solver: str, route: str) -> dict[str, Any]:
    """A cell's text, and the number by which it is sorted: off at the finest setting run."""
    cell: dict[str, Any] = {"solver": solver, "switch": switch(solver, route), "text": "", "small": [], "order": ""}
    if row is None:
        return cell
    cell["text"] = off_text(row, "finest")
    if isfinite(row["finest_off"]):
        cell["order"] = repr(float(row["finest_off"]))
        texts = [level_text(row), first_error_text(row, "finest"), default_text(row)]
        # Single words, so that no line break splits a number.
        cell["small"] = [verbatim(text).split(" ") for text in texts if text and not row["is_truth"]]
    return cell


def failures(frame: pd.DataFrame) -> list[dict[str, Any]]:
    """Runs without a usable motion, by severity."""
    tables = []
    columns = {name: name for name in ("case", "solver", "route", "setting", "reason")}
    for outcome, title in _FAILURES.items():
        rows = frame[(frame["outcome"] == outcome) | (frame["grade"] == outcome)] if len(frame) else frame
        if outcome == NOT_INSTALLED and not len(rows):
            continue
        tables.append({"title": title, **table(rows, columns)})
    return tables


def left_out(frames: Mapping[str, pd.DataFrame]) -> list[dict[str, Any]]:
    """A table of the tables and figures made without a solver's results; an empty list if there are none."""
    rows = frames.get("left_out")
    title = "Tables and figures without the results of a solver"
    return [] if rows is None else [{"title": title, **table(rows, {c: c for c in ("item", "solver", "reason")})}]


def provenance(manifest: Mapping[str, Any]) -> list[tuple[str, str]]:
    """The provenance of the report as rows of key and text."""
    rows = [
        ("command", manifest["command"]),
        ("when", manifest["made_at"]),
        ("report took", TOTAL_TIME),
    ]
    for key in (
        "commit",
        "machine",
        "python",
        "solvers",
        "not installed",
        "packages",
        "settings",
        "ladders",
    ):
        value = manifest.get(key)
        if value:
            rows.append(
                (key, ", ".join(f"{k} {v}" for k, v in value.items()) if isinstance(value, dict) else str(value))
            )
    return rows
