"""Accelerations of one group of contacts in given modes, by numbers, and the balance of forces that are not unique."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import inf
from typing import NamedTuple

import numpy as np

from cases import Case, Mode
from cases.formulas import formula_symbols
from cases.scene.free_plates import loads_of

from ..effect_laws.friction import SLIP_SIGN, STICKING
from ..effect_laws.own_forces import changes_in_time, own_force_values
from ..minimal.decision import AT_BOUND, Undecidable
from ..scales import STILL, slip_error
from . import forces
from .places import ContactPlace, plates_in
from .plate_numbers import Bodies, bodies, load_at, load_scale, rows_of, speed
from .regimes import Guides
from .rest import BALANCE
from .rotations import Sides, Turns, rigid_pairs, turning_row

# Accelerations that differ by less than this part of the largest are the same motion: series decide with 1e-12.
SAME = 1e-7
# Numbers exclude a combination of modes that violates a condition by this part of the largest force or acceleration.
VIOLATED = 1e-6
# Accelerations by this part of the largest apart are tried where forces that are not unique may change them.
OTHER = 1e-3
# Rows are dependent if one is the sum of others to this part.
DEPENDENT = 1e-9


@dataclass(frozen=True)
class DecisionInstant:
    """What a decision needs: the case, time (s), the plates' state, the largest speed of the motion so far (m/s), and
    the relative error of the state."""

    case: Case
    time: float
    state: tuple[float, ...]
    speed: float
    error: float

    @cached_property
    def velocity(self) -> np.ndarray:
        """The velocities of all plates, (3n,)."""
        return np.array(self.state[len(self.state) // 2 :])

    @cached_property
    def load(self) -> np.ndarray:
        """The accelerations (3n,) that weight and loads give all plates."""
        return load_at(self.case, self.time, self.state)

    @cached_property
    def scale(self) -> float:
        """The size of accelerations, m/s²: weight and load, which may cancel."""
        return load_scale(self.case, self.time, self.state)

    @cached_property
    def still(self) -> float:
        """The speed (m/s) below which a slip or a rim has none: the error of an event, or of a constraint's start."""
        return max(slip_error(self.error) * speed(self.case, self.state), STILL * self.speed)


class GroupAccelerations(NamedTuple):
    """Accelerations (3n,) in some modes, whether numbers do not exclude them, whether they show that all contacts that
    open do, and `guides` as of `SolverRegime`; `another`: further accelerations in the same modes, if they are not
    unique."""

    acceleration: np.ndarray
    is_possible: bool
    opens: bool
    guides: Guides = ()
    another: np.ndarray | None = None


def own_load(
    case: Case, t: float, velocity: np.ndarray, contacts: Sequence[ContactPlace], modes: Sequence[Mode]
) -> np.ndarray:
    """The accelerations (3n,) by effects of the user's own at closed contacts."""
    result = np.zeros(len(velocity))
    for at, mode in zip(contacts, modes, strict=True):
        if mode is Mode.FLIGHT or not at.law.own:
            continue
        slip, turning = 0.0 if mode in STICKING else at.slip(velocity, t), at.turning_row
        spin = 0.0 if mode is Mode.REST else float(turning @ velocity)
        for along, across, couple in own_force_values(at.pair, t, slip, spin):
            result += along * at.slip_row + across * at.lift_row + couple * turning
    return result * bodies(case).inverse


