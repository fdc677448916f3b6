"""Several bodies: the paper's matrix and Coulomb's law in the contacts' frames, at instants with exact answers.

Discs of radius r; the angle φ of a contact is that of the line of centres from the vertical, to the right.
"""

from itertools import product
from math import cos, inf, sin, sqrt

import numpy as np
import pytest

from cases import Mode
from reference.witness import complementarity
from tests.scenes.piles import BOTH, STILL, ContactSystem, G, Pile, on_top, random_pile

# --- two discs --------------------------------------------------------------------------------------------------------


def test_two_discs_that_do_not_slip_have_lagranges_accelerations():
    """Lagrange's equations for (x of the lower disc, φ) at rest, M q̈ = −∂V/∂q, with the spins that rolling gives."""
    phi, (r1, r2), (m1, m2) = 0.4, (0.5, 0.4), (1.5, 0.7)
    far = r1 + r2
    # Velocities by (ẋ, φ̇): the points that touch have equal velocities along the tangent (cos φ, −sin φ).
    # lower: ẋ cos φ − ω₁ r₁; upper: ẋ cos φ + L φ̇ + ω₂ r₂.
    spin1 = np.array([-1.0 / r1, 0.0])
    spin2 = (-spin1 * r1 - np.array([0.0, far])) / r2
    columns = np.array([[1.0, far * cos(phi)], [0.0, -far * sin(phi)]])
    mass = np.diag([m1, 0.0]) + m2 * columns.T @ columns
    mass += 0.5 * m1 * r1**2 * np.outer(spin1, spin1) + 0.5 * m2 * r2**2 * np.outer(spin2, spin2)
    x_ddot, phi_ddot = np.linalg.solve(mass, [0.0, m2 * G * far * sin(phi)])
    expected = np.array(
        [
            [x_ddot, 0.0, spin1 @ (x_ddot, phi_ddot)],
            [x_ddot + far * cos(phi) * phi_ddot, -far * sin(phi) * phi_ddot, spin2 @ (x_ddot, phi_ddot)],
        ]
    )
    pile = Pile(on_top(phi, masses=(m1, m2)), BOTH, (2.0, 2.0))
    solution = pile.literal((Mode.ROLL, Mode.ROLL))
    assert solution.q1_ddot == pytest.approx(expected, rel=1e-12, abs=1e-12)
    system = pile.frames()
    (force,) = complementarity.solutions(*_problem(system))
    assert system.accelerations(force) == pytest.approx(expected, rel=1e-11, abs=1e-11)


def test_a_disc_that_rolls_on_a_free_hemisphere_has_lagranges_accelerations():
    """The hemisphere slides on the floor and does not turn: a disc of infinite inertia. From rest, per unit of m₂:
    (m₁ + m₂) ẍ + m₂ L cos φ φ̈ = 0 and L cos φ ẍ + (3/2) L² φ̈ = g L sin φ, as r₂ ω₂ = −L φ̇ for one that rolls."""
    phi, (r1, r2), (m1, m2) = 0.6, (0.5, 0.4), (2.0, 0.8)
    far = r1 + r2
    matrix = np.array([[m1 + m2, m2 * far * cos(phi)], [far * cos(phi), 1.5 * far**2]])
    x_ddot, phi_ddot = np.linalg.solve(matrix, [0.0, G * far * sin(phi)])
    expected = np.array(
        [
            [x_ddot, 0.0, 0.0],
            [x_ddot + far * cos(phi) * phi_ddot, -far * sin(phi) * phi_ddot, -far * phi_ddot / r2],
        ]
    )
    pile = Pile(on_top(phi, masses=(m1, m2)), BOTH, (0.0, 2.0), inertias=(inf, None))
    assert pile.literal((Mode.SLIDE, Mode.ROLL)).q1_ddot == pytest.approx(expected, rel=1e-12, abs=1e-12)
    system = pile.frames()
    (force,) = complementarity.solutions(*_problem(system))
    assert system.accelerations(force) == pytest.approx(expected, rel=1e-11, abs=1e-11)


# --- a pile -----------------------------------------------------------------------------------------------------------


def pile_of_three(mu_ground: float, mu: float) -> Pile:
    """Two discs on the floor that touch, and one on both."""
    r, high = 0.5, 0.5 + sqrt(3.0) * 0.5
    discs = [(r, 1.0, -r, r, 0.0, 0.0, 0.0), (r, 1.0, r, r, 0.0, 0.0, 0.0), (r, 1.0, 0.0, high, 0.0, 0.0, 0.0)]
    return Pile(discs, ((None, 0), (None, 1), (0, 2), (1, 2), (0, 1)), (mu_ground, mu_ground, mu, mu, mu))


