"""Data for the templates of cases and data: cases by family, failures, provenance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite
from typing import TYPE_CHECKING, Any

import cases as catalogue
from cases import Case

from ..judging.grades import Grade
from ..running.records import Experiment
from ..running.solvers import NOT_INSTALLED
from . import motions
from .fragments import anchor, command_of, records, switch
from .page_table import Cell, Head, PageRow, PageTable

if TYPE_CHECKING:
    import pandas as pd

# Stands for the report's total time, which is known only when the page is complete.
TOTAL_TIME = "{total time}"
# Failures by severity: an unusable motion is the worst, because the solver does not report it. "Not installed" are
# requested versions only; an engine that is not installed has a line above the table.
_FAILURES = (Grade.UNUSABLE, "crashed", "timed_out", "unsupported", NOT_INSTALLED)
# Cases named in a row of the table of failures.
_NAMED_CASES = 3


def case_summary(case: Case | None) -> str:
    """The first line of a case function's docstring; empty for a case that is not in the catalogue."""
    return catalogue.entry(case.name).summary.replace("`", "") if case and case.name in catalogue.names() else ""


def cases(
    experiment: Experiment,
    manifest: dict[str, Any],
    moving: set[str],
) -> dict[str, Any]:
    """The cases, and their index by family."""
    entries: list[dict[str, Any]] = []
    families: dict[str, list[dict[str, Any]]] = {}
    for case in experiment.cases:
        label, family = case.label, motions.family(case)
        truth = experiment.truths[label]
        entry = {
            "label": label,
            "anchor": anchor(label),
            "said": case_summary(case),
            "failure": truth.failure,
            "moving": label in moving,
        }
        entries.append(entry)
        families.setdefault(family, []).append(entry)
    return {
        "cases": entries,
        "families": list(families.items()),
        "case_command": command_of("NAME", manifest),
    }


def failures(frame: pd.DataFrame) -> PageTable:
    """Runs without a usable motion, by severity: one row for each solver, route and reason, with the cases. The reasons
    of unusable motions all differ; their row has the worst."""
    by_reason: dict[tuple[str, ...], list[dict[str, Any]]] = {}
    for row in records(frame):
        word = next((str(w) for w in _FAILURES if w in (row["outcome"], row["grade"])), "")
        if word:
            reason = "" if word == Grade.UNUSABLE else row["reason"]
            by_reason.setdefault((word, row["solver"], row["route"], reason), []).append(row)
    order = [str(word) for word in _FAILURES]
    groups = sorted(by_reason.items(), key=lambda group: order.index(group[0][0]))
    heads = [Head("outcome"), Head("engine"), Head("runs", number=True), Head("cases"), Head("reason")]
    lines = [_failure(word, rows) for (word, *_), rows in groups]
    return PageTable("what did not work", heads, lines, "", "trajectories", len(lines), len(heads))


def _failure(word: str, rows: Sequence[dict[str, Any]]) -> PageRow:
    worst = max(rows, key=lambda row: row["off"] if isfinite(row["off"]) else 0.0)
    names = list(dict.fromkeys(row["case"] for row in rows))
    more = f" and {len(names) - _NAMED_CASES} more" if len(names) > _NAMED_CASES else ""
    where = f"{worst['case']}: " if word == Grade.UNUSABLE and len(names) > 1 else ""
    cells = [
        Cell(word.replace("_", " "), kind=word),
        Cell(f"{worst['solver']} {worst['route']}"),
        Cell(str(len(rows)), kind="number"),
        Cell(f"{', '.join(names[:_NAMED_CASES])}{more}"),
        Cell(f"{where}{worst['reason']}", kind="reason"),
    ]
    return PageRow(cells, worst["solver"], switch(worst["solver"], worst["route"]))


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
