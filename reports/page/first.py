"""The first screen: what was compared, the answer table, the paper's disc in motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite
from typing import TYPE_CHECKING, Any

from ..analysis import advice, tables
from ..analysis.words import level, number, seconds
from ..running.records import REFERENCE, Experiment, routes
from ..running.solvers import missing_words
from .chapters import anchor, said_of
from .pieces import records
from .text import lost_words

if TYPE_CHECKING:
    import pandas as pd

# The paper's application, if the report has it.
_HERO = "disc_in_circle[mu=0.2]"


def screen(
    experiment: Experiment,
    frames: Mapping[str, pd.DataFrame],
    moving: Sequence[Mapping[str, Any]],
    timed: bool,
    manifest: Mapping[str, Any],
) -> dict[str, Any]:
    """What the template of the first screen takes."""
    told = records(frames["answers"])
    hard = any("hard_right" in row for row in told)
    hero = next((m for m in moving if m["label"] == _HERO), moving[0] if moving else None)
    case = next((c for c in experiment.cases if hero and c.label == hero["label"]), None)
    rows = [row for row in told if row["route"]]
    costs = any(row[f"timed_{advice.COLUMN[accuracy]}"] for row in rows for accuracy in advice.ACCURACIES)
    return {
        "compared": _compared(experiment),
        "sentences": advice.sentences(told),
        "lost": lost_words(manifest["lost"]),
        "warnings": [
            {"case": label, "why": truth.failure} for label, truth in experiment.truths.items() if truth.failure
        ],
        "answers": [_row(row, hard, costs) for row in rows],
        "costs": costs,
        "levels": [f"{accuracy:g}" if accuracy >= 1e-3 else level(accuracy) for accuracy in advice.ACCURACIES],
        "hard": hard,
        "rolling": max((row["rolling_cases"] for row in rows), default=0),
        "timed": timed,
        "hero": hero and {"label": hero["label"], "anchor": anchor(hero["label"]), "said": said_of(case)},
        "absent": missing_words(experiment.versions),
        "provenance": f"Made {manifest['made_at'][:10]} on {manifest['machine']}.",
    }


def _compared(experiment: Experiment) -> str:
    """One sentence of what was compared."""
    solvers = dict.fromkeys(solver for _, solver, route in routes(experiment.runs) if route and solver != REFERENCE)
    counts = tables.outcome_counts(experiment)
    asked = {name: sum(counts[name][word] for word in ("right", "wrong", "crashed", "timed_out")) for name in solvers}
    wrong = {name: counts[name]["wrong"] for name in solvers}
    engines = ", ".join(f"{name} ({wrong[name]} of {asked[name]} motions wrong)" for name in solvers) or "no engine"
    many = len(experiment.cases)
    return (
        f"{many} scene{'s' * (many != 1)} of one rigid plate on one fixed curve with Coulomb friction, in "
        f"{len(experiment.runs)} runs: {engines}, held against a motion computed from the equations of Ogaru and "
        "Pandrea and certified to the last digits."
    )


def _row(row: Mapping[str, Any], hard: bool, costs: bool) -> dict[str, Any]:
    cells = [{"head": "as it comes", "text": _error(row["middle_default_error"]), "small": ""}]
    finest = "is the truth" if row["is_truth"] else _error(row["middle_finest_error"])
    cells.append({"head": "finest", "text": finest, "small": _wrong(row)})
    for accuracy in advice.ACCURACIES:
        name, column = level(accuracy), advice.COLUMN[accuracy]
        reached = f"{row[f'reached_{column}']} of {row['rolling_cases']}"
        if not costs:
            cells.append({"head": f"reaches {name}", "text": reached, "small": ""})
            continue
        once, many = (_cost(row, column, word) for word in advice.RUNS)
        cells.append({"head": f"{name} once", "text": once, "small": reached})
        cells.append({"head": f"{name} 1,000 ×", "text": many, "small": ""})
    if hard:
        count = [row.get(f"hard_{word}", 0) for word in ("right", "wrong", "refused")]
        told = " / ".join(str(int(n)) for n in count) if all(isfinite(n) for n in count) and sum(count) else ""
        cells.append({"head": "hard scenes", "text": told, "small": ""})
    return {"solver": row["solver"], "route": row["route"], "id": identifier(row["solver"]), "cells": cells}


def _cost(row: Mapping[str, Any], column: str, word: str) -> str:
    spent = row[f"{word}_{column}_s"]
    return seconds(spent) if isfinite(spent) else "not timed" if row[f"reached_{column}"] else "never"


def _wrong(row: Mapping[str, Any]) -> str:
    return f"{row['wrong']} of {row['cases'] - row['refused']} wrong" if row["wrong"] else ""


def _error(value: float) -> str:
    """An error as people write it: 38 ns of them would be unread, 3.8e-8 is what a reader compares."""
    if not isfinite(value):
        return "–"
    return number(value) if value >= 1e-2 else f"{value:.1e}".replace("e-0", "e-") if value else "0"


def identifier(name: str) -> str:
    """A solver's name as part of a name in CSS."""
    return "".join(c if c.isascii() and (c.isalnum() or c in "_-") else "_" for c in name)
