"""Where rigid Coulomb contact has no motion, one or several: a rod that slides on a floor, and on a floor and a wall.

The rod is that of `ladder_at_wall`: thin, homogeneous, of length 2 h, at the angle θ to the floor, turning towards it
with ω; Ω = ω² h/g. With s = sin θ, c = cos θ and forces per weight, its accelerations with both ends in contact are
linear in N_A (floor) and N_B (wall); eliminating them gives the boundaries below.

The floor alone is Painlevé's problem; its bounds are those of `painleve_rod`. (That with a floor alone either no motion
or several follow beyond it is known from Hogan & Kristiansen, Proc. R. Soc. A 473, 2017, doi 10.1098/rspa.2016.0773,
abstract looked up. The boundaries are derived here.)
"""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, pi, sin, sqrt
from typing import Any, NamedTuple

import numpy as np

import cases
from reference.solver.decide import motions_in
from reports.running.calls import Calls, StorePolicy
from reports.studies import Request

FLOOR, BOTH = "floor", "floor and wall"
# Ω of the panels: the floor alone lifts a rod of Ω > 1 at some angles.
SPINS = (0.5, 1.5, 3.0)
# Middles of cells, so that no state lies on a boundary to rounding. Coefficients at both ends are the same.
MUS = (np.arange(24) + 0.5) * 0.125
ANGLES = (np.arange(30) + 0.5) * (0.5 * pi / 30)
# With the floor alone the rod is this far from the wall, in m.
AWAY = 1.0


def painleve_mu(theta: np.ndarray, spin: float = 0.0) -> np.ndarray:
    """μ above which the floor's normal force pulls the sliding end in: 1 + 3 c² = 3 μ s c, least 4/3 at tan θ = 2."""
    s, c = np.sin(theta), np.cos(theta)
    return np.asarray((1.0 + 3.0 * c * c) / (3.0 * s * c))


def locking_mu(theta: np.ndarray, spin: float = 0.0) -> np.ndarray:
    """μ = √2 at every angle: the inertia (1 + μ²)/3 + 1 − μ² of a rod that slides at both ends is 0."""
    return np.full_like(theta, sqrt(2.0))


def wall_mu(theta: np.ndarray, spin: float) -> np.ndarray:
    """μ at which the wall's normal force is 0 while both ends slide: c (4 Ω − 3 s) = μ (1 − 3 s² + 2 Ω s)."""
    s, c = np.sin(theta), np.cos(theta)
    mu = c * (4.0 * spin - 3.0 * s) / (1.0 - 3.0 * s * s + 2.0 * spin * s)
    return np.where(mu > 0.0, mu, np.nan)


class StateRow(NamedTuple):
    """One state of the map: its scene, Ω, coefficient of friction, angle (rad), and the ends in contact per motion."""

    scene: str
    spin: float
    mu: float
    theta: float
    motions: tuple[str, ...]


def sliding_rod(scene: str, spin: float, theta: float) -> list[float]:
    """x, y, θ, vx, vy, ω of the rod of `ladder_at_wall` that slides with its lower end away from the wall."""
    half, g = 1.0, 9.81
    omega, s, c = sqrt(spin * g / half), sin(theta), cos(theta)
    x = half * c + (AWAY if scene == FLOOR else 0.0)
    return [x, half * s, pi - theta, half * omega * s, -half * omega * c, omega]


def count(scene: str, spin: float, mus: Sequence[float], angles: Sequence[float]) -> list[StateRow]:
    """The consistent motions of all those states."""
    results = []
    for mu in mus:
        case = cases.load("ladder_at_wall", mu=mu, mu_wall=mu)
        for theta in angles:
            motions = motions_in(case, sliding_rod(scene, spin, theta))
            results.append(StateRow(scene, spin, mu, theta, tuple(sorted(map(_ends, motions)))))
    return results


def _ends(modes: dict[str, cases.Mode]) -> str:
    """Which ends stay in contact."""
    names = {"plate/track": "floor", "plate/wall": "wall"}
    closed = [names[contact] for contact, mode in modes.items() if mode is not cases.Mode.FLIGHT]
    return " and ".join(closed) or "none"


def run(request: Request, calls: Calls) -> list[StateRow]:
    """The states of all panels, computed in one call for each."""
    panels = [(scene, spin, MUS.tolist(), ANGLES.tolist()) for scene in (FLOOR, BOTH) for spin in SPINS]
    answers = calls.all("map of uniqueness", count, panels, keep=StorePolicy())
    for answer in answers:
        if answer.outcome != "done":
            raise RuntimeError(answer.reason)
    return [row for answer in answers for row in answer.value]


def rows(findings: list[StateRow]) -> dict[str, list[dict[str, Any]]]:
    """For each panel and set of motions: number of states, and the range of friction."""
    panels: dict[tuple[str, float], list[StateRow]] = {}
    for row in findings:
        panels.setdefault((row.scene, row.spin), []).append(row)
    table = []
    for (scene, spin), states in panels.items():
        for motions in sorted({row.motions for row in states}, key=lambda motions: (len(motions), motions)):
            mus = [row.mu for row in states if row.motions == motions]
            table.append(
                {
                    "scene": scene, "spin": spin, "motions": len(motions), "modes": "; ".join(motions),
                    "states": len(mus), "share": len(mus) / len(states),
                    "least_mu": min(mus), "greatest_mu": max(mus),
                }
            )  # fmt: skip
    return {"uniqueness": table}
