"""Combinations of the modes of contacts: all of a few contacts, of many those that a mixed-integer program leaves.

The program has the forces and a bit for each mode of each contact: its conditions are those of the law, and its goal is
a sum of the contacts' rates with arbitrary weights. Where the greatest and the least sum are the same, so are the rates
of all solutions, and each contact has only the modes that agree with its own. (Derived here.)
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import chain, product
from math import inf, prod
from typing import TYPE_CHECKING, NamedTuple, TypeVar

import numpy as np

if TYPE_CHECKING:
    from scipy.optimize import LinearConstraint

# The kinds of modes: the sign of a slip (0 without friction), or these.
STICKS, OPEN = 2, 3
# Fewer combinations are a stack of linear systems that is solved sooner than a program; more than MOST take some ten
# seconds.
FEW, MOST = 4**6, 4**8
# Forces and rates are below this in units in which each force changes its own rate by one and the largest rate that is
# to change is about one. Solutions with larger ones are not looked for; with 1000 HiGHS reports errors of its numbers.
LARGE = 50.0
# Rates of solutions agree within this part: a hundred times the program's tolerance for what its conditions violate.
SAME = 1e-5
# The program has a solution, or none (manual of scipy.optimize.milp).
SOLVED, INFEASIBLE = 0, 2

Option = TypeVar("Option")


class TooManyModes(ArithmeticError):
    """A decision has more combinations of modes than are tried."""


class ContactRates(NamedTuple):
    """What forces do at n contacts and r rotations that they resist, in the order normal forces, friction, couples.

    `delassus`: from forces to rates, (2n + r, 2n + r); `free`: the rates without them; `least`: the least normal
    forces, (n,); `stick`, `mu`: the coefficients of friction without and with slip, (n,), infinite ones too; `arms`: of
    the couples, (r, n), per normal force; `begins`: which slips have their direction from these rates, (n,); `rate`:
    the size of the rates that forces make. Forces are impulses in an impact, and rates velocities after it.
    """

    delassus: np.ndarray
    free: np.ndarray
    least: np.ndarray
    stick: np.ndarray
    mu: np.ndarray
    arms: np.ndarray
    begins: np.ndarray
    rate: float


def mode_combinations(
    rates: Callable[[], ContactRates | None], options: Sequence[Sequence[Option]], kind: Callable[[int, Option], int]
) -> Iterator[tuple[Option, ...]]:
    """The combinations of a mode of each contact, in the order of `itertools.product`; `kind`: of a mode of contact k.
    `rates` is called where there are many; without them none is excluded. Raises TooManyModes."""
    some = [options]
    if prod(map(len, options)) > FEW and (given := rates()) is not None:
        program = _Program(given)
        left: list[Sequence[Sequence[Option]]] = [
            [[one for one in own if program.allows(found, k, kind(k, one))] for k, own in enumerate(options)]
            for found in program.solutions([{kind(k, one) for one in own} for k, own in enumerate(options)])
        ]
        some = left if left and all(map(all, left)) else some  # a contact without a mode is an error of numbers
    if any(prod(map(len, each)) > MOST for each in some):
        raise TooManyModes
    return chain.from_iterable(product(*each) for each in some)


class _Program:
    """The conditions of one decision. Forces and rates are in units in which each force changes its own rate by one."""

    def __init__(self, rates: ContactRates):
        n, m = len(rates.mu), len(rates.free)
        diagonal, forces = np.diag(rates.delassus), np.eye(m)
        unit = np.where(diagonal > 0.0, np.sqrt(np.maximum(diagonal, 0.0)), 1.0)
        ratio = (unit[n : 2 * n] / unit[:n])[:, None]
        self.n, self.rates = n, rates
        # A rate that no force reverses counts as one that is still large.
        self.free = np.clip(rates.free / (unit * rates.rate), -0.5 * LARGE, 0.5 * LARGE)
        self.moves = rates.delassus / np.outer(unit, unit)
        self.normal, self.along, couples = forces[:n], forces[n : 2 * n], forces[2 * n :]
        self.least = np.concatenate([rates.least * unit[:n] / rates.rate, np.full(m - n, -LARGE)])
        is_bounded, slides = np.isfinite(rates.stick), np.where(np.isfinite(rates.mu), rates.mu, 0.0)
        cone = rates.stick[is_bounded, None] * ratio[is_bounded] * self.normal[is_bounded]
        limit = (rates.arms * np.divide.outer(unit[2 * n :], unit[:n])) @ self.normal
        # What is not negative whatever the modes, and what vanishes with slip: the sum for slip forwards, the
        # difference for slip backwards.
        self.cones = np.vstack([
            cone - self.along[is_bounded], cone + self.along[is_bounded], limit - couples, limit + couples,
        ])  # fmt: skip
        self.slides = slides[:, None] * ratio * self.normal

    def solutions(self, kinds: Sequence[set[int]]) -> list[np.ndarray]:
        """The rates of the solutions with the greatest and the least sum of the rates with arbitrary weights, one if
        they are the same; none if nothing is found, or if there are several of which those that stick are preferred."""
        from scipy.optimize import Bounds, milp

        available = np.array([[OPEN in own, STICKS in own, bool(own & {0, 1}), -1 in own] for own in kinds]).T.ravel()
        m, no_bits = len(self.free), 0.0 * available
        bounds = Bounds(np.append(self.least, no_bits), np.append(np.full(m, LARGE), available))
        weights, conditions, found = np.random.default_rng(0).normal(size=m), self._conditions(), list[np.ndarray]()
        for sign in (1.0, -1.0):
            answer = milp(
                sign * np.append(weights @ self.moves, no_bits), bounds=bounds, constraints=conditions,
                integrality=np.append(np.zeros(m), np.ones(4 * self.n)), options={"mip_rel_gap": 0.0},
            )  # fmt: skip
            if answer.status != SOLVED:
                return []
            found.append(self.moves @ answer.x[:m] + self.free)
        if np.abs(found[0] - found[1]).max() <= SAME:
            return found[:1]
        return [] if (self.rates.stick > self.rates.mu).any() else found

    def _conditions(self) -> LinearConstraint:
        """Sums of the forces, and of the bits of all modes (open, without slip, slip forwards and backwards), that have
        a least and a greatest value: a bit of a mode adds its conditions, without it they are too weak to matter."""
        from scipy.optimize import LinearConstraint

        n, free, least = self.n, self.free, self.least[: self.n]
        opens, sticks, forward, backward = bits = np.eye(4 * n).reshape(4, n, 4 * n)
        lift, slip, forces = self.moves[:n], self.moves[n : 2 * n], np.zeros((n, len(free)))
        open_, begins = np.full(n, inf), np.where(self.rates.begins, 0.0, LARGE)
        unbounded = np.where(~np.isfinite(self.rates.stick) & (least == 0.0), 0.0, LARGE)
        every = [
            (self.cones, np.zeros((len(self.cones), 4 * n)), np.zeros(len(self.cones)), np.full(len(self.cones), inf)),
            (forces, bits.sum(axis=0), np.ones(n), np.ones(n)),
            (lift, 0.0 * opens, -free[:n], open_),
            (lift, -LARGE * opens, -open_, -free[:n]),
            (self.normal, LARGE * opens, -open_, LARGE + least),
            (self.along, LARGE * opens, -open_, LARGE + unbounded),
            (self.along, -LARGE * opens, -LARGE - unbounded, open_),
            (slip, LARGE * sticks, -open_, LARGE - free[n : 2 * n]),
            (slip, -LARGE * sticks, -LARGE - free[n : 2 * n], open_),
        ]
        for sign, bit in ((1.0, forward), (-1.0, backward)):
            slides = self.along + sign * self.slides
            every.append((slides, LARGE * bit, -open_, np.full(n, LARGE)))
            every.append((slides, -LARGE * bit, np.full(n, -LARGE), open_))
            every.append((sign * slip, -LARGE * bit, -LARGE - sign * free[n : 2 * n] - begins, open_))
        rows = np.vstack([np.hstack(some[:2]) for some in every])
        return LinearConstraint(rows, *(np.concatenate([some[i] for some in every]) for i in (2, 3)))

    def allows(self, rates: np.ndarray, k: int, kind: int) -> bool:
        """Whether contact k may have a mode of this kind in a solution with these rates: they agree with it, and some
        forces that make them do."""
        from scipy.optimize import Bounds, LinearConstraint, milp

        lift, slip, begins, most = rates[k], rates[self.n + k], self.rates.begins[k], np.full(len(rates), LARGE)
        if kind != OPEN and (lift > SAME or (kind == STICKS and abs(slip) > SAME) or (begins and kind * slip < -SAME)):
            return False
        row = np.zeros(len(rates))
        if kind == OPEN:
            most[k] = self.least[k] + SAME
        elif kind != STICKS:
            row = self.along[k] + kind * self.slides[k]
        forces = rates - self.free
        answer = milp(
            np.zeros(len(rates)), bounds=Bounds(self.least, most),
            constraints=[
                LinearConstraint(self.moves, forces - SAME, forces + SAME), LinearConstraint(self.cones, -SAME, inf),
                LinearConstraint(row, -SAME, SAME),
            ],
        )  # fmt: skip
        return bool(answer.status != INFEASIBLE)
