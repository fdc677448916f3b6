"""Whether every rung of every ladder pays, or another setting of the same engine is cheaper and as good."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...analysis.columns import Table
from ...running.calls import Calls
from .. import Request
from . import measure
from .measure import Cell

if TYPE_CHECKING:
    from ...drawing.files import Drawn

TITLE = "Whether every rung pays"
QUESTION = (
    "Each engine's ladder beside a grid of all its knobs, over several scenes: whether a setting is left that is "
    "cheaper and as good as a rung."
)
TAKES = ("case", "solver")
IN_REPORT = False  # it holds the ladders to what they promise, and says nothing of the cases
TABLES = {
    "settings": Table(
        "Rungs and settings of a grid, in the mean of the cases, and what beats a rung",
        {
            "solver": "the engine",
            "route": "its route",
            "place": "which rung of the ladder or setting of the grid; ladder or grid where the route offers none",
            "setting": "the setting, as it is in the first of the cases",
            "outcome": "right or wrong over the cases; refused, crashed or timed_out: it gave no motion in one of them",
            "reason": "why, and in which case",
            "cost": "CPU time over the case's median setting, geometric mean",
            "first_transition": "error of the first transition's time, s, geometric mean",
            "all_transitions": "largest error of all transitions' times, s, geometric mean",
            "right": "in how many of the cases all transitions are matched",
            "cases": "how many cases it gave a motion of, where it did of all",
            "on_envelope": "whether no setting of the grid is cheaper and as good, or as cheap and better",
            "beaten_by": "the cheapest setting of the grid that is, of a rung",
        },
    )
}


def run(request: Request, calls: Calls) -> list[Cell]:
    """The cells of all ladders and grids."""
    return measure.measure(request.cases_or(measure.CASES), request.engines, calls)


def rows(found: list[Cell]) -> dict[str, list[dict[str, Any]]]:
    """The table of settings."""
    return {"settings": measure.rows(found)}


def summary(found: list[Cell]) -> str:
    """The rungs alone; the grid is in the table."""
    from tabulate import tabulate

    keys = (
        "solver",
        "route",
        "place",
        "outcome",
        "cost",
        *measure.QUANTITIES,
        "right",
        "cases",
        "on_envelope",
        "beaten_by",
    )
    rungs = [{key: row[key] for key in keys} for row in measure.rows(found) if not row["place"].startswith("grid")]
    return tabulate(rungs, headers="keys", floatfmt=".3g", tablefmt="plain")


def draw(found: list[Cell], folder: Path) -> Iterator[Drawn]:
    """Write the figure of errors against costs."""
    from .figure import draw as drawn

    yield from drawn(found, folder)
