"""Regimes of several contacts, and their equations with numbers.

A contact is watched while it is closed, and after it has opened until its nearest points may no longer be the only
ones. The state is (x, y, θ), (ξ₁, ξ₂) of every watched contact, and (vx, vy, ω).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple, cast

import numpy as np

from cases import Belt, Case, CoulombFriction, Load, Mode
from cases.contact_pairs import PairCase, pairs
from cases.corner import Corner, Piece
from cases.supports import is_straight

from ..minimal.assembly import parameter_values, sizes_of
from ..minimal.effects import SLIP_SIGN, CoulombBySpeed, FixedSurface, Frictionless, laws
from ..minimal.frames import CORNER
from ..minimal.modes import Phase, Regime, _features
from ..minimal.system import slack_name
from .contact_law import STICKING, coefficients, resisting_arm
from .equations import NO_ROWS, ContactForm, ContactRows, Rotation, several_system

# An open contact is watched until the clearance of its curvatures falls below this part of its value when it was last
# closed: its nearest points then move fast, and may soon be lost.
LOST = 0.05


class SeveralRegime(NamedTuple):
    """The modes of all watched contacts (FLIGHT: open) and the clearances (1/m) at which open ones are lost.

    `rests`: the closed contacts hold the plate; `names` are those of the contacts, `pairs` the numbers of their pairs
    of a support and a feature of the outline; `away`: which of them are arcs turned away from their supports.
    `guides`: of contacts with more than three rows, some of them on belts, which normal and tangential rows determine
    the motion (`ContactForm.guides`); empty otherwise. `turn`: the sense of a rotation that closed contacts resist, 0
    if they prevent it; None if none of them resists rolling. `slack`: the conditions on forces that vanish all the
    time, and how far below zero they may be (m/s²): their rounding.
    """

    modes: tuple[Mode, ...]
    names: tuple[str, ...]
    limits: tuple[float, ...]
    pairs: tuple[int, ...]
    away: tuple[int, ...]
    rests: bool = False
    guides: tuple[tuple[bool, bool], ...] = ()
    turn: int | None = None
    slack: tuple[tuple[str, float], ...] = ()

    @property
    def has_open_forces(self) -> bool:
        """Whether the contacts determine the motion, and their forces may not be unique."""
        return self.rests or bool(self.guides)

    @property
    def closed(self) -> tuple[int, ...]:
        """The places of the closed contacts."""
        return tuple(k for k, mode in enumerate(self.modes) if mode is not Mode.FLIGHT)

    @property
    def kinds(self) -> tuple[ContactRows, ...]:
        """The kind of equations of each contact."""
        return tuple(
            ContactRows.AWAY if is_away
            else ContactRows.OPEN if mode is Mode.FLIGHT
            else ContactRows.STICK if mode in STICKING
            else ContactRows.SLIP
            for mode, is_away in zip(self.modes, self.away, strict=True)
        )  # fmt: skip


class SeveralPhase(Phase):
    """A regime of several contacts with its equations and numbers; integrators read it as any other phase."""

    __slots__ = ()

    def __reduce__(self):
        return several_phase, (self.case, self.regime)


def regime_of(phase: Phase) -> SeveralRegime:
    """The regime of a phase of several contacts."""
    return cast(SeveralRegime, phase.regime)


def contacts_of(case: Case, regime: SeveralRegime) -> list[PairCase]:
    """The pair of a support and a feature of each contact."""
    every = pairs(case)
    return [every[number] for number in regime.pairs]


def _structure(piece: Piece):
    """What the equations of a contact on that curve or corner depend on."""
    return piece.sign if isinstance(piece, Corner) else piece.structure


def _has_ends(piece: Piece) -> bool:
    """Whether a contact may reach an end of a curve; a corner alone has none."""
    return not isinstance(piece, Corner) and piece.ends is not None


def _sizes(piece: Piece, prefix: str) -> dict[str, float]:
    """A curve's parameters, by name."""
    names = CORNER if isinstance(piece, Corner) else [size.name for size in piece.structure[1]]
    values = {prefix + name: value for name, value in zip(names, piece.constants, strict=True)}
    return values | ({f"{prefix}low": piece.domain[0], f"{prefix}high": piece.domain[1]} if piece.domain else {})


def _first_of_side(contacts: Sequence[PairCase], kinds: Sequence[ContactRows], k: int) -> int | None:
    """The first closed corner on the straight track of another closed corner: a side lies flat there."""
    track = contacts[k].track
    flat = [
        j for j in range(k + 1)
        if kinds[j] not in NO_ROWS and isinstance(contacts[j].plate.outline, Corner) and contacts[j].track == track
    ]  # fmt: skip
    return flat[0] if flat[-1:] == [k] and len(flat) > 1 and is_straight(track) else None


