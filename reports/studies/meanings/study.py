"""What each engine's parameters of friction, restitution and rolling mean, as its adapter tells (`MEANINGS`).

`python -m reports.studies.meanings > docs/engine_parameters.md` writes the same for whoever reads the repository.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from ...analysis.columns import Table
from ...drawing.files import Drawn
from ...running.calls import ASKING_SECONDS, Calls
from ...running.records import REFERENCE
from ...running.serving import Answer
from ...running.solvers import names as all_solvers
from ...running.solvers import solver
from .. import Request

TITLE = "What the engines' parameters mean"
QUESTION = (
    "What each engine calls friction, restitution and rolling resistance, how it combines the two bodies' numbers, and "
    "what it does with them. What it models by another law than a case's is run, and the run's row tells so."
)
TAKES = ("solver",)
IN_REPORT = True
COLUMNS = {
    "solver": "the engine",
    "outcome": "done, crashed or timed_out: what came of asking its adapter",
    "route": "the routes of its adapter it holds for",
    "effect": "the effect of a case",
    "parameter": "the engine's word for it, and what it is given",
    "law": "what the engine does with it; why it is not known, where its adapter does not tell",
}
# The page for the repository is made where all adapters answer.
IN_TEXT = ("solver", "route", "effect", "parameter", "law")
TABLES = {"meanings": Table("What each engine's friction, restitution and rolling parameters mean", COLUMNS)}


def of_one(name: str) -> list[dict[str, Any]]:
    """The rows of one engine. Raises ImportError if it is not installed."""
    module = solver(name)
    told = [
        _row(
            name,
            route=", ".join(meaning.routes or map(str, module.routes)),
            effect=meaning.effect.__name__,
            parameter=meaning.parameter,
            law=meaning.law,
        )
        for meaning in getattr(module, "MEANINGS", ())
    ]
    return told or [_row(name, law="its adapter tells none")]


def _row(name: str, outcome: str = "done", **told: str) -> dict[str, Any]:
    return dict.fromkeys(COLUMNS, "") | {"solver": name, "outcome": outcome} | told


def run(request: Request, calls: Calls) -> list[dict[str, Any]]:
    """The rows of all engines; one that cannot be asked says why."""
    asked = [name for name in request.solvers or all_solvers() if name != REFERENCE]
    limit = min(calls.limit, ASKING_SECONDS)
    answers = calls.all("meanings", of_one, [(name,) for name in asked], limit=limit, brief=True)
    return [row for name, answer in zip(asked, answers, strict=True) for row in _rows_of(name, answer)]


def _rows_of(name: str, answer: Answer) -> list[dict[str, Any]]:
    if answer.outcome == "done":
        return answer.value
    outcome, reason = answer.failure
    return [_row(name, outcome, law=f"not known: {reason}")]


def rows(found: list[dict[str, Any]]) -> dict[str, list[dict[str, Any]]]:
    """The one table."""
    return {"meanings": found}


def draw(found: list[dict[str, Any]], folder: Path) -> Iterator[Drawn]:
    """Nothing: it is a table."""
    yield from ()


def as_lines(found: Sequence[dict[str, Any]]) -> list[str]:
    """The table in Markdown, a line to a row."""
    return ["| " + " | ".join(str(row[column]) for column in IN_TEXT) + " |" for row in found]


def as_text(found: Sequence[dict[str, Any]]) -> str:
    """The table as a page."""
    head = ["| " + " | ".join(IN_TEXT) + " |", "|" + "---|" * len(IN_TEXT)]
    note = "Made from the adapters by `python -m reports.studies.meanings`; a test compares."
    return "\n".join([f"# {TITLE}", "", QUESTION, "", *head, *as_lines(found), "", note])
