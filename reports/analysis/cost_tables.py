"""The tables of what accuracy costs, by name."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..running.records import Experiment
from . import time_to_accuracy, which_engine
from .work_precision import CostMeasurements, fit_rows, work_precision_rows

if TYPE_CHECKING:
    import pandas as pd

HOLDS = {
    "which_engine": "Which engine for which accuracy, at what cost, once and a thousand times",
    "time_to_accuracy": "CPU time of each route to each accuracy, and its ratio to the fastest route",
    "work_precision": "Error, CPU time, whole calls and parts of time of every right run of the timed cases",
    "work_precision_fits": "Orders in steps and in CPU time, and where and why the error saturates",
    "null_scores": "What motions that know nothing of friction's law would score",
}


def frames(experiment: Experiment, measured: CostMeasurements) -> dict[str, pd.DataFrame]:
    """The tables of this section; none if nothing was timed."""
    import pandas as pd

    if not measured.cases:
        return {}
    points = work_precision_rows(experiment, measured)
    told = time_to_accuracy.rows(points)
    return {
        "which_engine": pd.DataFrame(which_engine.rows(told)),
        "time_to_accuracy": pd.DataFrame(told),
        "work_precision": pd.DataFrame(points),
        "work_precision_fits": pd.DataFrame(fit_rows(experiment, measured)),
        "null_scores": pd.DataFrame([row for told in measured.nulls.values() for row in told.rows]),
    }
