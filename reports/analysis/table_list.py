"""The tables of a report in their order: the content, the rows and the columns of each. Files, page and data package
iterate over `TABLES`; the words of a column are in `columns`, a study has its own tables."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

from ..judging.impacts import ImpulseRow
from ..running.records import Experiment
from . import convergence, levels, tables, time_to_accuracy, verdict, which_engine, work_precision
from .work_precision import CostMeasurements

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Results:
    """What the tables are made of: the experiment, the same with external motions, and the timings."""

    ran: Experiment
    shown: Experiment
    costs: CostMeasurements = field(default_factory=CostMeasurements)

    @cached_property
    def times(self) -> list[dict[str, Any]]:
        """The rows of `time_to_accuracy`, from which others are made; none if nothing was timed."""
        return time_to_accuracy.rows(self.ran, self.costs) if self.costs.cases else []

    @cached_property
    def verdicts(self) -> list[dict[str, Any]]:
        """The rows of the verdict."""
        return verdict.rows(self.shown, self.times)

    @cached_property
    def pairs(self) -> list[dict[str, Any]]:
        """The rows of pairs of engines."""
        return verdict.pairs(self.shown)


class TableSource(NamedTuple):
    """A table: its content, the function of its rows, its columns if it may have no rows, whether a report without
    timings lacks it, and its `keys`, if two reports are compared in it ("_number": several rows may have the same)."""

    holds: str
    rows: Callable[[Results], list[dict[str, Any]]]
    columns: tuple[str, ...] | None = None
    is_timed: bool = False
    keys: tuple[str, ...] = ()


_ROUTE = ("case", "solver", "route")
_RUN = (*_ROUTE, "setting")
_IMPACT_COLUMNS = (
    *(*_RUN, "event", "contact", "time", "reference_time", "error"),
    *("swing", "reference_swing"),
    *("closing_speed", "reference_closing_speed", "restitution", "reference_restitution"),
)
TABLES = {
    "verdict": TableSource(
        "How far each route is from the truth, and how many cases it answers, over the cases that depend on friction's "
        "law (1: as bad as ignoring it); engines by themselves first",
        lambda results: results.verdicts,
        verdict.COLUMNS,
        keys=("solver", "route"),
    ),
    "which_engine": TableSource(
        "The fastest engine and method of the reference for each level, for the first run and 1,000 runs",
        lambda results: which_engine.rows(results.times),
        is_timed=True,
    ),
    "time_to_accuracy": TableSource(
        "CPU time of each route to each level, and its ratio to the fastest route",
        lambda results: results.times,
        is_timed=True,
    ),
    "work_precision": TableSource(
        "Error, CPU time, whole calls and parts of time of every usable run of the timed cases",
        lambda results: work_precision.work_precision_rows(results.ran, results.costs),
        is_timed=True,
        keys=(*_RUN, "quantity"),
    ),
    "null_scores": TableSource(
        "Errors of motions that ignore friction's law",
        lambda results: [row for baseline in results.costs.nulls.values() for row in baseline.rows],
        is_timed=True,
        keys=("case", "motion"),
    ),
    "headline": TableSource(
        "Grade and errors of each route with default settings and at the finest setting run, case by case",
        lambda results: tables.headline_rows(results.shown),
        keys=_ROUTE,
    ),
    "levels": TableSource(
        "From which setting on each route stays within each level of accuracy",
        lambda results: levels.rows(results.shown),
        keys=(*_ROUTE, "level"),
    ),
    "transitions": TableSource(
        "Every transition of every run, paired with the truth's",
        lambda results: tables.transition_rows(results.shown),
        keys=(*_RUN, "event", "before", "after", "pairing", "_number"),
    ),
    "impacts": TableSource(
        "Impacts next to the truth's: restitution with one contact, swings and the time of rest with several",
        lambda results: tables.impact_rows(results.shown),
        _IMPACT_COLUMNS,
    ),
    "impulses": TableSource(
        "Impulses and work of each contact in each impact of the truth, and those of every run",
        lambda results: tables.impulse_rows(results.shown),
        (*_RUN, *ImpulseRow._fields),
    ),
    "trajectories": TableSource(
        "Every run: outcome, grade, score and reason, distance from the truth, cost",
        lambda results: tables.trajectory_rows(results.shown),
        keys=_RUN,
    ),
    "convergence": TableSource(
        "Orders of every route in steps and in CPU time, and where and why its error saturates",
        lambda results: convergence.convergence_rows(results.shown, results.costs),
        keys=(*_ROUTE, "quantity"),
    ),
    "truth": TableSource(
        "The certified transitions that runs are compared with",
        lambda results: tables.truth_rows(results.shown),
        keys=("case", "event"),
    ),
    "pairs": TableSource(
        "Two engines by themselves compared over the cases that both answer",
        lambda results: results.pairs,
        verdict.PAIR_COLUMNS,
    ),
}


def frames(results: Results) -> dict[str, pd.DataFrame]:
    """Every table of a report by name, those of timings only if something was timed."""
    import pandas as pd

    return {
        name: pd.DataFrame(table.rows(results), columns=table.columns)
        for name, table in TABLES.items()
        if results.costs.cases or not table.is_timed
    }
