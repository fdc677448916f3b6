"""Effects of one pair of bodies: friction, rolling resistance and impact of their contacts instead of the case's."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from .. import effects as all_effects
from ..effects import CoulombFriction, Effect, Impact, PerfectlyRough, RollingResistance
from ..errors import BadValue, items, unknown_name
from .contact_names import FIRST, TRACK

# Effects by which two bodies resist slip and rotation, and which a pair has instead of the case's as soon as it has
# effects of its own.
RESISTING = (CoulombFriction, PerfectlyRough, RollingResistance)


@dataclass(frozen=True)
class Pair:
    """Effects of the contacts of two bodies, by their names: Pair("upper/plate", (CoulombFriction(0.2),)).

    `name`: two plates, or a plate with "track" or a support; the case's own plate is "plate". `effects`:
    CoulombFriction or PerfectlyRough (neither: no friction), RollingResistance (not given: none), and Impact (not
    given: the case's). Raises BadValue.
    """

    name: str
    effects: tuple[Effect, ...]

    def __post_init__(self):
        if not isinstance(self.name, str) or self.name.count("/") != 1:
            raise BadValue(
                f'the name of a Pair is {self.name!r}; give two bodies such as "upper/plate" or "plate/track"'
            )
        object.__setattr__(self, "effects", own_effects_of("Pair", self.effects, (*RESISTING, Impact)))


def own_effects_of(what: str, effects: Any, possible: tuple[type, ...]) -> tuple[Effect, ...]:
    """Effects of a part of the scene as a tuple. Raises BadValue for those that it cannot have."""
    try:
        own = tuple(effects)
    except TypeError:
        raise BadValue(f"effects of {what} is {effects!r}; give a tuple such as (CoulombFriction(0.2),)") from None
    for effect in own:
        if not isinstance(effect, possible):
            *first, last = (kind.__name__ for kind in possible)
            raise BadValue(
                f"{effect!r} is no effect of one {what}; give {', '.join(first)} or {last} there, and the other "
                "effects in the case"
            )
    return all_effects.that_act(own)


def with_own(of_case: tuple[Effect, ...], own: Sequence[Effect], *more: type) -> tuple[Effect, ...]:
    """The effects of a case with those of one of its parts in their places, and without those of `more` kinds."""
    kinds = (*RESISTING, *more, *((Impact,) if all_effects.one(own, Impact) else ()))
    return (*(effect for effect in items("effects", of_case) if not isinstance(effect, kinds)), *own)


def of_pair(case: Any, name: str, otherwise: tuple[Effect, ...]) -> tuple[Effect, ...]:
    """All effects at the contacts of two bodies; `otherwise`: those where the case names no Pair of them."""
    names = {name, "/".join(reversed(name.split("/")))}
    own = next((pair.effects for pair in case.pairs if pair.name in names), None)
    return otherwise if own is None else with_own(otherwise, own)


def check_pairs(case: Any) -> None:
    """Raise BadValue for pairs that the case cannot have."""
    if not isinstance(case.pairs, tuple) or not all(isinstance(pair, Pair) for pair in case.pairs):
        raise BadValue(f'pairs is {case.pairs!r}; give a tuple such as (Pair("plate/track", (CoulombFriction(0.2),)),)')
    plates = (FIRST, *(other.name for other in case.others))
    fixed = (TRACK, *(support.name for support in case.supports))
    possible_names = [f"{plate}/{base}" for i, plate in enumerate(plates) for base in (*fixed, *plates[:i])]
    seen = set[frozenset[str]]()
    for pair in case.pairs:
        bodies = frozenset(pair.name.split("/"))
        if bodies not in map(frozenset, (name.split("/") for name in possible_names)):
            raise unknown_name("pair of the case", pair.name, possible_names)
        if bodies in seen:
            raise BadValue(f"two pairs have the name {pair.name!r}; give all its effects in one")
        seen.add(bodies)
        if len(possible_names) == 1:
            raise BadValue(f"{pair.name!r} is the only pair of the case; give its effects as those of the case")
        all_effects.check_formula(of_pair(case, pair.name, case.effects))
        check_law(case, f"pair {pair.name!r}", pair.effects)


def check_law(case: Any, what: str, own: Sequence[Effect]) -> None:
    """Raise BadValue for a law of impact of a part of the scene that is not the case's."""
    one, law = all_effects.one(own, Impact), case.effect(Impact)
    if one is not None and (law is None or one.law != law.law):
        raise BadValue(f"the Impact of {what} needs an Impact of the case with the same law; restitution may differ")
