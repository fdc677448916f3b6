"""Boundaries with exact formulas, drawn over the maps."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from reference.paper.application import rolls_beyond, slip_end
from reference.sweeping import Plan


class BoundaryLine(NamedTuple):
    """A boundary in the plane of two parameters, and its name."""

    x: np.ndarray
    y: np.ndarray
    label: str


# Points of a boundary; each takes a root search.
POINTS = 60


def exact_boundaries(plan: Plan, x: str, y: str) -> list[BoundaryLine]:
    """The exact boundaries in the plane of parameters x and y; an empty list if there are none."""
    lines = _circle(plan) if plan.name == "disc_in_circle" and {x, y} == {"mu", "xi1"} else []
    return lines if x == "mu" else [BoundaryLine(line.y, line.x, line.label) for line in lines]


def _circle(plan: Plan) -> list[BoundaryLine]:
    """Boundaries of the paper's application by (35): rolling from the start, rolling or reversal at the first v = 0."""
    axis = next(axis for axis in plan.axes if axis.name == "mu")
    low, high = (axis.low, axis.high) if not axis.values else (min(axis.values), max(axis.values))
    mu = np.linspace(max(low, 1e-3), high, POINTS)
    # Released at ξ₁ = 0, the disc rolls if μ is larger than `most`: there the second line ends.
    most = brentq(lambda m: slip_end(m).demand - 1.0, 0.05, 0.5, xtol=1e-9)
    mu = np.unique(np.append(mu, most * (1.0 - 1e-9))) if low < most < high else mu
    after = np.array([rolls_beyond(float(m)) for m in mu])
    there = after > 0.0
    return [
        BoundaryLine(mu, np.arctan(1.0 / (3.0 * mu)), "rolls from the start above: tan ξ₁ = 1/(3 μ)"),
        BoundaryLine(mu[there], after[there], "rolls after the first v = 0 above, by (35)"),
    ]
