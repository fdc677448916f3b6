"""Impacts of several bodies at once: exact ones, and the complementarity problem of random ones."""

from math import sqrt
from types import SimpleNamespace

import numpy as np
import pytest

from cases import Impact
from reference.laws_check.contact_impulse import impulses_at_once
from reference.solver.impact import Inertia, NoImpact, impact_of_all
from reference.witness import complementarity
from tests.scenes.piles import ContactSystem, Pile, random_pile


class Touch:
    """What the law of impact needs of a contact."""

    def __init__(self, system: ContactSystem, k: int, restitution: float):
        self.lift_row, self.slip_row = system.rows[k], system.rows[len(system.mu) + k]
        self.restitution = restitution


def cradle(speeds, touching, restitution: float = 1.0, law: str = "moreau", mu: float = 0.0) -> np.ndarray:
    """Speeds after an impact of equal discs in a row at the contacts `touching`, (left, right) each."""
    # Contacts as of a body on the right of its base.
    discs = [(0.5, 1.0, float(i), 0.5, v, 0.0, 0.0) for i, v in enumerate(speeds)]
    system = Pile(discs, tuple(touching), (mu,) * len(touching)).frames()
    inertia = Inertia(np.tile([1.0, 1.0, 8.0], len(discs)), np.tile([1.0, 1.0, sqrt(0.125)], len(discs)))
    before = np.array([value for disc_ in discs for value in disc_[4:]])
    touched = [Touch(system, k, restitution) for k in range(len(touching))]
    return impact_of_all(law, inertia, before, touched, system.mu, 1.0).velocity.reshape(-1, 3)


def test_newtons_cradle_passes_its_momentum_on_by_pairs():
    """Discs a gap apart collide two at a time: the last one has all momentum and energy, for one and two at once."""
    for first, last in (((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)), ((1.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 1.0))):
        speeds, impacts = list(first), 0
        while any(a > b for a, b in zip(speeds, speeds[1:], strict=False)):
            i = max(i for i in range(3) if speeds[i] > speeds[i + 1])
            after = cradle(speeds, [(i, i + 1)])
            assert np.abs(after[:, 1:]).max() < 1e-14
            assert after[:, 0].sum() == pytest.approx(sum(speeds), abs=1e-15)
            speeds, impacts = np.round(after[:, 0], 15).tolist(), impacts + 1
        assert speeds == pytest.approx(last, abs=1e-14)
        assert impacts == (3 if sum(first) == 1.0 else 4)


@pytest.mark.parametrize("law", ["moreau", "newton", "poisson"])
def test_three_discs_that_touch_part_otherwise(law):
    """At once, e = 1: each contact rebounds as it closed (Newton, Moreau), or both impulses are doubled (Poisson).

    The first contact closes with 1 and opens with 1, the second stays closed: v = (−1/3, 2/3, 2/3). Momentum and energy
    are conserved, as they are by (0, 0, 1), which engines give that solve pair after pair."""
    after = cradle((1.0, 0.0, 0.0), [(0, 1), (1, 2)], law=law)[:, 0]
    assert after == pytest.approx([-1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0], abs=1e-12)
    assert (after.sum(), after @ after) == pytest.approx((1.0, 1.0), abs=1e-12)


def _compare_impacts(seeds) -> dict[str, int]:
    """Random impacts of a disc on a disc on the floor, with friction and two restitutions, by Moreau's law: enumeration
    and the complementarity problem. Returns how many have one solution, and how many of these stick or open somewhere.
    """
    counts = {"one": 0, "not one": 0, "sticks": 0, "opens": 0}
    for seed in seeds:
        numbers = np.random.default_rng(seed)
        pile = random_pile(seed)
        speeds = numbers.uniform(-1.0, 1.0, (2, 3)) * (1.0, 1.0, 4.0) - [[0.0, 1.0, 0.0], [0.0, 2.0, 0.0]]
        pile.states = [(*state[:3], *speed) for state, speed in zip(pile.states, speeds.tolist(), strict=True)]
        system, restitution = pile.frames(), numbers.uniform(0.0, 1.0, 2)
        lifts, slips = system.velocities[:2], system.velocities[2:]
        if lifts.max() >= 0.0:
            continue
        free = np.concatenate([(1.0 + restitution) * lifts, slips])
        impulses = complementarity.solutions(system.delassus, free, [None, None], system.mu, system.mu)
        inertia = Inertia(system.inverse, np.ones(6))
        touched = [Touch(system, k, float(e)) for k, e in enumerate(restitution)]
        try:
            outcome = impact_of_all("moreau", inertia, speeds.ravel(), touched, system.mu, float(np.abs(speeds).max()))
        except NoImpact:
            counts["not one"] += 1
            continue
        (impulse,) = impulses
        after = speeds.ravel() + system.inverse * (system.rows.T @ impulse)
        assert outcome.velocity == pytest.approx(after, abs=1e-9), seed
        counts["one"] += 1
        counts["sticks"] += bool((outcome.slip == 0.0).any())
        counts["opens"] += bool((impulse[:2] == 0.0).any())
    return counts


@pytest.mark.parametrize("number", [60, pytest.param(5000, marks=pytest.mark.slow)])
def test_impacts_of_two_bodies_with_friction_solve_the_complementarity_problem(number):
    counts = _compare_impacts(range(number))
    assert min(counts["one"], counts["sticks"]) > number // 2, counts
    assert counts["not one"] == 0 if number == 60 else counts["opens"] > 1, counts


def test_the_check_has_poisson_s_law_for_whole_impulses_as_the_solver():
    """At one contact of two free plates, of random arms, coefficients and velocities: by enumeration in each."""
    numbers = np.random.default_rng(5)
    for _ in range(300):
        rows = np.array([[1.0, 0.0, numbers.uniform(-1, 1)], [0.0, 1.0, numbers.uniform(-1, 1)]])
        inverse, before = np.array([1.0, 1.0, numbers.uniform(0.2, 8.0)]), numbers.uniform(-1.0, 1.0, 3)
        before[1] -= 3.0  # it approaches
        mu, e = numbers.uniform(0.0, 1.5), numbers.uniform(0.0, 1.0)
        at = SimpleNamespace(sides=(0,), turning_row=np.eye(3)[2], lift_row=rows[1], slip_row=rows[0], restitution=e)
        inertia = Inertia(inverse, np.ones(3))
        after = impact_of_all("poisson", inertia, before, [at], [mu], 5.0).velocity
        impulses = impulses_at_once(rows * inverse @ rows.T, rows @ before, mu, mu, Impact(e, "poisson"))
        off = [float(np.abs(after - before - inverse * (np.array(one) @ rows)).max()) for one in impulses]
        assert min(off) < 1e-12
