"""What the paper says and what is so: its equations, its claim that rolling follows, its closing remark, its curves.

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
from reference.paper.lines import LINES

from ...running.records import Row

# The paper's coefficients, and those it draws.
COEFFICIENTS, FIGURED = (0.01, 0.1, 0.2), (0.01, 0.1)
# What it draws, in its order.
QUANTITIES = {
    "v": "v / (m/s)",
    "xi1": "ξ₁ / rad",
    "xi2": "ξ₂ / rad",
    "theta": "θ / rad",
    "lambda": "λ / (N/m)",
}
# Four decades of friction, evenly on a logarithmic axis: as many points as a line needs to look smooth.
MUS = np.geomspace(1e-3, 10.0, 200)


class Paper(NamedTuple):
    """The rows of the three tables, and for each coefficient of `FIGURED` its curves up to v = 0 and on, with when v
    vanishes (s) and what follows."""

    equations: list[Row]
    claims: list[Row]
    remark: list[Row]
    curves: dict[float, tuple[dict[str, np.ndarray], dict[str, np.ndarray], float, str]]


def measure() -> Paper:
    """All that the section shows."""
    drawn = {}
    for mu in FIGURED:
        stop = _motion(mu).transitions[0]
        drawn[mu] = curves(mu, stop.time), curves(mu), stop.time, str(stop.after).replace("_", " ")
    return Paper(equation_rows(), claim_rows(), remark_rows(), drawn)


def equation_rows() -> list[Row]:
    """One row for each numbered equation: what it says and where it stands in the code."""
    return [{"equation": f"({n})", "says": says, "places": ", ".join(places)} for n, says, places in LINES]


def claim_rows() -> list[Row]:
    """One row for each of the paper's coefficients: where v vanishes, what follows, and the cone's margin there.

    `needed` is the friction that rolling would take over what the cone holds; `rolls_beyond` (rad) the release from
    rest from which on the disc rolls.
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
                "needed": end.needed,
                "margin": 1.0 - end.needed,
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
    # Both sides of a jump of the force: the instants of the transitions are samples, too.
    t = np.unique([*np.linspace(0.0, end, points), *(x.time for x in motion.transitions if x.time < end)])
    state = motion(t)
    speed = cases.load("disc_in_circle", mu=mu).track.speed(np.asarray(state.xi1))
    drawn = (state.slip, state.xi1, state.xi2, state.theta, state.normal_force / speed)
    return {"t": t, **{name: np.asarray(values) for name, values in zip(QUANTITIES, drawn, strict=True)}}
