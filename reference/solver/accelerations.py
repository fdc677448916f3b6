"""Accelerations of one group of contacts in combinations of modes, by numbers, and the balance of forces that are not
unique."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import inf, nan
from typing import NamedTuple

import numpy as np

from cases import Case, Mode
from cases.formulas import formula_symbols
from cases.scene.free_plates import loads_of, plates_of

from ..effect_laws import laws
from ..effect_laws.friction import SLIP_SIGN, STICKING
from ..effect_laws.own_forces import changes_in_time, own_force_values
from ..minimal.decision import AT_BOUND, Undecidable
from ..minimal.integrators.segment import Segment
from ..scales import EPS, STILL, slip_error
from . import forces
from .exclusion import TOGETHER, solve_stack
from .mode_program import OPEN, STICKS, ContactRates
from .places import ContactPlace, plates_in, sharing
from .plate_numbers import Sides, Turns, bodies, load_at, load_scale, rigid_pairs, rows_of, speed, turning_row
from .regimes import Guides

# Accelerations that differ by less than this part of the largest are the same motion: series decide with 1e-12.
SAME = 1e-7
# Numbers exclude a combination of modes that violates a condition by this part of the largest force or acceleration.
VIOLATED = 1e-6
# Accelerations by this part of the largest apart are tried where forces that are not unique may change them.
OTHER = 1e-3
# As `mode_program` has them.
KINDS = {Mode.FLIGHT: OPEN, Mode.SLIDE: 0} | dict.fromkeys(STICKING, STICKS) | {m: int(s) for m, s in SLIP_SIGN.items()}
# Rows are dependent if one is the sum of others to this part.
DEPENDENT = 1e-9


# A load is balanced if the least weight is no more negative than its rounding.
BALANCE = -1e-11
# Looks at a load in time while it may end a rest, besides those that resolve its features.
LOOKS = 64
# A root is located to roundings of its time, the finest that SciPy allows.
FINEST = 4.0 * EPS
# A balance that is lost within this part of the time between two looks is lost at once.
AT_ONCE = 1e-6
# Looks in each step of a motion; the steps resolve the features of belts and loads.
LOOKS_IN_STEP = 4


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


class GroupRows:
    """What all combinations of one group's modes share: the rows (2n + p, 3N) of lift and slip velocities of its n
    contacts, and of the p rotations that they resist, m/s."""

    def __init__(self, now: DecisionInstant, contacts: Sequence[ContactPlace]):
        some, velocity = bodies(now.case), now.velocity
        self.now, self.contacts, self.some, self.count = now, contacts, some, len(contacts)
        self.pairs = resisting(contacts)
        lengths = [float(some.lengths[3 * sides[0] + 2]) for sides in self.pairs]
        rotations = [length * turning_row(s, len(velocity)) for s, length in zip(self.pairs, lengths, strict=True)]
        self.rows = np.array([at.lift_row for at in contacts] + [at.slip_row for at in contacts] + rotations)
        slips = [at.slip_bias - at.belt_rate(now.time) for at in contacts]
        self.delassus = self.rows * some.inverse @ self.rows.T
        self.biases = np.array([at.lift_bias for at in contacts] + slips + [0.0] * len(rotations))
        mu = np.array([at.mu_of(velocity, now.time) for at in contacts])
        self.mu = np.where(np.isfinite(mu), mu, 0.0)  # without bound on friction there is no slip
        stick = np.array([at.stick for at in contacts])
        self.is_bounded = np.isfinite(stick)
        self.stick = np.where(self.is_bounded, stick, 0.0)
        every = zip(self.pairs, lengths, strict=True)
        arms = [[at.resisting_arm / length * (at.sides == sides) for at in contacts] for sides, length in every]
        self.arms = np.array(arms).reshape(-1, self.count)
        # Which contacts have one slip: the first that sticks has the friction force of all.
        same = sharing(contacts)
        first = np.array([same.get(k, k) for k in range(self.count)])
        self.shared = first[:, None] == first
        self.after = np.triu(self.shared, 1)
        self.begins = np.array([abs(at.slip(velocity, now.time)) <= now.still for at in contacts])

    def rates(self) -> ContactRates | None:
        """What forces do just after the instant; None with effects of the user's own, which depend on modes."""
        if laws(self.now.case).own:
            return None
        free, nothing = self.rows @ self.now.load + self.biases, np.zeros(self.count)
        stick, mu = np.where(self.is_bounded, self.stick, inf), np.where(self.is_bounded, self.mu, inf)
        return ContactRates(self.delassus, free, nothing, stick, mu, self.arms, self.begins, self.now.scale)

    def answers(
        self, combinations: Sequence[tuple[tuple[Mode, ...], Turns]]
    ) -> Iterator[tuple[tuple[Mode, ...], Turns, GroupAccelerations | None]]:
        """The combinations of modes, with the senses of resisted rotations, that numbers do not exclude, and their
        accelerations; None if neither forces nor accelerations are unique. All are one stack of linear systems:
        contacts that open, and friction that is not free, have rows of the identity."""
        for first in range(0, len(combinations), TOGETHER):
            yield from self._together(combinations[first : first + TOGETHER])

    def _together(self, combinations: Sequence[tuple[tuple[Mode, ...], Turns]]):
        n, now, some, inverse = self.count, self.now, self.some, self.some.inverse
        kinds = np.array([[KINDS[mode] for mode in modes] for modes, _ in combinations])
        closed, sticking, signs = kinds != OPEN, kinds == STICKS, np.where(np.abs(kinds) == 1, kinds, 0)
        holders = sticking & ~(sticking @ self.after)
        senses = np.array([[dict(turns).get(sides, nan) for sides in self.pairs] for _, turns in combinations])
        holds = senses.reshape(len(kinds), -1) == 0.0
        # Which forces each unknown is: a normal force also gives friction of a slip, and a couple against a rotation.
        mix = np.empty((len(kinds), len(self.rows), len(self.rows)))
        mix[:] = np.eye(len(self.rows))
        mix[:, n : 2 * n, :n] -= (signs * self.mu)[:, :, None] * np.eye(n)
        if self.pairs:
            mix[:, 2 * n :, :n] -= np.nan_to_num(senses)[:, :, None] * self.arms
        loads = now.load[None]
        if laws(now.case).own:
            loads = loads + [
                own_load(now.case, now.time, now.velocity, self.contacts, modes) for modes, _ in combinations
            ]
        used, goals = np.hstack([closed, holders, holds]), -(loads @ self.rows.T + self.biases)
        regular, values = solve_stack(self.delassus, mix, used, goals, DEPENDENT)
        loads = np.broadcast_to(loads, (len(kinds), len(now.load)))
        acceleration = loads[regular] + inverse * ((mix[regular] @ values[..., None])[..., 0] @ self.rows)
        heaviest = float((some.masses / some.lengths**2).max())
        force = VIOLATED * np.maximum(now.scale * heaviest, np.abs(values).max(axis=1))[:, None]
        rate = VIOLATED * np.maximum(now.scale, np.abs(acceleration * some.lengths).max(axis=1))[:, None]
        shut, normal, sticks = closed[regular], values[:, :n], sticking[regular]
        lift, pressing = acceleration @ self.rows[:n].T + self.biases[:n], np.maximum(normal, 0.0)
        violations = np.where(shut, normal < -force, lift < -rate) | self._turns_back(
            signs[regular], acceleration, rate
        )
        bounds = (
            np.where(sticks, self.stick * pressing + force * (1.0 + np.minimum(self.stick, 1e3)), 0.0) @ self.shared
        )
        violations |= holders[regular] & self.is_bounded & (np.abs(values[:, n : 2 * n]) > bounds)
        is_violated = violations.any(axis=1)
        if self.pairs:
            couples = np.where(shut, pressing, 0.0) @ self.arms.T + force
            is_violated |= (holds[regular] & (np.abs(values[:, 2 * n :]) > couples)).any(axis=1)
        opens, number = (shut | (lift > rate)).all(axis=1), 0
        for i, (modes, turns) in enumerate(combinations):
            if not regular[i]:
                yield modes, turns, self._by_guides(modes, turns, mix[i], loads[i])
                continue
            if not is_violated[number]:
                yield modes, turns, GroupAccelerations(acceleration[number], True, bool(opens[number]))
            number += 1

    def _turns_back(self, signs: np.ndarray, acceleration: np.ndarray, rate: np.ndarray | float) -> np.ndarray:
        """Which slips that have vanished begin against the directions of their modes, by more than `rate` (m/s²)."""
        own = slice(self.count, 2 * self.count)
        rates = acceleration @ self.rows[own].T + self.biases[own]
        return np.asarray(self.begins & (signs * rates < -rate))

    def _by_guides(
        self, modes: Sequence[Mode], turns: Turns, mix: np.ndarray, load: np.ndarray
    ) -> GroupAccelerations | None:
        """The same where the rows depend on each other: some of them determine the motion, and forces that are not
        unique have to give it. None where the acceleration is not unique, or where the rows contradict each other."""
        now, some, n, inverse = self.now, self.some, self.count, self.some.inverse
        closed = [k for k, mode in enumerate(modes) if mode is not Mode.FLIGHT]
        columns = mix.T @ self.rows
        basis, others = [2 * n + self.pairs.index(sides) for sides in rigid_pairs(turns)], list[int]()
        for i in [*closed, *(n + k for k in closed if modes[k] in STICKING)]:
            trial = self.rows[[*basis, i]] * np.sqrt(inverse)
            trial /= np.linalg.norm(trial, axis=1, keepdims=True)
            (basis if np.linalg.matrix_rank(trial, tol=DEPENDENT) > len(basis) else others).append(i)
        inner, outer = self.rows[basis], columns[basis]
        matrix, sizes = inner * inverse @ outer.T, np.sqrt(np.diag(inner * inverse @ inner.T))
        if np.linalg.matrix_rank(matrix / np.outer(sizes, sizes), tol=DEPENDENT) < len(basis):
            return None
        values = np.linalg.solve(matrix, -(inner @ load + self.biases[basis]))
        acceleration = load + inverse * (outer.T @ values)
        rate = SAME * max(now.scale, float(np.abs(acceleration * some.lengths).max()))
        if np.abs(self.rows[others] @ acceleration + self.biases[others]).max(initial=0.0) > rate:
            return None
        signs, violated = np.array([SLIP_SIGN.get(mode, 0.0) for mode in modes]), VIOLATED / SAME * rate
        if self._turns_back(signs, acceleration, violated).any():
            return GroupAccelerations(acceleration, False, False)
        contacts, own_modes = [self.contacts[k] for k in closed], [modes[k] for k in closed]

        def is_balanced(acceleration: np.ndarray) -> bool:
            balance = balance_of(now.case, now.time, now.state, acceleration, contacts, own_modes, turns)
            return forces.margin(contacts, *balance) >= BALANCE

        if not is_balanced(acceleration):
            return GroupAccelerations(acceleration, False, False)
        # Forces that no row misses, of contacts that are left out: with friction they may have an acceleration.
        another: np.ndarray | None = None
        for column in columns[others]:
            balance = column - outer.T @ np.linalg.solve(matrix, inner * inverse @ column)
            change, own = (np.abs(each * np.sqrt(inverse)).max() for each in (balance, column))
            if change > SAME * own:
                step = OTHER * rate / SAME * inverse * balance / np.abs(inverse * balance * some.lengths).max()
                another = next(
                    (acceleration + s * step for s in (1.0, -1.0) if is_balanced(acceleration + s * step)), another
                )
        lifts = np.delete(self.rows[:n] @ acceleration + self.biases[:n], closed)
        guides = tuple((k in basis, n + k in basis) for k in range(n))
        is_possible, opens = bool((lifts >= -violated).all()), bool((lifts > violated).all())
        return GroupAccelerations(acceleration, is_possible, opens, guides, another)


