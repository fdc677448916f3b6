"""Numbers of the contacts of several plates at one instant: gaps, the rows of their velocities, and projections."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple, cast

import numpy as np

from cases import Case, Gravity
from cases.free_plates import PlateContact, gap_of, parameter, plate_contacts, plates_of, size_of

from ..several.contact_law import coefficients, restitution

# Newton's steps that move plates onto their contacts: each squares the error.
STEPS = 8


class PlatesNumbers(NamedTuple):
    """Of all plates: radii (m), inverse masses and moments of inertia (3n,), lengths (3n,) by which velocities are
    compared (m; 1 for translations), and the accelerations (3n,) of the load."""

    radii: tuple[float, ...]
    inverse: np.ndarray
    lengths: np.ndarray
    load: np.ndarray


@lru_cache(maxsize=256)
def numbers_of(case: Case) -> PlatesNumbers:
    """The numbers of a case's plates."""
    plates, gravity = plates_of(case), case.effect(Gravity)
    radii = tuple(cast(float, plate.radius) for plate in plates)
    inverse = np.array([value for p in plates for value in (1.0 / p.mass, 1.0 / p.mass, 1.0 / p.inertia)])
    pull = (*gravity.vector, 0.0) if gravity is not None else (0.0, 0.0, 0.0)
    return PlatesNumbers(
        radii, inverse, np.array([v for r in radii for v in (1.0, 1.0, r)]), np.tile(pull, len(plates))
    )


class PlateContactPlace(NamedTuple):
    """One contact: its gap (m), unit normal, contact parameters, rows (3n,) of lift and slip velocity, and the parts of
    their rates that the velocities give."""

    contact: PlateContact
    gap: float
    normal: tuple[float, float]
    xi1: float
    xi2: float
    lift_row: np.ndarray
    slip_row: np.ndarray
    lift_bias: float
    slip_bias: float

    @property
    def mu(self) -> float:
        """The coefficient of friction with slip."""
        return coefficients(cast(Case, self.contact))[0]

    @property
    def stick(self) -> float:
        """The coefficient of friction without slip."""
        return coefficients(cast(Case, self.contact))[1]

    @property
    def restitution(self) -> float:
        """The coefficient of restitution."""
        return restitution(cast(Case, self.contact))


def place(case: Case, number: int, state: Sequence[float] | np.ndarray) -> PlateContactPlace:
    """A contact in a state (x, y, θ of all plates, then vx, vy, ω)."""
    contact, numbers = plate_contacts(case)[number], numbers_of(case)
    radii, half = numbers.radii, len(state) // 2
    positions, velocities = (np.asarray(part, dtype=float).reshape(-1, 3) for part in (state[:half], state[half:]))
    body, base = contact.body, contact.base
    gap = gap_of(contact, radii, positions)
    lift_row, slip_row = np.zeros(half), np.zeros(half)
    lift_bias = slip_bias = 0.0
    if base is None:
        assert contact.line is not None and contact.curve is not None
        tx, ty = (float(v) for v in contact.line.direction)
        along = float((positions[body, :2] - contact.line.point) @ contact.line.direction)
        xi1 = float(contact.curve.span[0]) + along / float(contact.curve.speed(contact.curve.span[0]))
    else:
        away = positions[body, :2] - positions[base, :2]
        nx, ny = (away / np.hypot(*away)).tolist()
        tx, ty = ny, -nx
        xi1 = float(parameter(plates_of(case)[base].outline, np.arctan2(ny, nx) - positions[base, 2]))
        relative = velocities[body, :2] - velocities[base, :2]
        along, across = float(relative @ (tx, ty)), float(relative @ (nx, ny))
        lift_bias, slip_bias = along**2 / float(np.hypot(*away)), -along * across / float(np.hypot(*away))
        lift_row[3 * base : 3 * base + 2] = ty, -tx
        slip_row[3 * base : 3 * base + 3] = -tx, -ty, radii[base]
    lift_row[3 * body : 3 * body + 2] = -ty, tx
    slip_row[3 * body : 3 * body + 3] = tx, ty, radii[body]
    xi2 = float(parameter(plates_of(case)[body].outline, np.arctan2(-tx, ty) - positions[body, 2]))
    return PlateContactPlace(contact, gap, (-ty, tx), xi1, xi2, lift_row, slip_row, lift_bias, slip_bias)