def test_a_pile_of_three_discs_needs_two_coefficients_of_friction():
    """2 − √3 between discs and (2 − √3)/3 at the ground.

    A lower disc has forces (T, N) at the ground and those of the upper disc at 30° from the vertical. Moments about its
    centre: the two friction forces are equal, T. Moments about its ground point: the upper force passes through it, so
    it is inclined by half of 30° to the line of centres: T/N₂ = tan 15° = 2 − √3. The ground carries 3/2 of a weight,
    half a weight is the upper force's vertical part; its horizontal part is T: T = ½ m g tan 15°, T/N = (2 − √3)/3."""
    needed, ground = 2.0 - sqrt(3.0), (2.0 - sqrt(3.0)) / 3.0
    modes = (Mode.ROLL,) * 4 + (Mode.FLIGHT,)
    solution = pile_of_three(1.0, 1.0).literal(modes)
    assert np.abs(solution.q1_ddot).max() < 1e-12 * G
    ratios = np.abs(np.array(solution.friction_force) / solution.normal_force)
    assert ratios == pytest.approx([ground, ground, needed, needed], rel=1e-12)
    assert solution.normal_force[0] == pytest.approx(1.5 * G, rel=1e-12)
    # By Coulomb's law without modes: it stands just above both thresholds, and moves just below either.
    for factors, stands in (((1.001, 1.001), True), ((0.999, 1.001), False), ((1.001, 0.999), False)):
        system = pile_of_three(ground * factors[0], needed * factors[1]).frames()
        motions = complementarity.solutions(*_problem(system))
        still = [np.abs(system.accelerations(force)).max() < 1e-7 * G for force in motions]
        assert any(still) == stands, factors


# --- both formulations ------------------------------------------------------------------------------------------------


def _problem(system: ContactSystem):
    count = len(system.mu)
    slips = [None if abs(v) < STILL else float(np.sign(v)) for v in system.velocities[count:]]
    return system.delassus, system.free, slips, system.mu, system.stick


def _enumerate(pile: Pile, system: ContactSystem) -> list[np.ndarray]:
    """The accelerations of all consistent modes by the paper's matrix, each motion once."""
    count, motions = len(system.mu), list[np.ndarray]()
    bias = system.free - system.rows @ (system.inverse * system.torsor)
    options = []
    for v in system.velocities[count:]:
        slips = Mode.SLIP_FORWARD if v > 0.0 else Mode.SLIP_BACKWARD
        every = Mode.FLIGHT, Mode.ROLL, Mode.SLIP_FORWARD, Mode.SLIP_BACKWARD
        options.append(every if abs(v) < STILL else (Mode.FLIGHT, slips))
    for modes in product(*options):
        solution = pile.literal(modes)
        rates = system.rows @ solution.q1_ddot.ravel() + bias
        forces = iter(zip(solution.normal_force, solution.friction_force, strict=True))
        is_consistent = True
        for k, mode in enumerate(modes):
            if mode is Mode.FLIGHT:
                is_consistent &= rates[k] >= 0.0
                continue
            normal, friction = next(forces)
            is_consistent &= normal >= 0.0
            if mode is Mode.ROLL:
                is_consistent &= abs(friction) <= system.stick[k] * normal
            elif abs(system.velocities[count + k]) < STILL:
                is_consistent &= rates[count + k] * (1.0 if mode is Mode.SLIP_FORWARD else -1.0) >= 0.0
        if is_consistent and all(np.abs(solution.q1_ddot - other).max() > 1e-7 for other in motions):
            motions.append(solution.q1_ddot)
    return motions


def _compare(seeds) -> dict[str, int]:
    """Both formulations at random states: every motion of Coulomb's law is among those of the enumerated modes, and if
    these are one motion, it is found. Returns how many states have one, several or none, and how many contacts open."""
    counts = {"one": 0, "several": 0, "none": 0, "open": 0}
    for seed in seeds:
        pile = random_pile(seed)
        system = pile.frames()
        count = len(system.mu)
        assert np.abs(system.velocities[:count]).max() < 1e-12  # the gaps stay zero
        literal = _enumerate(pile, system)
        forces = complementarity.solutions(*_problem(system))
        counts["one" if len(literal) == 1 else "several" if literal else "none"] += 1
        for force in forces:
            counts["open"] += int((force[:count] <= 0.0).sum())
            own = system.accelerations(force)
            assert min(np.abs(own - one).max() / np.abs(one).max() for one in literal) < 1e-9, seed
        assert len(literal) != 1 or len(forces) == 1, seed
    return counts


def test_both_formulations_agree_at_random_states_of_two_bodies():
    counts = _compare(range(60))
    assert counts["one"] > 50 and counts["open"] > 5, counts
