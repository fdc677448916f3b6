"""What each engine's parameters of friction, restitution and rolling mean, as its adapter tells (`MEANINGS`).

`python -m reports.studies.meanings > docs/engine_parameters.md` writes the same for whoever reads the repository.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from ...analysis.columns import Table
from ...drawing.files import Drawn
from ...running.calls import Calls
from ...running.records import REFERENCE
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
    "engine": "the engine",
    "route": "the routes of its adapter it holds for",
    "effect": "the effect of a case",
    "parameter": "the engine's word for it, and what it is given",
    "law": "what the engine does with it",
}
TABLES = {"meanings": Table("What each engine's friction, restitution and rolling parameters mean", COLUMNS)}


def of_one(name: str) -> list[dict[str, Any]]:
    """The rows of one engine; none if its adapter tells nothing. Raises ImportError if it is not installed."""
    module = solver(name)
    return [
        dict(
            engine=name,
            route=", ".join(meaning.routes or map(str, module.routes)),
            effect=meaning.effect.__name__,
            parameter=meaning.parameter,
            law=meaning.law,
        )
        for meaning in getattr(module, "MEANINGS", ())
    ]


def run(request: Request, calls: Calls) -> list[dict[str, Any]]:
    """The rows of all engines; one that cannot be asked says why."""
    asked = [name for name in request.solvers or all_solvers() if name != REFERENCE]
    found: list[dict[str, Any]] = []
    for name, answer in zip(asked, calls.all("meanings", of_one, [(name,) for name in asked]), strict=True):
        unknown = dict.fromkeys(COLUMNS, "") | {"engine": name, "law": f"not known: {answer.reason}"}
        found += answer.value if answer.outcome == "done" else [unknown]
    return found


def rows(found: list[dict[str, Any]]) -> dict[str, list[dict[str, Any]]]:
    """The one table."""
    return {"meanings": found}


def draw(found: list[dict[str, Any]], folder: Path) -> Iterator[Drawn]:
    """Nothing: it is a table."""
    yield from ()


def as_lines(found: Sequence[dict[str, Any]]) -> list[str]:
    """The table in Markdown, a line to a row."""
    return ["| " + " | ".join(str(row[column]) for column in COLUMNS) + " |" for row in found]


def as_text(found: Sequence[dict[str, Any]]) -> str:
    """The table as a page."""
    head = ["| " + " | ".join(COLUMNS) + " |", "|" + "---|" * len(COLUMNS)]
    note = "Made from the adapters by `python -m reports.studies.meanings`; a test compares."
    return "\n".join([f"# {TITLE}", "", QUESTION, "", *head, *as_lines(found), "", note])
