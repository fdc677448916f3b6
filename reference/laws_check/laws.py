"""The laws of mechanics at the samples of a motion: each gives the sizes of its defects, and the scale of each."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from math import isfinite
from typing import Any, NamedTuple

import numpy as np

from cases import Case, Gravity, Impact, Load, Mode
from cases.formulas import formula_symbols
from cases.formulas.expression_code import ON_ARRAYS, function_of
from cases.own_effects import ContactEffect, own_effects
from cases.scene.free_plates import loads_of, names_of, plates_of
from cases.scene.supports import has_belt

from ..scales import force_scale, speed_scale
from .chebyshev import WEIGHTS
from .samples import (
    CREEP,
    MIDDLE,
    ContactInstants,
    ContactLaw,
    MotionSamples,
    PlateSamples,
)  # fmt: skip
from .tolerances import AMPLIFICATION, EPS, EXACT, MOMENTUM, PARTS, POSE, SERIES

# The sign of the slip in each mode that has one, and the modes without slip.
SENSE = {Mode.SLIP_FORWARD: 1.0, Mode.SLIP_BACKWARD: -1.0}
STICKING = (Mode.ROLL, Mode.REST)
# The name of that law.
ENERGY = "energy is not created"
# Eight roundings of an angle, in parts of what they leave of a pose.
MANY = 8 * EPS / POSE


class Defects(NamedTuple):
    """How far a law is broken: its name, the place, the times (s), sizes in a unit, and their scales, all of one
    shape or broadcast to it. Negative sizes are none; those of a step are complex, so that they can be added. `floor`:
    the part of the scale that roundings leave; `friction`: μ N at these times, N, for laws that are broken by a part of
    it."""

    law: str
    place: str
    times: np.ndarray
    sizes: np.ndarray
    scale: np.ndarray | float
    unit: str
    floor: np.ndarray | float = EXACT
    friction: np.ndarray | None = None

    def limit(self, rtol: float) -> np.ndarray:
        """What is no error of a motion of that relative accuracy, of the sizes' shape, in their unit."""
        return np.broadcast_to((self.floor + PARTS * rtol) * self.scale, self.sizes.shape)


class MotionScales(NamedTuple):
    """The scales of a motion: its speed (m/s), the plates' sizes and the largest of them (m), how far they are from the
    origin (m), weight and load per mass (m/s²), the last time (s), the factor by which roundings are amplified in
    each step, (steps,), and the part of a pose that they leave."""

    speed: float
    reach: list[float]
    size: float
    extent: float
    acceleration: float
    last: float
    condition: np.ndarray
    poses: float


class Sums(NamedTuple):
    """Sums on each plate, arrays (steps, 5): of forces (complex, N) and moments (N m), NaN where they are not unique;
    and the largest of the forces in each step, (steps,)."""

    forces: list[np.ndarray]
    moments: list[np.ndarray]
    largest: list[np.ndarray]


@lru_cache(maxsize=256)
def load_on_arrays(load: Load):
    """(t, x, y, theta, vx, vy, omega) -> [fx, fy, moment] on arrays."""
    return function_of(formula_symbols.MOTION, load.expression, ON_ARRAYS)


@lru_cache(maxsize=256)
def own_force(effect: ContactEffect):
    """(t, slip, omega) -> [along, across, couple] on arrays."""
    return function_of(formula_symbols.CONTACT, effect.formulas[:3], ON_ARRAYS)


def load_at(load: Load | None, t: Any, one: PlateSamples) -> tuple[Any, Any]:
    """Force (complex, N) and moment (N m) of a plate's load at times (s), arrays of their shape."""
    if load is None:
        return 0j, 0.0
    state = one.place.real, one.place.imag, one.angle, one.velocity.real, one.velocity.imag, one.spin
    fx, fy, moment = load_on_arrays(load)(t, *state)
    return fx + 1j * np.asarray(fy), moment


def _load(samples: MotionSamples, body: int) -> tuple[Any, Any]:
    return load_at(loads_of(samples.case)[body], samples.times, samples.plates[body])


