"""The paper, line by line: its equations in the code, its figures beside motions that go on, its claims."""

from __future__ import annotations

from typing import Any

from ...analysis.columns import Table
from ...running.calls import Calls, Keep
from .. import Request
from .figure import draw as draw
from .measure import Paper, measure

TITLE = "The paper, line by line"
QUESTION = (
    "Each numbered equation and where it stands in the code, the paper's diagrams beside the motion that goes on, its "
    "claim that rolling follows with the cone's margin, and its closing remark. Its misprints are in the table errata."
)
TAKES = ()
IN_REPORT = True
TABLES = {
    "paper_equations": Table(
        "The paper's numbered equations and where each stands in the code",
        {"equation": "its number", "says": "what it says", "places": "where it stands in the code"},
    ),
    "paper_claims": Table(
        "The paper's claim that rolling follows, for each of its coefficients, with the cone's margin",
        {
            "mu": "the coefficient μ₀",
            "time_unitless": "when v vanishes, in units of √((R − r)/g)",
            "time": "the same in s, with R = 1 m, r = 0.1 m",
            "xi1": "ξ₁ there, rad",
            "needed": "the friction that rolling would take, over what the cone holds",
            "margin": "one less that",
            "after": "what follows",
            "claim_holds": "whether it rolls",
            "rolls_beyond": "from which release from rest on it rolls, rad",
        },
    ),
    "paper_remark": Table(
        "Where and when the slip first vanishes over the friction coefficient",
        {
            "mu": "the coefficient μ₀",
            "time": "when v vanishes, in units of √((R − r)/g)",
            "xi1": "ξ₁ there, rad",
            "needed": "the friction that rolling would take, over what the cone holds",
        },
    ),
}


def run(request: Request, calls: Calls) -> Paper:
    """All of it, in one call."""
    (answer,) = calls.all("the paper", measure, [()], keep=Keep())
    if answer.outcome != "done":
        raise RuntimeError(answer.reason)
    return answer.value


def rows(found: Paper) -> dict[str, list[dict[str, Any]]]:
    """The three tables."""
    return {"paper_equations": found.equations, "paper_claims": found.claims, "paper_remark": found.remark}
