"""Modes, of accelerations and of impacts, that numbers exclude, of many combinations at once.

The accelerations of all combinations are one stack of linear systems: contacts that open, and friction that is not
free, have rows of the identity. Systems that are nearly singular are left to `accelerations.answer_by_numbers`, as are
conditions that are violated by little: what is excluded here is excluded there.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cases import Mode

from ..effect_laws import laws
from ..effect_laws.friction import SLIP_SIGN, STICKING
from .accelerations import DEPENDENT, VIOLATED, DecisionInstant
from .places import ContactPlace, sharing
from .plate_numbers import bodies
from .rotations import Turns

# Conditions are violated by this many times what `answer_by_numbers` asks, and systems this many times as far from
# singular: the roundings of either solution are far less.
CLEARLY = 2.0
# Impulses are compared with roundings of 1e-10: systems this far from singular have fewer.
REGULAR = 1e-4
# Fewer combinations than this are solved sooner one by one.
FEW = 4
# As many systems are solved together: a few megabytes.
TOGETHER = 2048


def possible_modes(
    now: DecisionInstant, contacts: Sequence[ContactPlace], combinations: Sequence[tuple[tuple[Mode, ...], Turns]]
) -> list[tuple[tuple[Mode, ...], Turns]]:
    """The combinations of modes, with the senses of resisted rotations, that these numbers do not exclude. Resisted
    rotations, and forces of the user's own, which depend on the modes, are not looked at."""
    plain = [k for k, (_, turns) in enumerate(combinations) if not turns]
    if len(plain) < FEW or laws(now.case).own:
        return list(combinations)
    stack, without = _Stack(now, contacts), set[int]()
    for first in range(0, len(plain), TOGETHER):
        some = plain[first : first + TOGETHER]
        without |= {some[k] for k in np.flatnonzero(stack.exclusions([combinations[k][0] for k in some]))}
    return [one for k, one in enumerate(combinations) if k not in without]