def acceleration(samples: MotionSamples) -> float:
    """Weight and the largest load per mass, m/s²: each alone, as they may cancel."""
    gravity, outer = samples.case.effect(Gravity), 0.0
    for body, plate in enumerate(plates_of(samples.case)):
        force, moment = _load(samples, body)
        outer = max(outer, float(np.max(np.abs(force) + np.abs(moment) / plate.gyration)) / plate.mass)
    return (gravity.g if gravity else 0.0) + outer


def sums(samples: MotionSamples, speed: float) -> Sums:
    """All forces on each plate: gravity, load, and those of the contacts as the motion has them; `speed`: the scale of
    velocities, m/s."""
    case, shape, gravity = samples.case, samples.times.shape, samples.case.effect(Gravity)
    pull = complex(*gravity.vector) if gravity is not None else 0j
    forces = [np.full(shape, plate.mass * pull) for plate in plates_of(case)]
    moments = [np.zeros(shape) for _ in forces]
    largest = [np.full(shape[0], plate.mass * abs(pull)) for plate in plates_of(case)]
    for b in range(len(forces)):
        force, moment = _load(samples, b)
        forces[b], moments[b] = forces[b] + force, moments[b] + moment
        largest[b] = np.maximum(largest[b], np.abs(forces[b]).max(axis=1))
    for contact in samples.contacts:
        law, steps = contact.law, contact.steps
        here = slice(None) if len(steps) == len(shape) and len(steps) == shape[0] else steps
        couple = _couple(samples, contact, here, speed)
        force = (contact.friction + 1j * contact.normal) * contact.tangent
        for effect in own_effects(law.effects):
            along, across, more = own_force(effect)(
                samples.times[here], contact.slip, relative_spin(samples, law, here)
            )
            force = force + (along + 1j * np.asarray(across)) * contact.tangent
            couple = couple + more
        for body, sign in ((law.body, 1.0), (law.base, -1.0)):
            if body is not None:
                arm = contact.base - samples.plates[body].place[here]
                forces[body][here] += sign * force
                moments[body][here] += sign * ((arm.conj() * force).imag + couple)
                largest[body][here] = np.maximum(largest[body][here], np.abs(force).max(axis=1))
    return Sums(forces, moments, largest)


def _couple(samples: MotionSamples, contact: ContactInstants, here, speed: float) -> np.ndarray | float:
    """The couple of rolling resistance, N m; NaN where it prevents the rotation, also of a plate that slips."""
    arm, spin = contact.law.arm, relative_spin(samples, contact.law, slice(None))
    if not arm:
        return 0.0
    couple = -np.sign(spin[here][:, MIDDLE, None]) * arm * np.abs(contact.normal)
    reach = plates_of(samples.case)[contact.law.body].reach
    fastest = max(float(np.abs(spin).max()), speed / reach)  # all spins may be roundings
    couple[(np.abs(spin[here]) <= CREEP * fastest).all(axis=1)] = np.nan
    return couple


def relative_spin(samples: MotionSamples, law: ContactLaw, here) -> np.ndarray:
    """The spin of a plate against what it touches, rad/s."""
    spin = samples.plates[law.body].spin[here]
    return spin if law.base is None else spin - samples.plates[law.base].spin[here]


