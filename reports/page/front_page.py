"""The first screen of the page: engines, what to change, all scenes, error against cost, a motion, the verdict."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite
from typing import TYPE_CHECKING, Any

from ..analysis import verdict
from ..drawing import figures
from ..drawing.colours import LineStyles
from ..running.ladder_selection import ladder_case
from ..running.names import REFERENCE
from ..running.records import Experiment, Run, routes
from ..running.solvers import missing_words
from .case_matrix import legend, matrix
from .chapters import case_summary
from .engine_rows import changes, engine_rows
from .fragments import anchor, figure_of, records
from .text import lost_text

if TYPE_CHECKING:
    import pandas as pd


def screen(
    experiment: Experiment,
    frames: Mapping[str, pd.DataFrame],
    moving: Sequence[Mapping[str, Any]],
    manifest: Mapping[str, Any],
    looks: LineStyles,
) -> dict[str, Any]:
    """Data for the template of the first screen."""
    verdicts = records(frames["verdict"])
    offs = verdict.scenes(experiment)
    hero = ladder_case(experiment.cases)
    film = next((m for m in moving if m["label"] == hero), moving[0] if moving else None)
    case = next((c for c in experiment.cases if film and c.label == film["label"]), None)
    keys = [(row["solver"], row["route"]) for row in verdicts]
    own = {key: offs[key] for key, row in zip(keys, verdicts, strict=True) if verdict.is_engine(row)}
    timings = records(frames["work_precision"]) if "work_precision" in frames else []
    cost_case = next((row["cost_case"] for row in verdicts if row["cost_case"]), hero)
    return {
        "compared": _comparison(experiment),
        "measure": _measure(experiment),
        "changes": changes(experiment, verdicts),
        "rows": engine_rows(experiment, verdicts, offs, timings, cost_case),
        "strip": figure_of(figures.strip(own, lambda label: f"#{anchor(label)}"), looks, 68.0 * len(own) + 56.0),
        "friction": verdict.cost_of_friction(
            [experiment.truths[label].friction_sensitivity for label in verdict.friction_cases(experiment)]
        ),
        "lost": lost_text(manifest["lost"]),
        "warnings": [
            {"case": label, "why": truth.failure} for label, truth in experiment.truths.items() if truth.failure
        ],
        "matrix": matrix(experiment, keys),
        "grade_keys": legend(),
        "chart": _chart(experiment, timings, cost_case, looks),
        "cost_case": cost_case,
        "anchor": anchor,
        "hero": film and {"label": film["label"], "anchor": anchor(film["label"]), "said": case_summary(case)},
        "absent": missing_words(experiment.versions),
        "provenance": f"Made {manifest['made_at'][:10]} on {manifest['machine']}.",
    }


def _chart(
    experiment: Experiment, timings: Sequence[Mapping[str, Any]], label: str, looks: LineStyles
) -> dict[str, Any] | None:
    """Off against cost of every setting of a case, or against steps where nothing was timed; says how many settings
    were not timed."""
    rows = [row for row in timings if (row["case"], row["quantity"]) == (label, "off")]
    if not any(isfinite(row["call_s"]) for row in rows):
        case = next((case for case in experiment.cases if case.label == label), None)
        return figure_of(figures.against_steps(experiment, case) if case else None, looks, 300.0)
    chart = figure_of(figures.against_cost(label, rows), looks, 300.0)
    missing = sum(not isfinite(row["call_s"]) for row in rows)
    if chart and missing:
        chart["caption"] += f" Not timed: {missing} settings."
    return chart


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