@lru_cache(maxsize=512)
def several_phase(case: Case, regime: SeveralRegime) -> SeveralPhase:
    """The equations of that regime with the case's parameters."""
    contacts = contacts_of(case, regime)
    kinds = regime.kinds if not regime.rests else (ContactRows.OPEN,) * len(regime.kinds)
    forms = tuple(
        ContactForm(
            _structure(one.track), _structure(one.plate.outline), kind,
            laws(one).friction if kind not in NO_ROWS else Frictionless(),
            has_ends=(_has_ends(one.track), _has_ends(one.plate.outline)), stays=one.has_unique_points,
            turns=one.arc_range is not None, surface=laws(one).belt if kind not in NO_ROWS else FixedSurface(),
            guides=regime.guides[k] if regime.guides else None,
            resists=regime.turn is not None and kind not in NO_ROWS and resisting_arm(one) > 0.0,
            along=_first_of_side(contacts, kinds, k),
        )
        for k, (one, kind) in enumerate(zip(contacts, kinds, strict=True))
    )  # fmt: skip
    turn = None if regime.rests else regime.turn
    rotation = Rotation.FREE if turn is None else Rotation.RESISTED if turn else Rotation.HELD
    system = several_system(forms, laws(case), rotation, tuple(name for name, _ in regime.slack))
    values: dict[str, float] = {"tau": float(turn or 0)} | {slack_name(name): size for name, size in regime.slack}
    for k, (mode, one) in enumerate(zip(regime.modes, contacts, strict=True)):
        sign, (mu, stick) = SLIP_SIGN.get(mode, 0.0), coefficients(one)
        values |= forms[k].surface.of_contact(k).values(one)
        values |= {f"k_{k}": -sign * mu if sign else 0.0, f"sigma_{k}": sign, f"stick_{k}": stick}
        friction, law = forms[k].friction.of_contact(k), one.effect(CoulombFriction)
        if isinstance(friction, CoulombBySpeed) and law is not None:
            values |= friction.sizes_of(law)
        values[f"lost_{k}"] = regime.limits[k]
        values |= {f"arm_{k}": resisting_arm(one), f"rho_{k}": -(turn or 0) * resisting_arm(one)}
        values[f"turn_low_{k}"], values[f"turn_high_{k}"] = one.limits_of_turn(regime.away[k])
        values |= _sizes(one.track, f"track_{k}_") | _sizes(one.plate.outline, f"outline_{k}_")
    gyration = case.plate.gyration
    speeds = [_angle(piece, gyration) for one in contacts for piece in (one.track, one.plate.outline)]
    lengths = (gyration, gyration, 1.0, *speeds)
    load, count = case.effect(Load), len(regime.modes)
    features = list(_features(load, None))
    for k, one in enumerate(contacts):
        if kinds[k] not in NO_ROWS:
            features += _features(None, one.effect(Belt))
        features += [(3 + 2 * k, f) for _, f in _features(None, None, one.track)]
        features += [(4 + 2 * k, f) for _, f in _features(None, None, one.plate.outline)]
    first = pairs(case)[0]
    parameters = parameter_values(case, sizes_of(first.track, first.plate.outline, case.plate) | values, system)
    places = tuple(range(6 + 2 * count))
    return SeveralPhase(
        cast(Regime, regime),
        system,
        parameters,
        gyration,
        lengths,
        places,
        case,
        tuple(features),
        bool(system.load_quantities),
    )


def _angle(piece: Piece, gyration: float) -> float:
    """The change of a parameter that moves its point by the radius of gyration; at a corner it is an angle."""
    return 1.0 if isinstance(piece, Corner) else gyration / float(piece.speed(piece.span[0]))


def pairs_of(state: Sequence[float] | np.ndarray) -> list[tuple[float, float]]:
    """(ξ₁, ξ₂) of every contact of a state."""
    inside = list(state[3:-3])
    return list(zip(inside[::2], inside[1::2], strict=True))


def body_of(state: Sequence[float] | np.ndarray) -> list[float]:
    """(x, y, θ, vx, vy, ω) of a state."""
    return [*state[:3], *state[-3:]]


def join(body: Sequence[float] | np.ndarray, pairs: Sequence[tuple[float, float]]) -> tuple[float, ...]:
    """The state of a body (x, y, θ, vx, vy, ω) with those pairs of points."""
    return (*map(float, body[:3]), *(float(v) for pair in pairs for v in pair), *map(float, body[3:]))
