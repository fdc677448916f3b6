"""Columns of a motion: of each plate, and of each contact."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from cases import Case, Mode, State, Transition
from cases.contact import belt_speed, pose
from cases.motion.trajectory import CONTACT, ContactColumns
from cases.scene.couples import couples
from cases.scene.free_plates import names_of
from cases.scene.piece_case import PieceCase

from ..effect_laws.friction import STICKING
from ..minimal.integrators.segment import Segment, blocks
from ..minimal.modes import Phase
from . import forces
from .accelerations import balance_of, is_steady, load_and_units
from .places import ContactPlace, couple_of, groups, place, sides_of
from .plate_numbers import Sides
from .regimes import SolverPhase, SolverRegime, pair_of, regime_of, solver_phase, split
from .system import COLUMNS

# Forces that are not unique are computed once for each instant, of all contacts: a comparison with a motion of some
# thousand samples asks for them ten times. An entry takes 1 kB.
MOST_INSTANTS = 2**14
# Least and greatest normal and friction force (N), (2,) each, by the contact's name.
ForcesByContact = dict[str, tuple[np.ndarray, np.ndarray]]


def evaluate(
    segments: Sequence[Segment], times: np.ndarray | None, of: Callable[[Segment, np.ndarray], Sequence[Any]]
) -> list[np.ndarray]:
    """Columns of a motion at times (n,), along their last axis; None: at its samples. `of`: those of a segment."""
    if times is None or not len(times):
        some = segments if times is None else segments[:1]
        parts = [of(segment, segment.times if times is None else times) for segment in some]
        return [np.concatenate(columns, axis=-1) for columns in zip(*parts, strict=True)]
    columns = list[np.ndarray]()
    for i, block in blocks(np.array([segment.start for segment in segments]), times):
        values = of(segments[i], times[block])
        columns = columns or [np.empty((*value.shape[:-1], len(times))) for value in values]
        for column, value in zip(columns, values, strict=True):
            column[..., block] = value
    return columns


@dataclass
class AllPlates:
    """The plates of a motion: (name, times) -> State without contact columns; None instead of times: those of its
    samples. It is pickled with all steps."""

    case: Case
    segments: list[Segment]

    def __call__(self, name: str, times: np.ndarray | None) -> State:
        body = names_of(self.case).index(name)
        return State(*evaluate(self.segments, times, lambda one, when: plate_state(self.case, one.states(when), body)))


def plate_state(case: Case, y: np.ndarray, body: int) -> State:
    """Pose and velocities of one plate; nothing is known of its contacts as a whole. `y` (variables, n)."""
    none, last = np.full(y.shape[1], np.nan), len(y) - 3 * len(names_of(case))
    x, y0, theta = y[3 * body : 3 * body + 3]
    vx, vy, omega = y[last + 3 * body : last + 3 * body + 3]
    return State(x, y0, theta, vx, vy, omega, none, none, none, none, none)


@dataclass
class AllContacts:
    """The contacts of a motion: (name, times) -> ContactColumns; None instead of times: those of its samples."""

    case: Case
    segments: list[Segment]
    transitions: Sequence[Transition]

    @property
    def names(self) -> tuple[str, ...]:
        """The names of all contacts that close, in the order of their couples and numbers."""
        names = {change.contact for change in self.transitions if change.contact}
        names |= set() if self.case.others else {CONTACT}
        for segment in self.segments:
            if not isinstance(segment.phase, SolverPhase):
                continue
            regime = regime_of(segment.phase)
            names |= {n for n, mode in zip(regime.names, regime.modes, strict=True) if mode is not Mode.FLIGHT}
        order = [couple.pair_name for couple in couples(self.case)]
        return tuple(sorted(names, key=lambda name: (order.index(name.partition(" ")[0]), _number(name))))

    def __call__(self, name: str, times: np.ndarray | None) -> ContactColumns:
        return ContactColumns(*evaluate(self.segments, times, lambda one, when: self._of(one, when, name)))

    def _of(self, segment: Segment, times: np.ndarray, name: str) -> ContactColumns:
        phase, y = segment.phase, segment.states(times)
        if isinstance(phase, SolverPhase):
            return contact_columns(self.case, phase, times, y, name)
        none, nothing = np.full(times.shape, np.nan), np.zeros(times.shape)
        if name != CONTACT:
            return ContactColumns(none, none, nothing, nothing, none, none, *np.zeros((2, 2, len(times))))
        now = observe(self.case, phase, times, y)
        slip, normal, friction, xi1, xi2 = (
            np.broadcast_to(v, times.shape) for v in (now.slip, now.normal_force, now.friction_force, now.xi1, now.xi2)
        )
        ranges = np.array([normal, normal]), np.array([friction, friction])
        return ContactColumns(np.where(np.isnan(slip), np.nan, 0.0), slip, normal, friction, xi1, xi2, *ranges)


def _number(name: str) -> int:
    return int(name.partition(" ")[2] or 1)


def contact_columns(case: Case, now: SolverPhase, times: np.ndarray, y: np.ndarray, name: str) -> ContactColumns:
    """One contact of a phase at some instants; `y` (variables, n)."""
    regime, none, nothing = regime_of(now), np.full(times.shape, np.nan), np.zeros(times.shape)
    if name not in regime.names:
        return ContactColumns(none, none, nothing, nothing, none, none, *np.zeros((2, 2, len(times))))
    k = regime.names.index(name)
    xi1, xi2 = _parameters(case, regime, y, k)
    if regime.modes[k] is Mode.FLIGHT:
        gap = _outputs(case, now, times, y, k)[3]
        return ContactColumns(gap, none, nothing, nothing, xi1, xi2, *np.zeros((2, 2, len(times))))
    at_rest = set(sides(case, regime, k)) <= regime.resting
    normal, friction, slip, _ = [nothing] * 4 if at_rest else _outputs(case, now, times, y, k)
    slip = nothing if regime.modes[k] in STICKING else slip
    if k in _not_unique(case, regime, at_rest):
        some = [0.0] if at_rest and is_steady(case, regime.resting) else times.tolist()
        states = [y[:, 0]] * len(some) if at_rest else y.T
        every = [_ranges(case, regime, y.tobytes(), t, at_rest)[name] for t, y in zip(some, states, strict=True)]
        limits = [np.broadcast_to(np.array([each[i] for each in every]).T, (2, len(times))) for i in (0, 1)]
        values = [forces.values(limit.T, _weight(case, times, y)) for limit in limits]
        return ContactColumns(nothing, slip, values[0], values[1], xi1, xi2, limits[0], limits[1])
    partners = dict(enumerate(regime.shares)) if regime.shares else {}
    both = next(((a, b) for a, b in partners.items() if b is not None and k in (a, b)), None)
    if both is not None:
        return _at_partner(case, now, times, y, (k, both[1] if both[0] == k else both[0]), (xi1, xi2))
    pairs = (np.array([values, values]) for values in (normal, friction))
    return ContactColumns(nothing, slip, normal, friction, xi1, xi2, *pairs)


def sides(case: Case, regime: SolverRegime, k: int) -> Sides:
    """The numbers of the plates of contact k."""
    return sides_of(pair_of(case, regime.pairs[k]))


def _parameters(case: Case, regime: SolverRegime, y: np.ndarray, k: int) -> tuple[np.ndarray, np.ndarray]:
    """The parameters of contact k on both whole curves."""
    first, pair = 3 * len(names_of(case)) + 2 * k, pair_of(case, regime.pairs[k])
    xi1, xi2 = pair.to_whole(y[first], y[first + 1])
    return np.asarray(couple_of(pair).whole_xi1(xi1)), np.asarray(xi2)


def _outputs(case: Case, now: SolverPhase, times: np.ndarray, y: np.ndarray, k: int) -> list[np.ndarray]:
    """`COLUMNS` of contact k."""
    columns = now.system.outputs_of_arrays(times, y, now.parameters)
    first = 2 + 3 * len(names_of(case)) + len(COLUMNS) * k
    some = columns[first : first + len(COLUMNS)]
    return [np.broadcast_to(np.asarray(row, dtype=float), times.shape) for row in some]


def _weight(case: Case, times: np.ndarray, y: np.ndarray) -> float:
    """The largest load on any plate, N, by which forces are compared."""
    state, _ = split(case, y[:, 0])
    every = frozenset(range(len(state) // 6))
    return float(np.abs(load_and_units(case, float(times[0]), state, every)[0]).max())


def _at_partner(
    case: Case, now: SolverPhase, times: np.ndarray, y: np.ndarray, both: tuple[int, int],
    parameters: tuple[np.ndarray, np.ndarray],
) -> ContactColumns:  # fmt: skip
    """The first of two contacts with one slip that stick: of both friction forces only the sum is unique."""
    (normal, own_friction, *_), (other_normal, other_friction, *_) = (_outputs(case, now, times, y, k) for k in both)
    total, nothing = own_friction + other_friction, np.zeros(times.shape)
    stick = _places(case, regime_of(now), y[:, 0], [both[0]])[0].stick
    own, other = (stick * np.maximum(each, 0.0) for each in (normal, other_normal))
    limits = np.array([np.maximum(-own, total - other), np.minimum(own, total + other)])
    friction = forces.values(limits.T, _weight(case, times, y))
    return ContactColumns(nothing, nothing, normal, friction, *parameters, np.array([normal] * 2), limits)


def _not_unique(case: Case, regime: SolverRegime, at_rest: bool) -> list[int]:
    """The closed contacts whose forces are not unique: of plates at rest, or of groups with guides, which move."""
    guided = {side for k, used in enumerate(regime.guides) if used is not None for side in sides(case, regime, k)}
    closed = [(k, set(sides(case, regime, k))) for k, mode in enumerate(regime.modes) if mode is not Mode.FLIGHT]
    return [k for k, own in closed if (own <= regime.resting if at_rest else own & guided)]


@lru_cache(maxsize=MOST_INSTANTS)
def _ranges(case: Case, regime: SolverRegime, state: bytes, t: float, at_rest: bool) -> ForcesByContact:
    """Least and greatest normal and friction force (N), (2,) each, of the contacts of `_not_unique`. `state`: the
    variables' bytes, because keys that are equal may differ in the sign of a zero."""
    y, some, now = np.frombuffer(state), _not_unique(case, regime, at_rest), solver_phase(case, regime)
    (own, _), places = split(case, y), _places(case, regime, y, some)
    acceleration = np.zeros(len(own) // 2)
    if not at_rest:
        acceleration[:] = now.system.rates_of_numbers(t, tuple(y.tolist()), now.parameters)[-len(acceleration) :]
    result: ForcesByContact = {}
    for group in groups(places):
        at, modes = [places[i] for i in group], [regime.modes[some[i]] for i in group]
        limits = forces.ranges(at, *balance_of(case, t, own, acceleration, at, modes, regime.turns))
        for each in (*limits.normal, *limits.friction):
            each.flags.writeable = False  # shared by all callers
        names = [regime.names[some[i]] for i in group]
        result |= dict(zip(names, zip(limits.normal, limits.friction, strict=True), strict=True))
    return result


def _places(case: Case, regime: SolverRegime, y: np.ndarray, some: Sequence[int]) -> list[ContactPlace]:
    state, points = split(case, y)
    return [place(pair_of(case, regime.pairs[k]), state, points[k]) for k in some]


def observe(case: Case, now: Phase, times: np.ndarray, y: np.ndarray) -> State:
    """Pose by (5) and (6), velocities by (8), forces from (27), of the first plate. Of several contacts those of its
    first closed one with track or support; as in flight if none is closed."""
    if isinstance(now, SolverPhase):
        return _observe_poses(case, now, times, y)
    with np.errstate(over="ignore"):  # a load's exp(u) may overflow where 1/(1 + exp(u)) vanishes
        outputs = now.system.outputs_of_arrays(times, y, now.parameters)
    m = now.system.record(*(np.broadcast_to(row, times.shape) for row in outputs))
    xi1, xi2 = now.case.to_whole(y[0], y[1]) if isinstance(now.case, PieceCase) else (y[0], y[1])
    x, y0, theta = pose(case, xi1, xi2)
    tangent, contact = case.track.tangent(xi1), case.track.point(xi1)
    point = m.slip + belt_speed(case, times)  # (11) has the velocity of the plate's point
    vx = point * tangent[0] + m.omega * (contact[1] - y0)
    vy = point * tangent[1] - m.omega * (contact[0] - x)
    mass = case.plate.mass
    return State(x, y0, theta, vx, vy, m.omega, m.slip, mass * m.normal, mass * m.friction, xi1, xi2)


def _observe_poses(case: Case, now: SolverPhase, times: np.ndarray, y: np.ndarray) -> State:
    state, regime = plate_state(case, y, 0), regime_of(now)
    every = couples(case)
    own = [
        k for k, (key, mode) in enumerate(zip(regime.pairs, regime.modes, strict=True))
        if mode is not Mode.FLIGHT and every[key.couple].body == 0 and every[key.couple].base is None
    ]  # fmt: skip
    if not own:
        nothing = np.zeros(times.shape)
        return state._replace(normal_force=nothing, friction_force=nothing)
    first = min(own, key=lambda k: regime.pairs[k].couple)
    one = contact_columns(case, now, times, y, regime.names[first])
    return state._replace(
        slip=one.slip, normal_force=one.normal_force, friction_force=one.friction_force, xi1=one.xi1, xi2=one.xi2
    )
