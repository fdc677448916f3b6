"""Regimes of several contacts, and their equations with numbers.

A contact is watched while it is closed, and after it has opened until its nearest points may no longer be the only
ones. The state is (x, y, θ), (ξ₁, ξ₂) of every watched contact, and (vx, vy, ω).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple, cast

import numpy as np

from cases import Case, CoulombFriction, Load, Mode, PerfectlyRough

from ..minimal.assembly import parameter_values
from ..minimal.effects import SLIP_SIGN, laws
from ..minimal.modes import Phase, Regime, _features
from .equations import ContactRows, several_system

# An open contact is watched until the clearance of its curvatures falls below this part of its value when it was last
# closed: its nearest points then move fast, and may soon be lost.
LOST = 0.05


class SeveralRegime(NamedTuple):
    """The modes of all watched contacts (FLIGHT: open) and the clearances (1/m) at which open ones are lost.

    `rests`: the closed contacts hold the plate; `names` are those of the contacts.
    """

    modes: tuple[Mode, ...]
    names: tuple[str, ...]
    limits: tuple[float, ...]
    rests: bool = False

    @property
    def closed(self) -> tuple[int, ...]:
        """The places of the closed contacts."""
        return tuple(k for k, mode in enumerate(self.modes) if mode is not Mode.FLIGHT)

    @property
    def kinds(self) -> tuple[ContactRows, ...]:
        """The kind of equations of each contact."""
        return tuple(
            ContactRows.OPEN if mode is Mode.FLIGHT else ContactRows.STICK if mode is Mode.ROLL else ContactRows.SLIP
            for mode in self.modes
        )


class SeveralPhase(Phase):
    """A regime of several contacts with its equations and numbers; integrators read it as any other phase."""

    __slots__ = ()

    def __reduce__(self):
        return several_phase, (self.case, self.regime)


def regime_of(phase: Phase) -> SeveralRegime:
    """The regime of a phase of several contacts."""
    return cast(SeveralRegime, phase.regime)


def coefficients(case: Case) -> tuple[float, float]:
    """The coefficients of friction with slip and without; infinite for a perfectly rough contact."""
    if case.effect(PerfectlyRough) is not None:
        return float("inf"), float("inf")
    friction = case.effect(CoulombFriction)
    return (friction.at_rest, friction.stick) if friction else (0.0, 0.0)


def slip_modes(case: Case) -> tuple[Mode, ...]:
    """The modes of a closed contact that may slip."""
    if case.effect(PerfectlyRough) is not None:
        return ()
    return (Mode.SLIP_FORWARD, Mode.SLIP_BACKWARD) if case.effect(CoulombFriction) else (Mode.SLIDE,)


@lru_cache(maxsize=512)
def several_phase(case: Case, regime: SeveralRegime) -> SeveralPhase:
    """The equations of that regime with the case's parameters."""
    mu, stick = coefficients(case)
    rough = case.effect(PerfectlyRough) is not None
    has_ends = tuple(c.domain is not None and c.period is None for c in (case.track, case.plate.outline))
    kinds = regime.kinds if not regime.rests else (ContactRows.OPEN,) * len(regime.kinds)
    system = several_system(
        case.track.structure, case.plate.outline.structure, (has_ends[0], has_ends[1]), laws(case), kinds,
        stick > 0.0 and not rough, rough,
    )  # fmt: skip
    values: dict[str, float] = {}
    for k, mode in enumerate(regime.modes):
        sign = SLIP_SIGN.get(mode, 0.0)
        values |= {f"k_{k}": -sign * mu if sign else 0.0, f"sigma_{k}": sign, f"stick_{k}": stick}
        values[f"lost_{k}"] = regime.limits[k]
    gyration = case.plate.gyration
    speeds = [
        gyration / float(curve.speed(curve.span[0])) for _ in regime.modes for curve in (case.track, case.plate.outline)
    ]
    lengths = (gyration, gyration, 1.0, *speeds)
    load, count = case.effect(Load), len(regime.modes)
    features = list(_features(load, None))
    for k in range(count):
        features += [(3 + 2 * k, f) for _, f in _features(None, None, case.track)]
        features += [(4 + 2 * k, f) for _, f in _features(None, None, case.plate.outline)]
    parameters = parameter_values(case, values, system, case.track, case.plate.outline)
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
        bool(laws(case).checked_quantities),
    )


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
