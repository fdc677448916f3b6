"""What a contact can do, and the numbers that go with it.

A `Regime` is a mode and the sign of the normal force (−1 only in a two-sided guide). It fixes the runtime parameters
of the mode's equations: friction per normal force, sign of the slip, bound of friction in roll.
"""

from __future__ import annotations

from functools import lru_cache
from math import sqrt
from typing import NamedTuple

from cases import Case, CoulombFriction, Mode, Unilateral
from cases.contact import start_motion

from .eliminated import RATIO, SIDE, SIGMA, STICK, System, parameter_values, system

SLIP_SIGN = {Mode.SLIP_FORWARD: 1.0, Mode.SLIP_BACKWARD: -1.0}


class Regime(NamedTuple):
    """A mode of contact and the side of the track that presses."""

    mode: Mode
    side: int = 1


class Phase(NamedTuple):
    """A regime with its equations and their parameters: all an integrator needs.

    `lengths` are the plate's size (radius of gyration) in units of ξ₁ and ξ₂: what counts as a change of order one.
    """

    regime: Regime
    system: System
    parameters: tuple[float, ...]
    lengths: tuple[float, float]


def candidates(case: Case) -> tuple[Regime, ...]:
    """The regimes the case's effects allow; where two are possible (static friction) the earlier one is taken."""
    sides = (1,) if case.effect(Unilateral) else (1, -1)
    if case.effect(CoulombFriction) is None:
        return (Regime(Mode.SLIDE),)
    return tuple(Regime(mode, side) for mode in (Mode.ROLL, Mode.SLIP_FORWARD, Mode.SLIP_BACKWARD) for side in sides)


@lru_cache(maxsize=1024)
def phase(case: Case, regime: Regime) -> Phase:
    """The equations of that regime with the case's parameters."""
    equations = system(case, regime.mode)
    values = {SIDE: float(regime.side)}
    friction = case.effect(CoulombFriction)
    if friction:
        sign = SLIP_SIGN.get(regime.mode, 0.0)
        # (28), (30): against the slip, in proportion to the magnitude of the normal force.
        values |= {RATIO: -sign * regime.side * friction.mu, SIGMA: sign, STICK: friction.stick}
    start, size = start_motion(case), sqrt(case.plate.inertia / case.plate.mass)
    lengths = size / float(case.track.speed(start.xi1)), size / float(case.plate.outline.speed(start.xi2))
    return Phase(regime, equations, parameter_values(case, values, equations.parameters), lengths)


def state_in(phase: Phase, y) -> tuple[float, ...]:
    """The full state (ξ₁, ξ₂, ξ̇₁, ξ̇₂) in the mode's own variables."""
    return tuple(y[: len(phase.system.variables)])


def full_state(case: Case, phase: Phase, y) -> tuple[float, ...]:
    """A mode's own variables as (ξ₁, ξ₂, ξ̇₁, ξ̇₂)."""
    if len(y) == 4:
        return tuple(float(v) for v in y)
    xi1, xi2, u1 = (float(v) for v in y)
    return xi1, xi2, u1, without_slip(case, xi1, xi2, u1)


def without_slip(case: Case, xi1: float, xi2: float, u1: float) -> float:
    """ξ̇₂ of a plate that does not slip: v = 0 in (12)."""
    return u1 * float(case.track.speed(xi1)) / float(case.plate.outline.speed(xi2))


def start_state(case: Case) -> tuple[float, ...]:
    """The case's start as (ξ₁, ξ₂, ξ̇₁, ξ̇₂)."""
    start = start_motion(case)
    return start.xi1, start.xi2, start.xi1_dot, start.xi2_dot
