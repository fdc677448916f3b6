"""How much a case depends on friction's law: by how much the score moves with the coefficient of friction."""

from __future__ import annotations

import reference
from cases import Case, CoulombFriction, Trajectory

from .null_motions import with_friction
from .score import Scale, score

# The change of the coefficient: small enough for the score to be proportional to it, far above the truth's error.
CHANGE = 0.01
# A case depends on friction's law if 1 % more or less friction moves the score by this much.
LEAST = 1e-5


def friction_sensitivity(case: Case, truth: Trajectory, scale: Scale) -> float:
    """The larger of the scores of the motions with 1 % more and 1 % less friction; 0 without Coulomb friction.

    The two differ where a plate is about to slip."""
    friction = case.effect(CoulombFriction)
    if friction is None:
        return 0.0
    others = (with_friction(case, mu=part * friction.mu) for part in (1.0 + CHANGE, 1.0 - CHANGE))
    return max(score(case, reference.simulate(other, rtol=1e-12), truth, scale).off for other in others)
