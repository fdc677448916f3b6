"""The check of every motion before it is returned: laws at a few instants of each phase (`instants`), with the same
statements and scales as `reference.check`, which looks at five instants of each step, and at the balance of momentum.
"""

from __future__ import annotations

from cmath import phase as angle_of
from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import inf
from typing import Any, NamedTuple

import numpy as np

from cases import Case, Chain, Gravity, Impact, Transition, Unilateral
from cases.contact.overlap_search import span
from cases.contact.piece_contact import excludes_second
from cases.motion.trajectory import CONTACT
from cases.scene.free_plates import loads_of, names_of, plates_of
from cases.scene.supports import TRACK

from ..curvature_proof import fits
from ..endings import CAUSES
from ..scales import force_scale, load_acceleration, speed_scale
from . import laws, penetration
from .broken_laws import OVERLAP, BrokenLaw, worst_first
from .contact_impulse import landing_defect
from .instants import PhaseInstants
from .laws import ENERGY
from .samples import ContactLaw, PlateSamples, law_at, parameters_near, place_at
from .tolerances import part_of

# Phases, each with the one that begins where it ends.
Neighbours = list[tuple[PhaseInstants, PhaseInstants]]


class _Scales(NamedTuple):
    """The scales of a motion: its speed (m/s), how far its plates are from the origin (m), the plates' sizes (m), and
    for each plate the force at its contacts (N)."""

    speed: float
    extent: float
    reach: list[float]
    forces: list[float]

    def force(self, law: ContactLaw) -> float:
        """That of a contact, N."""
        own = self.forces[law.body]
        return own if law.base is None else max(own, self.forces[law.base])


def faults_at(
    case: Case, phases: list[PhaseInstants], transitions: Sequence[Transition], rtol: float
) -> tuple[BrokenLaw, ...]:
    """The laws that the instants of a motion of this relative accuracy break, of a case with a track at rest."""
    part = part_of(rtol)
    scales, contacts = _scales(case, phases), {touch[0].name for p in phases for touch in p.contacts[0]}
    following = [(a, b) for a, b in pairwise(phases) if a.number + 1 == b.number and a.times[-1] == b.times[0]]
    results = [
        *_at_contacts(case, phases, scales, part),
        *_at_joins(case, following, scales, part),
        *_of_energy(case, phases, following, scales, part),
        *_overlaps(case, phases, transitions, part * scales.extent),
    ]
    if sudden := _jumps(following, scales, part):
        results += _at_impacts(case, transitions, sudden, contacts, scales, part)
    return worst_first(results) if results else ()


def _scales(case: Case, phases: list[PhaseInstants]) -> _Scales:
    plates, gravity, loads = plates_of(case), case.effect(Gravity), loads_of(case)
    reach, largest, outer = [plate.reach for plate in plates], [0.0] * len(plates), 0.0
    every = [(*one, size) for p in phases for poses in p.plates for one, size in zip(poses, reach, strict=True)]
    speeds = [abs(velocity) + size * abs(spin) for _, _, velocity, spin, size in every]
    speeds += [phase.belt for phase in phases]
    for phase in phases:
        for touch in zip(*phase.contacts, strict=True):  # each contact at all instants
            speeds += [abs(slip) for _, _, slip, *_ in touch]
            forces = [size for one in touch for size in (abs(one[3]), abs(one[4])) if size == size]  # none is NaN
            for body in (touch[0][0].body, touch[0][0].base):
                if body is not None:
                    largest[body] = max(largest[body], *forces, 0.0)
        for b, load in enumerate(loads):
            if load is not None:  # at the start of each phase
                place, turn, velocity, spin = phase.plates[0][b]
                state = place.real, place.imag, angle_of(turn), velocity.real, velocity.imag, spin
                outer = max(outer, load_acceleration(plates[b], load, phase.times[0], state))
    extent = max([abs(place) + size for place, *_, size in every])
    size, acceleration = max(reach), (gravity.g if gravity else 0.0) + outer
    speed = max(*speeds, speed_scale(acceleration, size)) or size / case.duration
    scale = [force_scale(f, p.mass, acceleration, speed, extent) for f, p in zip(largest, plates, strict=True)]
    return _Scales(speed, extent, reach, scale)


def _at_contacts(case: Case, phases: list[PhaseInstants], scales: _Scales, part: float) -> Iterator[BrokenLaw]:
    """Laws of each contact. Phases of no length have no motion that could obey them."""
    is_unilateral, fast, far = case.effect(Unilateral) is not None, part * scales.speed, part * scales.extent
    for phase in phases:
        if phase.times[0] == phase.times[-1]:
            continue
        for touch in zip(*phase.contacts, strict=True):  # each contact at all instants
            law, mode = touch[0][:2]
            force = part * scales.force(law)
            for t, (_, _, slip, normal, friction, gap) in zip(phase.times, touch, strict=True):
                for name, size, unit in laws.contact_laws(law, mode, is_unilateral, slip, normal, friction):
                    if size > (limit := force if unit == "N" else fast):
                        yield BrokenLaw(name, law.name, t, float(size), unit, limit)
                if abs(gap) > far:
                    yield BrokenLaw("contact is closed", law.name, t, abs(gap), "m", far)


