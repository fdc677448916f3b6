"""Scenes on supports: random ones, and their motions compared in two formulations and with the paper's matrix."""

from collections.abc import Iterable
from dataclasses import replace
from functools import lru_cache
from math import pi

import numpy as np
import pytest

import reference
from cases import (
    Case,
    CoulombFriction,
    Curve,
    Flight,
    Gravity,
    Impact,
    Mode,
    Outline,
    Plate,
    StartPose,
    Support,
    Unilateral,
    disc,
)  # fmt: skip
from cases.curves import cos as cosine
from cases.curves import sin as sine
from cases.library import line
from reference.certification.witnesses import _by_second
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


def agree(case: Case, within: float = 1e-11) -> int:
    """Compare both formulations' whole sequences, and the laws where the second one ends; returns the number of changes
    that both have, or raises AssertionError."""
    motion, second = simulated(case), _by_second(case, "second", 1e-13)
    changes, count = events(motion), len(motion.transitions)
    if second.status == "breakdown":  # where two contacts hold one point of the plate, the first formulation goes on
        assert not reference.check(case, motion)
        count = len(second.transitions)
    else:
        assert second.status == motion.status
    assert events(second) == changes[:count]
    for one, other in zip(motion.transitions[:count], second.transitions, strict=True):
        assert abs(one.time - other.time) < within
    return count


def random_case(seed: int) -> Case:
    """A rod, block or disc on a plane and a wall, tilted, thrown or let go, with random friction."""
    numbers = np.random.default_rng(seed)
    kind = int(numbers.integers(3))
    plate = (
        disc(0.3, 1.0), Plate.rectangle(*numbers.uniform(0.2, 0.8, 2), 1.0),
        Plate(Outline.polygon([(-0.5, -0.01), (0.5, -0.01), (0.5, 0.0), (-0.5, 0.0)]), 1.0, 1.0 / 12.0),
    )[kind]  # fmt: skip
    slope, lean = numbers.uniform(-0.4, 0.4), numbers.uniform(-0.3, 0.3)
    frictions = [(CoulombFriction(mu),) if mu > 0.15 else () for mu in numbers.uniform(0.0, 1.2, 2).tolist()]
    wall = Support(line(pi / 2 + lean), "wall", frictions[1])
    theta, omega = numbers.uniform(-3.0, 3.0), numbers.uniform(-4.0, 4.0)
    vx, vy = numbers.uniform(-3.0, 1.0, 2).tolist()
    start = StartPose(1.2, 1.2, float(theta), vx, vy, float(omega))
    return Case(line(slope), plate, (*INELASTIC, *frictions[0]), start, 1.2, supports=(wall,))


def with_restitution(case: Case, e: float, law: str = "moreau") -> Case:
    """A case with other restitution."""
    effects = (Impact(e, law) if isinstance(effect, Impact) else effect for effect in case.effects)
    return replace(case, effects=tuple(effects))


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
