"""Symbolic elimination of the augmented system (27), derived by hand.

In the frame of the common tangent (t along the track, n = U t towards the plate) the tangents of track and outline
coincide, so (27) splits: the n-component of its first constraint rows holds neither ξ̈₁ nor ξ̈₂ and gives the normal
force by one division; the t-component and the tangency row then give ξ̈₁ and ξ̈₂. Letters: P = |R_p|, a = R_s·t,
b = R_s·n, c = R_t·n on the track; p, a, b, c on the outline, rotated with the plate; h = θr, the arm to the contact.

A contact may slip or not, and, with resistance to rotation, turn or not: these are its constraint rows. Forces are per
mass, so that mass drops out where it does not matter.
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


def eliminate(
    f: Frame, h: Frame, force: Torsor, belt: Surface, slips: bool, holds: bool, ratio, resistance
) -> Elimination:
    """(27) of a contact that slips, or has the tangential multiplier and the row v̇ = 0; one that holds has the row
    ω̇ = 0 and a couple. Else the couple is `resistance` times the normal force, as friction of a slip is `ratio`."""
    u1, u2 = speeds(f, h, belt, slips, holds)
    omega = ZERO if holds else spin(f, h, u1, u2)
    along, C_t, C_n, C_3 = _rates(f, h, u1, u2, omega)
    free_approach = C_n - h.ht * force.moment / GYRATION - force.n
    omega_dot, inverse_mass = ZERO, ONE
    if slips and not holds:
        lever = short(h.ht - h.hn * ratio + resistance)
        inverse_mass = short(1 + h.ht * lever / GYRATION)
        omega_dot = (force.moment + NORMAL * lever) / GYRATION
    elif not holds:
        # Moments about the contact: neither multiplier appears, except in the couple that is proportional to the normal
        # force.
        moment = short(
            force.moment + (h.ht + resistance) * (C_n - force.n) - h.hn * (omega**2 * h.ht - force.t + belt.rate)
        )
        inertia = GYRATION + h.ht**2 + h.hn**2
        inverse_mass = short(1 + resistance * h.ht / inertia)
        omega_dot = moment / short(inertia + resistance * h.ht)
    normal = free_approach / inverse_mass if slips and not holds else C_n - omega_dot * h.ht - force.n
    friction = ratio * NORMAL if slips else omega**2 * h.ht + omega_dot * h.hn - force.t + belt.rate
    # ξ̈₁ P − ξ̈₂ p, the t-component
    sigma = force.t + friction - omega_dot * h.hn - C_t if slips else belt.rate - along
    u1_dot, u2_dot = _accelerations(f, h, (u1, u2), C_3, omega_dot, sigma)
    slip, slip_dot = (U1 * f.P - U2 * h.P - belt.speed, sigma + along - belt.rate) if slips else (ZERO, ZERO)
    couple = friction * h.hn - NORMAL * h.ht - force.moment if holds else resistance * NORMAL
    motion = Elimination(
        u1_dot, u2_dot, NORMAL, friction, short(omega), omega_dot, slip, slip_dot, couple, inverse_mass, free_approach
    )
    return Elimination(*substitute(motion, {NORMAL: normal}))


def speeds(f: Frame, h: Frame, belt: Surface, slips: bool, holds: bool) -> tuple[Node, Node]:
    """ξ̇₁ and ξ̇₂ in terms of the velocities among a kind's variables. Without slip v = 0 in (12): on a corner of the
    outline that leaves ξ̇₂ free, else ξ̇₁. Without slip and rotation a belt carries the plate, by ω = 0 in (9)."""
    if slips:
        return U1, U2
    if not holds:
        return (belt.speed / f.P, U2) if h.sign else (U1, U1 * (f.P / h.P) - belt.speed / h.P)
    if f.sign or h.sign:  # on a belt only a plate of infinite inertia does not turn, and that has no corners
        return ZERO, ZERO
    bend = h.curvature - f.curvature
    return belt.speed * h.curvature / (f.P * bend), belt.speed * f.curvature / (h.P * bend)


def _accelerations(f: Frame, h: Frame, own, C_3: Node, omega_dot: Node, sigma: Node) -> tuple[Node, Node]:
    """ξ̈₁ and ξ̈₂ from σ = ξ̈₁ P − ξ̈₂ p and the tangency row, ξ̈₁ P κ₁ − ξ̈₂ p κ₂ = C₃/(P p) + ω̇, with the curvatures
    κ. On a corner the row is ξ̈₁ k₁ − ξ̈₂ k₂ = ω̇ − k₁′ ξ̇₁² + k₂′ ξ̇₂², and one of the speeds P and p is zero."""
    if f.sign or h.sign:
        turn = omega_dot - own[0] ** 2 * f.turning_rate + own[1] ** 2 * h.turning_rate
        if f.sign:
            return short((turn * h.P - sigma * h.turning) / (f.turning * h.P)), -sigma / h.P
        return sigma / f.P, short((f.turning * sigma - f.P * turn) / (h.turning * f.P))
    turn = C_3 / (f.P * h.P) + omega_dot
    bend = f.curvature - h.curvature
    u1_dot = short((turn - sigma * h.curvature) / short(f.P * bend))
    forms = short((u1_dot * f.P - sigma) / h.P), short((turn - sigma * f.curvature) / short(h.P * bend))
    return u1_dot, min(forms, key=lambda form: operations([u1_dot, form], _MOVING))
