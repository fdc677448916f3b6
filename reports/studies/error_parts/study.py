"""The parts of an error: those of the step and of the model, and the parameter to refine next."""

from __future__ import annotations

from typing import Any

from ...analysis.columns import Table, words
from ...running.calls import Calls
from .. import Request
from . import measure
from .figure import draw as draw
from .measure import ErrorCell

TITLE = "The parts of an error"
QUESTION = (
    "Step and model parameters are varied independently: how much of an error is due to the step, the facets, the "
    "penalty or the regularised friction, and which to refine next."
)
TAKES = ("case", "solver")
IN_REPORT = False
TABLES = {
    "error_parts": Table(
        "The parts of an error due to the step and to the model, and the parameter to refine next",
        words("case", "solver", "route")
        | words(
            quantity="first_transition_time, s; energy_lost, over the largest true kinetic energy; final_centre, m",
            setting="the parameters that differ within the grid",
            total="the error at this setting, signed (of the centre: its size)",
            finest_error="the error at the finest value of every parameter",
            step_part="error added by the step with the finest model",
            model_part="error added by the model with the finest step",
            interaction="the remainder of the total",
            model_parts="error added by each parameter of the model alone",
            turn_next="parameter whose next level reduces the error most; all: only together; none: nothing does",
            makes_worse="the parameters whose next level increases the error",
        )
        | words("off", "grade", "outcome")
        | words(reason="transitions that are not paired with the truth's, or the reason of any other outcome"),
    )
}


def run(request: Request, calls: Calls) -> list[ErrorCell]:
    """The cells of all grids."""
    return measure.measure(request.cases_or(measure.CASES), request.engines, calls)


def rows(cells: list[ErrorCell]) -> dict[str, list[dict[str, Any]]]:
    """The table of parts."""
    return {"error_parts": measure.rows(cells)}
