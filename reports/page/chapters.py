"""What the chapters' templates take: cases by family, all cases at a glance, what failed, how it was made."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import cases as catalogue
from cases import Case

from ..drawing.files import Drawn
from ..running.records import REFERENCE, Experiment, finest, routes
from ..running.solvers import NOT_INSTALLED
from . import motions
from .pieces import as_written, command_of, picture, records, switch, table
from .text import error_text, lead_text, reached_text

if TYPE_CHECKING:
    import pandas as pd

# By severity: who is wrong does not say so.
# Of versions that were asked for by their number; an engine that is not there has a line above.
_FAILURES = {
    "wrong": "Wrong",
    "crashed": "Crashed",
    "timed_out": "Timed out",
    "refused": "Refused",
    NOT_INSTALLED: "Not installed",
}


def anchor(label: str) -> str:
    """The place of a case on the page."""
    return "case-" + "".join(c if c.isalnum() else "-" for c in label).strip("-")


def said_of(case: Case | None) -> str:
    """The first line of a case function's docstring; of a case made by hand nothing is said."""
    return catalogue.entry(case.name).summary if case and case.name in catalogue.names() else ""


def cases(
    experiment: Experiment,
    frames: Mapping[str, pd.DataFrame],
    drawn: Sequence[Drawn],
    figures: Path,
    manifest: dict[str, Any],
    moving: set[str],
) -> dict[str, Any]:
    """The cases, and the index of them by family."""
    told: list[dict[str, Any]] = []
    families: dict[str, list[dict[str, Any]]] = {}
    for case in experiment.cases:
        label, family = case.label, motions.family(case)
        mine = [d for d in drawn if d.case == label and d.name != "headline"]
        # The player takes the place of what shows the motion: without scripts its figures are read from the folder.
        moved = [d for d in mine if label in moving and d.name.startswith(("motion_", "scene_"))]
        one = {
            "label": label,
            "anchor": anchor(label),
            "said": said_of(case),
            "words": f"{label} {family} {said_of(case)}".lower(),
            "failure": experiment.truths[label].failure,
            "moving": label in moving,
            "static": [picture(d, figures, inside=False) for d in moved],
            "pictures": [picture(d, figures) for d in mine if d not in moved],
            "command": command_of(label, manifest),
            "tables": _case_tables(experiment, label, frames),
        }
        told.append(one)
        families.setdefault(family, []).append(one)
    return {"cases": told, "families": list(families.items())}


def _case_tables(experiment: Experiment, label: str, frames: Mapping[str, pd.DataFrame]) -> list[dict[str, Any]]:
    groups = routes(run for run in experiment.runs if run.case == label).values()
    shown = {(r.solver, r.route, r.setting) for r in map(finest, groups) if r}
    told = []
    events = frames["transitions"]
    events = events[events["case"] == label] if len(events) else events
    if len(events):
        chosen = events[[(r["solver"], r["route"], r["setting"]) in shown for r in records(events)]]
        if len(chosen):
            # Who may be off stands first.
            chosen = chosen.sort_values("solver", key=lambda names: names == REFERENCE, kind="stable")
            told.append(_table("Transitions at the finest setting", chosen, ("case", "setting", "version"), True))
    orders = frames["convergence"]
    chosen = orders[orders["case"] == label] if len(orders) else orders
    if len(chosen):
        told.append(_table("Observed orders", chosen, ("case", "settings_used", "version"), False))
    return told


def _table(title: str, frame: pd.DataFrame, without: Sequence[str], is_open: bool) -> dict[str, Any]:
    columns = {c: c.replace("_", " ") for c in map(str, frame.columns) if c not in without}
    return {"title": title, "open": is_open, **table(frame, columns)}


def headline(frame: pd.DataFrame, drawn: Sequence[Drawn], figures: Path) -> dict[str, Any]:
    """All cases against all routes: what leads a case at the finest setting, and the first transition beside it."""
    rows = {(str(r["case"]), str(r["solver"]), str(r["route"])): r for r in records(frame)}
    asked = [who for who in dict.fromkeys(key[1:] for key in rows) if who[1]]
    return {
        "pictures": [picture(d, figures) for d in drawn if d.name == "headline"],
        "routes": [{"solver": solver, "route": route, "switch": switch(solver, route)} for solver, route in asked],
        "rows": [
            {"case": case, "anchor": anchor(case), "cells": [_cell(rows.get((case, *who)), *who) for who in asked]}
            for case in dict.fromkeys(key[0] for key in rows)
        ],
    }


def _cell(row: dict[str, Any] | None, solver: str, route: str) -> dict[str, Any]:
    """What a cell says, and by which number it is sorted: the error that leads its case."""
    cell: dict[str, Any] = {"solver": solver, "switch": switch(solver, route), "text": "", "small": [], "order": ""}
    if row is None:
        return cell
    finest, own = (error_text(row, which) for which in ("finest", "default"))
    lead, level = lead_text(row, "finest"), reached_text(row)
    cell["text"] = as_written(lead)
    if isfinite(row["finest_lead_error"]):
        cell["order"] = repr(float(row["finest_lead_error"]))
    if lead != finest:  # else a word, the same for both
        first = f"first: {finest}" if row["transitions_true"] else finest
        small = [f"reaches {level}" if level else "reaches none", first, *([f"as it comes: {own}"] if own else [])]
        # No number is broken where a line ends.
        cell["small"] = [as_written(text).split(" ") for text in small]
    return cell


def failures(frame: pd.DataFrame) -> list[dict[str, Any]]:
    """Runs that failed, by severity."""
    found = []
    columns = {name: name for name in ("case", "solver", "route", "setting", "reason")}
    for outcome, title in _FAILURES.items():
        rows = frame[frame["outcome"] == outcome] if len(frame) else frame
        if outcome == NOT_INSTALLED and not len(rows):
            continue
        found.append({"title": title, **table(rows, columns)})
    return found


def left_out(frames: Mapping[str, pd.DataFrame]) -> list[dict[str, Any]]:
    """Tables and figures that were made without a solver's results; none if there are none."""
    rows = frames.get("left_out")
    title = "Tables and figures without the results of a solver"
    return [] if rows is None else [{"title": title, **table(rows, {c: c for c in ("item", "solver", "reason")})}]


def made(manifest: Mapping[str, Any]) -> list[tuple[str, str]]:
    """How the report was made, in rows."""
    rows = [("command", manifest["command"]), ("when", manifest["made_at"]), ("took", f"{manifest['seconds']:.0f} s")]
    for key in (
        "commit",
        "machine",
        "python",
        "solvers",
        "not installed",
        "packages",
        "settings",
        "ladders",
        "compiled",
    ):
        value = manifest.get(key)
        if value:
            rows.append(
                (key, ", ".join(f"{k} {v}" for k, v in value.items()) if isinstance(value, dict) else str(value))
            )
    return rows
