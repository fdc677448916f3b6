"""Symbolic elimination of the augmented system (27), derived by hand.

In the frame of the common tangent (t along the track, n = U t towards the plate) the tangents of track and outline
coincide, so (27) splits: the n-component of its first constraint rows holds neither ξ̈₁ nor ξ̈₂ and gives the normal
force by one division; the t-component and the tangency row then give ξ̈₁ and ξ̈₂. Letters: P = |R_p|, a = R_s·t,
b = R_s·n, c = R_t·n on the track; p, a, b, c on the outline, rotated with the plate; h = θr, the arm to the contact.

There is one function for each set of constraint rows: a contact may slip or not, and, with resistance to rotation, turn
or not. Forces are per mass, so that mass drops out where it does not matter.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from cases.formulas.expression_graph import ONE, ZERO, Node, substitute, symbol

from ..effect_laws.belt import Surface
from .frames import Frame
from .tangent_algebra import operations, shorter

T, X1, X2, U1, U2 = map(symbol, ("t", "xi1", "xi2", "u1", "u2"))
GYRATION = symbol("G")  # J/m, the square of the radius of gyration
NORMAL = symbol("N")  # the normal force per mass, while it is being eliminated


# Force and moment of a load with powers or products, while the system is being eliminated, so that these are not
# multiplied out: where c/w is large, x²/w² − 2 c x/w² + c²/w² + 1 loses the digits of ((x − c)/w)² + 1.
LOAD = tuple(map(symbol, ("load fx", "load fy", "load moment")))
_MOVING = {T, X1, X2, U1, U2, *LOAD}


def short(value: Node) -> Node:
    """The node, multiplied out if that leaves fewer operations for each evaluation."""
    return shorter(value, _MOVING)


class Elimination(NamedTuple):
    """Result for one mode, as nodes or their values: accelerations, contact forces (per mass), spin and slip with their
    rates."""

    u1_dot: Any
    u2_dot: Any
    normal: Any
    friction: Any
    omega: Any
    omega_dot: Any
    slip: Any
    slip_dot: Any
    couple: Any  # what resists the rotation, per mass
    inverse_mass: Any  # the coefficient of the normal force in its equation, in units of its first term: Painlevé's
    free_approach: Any  # what the normal force balances: how fast the contact would close without any force in it


class Torsor(NamedTuple):
    """The applied force in the frame of the contact and its moment about the centre of mass, per mass."""

    t: Node
    n: Node
    moment: Node


def spin(f: Frame, h: Frame, u1, u2) -> Node:
    """ω, (9)."""
    return u1 * f.turning - u2 * h.turning


def _rates(f: Frame, h: Frame, u1, u2, omega):
    """Terms of the constraints that depend on the state: ξ̇₁²a − ξ̇₂²a, and the right-hand sides of (26) in the frame."""
    along = u1**2 * f.a - u2**2 * h.a
    C_t = omega**2 * h.ht + along
    C_n = omega**2 * h.hn - 2 * omega * u2 * h.P - u2**2 * h.b + u1**2 * f.b
    C_3 = (
        2 * omega * (u1 * f.a * h.P + u2 * h.a * f.P)
        - u1**2 * h.P * f.c
        + u2**2 * f.P * h.c
        - 2 * u1 * u2 * (f.b * h.a - f.a * h.b)
    )
    return along, C_t, short(C_n), short(C_3)


def sliding(f: Frame, h: Frame, force: Torsor, belt: Surface, ratio, resistance) -> Elimination:
    """(27) with one multiplier: friction is `ratio` and the couple `resistance` times the normal force."""
    omega = spin(f, h, U1, U2)
    along, C_t, C_n, C_3 = _rates(f, h, U1, U2, omega)
    lever = short(h.ht - h.hn * ratio + resistance)
    inverse_mass = short(1 + h.ht * lever / GYRATION)
    free_approach = _free_approach(h, force, C_n)
    omega_dot = (force.moment + NORMAL * lever) / GYRATION
    last = resistance * NORMAL, inverse_mass, free_approach
    motion = _slipping(f, h, force, belt, ratio, (omega, omega_dot), (along, C_t, C_3), last)
    return _with_normal_force(motion, free_approach / inverse_mass)


def translating(f: Frame, h: Frame, force: Torsor, belt: Surface, ratio) -> Elimination:
    """(27) with one multiplier and the row ω̇ = 0: the plate slips without turning; the couple follows from that."""
    along, C_t, C_n, C_3 = _rates(f, h, U1, U2, ZERO)
    couple = -force.moment - NORMAL * short(h.ht - h.hn * ratio)
    last = couple, ONE, _free_approach(h, force, C_n)
    motion = _slipping(f, h, force, belt, ratio, (ZERO, ZERO), (along, C_t, C_3), last)
    return _with_normal_force(motion, C_n - force.n)


def _slipping(f: Frame, h: Frame, force: Torsor, belt: Surface, ratio, spins, rates, last) -> Elimination:
    """ξ̈₁ and ξ̈₂ of a plate that slips, from its normal force and its spin."""
    (omega, omega_dot), (along, C_t, C_3) = spins, rates
    sigma = force.t + ratio * NORMAL - omega_dot * h.hn - C_t  # ξ̈₁ P − ξ̈₂ p, the t-component
    u1_dot, u2_dot = _accelerations(f, h, (U1, U2), C_3, omega_dot, sigma)
    slip = U1 * f.P - U2 * h.P - belt.speed
    friction = ratio * NORMAL
    slip_dot = sigma + along - belt.rate
    return Elimination(u1_dot, u2_dot, NORMAL, friction, short(omega), omega_dot, slip, slip_dot, *last)


def _accelerations(f: Frame, h: Frame, speeds, C_3: Node, omega_dot: Node, sigma: Node) -> tuple[Node, Node]:
    """ξ̈₁ and ξ̈₂ from σ = ξ̈₁ P − ξ̈₂ p and the tangency row, ξ̈₁ P κ₁ − ξ̈₂ p κ₂ = C₃/(P p) + ω̇, with the curvatures
    κ. On a corner the row is ξ̈₁ k₁ − ξ̈₂ k₂ = ω̇ − k₁′ ξ̇₁² + k₂′ ξ̇₂², and one of the speeds P and p is zero."""
    if f.sign or h.sign:
        turn = omega_dot - speeds[0] ** 2 * f.turning_rate + speeds[1] ** 2 * h.turning_rate
        if f.sign:
            return short((turn * h.P - sigma * h.turning) / (f.turning * h.P)), -sigma / h.P
        return sigma / f.P, short((f.turning * sigma - f.P * turn) / (h.turning * f.P))
    turn = C_3 / (f.P * h.P) + omega_dot
    bend = f.curvature - h.curvature
    u1_dot = short((turn - sigma * h.curvature) / short(f.P * bend))
    forms = short((u1_dot * f.P - sigma) / h.P), short((turn - sigma * f.curvature) / short(h.P * bend))
    return u1_dot, min(forms, key=lambda form: operations([u1_dot, form], _MOVING))


def _free_approach(h: Frame, force: Torsor, C_n) -> Node:
    return C_n - h.ht * force.moment / GYRATION - force.n


def _with_normal_force(motion: Elimination, normal: Node) -> Elimination:
    return Elimination(*substitute(motion, {NORMAL: normal}))


def rolling_speeds(f: Frame, h: Frame, belt: Surface) -> tuple[Node, Node]:
    """ξ̇₁ and ξ̇₂ of a plate whose point moves with the surface, in terms of one of them: v = 0 in (12). On a corner of
    the outline that leaves ξ̇₂ free, else ξ̇₁."""
    if h.sign:
        return belt.speed / f.P, U2
    return U1, U1 * (f.P / h.P) - belt.speed / h.P


def rolling(f: Frame, h: Frame, force: Torsor, belt: Surface, resistance) -> Elimination:
    """(27) with the tangential multiplier and the rolling row; ξ̇₂ follows from v = 0."""
    u1, u2 = rolling_speeds(f, h, belt)
    omega = spin(f, h, u1, u2)
    along, _, C_n, C_3 = _rates(f, h, u1, u2, omega)
    # Moments about the contact: neither multiplier appears, except in the couple that is proportional to the normal
    # force.
    moment = short(
        force.moment + (h.ht + resistance) * (C_n - force.n) - h.hn * (omega**2 * h.ht - force.t + belt.rate)
    )
    inertia = GYRATION + h.ht**2 + h.hn**2
    omega_dot = moment / short(inertia + resistance * h.ht)
    u1_dot, u2_dot = _accelerations(f, h, (u1, u2), C_3, omega_dot, belt.rate - along)
    N = C_n - omega_dot * h.ht - force.n
    friction = omega**2 * h.ht + omega_dot * h.hn - force.t + belt.rate
    inverse_mass = short(1 + resistance * h.ht / inertia)
    free_approach = _free_approach(h, force, C_n)
    return Elimination(
        u1_dot, u2_dot, N, friction, short(omega), omega_dot, ZERO, ZERO, resistance * N, inverse_mass, free_approach
    )


def resting(h: Frame, force: Torsor) -> Elimination:
    """(27) with the rows v̇ = 0 and ω̇ = 0 at rest: the contact carries the whole load."""
    couple = force.n * h.ht - force.t * h.hn - force.moment
    return Elimination(
        ZERO, ZERO, -force.n, -force.t, ZERO, ZERO, ZERO, ZERO, couple, ONE, _free_approach(h, force, ZERO)
    )


def conveyance_speeds(f: Frame, h: Frame, belt: Surface) -> tuple[Node, Node]:
    """ξ̇₁ and ξ̇₂ of a plate that a belt carries without rotation: v = 0 in (12) and ω = 0 in (9)."""
    if f.sign or h.sign:  # on a belt only a plate of infinite inertia does not turn, and that has no corners
        return ZERO, ZERO
    bend = h.curvature - f.curvature
    return belt.speed * h.curvature / (f.P * bend), belt.speed * f.curvature / (h.P * bend)


def conveyance(f: Frame, h: Frame, force: Torsor, belt: Surface) -> Elimination:
    """(27) with the rows v̇ = 0 and ω̇ = 0 on a belt."""
    u1, u2 = conveyance_speeds(f, h, belt)
    along, _, C_n, C_3 = _rates(f, h, u1, u2, ZERO)
    u1_dot, u2_dot = _accelerations(f, h, (u1, u2), C_3, ZERO, belt.rate - along)
    N, friction = C_n - force.n, belt.rate - force.t
    couple = friction * h.hn - N * h.ht - force.moment
    return Elimination(u1_dot, u2_dot, N, friction, ZERO, ZERO, ZERO, ZERO, couple, ONE, _free_approach(h, force, C_n))
