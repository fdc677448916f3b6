"""The check of every motion before it is returned: laws at a few instants of each phase (`instants`), with the same
statements and limits as `reference.check`, which looks at five instants of each step, and at the balance of momentum.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from cases import Case, Chain, Gravity, Impact, Load, Transition, Unilateral
from cases.free_plates import names_of, plates_of
from cases.overlap import span
from cases.piece_contact import excludes_second
from cases.supports import TRACK

from ..minimal.curvature_proof import fits
from ..minimal.integrators.segment import Segment
from ..minimal.phase_end import Ending
from ..scales import applied_acceleration, force_scale, speed_scale
from . import penetration
from .broken_laws import OVERLAP, BrokenLaw, worst, worst_first
from .instants import PhaseInstants, PlateInstant, of_phases
from .laws import ENERGY, Jumps, contact_laws, gives_energy, impact_defects
from .samples import PlateSamples, parameters_near
from .tolerances import part_of

# The status of a motion that breaks a law.
BROKEN_LAW = "broken_law"


class _Scales(NamedTuple):
    """The scales of a motion: speed (m/s), energy (J), how far its plates are from the origin (m), the plates' sizes
    (m), and the largest of the forces on each plate (N)."""

    speed: float
    energy: float
    extent: float
    reach: list[float]
    forces: list[float]


def ending_by_laws(case: Case, solution: tuple[Sequence[Segment], Sequence[Transition], Ending], rtol: float) -> Ending:
    """The ending of a solution (segments, transitions, ending) of a case with a track at rest that obeys the laws, or
    the status BROKEN_LAW with the law in a sentence."""
    segments, transitions, (status, reason) = solution
    if not segments:
        return status, reason
    laws = _laws_broken(case, of_phases(case, segments), transitions, part_of(rtol))
    if not laws:
        return status, reason
    return BROKEN_LAW, f"The motion breaks a law, so the solver is wrong: {laws[0]}. It ended as {status}: {reason}"


def _laws_broken(
    case: Case, phases: list[PhaseInstants], transitions: Sequence[Transition], part: float
) -> tuple[BrokenLaw, ...]:
    scales = _scales(case, phases)
    every = [*_at_contacts(case, phases, scales), *_over_time(case, phases, scales)]
    laws = [BrokenLaw(*one, part * scale) for *one, scale in every if one[3] > part * scale]
    sudden, contacts = _jumps(phases, scales, part), {c.law.name for p in phases for now in p.contacts for c in now}
    if sudden is not None:
        for defects in impact_defects(case, transitions, sudden, contacts, scales.reach, scales.speed):
            if one := worst(defects, part):
                laws.append(one)
    return worst_first([*laws, *_overlaps(case, phases, transitions, part * scales.extent)])


def _scales(case: Case, phases: list[PhaseInstants]) -> _Scales:
    every = plates_of(case)
    reach, size = [plate.reach for plate in every], max([plate.reach for plate in every])
    speed = acceleration = extent = 0.0
    largest = [0.0 for _ in every]
    gravity = case.effect(Gravity)
    acceleration = gravity.g if gravity else 0.0
    for phase in phases:
        for t, poses, touching in zip(phase.times, phase.plates, phase.contacts, strict=True):
            for one, r in zip(poses, reach, strict=True):
                speed, extent = max(speed, abs(one.velocity) + r * abs(one.spin)), max(extent, abs(one.place) + r)
            for touch in touching:
                law = touch.law
                speed = max(speed, abs(touch.slip), abs(law.belt.at(t)[0]) if law.belt else 0.0)
                for body in (law.body, law.base):
                    if body is not None:
                        largest[body] = max(largest[body], abs(touch.normal), abs(touch.friction))
            if case.effect(Load):
                acceleration = max(acceleration, applied_acceleration(case, t, _body(poses[0])))
    speed = max(speed, speed_scale(acceleration, size)) or size / case.duration
    forces = [force_scale(f, p.mass, acceleration, speed, extent) for f, p in zip(largest, every, strict=True)]
    mass = sum([plate.mass for plate in every])
    return _Scales(speed, mass * (speed * speed + (gravity.g if gravity else 0.0) * extent), extent, reach, forces)


def _body(one: PlateInstant) -> tuple[float, ...]:
    x, y, vx, vy = one.place.real, one.place.imag, one.velocity.real, one.velocity.imag
    return x, y, float(np.angle(one.turn)), vx, vy, one.spin


def _at_contacts(case: Case, phases: list[PhaseInstants], scales: _Scales) -> Iterator[tuple]:
    """Laws of each contact: name, place, time, size, unit and scale. Phases of no length have no motion in them."""
    is_unilateral = case.effect(Unilateral) is not None
    for phase in phases:
        if phase.times[0] == phase.times[-1]:
            continue
        for t, touching in zip(phase.times, phase.contacts, strict=True):
            for law, mode, slip, normal, friction, gap in touching:
                force = max([scales.forces[b] for b in (law.body, law.base) if b is not None])
                for name, size, unit in contact_laws(law, mode, is_unilateral, slip, normal, friction):
                    yield name, law.name, t, size, unit, force if unit == "N" else scales.speed
                yield "contact is closed", law.name, t, abs(gap), "m", scales.extent


def _over_time(case: Case, phases: list[PhaseInstants], scales: _Scales) -> Iterator[tuple]:
    """Poses are continuous from phase to phase, and energy is not created."""
    names = names_of(case)
    for one, other in _following(phases):
        for name, a, b in zip(names, one.plates[-1], other.plates[0], strict=True):
            yield "place is continuous", name, other.times[0], abs(b.place - a.place), "m", scales.extent
            yield "angle is continuous", name, other.times[0], abs(b.turn - a.turn), "rad", 1.0
    if case.effect(Load) or any(gives_energy(c.law) for phase in phases for c in phase.contacts[0]):
        return
    energies = [[_energy(case, poses) for poses in phase.plates] for phase in phases]
    for phase, values in zip(phases, energies, strict=True):
        for t, (before, after) in zip(phase.times[1:], pairwise(values), strict=True):
            yield ENERGY, "", t, after - before, "J", scales.energy
    impact = case.effect(Impact)
    if impact is None or impact.law == "poisson" or impact.restitution == 0.0:
        by_number = {phase.number: values for phase, values in zip(phases, energies, strict=True)}
        for one, other in _following(phases):
            gain = by_number[other.number][0] - by_number[one.number][-1]
            yield ENERGY, "", other.times[0], gain, "J", scales.energy


def _following(phases: list[PhaseInstants]) -> list[tuple[PhaseInstants, PhaseInstants]]:
    """Phases, each with the one that begins where it ends."""
    return [(a, b) for a, b in pairwise(phases) if a.number + 1 == b.number and a.times[-1] == b.times[0]]


def _energy(case: Case, poses: Sequence[PlateInstant]) -> float:
    gravity, energy = case.effect(Gravity), 0.0
    pull = complex(*gravity.vector) if gravity else 0j
    for plate, one in zip(plates_of(case), poses, strict=True):
        turning = plate.inertia * one.spin**2 if plate.turns else 0.0
        energy += 0.5 * (plate.mass * abs(one.velocity) ** 2 + turning)
        energy -= plate.mass * (pull.conjugate() * one.place).real
    return energy


def _jumps(phases: list[PhaseInstants], scales: _Scales, part: float) -> Jumps | None:
    """Where velocities jump by more than an error."""
    pairs = []
    for one, other in _following(phases):
        changes = [
            abs(b.velocity - a.velocity) + r * abs(b.spin - a.spin)
            for a, b, r in zip(one.plates[-1], other.plates[0], scales.reach, strict=True)
        ]
        if max(changes) > part * scales.speed:
            pairs.append((one, other))
    if not pairs:
        return None
    times = np.array([other.times[0] for _, other in pairs])
    place = np.array([[one.place for one in other.plates[0]] for _, other in pairs]).T
    before, after = (
        np.array([[(one.velocity, one.spin) for one in poses] for poses in every], dtype=complex).T
        for every in ([one.plates[-1] for one, _ in pairs], [other.plates[0] for _, other in pairs])
    )
    return Jumps(times, np.arange(len(pairs)), place, before, after)


def _overlaps(
    case: Case, phases: list[PhaseInstants], transitions: Sequence[Transition], limit: float
) -> Iterator[BrokenLaw]:
    """Pairs that overlap. Not looked for where curvatures exclude a second touch of a plate in contact."""
    near = parameters_near(case, transitions)
    near[TRACK] += [xi1 for phase in phases for xi1 in phase.near]
    is_proven = not case.others and not case.supports and _touches_once(case, near[TRACK])
    some = [
        (t, poses) for p in phases if not (is_proven and p.near) for t, poses in zip(p.times, p.plates, strict=True)
    ]
    if not some:
        return
    rows = np.array([[(*one[:3], one.spin) for one in poses] for _, poses in some]).T
    plates = [PlateSamples(place, turn, v, spin.real, np.angle(turn)) for place, turn, v, spin in rows.swapaxes(0, 1)]
    times = np.array([t for t, _ in some])
    for depth in penetration.depths(case, times, plates, {name: np.array(values) for name, values in near.items()}):
        i = int(np.argmax(depth.depths))
        if depth.depths[i] > limit:
            yield BrokenLaw(OVERLAP, depth.pair, float(depth.times[i]), float(depth.depths[i]), "m", limit)


def _touches_once(case: Case, xi1: list[float]) -> bool:
    """Whether curvatures exclude that a plate which touches its track there touches it elsewhere, too."""
    track, outline = case.track, case.plate.outline
    if isinstance(track, Chain) or isinstance(outline, Chain):
        return excludes_second(track, outline)
    return fits(track, outline, *span(track, np.array(xi1), case.plate.reach))