def answer_by_numbers(
    now: DecisionInstant, contacts: Sequence[ContactPlace], modes: Sequence[Mode], shares: Mapping[int, int],
    turns: Turns,
) -> GroupAccelerations | None:  # fmt: skip
    """The accelerations in these modes; None if neither forces nor accelerations are unique. `shares`: as of
    `shares_of`."""
    some, velocity = bodies(now.case), now.velocity
    load = now.load + own_load(now.case, now.time, velocity, contacts, modes)
    rows, columns, biases, senses = list[np.ndarray](), list[np.ndarray](), list[float](), dict(turns)
    for i, (at, mode) in enumerate(zip(contacts, modes, strict=True)):
        if mode is Mode.FLIGHT:
            continue
        column = _column(now, at, mode, senses)
        rows, columns, biases = [*rows, at.lift_row], [*columns, column], [*biases, at.lift_bias]
        if mode in STICKING and i not in shares:
            belt = at.belt_rate(now.time)
            rows, columns, biases = [*rows, at.slip_row], [*columns, at.slip_row], [*biases, at.slip_bias - belt]
    holding = [sides for sides, sense in turns if sense == 0]
    still_rows = [_still_row(sides, some) for sides in holding]
    rows, columns, biases = [*rows, *still_rows], [*columns, *still_rows], [*biases, *(0.0 for _ in holding)]
    acceleration, values = load, np.zeros(0)
    if rows:
        inner, outer = np.array(rows), np.array(columns)
        matrix = inner * some.inverse @ outer.T
        sizes = np.sqrt(np.abs(np.diag(inner * some.inverse @ inner.T)))
        if np.linalg.matrix_rank(matrix / np.outer(sizes, sizes), tol=DEPENDENT) < len(rows):
            return _by_guides(now, contacts, modes, turns)
        values = np.linalg.solve(matrix, -(inner @ load + biases))
        acceleration = load + some.inverse * (outer.T @ values)
    largest = now.scale
    heaviest = float((some.masses / some.lengths**2).max())
    force = VIOLATED * max(largest * heaviest, float(np.abs(values).max(initial=0.0)))
    rate = VIOLATED * max(largest, float(np.abs(acceleration * some.lengths).max()))
    forces_left, possible, opens = iter(values.tolist()), True, True
    frictions, bounds, couples = dict[int, float](), dict[int, float](), dict[Sides, float]()
    for i, (at, mode) in enumerate(zip(contacts, modes, strict=True)):
        if mode is Mode.FLIGHT:
            lift = float(at.lift_row @ acceleration) + at.lift_bias
            possible, opens = possible and lift >= -rate, opens and lift > rate
            continue
        normal = next(forces_left)
        possible &= normal >= -force
        couples[at.sides] = couples.get(at.sides, 0.0) + at.resisting_arm * max(normal, 0.0)
        if mode in STICKING:
            holder = shares.get(i, i)
            bounds[holder] = bounds.get(holder, 0.0) + at.stick * max(normal, 0.0) + force * (1.0 + min(at.stick, 1e3))
            if holder == i:
                frictions[i] = next(forces_left)
    possible = possible and _slips_follow(now, contacts, modes, acceleration, rate)
    for sides in holding:
        length = some.lengths[3 * sides[0] + 2]
        possible &= abs(next(forces_left)) * length <= couples[sides] + force * length
    possible &= all(not abs(friction) > bounds[i] for i, friction in frictions.items())
    return GroupAccelerations(acceleration, bool(possible), opens)


def _column(now: DecisionInstant, at: ContactPlace, mode: Mode, senses: Mapping[Sides, int]) -> np.ndarray:
    """A normal force of one, with the friction of a slip and the couple against a rotation that it gives, (3n,)."""
    ratio, sense = -SLIP_SIGN.get(mode, 0.0), senses.get(at.sides)
    column = at.lift_row + (ratio * at.mu_of(now.velocity, now.time) * at.slip_row if ratio else 0.0)
    return column - sense * at.resisting_arm * at.turning_row if sense else column


def _slips_follow(
    now: DecisionInstant, contacts: Sequence[ContactPlace], modes: Sequence[Mode], acceleration: np.ndarray, rate: float
) -> bool:
    """Whether slips that have vanished begin in the directions of their modes, or change by at most `rate` (m/s²)."""
    return all(
        SLIP_SIGN[mode] * at.slip_rate(acceleration, now.time) >= -rate
        for at, mode in zip(contacts, modes, strict=True)
        if mode in SLIP_SIGN and abs(at.slip(now.velocity, now.time)) <= now.still
    )


def _still_row(sides: Sides, some: Bodies) -> np.ndarray:
    """The row of a rotation that is prevented, in m/s²."""
    return float(some.lengths[3 * sides[0] + 2]) * turning_row(sides, len(some.lengths))


