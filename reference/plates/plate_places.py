"""Numbers of the contacts of several plates at one instant: gaps, the rows of their velocities, and projections."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import lru_cache
from math import cos, hypot, sin
from typing import NamedTuple, cast

import numpy as np

from cases import Case, Gravity
from cases.free_plates import PlateContact, parameter, plate_contacts, plates_of, size_of
from cases.polygon_features import (
    local_centre,
    place_in_region,
    places_in_regions,
    region_ahead,
    regions,
    size_of_plate,
)

from ..several.contact_law import coefficients, restitution

# Newton's steps that move plates onto their contacts: each squares the error.
STEPS = 8


class PlatesNumbers(NamedTuple):
    """Of all plates: radii of discs and reaches of polygons (m), inverse masses and moments of inertia (3n,), lengths
    (3n,) by which velocities are compared (m; 1 for translations), and the accelerations (3n,) of the load."""

    radii: tuple[float, ...]
    inverse: np.ndarray
    lengths: np.ndarray
    load: np.ndarray


@lru_cache(maxsize=256)
def numbers_of(case: Case) -> PlatesNumbers:
    """The numbers of a case's plates."""
    plates, gravity = plates_of(case), case.effect(Gravity)
    radii = tuple(map(size_of_plate, plates))
    inverse = np.array([value for p in plates for value in (1.0 / p.mass, 1.0 / p.mass, 1.0 / p.inertia)])
    pull = (*gravity.vector, 0.0) if gravity is not None else (0.0, 0.0, 0.0)
    return PlatesNumbers(
        radii, inverse, np.array([v for r in radii for v in (1.0, 1.0, r)]), np.tile(pull, len(plates))
    )


class PlateContactPlace(NamedTuple):
    """One contact: its gap (m), unit normal, contact parameters, rows (3n,) of lift and slip velocity, the parts of
    their rates that the velocities give, and the number of the region of a polygon in which it is."""

    contact: PlateContact
    gap: float
    normal: tuple[float, float]
    xi1: float
    xi2: float
    lift_row: np.ndarray
    slip_row: np.ndarray
    lift_bias: float
    slip_bias: float
    region: int = 0

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
    contact, plates, half = plate_contacts(case)[number], plates_of(case), len(state) // 2
    positions, velocities = (np.asarray(part, dtype=float).reshape(-1, 3) for part in (state[:half], state[half:]))
    body, base, circle = contact.body, contact.base, contact.circle
    theta, spin = float(positions[body, 2]), float(velocities[body, 2])
    ax, ay = circle.arm(theta)
    centre, radius = positions[body, :2] + (ax, ay), circle.radius
    lift_row, slip_row, region = np.zeros(half), np.zeros(half), 0
    if base is None:
        assert contact.line is not None and contact.curve is not None
        tx, ty = (float(v) for v in contact.line.direction)
        along = float((centre - contact.line.point) @ contact.line.direction)
        gap = float((centre[1] - contact.line.point[1]) * tx - (centre[0] - contact.line.point[0]) * ty) - radius
        xi1 = float(contact.curve.span[0]) + along / float(contact.curve.speed(contact.curve.span[0]))
        lift_bias = slip_bias = 0.0
    elif around := regions(plates[base]):
        pose, rate = positions[base], velocities[base]
        region = region_ahead(plates[base], pose, rate, centre, velocities[body, :2])
        one = around[region]
        u, v = local_centre(pose, *centre)
        gap, *local, xi1 = map(float, place_in_region(one, u, v, radius))
        c, s = cos(pose[2]), sin(pose[2])
        nx, ny = c * local[0] - s * local[1], s * local[0] + c * local[1]
        tx, ty = ny, -nx
        # The edge turns about the polygon's centre of mass, the corner is a point of it.
        arm = np.array([c * one.x - s * one.y, s * one.x + c * one.y])
        offset = centre - pose[:2] - (arm if one.corner else 0.0)
        relative = velocities[body, :2] - rate[:2] - (rate[2] * np.array([-arm[1], arm[0]]) if one.corner else 0.0)
        along, across, w = float(relative @ (tx, ty)), float(relative @ (nx, ny)), float(rate[2])
        if one.corner:
            far, out, aside = float(np.hypot(*offset)), float(arm @ (nx, ny)), float(arm @ (tx, ty))
            lift_bias, slip_bias = along**2 / far + w * w * out, -along * across / far + w * w * aside
            turns = -aside, out
        else:
            out, aside = float(offset @ (nx, ny)), float(offset @ (tx, ty))
            lift_bias, slip_bias = -2.0 * w * along - w * w * out, 2.0 * w * across - w * w * aside
            turns = -aside, out - radius
        lift_row[3 * base : 3 * base + 3] = ty, -tx, turns[0]
        slip_row[3 * base : 3 * base + 3] = -tx, -ty, turns[1]
    else:
        away = centre - positions[base, :2]
        far = float(np.hypot(*away))
        nx, ny = (away / np.hypot(*away)).tolist()
        tx, ty = ny, -nx
        gap = hypot(*away.tolist()) - radius - size_of_plate(plates[base])
        xi1 = float(parameter(plates[base].outline, np.arctan2(ny, nx) - positions[base, 2]))
        relative = velocities[body, :2] - velocities[base, :2]
        along, across = float(relative @ (tx, ty)), float(relative @ (nx, ny))
        lift_bias, slip_bias = along**2 / far, -along * across / far
        lift_row[3 * base : 3 * base + 2] = ty, -tx
        slip_row[3 * base : 3 * base + 3] = -tx, -ty, size_of_plate(plates[base])
    lift_row[3 * body : 3 * body + 2] = -ty, tx
    slip_row[3 * body : 3 * body + 3] = tx, ty, radius
    if radius == 0.0:  # the corner turns about the centre of mass
        lift_row[3 * body + 2], slip_row[3 * body + 2] = tx * ax + ty * ay, ty * ax - tx * ay
        lift_bias += spin * spin * (ty * ax - tx * ay)
        slip_bias -= spin * spin * (tx * ax + ty * ay)
    xi2 = float(_own_parameter(case, number, np.arctan2(ty, tx), theta))
    return PlateContactPlace(
        contact, gap, (-ty, tx), xi1, xi2, lift_row, slip_row, float(lift_bias), float(slip_bias), region
    )


