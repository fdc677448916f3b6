"""The first short step of a phase, by its Taylor polynomial alone.

A phase begins with a guard at zero that is known to grow, often with the square of time. Event detection would find
that root again, and a cool-down after it would hide the next. So a first step leaves the start. The length of the step,
the state after it and the guards there are computed together, by machine code.
"""

from __future__ import annotations

from functools import lru_cache
from math import exp, inf, isfinite
from typing import NamedTuple

import heyoka as hy
import numpy as np

from ..defect_check import Expansion, clear_part
from ..modes import Phase
from ..system import System
from .conversion import build, compile_quickly, convert, guards, variables
from .segment import BREAKDOWN

# Length of the first step as a part of its polynomial's range: the polynomial is exact there to rounding, and a
# quantity that grows with the fourth power of time is still well above its own rounding.
PART = 1e-3
# Highest power used there: later terms are less than (NEAR + 2) PART**(NEAR + 1) of the plate's size.
NEAR = 8
# The step is shortened tenfold this many times if a guard is not positive at its end: the rest is then rounding.
SHORTER = 9


class FirstStep(NamedTuple):
    """The result of the first step: time (s), state, number of steps (0 or 1), the longest step (s) that may follow,
    and the guard that is at zero, if any."""

    time: float
    state: tuple[float, ...] | list[float]
    steps: int
    longest: float
    guard: str | None = None


def leave(phase: Phase, coefficients: np.ndarray, t: float, y, end: float, tolerance: float) -> FirstStep:
    """Take the first step from t; all guards are positive at its end and half-way, or the result names one that is not.

    `coefficients` (variables, order + 1) are those of the phase's Taylor polynomial at (t, y).
    """
    start = _start(phase.system, coefficients.shape[1])
    numbers = (t, phase.size, *phase.lengths, *phase.parameters)
    part, span = PART, end - t
    for _ in range(SHORTER):
        ahead = start(coefficients, (part, span, *numbers))
        if not isfinite(ahead.total) and not np.isfinite(coefficients).all():
            return FirstStep(t, y, 0, inf, BREAKDOWN)
        if not ahead.guards or not 0.0 < ahead.often < inf:
            return FirstStep(t, y, 0, ahead.longest)  # no motion and no contact force: no guard leaves zero
        if phase.checks_steps:
            clear = clear_part(phase, Expansion(t, ahead.h, coefficients), tolerance)
            ahead = start(coefficients, (part, clear * ahead.h, *numbers))
        # A guard that is positive at the end and half-way has left zero and not come back; else the step is shortened
        # until the event lies behind it.
        if all([value > 0.0 for value in ahead.guards]):
            return FirstStep(t + ahead.h, ahead.state, 1, ahead.longest)
        part *= 0.1
    names = phase.system.guards.names
    zero = next(i for i, value in enumerate(ahead.guards) if not value > 0.0)
    return FirstStep(t, y, 0, ahead.longest, names[zero % len(names)])


class _SeriesEstimate(NamedTuple):
    """Estimates from a Taylor polynomial: the sum of its coefficients, the longest step (s) that the upper half of them
    allows, the rate (1/s) at which a term grows to the plate's size or the forces move the plate that far, the step h
    (s), the state after it, and the guards half-way and after it."""

    total: float
    longest: float
    often: float
    h: float
    state: list[float]
    guards: list[float]


class _FirstPolynomial:
    """The first polynomial of a system's phases, with a number of terms, as a compiled function."""

    def __init__(self, system: System, terms: int):
        key = (terms, PART, NEAR, hy.__version__, build())
        self._function = system.from_cache("start", key, lambda: _compile(system, terms))
        self._variables = len(system.variables)
        self._coefficients = self._variables * terms
        self._count = self._coefficients + 4 + system.positions + len(system.parameters)

    def __call__(self, coefficients: np.ndarray, numbers: tuple[float, ...]) -> _SeriesEstimate:
        """Evaluate; `numbers` are part, span, t, the plate's size, lengths and parameters; h = min(part/often,
        span)."""
        inputs = np.empty(self._count)  # local to this call, for thread safety
        inputs[: self._coefficients] = coefficients.ravel()
        inputs[self._coefficients :] = numbers
        total, longest, often, h, *results = self._function(inputs).tolist()
        return _SeriesEstimate(total, longest, often, h, results[: self._variables], results[self._variables :])


_start = lru_cache(maxsize=128)(_FirstPolynomial)


def _compile(system: System, terms: int):
    rows = [[hy.expression(f"c_{i:02d}_{k:03d}") for k in range(terms)] for i in range(len(system.variables))]
    part, span, t, size = map(hy.expression, ("part", "span", "t", "size"))
    lengths = [hy.expression(f"length_{i}") for i in range(system.positions)]
    parameters = [hy.expression(f"parameter_{i:03d}") for i in range(len(system.parameters))]
    symbols = variables(system)
    fixed = {hy.par[i]: parameter for i, parameter in enumerate(parameters)}

    def there(expressions, time, state) -> list:
        """Expressions of time and state, evaluated at `time` and `state`."""
        substitutions = {symbols[variable]: value for variable, value in zip(system.variables, state, strict=True)}
        return hy.subs(list(expressions), substitutions | fixed | {hy.time: time})

    # heyoka's rule (said to be of Jorba & Zou 2005; known to us, not looked up) uses the last two terms, relative to
    # the state or to 1. A motion from rest at a symmetric place has only every fourth power, and both terms may vanish.
    sizes = [[_size(c) for c in row] for row in rows]
    largest = _largest([hy.expression(1.0), *(row[0] for row in sizes)])
    powers = range(terms // 2, terms)
    longest = exp(-2.0) / _largest([(_largest([row[k] for row in sizes]) / largest) ** (1.0 / k) for k in powers])
    # All terms of positions are used: those of even or of odd order vanish in a motion from rest. If all vanish, the
    # forces balance, and a load may change them: they enter by the time in which they would move the plate by its size.
    pressing = [convert(force, symbols) for force in (system.outputs.normal, system.outputs.friction)]
    forces = there(pressing, t, [row[0] for row in rows])
    growth = [_largest([row[k] / unit for row, unit in zip(sizes, lengths, strict=False)]) for k in range(terms)]
    often = _largest(
        [(_largest(list(map(_size, forces))) / size) ** 0.5, *(growth[k] ** (1.0 / k) for k in range(1, terms))]
    )
    h = hy.select(hy.lt(part / often, span), part / often, span)

    half, state = ([_horner(row[: NEAR + 1], when) for row in rows] for when in (0.5 * h, h))
    values = [*there(guards(system), t + 0.5 * h, half), *there(guards(system), t + h, state)]
    outputs = [hy.sum([c for row in rows for c in row]), longest, often, h, *state, *values]
    return compile_quickly(outputs, [*(c for row in rows for c in row), part, span, t, size, *lengths, *parameters])


def _size(value):
    return hy.select(hy.lt(value, 0.0), -value, value)


def _largest(values: list):
    largest = values[0]
    for value in values[1:]:
        largest = hy.select(hy.gt(value, largest), value, largest)
    return largest


def _horner(row: list, x):
    """A polynomial's value, its coefficients from the lowest up."""
    value = row[-1]
    for coefficient in row[-2::-1]:
        value = coefficient + value * x
    return value
