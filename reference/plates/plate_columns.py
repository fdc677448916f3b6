"""Columns of a motion of several plates: of each plate, and of each contact."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import cast

import numpy as np

from cases import Case, Mode, State, Transition
from cases.free_plates import names_of, plate_contacts
from cases.trajectory import ContactColumns

from ..minimal.integrators.segment import Segment, blocks
from ..several import forces
from .held_plates import held_plates, inner_contacts, load_and_units, pressing_forces
from .plate_places import coordinates, flush, groups, place, places, plates_in
from .plates_phase import PlatesPhase, moving_contacts, regime_of
from .plates_system import COLUMNS


@dataclass
class AllPlates:
    """The plates of a motion: (name, times) -> State without contact columns; None instead of times: those of its
    samples. It is pickled with all steps."""

    case: Case
    segments: list[Segment]

    def __call__(self, name: str, times: np.ndarray | None) -> State:
        body = names_of(self.case).index(name)
        if times is None:
            return _join([_plate(segment.states(segment.times), body) for segment in self.segments])
        values = np.empty((len(State._fields), len(times)))
        for i, block in blocks(np.array([segment.start for segment in self.segments]), times):
            values[:, block] = _plate(self.segments[i].states(times[block]), body)
        return State(*values)


def _plate(y: np.ndarray, body: int) -> State:
    """Pose and velocities of one plate; nothing is known of its contacts as a whole."""
    half, none = len(y) // 2, np.full(y.shape[1], np.nan)
    (x, y0, theta), (vx, vy, omega) = (part[3 * body : 3 * body + 3] for part in (y[:half], y[half:]))
    return State(x, y0, theta, vx, vy, omega, none, none, none, none, none)


def _join(parts: Sequence[State]) -> State:
    return State(*(np.concatenate(column) for column in zip(*parts, strict=True)))


@dataclass
class AllPlateContacts:
    """The contacts of a motion: (name, times) -> ContactColumns, as `several.AllContacts`."""

    case: Case
    segments: list[Segment]
    transitions: Sequence[Transition]

    @property
    def names(self) -> tuple[str, ...]:
        """The names of all contacts that close, in the order of their numbers."""
        closed = {number for segment in self.segments for number in regime_of(segment.phase).closed}
        touched = {change.contact for change in self.transitions}
        return tuple(c.name for n, c in enumerate(plate_contacts(self.case)) if n in closed or c.name in touched)

    def __call__(self, name: str, times: np.ndarray | None) -> ContactColumns:
        if times is None:
            parts = [self._of(segment, name, segment.times) for segment in self.segments]
            return ContactColumns(*(np.concatenate(columns, axis=-1) for columns in zip(*parts, strict=True)))
        columns = [np.empty(len(times)) for _ in range(6)] + [np.empty((2, len(times))) for _ in range(2)]
        for i, block in blocks(np.array([segment.start for segment in self.segments]), times):
            for column, values in zip(columns, self._of(self.segments[i], name, times[block]), strict=True):
                column[..., block] = values
        return ContactColumns(*columns)

    def _of(self, segment: Segment, name: str, times: np.ndarray) -> ContactColumns:
        (number,) = [n for n, contact in enumerate(plate_contacts(self.case)) if contact.name == name]
        return contact_columns(self.case, cast(PlatesPhase, segment.phase), times, segment.states(times), number)


def contact_columns(case: Case, now: PlatesPhase, times: np.ndarray, y: np.ndarray, number: int) -> ContactColumns:
    """One contact of a phase at some instants; `y` (variables, n)."""
    regime, none, nothing = regime_of(now), np.full(times.shape, np.nan), np.zeros(times.shape)
    gap, *parameters = coordinates(case, number, y)
    xi1, xi2 = map(np.unwrap, parameters)
    if number not in regime.closed:
        return ContactColumns(gap, none, nothing, nothing, xi1, xi2, *np.zeros((2, 2, len(times))))
    moving = moving_contacts(case, regime)
    k = next((k for k, (other, _) in enumerate(moving) if other == number), None)
    if k is None:
        normal, friction = _rest_ranges(case, now, times, y, number)
        weight = float(np.abs(load_and_units(case, frozenset(range(len(y) // 6)))[0]).max())
        values = [nothing + forces.values(limit.T, weight) for limit in (normal, friction)]
        limits = [nothing + limit for limit in (normal, friction)]
        return ContactColumns(nothing, nothing, values[0], values[1], xi1, xi2, limits[0], limits[1])
    columns = now.system.outputs_of_arrays(times, y, now.parameters)
    first = 2 + len(y) // 2 + len(COLUMNS) * k
    normal, friction, slip, _ = (
        np.broadcast_to(np.asarray(row, dtype=float), times.shape) for row in columns[first : first + len(COLUMNS)]
    )
    seconds = flush(case, [other for other, mode in moving if mode is Mode.ROLL])
    partner = (seconds | {first: second for second, first in seconds.items()}).get(number)
    if partner is not None:
        return _at_partner(case, now, times, y, (number, partner), (xi1, xi2))
    slip = 0.0 * slip if dict(moving)[number] is Mode.ROLL else slip
    pairs = (np.array([values, values]) for values in (normal, friction))
    return ContactColumns(nothing, slip, normal, friction, xi1, xi2, *pairs)


def _at_partner(
    case: Case, now: PlatesPhase, times: np.ndarray, y: np.ndarray, both: tuple[int, int],
    parameters: tuple[np.ndarray, np.ndarray],
) -> ContactColumns:  # fmt: skip
    """The first of two corners of a plate that stick to one line: of both friction forces only the sum is unique."""
    columns, order = now.system.outputs_of_arrays(times, y, now.parameters), dict(moving_contacts(case, regime_of(now)))
    firsts = [2 + len(y) // 2 + len(COLUMNS) * list(order).index(number) for number in both]
    normals, frictions = (
        [np.broadcast_to(np.asarray(columns[first + i], dtype=float), times.shape) for first in firsts] for i in (0, 1)
    )
    total, stick, nothing = sum(frictions), place(case, both[0], y[:, 0]).stick, np.zeros(times.shape)
    own, other = (stick * np.maximum(normal, 0.0) for normal in normals)
    limits = np.array([np.maximum(-own, total - other), np.minimum(own, total + other)])
    weight = float(np.abs(load_and_units(case, frozenset(range(len(y) // 6)))[0]).max())
    friction = forces.values(limits.T, weight)
    return ContactColumns(nothing, nothing, normals[0], friction, *parameters, np.array([normals[0]] * 2), limits)


def _rest_ranges(
    case: Case, now: PlatesPhase, times: np.ndarray, y: np.ndarray, number: int
) -> tuple[np.ndarray, np.ndarray]:
    """Least and greatest normal and friction force (N) of a contact of plates at rest, (2, n) each; (2, 1) if they are
    the same all the time, as nothing that moves presses on the plates."""
    regime = regime_of(now)
    inner = inner_contacts(case, regime.closed, regime.resting)
    group = tuple(next(some for some in groups(case, inner) if number in some))
    plates, ranges = plates_in(case, group), list[forces.ForceRanges]()
    is_pressed = bool(plates & held_plates(now))
    for t, state in zip(times.tolist(), y.T, strict=True) if is_pressed else [(0.0, y[:, 0])]:
        pressing = pressing_forces(now, t, state.tolist(), plates) if is_pressed else np.zeros(len(y) // 2)
        ranges.append(_group_ranges(case, group, np.ascontiguousarray(state).tobytes(), pressing.tobytes()))
    k = group.index(number)
    return np.array([one.normal[k] for one in ranges]).T, np.array([one.friction[k] for one in ranges]).T


# The ranges of all contacts at so many instants are kept: those of a motion's samples, for one contact after the other.
@lru_cache(maxsize=4096)
def _group_ranges(case: Case, group: tuple[int, ...], state: bytes, pressing: bytes) -> forces.ForceRanges:
    """The ranges of the forces of some contacts of plates at rest, computed once for all contacts. `state`, `pressing`
    (as of `load_and_units`): the numbers' bytes, because keys that are equal may differ in the sign of a zero."""
    at = places(case, group, np.frombuffer(state))
    load, units = load_and_units(case, plates_in(case, group), np.frombuffer(pressing))
    limits = forces.ranges(at, load, units, [one.stick for one in at])
    for each in limits:
        each.flags.writeable = False  # shared by all callers
    return limits


def observe(case: Case, now: PlatesPhase, times: np.ndarray, y: np.ndarray) -> State:
    """Pose and velocities of the first plate, with slip, forces and parameters of its first closed contact with track
    or support; as in flight if none is closed."""
    state = _plate(y, 0)
    own = [n for n in regime_of(now).closed if plate_contacts(case)[n].body == 0]
    if not own:
        nothing = np.zeros(times.shape)
        return state._replace(normal_force=nothing, friction_force=nothing)
    one = contact_columns(case, now, times, y, own[0])
    return state._replace(
        slip=one.slip, normal_force=one.normal_force, friction_force=one.friction_force, xi1=one.xi1, xi2=one.xi2
    )
