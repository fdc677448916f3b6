"""Velocities after an impact at one contact or several, by the laws of Newton, Poisson and Moreau.

One plate that touches what is fixed in one place is hit by Routh's construction: the impulse equations integrated along
the normal impulse P, piece by piece (as Wang & Mason, J. Appl. Mech. 59, 1992, 635, describe it: reference looked up,
not the text; Routh's book of 1905 is known to us, not looked up). The velocities of lift, slip and rotation change by
the Delassus matrix times (dP, dT, dC), where friction T and couple C per normal impulse are constant while slip and
rotation keep their signs, so an integration in straight pieces is exact. Elsewhere, and by Moreau's law everywhere,
Coulomb's law holds between the sums of impulses and the velocities after the impact. The first formulation's laws are
in `minimal.impact`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from math import inf

import numpy as np

from cases import Case, CoulombFriction, Impact

from .complementarity import MOVES, pressing_forces, refine_solution, solutions
from .contacts import ROUGH, PairState, PlateDynamics, frictions, is_rough, resisting_arm, surfaces
from .plate_state import PlateState, SimulationEnd

# Far more pieces than Coulomb's law allows: slip and rotation stop, reverse or stay, each at most once in compression
# and once in restitution.
MOST_PIECES = 20
# Friction may exceed its bound by this part of the normal impulse: both are results of some tens of rounded operations.
AT_BOUND = 64 * float(np.finfo(float).eps)


def velocities(state: PlateState, effect: Impact, some: Sequence[PairState]) -> tuple[np.ndarray, list[bool]]:
    """Velocities after an impact of contacts that share plates, and which of them do not slip: by Routh's construction
    where one plate touches what is fixed in one place, else by the law for whole impulses."""
    laws = [pair.contact.effect(Impact) for pair in some]
    # A contact that opens before the impact has nothing to give back.
    is_opening = [one.lift > MOVES * state.speed for one in some]
    restitution = np.where(is_opening, 0.0, [law.restitution if law else 0.0 for law in laws])
    if len(some) != 1 or some[0].sides[1] is not None:
        return by_whole_impulses(state, effect, some, restitution)
    impulse = Impulse(state, some[0])
    goal = -float(restitution[0]) * impulse.rates[0]
    if impulse.is_rough:  # a tangential impulse stops the slip before any normal impulse acts
        along = np.eye(len(impulse.rates))[1]
        impulse.add(-impulse.rates[1] / impulse.delassus[1, 1], along, impulse.delassus @ along)
        impulse.rates[1] = 0.0
    if effect.law == "moreau":
        if impulse.rates[0] < goal:  # otherwise no normal impulse is needed
            return by_whole_impulses(state, effect, some, restitution)
    else:
        compression = impulse.push(until_lift=0.0)
        if effect.law == "newton" and goal > 0.0:
            impulse.push(until_lift=goal)
        elif effect.law == "poisson":
            impulse.push(amount=float(restitution[0]) * compression)
        if impulse.rates[0] < 0.0:
            raise SimulationEnd("paradox")
    after = state.body[state.half :] + state.dynamics.inverse * (impulse.sum @ impulse.rows)
    return after, [impulse.rates[1] == 0.0]


class Impulse:
    """The velocities of lift, slip and, where it is resisted, rotation (`rates`, m/s) at a contact as they change with
    the impulse, and the `sum` of the impulses along them, N s."""

    def __init__(self, state: PlateState, pair: PairState):
        self.delassus, self.rows = state.dynamics.delassus([pair])
        arm = resisting_arm(pair.contact) / pair.contact.plate.gyration if pair.contact.plate.turns else 0.0
        self.laws = [_frictions(pair.contact, pair.slip), *([(arm, arm)] if arm else [])]
        if not arm:
            self.delassus, self.rows = self.delassus[:2, :2], self.rows[:2]
        self.rates = self.rows @ state.body[state.half :]
        self.rates[:2] = min(pair.lift, 0.0), pair.slip
        self.sum, self.is_rough = np.zeros(len(self.rates)), is_rough(pair.contact)

    def add(self, amount: float, force: np.ndarray, change: np.ndarray) -> None:
        """Add so much of an impulse, and its change of the velocities."""
        self.sum, self.rates = self.sum + amount * force, self.rates + amount * change

    def push(self, amount: float = inf, until_lift: float = inf) -> float:
        """Add normal impulse, at most `amount`, until the normal velocity reaches `until_lift`; returns the impulse.
        Raises SimulationEnd."""
        total = 0.0
        if self.rates[0] >= until_lift or amount == 0.0:
            return total
        for _ in range(MOST_PIECES):
            ways = next(self.ways(), None)
            if ways is None:
                break
            force = self.force(ways)
            change = self.delassus @ force * [True, *(way != 0 for way in ways)]
            goals = [until_lift, *([0.0] * len(self.laws))]
            comes = [change[0] > 0.0, *(self.rates[1:] * change[1:] < 0.0)]
            pieces = [(g - v) / c if it else inf for g, v, c, it in zip(goals, self.rates, change, comes, strict=True)]
            rest = amount - total
            piece = min(*pieces, rest)
            if piece == inf:
                break
            self.add(piece, force, change)
            total += piece
            if piece == rest:
                return total
            first = pieces.index(piece)
            self.rates[first] = goals[first]
            if first == 0:
                return total
        raise SimulationEnd("paradox")

    def ways(self) -> Iterator[tuple[int, ...]]:
        """Senses of slip and rotation in which the next part may act by Coulomb's inequalities, the most static ones
        first: a zero velocity stays zero while the force needed for that is within its bound; otherwise it begins
        against that force."""
        options = [_options(slips, velocity) for (slips, _), velocity in zip(self.laws, self.rates[1:], strict=True)]
        for ways in product(*options):
            for i, (way, (_, bound)) in enumerate(zip(ways, self.laws, strict=True)):
                needed = self.force([0 if k == i else other for k, other in enumerate(ways)])[i + 1]
                if self.rates[i + 1] == 0.0 and not _is_right(way, needed, bound):
                    break
            else:
                yield ways

    def force(self, ways: Sequence[int]) -> np.ndarray:
        """The force per normal impulse for senses of slip and rotation (±1), of which those that are 0 are kept."""
        still = [i for i, way in enumerate(ways, 1) if way == 0]
        force = np.array([1.0, *(-way * law[0] if way else 0.0 for way, law in zip(ways, self.laws, strict=True))])
        if still:
            force[still] = -np.linalg.solve(self.delassus[np.ix_(still, still)], self.delassus[still] @ force)
        return force


def _frictions(contact: Case, slip: float) -> tuple[float, float]:
    """The coefficients against slip and without it of an impact that begins at a slip velocity."""
    if is_rough(contact):
        return inf, inf
    friction = contact.effect(CoulombFriction)
    against, holds = friction.in_impact(slip) if friction else (0.0, 0.0)
    return float(against), float(holds)


def _options(law: float, velocity: float) -> tuple[int, ...]:
    return (0,) if law == inf else (0, 1, -1) if velocity == 0.0 else (1,) if velocity > 0.0 else (-1,)


def _is_right(way: int, force: float, bound: float) -> bool:
    """Whether a velocity that is zero stays so (0), or begins that way, by the force that would hold it."""
    too_much = abs(force) > bound * (1.0 + AT_BOUND)
    return not too_much if way == 0 else too_much and way * force <= 0.0


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