def coordinates(case: Case, number: int, states: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Gap (m) and parameters of a contact in many states (variables, n): as of `place`, each of shape (n,)."""
    contact, radii = plate_contacts(case)[number], numbers_of(case).radii
    body, base = contact.body, contact.base
    (x, y, theta), plates = states[3 * body : 3 * body + 3], plates_of(case)
    if base is None:
        assert contact.line is not None and contact.curve is not None
        (px, py), (tx, ty) = contact.line.point, (float(v) for v in contact.line.direction)
        gap = (y - py) * tx - (x - px) * ty - radii[body]
        low = contact.curve.span[0]
        xi1 = float(low) + ((x - px) * tx + (y - py) * ty) / float(contact.curve.speed(low))
        inward = np.full(x.shape, np.arctan2(-tx, ty))
    else:
        u, v, turn = states[3 * base : 3 * base + 3]
        distance = np.hypot(x - u, y - v)
        gap = distance - radii[body] - radii[base]
        nx, ny = (x - u) / distance, (y - v) / distance
        xi1 = parameter(plates[base].outline, np.arctan2(ny, nx) - turn)
        inward = np.arctan2(-ny, -nx)
    return gap, xi1, parameter(plates[body].outline, inward - theta)


def places(case: Case, numbers: Sequence[int], state: Sequence[float] | np.ndarray) -> list[PlateContactPlace]:
    """`place` for every contact."""
    return [place(case, number, state) for number in numbers]


def size(case: Case, state: Sequence[float] | np.ndarray) -> float:
    """The size of the poses' numbers, m."""
    return size_of(np.asarray(state[: len(state) // 2], dtype=float).reshape(-1, 3), numbers_of(case).radii)


def speed(case: Case, state: Sequence[float] | np.ndarray) -> float:
    """The largest of the plates' speeds, m/s; that of a spin at the radius."""
    return float(np.abs(np.asarray(state[len(state) // 2 :]) * numbers_of(case).lengths).max())


def project(case: Case, state: Sequence[float], touching: Sequence[int]) -> tuple[float, ...]:
    """The plates moved by rounding so that the touching contacts have no gap."""
    values, inverse, half = np.array(state, dtype=float), numbers_of(case).inverse, len(state) // 2
    for _ in range(STEPS if touching else 0):
        now = places(case, touching, values)
        gaps = np.array([at.gap for at in now])
        if np.abs(gaps).max() <= 2e-16 * size(case, values):
            break
        rows = np.array([at.lift_row for at in now])
        values[:half] -= inverse * (rows.T @ np.linalg.lstsq(rows * inverse @ rows.T, gaps, rcond=1e-10)[0])
    return tuple(values.tolist())


def without_velocity(
    case: Case, state: Sequence[float], touching: Sequence[int], stuck: Sequence[int]
) -> tuple[float, ...]:
    """The state with lift velocity 0 at touching contacts and slip velocity 0 at the stuck ones: the nearest such
    velocities in kinetic energy."""
    numbers, half = numbers_of(case), len(state) // 2
    rows = [at.lift_row for at in places(case, touching, state)] + [at.slip_row for at in places(case, stuck, state)]
    if not rows:
        return tuple(state)
    velocity, matrix = np.array(state[half:], dtype=float), np.array(rows)
    # Plates that their contacts hold have no velocity, to the last bit.
    free = np.linalg.svd(matrix * np.sqrt(numbers.inverse))[1]
    held = np.linalg.matrix_rank(matrix * np.sqrt(numbers.inverse), tol=1e-9 * float(free.max()))
    for _ in range(2):  # the second step removes the rounding of the first
        off = np.linalg.lstsq(matrix * numbers.inverse @ matrix.T, matrix @ velocity, rcond=1e-10)[0]
        velocity = velocity - numbers.inverse * (matrix.T @ off)
    if held == np.count_nonzero(numbers.inverse):
        velocity[:] = 0.0
    return (*state[:half], *velocity.tolist())
