"""Numbers published by other programs, compared with ours."""

from __future__ import annotations

from ...analysis.columns import Table
from ...running.calls import Calls, StorePolicy
from ...running.records import Row
from .. import Request
from . import COLUMNS, PUBLICATIONS
from .publications import rows as compared

TITLE = "Published numbers of other programs"
QUESTION = (
    "Published motions of other programs, computed by the reference: each number with its source, its publisher's own "
    "accuracy and the difference. Where a published value is known to be wrong, the note gives the reason."
)
TAKES = ()
TAB = "evidence"
IN_REPORT = True
TABLES = {"published": Table("Numbers that other programs publish, and ours", COLUMNS)}


def of_one(index: int) -> list[Row]:
    """The rows of one publication, by its index in `PUBLICATIONS`."""
    return compared(PUBLICATIONS[index : index + 1])


def run(request: Request, calls: Calls) -> list[Row]:
    """The rows of all publications; one that could not be computed has a row with the reason."""
    answers = calls.all("published numbers", of_one, [(i,) for i in range(len(PUBLICATIONS))], keep=StorePolicy())
    table_rows: list[Row] = []
    for publication, answer in zip(PUBLICATIONS, answers, strict=True):
        if answer.outcome == "done":
            table_rows += answer.value
        else:
            labels = dict(program=publication.program, scene=publication.name, source=publication.source)
            table_rows.append(dict.fromkeys(COLUMNS) | labels | {"verdict": answer.outcome, "note": answer.reason})
    return table_rows


def rows(findings: list[Row]) -> dict[str, list[Row]]:
    """The table of published numbers."""
    return {"published": findings}
