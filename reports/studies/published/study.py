"""Numbers published by other programs, compared with ours: a table made once, as no engine takes part.

`python -m tests.authorities.published` writes it, in a clone, from the scenes that the tests compute again."""

from __future__ import annotations

import csv
from pathlib import Path

from ...analysis.columns import Table
from ...running.calls import Calls
from ...running.records import Row
from .. import Request

TITLE = "Published numbers of other programs"
QUESTION = (
    "Published motions of other programs, computed by the reference: each number with its source, its publisher's own "
    "accuracy and the difference. Where a published value is known to be wrong, the note gives the reason."
)
TAKES = ()
TAB = "evidence"
IN_REPORT = True
TABLES = {
    "published": Table(
        "Numbers that other programs publish, and ours",
        {
            "program": "program",
            "scene": "scene",
            "quantity": "quantity",
            "published": "published",
            "ours": "ours",
            "difference": "difference",
            "accuracy": "publisher's own accuracy",
            "verdict": "verdict",
            "note": "why they differ, or what is compared",
            "source": "source",
        },
    )
}
_FILE = Path(__file__).with_name("numbers.csv")


def run(request: Request, calls: Calls) -> list[Row]:
    """The rows of the table."""
    with open(_FILE, newline="", encoding="utf-8") as file:
        records = list(csv.DictReader(file))
    return [row | {name: float(row[name]) for name in ("difference", "accuracy")} for row in records]


def rows(findings: list[Row]) -> dict[str, list[Row]]:
    """The table of published numbers."""
    return {"published": findings}
