"""Impacts without duration: Routh's construction, piecewise along the normal impulse, or Moreau's law in one step.

The contact point's velocity (v_t, v_n) and the spin ω are linear in the normal impulse P as long as the contact slips
in one direction or sticks, and turns in one direction or does not turn. (Routh's construction: his book of
1905 is known to us, not looked up; Wang & Mason 1992, J. Appl. Mech. 59, 635: reference looked up, not the text.)
Impulses are taken per mass.

Moreau's law does not resolve the impact: normal impulse P, friction T and couple C of the whole impact obey
v_n⁺ = −e v_n⁻, |T| ≤ μ P with T against v_t⁺ where that is not 0, and |C| ≤ arm P with C against ω⁺ likewise. Without
rolling resistance there is exactly one solution whatever μ is: with T = −τ P and the 2×2 matrix [[a, b], [b, c]] from
(T, P) to the velocities, P = Q/(c − b τ), Q = −(1 + e) v_n⁻ > 0, and v_t⁺ = v_t⁻ + Q (b − a τ)/(c − b τ) falls with τ
wherever P > 0, since its derivative has the sign of b² − a c < 0. (Derived here; Moreau's and Jean's papers of 1988 and
1992 are known to us, not looked up.) It is the law of `solver.impact` at one contact, which takes five times as long.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from math import copysign, inf
from typing import NamedTuple

import numpy as np

from cases import Case

from ..effect_laws import laws
from ..effect_laws.restitution import impact_law, restitution
from .decision import Undecidable

# Slip and spin each end, and may begin again in the other direction, once in compression and once in restitution: an
# impact of finite numbers has no more than ten pieces.
MOST_PIECES = 100
# Exactly one end state satisfies Moreau's law; at the border of two, rounding may put each a little beyond its bound.
ROUNDING = 1e-9


class ContactVelocity(NamedTuple):
    """Velocity of the plate's contact point along the track's tangent and normal (m/s), and spin (rad/s)."""

    slip: float
    lift: float
    omega: float


class Law(NamedTuple):
    """The law of an impact: the arm from the centre to the contact along tangent and normal (m), the squared radius
    of gyration (m²), kinetic and static friction, the arm of rolling resistance (m), restitution and the name of its
    law (`cases.Impact`)."""

    arm_t: float
    arm_n: float
    gyration: float
    mu: float
    stick: float
    arm: float
    restitution: float
    name: str


class _Rates(NamedTuple):
    """Friction and couple per normal impulse, and the resulting rates of slip, lift and spin."""

    friction: float
    couple: float
    slip: float
    lift: float
    omega: float


def collide(law: Law, before: ContactVelocity) -> ContactVelocity:
    """The velocities after the impact of a closing contact; slip or spin that ends at 0 is exactly 0.

    A contact that neither opens nor closes has an impact only if unbounded friction stops its slip.
    """
    if before.lift > 0.0 or (before.lift == 0.0 and law.mu < inf):
        return before
    if law.name == "moreau":
        return _at_once(law, before)
    now = _stops(law, before) if law.mu == inf else before
    goal = 0.0 if law.name == "poisson" else -law.restitution * before.lift
    if now.lift >= goal:
        return now  # the impulse that stopped the slip has lifted the contact
    compression = 0.0
    if now.lift < 0.0:
        now, compression = _advance(law, now, lambda total, now, rates: _until(now.lift, rates.lift, 0.0))
        now = now._replace(lift=0.0)
    if law.restitution == 0.0:
        return now
    if law.name == "poisson":
        return _advance(law, now, lambda total, now, rates: law.restitution * compression - total)[0]
    if goal == 0.0:  # by underflow
        return now
    return _advance(law, now, lambda total, now, rates: _until(now.lift, rates.lift, goal))[0]._replace(lift=goal)


def energy(law: Law, touch: ContactVelocity) -> float:
    """Kinetic energy per mass (J/kg) of a plate with that contact velocity and spin."""
    along, across = touch.slip + touch.omega * law.arm_n, touch.lift - touch.omega * law.arm_t
    turning = law.gyration * touch.omega**2 if touch.omega else 0.0  # the radius of gyration may be infinite
    return 0.5 * (along**2 + across**2 + turning)


def _advance(
    law: Law, now: ContactVelocity, remaining: Callable[[float, ContactVelocity, _Rates], float]
) -> tuple[ContactVelocity, float]:
    """Apply impulse in pieces until `remaining(total, velocities, rates)`, the impulse still to come, is zero.

    Raises Undecidable if the velocities are not finite numbers, so that no piece ends it.
    """
    total = 0.0
    for _ in range(MOST_PIECES):
        rates = _rates(law, now)
        rest = max(remaining(total, now, rates), 0.0)
        slip_ends = _until(now.slip, rates.slip, 0.0)
        spin_ends = _until(now.omega, rates.omega, 0.0) if law.arm else inf  # otherwise nothing changes there
        step = min(rest, slip_ends, spin_ends)
        now = ContactVelocity(
            0.0 if step == slip_ends else now.slip + step * rates.slip,
            now.lift + step * rates.lift,
            0.0 if step == spin_ends else now.omega + step * rates.omega,
        )
        total += step
        if step == rest:
            return now, total
    raise Undecidable(f"the impact does not end at {now} under {law}")


def _until(value: float, rate: float, goal: float) -> float:
    """The impulse after which a velocity reaches `goal`; infinite if it does not approach it, or is equal to it."""
    way = goal - value
    approaches = way > 0.0 < rate or way < 0.0 > rate  # their product may be zero by underflow
    return way / rate if approaches else inf


def _rates(law: Law, now: ContactVelocity) -> _Rates:
    """The rates of the only continuation that satisfies Coulomb's law and the bound of the couple."""
    slips = (copysign(1.0, now.slip),) if now.slip else (0.0, 1.0, -1.0)
    turns = (0.0,) if not law.arm else (copysign(1.0, now.omega),) if now.omega else (0.0, 1.0, -1.0)
    for slip, turn in product(slips, turns):
        rates = _piece(law, slip, turn)
        sticks = abs(rates.friction) <= law.stick if not slip else bool(now.slip) or rates.slip * slip > 0.0
        holds = abs(rates.couple) <= law.arm if not turn else bool(now.omega) or rates.omega * turn > 0.0
        if sticks and holds:
            return rates
    # The matrix from (friction, couple) to the rates of (slip, ω) is positive definite, so one of them agrees.
    raise Undecidable(f"no piece of the impact agrees with its laws at {now} under {law}")


