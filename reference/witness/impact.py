"""Impacts of the second formulation: the impulse equations integrated along the normal impulse, piece by piece.

At an impact only impulses count, and the contact does not move. Velocity of the contact point (v_t, v_n) and spin ω
obey, per normal impulse P (Routh's construction as Wang & Mason, J. Appl. Mech. 59, 1992, 635,
describe it: reference looked up, not the text; Routh's book of 1905 is known to us, not looked up):

    m dv_Ct = dT,   m dv_Cn = dP,   J dω = arm_t dP − arm_n dT + dC,   v_t = v_Ct − ω arm_n,   v_n = v_Cn + ω arm_t.

Their right-hand sides are constant while slip and rotation keep their signs, so an integration in straight pieces is
exact.

Moreau's law uses only the sums T, P, C: the same equations once, with the velocities after the impact in Coulomb's
inequalities; if several phases agree, the most static one.
"""

from __future__ import annotations

from copy import copy
from math import inf
from typing import NamedTuple

from cases import CoulombFriction, Impact, PerfectlyRough

from .coulomb_law import ContactForces, admissible
from .equations import ContactPhase, ContactScene, Place, ratios

# Far more pieces than Coulomb's law allows: slip and rotation stop, reverse or stay, each at most once in compression
# and once in restitution.
MOST_PIECES = 20

# Newton's restitution is rejected if kinetic energy grows by more than rounding.
ENERGY_ROUNDING = 1e-12


# A moving phase may move against its direction by this much at the border to a static one: rounding.
AT_REST = 1e-12


class Rates(NamedTuple):
    """The changes of slip, normal velocity and spin per unit of normal impulse."""

    slip: float
    lift: float
    spin: float


class ImpactResult(NamedTuple):
    """Slip, normal velocity and spin after an impact, the last phase, and the relative change of kinetic energy."""

    slip: float
    lift: float
    spin: float
    phase: ContactPhase
    energy: float


class ImpactWithoutSolution(Exception):
    """No normal impulse ends the impact: Coulomb's law has no consistent solution."""


def hit(scene: ContactScene, effect: Impact, q: Place, slip: float, lift: float, spin: float) -> ImpactResult:
    """Compute the impact at a place with contact velocity (slip, lift < 0) and spin; raises ImpactWithoutSolution."""
    if (friction := scene.case.effect(CoulombFriction)) is not None:
        against, holds = map(float, friction.in_impact(slip))
        scene = copy(scene)
        scene.laws = scene.laws._replace(slip=against, stick=holds, by_speed=None)
    if effect.law == "moreau":
        return _whole(scene, q, slip, lift, spin, effect.restitution)
    impulse = _Impulse(scene, q, slip, lift, spin)
    before = impulse.energy()
    if scene.case.effect(PerfectlyRough):
        impulse.stop_slip_at_once()
    compression = impulse.push(until_lift=0.0)
    if effect.restitution > 0.0 and effect.law == "newton":
        impulse.push(until_lift=-effect.restitution * lift)
    elif effect.restitution > 0.0:
        impulse.push(amount=effect.restitution * compression)
    if impulse.lift < 0.0:
        raise ImpactWithoutSolution
    change = (impulse.energy() - before) / before if before > 0.0 else 0.0  # speeds whose squares underflow
    return ImpactResult(impulse.slip, impulse.lift, impulse.spin, impulse.phase, change)


def creates_energy(result: ImpactResult) -> bool:
    return result.energy > ENERGY_ROUNDING


def _whole(scene: ContactScene, q: Place, slip: float, lift: float, spin: float, restitution: float) -> ImpactResult:
    """Compute the impact by Moreau's law; raises ImpactWithoutSolution if no phase agrees."""
    m, J, at, an = scene.m, scene.J, q.arm_t, q.arm_n
    goal = -restitution * lift
    about = J + m * an * an  # inertia about the contact, for rotation without slip

    def forces_in(phase: ContactPhase) -> ContactForces:
        """The sums P, T, C in a phase, from the one condition v_n⁺ = goal."""
        by_slip, by_turn = ratios(scene.laws, phase)
        if phase.turn == 0:
            normal = m * (goal - lift + at * spin)
            friction = -m * (an * spin + slip) if phase.slip == 0 else by_slip * normal
            return ContactForces(normal, friction, an * friction - at * normal - (J * spin if spin else 0.0))
        if phase.slip == 0:
            lever = at + by_turn
            normal = (goal - lift - at * an * m * slip / about) / (1 / m + at * lever / about)
            spin_change = (lever * normal + an * m * slip) / about
            return ContactForces(normal, m * (an * spin_change - slip), by_turn * normal)
        lever = at - an * by_slip + by_turn
        per_impulse = 1 / m + at * lever / J
        normal = (goal - lift) / per_impulse if per_impulse > 0.0 else inf  # friction that wedges
        return ContactForces(normal, by_slip * normal, by_turn * normal)

    def as_result(slip_after: float, lift_after: float, spin_after: float, phase: ContactPhase) -> ImpactResult:
        before = _Impulse(scene, q, slip, lift, spin).energy()
        after = _Impulse(scene, q, slip_after, lift_after, spin_after).energy()
        return ImpactResult(
            slip_after, lift_after, spin_after, phase, (after - before) / before if before > 0.0 else 0.0
        )

    slips: tuple[int | None, ...] = (None,) if scene.laws.slip is None else (0, 1, -1)
    turns: tuple[int | None, ...] = (None,) if scene.laws.arm is None else (0,) if scene.laws.arm == inf else (0, 1, -1)
    if scene.laws.slip == inf:
        slips, impulse = (0,), _Impulse(scene, q, slip, lift, spin)
        impulse.stop_slip_at_once()
        if impulse.lift >= goal:  # no normal impulse is needed
            return as_result(0.0, impulse.lift, impulse.spin, ContactPhase(0, None))
    for phase in (ContactPhase(along, turn) for along in slips for turn in turns):
        forces = forces_in(phase)
        if not 0.0 < forces.normal < inf:
            continue
        spin_change = -spin if phase.turn == 0 else (at * forces.normal - an * forces.friction + forces.couple) / J
        along = 0.0 if phase.slip == 0 else slip + forces.friction / m - an * spin_change
        slips_so = _agrees(phase.slip, along, abs(slip), forces.friction, scene.laws.stick * forces.normal)
        if slips_so and _agrees(
            phase.turn, spin + spin_change, abs(spin), forces.couple, (scene.laws.arm or 0.0) * forces.normal
        ):
            return as_result(along, goal, spin + spin_change, phase)
    raise ImpactWithoutSolution


