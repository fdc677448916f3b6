"""Which coordinates to integrate: the paper's ten, plain, stabilised or projected, or the independent ones."""

from __future__ import annotations

from typing import Any

from reports.analysis.columns import Table
from reports.running.calls import Calls
from reports.studies import Request

from . import measure

TABLES = {
    "formulation_study": Table(
        "Ten coordinates plain, stabilised, projected; independent coordinates: drift and cost",
        {
            "scene": "the motion of an unbalanced ellipse in an ellipse",
            "formulation": "the integrated coordinates",
            "rtol": "relative (and absolute) tolerance of the integrator",
            "gap": "largest distance of the contact points (5), m",
            "gap_drift": "the last such distance over the time it took, m/s",
            "tangency": "largest residual of (6), R_p' U θ r_p, m²",
            "velocity_residual": "largest residual of (8), m/s",
            "centre_error": "largest distance of the centre from the truth, m",
            "steps": "steps of the integrator",
            "evaluations": "evaluations of (27)",
            "cpu_s": "CPU time of one run, possibly with other load, s",
            "outcome": "done, crashed or timed_out",
            "reason": "the reason of any other outcome than done",
        },
    )
}


def run(request: Request, calls: Calls) -> list[dict[str, Any]]:
    """The rows of all scenes."""
    return measure.measure(measure.TOLERANCES if request.full else measure.TOLERANCES[::2], calls)


def rows(findings: list[dict[str, Any]]) -> dict[str, list[dict[str, Any]]]:
    """The table of drift and cost."""
    return {"formulation_study": findings}
