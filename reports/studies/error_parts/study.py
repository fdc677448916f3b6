"""The parts of an error: how much is the step's, how much the model's, and which knob to turn next."""

from __future__ import annotations

from typing import Any

from ...analysis.columns import Table
from ...running.calls import Calls
from .. import Request
from . import measure
from .figure import draw as draw
from .measure import Cell

TITLE = "The parts of an error"
QUESTION = (
    "Step and model parameter are varied against each other: how much of an error is the step's, how much the facets', "
    "the penalty's or the regularised friction's, and which to turn next."
)
TAKES = ("case", "solver")
IN_REPORT = True
TABLES = {
    "error_parts": Table(
        "How much of an error is the step's, how much the model's, and which knob to turn next",
        {
            "case": "the case",
            "solver": "the engine",
            "route": "its route",
            "quantity": "first_transition_time in s, energy_lost in J, final_centre in m",
            "setting": "the knobs that differ within the grid",
            "total": "the error at this setting, signed (of the centre: its size)",
            "finest_error": "the error where every knob is finest",
            "step_part": "what the step adds if the model is at its finest",
            "model_part": "what the model adds if the step is at its finest",
            "interaction": "what is left of the total",
            "model_parts": "what each knob of the model adds by itself",
            "turn_next": "the knob whose next notch lowers the error most; all: only together; none: nothing does",
            "makes_worse": "the knobs whose next notch makes the error larger",
            "outcome": "right, wrong, refused, crashed or timed_out",
            "reason": "why it is not right",
        },
    )
}


def run(request: Request, calls: Calls) -> list[Cell]:
    """The cells of all grids."""
    return measure.measure(request.cases_or(measure.CASES), request.engines, calls)


def rows(found: list[Cell]) -> dict[str, list[dict[str, Any]]]:
    """The table of parts."""
    return {"error_parts": measure.rows(found)}
