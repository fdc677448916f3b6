"""Supports: fixed curves that a plate may touch in addition to its track, each with its own friction and restitution.

A plate with pieces (a rod, a block) touches straight supports with its corners and round pieces only. The nearest
points of each such pair are unique in every pose, so that a solver can watch all of them for the whole motion.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..contact.close_pairs import nearest_on
from ..contact.geometry import bends
from ..curves import Curve
from ..curves.line_or_circle import as_line
from ..effects import CoulombFriction, Effect, Impact, RollingResistance
from ..errors import BadValue, DoesNotFit, items
from ..moving_surface import Belt
from .contact_names import TRACK, check_word
from .pair_effects import RESISTING, of_pair, own_effects_of, with_own

# A plate is behind a curve if the normal of the sample next to it points away from it by at least this (a cosine).
BEHIND = 0.1
# Effects that a support may have of its own.
OWN = (*RESISTING, Impact, Belt)


@dataclass(frozen=True)
class Support:
    """A fixed curve that the plate may touch in addition to its track: a wall, the other side of a groove, a step.

    The plate lies on its left. `name` names its contacts: "plate/wall". `effects`: friction, rolling resistance and
    impact of these contacts instead of the case's: CoulombFriction or PerfectlyRough (neither: no friction),
    RollingResistance (not given: none), and Impact (not given: the case's). With effects=None they are as on the track.
    A Belt there is the support's own: that of the case is the track's alone. A Drive of the case moves the track with
    all supports. Raises BadValue.
    """

    curve: Curve
    name: str
    effects: tuple[Effect, ...] | None = None

    def __post_init__(self):
        if not isinstance(self.curve, Curve):
            raise BadValue(f"the curve of a Support is {self.curve!r}; give a Curve, such as library.line(pi/2)")
        check_word("Support", self.name, "wall", TRACK)
        if self.effects is not None:
            object.__setattr__(self, "effects", own_effects_of("Support", self.effects, OWN))

    def acting(self, of_case: tuple[Effect, ...]) -> tuple[Effect, ...]:
        """All effects at this support's contacts, given those of the case."""
        return _without_belt(of_case) if self.effects is None else with_own(of_case, self.effects, Belt)


def _without_belt(effects: tuple[Effect, ...]) -> tuple[Effect, ...]:
    return tuple(effect for effect in items("effects", effects) if not isinstance(effect, Belt))


def base_of(contact: str) -> str:
    """What a contact lies on, the name of a support, of the track or of another plate: "wall" of "plate/wall 2"."""
    return contact.partition("/")[2].partition(" ")[0]


def effects_at(case: Any, contact: str) -> tuple[Effect, ...]:
    """All effects at a contact, such as "plate/wall 2": those of the case, and those of its pair, or its support's own,
    in their places. The case's Belt is the track's alone."""
    base = base_of(contact)
    own = next((support.acting(case.effects) for support in case.supports if support.name == base), None)
    otherwise = case.effects if base == TRACK else _without_belt(case.effects) if own is None else own
    return of_pair(case, contact.partition(" ")[0], otherwise)


def has_belt(case: Any) -> bool:
    """Whether the surface of the track or of a support runs."""
    return any(isinstance(effect, Belt) for effect in _all_effects(case))


def has_rolling_resistance(case: Any) -> bool:
    """Whether the track or a support resists rolling."""
    return any(isinstance(effect, RollingResistance) for effect in _all_effects(case))


def has_slip_law(case: Any) -> bool:
    """Whether the friction of the track or of a support depends on the slip speed."""
    return any(isinstance(effect, CoulombFriction) and effect.by_speed for effect in _all_effects(case))


def _all_effects(case: Any) -> tuple[Effect, ...]:
    """The effects of a case, of its supports and of its pairs."""
    parts = (*case.supports, *case.pairs)
    return (*case.effects, *(effect for part in parts for effect in part.effects or ()))


def is_straight(curve: Curve) -> bool:
    """Whether a support is a straight line without ends."""
    return curve.domain is None and as_line(curve) is not None


def is_hollow(curve: Curve) -> bool:
    """Whether a smooth support bends to its left everywhere, where the plate is: of an outline it touches corners and
    round pieces only. A line has no bend."""
    return bends(curve)[0] > 0.0


def is_hill(curve: Curve) -> bool:
    """Whether a smooth support is closed and bends to its right everywhere, away from the plate: corners and edges of a
    convex polygon touch it, and the nearest points are unique."""
    return bool(curve.period) and bends(curve)[1] < 0.0


def check_side(support: Support, who: str, x: float, y: float) -> None:
    """Raise DoesNotFit for a plate whose centre lies on the right of a support, where it would go through."""
    curve = support.curve
    near = nearest_on(curve, x, y)
    is_end = curve.ends is not None and near in curve.ends
    away = np.array([x, y]) - curve.point(near)
    if not is_end and float(away @ curve.normal(near)) < -BEHIND * float(np.hypot(*away)):
        raise DoesNotFit(
            f"{who} lies behind support {support.name!r} where it begins, on its right; give another start, or turn "
            "its curve round"
        )