def _agrees(way: int | None, after: float, size: float, holds: float, bound: float) -> bool:
    """Whether a static direction (0) needs no more than the bound, and a moving one keeps its sign, except rounding."""
    if way == 0:
        return abs(holds) <= bound
    return way is None or way * after >= -AT_REST * (size + abs(after))


class _Impulse:
    """The velocities at a contact as they change with the normal impulse."""

    def __init__(self, scene: ContactScene, q: Place, slip: float, lift: float, spin: float):
        self.laws, self.m, self.J = scene.laws, scene.m, scene.J
        self.at, self.an = q.arm_t, q.arm_n
        self.slip, self.lift, self.spin = slip, lift, spin
        self.phase = self._phase()

    def energy(self) -> float:
        """Kinetic energy, J."""
        along, across = self.slip + self.spin * self.an, self.lift - self.spin * self.at
        turning = 0.5 * self.J * self.spin**2 if self.spin else 0.0  # the inertia may be infinite
        return 0.5 * self.m * (along**2 + across**2) + turning

    def push(self, amount: float = inf, until_lift: float = inf) -> float:
        """Add normal impulse, at most `amount`, until the normal velocity reaches `until_lift`; returns the impulse."""
        total = 0.0
        if self.lift >= until_lift:
            return total
        for _ in range(MOST_PIECES):
            self.phase = self._phase()
            rates = self._rates(self.phase)
            pieces = {
                "amount": amount - total,
                "lift": (until_lift - self.lift) / rates.lift if rates.lift > 0.0 else inf,
                "slip": -self.slip / rates.slip if self.phase.slip and self.slip * rates.slip < 0.0 else inf,
                "spin": -self.spin / rates.spin if self.phase.turn and self.spin * rates.spin < 0.0 else inf,
            }
            first = min(pieces, key=pieces.__getitem__)
            piece = pieces[first]
            if piece == inf:
                raise ImpactWithoutSolution
            total += piece
            self.slip += piece * rates.slip
            self.lift += piece * rates.lift
            self.spin += piece * rates.spin
            if first == "amount":
                return total
            if first == "lift":
                self.lift = until_lift
                return total
            setattr(self, first, 0.0)
        raise ImpactWithoutSolution

    def stop_slip_at_once(self) -> None:
        """Perfectly rough contact: a tangential impulse stops the slip before any normal impulse acts."""
        by_friction = Rates(1 / self.m + self.an**2 / self.J, -self.an * self.at / self.J, -self.an / self.J)
        impulse = -self.slip / by_friction.slip
        self.slip = 0.0
        self.lift += impulse * by_friction.lift
        self.spin += impulse * by_friction.spin

    def _phase(self) -> ContactPhase:
        """The phase in which the next part of the impulse acts, by Coulomb's inequalities for impulses."""
        phase = next(admissible(self.laws, self.slip, self.spin, self._forces_in), None)
        if phase is None:
            raise ImpactWithoutSolution
        return phase

    def _forces_in(self, phase: ContactPhase) -> ContactForces:
        """Friction and couple per normal impulse."""
        friction, couple = ratios(self.laws, phase)
        at, an, inertia = self.at, self.an, self.J / self.m
        if phase.turn == 0:
            # Without rotation only friction changes the slip, so zero slip needs none; the couple follows from ω̇ = 0.
            friction = 0.0 if phase.slip == 0 else friction
            couple = an * friction - at
        elif phase.slip == 0:
            friction = an * (at + couple) / (inertia + an * an)
        return ContactForces(1.0, friction, couple)

    def _rates(self, phase: ContactPhase) -> Rates:
        _, friction, couple = self._forces_in(phase)
        spin = 0.0 if phase.turn == 0 else (self.at - self.an * friction + couple) / self.J
        slip = 0.0 if phase.slip == 0 else friction / self.m - self.an * spin
        return Rates(slip, 1.0 / self.m + self.at * spin, spin)
