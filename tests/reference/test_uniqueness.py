"""The map of uniqueness: counts against a complementarity problem of two contacts, and boundaries that are exact."""

from itertools import product
from math import atan, cos, pi, sin, sqrt

import numpy as np
import pytest

import cases
from cases import (
    Case,
    CoulombFriction,
    Flight,
    Gravity,
    Impact,
    Mode,
    StartPose,
    Support,
    Unilateral,
    disc,
)
from cases.library import line
from reference.solver.decide import motions_in
from tests.benchmarks.uniqueness import BOTH, FLOOR, count, locking_mu, painleve_mu, sliding_rod, wall_mu
from tests.sampling import quick_every


def complementary_solutions(scene: str, spin: float, mu: float, theta: float) -> int:
    """Solutions of w = M z + q, w ≥ 0, z ≥ 0, wᵀ z = 0 for a rod of half length, mass and gravity 1 that slides, one
    for each of the 2ⁿ choices of zeros: z are the normal forces, w the accelerations of the ends from the supports."""
    s, c = sin(theta), cos(theta)
    # Normal force N_A at (c, −s) along y with friction −μ N_A along x; N_B at (−c, s) along x, with μ N_B along y.
    push = np.array([[-mu, 1.0, c - mu * s], [1.0, mu, -s - mu * c]])
    away = np.array([[0.0, 1.0, c], [1.0, 0.0, -s]])  # rows of the ends' velocities along the normals
    compliance = np.array([1.0, 1.0, 3.0])
    matrix = away @ (compliance[:, None] * push.T)
    right = np.array([spin * s - 1.0, spin * c])
    if scene == FLOOR:
        matrix, right = matrix[:1, :1], right[:1]
    solutions = 0
    for chosen in product((False, True), repeat=len(right)):
        on = np.flatnonzero(chosen)
        z = np.zeros(len(right))
        z[on] = np.linalg.solve(matrix[np.ix_(on, on)], -right[on])
        solutions += bool((z >= 0.0).all() and (np.delete(matrix @ z + right, on) >= 0.0).all())
    return solutions


def test_counts_are_those_of_a_complementarity_problem():
    numbers, counts = np.random.default_rng(1), []
    for scene in (FLOOR, BOTH):
        for _ in range(12):
            spin, mu = float(numbers.uniform(0.0, 3.0)), float(numbers.uniform(0.1, 3.0))
            angles = numbers.uniform(0.05, 0.5 * pi - 0.05, 5).tolist()
            for row in count(scene, spin, [mu], angles):
                assert len(row.motions) == complementary_solutions(*row[:4]), row
                counts.append(len(row.motions))
    assert min(counts.count(n) for n in (0, 1, 2)) > 5


def test_known_values_of_the_boundaries():
    assert painleve_mu(np.array(atan(2.0))) == pytest.approx(4.0 / 3.0, rel=1e-15)  # its least value
    assert (painleve_mu(np.linspace(0.05, 1.5, 999)) >= 4.0 / 3.0 - 1e-15).all()
    assert locking_mu(np.array(1.0)) == pytest.approx(sqrt(2.0))
    # Without friction Ω = (3/2) (sin θ₀ − sin θ) by the energy, and the wall's force vanishes at sin θ = (2/3) sin θ₀.
    start = sin(1.2)
    leaves = np.arcsin(2.0 / 3.0 * start)
    assert wall_mu(leaves - 1e-9, 1.5 * (start - sin(leaves))) == pytest.approx(0.0, abs=1e-8)


@quick_every(3)
@pytest.mark.parametrize("mu", [0.2, 0.9, 1.6, 3.0])
def test_a_rod_at_rest_has_one_motion_and_is_held_as_in_statics(mu):
    """Equal coefficients hold a homogeneous rod if tan θ ≥ (1 − μ²)/(2 μ)."""
    case = cases.load("ladder_at_wall", mu=mu, mu_wall=mu)
    for theta in np.linspace(0.2, 1.4, 7).tolist():
        (modes,) = motions_in(case, sliding_rod(BOTH, 0.0, theta))
        held = set(modes.values()) == {Mode.ROLL}
        assert held == (np.tan(theta) >= (1.0 - mu * mu) / (2.0 * mu)), theta


def test_a_motion_has_the_names_of_the_most_contacts():
    """Of a disc at rest in a corner the wall's force is zero: without its contact the motion is the same one."""
    wall = Support(line(pi / 2), "wall", (CoulombFriction(0.3),))
    effects = Gravity(9.81), Unilateral(), Flight(), Impact(0.0, "moreau"), CoulombFriction(0.3)
    case = Case(line(), disc(0.5, 1.0), effects, StartPose(0.5, 0.5), 1.0, supports=(wall,))
    assert motions_in(case, (0.5, 0.5, 0.0, 0.0, 0.0, 0.0)) == [{"plate/track": Mode.ROLL, "plate/wall": Mode.ROLL}]
