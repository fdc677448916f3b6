"""Piles of discs at an instant, for the paper's matrix and for the contacts' frames."""

from collections.abc import Sequence
from functools import lru_cache
from math import atan2, cos, pi, sin
from typing import NamedTuple

import numpy as np

from cases import (
    Case,
    CoulombFriction,
    Curve,
    Flight,
    FreePlate,
    Gravity,
    Mode,
    Pair,
    Plate,
    Start,
    StartPose,
    Unilateral,
    disc,
)
from cases.library import hill, line
from cases.scene.couples import couples
from reference.paper.bodies import BodiesSolution, BodyContact, solve_bodies
from reference.witness.contacts import PlateDynamics, frictions, pair_at
from reference.witness.watched_pairs import watched_pairs

G = 9.81
LINE = line()
STILL = 1e-9  # a slip velocity below this is none: states are given to rounding, with speeds of 0.1 to 5 m/s


@lru_cache(maxsize=256)
def body(plate: Plate, track: Curve = LINE, mu: float = 0.0, down: float = -pi / 2) -> Case:
    """A plate with weight in that direction, and friction where it lies on that track."""
    friction = (CoulombFriction(mu),) if mu else ()
    return Case(track, plate, (Gravity(G, down), Unilateral(), *friction), Start(0.0, 0.0), 1.0)


class ContactSystem(NamedTuple):
    """The K contacts of n plates in their frames, first all normals, then all tangents: rows (2K, 3n) of the velocities
    of gap and slip, these velocities, the Delassus matrix, the rates without contact forces; inverse masses and loads
    (3n,); coefficients of friction (K,) with slip and without."""

    rows: np.ndarray
    velocities: np.ndarray
    delassus: np.ndarray
    free: np.ndarray
    inverse: np.ndarray
    torsor: np.ndarray
    mu: np.ndarray
    stick: np.ndarray

    def accelerations(self, forces: np.ndarray) -> np.ndarray:
        """Accelerations (n, 3) with those contact forces (N₁ … N_K, T₁ … T_K), N."""
        return np.asarray(self.inverse * (self.torsor + self.rows.T @ forces)).reshape(-1, 3)


def case_of(plates: Sequence[Plate], contacts, mus: Sequence[float], down: float = -pi / 2) -> Case:
    """Plates with friction at `contacts`, (base, plate), base None for the floor. It begins with the plates apart."""
    names = ("plate", *(f"plate{i}" for i in range(1, len(plates))))
    pairs = tuple(
        Pair(f"{names[own]}/{'track' if base is None else names[base]}", (CoulombFriction(mu),))
        for (base, own), mu in zip(contacts, mus, strict=True) if mu
    )  # fmt: skip
    poses = [StartPose(10.0 * i, 5.0) for i in range(len(plates))]
    others = tuple(map(FreePlate, plates[1:], poses[1:], names[1:]))
    return Case(LINE, plates[0], (Gravity(G, down), Unilateral(), Flight()), poses[0], 1.0, others=others, pairs=pairs)


