"""The first screen of the page: the verdict, the map of engines and cases, off against cost, a motion."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from math import isfinite
from typing import TYPE_CHECKING, Any

from ..analysis import verdict, verdict_text
from ..running.ladder_selection import ladder_case
from ..running.names import REFERENCE
from ..running.records import Experiment, Run, routes
from ..running.solvers import missing_words
from .chapters import anchor, case_summary
from .engine_rows import engine_rows
from .fragments import identifier, records
from .grade_map import engine_map
from .off_chart import off_chart
from .strip_plot import strip_plot
from .text import lost_text

if TYPE_CHECKING:
    import pandas as pd


def screen(
    experiment: Experiment,
    frames: Mapping[str, pd.DataFrame],
    moving: Sequence[Mapping[str, Any]],
    manifest: Mapping[str, Any],
) -> dict[str, Any]:
    """Data for the template of the first screen."""
    verdicts = records(frames["verdict"])
    offs = verdict.scenes(experiment)
    rows = [_row(row, offs.get((row["solver"], row["route"]), {})) for row in verdicts]
    hero = ladder_case(experiment.cases)
    film = next((m for m in moving if m["label"] == hero), moving[0] if moving else None)
    case = next((c for c in experiment.cases if film and c.label == film["label"]), None)
    exclusions = verdict.exclusions(experiment)
    timings = records(frames["work_precision"]) if "work_precision" in frames else []
    cost_case = next((row["cost_case"] for row in verdicts if row["cost_case"]), hero)
    return {
        "compared": _comparison(experiment),
        "measure": _measure(experiment),
        "rows": engine_rows(experiment, verdicts, offs, timings, cost_case),
        "strip": strip_plot(verdicts, offs),
        "sentence": verdict_text.sentence(verdicts, records(frames["pairs"])),
        "lead": verdict_text.LEAD,
        "friction": verdict.cost_of_friction(
            [experiment.truths[label].friction_sensitivity for label in verdict.friction_cases(experiment)]
        ),
        "lost": lost_text(manifest["lost"]),
        "warnings": [
            {"case": label, "why": truth.failure} for label, truth in experiment.truths.items() if truth.failure
        ],
        "engines": [row for row in rows if not row["our_part"]],
        "partly_ours": [row for row in rows if row["our_part"]],
        "map": engine_map(experiment, [(row["solver"], row["route"]) for row in verdicts], exclusions),
        "is_ours": {(row["solver"], row["route"]) for row in verdicts if row["our_part"]},
        "chart": off_chart(cost_case, records(frames["trajectories"]), timings),
        "friction_cases": len(experiment.truths) - len(exclusions),
        "cost_case": cost_case,
        "anchor": anchor,
        "hero": film and {"label": film["label"], "anchor": anchor(film["label"]), "said": case_summary(case)},
        "absent": missing_words(experiment.versions),
        "provenance": f"Made {manifest['made_at'][:10]} on {manifest['machine']}.",
    }


def _comparison(experiment: Experiment) -> str:
    """One sentence about what was compared."""
    solvers = dict.fromkeys(solver for _, solver, route in routes(experiment.runs) if route and solver != REFERENCE)
    engines, many = ", ".join(solvers) or "no engine", len(experiment.cases)
    return (
        f"{many} scene{'s' * (many != 1)} of rigid plates on planar curves with Coulomb friction, in "
        f"{sum(map(is_of_an_engine, experiment.runs)):,} motions of {engines}, compared with a motion computed from "
        "the equations of Ogaru and Pandrea and certified to the last digits."
    )


def _measure(experiment: Experiment) -> str:
    """What was measured, in a sentence."""
    many = len(verdict.friction_cases(experiment))
    scenes = f"{many} scenes" if many != 1 else "One scene"
    return (
        f"{scenes} in which a disc, box or rod slides, sticks, rolls or lifts off, as friction's law decides. The true "
        "times are known, each with an error bar; this is how far engines are from them. "
        "100 % off is as bad as ignoring friction."
    )


def is_of_an_engine(run: Run) -> bool:
    """Whether a run is a motion of an engine, not of the reference."""
    return run.solver != REFERENCE and run.score is not None


def _row(row: Mapping[str, Any], offs: Mapping[str, verdict.SceneOffs]) -> dict[str, Any]:
    """A row of the verdict; rows of engines carry their errors of each case, from which the page's sentence is made."""
    return {
        "solver": row["solver"],
        "route": row["route"],
        "id": identifier(row["solver"]),
        "our_part": row["our_part"],
        "scenes": json.dumps(_numbers(offs)) if verdict.is_engine(row) else "",
        "cells": [
            {"head": head, "text": text, "small": small} for head, (text, small) in verdict_text.cells(row).items()
        ],
    }


def _numbers(offs: Mapping[str, verdict.SceneOffs]) -> dict[str, tuple[float | None, float, float]]:
    """Of each case off with default settings (None: unknown), off and its doubt at the finest setting, to 6 digits."""
    return {
        case: (
            float(f"{own.default:.6g}") if isfinite(own.default) else None,
            float(f"{own.finest.off:.6g}"),
            float(f"{own.finest.doubt:.6g}"),
        )
        for case, own in offs.items()
    }
