"""Columns of a motion with several contacts: of the plate, and of each contact."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import NamedTuple, cast

import numpy as np

from cases import Case, State, Transition
from cases.contact import belt_speed
from cases.contact_pairs import PairCase
from cases.trajectory import CONTACT, ContactColumns

from ..minimal.effects import SLIP_SIGN
from ..minimal.integrators.segment import Segment, blocks
from .contact_law import STICKING, kinetic, resisting_arm
from .decision import depends_on_time, limits_of_couples, limits_of_friction, load_at, load_on_belts
from .equations import COLUMNS, FIRST_COLUMN
from .forces import ForceRanges, ranges, units_of
from .geometry import TURNING_ROW, ContactPlace, places
from .meetings import gaps
from .regimes import SeveralPhase, SeveralRegime, body_of, contacts_of, pairs_of, regime_of

# Equations of equilibrium whose singular values are below this part of the largest, and forces that take a smaller part
# in what balances nothing, are rounded zeros.
OPEN_FORCE = 1e-9


class OneContactColumns(NamedTuple):
    """One contact at n instants, arrays (n,), as the first columns of `cases.ContactColumns`."""

    gap: np.ndarray
    slip: np.ndarray
    normal_force: np.ndarray
    friction_force: np.ndarray
    xi1: np.ndarray
    xi2: np.ndarray


class AllContacts:
    """The contacts of a motion: (name, times) -> ContactColumns; None instead of times: those of its samples.

    `observe` gives the State of a phase with one contact at some times. It is pickled with all steps. The ranges of
    forces that are not unique take a search for vertices at every time: `without_ranges` leaves them NaN.
    """

    def __init__(self, case: Case, segments: list[Segment], transitions: Sequence[Transition], observe: Callable):
        self.case, self.segments, self.observe = case, segments, observe
        self.touched = {change.contact for change in transitions if change.contact}

    @property
    def names(self) -> tuple[str, ...]:
        """The contacts' names in the order of their numbers."""
        regimes = [regime_of(s.phase) for s in self.segments if isinstance(s.phase, SeveralPhase)]
        names = {regime.names[k] for regime in regimes for k in regime.closed} | self.touched
        return tuple(sorted(names | {CONTACT}, key=_order))

    def without_ranges(self, name: str, times: np.ndarray | None) -> ContactColumns:
        """The same without the ranges of forces that are not unique."""
        return self(name, times, with_ranges=False)

    def __call__(self, name: str, times: np.ndarray | None, with_ranges: bool = True) -> ContactColumns:
        if times is None:
            return _join([self._of(segment, name, segment.times, with_ranges) for segment in self.segments])
        columns = [np.empty(len(times)) for _ in OneContactColumns._fields] + [
            np.empty((2, len(times))) for _ in range(2)
        ]
        for i, block in blocks(np.array([segment.start for segment in self.segments]), times):
            part = self._of(self.segments[i], name, times[block], with_ranges)
            for column, values in zip(columns, part, strict=True):
                column[..., block] = values
        return ContactColumns(*columns)

    def _of(self, segment: Segment, name: str, times: np.ndarray, with_ranges: bool) -> ContactColumns:
        y = segment.states(times)
        if not isinstance(segment.phase, SeveralPhase):
            return self._one_contact(segment, name, times, y)
        now = contact_states(self.case, segment.phase, times, y, name)
        normal, friction = (np.array([values, values]) for values in (now.normal_force, now.friction_force))
        open_forces = np.flatnonzero(np.isnan(now.normal_force) | np.isnan(now.friction_force))
        if with_ranges and len(open_forces):
            moves = bool(regime_of(segment.phase).guides) or depends_on_time(self.case)
            for i in open_forces.tolist():
                time = float(times[i if moves else open_forces[0]])
                normal[:, i], friction[:, i] = force_ranges(self.case, segment, time)[name]
        return ContactColumns(*now, normal, friction)

    def _one_contact(self, segment: Segment, name: str, times: np.ndarray, y: np.ndarray) -> ContactColumns:
        """The columns before the second contact."""
        none, nothing = np.full(times.shape, np.nan), np.zeros(times.shape)
        if name != CONTACT:
            return ContactColumns(none, none, nothing, nothing, none, none, *np.zeros((2, 2, len(times))))
        now = self.observe(self.case, segment.phase, times, y)
        normal, friction = (np.broadcast_to(v, times.shape) for v in (now.normal_force, now.friction_force))
        gap = np.where(np.isnan(np.broadcast_to(now.slip, times.shape)), np.nan, 0.0)
        ranges = np.array([normal, normal]), np.array([friction, friction])
        return ContactColumns(gap, now.slip, normal, friction, now.xi1, now.xi2, *ranges)


