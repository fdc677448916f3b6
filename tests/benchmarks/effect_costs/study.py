"""The cost of each effect and the error without it: one scene with its effects added one at a time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from reports.analysis.columns import Table
from reports.running.calls import Calls
from reports.studies import Request

from . import measure
from .figure import draw as draw

TITLE = "What each effect costs"
QUESTION = "One scene with its effects added one at a time: the cost of each, and the error of the motion without it."
TAKES = ("solver",)

TABLES = {
    "effect_costs": Table(
        "The cost of each effect, and the error of the motion without it",
        {
            "scene": "the scene, which also determines the order of its effects",
            "effect": "the effect that this stage adds to the stage before",
            "effects": "all effects of the stage",
            "solver": "the solver",
            "route": "its route, or method of the reference",
            "setting": "one rung: the reference at 1e-9, engines in the middle of their ladders",
            "outcome": "done, unsupported, crashed (also a motion that is not finite) or timed_out",
            "reason": "the reason of any other outcome than done",
            "cpu_s": "CPU time of the run alone, s: the median of the undisturbed repeats",
            "cpu_low_s": "lower end of the interval expected for the median of another process, s",
            "cpu_high_s": "its upper end, s",
            "cpu_to_first": "CPU time over that of the first stage",
            "repeats": "number of repeats behind the median",
            "disturbed": "whether the timing was disturbed by other load",
            "evaluations": "evaluations of the right-hand side, if the solver counts them",
            "operations": "operations of the largest compiled mode of contact (the reference)",
            "events": "largest number of events monitored in a mode (the reference)",
            "transitions": "transitions that the solver located itself",
            "status": "how the motion ended",
            "end_s": "when it ended, s",
            "change_m": "largest distance of the centre from the motion without the effect, m",
        },
    )
}
# Columns shown in the terminal.
_TERMINAL_COLUMNS = (
    "scene",
    "effect",
    "solver",
    "route",
    "outcome",
    "cpu_s",
    "cpu_to_first",
    "operations",
    "events",
    "change_m",
)


def run(request: Request, calls: Calls) -> list[dict[str, Any]]:
    """The rows of all scenes."""
    return measure.measure(request.solvers, measure.FULL_BUDGET if request.full else measure.BUDGET, calls)


def rows(findings: list[dict[str, Any]]) -> dict[str, list[dict[str, Any]]]:
    """The table of costs."""
    return {"effect_costs": findings}


def summary(findings: Sequence[dict[str, Any]]) -> str:
    """The columns that fit on a screen."""
    from tabulate import tabulate

    return tabulate([[row[name] for name in _TERMINAL_COLUMNS] for row in findings], _TERMINAL_COLUMNS, floatfmt=".3g")
