"""Plates that their contacts hold at rest while others move on them, as a disc in a corner on which another one rolls.

The contacts between such plates, floor and walls may have more forces than the plates have equations. They do not move
any plate, so the equations of the others have no part of them: there a held plate is as fixed as a wall. It stays so as
long as some admissible forces balance its load and what the moving plates press on it (`several.forces`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import cast

import numpy as np

from cases import Case
from cases.free_plates import plate_contacts

from ..minimal.integrators.segment import Segment
from ..several import forces
from ..several.rest import first_loss_in
from .plate_places import numbers_of, places, plates_in
from .plates_phase import PlatesPhase, moving_contacts, regime_of
from .plates_system import COLUMNS


def held_sets(case: Case, state: Sequence[float], group: Sequence[int]) -> Iterator[frozenset[int]]:
    """The sets of plates of a group that its contacts may hold while others of it move: they are still, and each
    touches the floor, a wall or another one of them."""
    speeds, plates = np.array(state[len(state) // 2 :]).reshape(-1, 3), plates_in(case, group)
    still = sorted(b for b in plates if not speeds[b].any())
    for count in range(1, len(still) + 1):
        for some in map(frozenset, combinations(still, count)):
            if some != plates and plates_in(case, inner_contacts(case, group, some)) == some:
                yield some


def inner_contacts(case: Case, group: Sequence[int], anchors: frozenset[int]) -> list[int]:
    """Those contacts of a group that touch no plate but held ones."""
    return [n for n in group if plates_in(case, [n]) <= anchors]


def load_and_units(
    case: Case, plates: frozenset[int], pressing: np.ndarray | float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """The load (3n,) on some plates (N, N, N m) with what others press on them, and the units of the equations of their
    equilibrium: 0 for those of other plates, and for the moment of a plate that cannot turn."""
    numbers = numbers_of(case)
    own = np.repeat([b in plates for b in range(len(numbers.radii))], 3) & (numbers.inverse > 0.0)
    mass = np.divide(1.0, numbers.inverse, out=np.zeros(len(own)), where=own)
    return numbers.load * mass + np.where(own, pressing, 0.0), own / numbers.lengths


def margin(
    case: Case, state: Sequence[float], inner: Sequence[int], plates: frozenset[int], pressing: np.ndarray | float = 0.0
) -> float:
    """By how much the inner contacts hold those plates, as `forces.margin`; `pressing` (3n,) as in `load_and_units`."""
    now = places(case, inner, state)
    return forces.margin(now, *load_and_units(case, plates, pressing), [at.stick for at in now])


def pressing_forces(phase: PlatesPhase, t: float, state: Sequence[float], anchors: frozenset[int]) -> np.ndarray:
    """Forces and moments (3n,) of moving plates on held ones, N and N m."""
    regime, total = regime_of(phase), np.zeros(len(state) // 2)
    moving = moving_contacts(phase.case, regime)
    links = [(k, n) for k, (n, _) in enumerate(moving) if n in regime.closed and plates_in(phase.case, [n]) & anchors]
    if not links:
        return total
    outputs, first = phase.system.outputs_of_numbers(t, tuple(state), phase.parameters), 2 + len(total)
    for (k, _), at in zip(links, places(phase.case, [n for _, n in links], state), strict=True):
        normal, friction = outputs[first + len(COLUMNS) * k : first + len(COLUMNS) * k + 2]
        total += normal * at.lift_row + friction * at.slip_row
    return total


def held_plates(phase: PlatesPhase) -> frozenset[int]:
    """The plates at rest of a phase on which moving plates press."""
    regime, every = regime_of(phase), plate_contacts(phase.case)
    links = {number for number, _ in moving_contacts(phase.case, regime)} & set(regime.closed)
    touched = {side for n in links for side in (every[n].body, every[n].base) if side in regime.resting}
    inner = inner_contacts(phase.case, regime.closed, regime.resting)
    while more := plates_in(phase.case, [n for n in inner if plates_in(phase.case, [n]) & touched]) - touched:
        touched |= more
    return frozenset(cast(set[int], touched))


def end_of_hold(segment: Segment) -> float | None:
    """When the contacts of held plates cannot balance the others any more, s; None if they can in the whole segment."""
    phase = cast(PlatesPhase, segment.phase)
    anchors = held_plates(phase)
    if not anchors:
        return None
    inner = inner_contacts(phase.case, regime_of(phase).closed, anchors)

    def margin_at(t: float) -> float:
        state = segment.states(np.array([t]))[:, 0].tolist()
        return margin(phase.case, state, inner, anchors, pressing_forces(phase, t, state, anchors))

    return first_loss_in(segment, margin_at)