def _order(name: str) -> tuple[str, int]:
    """The track's contacts first, those of a support by their numbers."""
    support, _, number = name.partition(" ")
    return "" if support == CONTACT else support, int(number or 1)


def _join(parts: list[ContactColumns]) -> ContactColumns:
    """The columns of all parts one after the other."""
    return ContactColumns(*(np.concatenate(columns, axis=-1) for columns in zip(*parts, strict=True)))


def contact_states(case: Case, now: SeveralPhase, times: np.ndarray, y: np.ndarray, name: str) -> OneContactColumns:
    """One contact of a phase at some instants; `y` (variables, n)."""
    none, regime = np.full(times.shape, np.nan), regime_of(now)
    if name not in regime.names:
        return OneContactColumns(none, none, 0.0 * times, 0.0 * times, none, none)
    k = regime.names.index(name)
    xi1, xi2 = y[3 + 2 * k], contacts_of(case, regime)[k].whole_xi2(y[4 + 2 * k])
    is_closed, mass = k in regime.closed, case.plate.mass
    if regime.rests:
        normal, friction = _rest_forces(case, now, times, y, k)
        return OneContactColumns(
            _gap(now, y, k, is_closed), 0.0 * times if is_closed else none, normal, friction, xi1, xi2
        )
    values = now.system.outputs_of_arrays(times, y, now.parameters)
    first = FIRST_COLUMN + len(COLUMNS) * k
    columns = values[first : first + len(COLUMNS)]
    normal, friction, slip, _, _ = (np.broadcast_to(np.asarray(row, dtype=float), times.shape) for row in columns)
    slip = 0.0 * slip if regime.modes[k] in STICKING else slip
    if regime.guides:
        normal, friction = _forces_on_belts(case, now, times, y, k)
    else:
        normal, friction = mass * normal, mass * friction
    return OneContactColumns(_gap(now, y, k, is_closed), slip if is_closed else none, normal, friction, xi1, xi2)


def _gap(now: SeveralPhase, y: np.ndarray, k: int, is_closed: bool) -> np.ndarray:
    """The distance of contact k's points, 0 while it is closed."""
    return np.zeros(y.shape[1]) if is_closed else gaps(contacts_of(now.case, regime_of(now))[k], y, k)


def _rest_forces(case: Case, now: SeveralPhase, times: np.ndarray, y: np.ndarray, k: int):
    """Normal and friction force of contact k of a plate at rest, NaN where they are not unique."""
    closed = regime_of(now).closed
    if k not in closed:
        return 0.0 * times, 0.0 * times
    load = np.array([load_at(case, float(t), body_of(y[:, 0])) for t in times]).T
    return _balance(case, regime_of(now), times[:1], y[:, :1], load, k)


def _forces_on_belts(case: Case, now: SeveralPhase, times: np.ndarray, y: np.ndarray, k: int):
    """The same for contacts with more than three rows, which belts may move."""
    if k not in regime_of(now).closed:
        return 0.0 * times, 0.0 * times
    load = np.array([load_on_belts(now, t, state) for t, state in zip(times.tolist(), y.T, strict=True)]).T
    return _balance(case, regime_of(now), times, y, load, k)


def _balance(
    case: Case, regime: SeveralRegime, times: np.ndarray, states: np.ndarray, load: np.ndarray, k: int
) -> tuple[np.ndarray, np.ndarray]:
    """Normal and friction force of contact k that balance loads (3, n), NaN where they are not unique. `states`, at
    `times`: as many, or one state (variables, 1) for all loads."""
    closed, at = regime.closed, _closed_places(case, regime, states[:, 0])
    modes = [regime.modes[number] for number in closed]
    sticking = [i for i, mode in enumerate(modes) if at[i].stick > 0.0 and mode in STICKING]
    contacts = [contacts_of(case, regime)[number] for number in closed]
    each = [_rows(contact, states, number) for contact, number in zip(contacts, closed, strict=True)]
    ratios = {
        i: -SLIP_SIGN[mode] * kinetic(contacts[i], _slip(contacts[i], each[i][0], times, states))
        for i, mode in enumerate(modes) if mode in SLIP_SIGN
    }  # fmt: skip
    shares = [np.reshape(ratios.get(i, 0.0), (-1, 1)) for i in range(len(closed))]
    rows = [lift + share * slip for share, (slip, lift) in zip(shares, each, strict=True)] + [
        each[i][0] for i in sticking
    ]
    if regime.turn:
        for i, contact in enumerate(contacts):
            rows[i] = rows[i] - regime.turn * resisting_arm(contact) * TURNING_ROW
    elif regime.turn == 0:  # the sum of the couples
        rows.append(np.broadcast_to(TURNING_ROW, rows[0].shape))
    units = units_of(case.plate)
    matrix = units[:, None] * np.stack(rows, axis=-1)
    values = -(np.linalg.pinv(matrix, rcond=OPEN_FORCE) @ (units[:, None] * load).T[:, :, None])[:, :, 0].T
    # Forces that balance nothing may be added: the normal forces on one line are unique, their frictions' sum is.
    _, sizes, basis = np.linalg.svd(matrix)
    rank = (sizes > OPEN_FORCE * sizes[:, :1]).sum(axis=1)
    free = np.arange(basis.shape[1]) >= rank[:, None]
    is_open = (free[:, :, None] & (np.abs(basis) > OPEN_FORCE)).any(axis=1).T
    values = np.where(is_open, np.nan, values)
    i = closed.index(k)
    if i in sticking:
        return values[i], values[len(closed) + sticking.index(i)]
    return values[i], ratios[i] * values[i] if i in ratios else np.zeros(load.shape[1])


