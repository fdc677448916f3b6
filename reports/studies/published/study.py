"""Other people's numbers beside ours."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from ...analysis.columns import Table
from ...drawing.files import Drawn
from ...running.calls import Calls, Keep
from ...running.records import Row
from .. import Request
from . import COLUMNS, PUBLICATIONS
from .records import rows as compared

TITLE = "Other people's numbers"
QUESTION = (
    "Motions that other people's programs publish, computed by the reference: each number with its source, its "
    "publisher's own accuracy and the difference. Where a publisher is known to be off, it is said why."
)
TAKES = ()
IN_REPORT = True
TABLES = {"published": Table("Numbers that other programs publish, and ours", COLUMNS)}


def of_one(index: int) -> list[Row]:
    """The rows of one publication, by its place in `PUBLICATIONS`."""
    return compared(PUBLICATIONS[index : index + 1])


def run(request: Request, calls: Calls) -> list[Row]:
    """The rows of all publications; one that could not be computed says why."""
    answers = calls.all("published numbers", of_one, [(i,) for i in range(len(PUBLICATIONS))], keep=Keep())
    found: list[Row] = []
    for publication, answer in zip(PUBLICATIONS, answers, strict=True):
        if answer.outcome == "done":
            found += answer.value
        else:
            known = dict(program=publication.program, scene=publication.name, source=publication.source)
            found.append(dict.fromkeys(COLUMNS) | known | {"verdict": answer.outcome, "note": answer.reason})
    return found


def rows(found: list[Row]) -> dict[str, list[Row]]:
    """The one table."""
    return {"published": found}


def draw(found: list[Row], folder: Path) -> Iterator[Drawn]:
    """Nothing: it is a table."""
    yield from ()
