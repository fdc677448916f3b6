"""The check of every solution before it is returned: its plates and contacts at a few instants of each phase, from the
states and equations that its integrator has, by the laws of `laws_check`.
"""

from __future__ import annotations

from cmath import rect
from collections.abc import Callable, Sequence
from functools import lru_cache
from math import nan
from operator import itemgetter
from typing import Any

import numpy as np

from cases import Belt, Case, Mode, Transition
from cases.motion.trajectory import CONTACT
from cases.scene.piece_case import PieceCase

from . import solver
from .endings import Ending, law_ending
from .laws_check.automatic_check import faults_at
from .laws_check.instants import PhaseInstants, PlateInstant, TouchInstant
from .laws_check.samples import law_at, place_at
from .minimal.integrators.segment import Instant, Segment
from .minimal.modes import Phase
from .solver.regimes import SolverPhase
from .solver.system import COLUMNS

# Phases that are looked at: of more, so many that are evenly distributed. Of more than a few, only some are looked at
# between their start and end: an instant takes 10 µs, and a phase 100 µs.
MOST, FEW = 500, 4


def ending_by_laws(case: Case, solution: tuple[Sequence[Segment], Sequence[Transition], Ending], rtol: float) -> Ending:
    """The ending of a solution (segments, transitions, ending) of a case with a track at rest that obeys the laws, or
    the status BROKEN_LAW with the law in a sentence."""
    segments, transitions, (status, reason) = solution
    if not segments:
        return status, reason
    every = faults_at(case, _phases(case, segments), transitions, rtol)
    if not every:
        return status, reason
    return law_ending(every[0], (status, reason))


def _phases(case: Case, segments: Sequence[Segment]) -> list[PhaseInstants]:
    """The phases of a motion, at most MOST of them, each with the one that follows."""
    count = len(segments)
    some: Sequence[int] = range(count)
    if count > MOST:
        even = np.linspace(0, count - 2, MOST // 2).astype(int)
        some = np.union1d(even, even + 1).tolist()
    every = 1 + count // FEW
    return [_of_phase(case, i, segments[i], inside=i % every == 0) for i in some]


def _of_phase(case: Case, number: int, segment: Segment, inside: bool) -> PhaseInstants:
    phase, instants = segment.phase, segment.instants(inside)
    if isinstance(phase, SolverPhase):
        count, times = 3 * (1 + len(case.others)), [t for t, _ in instants]
        every = [
            tuple(_plate(*y[i : i + 3], *y[len(y) - count + i : len(y) - count + i + 3]) for i in range(0, count, 3))
            for _, y in instants
        ]
        contacts = _several_contacts(case, phase, instants)
        belts = [abs(law.belt.at(t)[0]) for law, *_ in contacts[0] if law.belt is not None for t in times]
        return PhaseInstants(number, times, every, contacts, belt=max(belts, default=0.0))
    return _one_contact(case, number, phase, instants)


def _plate(x: float, y: float, theta: float, vx: float, vy: float, spin: float) -> PlateInstant:
    return complex(x, y), rect(1.0, theta), complex(vx, vy), spin


def _one_contact(case: Case, number: int, phase: Phase, instants: Sequence[Instant]) -> PhaseInstants:
    """Pose by (5) and (6), velocities by (11), forces from the phase's equations."""
    law, mode, mass, parameters = law_at(case, CONTACT), phase.regime.mode, case.plate.mass, phase.parameters
    columns, quantities = _columns(phase.system.record), phase.system.outputs_of_numbers
    track, outline, belt = phase.case.track, phase.case.plate.outline, case.effect(Belt)
    shift = phase.case.first.shift if isinstance(phase.case, PieceCase) else 0.0
    times, poses, contacts, near, fastest = [], [], [], [], 0.0
    for t, y in instants:
        slip, spin, normal, friction = columns(quantities(t, y, parameters))
        (base, tangent), (own, along) = place_at(track, y[0]), place_at(outline, y[1])
        turn = tangent * along.conjugate()
        arm = turn * own
        speed = slip
        if belt is not None:
            under = belt.at(t)[0]
            speed, fastest = slip + under, max(fastest, abs(under))
        times.append(t)
        poses.append(((base - arm, turn, speed * tangent - 1j * spin * arm, spin),))
        contacts.append([(law, mode, slip, mass * normal, mass * friction, 0.0)])
        near.append(y[0] + shift)
    return PhaseInstants(number, times, poses, contacts, near, fastest)


@lru_cache(maxsize=16)
def _columns(record: Any) -> Callable[[Sequence[float]], tuple[float, ...]]:
    """Slip, spin, normal and friction force per mass from the outputs of equations with those columns."""
    return itemgetter(*(record._fields.index(name) for name in ("slip", "omega", "normal", "friction")))


def _several_contacts(case: Case, phase: SolverPhase, instants: Sequence[Instant]) -> list[list[TouchInstant]]:
    """The closed contacts in poses but for those between plates at rest and those whose forces are not unique, which
    take a search for vertices. Of the friction of two contacts with one slip that stick only the sum is unique."""
    regime = solver.regime_of(phase)
    pairs = {k for both in enumerate(regime.shares) if both[1] is not None for k in both}
    closed = [
        k for k, mode in enumerate(regime.modes)
        if mode is not Mode.FLIGHT and not set(solver.sides(case, regime, k)) <= regime.resting
        and not (regime.guides and regime.guides[k] is not None)
    ]  # fmt: skip
    laws, first = [law_at(case, regime.names[k]) for k in closed], 2 + 3 * (1 + len(case.others))
    results = list[list[TouchInstant]]()
    for t, y in instants:
        values = phase.system.outputs_of_numbers(t, y, phase.parameters) if closed else ()
        results.append([])
        for k, law in zip(closed, laws, strict=True):
            normal, friction, slip, gap = values[first + len(COLUMNS) * k :][: len(COLUMNS)]
            friction = nan if k in pairs else friction
            results[-1].append((law, regime.modes[k], slip, normal, friction, gap))
    return results
