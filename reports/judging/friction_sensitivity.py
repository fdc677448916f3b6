"""How much a case depends on friction's law: by how much the score moves with the coefficient of friction."""

from __future__ import annotations

import reference
from cases import Case, CoulombFriction, Trajectory

from .null_motions import with_friction
from .score import Scale, score

# The change of the coefficient: small enough for the score to be proportional to it, large beside the truth's error.
CHANGE = 0.01
# A case depends on friction's law if 1 % more friction moves the score by this much.
LEAST = 1e-5


def friction_sensitivity(case: Case, truth: Trajectory, scale: Scale) -> float:
    """The score of the motion with 1 % more friction; 0 where the case has no Coulomb friction."""
    friction = case.effect(CoulombFriction)
    if friction is None:
        return 0.0
    more = reference.simulate(with_friction(case, mu=(1.0 + CHANGE) * friction.mu), rtol=1e-12)
    return score(case, more, truth, scale).off