def _rows(contact: PairCase, states: np.ndarray, k: int) -> tuple[np.ndarray, np.ndarray]:
    """The rows of contact k's slip and lift velocity in (vx, vy, ω), as `geometry.place` has them, shape (n, 3)."""
    theta, (xi1, xi2) = states[2], states[3 + 2 * k : 5 + 2 * k]
    (tx, ty), (u, v) = contact.track.tangent(xi1), contact.plate.outline.point(xi2)
    c, s = np.cos(theta), np.sin(theta)
    rx, ry = c * u - s * v, s * u + c * v
    return np.stack([tx, ty, ty * rx - tx * ry], axis=-1), np.stack([-ty, tx, tx * rx + ty * ry], axis=-1)


def _slip(contact: PairCase, slip_row: np.ndarray, times: np.ndarray, states: np.ndarray) -> np.ndarray:
    """The slip velocity (n,) of a contact with the rows (n, 3) of `_rows`, m/s."""
    return (slip_row * states[-3:].T).sum(axis=1) - np.array([belt_speed(contact, t) for t in times.tolist()])


def _closed_places(case: Case, regime: SeveralRegime, state: np.ndarray) -> list[ContactPlace]:
    """The closed contacts in a state."""
    contacts, pairs = contacts_of(case, regime), pairs_of(state)
    return places([contacts[k] for k in regime.closed], body_of(state), [pairs[k] for k in regime.closed])


def observe(case: Case, now: SeveralPhase, times: np.ndarray, y: np.ndarray) -> State:
    """The plate's pose and velocities, and slip, forces and parameters of the first closed contact; as in flight if
    none is closed."""
    closed = regime_of(now).closed
    x, y0, theta, vx, vy, omega = *y[:3], *y[-3:]
    if not closed:
        none, nothing = np.full(times.shape, np.nan), np.zeros(times.shape)
        return State(x, y0, theta, vx, vy, omega, none, nothing, nothing, none, none)
    one = contact_states(case, now, times, y, regime_of(now).names[closed[0]])
    return State(x, y0, theta, vx, vy, omega, one.slip, one.normal_force, one.friction_force, one.xi1, one.xi2)


@lru_cache(maxsize=2048)  # the times at which the columns of each contact in turn are computed
def force_ranges(case: Case, segment: Segment, t: float) -> dict[str, np.ndarray]:
    """For each closed contact at an instant: least and greatest normal force and friction force, shape (2, 2)."""
    now, state = cast(SeveralPhase, segment.phase), segment.states(np.array([t]))[:, 0]
    regime = regime_of(now)
    names = [regime.names[k] for k in regime.closed]
    if not regime.has_open_forces:
        values = [contact_states(case, now, np.array([t]), state[:, None], name) for name in names]
        pairs = [(float(one.normal_force[0]), float(one.friction_force[0])) for one in values]
        return {name: np.array([[n, n], [f, f]]) for name, (n, f) in zip(names, pairs, strict=True)}
    at = _closed_places(case, regime, state)
    load = load_on_belts(now, t, state) if regime.guides else load_at(case, t, body_of(state))
    friction = limits_of_friction(at, [regime.modes[k] for k in regime.closed], t, state)
    couples = limits_of_couples(at, regime.turn)
    limits: ForceRanges = ranges(at, load, units_of(case.plate), friction, couples)
    return {name: np.array([limits.normal[i], limits.friction[i]]) for i, name in enumerate(names)}
