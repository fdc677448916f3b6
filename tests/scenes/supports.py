"""Scenes on supports: random ones, and their motions compared in two formulations and with the paper's matrix."""

from collections.abc import Iterable
from functools import lru_cache

import numpy as np
import pytest

import reference
from cases import (
    Case,
    Curve,
    Flight,
    Gravity,
    Impact,
    Mode,
    Unilateral,
)  # fmt: skip
from cases.curves import cos as cosine
from cases.curves import sin as sine
from reference.paper.bodies import BodyContact, solve_bodies
from reference.solver.regimes import SolverPhase, pair_of, regime_of

G = 9.81
FREE = Gravity(G), Unilateral(), Flight()
INELASTIC = (*FREE, Impact(0.0, "moreau"))


def hill(radius: float, x: float, y: float) -> Curve:
    """The outside of a circle."""
    return Curve(lambda s: (x + radius * sine(s), y + radius * cosine(s)))


def bowl(radius: float, x: float, y: float) -> Curve:
    """The inside of a circle."""
    return Curve(lambda s: (x + radius * cosine(s), y + radius * sine(s)))


def events(motion) -> list[tuple]:
    return [(t.contact, t.before, t.after) for t in motion.transitions]


def slow(*values):
    """Parameters of the slow tests; the quick ones run a sample."""
    return [pytest.param(value, marks=pytest.mark.slow) for value in values]


@lru_cache(maxsize=8)
def simulated(case: Case):
    """The motion at the finest tolerance, computed once for tests of the same scene."""
    return reference.simulate(case, rtol=1e-14)


def compare_with_matrix(scenes: Iterable[Case]) -> list[list[Mode]]:
    """Compare accelerations and forces in each phase with the paper's matrix; returns the modes of the closed contacts
    of each phase that was compared: where forces are not unique, the matrix is singular."""
    compared = []
    for case in scenes:
        for segment in simulated(case).dense._segments:
            regime = regime_of(segment.phase) if isinstance(segment.phase, SolverPhase) else None
            if regime is None or regime.resting or regime.guides or any(k is not None for k in regime.shares):
                continue
            closed = [k for k, mode in enumerate(regime.modes) if mode is not Mode.FLIGHT]
            if not closed:
                continue
            t = 0.5 * (segment.start + segment.event.time)
            y = segment.states(np.array([t]))[:, 0]
            rates = segment.phase.system.rates_of_numbers(t, tuple(y), segment.phase.parameters)
            outputs = segment.phase.system.outputs_of_numbers(t, tuple(y), segment.phase.parameters)
            states = [(*y[3 + 2 * k : 5 + 2 * k], *rates[3 + 2 * k : 5 + 2 * k]) for k in closed]
            contacts, modes = [pair_of(case, regime.pairs[k]) for k in closed], [regime.modes[k] for k in closed]
            paper = solve_bodies([case], list(map(BodyContact, contacts, modes, states)), [(t, *y[:3], *y[-3:])])
            assert paper.q1_ddot[0] == pytest.approx(rates[-3:], rel=1e-9, abs=1e-9)
            for i, k in enumerate(closed):
                forces = outputs[5 + 4 * k : 7 + 4 * k]
                assert (paper.normal_force[i], paper.friction_force[i]) == pytest.approx(forces, rel=1e-9, abs=1e-9)
            compared.append(modes)
    return compared
