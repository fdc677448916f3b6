"""Data for the templates of cases and data: cases by family, all cases in one table, failures, provenance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite
from typing import TYPE_CHECKING, Any

import cases as catalogue
from cases import Case

from ..analysis import verdict
from ..analysis.work_precision import groups
from ..drawing.figure_files import short_digest
from ..judging.grades import Grade
from ..running.names import REFERENCE
from ..running.records import Experiment, finest, routes
from ..running.solvers import NOT_INSTALLED
from . import case_tables, motions
from .fragments import command_of, records, short_percent, switch

if TYPE_CHECKING:
    import pandas as pd

# Stands for the report's total time, which is known only when the page is complete.
TOTAL_TIME = "{total time}"
# Failures by severity: an unusable motion is the worst, because the solver does not report it. "Not installed" are
# requested versions only; an engine that is not installed has a line above the table.
_FAILURES = (Grade.UNUSABLE, "crashed", "timed_out", "unsupported", NOT_INSTALLED)
# Cases named in a row of the table of failures.
_NAMED_CASES = 3


def anchor(label: str) -> str:
    """The HTML anchor of a case on the page; with a digest of the label where characters of it are replaced, so that no
    two cases have the same."""
    readable = "".join(c if c.isalnum() or c == "_" else "-" for c in label)
    return f"case-{readable}" if readable == label else f"case-{readable.strip('-')}-{short_digest(label)}"


def case_summary(case: Case | None) -> str:
    """The first line of a case function's docstring; empty for a case that is not in the catalogue."""
    return catalogue.entry(case.name).summary.replace("`", "") if case and case.name in catalogue.names() else ""


def cases(
    experiment: Experiment,
    frames: Mapping[str, pd.DataFrame],
    manifest: dict[str, Any],
    moving: set[str],
) -> dict[str, Any]:
    """The cases, and their index by family."""
    entries: list[dict[str, Any]] = []
    families: dict[str, list[dict[str, Any]]] = {}
    tables = {name: groups(records(frames[name]), "case") for name in ("transitions", "truth", "impacts")}
    finest_runs = [run for group in routes(experiment.runs).values() if (run := finest(group) or group[-1])]
    for case in experiment.cases:
        label, family = case.label, motions.family(case)
        runs = [run for run in finest_runs if run.case == label]
        settings = {(run.solver, run.route): str(run.setting) for run in runs}
        rows = {name: by_case.get((label,), []) for name, by_case in tables.items()}
        truth = experiment.truths[label]
        entry = {
            "label": label,
            "anchor": anchor(label),
            "said": case_summary(case),
            "words": f"{label} {family} {case_summary(case)}".lower(),
            "failure": truth.failure,
            "moving": label in moving,
            "transitions": case_tables.transitions(rows["truth"], rows["transitions"], settings),
            "impacts": case_tables.impacts(rows["impacts"], settings),
        }
        entries.append(entry)
        families.setdefault(family, []).append(entry)
    return {
        "cases": entries,
        "families": list(families.items()),
        "case_command": command_of("NAME", manifest),
    }


def headline(experiment: Experiment, frame: pd.DataFrame) -> dict[str, Any]:
    """All cases against all engines: off with default settings and at the finest setting run, and what 1 % of friction
    makes."""
    exclusions = verdict.exclusions(experiment)
    sensitivity = {label: truth.friction_sensitivity for label, truth in experiment.truths.items()}
    rows = {(str(r["case"]), str(r["solver"]), str(r["route"])): r for r in records(frame)}
    solver_routes = [key for key in dict.fromkeys(key[1:] for key in rows) if key[1] and key[0] != REFERENCE]
    return {
        "routes": [{"solver": solver, "route": route} for solver, route in solver_routes],
        "rows": [
            {
                "case": case,
                "anchor": anchor(case),
                "exclusion": exclusions.get(case, ""),
                "sensitivity": short_percent(sensitivity[case]) if isfinite(sensitivity[case]) else "",
                "order": repr(sensitivity[case]) if isfinite(sensitivity[case]) else "1e308",
                "cells": [
                    _cell(rows.get((case, *route_key)), *route_key, which)
                    for route_key in solver_routes
                    for which in ("default", "finest")
                ],
            }
            for case in dict.fromkeys(key[0] for key in rows)
        ],
    }


def _cell(row: dict[str, Any] | None, solver: str, route: str, which: str) -> dict[str, Any]:
    """A cell's text, grade, and the number by which it is sorted: off with these settings."""
    cell: dict[str, Any] = {"solver": solver, "route": route, "text": "", "grade": "", "order": "1e308"}
    if row is None:
        return cell
    off = row[f"{which}_off"]
    if not isfinite(off):
        return cell | {"text": "–" if which == "finest" else "", "grade": "none"}
    return cell | {
        "text": short_percent(off),
        "grade": str(row[f"{which}_grade"]).replace(" ", "-"),
        "order": repr(float(off)),
    }


def failures(frame: pd.DataFrame) -> list[dict[str, Any]]:
    """Runs without a usable motion, by severity: one row for each solver, route and reason, with the cases. The reasons
    of unusable motions all differ; their row has the worst."""
    by_reason: dict[tuple[str, ...], list[dict[str, Any]]] = {}
    for row in records(frame):
        word = next((str(w) for w in _FAILURES if w in (row["outcome"], row["grade"])), "")
        if word:
            reason = "" if word == Grade.UNUSABLE else row["reason"]
            by_reason.setdefault((word, row["solver"], row["route"], reason), []).append(row)
    order = [str(word) for word in _FAILURES]
    return [_failure(word, rows) for (word, *_), rows in sorted(by_reason.items(), key=lambda g: order.index(g[0][0]))]


def _failure(word: str, rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    worst = max(rows, key=lambda row: row["off"] if isfinite(row["off"]) else 0.0)
    names = list(dict.fromkeys(row["case"] for row in rows))
    more = f" and {len(names) - _NAMED_CASES} more" if len(names) > _NAMED_CASES else ""
    where = f"{worst['case']}: " if word == Grade.UNUSABLE and len(names) > 1 else ""
    return {
        "outcome": word.replace("_", " "),
        "kind": word,
        "solver": worst["solver"],
        "route": worst["route"],
        "switch": switch(worst["solver"], worst["route"]),
        "runs": len(rows),
        "cases": f"{', '.join(names[:_NAMED_CASES])}{more}",
        "reason": f"{where}{worst['reason']}",
    }


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
