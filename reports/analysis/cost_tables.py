"""The tables of accuracy and cost, by name."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..running.records import Experiment
from . import time_to_accuracy, which_engine
from .work_precision import CostMeasurements, fit_rows, work_precision_rows

if TYPE_CHECKING:
    import pandas as pd

HOLDS = {
    "which_engine": "The fastest engine and method of the reference for each level, for the first run and 1,000 runs",
    "time_to_accuracy": "CPU time of each route to each level, and its ratio to the fastest route",
    "work_precision": "Error, CPU time, whole calls and parts of time of every usable run of the timed cases",
    "work_precision_fits": "Orders in steps and in CPU time, and where and why the error saturates",
    "null_scores": "Errors of motions that ignore friction's law",
}


def frames(experiment: Experiment, measurements: CostMeasurements) -> dict[str, pd.DataFrame]:
    """The tables of this section; none if nothing was timed."""
    import pandas as pd

    if not measurements.cases:
        return {}
    times = time_to_accuracy.rows(experiment, measurements)
    return {
        "which_engine": pd.DataFrame(which_engine.rows(times)),
        "time_to_accuracy": pd.DataFrame(times),
        "work_precision": pd.DataFrame(work_precision_rows(experiment, measurements)),
        "work_precision_fits": pd.DataFrame(fit_rows(experiment, measurements)),
        "null_scores": pd.DataFrame([row for baseline in measurements.nulls.values() for row in baseline.rows]),
    }
