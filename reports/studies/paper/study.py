"""The paper, line by line: its equations in the code, its figures next to the continued motions, its claims."""

from __future__ import annotations

from typing import Any

from ...analysis.columns import Table
from ...running.calls import Calls, StorePolicy
from .. import Request
from .figure import draw as draw
from .measure import Paper, measure

TITLE = "The paper, line by line"
QUESTION = (
    "Each numbered equation and its places in the code, the paper's diagrams next to the continued motion, its claim "
    "that rolling follows with the cone's margin, and its closing remark. Its misprints are in the table errata."
)
TAKES = ()
IN_REPORT = True
TABLES = {
    "paper_equations": Table(
        "The paper's numbered equations and their places in the code",
        {"equation": "its number", "says": "its content", "places": "its places in the code"},
    ),
    "paper_claims": Table(
        "The paper's claim that rolling follows, for each of its coefficients, with the cone's margin",
        {
            "mu": "the coefficient μ₀",
            "time_unitless": "when v vanishes, in units of √((R − r)/g)",
            "time": "the same in s, with R = 1 m, r = 0.1 m",
            "xi1": "ξ₁ there, rad",
            "demand": "the friction that rolling would need, over the largest friction of the cone",
            "margin": "1 − demand",
            "after": "the mode that follows",
            "claim_holds": "whether it rolls",
            "rolls_beyond": "the disc rolls if it is released from rest beyond this ξ₁, rad",
        },
    ),
    "paper_remark": Table(
        "Where and when the slip first vanishes over the friction coefficient",
        {
            "mu": "the coefficient μ₀",
            "time": "when v vanishes, in units of √((R − r)/g)",
            "xi1": "ξ₁ there, rad",
            "demand": "the friction that rolling would need, over the largest friction of the cone",
        },
    ),
}


def run(request: Request, calls: Calls) -> Paper:
    """All findings, computed in one call."""
    (answer,) = calls.all("the paper", measure, [()], keep=StorePolicy())
    if answer.outcome != "done":
        raise RuntimeError(answer.reason)
    return answer.value


def rows(findings: Paper) -> dict[str, list[dict[str, Any]]]:
    """The three tables."""
    return {"paper_equations": findings.equations, "paper_claims": findings.claims, "paper_remark": findings.remark}
