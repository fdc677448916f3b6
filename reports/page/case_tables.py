"""The tables of one case: every route with its grades, and the transitions with every route's error."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite
from typing import Any

from ..running.records import REFERENCE
from .fragments import switch, verbatim
from .text import default_text, level_text, off_text

# Transitions that the page shows of a case; the table `transitions` has all.
_MOST_TRANSITIONS = 10


def by_case(rows: Sequence[dict[str, Any]]) -> dict[str, list[dict[str, Any]]]:
    """Rows of a table by case."""
    groups: dict[str, list[dict[str, Any]]] = {}
    for row in rows:
        groups.setdefault(row["case"], []).append(row)
    return groups


def engines(headline_rows: Sequence[dict[str, Any]], reasons: Mapping[tuple, str]) -> list[dict[str, Any]]:
    """A row for each route of a case. `reasons`: why its finest run has its grade, or is missing, by solver
    and route."""
    return [
        {
            "solver": row["solver"],
            "route": row["route"],
            "switch": switch(row["solver"], row["route"]),
            "default": default_text(row).removeprefix("default: ") if row["default_outcome"] else "",
            "default_grade": _grade(row, "default"),
            "finest": off_text(row, "finest"),
            "finest_grade": _grade(row, "finest"),
            "level": "" if row["is_truth"] or not isfinite(row["finest_off"]) else level_text(row),
            "default_friction": _factor(row["default_friction_factor"]),
            "finest_friction": _factor(row["finest_friction_factor"]),
            "reason": reasons.get((row["solver"], row["route"]), ""),
            "order": [_order(row["default_off"]), _order(row["finest_off"])],
        }
        for row in sorted(headline_rows, key=lambda row: row["solver"] == REFERENCE)
        if row["route"]
    ]


def transitions(
    truth_rows: Sequence[dict[str, Any]], event_rows: Sequence[dict[str, Any]], settings: Mapping[tuple, str]
) -> dict[str, Any]:
    """A row for each transition of the truth, with the error of each route at its finest setting run. `settings`: that
    setting by solver and route."""
    mine = [row for row in event_rows if settings.get((row["solver"], row["route"])) == str(row["setting"])]
    keys = list(dict.fromkeys((row["solver"], row["route"]) for row in mine))
    keys.sort(key=lambda key: key[0] == REFERENCE)
    errors = {(row["solver"], row["route"], row["event"]): row for row in mine if row["pairing"] != "spurious"}
    extra = {key: sum((r["solver"], r["route"]) == key and r["pairing"] == "spurious" for r in mine) for key in keys}
    events = [row for row in truth_rows if row["event"]]
    return {
        "count": len(events),
        "routes": [
            {"solver": solver, "route": route, "switch": switch(solver, route), "spurious": extra[solver, route]}
            for solver, route in keys
        ],
        "rows": [
            {
                "event": row["event"],
                "change": f"{row['before']} → {row['after']}".replace("_", " "),
                "time": f"{row['time']:.9g}",
                "bar": verbatim(f"{row['truth_error_bar']:.1e}"),
                "certificate": row["certificate"],
                "errors": [_error(errors.get((*key, row["event"]))) for key in keys],
            }
            for row in events[:_MOST_TRANSITIONS]
        ],
    }


def _error(row: Mapping[str, Any] | None) -> str:
    """The error of a transition's time in s with its sign, or why there is none."""
    if row is None:
        return ""
    return verbatim(f"{row['error']:+.1e}") if isfinite(row["error"]) else row["pairing"]


def _grade(row: Mapping[str, Any], which: str) -> str:
    return "" if which == "finest" and row["is_truth"] else str(row[f"{which}_grade"]).replace(" ", "-")


def _factor(value: float) -> str:
    return f"{float(f'{value:.2g}'):g}" if isfinite(value) else ""


def _order(value: float) -> str:
    return repr(float(value)) if isfinite(value) else "1e308"
