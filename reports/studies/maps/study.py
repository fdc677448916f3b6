"""The paper's application over friction and start: what follows, when, and which engine gets it wrong where."""

from __future__ import annotations

from typing import Any

from ...analysis.columns import Table
from ...running.calls import Calls
from .. import Request
from . import measure
from .figure import draw as draw
from .measure import Map

TITLE = "Maps over friction and start"
QUESTION = (
    "The paper asks about three coefficients and does not say where the disc is let go. Here are all of both: when it "
    "rolls, when its slip reverses, and, in a full report, where engines as they come get that wrong."
)
TAKES = ()
IN_REPORT = True
TABLES = {
    "maps": Table(
        "The paper's application over friction and start, counted",
        {
            "case": "the scene, over mu and xi1",
            "solver": "who solves it",
            "route": "by which route",
            "what": "of the reference what the motion does first and next; of an engine its verdict, or its failure",
            "scenarios": "in how many scenarios",
            "share": "the same as a part of all",
            "earliest": "the earliest first transition among them, s",
            "latest": "and the latest",
        },
    )
}


def run(request: Request, calls: Calls) -> list[Map]:
    """The maps."""
    return measure.measure(request.full, calls)


def rows(found: list[Map]) -> dict[str, list[dict[str, Any]]]:
    """The table."""
    return {"maps": measure.rows(found)}
