"""The paper's application over friction and start: kinds of motion, their times, and where engines are wrong."""

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
    "The paper treats three coefficients of friction and does not state where the disc is released. These maps cover "
    "the whole range of both: where it rolls, where its slip reverses, and, in a full report, where engines with "
    "default settings are wrong."
)
TAKES = ()
IN_REPORT = True
TABLES = {
    "maps": Table(
        "Kinds of motion of the paper's application over friction and start, counted",
        {
            "case": "the scene, over mu and xi1",
            "solver": "the solver",
            "route": "its route",
            "what": "for the reference the first and second phase of the motion; for an engine its verdict or failure",
            "scenarios": "number of scenarios",
            "share": "its fraction of all scenarios",
            "earliest": "the earliest first transition among them, s",
            "latest": "the latest first transition among them, s",
        },
    )
}


def run(request: Request, calls: Calls) -> list[Map]:
    """The maps."""
    return measure.measure(request.full, calls)


def rows(findings: list[Map]) -> dict[str, list[dict[str, Any]]]:
    """The table."""
    return {"maps": measure.rows(findings)}
