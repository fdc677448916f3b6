"""Whether every rung is worth its cost, or another setting of the same engine is faster and as accurate.

The usual combinations, which stand for an engine's default settings, are not from here: adapters have `default_grid`.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from reports.analysis.columns import Table
from reports.running.calls import Calls
from reports.studies import Request

from . import measure
from .measure import SettingCell

if TYPE_CHECKING:
    from reports.drawing.figure_files import FigureEntry

TITLE = "Whether every rung is worth its cost"
QUESTION = (
    "Each engine's ladder compared with a grid of all its parameters, over several scenes: whether another setting is "
    "faster than a rung and as accurate."
)
TAKES = ("case", "solver")

TABLES = {
    "settings": Table(
        "Rungs and settings of a grid, averaged over the cases, and the settings that beat a rung",
        {
            "solver": "the engine",
            "route": "its route",
            "place": "number of the rung or of the setting in the grid; ladder or grid if the route offers none",
            "setting": "the setting, as it is in the first of the cases",
            "outcome": "answered; unsupported, crashed or timed_out: no motion in one of the cases",
            "reason": "the reason, and the case",
            "cost": "CPU time over the case's median setting, geometric mean",
            "off": "error as a share of the error of ignoring friction's law, geometric mean of max(off, 1e-4)",
            "grade": "the grade of that mean",
            "worst_off": "the largest off",
            "cases": "number of cases, if it gave a motion in all of them",
            "on_envelope": "whether no setting of the grid is faster and as accurate, or as fast and more accurate",
            "beaten_by": "for a rung: the fastest setting of the grid that beats it",
        },
    )
}


def run(request: Request, calls: Calls) -> list[SettingCell]:
    """The cells of all ladders and grids."""
    return measure.measure(request.cases_or(measure.CASES), request.engines, calls)


def rows(cells: list[SettingCell]) -> dict[str, list[dict[str, Any]]]:
    """The table of settings."""
    return {"settings": measure.rows(cells)}


def summary(cells: list[SettingCell]) -> str:
    """The rungs as text for the terminal; the grid is only in the table."""
    from tabulate import tabulate

    keys = (
        "solver",
        "route",
        "place",
        "outcome",
        "cost",
        "off",
        "grade",
        "worst_off",
        "cases",
        "on_envelope",
        "beaten_by",
    )
    rungs = [{key: row[key] for key in keys} for row in measure.rows(cells) if not row["place"].startswith("grid")]
    return tabulate(rungs, headers="keys", floatfmt=".3g", tablefmt="plain")


def draw(cells: list[SettingCell], folder: Path) -> Iterator[FigureEntry]:
    """Write the figure of errors against costs."""
    from .figure import draw as draw_figure

    yield from draw_figure(cells, folder)
