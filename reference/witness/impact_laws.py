"""Velocities after an impact at one contact or several, by the laws of Newton, Poisson and Moreau.

One contact alone is hit as in `impact`; the first formulation's laws are in `minimal.impact`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cases import Impact

from .complementarity import MOVES, refine_solution, solutions
from .contacts import ROUGH, PairState, PlateDynamics, frictions, surfaces
from .equations import ContactScene
from .impact import ImpactWithoutSolution, creates_energy, hit
from .plate_state import PlateState, SimulationEnd


def velocities(state: PlateState, effect: Impact, some: Sequence[PairState]) -> tuple[np.ndarray, list[bool]]:
    """Velocities after an impact of contacts that share plates, and which of them do not slip: by Routh's construction
    where one plate touches what is fixed in one place, else by the law for whole impulses."""
    velocity, laws = state.body[state.half :], [pair.contact.effect(Impact) for pair in some]
    restitution = np.array([law.restitution if law else 0.0 for law in laws])
    own, base = some[0].sides
    if len(some) == 1 and base is None:
        law, plate = laws[0], slice(3 * own, 3 * own + 3)
        assert law is not None
        pair, scene = some[0], ContactScene(some[0].contact)
        q = scene.place(pair.xi1, pair.xi2)
        try:
            result = hit(scene, law, q, pair.slip, pair.lift, float(velocity[plate][2]))
        except ImpactWithoutSolution:
            raise SimulationEnd("paradox") from None
        if effect.law == "newton" and creates_energy(result):
            raise SimulationEnd("energy_gain")
        rows = np.array([pair.slip_row[plate], pair.lift_row[plate], [0.0, 0.0, 1.0]])
        after = velocity.copy()
        after[plate] = np.linalg.solve(rows, [result.slip + pair.surface, result.lift, result.spin])
        return after, [result.slip == 0.0]
    return by_whole_impulses(state, effect, some, restitution)


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
    answers = solutions(delassus, free, [None] * len(mu), mu, mu, least)
    if len(answers) != 1:
        raise SimulationEnd("not_unique")
    force = answers[0] if mu.max() < ROUGH or least.any() else refine_solution(delassus, free, answers[0], mu)
    return velocity + dynamics.inverse * (rows.T @ force), force[: len(some)]