def _piece(law: Law, slip: float, turn: float) -> _Rates:
    """Rates while it slips and turns in those directions; 0: it sticks or does not turn (or rotation is free)."""
    holds = bool(law.arm) and not turn
    couple = -law.arm * turn
    if slip:
        friction = -law.mu * slip
    else:
        friction = 0.0 if holds else law.arm_n * (law.arm_t + couple) / (law.gyration + law.arm_n**2)
    if holds:
        couple = law.arm_n * friction - law.arm_t
    omega = (law.arm_t - law.arm_n * friction + couple) / law.gyration
    along = friction - law.arm_n * omega if slip else 0.0
    return _Rates(friction, couple, along, 1.0 + law.arm_t * omega, omega)


def _at_once(law: Law, before: ContactVelocity) -> ContactVelocity:
    """The velocities after an impact by Moreau's law: the first end state, most static first, that satisfies it."""
    goal = -law.restitution * before.lift
    if law.mu == inf and (sticking := _stops(law, before)).lift >= goal:
        return sticking  # the impulse that stops the slip lifts the contact fast enough without a normal impulse
    slips, turns = (0.0,) if law.mu == inf else (0.0, 1.0, -1.0), (0.0, 1.0, -1.0) if law.arm else (0.0,)
    ends = [_ending(law, before, slip, turn) for slip, turn in product(slips, turns)]
    excess, after = min(ends, key=lambda end: end[0])
    if not excess <= ROUNDING:
        raise Undecidable(f"no end of the impact agrees with its laws at {before} under {law}")
    return after._replace(lift=goal)


def _ending(law: Law, before: ContactVelocity, slip: float, turn: float) -> tuple[float, ContactVelocity]:
    """The relative violation of the laws by the impulse that ends slipping and turning in those directions (0: none),
    and the velocities after it.

    The impulse (T, P, C) solves one condition each on friction, normal velocity and couple.
    """
    holds = bool(law.arm) and not turn
    spins = np.array([-law.arm_n, law.arm_t, 1.0]) / law.gyration
    slips, lifts = np.array([1.0, 0.0, 0.0]) - law.arm_n * spins, np.array([0.0, 1.0, 0.0]) + law.arm_t * spins
    conditions = (
        (np.array([1.0, law.mu * slip, 0.0]), 0.0) if slip else (slips, -before.slip),
        (lifts, -(1.0 + law.restitution) * before.lift),
        (spins, -before.omega) if holds else (np.array([0.0, law.arm * turn, 1.0]), 0.0),
    )
    try:
        impulse = np.linalg.solve([row for row, _ in conditions], [value for _, value in conditions])
    except np.linalg.LinAlgError:  # friction that wedges: no impulse of this kind changes the normal velocity
        return inf, before
    friction, normal, couple = (float(part) for part in impulse)
    along, omega = before.slip + float(slips @ impulse), before.omega + float(spins @ impulse)
    if not normal > 0.0:
        return inf, before
    excess = max(
        -along * slip / (abs(before.slip) + abs(along)) if slip and along else 0.0,
        -omega * turn / (abs(before.omega) + abs(omega)) if turn and omega else 0.0,
        abs(friction) / normal - law.stick if not slip else 0.0,
        (abs(couple) / normal - law.arm) / law.arm if holds else 0.0,
    )
    return max(excess, 0.0), ContactVelocity(along if slip else 0.0, before.lift, 0.0 if holds else omega)


def _stops(law: Law, now: ContactVelocity) -> ContactVelocity:
    """The velocities after unbounded friction has stopped the slip, before any normal impulse."""
    impulse = -now.slip / (1.0 + law.arm_n**2 / law.gyration)
    spin_change = -law.arm_n * impulse / law.gyration
    return ContactVelocity(0.0, now.lift + law.arm_t * spin_change, now.omega + spin_change)


def law_of(case: Case, arm_t: float, arm_n: float, slip: float) -> Law:
    """The law of an impact of the case at a contact with that arm from the centre of mass, which begins at that slip
    velocity (m/s)."""
    law = laws(case)
    numbers = *law.friction.in_impact(case, slip), law.resistance.arm(case), restitution(case), impact_law(case)
    return Law(arm_t, arm_n, case.plate.inertia / case.plate.mass, *numbers)
