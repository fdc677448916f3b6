"""The plates and contacts of a motion at a few instants of each phase, in numbers, from the states that its integrator
has: a motion by the Taylor method takes 0.3 ms, and arrays of its dense output as long as that.

Plane vectors are complex numbers, as in `samples`.
"""

from __future__ import annotations

from cmath import rect
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cases import Case, Mode
from cases.contact import belt_speed
from cases.corner import Piece
from cases.free_plates import plate_contacts
from cases.piece_case import PieceCase
from cases.trajectory import CONTACT

from .. import plates, several
from ..minimal.integrators.segment import Segment
from ..minimal.modes import FLIGHT, Phase
from ..plates.plate_places import flush
from ..plates.plates_phase import PlatesPhase, moving_contacts
from ..plates.plates_system import COLUMNS as PLATES_COLUMNS
from ..several.equations import COLUMNS, FIRST_COLUMN
from ..several.output import contact_states
from ..several.regimes import SeveralPhase
from .samples import ContactLaw, law_at

# Phases that are looked at: of more, so many that are evenly distributed.
MOST = 500


class PlateInstant(NamedTuple):
    """One plate: place (m), direction of its own x axis and velocity (m/s), complex, and spin (rad/s)."""

    place: complex
    turn: complex
    velocity: complex
    spin: float


class TouchInstant(NamedTuple):
    """A closed contact: its laws, mode, slip velocity (m/s), normal and friction force (N, NaN where they are not
    unique), and the gap of its points (m)."""

    law: ContactLaw
    mode: Mode
    slip: float
    normal: float
    friction: float
    gap: float = 0.0


class PhaseInstants(NamedTuple):
    """A phase at a few instants, the first at its start and the last at its end (s): plates in the case's order, and
    closed contacts; `number`: that of its segment; `near`: parameters of the track at its contact."""

    number: int
    times: list[float]
    plates: list[tuple[PlateInstant, ...]]
    contacts: list[list[TouchInstant]]
    near: list[float]


def of_phases(case: Case, segments: Sequence[Segment]) -> list[PhaseInstants]:
    """The phases of a motion, at most MOST of them, each with the one that follows."""
    count = len(segments)
    some: Sequence[int] = range(count)
    if count > MOST:
        even = np.linspace(0, count - 2, MOST // 2).astype(int)
        some = np.union1d(even, even + 1).tolist()
    return [_of_phase(case, i, segments[i]) for i in some]


def _of_phase(case: Case, number: int, segment: Segment) -> PhaseInstants:
    phase, instants = segment.phase, segment.instants()
    if isinstance(phase, SeveralPhase):
        rows = _several_contacts(case, phase, instants)
        poses = [(_plate(*y[:3], *y[-3:]),) for _, y in instants]
        return PhaseInstants(number, [t for t, _ in instants], poses, rows, [])
    if isinstance(phase, PlatesPhase):
        half = 3 * (1 + len(case.others))
        every = [
            tuple(_plate(*y[i : i + 3], *y[half + i : half + i + 3]) for i in range(0, half, 3)) for _, y in instants
        ]
        return PhaseInstants(number, [t for t, _ in instants], every, _contacts_of_plates(case, phase, instants), [])
    if phase.regime == FLIGHT:
        flight = [(_plate(*y[:6]),) for _, y in instants]
        return PhaseInstants(number, [t for t, _ in instants], flight, [[] for _ in instants], [])
    return _one_contact(case, number, phase, instants)


def _plate(x: float, y: float, theta: float, vx: float, vy: float, spin: float) -> PlateInstant:
    return PlateInstant(complex(x, y), rect(1.0, theta), complex(vx, vy), spin)


def _one_contact(case: Case, number: int, phase: Phase, instants) -> PhaseInstants:
    """Pose by (5) and (6), velocities by (11), forces from the phase's equations."""
    law, mode, mass, system = law_at(case, CONTACT), phase.regime.mode, case.plate.mass, phase.system
    track, outline = phase.case.track, phase.case.plate.outline
    shift = phase.case.first.shift if isinstance(phase.case, PieceCase) else 0.0
    result = PhaseInstants(number, [], [], [], [])
    for t, y in instants:
        values = system.record(*system.outputs_of_numbers(t, y, phase.parameters))
        (base, tangent), (own, along) = _point_and_tangent(track, y[0]), _point_and_tangent(outline, y[1])
        turn = tangent * along.conjugate()
        carried = values.slip + (belt_speed(case, t) if law.belt else 0.0)
        velocity = carried * tangent - 1j * values.omega * turn * own
        result.times.append(t)
        result.plates.append((PlateInstant(base - turn * own, turn, velocity, values.omega),))
        result.contacts.append([TouchInstant(law, mode, values.slip, mass * values.normal, mass * values.friction)])
        result.near.append(y[0] + shift)
    return result


def _point_and_tangent(curve: Piece, s: float) -> tuple[complex, complex]:
    """The point of a piece at a parameter, and its unit tangent."""
    x, y, dx, dy, *_ = curve.jet(s)
    length = abs(complex(dx, dy))
    return complex(x, y), complex(dx, dy) / length if length else complex(*curve.tangent(s))


def _several_contacts(case: Case, phase: SeveralPhase, instants) -> list[list[TouchInstant]]:
    """The closed contacts of one plate with several."""
    regime, mass = several.regime_of(phase), case.plate.mass
    laws = {k: law_at(case, regime.names[k]) for k in regime.closed}
    if regime.has_open_forces:
        times, states = np.array([t for t, _ in instants]), np.array([y for _, y in instants]).T
        columns = {k: contact_states(case, phase, times, states, regime.names[k]) for k in regime.closed}
        return [
            [
                TouchInstant(
                    laws[k], regime.modes[k], float(c.slip[i]), float(c.normal_force[i]), float(c.friction_force[i])
                )
                for k, c in columns.items()
            ]
            for i in range(len(instants))
        ]  # fmt: skip
    results = []
    for t, y in instants:
        values, now = phase.system.outputs_of_numbers(t, y, phase.parameters), []
        for k, law in laws.items():
            normal, friction, slip, gap, _ = values[FIRST_COLUMN + len(COLUMNS) * k :][: len(COLUMNS)]
            now.append(TouchInstant(law, regime.modes[k], slip, mass * normal, mass * friction, gap))
        results.append(now)
    return results


def _contacts_of_plates(case: Case, phase: PlatesPhase, instants) -> list[list[TouchInstant]]:
    """The closed contacts of several plates but for those between plates at rest, whose forces take a search for
    vertices. Of the friction of two corners that stick to one line only the sum is unique."""
    regime, every = plates.regime_of(phase), plate_contacts(case)
    moving = moving_contacts(case, regime)
    seconds = flush(case, [number for number, mode in moving if mode is Mode.ROLL])
    pairs = {*seconds, *seconds.values()}
    first = 2 + 3 * (1 + len(case.others))
    results = []
    for t, y in instants:
        values, now = phase.system.outputs_of_numbers(t, y, phase.parameters), []
        for k, (number, mode) in enumerate(moving):
            if mode is not Mode.FLIGHT:
                normal, friction, slip, gap = values[first + len(PLATES_COLUMNS) * k :][: len(PLATES_COLUMNS)]
                friction = np.nan if number in pairs else friction
                now.append(TouchInstant(law_at(case, every[number].name), mode, slip, normal, friction, gap))
        results.append(now)
    return results
