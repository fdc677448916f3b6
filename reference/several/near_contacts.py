"""Decisions among the contacts that are near: gaps that are far from closing have no part in them.

A polygon of 200 corners watches 200 contacts, of which one or two touch. Equations of those alone are few and small,
and are compiled once.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypeVar

from cases import Case, Mode

from .decision import NEAR, DecisionInstant, SeveralDecision, decide
from .regimes import SeveralRegime, body_of, join, pairs_of

# What a contact has one of: a mode, or whether its rows are used.
Each = TypeVar("Each")


def decide_near(
    case: Case,
    now: DecisionInstant,
    error: float,
    fixed: Mapping[int, tuple[Mode, ...]] | None = None,
    last_modes: tuple[Mode, ...] | None = None,
) -> SeveralDecision:
    """`decide` among the contacts that touch or have a gap of less than `decision.NEAR`; the regime and the motions
    have all contacts, the others open. Arguments as of `decide`. Raises Undecidable."""
    near = _near(case, now)
    few = _only(now, near)
    own = {near.index(k): modes for k, modes in (fixed or {}).items()}
    answer = decide(case, few, error, own, None if last_modes is None else tuple(last_modes[k] for k in near))
    motions = tuple(_filled(modes, near, len(now.names), Mode.FLIGHT) for modes in answer.motions)
    return answer._replace(regime=answer.regime and _with_all(answer.regime, now, near), motions=motions)


def _near(case: Case, now: DecisionInstant) -> list[int]:
    """The places of the contacts that touch or nearly do; of a plate in flight the first."""
    size = abs(now.state[0]) + abs(now.state[1]) + case.plate.reach
    near = [k for k, at in enumerate(now.places) if k in now.touching or (at.gap <= NEAR * size and not now.away[k])]
    return near or list(range(min(1, len(now.places))))


def _only(now: DecisionInstant, some: Sequence[int]) -> DecisionInstant:
    """The instant with some of its contacts."""
    pairs = pairs_of(now.state)
    return now._replace(
        state=join(body_of(now.state), [pairs[k] for k in some]),
        places=[now.places[k] for k in some],
        names=tuple(now.names[k] for k in some),
        limits=tuple(now.limits[k] for k in some),
        touching=tuple(i for i, k in enumerate(some) if k in now.touching),
        away=tuple(now.away[k] for k in some),
    )


def _with_all(regime: SeveralRegime, now: DecisionInstant, some: Sequence[int]) -> SeveralRegime:
    """A regime of some contacts with all contacts of the instant, the others open."""
    count = len(now.names)
    guides = _filled(regime.guides, some, count, (False, False)) if regime.guides else ()
    modes = _filled(regime.modes, some, count, Mode.FLIGHT)
    return regime._replace(
        modes=modes, names=now.names, limits=now.limits, pairs=now.pairs, away=now.away, guides=guides
    )


def _filled(values: Sequence[Each], places: Sequence[int], count: int, other: Each) -> tuple[Each, ...]:
    """Values at those places among `count`, and `other` at the rest."""
    every = [other] * count
    for k, value in zip(places, values, strict=True):
        every[k] = value
    return tuple(every)
