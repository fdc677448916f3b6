"""How much a case depends on friction's law: by how much the score moves with the coefficient of friction, and whether
the case measures friction at all."""

from __future__ import annotations

from collections.abc import Mapping

import reference
from cases import Case, CoulombFriction, Trajectory

from . import several_contacts
from .null_motions import with_friction
from .score import Scale

# The change of the coefficient: small enough for the score to be proportional to it, far above the truth's error.
CHANGE = 0.01
# A case depends on friction's law if 1 % more or less friction moves the score by this much.
LEAST = 1e-5
# A case measures friction if ignoring friction's law moves the plate by this share of its path at least. Below that,
# the error of an engine's step is as large: semi-implicit Euler with 60 steps per second puts a plate that accelerates
# evenly for 2 s off by h/(√3 T) = 0.5 % of its path (root mean square), without any friction.
LEAST_SHARE = 0.005


def friction_sensitivity(case: Case, truth: Trajectory, scales: Mapping[str, Scale]) -> float:
    """The larger of the scores of the motions with 1 % more and 1 % less friction; 0 without Coulomb friction.

    `scales`: of each contact by its name, "" for the only one.

    The two differ where a plate is about to slip."""
    friction = case.effect(CoulombFriction)
    if friction is None:
        return 0.0
    others = (with_friction(case, mu=part * friction.mu) for part in (1.0 + CHANGE, 1.0 - CHANGE))
    # At the truth's tolerance, for which its equations are compiled.
    motions = [reference.simulate(other, rtol=1e-13) for other in others]
    return max(several_contacts.judge(case, motion, truth, scales, truth.transitions).score.off for motion in motions)


def not_ranked(sensitivity: float, scale: Scale | None) -> str:
    """Why a case does not rank engines, in a phrase; "" for a case that does. `sensitivity`: `friction_sensitivity`."""
    if scale is None:
        return "there is no truth"
    if not sensitivity >= LEAST:
        return "does not depend on friction's law"
    return small_share(scale)


def small_share(scale: Scale) -> str:
    """A phrase if ignoring friction's law moves the plate by less than `LEAST_SHARE` of its path; else ""."""
    if scale.share >= LEAST_SHARE:
        return ""
    return f"ignoring friction's law moves the plate by {100.0 * scale.share:.1g} % of its path only"
