"""The table of one case's transitions, with every engine's error."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite
from typing import Any

from ..running.names import REFERENCE
from .fragments import WHOLE, switch, verbatim


def transitions(
    truth_rows: Sequence[dict[str, Any]], event_rows: Sequence[dict[str, Any]], settings: Mapping[tuple, str]
) -> dict[str, Any]:
    """A row for each transition of the truth, with the error of each engine at its finest setting run. `settings`: that
    setting by solver and route."""
    mine = [row for row in event_rows if settings.get((row["solver"], row["route"])) == str(row["setting"])]
    keys = list(dict.fromkeys((row["solver"], row["route"]) for row in mine if row["solver"] != REFERENCE))
    errors = {(row["solver"], row["route"], row["event"]): row for row in mine if isfinite(row["reference_time"])}
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
                "change": _change(row),
                "time": f"{row['time']:.9g}",
                "bar": verbatim(f"{row['truth_error_bar']:.1e}"),
                "certificate": row["certificate"],
                "errors": [error_text(errors.get((*key, row["event"]))) for key in keys],
            }
            for row in events[:WHOLE]
        ],
    }


def _change(row: Mapping[str, Any]) -> str:
    """A change of mode in words, with the contact's name where there are several."""
    which = f"{row['contact']}: " if row.get("contact") else ""
    return f"{which}{row['before']} → {row['after']}".replace("_", " ")


def impacts(rows: Sequence[dict[str, Any]], settings: Mapping[tuple, str]) -> dict[str, Any]:
    """A row for each impact of the truth, and one for the time of rest: the swing after it, and for each engine at its
    finest setting run its time and swing minus the truth's, with several contacts. `settings`: that setting by solver
    and route."""
    several = [row for row in rows if row["contact"] or not row["event"]]
    mine = [row for row in several if settings.get((row["solver"], row["route"])) == str(row["setting"])]
    keys = list(dict.fromkeys((row["solver"], row["route"]) for row in mine if row["solver"] != REFERENCE))
    # Each route has its own numbers, as its own impacts count; the truth's times are the same in all.
    by_instant = {(row["solver"], row["route"], _instant(row)): row for row in mine if isfinite(row["reference_time"])}
    true = {_instant(row): row for row in by_instant.values()} if keys else {}
    return {
        "routes": [{"solver": solver, "route": route, "switch": switch(solver, route)} for solver, route in keys],
        "rows": [
            {
                "what": f"impact at {contact}" if contact else "at rest",
                "time": f"{time:.6g}",
                "swing": f"{true[is_rest, time, contact]['reference_swing']:.4g}" if contact else "",
                "cells": [_impact_cell(by_instant.get((*key, (is_rest, time, contact)))) for key in keys],
            }
            for is_rest, time, contact in sorted(true)
        ],
    }


def _instant(row: Mapping[str, Any]) -> tuple[bool, float, str]:
    """An impact of the truth by time and contact, after all of them its rest, which has no contact."""
    return not row["event"], row["reference_time"], row["contact"] if row["event"] else ""


def _impact_cell(row: Mapping[str, Any] | None) -> dict[str, str]:
    """Errors of time and swing of one impact with their signs, or that the run does not have it."""
    if row is None or not isfinite(row["error"]):
        return {"time": "–", "swing": ""}
    off = row["swing"] - row["reference_swing"]
    return {"time": verbatim(f"{row['error']:+.1e}"), "swing": verbatim(f"{off:+.1e}") if isfinite(off) else ""}


def error_text(row: Mapping[str, Any] | None) -> str:
    """The error of a transition's time in s with its sign, or why there is none; an error within the truth's error bar
    is written as less than the bar."""
    if row is None:
        return ""
    if not isfinite(row["error"]):
        return str(row["pairing"])
    bar = row["truth_error_bar"]
    return verbatim(f"{row['error']:+.1e}" if abs(row["error"]) > bar else f"< {bar:.1e}")
