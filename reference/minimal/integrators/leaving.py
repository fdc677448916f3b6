"""The first, tiny part of a phase, by its Taylor polynomial alone.

A phase begins with a guard at zero that the decision found to grow, often with the square of time; event detection
would find that root again, and a cool-down after it would hide the next. So the start is left first. How far the
polynomial reaches and where it leads is worked out by machine code from its coefficients: the same for all equations
of as many variables, so that it is compiled once.
"""

from __future__ import annotations

from functools import lru_cache
from math import exp, inf, isfinite
from pathlib import Path
from typing import NamedTuple

import heyoka as hy
import numpy as np
from numpy.polynomial.polynomial import polyval

from cases.kept import kept

from ..ahead import PARTS, clear_part
from ..eliminated import Motion
from ..modes import Phase
from .conversion import build, quickly_compiled
from .segment import BREAKDOWN

# The part of its first polynomial's reach that a phase covers by it alone: it is exact there to rounding, and what
# leaves zero with the fourth power of time is still well above its own rounding.
PART = 1e-3
# Powers that count there: beyond, a term is less than (NEAR + 2) PART**(NEAR + 1) of the plate's size.
NEAR = 8
# So often the part is shortened tenfold where a guard is not positive at its end: what is left then is rounding.
SHORTER = 9
# Where the forces stand among what is observed.
NORMAL, FRICTION = Motion._fields.index("normal"), Motion._fields.index("friction")


class Left(NamedTuple):
    """How a phase's start was left: when (s), with which state, in how many steps (0 or 1), the longest step (s) that
    may follow, and the guard that is at zero, if one is."""

    time: float
    state: tuple[float, ...] | list[float]
    steps: int
    longest: float
    guard: str | None = None


def leave(phase: Phase, coefficients: np.ndarray, t: float, y, end: float) -> Left:
    """The state a little later than t, all guards positive there and half-way; or the guard that is not.

    `coefficients` (variables, order + 1) are those of the phase's Taylor polynomial at (t, y).
    """
    variables, terms = coefficients.shape
    far = _far(variables, len(phase.lengths), terms)
    guards = phase.system.guards_of_numbers
    forces = phase.system.observed_of_numbers(t, y, phase.parameters)
    # The contact's forces count by the time in which they would move the plate by its size, 1/s.
    pressed = (max(abs(forces[NORMAL]), abs(forces[FRICTION])) / phase.size) ** 0.5
    part, span = PART, end - t
    values: list[float] = []
    for _ in range(SHORTER):
        total, longest, often, h, *states = far(coefficients, (*phase.lengths, pressed, part, span))
        if not isfinite(total) and not np.isfinite(coefficients).all():
            return Left(t, y, 0, inf, BREAKDOWN)
        if not often > 0.0 or not phase.system.guards.names:
            return Left(t, y, 0, longest)  # nothing moves and nothing presses: no guard leaves zero
        if phase.features:
            clear = clear_part(phase, t, h, polyval(h * PARTS, coefficients.T))
            h *= clear
            states = far(coefficients, (*phase.lengths, pressed, part, h))[4:]
        # What is positive at the end and half-way there has left zero and not come back; else the step is shortened
        # until the event lies behind it.
        for time, state in ((t + 0.5 * h, states[:variables]), (t + h, states[variables:])):
            values = guards(time, state, phase.parameters)
            if not all([value > 0.0 for value in values]):
                break
        else:
            return Left(time, state, 1, longest)
        part *= 0.1
    return Left(t, y, 0, longest, next(n for n, v in zip(phase.system.guards, values, strict=True) if not v > 0.0))


class _Far:
    """How far a polynomial reaches and where it leads, compiled for one number of variables, positions and terms."""

    def __init__(self, variables: int, positions: int, terms: int):
        decided = (variables, positions, terms, PART, NEAR, hy.__version__, build())
        here = Path(__file__).parent
        self._compiled = kept("leaving", decided, here, lambda: _compile(variables, positions, terms))
        self._count = variables * terms
        self._inputs = np.empty(self._count + positions + 3)

    def __call__(self, coefficients: np.ndarray, others: tuple[float, ...]) -> list[float]:
        """From coefficients and (lengths, pressed, part, span): their sum, the longest step (s), how often a term grows
        to the plate's size or the forces move it so far (1/s), h = min(part/often, span), states half-way and at h."""
        self._inputs[: self._count] = coefficients.ravel()
        self._inputs[self._count :] = others
        return self._compiled(self._inputs).tolist()


_far = lru_cache(maxsize=64)(_Far)


def _compile(variables: int, positions: int, terms: int):
    rows = [[hy.expression(f"c_{i:02d}_{k:03d}") for k in range(terms)] for i in range(variables)]
    lengths = [hy.expression(f"length_{i}") for i in range(positions)]
    pressed, part, span = map(hy.expression, ("pressed", "part", "span"))
    sizes = [[_size(c) for c in row] for row in rows]

    # heyoka's rule (said to be of Jorba & Zou 2005; known to us, not looked up) looks at the last two terms, relative
    # to the state or to 1. From a symmetric place at rest a motion has every fourth power only, and both may vanish.
    largest = _largest([hy.expression(1.0), *(row[0] for row in sizes)])
    powers = range(terms // 2, terms)
    longest = exp(-2.0) / _largest([(_largest([row[k] for row in sizes]) / largest) ** (1.0 / k) for k in powers])
    # All terms of positions count: those of even or of odd order vanish in a motion from rest. Where none is left the
    # forces balance, and a load may change them.
    moves = [[row[k] / length for row, length in zip(sizes, lengths, strict=False)] for k in range(terms)]
    often = _largest([pressed, *(_largest(moves[k]) ** (1.0 / k) for k in range(1, terms))])
    h = hy.select(hy.lt(part / often, span), part / often, span)
    states = [_horner(row[: NEAR + 1], when) for when in (0.5 * h, h) for row in rows]
    inputs = [*(c for row in rows for c in row), *lengths, pressed, part, span]
    outputs = [hy.sum([c for row in rows for c in row]), longest, often, h, *states]
    return quickly_compiled(outputs, inputs)


def _size(value):
    return hy.select(hy.lt(value, 0.0), -value, value)


def _largest(values: list):
    found = values[0]
    for value in values[1:]:
        found = hy.select(hy.gt(value, found), value, found)
    return found


def _horner(row: list, x):
    """A polynomial's value, its coefficients from the lowest up."""
    value = row[-1]
    for coefficient in row[-2::-1]:
        value = coefficient + value * x
    return value
