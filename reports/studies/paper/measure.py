"""The paper compared with computed motions: its equations, its claim that rolling follows, its remark, its curves.

The paper's figures end where v vanishes. Its sizes and its start are not in its text; ours are those of
`disc_in_circle`. What it claims depends on neither R, r, m nor g (`reference.paper.application`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

import cases
import reference
from cases import Mode, Trajectory
from reference.paper.application import rolls_beyond, slip_end
from reference.paper.equation_list import LINES

from ...running.records import Row

# The paper's coefficients, and those of its figures.
COEFFICIENTS, FIGURE_COEFFICIENTS = (0.01, 0.1, 0.2), (0.01, 0.1)
# The quantities of its figures, in its order.
QUANTITIES = {
    "v": "v / (m/s)",
    "xi1": "ξ₁ / rad",
    "xi2": "ξ₂ / rad",
    "theta": "θ / rad",
    "lambda": "λ / (N/m)",
}
# Four decades of friction, evenly spaced on a logarithmic axis: enough points for a smooth line.
MUS = np.geomspace(1e-3, 10.0, 200)


class Paper(NamedTuple):
    """The rows of the three tables, and for each coefficient of `FIGURED` the curves up to v = 0, the complete curves,
    the time of v = 0 (s) and the mode that follows."""

    equations: list[Row]
    claims: list[Row]
    remark: list[Row]
    curves: dict[float, tuple[dict[str, np.ndarray], dict[str, np.ndarray], float, str]]


def measure() -> Paper:
    """All findings of the study."""
    by_coefficient = {}
    for mu in FIGURE_COEFFICIENTS:
        stop = _motion(mu).transitions[0]
        by_coefficient[mu] = curves(mu, stop.time), curves(mu), stop.time, str(stop.after).replace("_", " ")
    return Paper(equation_rows(), claim_rows(), remark_rows(), by_coefficient)


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


def curves(mu: float, until: float | None = None, points: int = 300) -> dict[str, np.ndarray]:
    """The paper's five quantities and `t` (s) for one coefficient, to the end of the motion or `until`.

    λ = N/‖R_p‖ of (31), in N per unit of the track's parameter.
    """
    motion = _motion(mu)
    end = motion.t[-1] if until is None else until
    # The transitions are also samples, so that both sides of a jump of the force are included.
    t = np.unique([*np.linspace(0.0, end, points), *(x.time for x in motion.transitions if x.time < end)])
    state = motion(t)
    speed = cases.load("disc_in_circle", mu=mu).track.speed(np.asarray(state.xi1))
    quantities = (state.slip, state.xi1, state.xi2, state.theta, state.normal_force / speed)
    return {"t": t, **{name: np.asarray(values) for name, values in zip(QUANTITIES, quantities, strict=True)}}
