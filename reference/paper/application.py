"""The paper's application, (35) as corrected, in dimensionless form: which parameters its claims depend on.

Take √(L/g) as the unit of time, L = R − r, and w = r θ̇/√(g L); a dash is the derivative in that time and k = J/(m r²)
(½ for the paper's disc). While v > 0, (35) then reads

    ξ₁'' = cos ξ₁ − μ₀ sin ξ₁ − μ₀ ξ₁'²,    w' = −(μ₀/k) (sin ξ₁ + ξ₁'²),    v/√(g L) = ξ₁' + w,
    N/(m g) = sin ξ₁ + ξ₁'²,    rolling would take T/(m g) = k/(1 + k) cos ξ₁.

R, r, m and g have dropped out. So the place where v vanishes, and whether the disc then rolls, depend on μ₀, the start
and k alone; the time also depends on √(L/g). The paper's claims can be judged although it gives no sizes, except for
the start.

Where v falls to zero, v' ≤ 0, so that cos ξ₁ ≤ μ₀ (1 + 1/k) (sin ξ₁ + ξ₁'²): before the bottom, ξ₁ ≤ π/2, this is the
condition for rolling. The slip can only reverse beyond the bottom.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from cases import BadValue

DISC = 0.5  # k of a homogeneous disc
# A swing lasts less than four units of time between its turning points; the slip is over within it, or never.
_LONGEST = 20.0


class SlipEnd(NamedTuple):
    """The first zero of the slip velocity: time in units of √((R − r)/g), ξ₁ in rad, and `demand`, the friction that
    rolling needs over the friction that the cone allows, |T|/(μ₀ N): the disc rolls if it is at most one."""

    time: float
    xi1: float
    demand: float


def slip_end(mu: float, release: float = 0.0, k: float = DISC) -> SlipEnd:
    """The first zero of v of a disc released at rest at ξ₁ = `release`, 0 ≤ release < π/2 (Y down), by (35).

    Raises BadValue for arguments outside these ranges, and if the disc would roll from the start,
    tan(release) ≥ 1/(μ₀ (1 + 1/k)).
    """
    if not (0.0 <= release < np.pi / 2 and mu > 0.0 and k > 0.0):
        raise BadValue(f"release is {release!r}, mu {mu!r}, k {k!r}; give 0 <= release < pi/2, and mu and k above 0")
    if not np.cos(release) > mu * (1.0 + 1.0 / k) * np.sin(release):
        raise BadValue(
            f"released at xi1 = {release:g} with mu = {mu:g} the disc does not slip forward; release it higher"
        )

    def rates(_, y):
        xi1, p, _ = y
        pressing = np.sin(xi1) + p * p
        return [p, np.cos(xi1) - mu * pressing, -mu / k * pressing]

    def slip(_, y):
        return y[1] + y[2]

    slip.terminal, slip.direction = True, -1.0  # type: ignore[attr-defined]
    # A double has no digits left for a tolerance below 1e-12; the first zero is then accurate to 1e-11.
    run = solve_ivp(rates, (0.0, _LONGEST), [release, 0.0, 0.0], method="DOP853", rtol=1e-12, atol=1e-14, events=slip)
    (time,), ((xi1, p, _),) = run.t_events[0], run.y_events[0]
    demand = k / (1.0 + k) * abs(np.cos(xi1)) / (mu * (np.sin(xi1) + p * p))
    return SlipEnd(float(time), float(xi1), float(demand))


def rolls_beyond(mu: float, k: float = DISC) -> float:
    """The least ξ₁ (rad) from which a disc released at rest rolls when its slip ends; 0 if it does from 0."""
    if slip_end(mu, 0.0, k).demand <= 1.0:
        return 0.0
    # With μ₀ (1 + 1/k) tan ξ₁ ≥ 1 it rolls from the start; slightly below that it slips a little and then rolls.
    high = float(np.arctan(1.0 / (1.5 * mu * (1.0 + 1.0 / k))))
    return float(brentq(lambda release: slip_end(mu, release, k).demand - 1.0, 0.0, high, xtol=1e-12))
