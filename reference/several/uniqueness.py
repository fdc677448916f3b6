"""How many motions rigid Coulomb contact allows in a state: none, one or several, by the enumeration of modes."""

from __future__ import annotations

from collections.abc import Sequence

from cases import Case, Mode
from cases.contact_pairs import contact_name, pairs_in_pose

from .decision import DecisionInstant, consistent_motions
from .geometry import TOUCHES, places
from .regimes import join

# Relative error of a state that is given by formulas: a few roundings of its numbers.
ERROR = 1e-14


def motions_in(case: Case, body: Sequence[float]) -> list[dict[str, Mode]]:
    """The motions that may follow a state of a plate with supports, each as the modes of the contacts that touch.

    `body`: x, y (m), θ, vx, vy (m/s), ω. Modes that give the same accelerations are one motion, listed with the most
    contacts. No contact may close: an impact is no motion. Raises Undecidable, and DoesNotFit for points not found.
    """
    every = [one for one in pairs_in_pose(case, *body[:3]) if not one.is_away]
    at = places([one.pair for one in every], body, [one.points for one in every])
    size = TOUCHES * (abs(body[0]) + abs(body[1]) + case.plate.reach)
    touching = [one for one in at if abs(one.gap) <= size]
    names = tuple(contact_name(one.contact.support, 1) for one in touching)
    speed = max(abs(body[3]), abs(body[4]), abs(body[5]) * case.plate.gyration)
    state = join(body, [(one.xi1, one.xi2) for one in touching])
    count = len(names)
    now = DecisionInstant(0.0, state, touching, names, (0.0,) * count, tuple(range(count)), speed, (False,) * count)
    motions = consistent_motions(case, now, ERROR)
    most = [max(regimes, key=lambda regime: len(regime.closed)) for regimes in motions]
    return [dict(zip(names, regime.modes, strict=True)) for regime in most]