def resisting(contacts: Sequence[ContactPlace]) -> list[Sides]:
    """The plates with contacts that resist rolling."""
    return list(dict.fromkeys(at.sides for at in contacts if at.resisting_arm))


class Balance(NamedTuple):
    """What forces of contacts balance: the load less what gives the acceleration, the units of the equations, and the
    limits of friction and of couples, as `forces.margin` has them."""

    load: np.ndarray
    units: np.ndarray
    limits: list[forces.Limit]
    couples: list[forces.Limit]


def balance_of(
    case: Case, t: float, state: Sequence[float], acceleration: np.ndarray, closed: Sequence[ContactPlace],
    modes: Sequence[Mode], turns: Turns = (),
) -> Balance:  # fmt: skip
    """What the forces of contacts in those modes balance whose plates have an acceleration (3n,)."""
    load, units = load_and_units(case, t, state, plates_in(closed), closed, modes)
    velocity, limits = np.asarray(state[len(state) // 2 :], dtype=float), list[forces.Limit]()
    for at, mode in zip(closed, modes, strict=True):
        slips = forces.Slipping(-SLIP_SIGN[mode] * at.mu_of(velocity, t)) if mode in SLIP_SIGN else 0.0
        limits.append(at.stick if mode in STICKING else slips)
    senses = {sides: sense for sides, sense in turns if sense}
    couples: list[forces.Limit] = [
        forces.Slipping(-senses[at.sides] * at.resisting_arm) if at.sides in senses else at.resisting_arm
        for at in closed
    ]
    inertial = acceleration * bodies(case).masses * (units > 0.0)
    sizes = float((np.abs(load) * units).max()), float((np.abs(inertial) * units).max())
    right = load - inertial
    right[np.abs(right) * units <= AT_BOUND * max(sizes)] = 0.0  # forces of roundings alone have no balance
    return Balance(right, units, limits, couples if any(couples) else [])


def rest_margin(case: Case, state: Sequence[float], contacts: Sequence[ContactPlace], t: float) -> float:
    """`forces.margin` of a group of contacts whose plates are still; −inf if they are not, or one is turned or on a
    belt, which may move them. Raises Undecidable."""
    half, plates = len(state) // 2, plates_of(case)
    moves = np.asarray(state[half:], dtype=float)[rows_of(plates_in(contacts))].any()
    if moves or any(plates[b].spins_by_load for b in plates_in(contacts)) or any(at.law.belt.runs for at in contacts):
        return -inf
    still = [Mode.REST if at.stick > 0.0 else Mode.SLIDE for at in contacts]
    balance = balance_of(case, t, state, np.zeros(half), contacts, still)
    if not np.isfinite(balance.load).all():
        raise Undecidable
    return forces.margin(contacts, *balance)


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


def looks_at_load(case: Case, start: float) -> list[float]:
    """Times (s) from a start to the end of a case's motion that resolve its loads."""
    end, looks = case.duration, np.linspace(start, case.duration, LOOKS)
    for load in loads_of(case):
        if load is not None and load.features is not None:
            looks = np.union1d(looks, load.features.nodes(start, end))
    return looks.tolist()


def first_loss_in(segment: Segment, margin: Callable[[float], float]) -> float | None:
    """When a margin is lost in a segment, s; None if it is not at any look in its steps."""
    steps = np.unique(segment.times)
    parts = np.arange(1, LOOKS_IN_STEP + 1) / LOOKS_IN_STEP
    looks = (steps[:-1, None] + np.diff(steps)[:, None] * parts).ravel()
    return first_loss(margin, [float(steps[0]), *looks.tolist()])


def first_loss(margin: Callable[[float], float], looks: list[float]) -> float | None:
    """When a margin is lost, s, located to rounding; None if it is not at any of these times. One that touches zero is
    kept: it is known to its rounding only."""
    from scipy.optimize import brentq

    last = looks[0]
    for look in looks:
        value = margin(look)
        if value < BALANCE:
            # Without friction a load is balanced at single instants: no weights of any sign have its direction then. A
            # margin that is a rounding and shrinks is lost at once, too.
            now, soon = margin(last), margin(last + AT_ONCE * (look - last))
            if soon == -inf or not now > 0.0 or soon < now <= -BALANCE:
                return last
            return float(brentq(lambda t: max(margin(t), -1.0), last, look, xtol=EPS * (look - last), rtol=FINEST))
        last = look if value > 0.0 else last
    return None
