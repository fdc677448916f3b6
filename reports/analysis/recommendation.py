"""Which route reaches an accuracy in rolling contact, and at what cost: the table `answers`.

Errors say how far a route is off in the middle of all cases; trust counts in how many of the cases that roll its ladder
reached an accuracy so that no finer setting and no doubt contradicts it (`reached`). Costs are of whole calls as used
from Python, all of one case, so that they compare: the first of the timed ones that rolls.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite, nan
from typing import TYPE_CHECKING, Any

from cases import Mode

from ..running.records import REFERENCE, Experiment, Truth
from . import solver_summary
from .time_to_accuracy import YES, cost

if TYPE_CHECKING:
    import pandas as pd

HOLDS = "In how many rolling cases each solver and route reaches an accuracy, and at what cost"
# What a game and what an engineer asks for, and how columns call it.
COLUMN = {1e-2: "1e_2", 1e-4: "1e_4"}
# Once, as a user tries an engine; for a sweep or a training.
RUNS = {"once": 1, "thousand": 1000}
LEVEL = 1e-4
_REACHED, _AWARD, _ONCE, _MANY = "reached_1e_4", "award_1e_4", "once_1e_4_s", "thousand_1e_4_s"


def rows(experiment: Experiment, frames: Mapping[str, pd.DataFrame]) -> list[dict[str, Any]]:
    """The rows of `answers`, the most trustworthy engine first and the reference last, with

    `rolling_cases`: those it was asked whose truth rolls; for 1e-2 and 1e-4 `reached_…`: in how many of these it
    reached it; and of the case `cost_case` `award_…`, whether it reached it there, and `once_…_s`, `thousand_…_s` (s):
    whole calls, the first from cold. A solver that could not be asked for its routes has one row, of failures."""
    rolling = {label for label, truth in experiment.truths.items() if _rolls(truth)}
    headline, told = _records(frames.get("headline")), _records(frames.get("time_to_accuracy"))
    told = [row for row in told if row["lead"] and row["case"] in rolling]
    case = told[0]["case"] if told else ""
    spent = {(r["solver"], r["route"], r["accuracy"]): r for r in told if r["case"] == case}
    found = []
    for row in solver_summary.rows(experiment, frames):
        who = (row["solver"], row["route"])
        mine = [r for r in headline if (r["solver"], r["route"]) == who and r["case"] in rolling]
        row |= {"rolling_cases": len(mine), "cost_case": case}
        for accuracy, name in COLUMN.items():
            row[f"reached_{name}"] = sum(r["reached"] <= accuracy for r in mine)
            one = spent.get((*who, accuracy))
            row[f"award_{name}"] = one["award"] if one else ""
            for word, runs in RUNS.items():
                row[f"{word}_{name}_s"] = cost(one, runs) if one and one["award"] == YES else nan
        found.append(row)
    return sorted(found, key=_trust)


def _trust(row: Mapping[str, Any]) -> tuple:
    """Engines before the reference; then by the share of cases at the accuracy asked for and at the others, by cost,
    by error."""
    shares = [-row[f"reached_{COLUMN[a]}"] / max(row["rolling_cases"], 1) for a in (LEVEL, *COLUMN)]
    last = (row[_MANY], row["middle_finest_error"])
    return (row["solver"] == REFERENCE, *shares, *(value if isfinite(value) else float("inf") for value in last))


def _rolls(truth: Truth) -> bool:
    return truth.first_mode == Mode.ROLL or any(event.after == Mode.ROLL for event in truth.transitions)


def _records(frame: pd.DataFrame | None) -> list[dict[str, Any]]:
    return [] if frame is None else [{str(k): v for k, v in row.items()} for row in frame.to_dict("records")]
