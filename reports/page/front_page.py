"""The first screen of the page: what was compared, the verdict, the motion of the paper's disc."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite
from typing import TYPE_CHECKING, Any

from ..analysis import verdict
from ..judging.friction_sensitivity import LEAST
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
    manifest: Mapping[str, Any],
) -> dict[str, Any]:
    """Data for the template of the first screen."""
    rows = [_row(row) for row in records(frames["verdict"])]
    hero = next((m for m in moving if m["label"] == _HERO), moving[0] if moving else None)
    case = next((c for c in experiment.cases if hero and c.label == hero["label"]), None)
    return {
        "compared": _comparison(experiment),
        "sentence": verdict.sentence(records(frames["verdict"])),
        "lead": verdict.LEAD,
        "tie": verdict.TIE,
        "lost": lost_text(manifest["lost"]),
        "warnings": [
            {"case": label, "why": truth.failure} for label, truth in experiment.truths.items() if truth.failure
        ],
        "engines": [row for row in rows if not row["our_part"]],
        "partly_ours": [row for row in rows if row["our_part"]],
        "friction_cases": len(verdict.friction_cases(experiment)),
        "least": f"{LEAST:g}",
        "cost_case": next((row["cost_case"] for row in records(frames["verdict"])), ""),
        "hero": hero and {"label": hero["label"], "anchor": anchor(hero["label"]), "said": case_summary(case)},
        "absent": missing_words(experiment.versions),
        "provenance": f"Made {manifest['made_at'][:10]} on {manifest['machine']}.",
    }


def _comparison(experiment: Experiment) -> str:
    """One sentence about what was compared."""
    solvers = dict.fromkeys(solver for _, solver, route in routes(experiment.runs) if route and solver != REFERENCE)
    engines, many = ", ".join(solvers) or "no engine", len(experiment.cases)
    return (
        f"{many} scene{'s' * (many != 1)} of one rigid plate on one fixed curve with Coulomb friction, in "
        f"{len(experiment.runs):,} runs: {engines}, compared with a motion computed from the equations of Ogaru and "
        "Pandrea and certified to the last digits."
    )


def _row(row: Mapping[str, Any]) -> dict[str, Any]:
    """A row of the verdict; rows of engines carry the phrase and the digits from which the page's sentence is made."""
    has_rank = isfinite(row["digits_rank"])
    return {
        "solver": row["solver"],
        "route": row["route"],
        "id": identifier(row["solver"]),
        "rank": f"{row['digits_rank']:.0f}" if has_rank else "",
        "our_part": row["our_part"],
        "phrase": verdict.phrase(row) if verdict.is_engine(row) else "",
        "digits": row["digits"],
        "doubt": row["digits_doubt"],
        "cells": [{"head": head, "text": text, "small": small} for head, (text, small) in verdict.cells(row).items()],
    }


def identifier(name: str) -> str:
    """A solver's name with only the characters that a CSS identifier allows."""
    return "".join(c if c.isascii() and (c.isalnum() or c in "_-") else "_" for c in name)