def _by_guides(
    now: DecisionInstant, contacts: Sequence[ContactPlace], modes: Sequence[Mode], turns: Turns
) -> GroupAccelerations | None:
    """The same where the rows depend on each other: some of them determine the motion, and forces that are not unique
    have to give it. None where the acceleration is not unique, or where the rows contradict each other."""
    some, velocity = bodies(now.case), now.velocity
    load = now.load + own_load(now.case, now.time, velocity, contacts, modes)
    closed = [k for k, mode in enumerate(modes) if mode is not Mode.FLIGHT]
    each = [(k, False) for k in closed] + [(k, True) for k in closed if modes[k] in STICKING]
    rows, columns, biases = list[np.ndarray](), list[np.ndarray](), list[float]()
    senses = dict(turns)
    picks, others = [[False, False] for _ in contacts], list[tuple[np.ndarray, np.ndarray, float]]()
    rows = [_still_row(sides, some) for sides in rigid_pairs(turns)]
    columns, biases = list(rows), [0.0] * len(rows)
    for k, is_tangent in each:
        at = contacts[k]
        row = at.slip_row if is_tangent else at.lift_row
        column = row if is_tangent else _column(now, at, modes[k], senses)
        bias = at.slip_bias - at.belt_rate(now.time) if is_tangent else at.lift_bias
        if np.linalg.matrix_rank(_unit(np.array([*rows, row]) * np.sqrt(some.inverse)), tol=DEPENDENT) > len(rows):
            rows, columns, biases, picks[k][is_tangent] = [*rows, row], [*columns, column], [*biases, bias], True
        else:
            others.append((row, column, bias))
    matrix = np.array(rows) * some.inverse @ np.array(columns).T
    sizes = np.sqrt(np.diag(np.array(rows) * some.inverse @ np.array(rows).T))
    if np.linalg.matrix_rank(matrix / np.outer(sizes, sizes), tol=DEPENDENT) < len(rows):
        return None
    values = np.linalg.solve(matrix, -(np.array(rows) @ load + biases))
    acceleration = load + some.inverse * (np.array(columns).T @ values)
    largest = now.scale
    rate = SAME * max(largest, float(np.abs(acceleration * some.lengths).max()))
    if any(abs(float(row @ acceleration) + bias) > rate for row, _, bias in others):
        return None
    if not _slips_follow(now, contacts, modes, acceleration, VIOLATED / SAME * rate):
        return GroupAccelerations(acceleration, False, False)
    away = [at for k, at in enumerate(contacts) if k not in closed]
    lifts = [float(at.lift_row @ acceleration) + at.lift_bias for at in away]
    some_contacts, some_modes = [contacts[k] for k in closed], [modes[k] for k in closed]

    def is_balanced(acceleration: np.ndarray) -> bool:
        margin = guided_margin(now.case, now.time, now.state, acceleration, some_contacts, some_modes, turns)
        return margin >= BALANCE

    if not is_balanced(acceleration):
        return GroupAccelerations(acceleration, False, False)
    # Forces that no row misses, of contacts that are left out: with friction they may have an acceleration.
    another: np.ndarray | None = None
    for _, column, _ in others:
        balance = column - np.array(columns).T @ np.linalg.solve(matrix, np.array(rows) * some.inverse @ column)
        change, own = (np.abs(each * np.sqrt(some.inverse)).max() for each in (balance, column))
        if change > SAME * own:
            step = OTHER * rate / SAME * some.inverse * balance / np.abs(some.inverse * balance * some.lengths).max()
            another = next(
                (acceleration + s * step for s in (1.0, -1.0) if is_balanced(acceleration + s * step)), another
            )
    opens = VIOLATED / SAME * rate
    return GroupAccelerations(
        acceleration, all(lift >= -opens for lift in lifts), all(lift > opens for lift in lifts),
        tuple((normal, tangent) for normal, tangent in picks), another,
    )  # fmt: skip


def _unit(rows: np.ndarray) -> np.ndarray:
    return rows / np.linalg.norm(rows, axis=1, keepdims=True)