def contact_system(case: Case, states, contacts) -> ContactSystem:
    """The second formulation's system of a case in these states, with closed contacts (base, plate)."""
    values = np.array([value for part in (slice(0, 3), slice(3, 6)) for state in states for value in state[part]])
    closed = []
    for place in contacts:
        (couple,) = (one for one in couples(case) if (one.base, one.body) == place)
        ((pair, near),) = watched_pairs(couple, values[: len(values) // 2])
        closed.append(pair_at(pair, values, near))
    dynamics = PlateDynamics(case)
    delassus, rows = dynamics.delassus(closed)
    return ContactSystem(
        rows, rows @ values[len(values) // 2 :], delassus, dynamics.free_rates(0.0, values, closed, rows),
        dynamics.inverse, dynamics.torsor(0.0, values), *frictions(closed),
    )  # fmt: skip


class Pile:
    """Discs (radius, mass, x, y, vx, vy, ω) with closed contacts: (base, body), base None: the level floor y = 0."""

    def __init__(self, discs, contacts, mus, down: float = -pi / 2, inertias=None):
        inertias = inertias or [None] * len(discs)
        self.plates = [disc(r, m, inertia) for (r, m, *_), inertia in zip(discs, inertias, strict=True)]
        self.states = [(x, y, 0.3 * i, vx, vy, omega) for i, (_, _, x, y, vx, vy, omega) in enumerate(discs)]
        self.bodies = [body(plate, down=down) for plate in self.plates]
        self.contacts, self.mus, self.radii = contacts, mus, [r for r, *_ in discs]
        self.case = case_of(self.plates, contacts, mus, down)

    def pair(self, k: int) -> Case:
        base, own = self.contacts[k]
        return body(self.plates[own], LINE if base is None else hill(self.radii[base]), self.mus[k])

    def parameters(self, k: int) -> tuple[float, float, float, float]:
        """(ξ₁, ξ₂) of a contact and their rates."""
        base, own = self.contacts[k]
        x, y, theta, vx, vy, omega = self.states[own]
        if base is None:
            return x, -pi / 2 - theta, vx, -omega  # along a level line; the lowest point of the circle
        bx, by, base_theta, bvx, bvy, base_omega = self.states[base]
        (dx, dy), (dvx, dvy) = (x - bx, y - by), (vx - bvx, vy - bvy)
        phi, rate = atan2(dx, dy), (dvx * dy - dvy * dx) / (dx * dx + dy * dy)
        # `hill` counts from its top to the right in the base's frame, the circle from its own x axis.
        return phi + base_theta, -pi / 2 - phi - theta, rate + base_omega, -rate - omega

    def literal(self, modes) -> BodiesSolution:
        """The paper's matrix in those modes."""
        contacts = [
            BodyContact(self.pair(k), mode, self.parameters(k), own, base)
            for k, ((base, own), mode) in enumerate(zip(self.contacts, modes, strict=True)) if mode is not Mode.FLIGHT
        ]  # fmt: skip
        return solve_bodies(self.bodies, contacts, [(0.0, *state) for state in self.states])

    def frames(self) -> ContactSystem:
        """The contacts' frames."""
        return contact_system(self.case, self.states, self.contacts)


def on_top(phi: float, spins=(0.0, 0.0), speed: float = 0.0, rate: float = 0.0, masses=(1.0, 1.0), radii=(0.5, 0.4)):
    """Two discs: the lower one on the floor with that speed, the upper one on it at φ with φ̇ = `rate`."""
    far = sum(radii)
    x, y = far * sin(phi), radii[0] + far * cos(phi)
    upper = radii[1], masses[1], x, y, speed + far * rate * cos(phi), -far * rate * sin(phi), spins[1]
    return (radii[0], masses[0], 0.0, radii[0], speed, 0.0, spins[0]), upper


BOTH = ((None, 0), (0, 1))


def random_pile(seed: int) -> Pile:
    """A disc on a disc on the floor, in motion with closed contacts, on an incline; one slip in three is zero."""
    numbers = np.random.default_rng(seed)
    radii, masses = numbers.choice([0.2, 0.5, 0.9], 2), numbers.uniform(0.3, 3.0, 2)
    phi, speed, rate = numbers.uniform(-1.2, 1.2), numbers.uniform(-2.0, 2.0), numbers.uniform(-1.5, 1.5)
    spins, down = numbers.uniform(-5.0, 5.0, 2), float(numbers.uniform(-2.2, -0.9))
    if numbers.random() < 1 / 3:
        spins[0] = -speed / radii[0]
    if numbers.random() < 1 / 3:
        spins[1] = -(sum(radii) * rate + spins[0] * radii[0]) / radii[1]
    discs = on_top(float(phi), tuple(spins.tolist()), speed, rate, tuple(masses.tolist()), tuple(radii.tolist()))
    return Pile(discs, BOTH, tuple(numbers.uniform(0.05, 1.2, 2).tolist()), down)
