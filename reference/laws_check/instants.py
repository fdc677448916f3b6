"""The plates and contacts of a motion at a few instants of each phase, in numbers: a motion by the Taylor method takes
0.3 ms, and arrays of its dense output as long as that.

Plane vectors are complex numbers, as in `samples`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from cases import Mode

from .samples import ContactLaw

# A plate's place (m), direction of its own x axis and velocity (m/s), complex, and spin (rad/s).
PlateInstant = tuple[complex, complex, complex, float]
# A closed contact's laws and mode, slip velocity (m/s), normal and friction force (N, NaN where they are not unique),
# and the gap of its points (m).
TouchInstant = tuple[ContactLaw, Mode, float, float, float, float]


class PhaseInstants(NamedTuple):
    """A phase at a few instants, the first at its start and the last at its end (s): plates in the case's order, and
    closed contacts; `number`: that of its segment; `near`: parameters of the track at its contact; `belt`: the largest
    speed of belts under its contacts (m/s)."""

    number: int
    times: list[float]
    plates: Sequence[tuple[PlateInstant, ...]]
    contacts: list[list[TouchInstant]]
    near: Sequence[float] = ()
    belt: float = 0.0