def motion_defects(samples: MotionSamples, total: Sums, scales: MotionScales) -> Iterator[Defects]:
    """Newton's law, and velocities as rates of poses, over each step: differences of its ends less integrals."""
    case, length, speed = samples.case, samples.length, scales.speed
    end = samples.times[:, -1]
    for b, (name, plate, one, force, moment, most, size) in enumerate(
        zip(names_of(case), plates_of(case), samples.plates, *total, scales.reach, strict=True)
    ):
        gain = (length / plate.mass) * (force @ WEIGHTS)
        scale = speed + length * most / plate.mass
        # The velocity at an instant that is rounded.
        floor = MOMENTUM + AMPLIFICATION * scales.condition + 16 * EPS * end * most / plate.mass / scale
        yield Defects("momentum", name, end, one.velocity[:, -1] - one.velocity[:, 0] - gain, scale, "m/s", floor)
        if plate.turns:
            spins = (length / plate.inertia) * (moment @ WEIGHTS)
            turning = speed / size + length / plate.inertia * most * size
            off = one.spin[:, -1] - one.spin[:, 0] - spins + 0j
            yield Defects("angular momentum", name, end, off, turning, "rad/s", floor)
        else:  # its spin does not change, or as its load says
            swing = _load(samples, b)[1] if plate.spins_by_load else 0.0
            off = one.spin[:, -1] - one.spin[:, 0] - length * (np.broadcast_to(swing, one.spin.shape) @ WEIGHTS) + 0j
            yield Defects("angular momentum", name, end, off, speed / size, "rad/s", floor)
        way = one.place[:, -1] - one.place[:, 0] - length * (one.velocity @ WEIGHTS)
        scale = np.abs(one.place[:, 0]) + size + speed * length
        yield Defects("velocity is the rate of the place", name, end, way, scale, "m", scales.poses)
        angle = length * (one.spin @ WEIGHTS)
        off = np.angle(one.turn[:, -1] * one.turn[:, 0].conj() * np.exp(-1j * angle)) + 0j
        scale = turns_of(one, scales.last) + np.abs(angle)
        yield Defects("spin is the rate of the angle", name, end, off, scale, "rad", scales.poses)


def turns_of(one: PlateSamples, last: float) -> float:
    """The scale of angles, rad, until a time `last`: a radian, and many turns, whose roundings, and their changes
    during those of the time, are large."""
    return 1.0 + MANY * float(np.abs(one.angle).max(initial=0.0) + np.abs(one.spin).max(initial=0.0) * last)


def contact_laws(
    law: ContactLaw, mode: Mode | None, is_unilateral: bool, slip: Any, normal: Any, friction: Any
) -> Iterator[tuple[str, Any, str]]:
    """Signorini's and Coulomb's laws at a contact in a mode (None: any mode): for each its name, how far it is broken,
    and the unit. Slip velocity (m/s), normal and friction force (N) are numbers, or arrays of one shape."""
    pressure, sense = abs(normal), SENSE.get(mode, 0.0) if mode else 0.0
    if is_unilateral:
        yield "normal force presses", -normal, "N"
    if sense:
        yield "Coulomb's law in slip", abs(friction + sense * law.coefficient(slip) * pressure), "N"
        yield "sense of slip", -sense * slip, "m/s"
        return
    if mode in STICKING:
        yield "no slip", abs(slip), "m/s"
    if isfinite(law.stick):
        stick = law.stick if mode else np.maximum(law.stick, law.coefficient(slip))
        yield "Coulomb's cone", abs(friction) - stick * pressure, "N"
    if mode is Mode.SLIDE:
        yield "no friction", abs(friction), "N"


def force_scale_at(samples: MotionSamples, law: ContactLaw, scales: MotionScales) -> float:
    """The scale of a contact's forces, N: `force_scale` with the forces of all contacts of its plates."""
    largest, bodies = 0.0, {law.body, law.base} - {None}
    for other in samples.contacts:
        if other.law.body in bodies or other.law.base in bodies:
            forces = np.abs(np.array((other.normal, other.friction)))
            largest = max(largest, float(np.fmax.reduce(forces, axis=None, initial=0.0)))
    mass = plates_of(samples.case)[law.body].mass
    return force_scale(largest, mass, scales.acceleration, scales.speed, scales.extent)


