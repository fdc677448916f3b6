"""The impact of one group of contacts of several plates."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cases import Case

from ..effect_laws.restitution import impact_law
from ..minimal.impact import ContactVelocity, collide, law_of
from ..scales import power_of_two
from .impact import ImpactVelocities, Inertia, impact_of_all
from .places import ContactPlace, couple_of
from .plate_numbers import bodies


def strike(case: Case, t: float, velocity: np.ndarray, part: Sequence[ContactPlace], speed: float) -> ImpactVelocities:
    """The velocities (3n,) after an impact at time t (s) at all contacts of a group: by Routh's construction where one
    plate touches what is fixed in one place, else by the law for whole impulses. Raises NoImpact."""
    some = bodies(case)
    if len(part) == 1 and couple_of(part[0].pair).base is None:
        return _at_one_contact(t, velocity, part[0])
    belts, arms = (np.array(each) for each in zip(*((at.belt(t), at.resisting_arm) for at in part), strict=True))
    mu = [at.mu_of(velocity, t) for at in part]
    # Impulses in units of the lightest plate's mass are velocities, and have their rounding.
    inverse = some.inverse / power_of_two(float(some.inverse.reshape(-1, 3)[:, 0].max()))
    return impact_of_all(impact_law(case), Inertia(inverse, some.lengths), velocity, list(part), mu, speed, belts, arms)


def _at_one_contact(t: float, velocity: np.ndarray, at: ContactPlace) -> ImpactVelocities:
    body = couple_of(at.pair).body
    own = slice(3 * body, 3 * body + 3)
    (tx, ty), ht, hn = at.tangent, float(at.lift_row[own][2]), -float(at.slip_row[own][2])
    before = ContactVelocity(at.slip(velocity, t), float(at.lift_row @ velocity), float(velocity[own][2]))
    slip, lift, omega = collide(law_of(at.pair, ht, hn, before.slip), before)
    # The centre of mass follows from the contact's point, at the arm h.
    along, across = slip + at.belt(t) + omega * hn, lift - omega * ht
    after = velocity.copy()
    after[own] = along * tx - across * ty, along * ty + across * tx, omega
    still = (at.sides,) if omega == 0.0 and at.resisting_arm else ()
    return ImpactVelocities(after, np.array([lift]), np.array([slip]), still)