def guided_margin(
    case: Case, t: float, state: Sequence[float], acceleration: np.ndarray, closed: Sequence[ContactPlace],
    modes: Sequence[Mode], turns: Turns,
) -> float:  # fmt: skip
    """`forces.margin` of contacts in those modes whose forces give their plates an acceleration (3n,)."""
    return forces.margin(closed, *balance_of(case, t, state, acceleration, closed, modes, turns))


class Balance(NamedTuple):
    """What forces of contacts balance: the load less what gives the acceleration, the units of the equations, and the
    limits of friction and of couples, as `forces.margin` has them."""

    load: np.ndarray
    units: np.ndarray
    limits: list[forces.Limit]
    couples: list[forces.Limit]


def balance_of(
    case: Case, t: float, state: Sequence[float], acceleration: np.ndarray, closed: Sequence[ContactPlace],
    modes: Sequence[Mode], turns: Turns,
) -> Balance:  # fmt: skip
    """What the forces of contacts in those modes balance whose plates have an acceleration (3n,)."""
    load, units = load_and_units(case, t, state, plates_in(closed), closed, modes)
    velocity, limits = np.asarray(state[len(state) // 2 :], dtype=float), list[forces.Limit]()
    for at, mode in zip(closed, modes, strict=True):
        slips = forces.Slipping(-SLIP_SIGN[mode] * at.mu_of(velocity, t)) if mode in SLIP_SIGN else 0.0
        limits.append(at.stick if mode in STICKING else slips)
    couples, senses = list[forces.Limit](), dict(turns)
    for at in closed if turns else ():
        sense = senses.get(at.sides)
        couples.append(forces.Slipping(-sense * at.resisting_arm) if sense else at.resisting_arm)
    inertial = acceleration * bodies(case).masses * (units > 0.0)
    sizes = float((np.abs(load) * units).max()), float((np.abs(inertial) * units).max())
    right = load - inertial
    right[np.abs(right) * units <= AT_BOUND * max(sizes)] = 0.0  # forces of roundings alone have no balance
    return Balance(right, units, limits, couples)


def rest_margin(case: Case, t: float, state: Sequence[float], contacts: Sequence[ContactPlace]) -> float:
    """`forces.margin` of a group of contacts whose plates are still; −inf if they are not, or are on a belt, which may
    move them. Raises Undecidable."""
    plates, half = plates_in(contacts), len(state) // 2
    moves = np.asarray(state[half:], dtype=float)[rows_of(plates)].any()
    if moves or any(at.law.belt.runs for at in contacts):
        return -inf
    still = [Mode.REST if at.stick > 0.0 else Mode.SLIDE for at in contacts]
    load, units = load_and_units(case, t, state, plates, contacts, still)
    if not np.isfinite(load).all():
        raise Undecidable
    couples = [at.resisting_arm for at in contacts]
    return forces.margin(contacts, load, units, [at.stick for at in contacts], couples if any(couples) else ())


def is_steady(case: Case, plates: frozenset[int]) -> bool:
    """Whether the loads on some plates at rest stay the same."""
    loads = loads_of(case)
    formulas = [part for b in plates if (load := loads[b]) is not None for part in load.expression]
    return not any(part.has(formula_symbols.TIME) for part in formulas) and not changes_in_time(case)


def load_and_units(
    case: Case, t: float, state: Sequence[float], plates: frozenset[int], contacts: Sequence[ContactPlace] = (),
    modes: Sequence[Mode] = (),
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """The load (3n,) on some plates (N, N, N m), with forces of the user's own at contacts in these modes, and the
    units of the equations of their equilibrium: 0 for those of other plates, and for the moment of a plate that cannot
    turn."""
    some, own = bodies(case), np.zeros(len(state) // 2, dtype=bool)
    own[rows_of(plates)] = True
    own &= some.inverse > 0.0
    velocity = np.asarray(state[len(state) // 2 :], dtype=float)
    load = load_at(case, t, state) + own_load(case, t, velocity, contacts, modes)
    return load * np.where(own, some.masses, 0.0), own / some.lengths