def _own_parameter(case: Case, number: int, direction, theta):
    """The parameter of the outline of a contact's plate where the contact's tangent has a direction (rad); numbers or
    arrays."""
    contact = plate_contacts(case)[number]
    if contact.circle.radius == 0.0:
        return contact.circle.outline_parameter(direction - theta)
    inward = np.arctan2(-np.cos(direction), np.sin(direction))
    return parameter(plates_of(case)[contact.body].outline, inward - theta)


def coordinates(case: Case, number: int, states: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Gap (m) and parameters of a contact in many states (variables, n): as of `place`, each of shape (n,)."""
    contact, plates = plate_contacts(case)[number], plates_of(case)
    body, base, circle = contact.body, contact.base, contact.circle
    x, y, theta = states[3 * body : 3 * body + 3]
    if circle.radius == 0.0:
        c, s = np.cos(theta), np.sin(theta)
        x, y = x + c * circle.x - s * circle.y, y + s * circle.x + c * circle.y
    if base is None:
        assert contact.line is not None and contact.curve is not None
        (px, py), (tx, ty) = contact.line.point, (float(v) for v in contact.line.direction)
        gap = (y - py) * tx - (x - px) * ty - circle.radius
        low = contact.curve.span[0]
        xi1 = float(low) + ((x - px) * tx + (y - py) * ty) / float(contact.curve.speed(low))
        return gap, xi1, _own_parameter(case, number, np.arctan2(ty, tx), theta)
    pose = states[3 * base : 3 * base + 3]
    if around := regions(plates[base]):
        u, v = local_centre(pose, x, y)
        gap, nx, ny, xi1 = places_in_regions(around, u, v, circle.radius)
        polar = np.arctan2(ny, nx) + pose[2]
    else:
        distance = np.hypot(x - pose[0], y - pose[1])
        gap = distance - circle.radius - size_of_plate(plates[base])
        polar = np.arctan2((y - pose[1]) / distance, (x - pose[0]) / distance)
        xi1 = parameter(plates[base].outline, polar - pose[2])
    return gap, xi1, _own_parameter(case, number, polar - 0.5 * np.pi, theta)


def places(case: Case, numbers: Sequence[int], state: Sequence[float] | np.ndarray) -> list[PlateContactPlace]:
    """`place` for every contact."""
    return [place(case, number, state) for number in numbers]


def regions_of(case: Case, numbers: Iterable[int], now: Sequence[PlateContactPlace]) -> tuple[tuple[int, int], ...]:
    """The numbers of the contacts with a polygon, and of their regions."""
    plates = plates_of(case)
    each = zip(numbers, now, strict=True)
    return tuple((n, at.region) for n, at in each if at.contact.base is not None and regions(plates[at.contact.base]))


def flush(case: Case, numbers: Iterable[int]) -> dict[int, int]:
    """Of those contacts, each second corner of a plate on one line, with the first: such corners have one slip."""
    firsts, seconds, every = dict[tuple[int, int], int](), dict[int, int](), plate_contacts(case)
    for number in numbers:
        one = every[number]
        if one.base is None and one.circle.radius == 0.0:
            first = firsts.setdefault((one.body, id(one.curve)), number)
            if first != number:
                seconds[number] = first
    return seconds


def size(case: Case, state: Sequence[float] | np.ndarray) -> float:
    """The size of the poses' numbers, m."""
    return size_of(np.asarray(state[: len(state) // 2], dtype=float).reshape(-1, 3), numbers_of(case).radii)


def speed(case: Case, state: Sequence[float] | np.ndarray) -> float:
    """The largest of the plates' speeds, m/s; that of a spin at the radius."""
    return float(np.abs(np.asarray(state[len(state) // 2 :]) * numbers_of(case).lengths).max())


def groups(case: Case, touching: Iterable[int]) -> list[list[int]]:
    """The touching contacts in groups that share plates: what happens in one changes no other."""
    every, results = plate_contacts(case), list[tuple[set[int], list[int]]]()
    for number in touching:
        sides = {side for side in (every[number].body, every[number].base) if side is not None}
        own = [group for group in results if group[0] & sides]
        bodies = sides.union(*(group[0] for group in own))
        contacts = sorted([number, *(n for group in own for n in group[1])])
        results = [group for group in results if group not in own] + [(bodies, contacts)]
    return [contacts for _, contacts in results]


def plates_in(case: Case, contacts: Sequence[int]) -> frozenset[int]:
    """The plates of some contacts."""
    every = plate_contacts(case)
    return frozenset(side for n in contacts for side in (every[n].body, every[n].base) if side is not None)


def project(case: Case, state: Sequence[float], touching: Sequence[int]) -> tuple[float, ...]:
    """The plates moved by rounding so that the touching contacts have no gap; plates of other contacts keep their
    bits."""
    values, inverse, half = np.array(state, dtype=float), numbers_of(case).inverse, len(state) // 2
    for group in groups(case, touching):
        for _ in range(STEPS):
            now = places(case, group, values)
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
    velocities in kinetic energy. Plates of other contacts keep their bits."""
    numbers, half = numbers_of(case), len(state) // 2
    velocity = np.array(state[half:], dtype=float)
    for group in groups(case, {*touching, *stuck}):
        lifts, slips = ([n for n in some if n in group] for some in (touching, stuck))
        matrix = np.array(
            [at.lift_row for at in places(case, lifts, state)] + [at.slip_row for at in places(case, slips, state)]
        )
        for _ in range(2):  # the second step removes the rounding of the first
            off = np.linalg.lstsq(matrix * numbers.inverse @ matrix.T, matrix @ velocity, rcond=1e-10)[0]
            velocity = velocity - numbers.inverse * (matrix.T @ off)
        # Plates that their contacts hold have no velocity, to the last bit.
        own = np.repeat([b in plates_in(case, group) for b in range(half // 3)], 3)
        free = matrix * np.sqrt(numbers.inverse)
        if np.linalg.matrix_rank(free, tol=1e-9 * float(np.linalg.norm(free, 2))) == np.count_nonzero(
            numbers.inverse[own]
        ):
            velocity[own] = 0.0
    return (*state[:half], *velocity.tolist())
