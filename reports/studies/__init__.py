"""The studies that stand beside the comparison, each with a question, tables and pictures of its own.

A study that fails is told in its place; it takes nothing else with it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    import pandas as pd

    from ..drawing.style import Drawn
    from ..options import Plan

Tell = Callable[[str, int, Iterator], Iterator]
Calls = Callable[..., Iterator]
Draw = Callable[[Path], Iterator["Drawn"]]


class Study(NamedTuple):
    """What a study found: its anchor, title and question on the page, the command that makes it alone, tables by name,
    how its pictures are drawn into a folder; or why it failed, in a sentence."""

    name: str
    title: str
    question: str
    command: str
    frames: dict[str, pd.DataFrame]
    draw: Draw
    failure: str = ""


def _effects(plan: Plan, tell: Tell, calls: Calls):
    from .effect_costs import measure as effect_costs

    rows = effect_costs.measure(plan.solvers, plan.jobs, tell=tell, calls=calls)
    return {"effect_costs": effect_costs.frame(rows)}, lambda folder: effect_costs.draw(rows, folder)


def _parts(plan: Plan, tell: Tell, calls: Calls):
    from .error_parts import figure as error_parts_figure
    from .error_parts import measure as error_parts

    engines = [name for name in plan.solvers if name != "reference"]
    cells = error_parts.measure(error_parts.chosen(plan.cases), engines, plan.files, plan.jobs, tell, calls)
    return {"error_parts": error_parts.frame(cells)}, lambda folder: error_parts_figure.draw(cells, folder)


def _hard(plan: Plan, tell: Tell, calls: Calls):
    from .stability import measure as stability

    full = plan.effort == "full"
    found = stability.measure(stability.atlas(full), plan.solvers, full, plan.jobs, tell=tell, calls=calls)
    return stability.frames(found), lambda folder: stability.draw(found, folder)


def _formulations(plan: Plan, tell: Tell, calls: Calls):
    from .formulations import measure as formulations

    tolerances = formulations.TOLERANCES if plan.effort == "full" else formulations.TOLERANCES[::2]
    (rows,) = tell("formulations", 1, (formulations.rows(tolerances) for _ in range(1)))
    return {"formulation_study": formulations.frame(rows)}, lambda folder: formulations.draw(rows, folder)


# By name: title, question, and what answers it.
_STUDIES: dict[str, tuple[str, str, Callable]] = {
    "effect_costs": (
        "What each effect costs",
        "One scene with its effects added one at a time: what each costs, and how wrong the answer is without it.",
        _effects,
    ),
    "error_parts": (
        "The parts of an error",
        "Step and model parameter are varied against each other: how much of an error is the step's, how much the "
        "facets', the penalty's or the regularised friction's, and which to turn next.",
        _parts,
    ),
    "stability": (
        "Hard scenes",
        "Scenes that break solvers, and what each does there. One variant of each family; a full report has all. "
        "Chaotic: one unit in the last place of the inputs decides, so nobody is ranked.",
        _hard,
    ),
    "formulations": (
        "Which coordinates to integrate",
        "The paper's ten coordinates without stabilisation, with Baumgarte's, with projection, and the two independent "
        "ones: how far each drifts off its constraints, and what it costs.",
        _formulations,
    ),
}


def run(plan: Plan, tell: Tell, calls: Calls) -> list[Study]:
    """All studies of a plan: none in a quick report, nor where cases were named, unless it is a full one.

    `calls` makes what each study runs, as `workers.run` does."""
    if plan.effort == "quick" or (plan.asked and plan.effort != "full"):
        return []
    return [_one(name, plan, tell, calls) for name in _STUDIES]


def _one(name: str, plan: Plan, tell: Tell, calls: Calls) -> Study:
    title, question, find = _STUDIES[name]
    command = f"python -m reports.studies.{name}.measure"
    try:
        frames, draw = find(plan, tell, calls)
    except Exception as problem:  # whatever it is, the report goes on without this study and says so
        return Study(
            name, title, question, command, {}, lambda folder: iter(()), f"{type(problem).__name__}: {problem}"
        )
    return Study(name, title, question, command, frames, draw)


def drawn(studies: Sequence[Study], folder: Path) -> dict[str, list[Drawn]]:
    """Every study's pictures, written into the folder, by the study's name."""
    return {study.name: list(study.draw(folder)) for study in studies}