def _at_joins(case: Case, following: Neighbours, scales: _Scales, part: float) -> Iterator[BrokenLaw]:
    """Poses are continuous from phase to phase, and without impacts velocities are."""
    steady, has_impacts = {"m": part * scales.extent, "rad": part}, case.effect(Impact) is not None
    for one, other in following:
        for law, name, size, unit in laws.at_join(case, one.plates[-1], other.plates[0]):
            limit = steady.get(unit, inf if has_impacts else part * scales.speed)
            if unit == "rad/s" and not has_impacts:
                limit /= scales.reach[names_of(case).index(name)]
            if size > limit:
                yield BrokenLaw(law, name, other.times[0], size, unit, limit)


def _of_energy(
    case: Case, phases: list[PhaseInstants], following: Neighbours, scales: _Scales, part: float
) -> Iterator[BrokenLaw]:
    """Energy is not created in phases, nor from one to the next."""
    rows, pairs = laws.energy_rows(case), list[tuple]()
    limit = part * laws.energy_scale(rows, scales.speed, scales.extent)
    if laws.keeps_energy(case):
        pairs += [(t, *both) for p in phases for t, both in zip(p.times[1:], pairwise(p.plates), strict=True)]
    if laws.impacts_keep_energy(case):
        pairs += [(other.times[0], one.plates[-1], other.plates[0]) for one, other in following]
    for t, before, after in pairs:
        if (gain := laws.energy_of(rows, after) - laws.energy_of(rows, before)) > limit:
            yield BrokenLaw(ENERGY, "", t, gain, "J", limit)


def _jumps(following: Neighbours, scales: _Scales, part: float) -> Neighbours:
    """Where velocities jump by more than an error."""
    limit, sudden = part * scales.speed, list[tuple[PhaseInstants, PhaseInstants]]()
    for one, other in following:
        for a, b, size in zip(one.plates[-1], other.plates[0], scales.reach, strict=True):
            if abs(b[2] - a[2]) + size * abs(b[3] - a[3]) > limit:
                sudden.append((one, other))
                break
    return sudden


def _at_impacts(
    case: Case, transitions: Sequence[Transition], sudden: Neighbours, contacts: set[str], scales: _Scales, part: float
) -> Iterator[BrokenLaw]:
    """Impacts obey their law, of a plate that has one contact."""
    names = contacts | {change.contact or CONTACT for change in transitions}
    if case.effect(Impact) is None or case.others or case.supports or len(names) > 1:
        return
    law, limit = law_at(case, *names or {CONTACT}), part * scales.speed
    places = {change.time: change.xi1 for change in transitions if change.cause == CAUSES["landing"]}
    for one, other in sudden:
        (centre, _, *before), (_, _, *after), t = one.plates[-1][0], other.plates[0][0], other.times[0]
        if t in places:
            point, tangent = place_at(law.track, places[t])
            off = landing_defect(case, law, t, point - centre, tangent, before, after)
            if off > limit:
                yield BrokenLaw("law of impact", law.name, t, off, "m/s", limit)


def _overlaps(
    case: Case, phases: list[PhaseInstants], transitions: Sequence[Transition], limit: float
) -> Iterator[BrokenLaw]:
    """Pairs that overlap. Not looked for where curvatures exclude a second touch of a plate in contact."""
    if not case.others and not case.supports and _touches_once(case, phases):
        phases = [phase for phase in phases if not phase.near]
    if not phases:
        return
    line, radius = penetration.line_of(case.track), case.plate.radius
    if line is not None and radius is not None and not case.others and not case.supports:  # without arrays
        for phase in phases:
            for t, ((place, *_),) in zip(phase.times, phase.plates, strict=True):
                if (depth := radius - penetration.height_above(line, place)) > limit:
                    yield BrokenLaw(OVERLAP, CONTACT, t, depth, "m", limit)
        return
    near = parameters_near(case, transitions)
    near[TRACK] += [xi1 for phase in phases for xi1 in phase.near]
    times = np.array([t for phase in phases for t in phase.times])
    rows: Any = np.array([poses for phase in phases for poses in phase.plates], dtype=complex).transpose(1, 2, 0)
    plates = [PlateSamples(place, turn, v, spin.real, np.angle(turn)) for place, turn, v, spin in rows]
    for depth in penetration.depths(case, times, plates, {name: np.array(values) for name, values in near.items()}):
        i = int(np.argmax(depth.depths))
        if depth.depths[i] > limit:
            yield BrokenLaw(OVERLAP, depth.pair, float(depth.times[i]), float(depth.depths[i]), "m", limit)


def _touches_once(case: Case, phases: list[PhaseInstants]) -> bool:
    """Whether curvatures exclude that a plate in contact with its track touches it elsewhere, too."""
    track, outline = case.track, case.plate.outline
    if isinstance(track, Chain) or isinstance(outline, Chain):
        return excludes_second(track, outline)
    if not outline.period:
        return True
    places = [xi1 for phase in phases for xi1 in phase.near]
    if not places:
        return False
    is_straight = penetration.line_of(track) is not None  # everywhere alike
    stretch = track.span if is_straight else span(track, (min(places), max(places)), case.plate.reach)
    return fits(track, outline, *stretch)
