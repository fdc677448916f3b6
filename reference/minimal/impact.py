"""An impact without duration: Routh's construction, piece by piece along the normal impulse.

The contact point's velocity (v_t, v_n) and the spin ω are linear in the normal impulse P as long as the contact
slips one way or sticks, turns one way or is held. (Routh's construction: his book of
1905 is known to us, not looked up; Wang & Mason 1992, J. Appl. Mech. 59, 635: reference looked up, not the text.)
Impulses are taken per mass.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from math import copysign, inf
from typing import NamedTuple

from cases import Case, CoulombFriction, Impact, PerfectlyRough, RollingResistance


class Touch(NamedTuple):
    """Velocity of the plate's contact point along the track's tangent and normal (m/s), and spin (rad/s)."""

    slip: float
    lift: float
    omega: float


class Law(NamedTuple):
    """What an impact obeys: the arm from the centre to the contact along tangent and normal (m), the squared radius
    of gyration (m²), kinetic and static friction, the arm of rolling resistance (m), restitution and its law."""

    arm_t: float
    arm_n: float
    gyration: float
    mu: float
    stick: float
    arm: float
    restitution: float
    poisson: bool


class _Rates(NamedTuple):
    """Friction and couple per normal impulse, and what they do to slip, lift and spin."""

    friction: float
    couple: float
    slip: float
    lift: float
    omega: float


def collide(law: Law, before: Touch) -> Touch:
    """The velocities after the impact of a contact that closes (lift <= 0); a slip or spin that ends is exactly 0."""
    if before.lift > 0.0:
        return before
    now = _stopped(law, before) if law.mu == inf else before
    if now.lift >= 0.0:
        return now
    now, compression = _advance(law, now, lambda spent, now, rates: _until(now.lift, rates.lift, 0.0))
    now = now._replace(lift=0.0)
    if law.restitution == 0.0:
        return now
    if law.poisson:
        return _advance(law, now, lambda spent, now, rates: law.restitution * compression - spent)[0]
    goal = -law.restitution * before.lift
    return _advance(law, now, lambda spent, now, rates: _until(now.lift, rates.lift, goal))[0]._replace(lift=goal)


def energy(law: Law, touch: Touch) -> float:
    """Kinetic energy per mass (J/kg) of a plate whose contact point moves like that."""
    along, across = touch.slip + touch.omega * law.arm_n, touch.lift - touch.omega * law.arm_t
    return 0.5 * (along**2 + across**2 + law.gyration * touch.omega**2)


def _advance(law: Law, now: Touch, left: Callable[[float, Touch, _Rates], float]) -> tuple[Touch, float]:
    """Piece after piece until `left(spent, velocities, rates)`, the impulse still to come, is used up."""
    spent = 0.0
    while True:
        rates = _rates(law, now)
        rest = max(left(spent, now, rates), 0.0)
        slip_ends = _until(now.slip, rates.slip, 0.0)
        spin_ends = _until(now.omega, rates.omega, 0.0) if law.arm else inf  # otherwise nothing changes there
        step = min(rest, slip_ends, spin_ends)
        now = Touch(
            0.0 if step == slip_ends else now.slip + step * rates.slip,
            now.lift + step * rates.lift,
            0.0 if step == spin_ends else now.omega + step * rates.omega,
        )
        spent += step
        if step == rest:
            return now, spent


def _until(value: float, rate: float, goal: float) -> float:
    """The impulse after which a velocity reaches `goal`; infinite if it does not come nearer, or is there."""
    return (goal - value) / rate if (goal - value) * rate > 0.0 else inf


def _rates(law: Law, now: Touch) -> _Rates:
    """The one way on that agrees with Coulomb's law and with the bound of the couple."""
    slips = (copysign(1.0, now.slip),) if now.slip else (0.0, 1.0, -1.0)
    turns = (0.0,) if not law.arm else (copysign(1.0, now.omega),) if now.omega else (0.0, 1.0, -1.0)
    for slip, turn in product(slips, turns):
        rates = _piece(law, slip, turn)
        sticks = abs(rates.friction) <= law.stick if not slip else bool(now.slip) or rates.slip * slip > 0.0
        held = abs(rates.couple) <= law.arm if not turn else bool(now.omega) or rates.omega * turn > 0.0
        if sticks and held:
            return rates
    # The matrix from (friction, couple) to the rates of (slip, ω) is positive definite, so one of them agrees.
    raise ArithmeticError(f"no piece of the impact agrees with its laws at {now} under {law}")


def _piece(law: Law, slip: float, turn: float) -> _Rates:
    """Rates while it slips and turns in those senses; 0: it sticks, it is held (or nothing resists the rotation)."""
    held = bool(law.arm) and not turn
    couple = -law.arm * turn
    if slip:
        friction = -law.mu * slip
    else:
        friction = 0.0 if held else law.arm_n * (law.arm_t + couple) / (law.gyration + law.arm_n**2)
    if held:
        couple = law.arm_n * friction - law.arm_t
    omega = (law.arm_t - law.arm_n * friction + couple) / law.gyration
    along = friction - law.arm_n * omega if slip else 0.0
    return _Rates(friction, couple, along, 1.0 + law.arm_t * omega, omega)


def _stopped(law: Law, now: Touch) -> Touch:
    """Friction without bound ends the slip before there is any normal impulse."""
    impulse = -now.slip / (1.0 + law.arm_n**2 / law.gyration)
    turned = -law.arm_n * impulse / law.gyration
    return Touch(0.0, now.lift + law.arm_t * turned, now.omega + turned)


def law_of(case: Case, arm_t: float, arm_n: float) -> Law:
    """What an impact of the case obeys whose contact lies at that arm from the centre of mass."""
    impact, friction, resistance = case.effect(Impact), case.effect(CoulombFriction), case.effect(RollingResistance)
    assert impact is not None
    mu, stick = (friction.mu, friction.stick) if friction else (0.0, 0.0)
    if case.effect(PerfectlyRough):
        mu = stick = inf
    return Law(
        arm_t,
        arm_n,
        case.plate.inertia / case.plate.mass,
        mu,
        stick,
        resistance.arm if resistance else 0.0,
        impact.restitution,
        impact.law == "poisson",
    )
