"""Velocities after an impact at one contact or several, by the laws of Newton, Poisson and Moreau.

One plate that touches what is fixed in one place is hit by Routh's construction: the impulse equations integrated along
the normal impulse, piece by piece. Velocity of the contact point (v_t, v_n) and spin ω obey, per normal impulse P (as
Wang & Mason, J. Appl. Mech. 59, 1992, 635, describe it: reference looked up, not the text; Routh's book of 1905 is
known to us, not looked up):

    m dv_Ct = dT,   m dv_Cn = dP,   J dω = arm_t dP − arm_n dT + dC,   v_t = v_Ct − ω arm_n,   v_n = v_Cn + ω arm_t.

Their right-hand sides are constant while slip and rotation keep their signs, so an integration in straight pieces is
exact. Elsewhere, and by Moreau's law everywhere, Coulomb's law holds between the sums of impulses and the velocities
after the impact. The first formulation's laws are in `minimal.impact`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import inf
from typing import NamedTuple

import numpy as np

from cases import Case, CoulombFriction, Impact

from .complementarity import MOVES, pressing_forces, refine_solution, solutions
from .contacts import ROUGH, PairState, PlateDynamics, frictions, is_rough, resisting_arm, surfaces
from .plate_state import PlateState, SimulationEnd

# Far more pieces than Coulomb's law allows: slip and rotation stop, reverse or stay, each at most once in compression
# and once in restitution.
MOST_PIECES = 20
# Newton's restitution is rejected if kinetic energy grows by more than rounding.
ENERGY_ROUNDING = 1e-12
# Friction may exceed its bound by this part of the normal impulse: both are results of some tens of rounded operations.
AT_BOUND = 64 * float(np.finfo(float).eps)


def velocities(state: PlateState, effect: Impact, some: Sequence[PairState]) -> tuple[np.ndarray, list[bool]]:
    """Velocities after an impact of contacts that share plates, and which of them do not slip: by Routh's construction
    where one plate touches what is fixed in one place, else by the law for whole impulses."""
    velocity, laws = state.body[state.half :], [pair.contact.effect(Impact) for pair in some]
    restitution = np.array([law.restitution if law else 0.0 for law in laws])
    own, base = some[0].sides
    if len(some) != 1 or base is not None:
        return by_whole_impulses(state, effect, some, restitution)
    pair, plate = some[0], slice(3 * own, 3 * own + 3)
    impulse = Impulse(pair, float(velocity[plate][2]))
    before = impulse.energy()
    if effect.law == "moreau":
        goal = -float(restitution[0]) * impulse.lift
        impulse.stop_slip_at_once()
        if impulse.lift < goal:  # otherwise no normal impulse is needed
            return by_whole_impulses(state, effect, some, restitution)
    else:
        impulse.act(effect, float(restitution[0]))
    if effect.law == "newton" and impulse.energy() > (1.0 + ENERGY_ROUNDING) * before:
        raise SimulationEnd("energy_gain")
    rows = np.array([pair.slip_row[plate], pair.lift_row[plate], [0.0, 0.0, 1.0]])
    after = velocity.copy()
    after[plate] = np.linalg.solve(rows, [impulse.slip + pair.surface, impulse.lift, impulse.spin])
    return after, [impulse.slip == 0.0]


class ImpactSense(NamedTuple):
    """Directions of slip and rotation (±1), 0 if they are kept at zero, None if nothing opposes them."""

    slip: int | None
    turn: int | None


class Impulse:
    """The velocities at a contact as they change with the normal impulse."""

    def __init__(self, pair: PairState, spin: float):
        plate, (self.against, self.holds) = pair.contact.plate, _frictions(pair.contact, pair.slip)
        self.m, self.J = plate.mass, plate.inertia
        own = 3 * pair.sides[0] + 2
        self.at, self.an = float(pair.lift_row[own]), -float(pair.slip_row[own])
        arm = resisting_arm(pair.contact)
        self.arm = inf if not plate.turns else arm or None
        self.is_rough = is_rough(pair.contact)
        self.slip, self.lift, self.spin = pair.slip, min(pair.lift, 0.0), spin

    def act(self, effect: Impact, restitution: float) -> None:
        """Compression, and restitution by Newton's or Poisson's law. Raises SimulationEnd."""
        goal = -restitution * self.lift
        self.stop_slip_at_once()
        compression = self.push(until_lift=0.0)
        if restitution > 0.0 and effect.law == "newton":
            self.push(until_lift=goal)
        elif restitution > 0.0:
            self.push(amount=restitution * compression)
        if self.lift < 0.0:
            raise SimulationEnd("paradox")

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
            sense = next(self.senses(), None)
            if sense is None:
                break
            slip, lift, spin = self.rates(sense)
            pieces = {
                "amount": amount - total,
                "lift": (until_lift - self.lift) / lift if lift > 0.0 else inf,
                "slip": -self.slip / slip if sense.slip and self.slip * slip < 0.0 else inf,
                "spin": -self.spin / spin if sense.turn and self.spin * spin < 0.0 else inf,
            }
            first = min(pieces, key=pieces.__getitem__)
            piece = pieces[first]
            if piece == inf:
                break
            total += piece
            self.slip, self.lift, self.spin = (
                self.slip + piece * slip,
                self.lift + piece * lift,
                self.spin + piece * spin,
            )
            if first == "amount":
                return total
            if first == "lift":
                self.lift = until_lift
                return total
            setattr(self, first, 0.0)
        raise SimulationEnd("paradox")

    def stop_slip_at_once(self) -> None:
        """A perfectly rough contact: a tangential impulse stops the slip before any normal impulse acts."""
        if not self.is_rough:
            return
        impulse = -self.slip / (1 / self.m + self.an**2 / self.J)
        self.slip, self.lift = 0.0, self.lift - impulse * self.an * self.at / self.J
        self.spin -= impulse * self.an / self.J

    def senses(self) -> Iterator[ImpactSense]:
        """Senses in which the next part of the impulse may act by Coulomb's inequalities, the most static ones first: a
        zero slip or spin stays zero while the force needed for that is within its bound; otherwise it begins against
        that force."""
        for slip in _options(self.against, self.slip):
            for turn in _options(self.arm, self.spin):
                friction, couple = self.forces(ImpactSense(0, turn))[0], self.forces(ImpactSense(slip, 0))[1]
                if self.slip == 0.0 and not _is_right(slip, friction, self.holds):
                    continue
                if self.spin == 0.0 and not _is_right(turn, couple, self.arm or 0.0):
                    continue
                yield ImpactSense(slip, turn)

    def forces(self, sense: ImpactSense) -> tuple[float, float]:
        """Friction and couple per normal impulse."""
        friction = -sense.slip * self.against if sense.slip and self.against else 0.0
        couple = -sense.turn * self.arm if sense.turn and self.arm else 0.0
        if sense.turn == 0:
            # Without rotation only friction changes the slip, so zero slip needs none; the couple follows from ω̇ = 0.
            friction = 0.0 if sense.slip == 0 else friction
            couple = self.an * friction - self.at
        elif sense.slip == 0:
            friction = self.an * (self.at + couple) / (self.J / self.m + self.an * self.an)
        return friction, couple

    def rates(self, sense: ImpactSense) -> tuple[float, float, float]:
        """The changes of slip, normal velocity and spin per unit of normal impulse."""
        friction, couple = self.forces(sense)
        spin = 0.0 if sense.turn == 0 else (self.at - self.an * friction + couple) / self.J
        slip = 0.0 if sense.slip == 0 else friction / self.m - self.an * spin
        return slip, 1.0 / self.m + self.at * spin, spin


def _frictions(contact: Case, slip: float) -> tuple[float | None, float]:
    """The coefficients against slip and without it of an impact that begins at a slip velocity; None: no friction."""
    if is_rough(contact):
        return inf, inf
    friction = contact.effect(CoulombFriction)
    if friction is None:
        return None, 0.0
    against, holds = friction.in_impact(slip)
    return float(against), float(holds)


def _options(law: float | None, velocity: float) -> tuple[int | None, ...]:
    if law is None:
        return (None,)
    if law == inf:
        return (0,)
    return (0, 1, -1) if velocity == 0.0 else (1,) if velocity > 0.0 else (-1,)


def _is_right(way: int | None, force: float, bound: float) -> bool:
    """Whether a velocity that is zero stays so (0), or begins that way, by the force that would hold it."""
    too_much = abs(force) > bound * (1.0 + AT_BOUND)
    return way is None or (not too_much if way == 0 else too_much and way * force <= 0.0)


def by_whole_impulses(
    state: PlateState, effect: Impact, some: Sequence[PairState], restitution: np.ndarray
) -> tuple[np.ndarray, list[bool]]:
    """As `velocities`, by Coulomb's law between whole impulses and velocities after the impact."""
    velocity = state.body[state.half :]
    if effect.law != "poisson":
        after, _ = complementary(state.dynamics, velocity, some, restitution, np.zeros(len(some)))
    else:
        nothing = np.zeros(len(some))
        after, impulses = complementary(state.dynamics, velocity, some, nothing, nothing)
        if restitution.any():
            after, _ = complementary(state.dynamics, after, some, nothing, restitution * impulses)
    mu, _ = frictions(some)
    still = np.abs([float(pair.slip_row @ after) - pair.surface for pair in some]) <= MOVES * state.speed
    slips = [bool(is_still) and mu[i] > 0.0 for i, is_still in enumerate(still)]
    return after, slips