def motion_scales(samples: MotionSamples, poses: float = POSE) -> MotionScales:
    """The scales of a motion. That of its velocities is the largest of plates, slips and belts, and that of a fall from
    a plate's size; without weight and load a plate's size in the case's duration."""
    reach, outer = [plate.reach for plate in plates_of(samples.case)], acceleration(samples)
    every = list(zip(samples.plates, reach, strict=True))
    speeds = [float((np.abs(p.velocity) + r * np.abs(p.spin)).max()) for p, r in every]
    for contact in samples.contacts:
        speeds.append(float(np.fmax.reduce(np.abs(contact.slip), axis=None, initial=0.0)))
        if contact.law.belt:
            speeds.append(float(np.abs(contact.law.belt.at_arrays(samples.times.ravel())).max()))
    size, last = max(reach), float(samples.times.max(initial=0.0))
    speed = max(*speeds, speed_scale(outer, size)) or size / samples.case.duration
    extent = max([float(np.abs(p.place).max()) + r for p, r in every])
    return MotionScales(speed, reach, size, extent, outer, last, condition_numbers(samples), poses)


def condition_numbers(samples: MotionSamples) -> np.ndarray:
    """How much roundings are amplified in each step, (steps,): by curvatures that nearly agree, and by friction that
    nearly makes the normal equation singular (Painlevé)."""
    result = np.ones(len(samples.start))
    for contact in samples.contacts:
        law = contact.law
        below = law.track.curvature(contact.xi1.ravel()) * (-1.0 if law.base is not None else 1.0)
        above = law.outline.curvature(contact.xi2.ravel())
        sizes = (np.abs(below) + np.abs(above)) / np.abs(above - below)
        ratio = np.where(np.isfinite(sizes), sizes, 1.0).reshape(contact.xi1.shape).max(axis=1)
        along, across = np.zeros(contact.xi1.shape), np.zeros(contact.xi1.shape)
        for body in (law.body, law.base):
            if body is not None:
                plate = plates_of(samples.case)[body]
                arm = (contact.base - samples.plates[body].place[contact.steps]) * contact.tangent.conj()
                turn = 1.0 / plate.inertia if plate.turns else 0.0
                across = across + 1.0 / plate.mass + turn * arm.real**2
                along = along - turn * arm.real * arm.imag
        sense = np.array([SENSE.get(mode, 0.0) for mode in contact.modes])[:, None]
        pull = law.coefficient(contact.slip) * sense * along
        ratio = np.maximum(ratio, ((across + np.abs(pull)) / np.abs(across - pull)).max(axis=1))
        result[contact.steps] = np.maximum(result[contact.steps], ratio)
    return result


def material_velocity(samples: MotionSamples, contact: ContactInstants, body: int | None) -> np.ndarray | complex:
    """The velocity of a plate's point at a contact, complex, m/s; 0 of track and supports."""
    if body is None:
        return 0j
    one, steps = samples.plates[body], contact.steps
    return one.velocity[steps] + 1j * one.spin[steps] * (contact.base - one.place[steps])


class Joins(NamedTuple):
    """Where a step or phase begins at the end of the one before: times (k,), numbers of the steps (k,), and each
    plate's place, turn, velocity and spin before and after, (plates, 4, k), complex."""

    times: np.ndarray
    steps: np.ndarray
    before: np.ndarray
    after: np.ndarray


def joins(samples: MotionSamples) -> Joins:
    """Where the steps of a motion follow each other."""
    before, after = (
        np.array([[row[steps, i] for row in one[:4]] for one in samples.plates])
        for steps, i in ((slice(-1), -1), (slice(1, None), 0))
    )
    return Joins(samples.start[1:], np.arange(1, len(samples.start)), before, after)


def sudden_part(scales: MotionScales, rtol: float) -> float:
    """The part of the speed by which velocities jump in impacts only."""
    return MOMENTUM + AMPLIFICATION * float(scales.condition.max()) + PARTS * rtol


def jumps(every: Joins, reach: list[float], speed: float, part: float) -> Joins:
    """Those where velocities jump by more than an error."""
    change = np.abs(every.after[:, 2:] - every.before[:, 2:])
    large = (change[:, 0] + change[:, 1] * np.array(reach)[:, None] > part * speed).any(axis=0)
    return Joins(every.times[large], every.steps[large], every.before[..., large], every.after[..., large])


