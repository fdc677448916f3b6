"""The atlas of hard scenes: who gets through, who breaks, and at which step."""

from __future__ import annotations

from collections import Counter
from math import isfinite
from typing import Any

from adapters import Setting

from ...analysis.columns import Table
from ...running.calls import Calls
from ...running.records import REFERENCE, TRUTH_RTOL
from .. import Request
from . import measure
from .figure import draw as draw
from .measure import Stability

TITLE = "Hard scenes"
QUESTION = (
    "Scenes that break solvers, and what each does there. One variant of each family; a full report has all. Chaotic: "
    "one unit in the last place of the inputs decides, so nobody is ranked."
)
TAKES = ("case", "solver")
IN_REPORT = True
TABLES = {
    "stability": Table(
        "Hard scenes, solver by solver: outcome, residuals, conditioning",
        {
            "case": "the scene",
            "solver": "who solves it",
            "route": "by which route, or method of the reference",
            "setting": "the rung",
            "outcome": "right, wrong, refused, crashed, timed_out, or chaotic: the last bit of the inputs decides",
            "reason": "why it is not right",
            "first_transition_error": "error of the first transition's time, s",
            "centre_error": "largest distance of the centre from the truth over its path",
            "energy": "largest residual of the energy's balance over the energy that moves",
            "energy_drift": "its slope, 1/s",
            "gap": "largest distance of the two contact points (5) over the plate's size",
            "gap_drift": "its slope, m/s",
            "tangency": "largest sine between the tangents at the contact point (6)",
            "condition": "largest condition number of the matrix of (27), in the plate's own units; empty: singular",
            "condition_si": "the same as it stands, in SI units",
            "condition_time": "when the former is met, s",
            "spread": "what one unit in the last place of the inputs does to the centre over its path; or `last_bit`",
            "spread_time": "and to the time of a transition, s",
            "last_bit": "what that unit makes of the sequence of modes; empty: it stays",
            "witnesses": "how many ways of solving the truth rests on",
        },
    ),
    "unstable_steps": Table(
        "The step at which each engine turns unstable, by bisection",
        {
            "case": "the scene",
            "solver": "the engine",
            "route": "its route",
            "setting": "all knobs but the step, as a middle rung has them",
            "works": "largest step known to work, s",
            "fails": "smallest step known to blow up, s",
            "steps_at_failure": "the duration over the latter",
            "how": "how it blows up, or why there is no such step",
        },
    ),
}
_OUTCOMES = ("right", "wrong", "chaotic", "refused", "crashed", "timed_out")


def run(request: Request, calls: Calls) -> Stability:
    """The named cases, or the atlas."""
    return measure.measure(request.cases or measure.atlas(request.full), request.solvers, request.full, calls)


def rows(found: Stability) -> dict[str, list[dict[str, Any]]]:
    """Both tables; none if nothing was run."""
    if not found.cases:
        return {}
    return {"stability": measure.rows(found), "unstable_steps": [b._asdict() for b in found.unstable]}


def summary(found: Stability) -> str:
    """Outcomes by route, and the reference's worst residuals at its finest, for the terminal."""
    from tabulate import tabulate

    counts: dict[tuple[str, str], Counter] = {}
    told = measure.rows(found)
    for row in told:
        counts.setdefault((row["solver"], row["route"]), Counter())[row["outcome"]] += 1
    table = [[*who, *(count[outcome] for outcome in _OUTCOMES)] for who, count in counts.items()]
    lines = [tabulate(table, ["solver", "route", *_OUTCOMES])]
    finest = [r for r in told if r["solver"] == REFERENCE and r["setting"] == Setting.of(rtol=TRUTH_RTOL)]
    for name in ("energy", "gap", "tangency", "condition"):
        known = [row for row in finest if isfinite(row[name])]
        if known:
            worst = max(known, key=lambda row: row[name])
            lines.append(f"reference at rtol={TRUTH_RTOL:g}, largest {name}: {worst[name]:.1e} ({worst['case']})")
    return "\n".join(lines)
