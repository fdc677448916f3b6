"""The atlas of hard scenes: outcomes of the solvers, and the steps at which engines become unstable."""

from __future__ import annotations

from collections import Counter
from math import isfinite
from typing import Any

from adapters import Setting

from ...analysis.columns import Table, words
from ...judging.grades import Grade
from ...running.calls import Calls
from ...running.names import REFERENCE
from ...running.records import TRUTH_RTOL
from .. import Request
from . import measure
from .figure import draw as draw
from .measure import Stability

TITLE = "Hard scenes"
QUESTION = (
    "Scenes that are hard for solvers, and the outcome of each. One variant of each family; a full report has all. "
    "Chaotic: one unit in the last place of the inputs decides the outcome, so solvers are not ranked."
)
TAKES = ("case", "solver")
IN_REPORT = True
TABLES = {
    "stability": Table(
        "Hard scenes, solver by solver: outcome, residuals, conditioning",
        words("case", "solver", "route", "setting")
        | words(outcome="answered, unsupported, crashed, timed_out, or chaotic: the last bit of the inputs decides")
        | words("grade", "off", "off_doubt", "reason")
        | words(
            first_transition_error="error of the first transition's time, s",
            centre_error="largest distance of the centre from the truth over its path",
            energy="largest residual of the energy balance over the energy of the motion",
            energy_drift="its slope, 1/s",
            gap="largest distance of the two contact points (5) over the plate's size",
            gap_drift="its slope, m/s",
            tangency="largest sine between the tangents at the contact point (6)",
            condition="largest condition number of the matrix of (27), in the plate's own units; empty: singular",
            condition_si="the same in SI units",
            condition_time="time of `condition`, s",
            spread="change of the centre over its path by one unit in the last place of the inputs; or `last_bit`",
            spread_time="change of the time of a transition by that unit, s",
            last_bit="change of the sequence of modes by that unit; empty: none",
            witnesses="number of independent solutions behind the truth",
        ),
    ),
    "unstable_steps": Table(
        "The step at which each engine becomes unstable, by bisection",
        words("case", "solver", "route")
        | words(
            setting="all parameters except the step, from a middle rung",
            works="largest step that works, s",
            fails="smallest unstable step, s",
            steps_at_failure="the duration over the latter",
            how="how it fails, or why there is no such step",
        ),
    ),
}
# Words of the chart and of the summary: the grades of answers, and the other outcomes.
WORDS = (*map(str, Grade), "chaotic", "unsupported", "crashed", "timed_out")


def run(request: Request, calls: Calls) -> Stability:
    """Measure the requested cases, or the atlas."""
    return measure.measure(request.cases or measure.atlas(request.full), request.solvers, request.full, calls)


def rows(stability: Stability) -> dict[str, list[dict[str, Any]]]:
    """Both tables; no table if nothing was run."""
    if not stability.cases:
        return {}
    return {"stability": measure.rows(stability), "unstable_steps": [b._asdict() for b in stability.unstable]}


def summary(stability: Stability) -> str:
    """Grades and outcomes by route, and the reference's largest residuals at its finest setting, for the terminal."""
    from tabulate import tabulate

    counts: dict[tuple[str, str], Counter] = {}
    table_rows = measure.rows(stability)
    for row in table_rows:
        counts.setdefault((row["solver"], row["route"]), Counter())[row["grade"] or row["outcome"]] += 1
    table = [[*key, count.total(), *(count[word] for word in WORDS)] for key, count in counts.items()]
    lines = [tabulate(table, ["solver", "route", "runs", *WORDS])]
    finest = [r for r in table_rows if r["solver"] == REFERENCE and r["setting"] == Setting.of(rtol=TRUTH_RTOL)]
    for name in ("energy", "gap", "tangency", "condition"):
        finite_rows = [row for row in finest if isfinite(row[name])]
        if finite_rows:
            worst = max(finite_rows, key=lambda row: row[name])
            lines.append(f"reference at rtol={TRUTH_RTOL:g}, largest {name}: {worst[name]:.1e} ({worst['case']})")
    return "\n".join(lines)