def complementary(
    dynamics: PlateDynamics,
    velocity: np.ndarray,
    some: Sequence[PairState],
    restitution: np.ndarray,
    least: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Velocities and normal impulses of Coulomb's law between impulses and velocities after the impact."""
    delassus, rows = dynamics.delassus(some)
    before = rows @ velocity - surfaces(some)
    free = before + np.concatenate([restitution * before[: len(some)], np.zeros(len(before) - len(some))])
    mu, _ = frictions(some)
    bounds = [mu]
    if len(some) == 1:  # static friction holds it, or its slip has the coefficient of slip
        bounds = [np.append(_frictions(some[0].contact, some[0].slip)[1], mu[1:]), mu] if mu[0] < ROUGH else bounds
    if len(some) == 1 and mu[0] >= ROUGH and not least.any():
        pressure = pressing_forces(delassus, free, [None] * (len(mu) - 1), mu[1:])
        if len(pressure) == 1:
            return velocity + dynamics.inverse * (rows.T @ pressure[0]), pressure[0][:1]
    for bound in bounds:
        answers = solutions(delassus, free, [None] * len(mu), mu, bound, least)
        if len(answers) != 1:
            raise SimulationEnd("not_unique")
        slip = abs(float((delassus @ answers[0] + free)[len(some)]))
        if slip <= MOVES * float(np.abs(free).max()):
            break
    force = answers[0] if mu.max() < ROUGH or least.any() else refine_solution(delassus, free, answers[0], mu)
    return velocity + dynamics.inverse * (rows.T @ force), force[: len(some)]
