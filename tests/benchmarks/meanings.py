"""The meaning of each engine's parameters of friction, restitution and rolling, from its adapter's `MEANINGS`.

`python -m tests.benchmarks.meanings > docs/engine_parameters.md` writes the same table for readers of the repository.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Any

from adapters.processes.worker import CallResult
from cases.files.command_line import status
from reports.running.calls import Calls
from reports.running.names import REFERENCE
from reports.running.solvers import names as all_solvers
from reports.running.solvers import solver
from reports.running.time_limits import ASKING_SECONDS
from reports.studies import Request

TITLE = "What the engines' parameters mean"
QUESTION = (
    "What each engine calls friction, restitution and rolling resistance, how it combines the two bodies' numbers, and "
    "how it uses them. If an engine uses a different law from the case's, the run is made and marked."
)

COLUMNS = ("solver", "outcome", "route", "effect", "parameter", "law", "duration")
# Columns of the page for the repository, which is made on a machine with all engines.
IN_TEXT = ("solver", "route", "effect", "parameter", "law", "duration")


def of_one(name: str) -> list[dict[str, Any]]:
    """The rows of one engine. Raises ImportError if it is not installed."""
    module = solver(name)
    entries = [
        _row(
            name,
            route=", ".join(meaning.routes or map(str, module.routes)),
            effect=meaning.effect.__name__,
            parameter=meaning.parameter,
            law=meaning.law,
            duration=meaning.duration,
        )
        for meaning in getattr(module, "MEANINGS", ())
    ]
    return entries or [_row(name, law="not reported by its adapter")]


def _row(name: str, outcome: str = "done", **cells: str) -> dict[str, Any]:
    return dict.fromkeys(COLUMNS, "") | {"solver": name, "outcome": outcome} | cells


def run(request: Request, calls: Calls) -> list[dict[str, Any]]:
    """The rows of all engines; an engine that fails has a row with the reason."""
    engines = [name for name in request.solvers or all_solvers() if name != REFERENCE]
    limit = min(calls.limit, ASKING_SECONDS)
    answers = calls.all("meanings", of_one, [(name,) for name in engines], limit=limit, brief=True)
    return [row for name, answer in zip(engines, answers, strict=True) for row in _rows_of(name, answer)]


def _rows_of(name: str, answer: CallResult) -> list[dict[str, Any]]:
    if answer.outcome == "done":
        return answer.value
    outcome, reason = answer.failure
    return [_row(name, outcome, law=f"unknown: {reason}")]


def rows(findings: list[dict[str, Any]]) -> dict[str, list[dict[str, Any]]]:
    """The table of meanings."""
    return {"meanings": findings}


def as_lines(findings: Sequence[dict[str, Any]]) -> list[str]:
    """The table in Markdown, one line per row."""
    return ["| " + " | ".join(str(row[column]) for column in IN_TEXT) + " |" for row in findings]


def as_text(findings: Sequence[dict[str, Any]]) -> str:
    """The table as a page in Markdown."""
    head = ["| " + " | ".join(IN_TEXT) + " |", "|" + "---|" * len(IN_TEXT)]
    note = "Made from the adapters by `python -m tests.benchmarks.meanings`; a test compares."
    return "\n".join([f"# {TITLE}", "", QUESTION, "", *head, *as_lines(findings), "", note])


def _print_page(words: Sequence[str]) -> None:
    from tests.benchmarks import meanings  # workers import functions by their module's name, which is not __main__

    with Calls() as calls:
        print(meanings.as_text(meanings.run(Request(), calls)))


if __name__ == "__main__":
    sys.exit(status("tests.benchmarks.meanings", _print_page, None))
