"""The paper, line by line: its equations in the code, its claims, its remark and its misprints as rows.

Its sizes and its start are not in its text; ours are those of `disc_in_circle`. What it claims depends on neither R, r,
m nor g (`reference.paper.application`).
"""

from __future__ import annotations

from typing import Any

import numpy as np

import cases
import reference
from cases import Mode, Trajectory
from reference.errata import errata
from reference.paper.application import rolls_beyond, slip_end
from reference.paper.equation_list import LINES
from reports.running.calls import Calls
from reports.running.records import Row
from reports.studies import Request

# The paper's coefficients, and those of its figures, which end where v vanishes.
COEFFICIENTS, FIGURE_COEFFICIENTS = (0.01, 0.1, 0.2), (0.01, 0.1)
# Four decades of friction.
MUS = np.geomspace(1e-3, 10.0, 200)


def equation_rows() -> list[Row]:
    """One row for each numbered equation: its content and its places in the code."""
    return [{"equation": f"({n})", "says": says, "places": ", ".join(places)} for n, says, places in LINES]


def claim_rows() -> list[Row]:
    """One row for each of the paper's coefficients: where v vanishes, what follows, and the cone's margin there.

    `demand`: the friction that rolling would need over the largest friction of the cone; `rolls_beyond` (rad): the disc
    rolls if it is released from rest beyond this ξ₁.
    """
    rows: list[Row] = []
    for mu in COEFFICIENTS:
        end, first = slip_end(mu), _motion(mu).transitions[0]
        rows.append(
            {
                "mu": mu,
                "time_unitless": end.time,
                "time": first.time,
                "xi1": first.xi1,
                "demand": end.demand,
                "margin": 1.0 - end.demand,
                "after": str(first.after),
                "claim_holds": first.after is Mode.ROLL,
                "rolls_beyond": rolls_beyond(mu),
            }
        )
    return rows


def remark_rows() -> list[Row]:
    """The closing remark: where and when v vanishes (in units of √((R − r)/g)), one row for each of `MUS`."""
    return [{"mu": float(mu), **slip_end(float(mu))._asdict()} for mu in MUS]


def _motion(mu: float) -> Trajectory:
    return reference.simulate(cases.load("disc_in_circle", mu=mu), rtol=1e-12)


def run(request: Request, calls: Calls) -> dict[str, list[dict[str, Any]]]:
    """The four tables."""
    misprints = [erratum._asdict() for erratum in errata()]
    return {"equations": equation_rows(), "claims": claim_rows(), "remark": remark_rows(), "errata": misprints}
