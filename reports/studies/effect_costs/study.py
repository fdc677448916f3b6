"""What each effect costs, and what would be wrong without it: one scene, its effects added one at a time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ...analysis.columns import Table
from ...running.calls import Calls
from .. import Request
from . import measure
from .figure import draw as draw

TITLE = "What each effect costs"
QUESTION = "One scene with its effects added one at a time: what each costs, and how wrong the answer is without it."
TAKES = ("solver",)
IN_REPORT = True
TABLES = {
    "effect_costs": Table(
        "What each effect costs, and what would be wrong without it",
        {
            "scene": "which scene, and in which order its effects are added",
            "effect": "the effect that this stage adds to the stage before",
            "effects": "all effects of the stage",
            "solver": "who solves it",
            "route": "by which route, or method of the reference",
            "setting": "one rung: the reference at 1e-9, engines in the middle of their ladders",
            "outcome": "done, wrong (a motion that is not finite), refused, crashed or timed_out",
            "reason": "why it is not done",
            "cpu_s": "CPU time of the run alone, s: the median of the undisturbed repeats",
            "cpu_low_s": "where the median of another process is expected to begin, s",
            "cpu_high_s": "where it is expected to end, s",
            "cpu_to_first": "CPU time over that of the first stage",
            "repeats": "how many repeats the median is of",
            "disturbed": "whether the machine had other things to do",
            "evaluations": "evaluations of the right-hand side, where the solver counts them",
            "operations": "operations of the largest compiled mode of contact (the reference)",
            "events": "events watched in the mode that watches most (the reference)",
            "transitions": "transitions that the solver located itself",
            "status": "how the motion ended",
            "end_s": "when it ended, s",
            "change_m": "how far the centre is from where it was without the effect, m, at most",
        },
    )
}
# What the terminal shows of it.
_SHOWN = ("scene", "effect", "solver", "route", "outcome", "cpu_s", "cpu_to_first", "operations", "events", "change_m")


def run(request: Request, calls: Calls) -> list[dict[str, Any]]:
    """The rows of all scenes."""
    return measure.measure(request.solvers, measure.FULL_BUDGET if request.full else measure.BUDGET, calls)


def rows(found: list[dict[str, Any]]) -> dict[str, list[dict[str, Any]]]:
    """The price list."""
    return {"effect_costs": found}


def summary(found: Sequence[dict[str, Any]]) -> str:
    """The columns that fit on a screen."""
    from tabulate import tabulate

    return tabulate([[row[name] for name in _SHOWN] for row in found], _SHOWN, floatfmt=".3g")