def _solve(
    delassus: np.ndarray, ratios: np.ndarray, used: np.ndarray, goals: np.ndarray, least: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Which systems are regular: no singular value, with rows and columns of size one, is below `least`; and of these
    the unknown forces and all forces, with the friction of contacts that slip, (systems, 2n) each.

    `ratios`: friction per normal force of contacts that slip, (systems, n); `used`: the rows that hold, (systems, 2n).
    """
    n, sizes = ratios.shape[1], np.sqrt(np.diag(delassus))
    matrix = np.repeat(delassus[None], len(used), axis=0)
    matrix[:, :, :n] += ratios[:, None, :] * delassus[:, n:]
    matrix /= np.outer(sizes, sizes)
    matrix = np.where(used[:, :, None] & used[:, None, :], matrix, np.eye(2 * n))
    regular = np.linalg.svd(matrix, compute_uv=False)[:, -1] > least
    right = np.where(used, goals / sizes, 0.0)[regular]
    values = np.where(used[regular], np.linalg.solve(matrix[regular], right[..., None])[..., 0] / sizes, 0.0)
    every = values.copy()
    every[:, n:] += ratios[regular] * values[:, :n]
    return regular, values, every


class ImpactModes(NamedTuple):
    """Combinations of modes of an impact, (combinations, n) each: which contacts have impulses, which of these end the
    slip, and the senses of slip of the others."""

    closed: np.ndarray
    sticking: np.ndarray
    signs: np.ndarray


def impact_exclusions(
    modes: ImpactModes, inverse: np.ndarray, rows: np.ndarray, before: np.ndarray, restitution: np.ndarray,
    mu: np.ndarray, small: float,
) -> np.ndarray:  # fmt: skip
    """Whether impulses or velocities after an impact violate its law clearly, (combinations,).

    `rows`: of lift and slip velocities, (2n, 3N); `before`: these velocities, (2n,), m/s; `small`: their rounding.
    """
    closed, sticking, signs = modes
    n, finite = len(mu), np.where(np.isfinite(mu), mu, 0.0)
    goals = -before * np.append(1.0 + restitution, np.ones(n))
    used, result = np.hstack([closed, sticking]), np.zeros(len(closed), dtype=bool)
    for first in range(0, len(closed), TOGETHER):
        some = slice(first, first + TOGETHER)
        ratios = -signs[some] * finite
        regular, values, every = _solve(rows * inverse @ rows.T, ratios, used[some], goals, REGULAR)
        after = before + every @ (rows * inverse @ rows.T)
        normal, friction, limit = values[:, :n], values[:, n:], CLEARLY * small
        shut, slips = closed[some][regular], signs[some][regular]
        violations = (~shut & (after[:, :n] + restitution * before[:n] < -limit)) | (shut & (normal < -limit))
        violations |= slips * after[:, n:] < -limit
        violations |= np.isfinite(mu) & (np.abs(friction) > finite * normal + limit)
        result[some][regular] = violations.any(axis=1)
    return result


class _Stack:
    """The numbers that all combinations of one group's modes share: rows of all lift and slip velocities, (2n, 3N)."""

    def __init__(self, now: DecisionInstant, contacts: Sequence[ContactPlace]):
        some, velocity = bodies(now.case), now.velocity
        self.now, self.some, self.count = now, some, len(contacts)
        self.load = now.load
        self.rows = np.array([at.lift_row for at in contacts] + [at.slip_row for at in contacts])
        slips = [at.slip_bias - at.belt_rate(now.time) for at in contacts]
        self.biases = np.array([at.lift_bias for at in contacts] + slips)
        self.delassus = self.rows * some.inverse @ self.rows.T
        self.mu = np.array([at.mu_of(velocity, now.time) for at in contacts])
        self.stick = np.array([at.stick for at in contacts])
        same = sharing(contacts)
        self.first = [same.get(k, k) for k in range(self.count)]
        self.begins = np.array([abs(at.slip(velocity, now.time)) <= now.still for at in contacts])

    def exclusions(self, modes: Sequence[tuple[Mode, ...]]) -> np.ndarray:
        """Whether each combination is excluded, (combinations,)."""
        n, some = self.count, self.some
        closed = np.array([[mode is not Mode.FLIGHT for mode in one] for one in modes])
        sticking = np.array([[mode in STICKING for mode in one] for one in modes])
        signs = np.array([[SLIP_SIGN.get(mode, 0.0) for mode in one] for one in modes])
        holders = sticking & ~np.array([self._before(sticking, k) for k in range(n)]).T
        # Without bound on friction there is no slip.
        ratios = np.where(signs, -signs * np.where(np.isfinite(self.mu), self.mu, 0.0), 0.0)
        used = np.hstack([closed, holders])
        goals = -(self.rows @ self.load + self.biases)
        regular, values, every = _solve(self.delassus, ratios, used, goals, CLEARLY * DEPENDENT)
        acceleration = self.load + some.inverse * (every @ self.rows)
        result = np.zeros(len(modes), dtype=bool)
        result[regular] = self._violations(
            closed[regular], sticking[regular], holders[regular], signs[regular], values, values[:, :n], acceleration
        )
        return result

    def _before(self, sticking: np.ndarray, k: int) -> np.ndarray:
        """Whether an earlier contact that sticks has the friction force of contact k."""
        return np.asarray(sticking[:, [j for j in range(k) if self.first[j] == self.first[k]]].any(axis=1))

    def _violations(
        self, closed: np.ndarray, sticking: np.ndarray, holders: np.ndarray, signs: np.ndarray,
        values: np.ndarray, normal: np.ndarray, acceleration: np.ndarray,
    ) -> np.ndarray:  # fmt: skip
        """Whether a force, a lift or a slip that begins violates its condition, as of `answer_by_numbers`."""
        n, now, part = self.count, self.now, CLEARLY * VIOLATED
        largest, heaviest = now.scale, (self.some.masses / self.some.lengths**2).max()
        force = part * np.maximum(largest * heaviest, np.abs(values).max(axis=1))
        rate = part * np.maximum(largest, np.abs(acceleration * self.some.lengths).max(axis=1))
        lift = acceleration @ self.rows[:n].T + self.biases[:n]
        violations = (~closed & (lift < -rate[:, None])).any(axis=1) | (closed & (normal < -force[:, None])).any(axis=1)
        slip_rates = acceleration @ self.rows[n:].T + self.biases[n:]
        violations |= (self.begins & (signs * slip_rates < -rate[:, None])).any(axis=1)
        with np.errstate(invalid="ignore"):
            bounds = np.where(sticking, self.stick * np.maximum(normal, 0.0), 0.0)
            bounds += np.where(sticking, force[:, None] * (1.0 + np.minimum(self.stick, 1e3)), 0.0)
        for k in range(n):
            whole = bounds[:, [j for j in range(n) if self.first[j] == self.first[k]]].sum(axis=1)
            violations |= holders[:, k] & (np.abs(values[:, n + k]) > whole)
        return violations