def at_join(case: Case, before: Any, after: Any) -> Iterator[tuple[str, str, Any, str]]:
    """How far each plate's place, angle, velocity and spin jump between two instants, given as rows of each plate in
    numbers or arrays: the name of the law, the plate, the size and its unit."""
    for name, a, b in zip(names_of(case), before, after, strict=True):
        yield "place is continuous", name, abs(b[0] - a[0]), "m"
        yield "angle is continuous", name, abs(b[1] - a[1]), "rad"
        yield "velocity is continuous", name, abs(b[2] - a[2]), "m/s"
        yield "spin is continuous", name, abs(b[3] - a[3]), "rad/s"


def continuity_defects(
    samples: MotionSamples, every: Joins, scales: MotionScales, is_series: np.ndarray
) -> Iterator[Defects]:
    """Poses are continuous, but for what is left of a hop in a series of impacts (`is_series`: which joins are), and
    without impacts velocities are."""
    poses = np.where(is_series, SERIES, scales.poses)
    rates = MOMENTUM + AMPLIFICATION * float(scales.condition.max())
    rates = np.inf if samples.case.effect(Impact) is not None else rates
    for law, name, size, unit in at_join(samples.case, every.before, every.after):
        b = names_of(samples.case).index(name)
        reach, one = scales.reach[b], samples.plates[b]
        scale = {
            "m": np.abs(every.after[b, 0]) + reach, "rad": turns_of(one, scales.last), "m/s": scales.speed,
            "rad/s": scales.speed / reach,
        }[unit]  # fmt: skip
        yield Defects(law, name, every.times, size, scale, unit, rates if unit.endswith("/s") else poses)


def energy_defects(samples: MotionSamples, scales: MotionScales) -> Iterator[Defects]:
    """Energy is not created in steps, nor from one to the next."""
    case = samples.case
    rows = energy_rows(case)
    energy, scale = energy_of(rows, samples.plates), energy_scale(rows, scales.speed, scales.extent)
    if keeps_energy(case):
        yield Defects(ENERGY, "", samples.times[:, 1:], np.diff(energy, axis=1), scale, "J")
    if impacts_keep_energy(case):
        yield Defects(ENERGY, "", samples.start[1:], energy[1:, 0] - energy[:-1, -1], scale, "J")


def energy_rows(case: Case) -> list[tuple[float, float, complex]]:
    """Half the mass and half the inertia (0: it does not turn) of each plate, and its weight, N."""
    gravity = case.effect(Gravity)
    pull = complex(*gravity.vector) if gravity is not None else 0j
    return [(0.5 * p.mass, 0.5 * p.inertia if p.turns else 0.0, p.mass * pull) for p in plates_of(case)]


def energy_of(rows: list[tuple[float, float, complex]], plates: Any) -> Any:
    """The energy of all plates, J, which have place, turn, velocity and spin in numbers or arrays."""
    total = 0.0
    for (mass, inertia, weight), (place, _, velocity, spin, *_) in zip(rows, plates, strict=True):
        total = total + mass * (velocity.real**2 + velocity.imag**2) + inertia * spin * spin
        total = total - weight.real * place.real - weight.imag * place.imag
    return total


def energy_scale(rows: list[tuple[float, float, complex]], speed: float, extent: float) -> float:
    """The scale of energies at that speed (m/s) and distance from the origin (m), J."""
    return sum([2.0 * mass * speed**2 + 1.5 * abs(weight) * extent for mass, _, weight in rows])


def keeps_energy(case: Case) -> bool:
    """Whether nothing gives energy to plates that move: no load, belt or effect of the user's own."""
    return not (any(loads_of(case)) or has_belt(case) or own_effects(case.effects))


def impacts_keep_energy(case: Case) -> bool:
    """Whether impacts give none: no belts, and no restitution of Newton's, whose own law has the balance."""
    law, gives = case.effect(Impact), has_belt(case) or any(plate.spins_by_load for plate in plates_of(case))
    return not gives and (law is None or law.law == "poisson" or law.restitution == 0.0)
