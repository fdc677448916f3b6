"""The first screen of the page: what was compared, the answer table, the motion of the paper's disc."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite
from typing import TYPE_CHECKING, Any

from ..analysis import recommendation, tables
from ..analysis.number_format import level, number, seconds
from ..analysis.time_to_accuracy import YES
from ..running.records import REFERENCE, Experiment, routes
from ..running.solvers import missing_words
from .chapters import anchor, case_summary
from .fragments import records
from .text import lost_text

if TYPE_CHECKING:
    import pandas as pd

# The paper's application; shown if the report contains it.
_HERO = "disc_in_circle[mu=0.2]"


def screen(
    experiment: Experiment,
    frames: Mapping[str, pd.DataFrame],
    moving: Sequence[Mapping[str, Any]],
    timed: bool,
    manifest: Mapping[str, Any],
) -> dict[str, Any]:
    """Data for the template of the first screen."""
    answers = records(frames["answers"])
    hard, costs = _has_hard(answers), _has_costs(answers)
    hero = next((m for m in moving if m["label"] == _HERO), moving[0] if moving else None)
    case = next((c for c in experiment.cases if hero and c.label == hero["label"]), None)
    rows = [row for row in answers if row["route"]]
    return {
        "compared": _comparison(experiment),
        "sentences": recommendation.sentences(answers),
        "lost": lost_text(manifest["lost"]),
        "warnings": [
            {"case": label, "why": truth.failure} for label, truth in experiment.truths.items() if truth.failure
        ],
        "answers": [_row(row, hard, costs) for row in rows],
        "costs": costs,
        "cost_case": rows[0]["cost_case"] if rows else "",
        "levels": [f"{accuracy:g}" if accuracy >= 1e-3 else level(accuracy) for accuracy in recommendation.COLUMN],
        "hard": hard,
        "rolling": max((row["rolling_cases"] for row in rows), default=0),
        "timed": timed,
        "hero": hero and {"label": hero["label"], "anchor": anchor(hero["label"]), "said": case_summary(case)},
        "absent": missing_words(experiment.versions),
        "provenance": f"Made {manifest['made_at'][:10]} on {manifest['machine']}.",
    }


def _comparison(experiment: Experiment) -> str:
    """One sentence about what was compared."""
    solvers = dict.fromkeys(solver for _, solver, route in routes(experiment.runs) if route and solver != REFERENCE)
    counts = tables.outcome_counts(experiment)
    attempts = {
        name: sum(counts[name][word] for word in ("right", "wrong", "crashed", "timed_out")) for name in solvers
    }
    wrong = {name: counts[name]["wrong"] for name in solvers}
    engines = ", ".join(f"{name} ({wrong[name]} of {attempts[name]} motions wrong)" for name in solvers) or "no engine"
    many = len(experiment.cases)
    return (
        f"{many} scene{'s' * (many != 1)} of one rigid plate on one fixed curve with Coulomb friction, in "
        f"{len(experiment.runs):,} runs: {engines}, compared with a motion computed from the equations of Ogaru and "
        "Pandrea and certified to the last digits."
    )


def _row(row: Mapping[str, Any], hard: bool, costs: bool) -> dict[str, Any]:
    cells = [{"head": "default", "text": _error(row["middle_default_error"]), "small": ""}]
    cells.append({"head": "finest", "text": _finest(row), "small": _wrong(row)})
    for accuracy, column in recommendation.COLUMN.items():
        name, reached_count = level(accuracy), _level_cells(row, column)
        if not costs:
            cells.append({"head": f"reaches {name}", "text": reached_count, "small": ""})
            continue
        once, many = (_cost(row, column, word) for word in recommendation.RUNS)
        cells.append({"head": f"{name} first run", "text": once, "small": reached_count})
        cells.append({"head": f"{name} 1,000 runs", "text": many, "small": ""})
    if hard:
        cells.append({"head": "hard scenes", "text": _of_hard(row), "small": ""})
    return {"solver": row["solver"], "route": row["route"], "id": identifier(row["solver"]), "cells": cells}


def in_terminal(answers: Sequence[Mapping[str, Any]]) -> str:
    """The answer table for the terminal, from rows of `advice`: the same numbers and words as the first screen."""
    from tabulate import tabulate

    costs, lines = _has_costs(answers), []
    for row in answers:
        line = {"": f"{row['solver']} {row['route']}"}
        line |= {word: str(row[word]) for word in ("right", "wrong", "refused", "failed")}
        line |= {"default": _error(row["middle_default_error"]), "finest": _finest(row)}
        for accuracy, column in recommendation.COLUMN.items():
            line[f"reaches {level(accuracy)}"] = _level_cells(row, column)
            if costs:
                line[f"{level(accuracy)} first run"] = _cost(row, column, "once")
                line[f"{level(accuracy)} 1,000 runs"] = _cost(row, column, "thousand")
        if _has_hard(answers):
            line["hard scenes"] = _of_hard(row)
        lines.append(line)
    return tabulate(lines, headers="keys", tablefmt="plain", disable_numparse=True, stralign="right")


def notes(answers: Sequence[Mapping[str, Any]]) -> list[str]:
    """Explanations of the columns of `in_terminal`."""
    lines = [
        "default, finest: error of the first transition's time, s, with default settings and at the finest setting"
    ]
    lines[0] += " run; median of the cases"
    lines += ["reaches: number of rolling cases within this tolerance; failed: crashed or timed out"]
    if _has_costs(answers):
        lines += [
            f"first run, 1,000 runs: whole calls from Python, the first a cold start, on {answers[0]['cost_case']}"
        ]
    return lines


def _has_costs(answers: Sequence[Mapping[str, Any]]) -> bool:
    return any(isfinite(row[f"once_{column}_s"]) for row in answers for column in recommendation.COLUMN.values())


def _has_hard(answers: Sequence[Mapping[str, Any]]) -> bool:
    return any("hard_right" in row for row in answers)


def _finest(row: Mapping[str, Any]) -> str:
    return "is the truth" if row["is_truth"] else _error(row["middle_finest_error"])


def _level_cells(row: Mapping[str, Any], column: str) -> str:
    return f"{row[f'reached_{column}']} of {row['rolling_cases']}"


def _of_hard(row: Mapping[str, Any]) -> str:
    count = [row.get(f"hard_{word}", 0) for word in ("right", "wrong", "refused")]
    return " / ".join(str(int(n)) for n in count) if all(isfinite(n) for n in count) and sum(count) else ""


def _cost(row: Mapping[str, Any], column: str, word: str) -> str:
    """The time on the timed case, or the reason why there is none."""
    total, award = row[f"{word}_{column}_s"], row[f"award_{column}"]
    return seconds(total) if isfinite(total) else "not timed" if award == YES else award or "–"


def _wrong(row: Mapping[str, Any]) -> str:
    return f"{row['wrong']} of {row['cases'] - row['refused']} wrong" if row["wrong"] else ""


def _error(value: float) -> str:
    """An error in scientific notation if it is small: 3.8e-8 rather than 38 ns, so that errors compare at a glance."""
    if not isfinite(value):
        return "–"
    return number(value) if value >= 1e-2 else f"{value:.1e}".replace("e-0", "e-") if value else "0"


def identifier(name: str) -> str:
    """A solver's name with only the characters that a CSS identifier allows."""
    return "".join(c if c.isascii() and (c.isalnum() or c in "_-") else "_" for c in name)
