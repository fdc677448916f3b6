"""Derivatives of a motion by a parameter, through its events, with error bars.

Transition times, and states at fixed times, are smooth functions of a parameter as long as the sequence of transitions
stays the same: at an event g(t, y, p) = 0 with ġ ≠ 0 the implicit function theorem gives the derivative of its time.
Central differences of motions at p ± h have errors in even powers of h, which Richardson's extrapolation removes; each
motion is exact to some roundings, so that bars are about 1e-11 of the scale. Where the sequence changes however small h
is (grazing, two events at once), there is no derivative, nor at a state's kink, as of a velocity at a transition.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import inf
from typing import NamedTuple

import numpy as np

from cases import BadValue, Case, CaseError, Trajectory, registry
from cases.errors import unknown_name

from .certification.bars import Bar
from .certification.certificate import SAMPLES
from .certification.witnesses import states_of
from .solve import simulate

# The first step in units of the parameter; a parameter that is 0 has the unit 1.
FIRST = 1e-2
# Steps are halved so often for the extrapolation, and before, until the sequence of transitions stays.
HALVINGS, MOST_HALVINGS = 6, 30
# Roundings of a time or a state: errors of motions at 1e-14 are some tens of them (`certification.bars`).
NOISE = 64 * np.finfo(float).eps
# From step to step the change of a central difference falls by 4 where errors are even powers of h, by 2 where a second
# derivative jumps; then the last difference is taken, and four times its change is its bar.
EVEN = 3.0
# At a kink the second difference over h does not fall with h; elsewhere it is proportional to h.
KINK = 0.75


class NoDerivative(CaseError):
    """The motion has no derivative by the parameter there."""


class TransitionDerivative(NamedTuple):
    """A transition of a `contact` at `time` (s), and d(time)/d(parameter) with its error bar."""

    contact: str
    before: str
    after: str
    time: float
    derivative: Bar


class Derivatives(NamedTuple):
    """The derivatives of a motion by a parameter: those of all transition times, and of the states at `times` (s), by
    quantity. NaN with an infinite bar where a state has no derivative."""

    parameter: str
    value: float
    transitions: tuple[TransitionDerivative, ...]
    times: tuple[float, ...]
    states: dict[str, tuple[Bar, ...]]


def derivatives(case: Case, parameter: str, rtol: float = 1e-14) -> Derivatives:
    """The derivatives of the motion of a case by a parameter of its function, such as "mu", or by a value of its start,
    such as "start.slip".

    `rtol`: relative accuracy of the motions. Raises UnknownName for a parameter that does not exist, NoDerivative where
    the sequence of transitions changes next to the value, or values next to it make no scene.
    """
    value, make = _by(case, parameter)

    def motion(p: float) -> Trajectory:
        return simulate(replace(make(p), duration=case.duration), rtol=rtol)

    centre = motion(value)
    times = np.linspace(0.0, float(centre.t[-1]), SAMPLES)  # as of certificates
    steps, sides = _steps(parameter, value, motion, centre, times)
    found = _extrapolated(steps, _numbers(centre, times), sides)
    count = len(centre.transitions)
    changes = tuple(
        TransitionDerivative(t.contact, str(t.before), str(t.after), t.time, derivative)
        for t, derivative in zip(centre.transitions, found, strict=False)
    )
    rest = np.array(found[count:], dtype=float).reshape(-1, len(times), 2)
    names = states_of(centre, times)
    states = {name: tuple(Bar(*pair) for pair in row.tolist()) for name, row in zip(names, rest, strict=True)}
    return Derivatives(parameter, value, changes, tuple(times.tolist()), states)


def _by(case: Case, parameter: str) -> tuple[float, Callable[[float], Case]]:
    """The value of a parameter, and the case with another one."""
    start, _, field = parameter.partition(".")
    values = {f"start.{name}": value for name, value in vars(case.start).items() if isinstance(value, float)}
    if start == "start" and parameter in values:
        return values[parameter], lambda p: replace(case, start=replace(case.start, **{field: p}))
    of_function = registry.entry(case.name).parameters | dict(case.parameters) if case.name in registry.names() else {}
    numbers = {name: float(each) for name, each in of_function.items() if isinstance(each, int | float)}
    if parameter not in numbers and not of_function:
        raise BadValue(
            f"{case.label} has no parameters but {', '.join(values)}, not {parameter!r}; make it by a function with "
            "@case, which has its own"
        )
    if parameter not in numbers:
        raise unknown_name(f"parameter of {case.label}", parameter, [*numbers, *values])
    return numbers[parameter], lambda p: registry.load(case.name, **{**case.parameters, parameter: p})


def _sequence(motion: Trajectory) -> tuple:
    return motion.status, *((t.contact, t.before, t.after) for t in motion.transitions)


def _numbers(motion: Trajectory, times: np.ndarray) -> np.ndarray:
    """The transition times, and all states at times one after the other."""
    within = np.minimum(times, float(motion.t[-1]))
    return np.array([*(t.time for t in motion.transitions), *np.concatenate([*states_of(motion, within).values()])])


def _steps(
    parameter: str, value: float, motion: Callable[[float], Trajectory], centre: Trajectory, times: np.ndarray
) -> tuple[list[float], list[tuple[np.ndarray, np.ndarray]]]:
    """Steps, each half of the one before, and the numbers of the motions below and above: the first step is the largest
    one with which the sequence of transitions stays."""
    h, steps, sides, reason = FIRST * abs(value or 1.0), list[float](), list[tuple[np.ndarray, np.ndarray]](), ""
    for _ in range(MOST_HALVINGS):
        try:
            both = motion(value - h), motion(value + h)
        except BadValue as problem:
            both, reason = None, str(problem)
        if both is not None and all(_sequence(one) == _sequence(centre) for one in both):
            steps.append(h)
            sides.append((_numbers(both[0], times), _numbers(both[1], times)))
            if len(steps) == HALVINGS:
                return steps, sides
        elif steps:
            break
        h /= 2.0
    reason = reason or f"the sequence of transitions changes within {h:.1g}"
    raise NoDerivative(f"there is no derivative by {parameter} at {value:g}: {reason}")


def _extrapolated(steps: list[float], centre: np.ndarray, sides: list[tuple[np.ndarray, np.ndarray]]) -> list[Bar]:
    """The derivative of each number, by Richardson's extrapolation: of its columns the value that differs least from
    the one before it, and that difference with the roundings of the differences as its bar."""
    below, above = (np.array(some) for some in zip(*sides, strict=True))
    h = np.array(steps)[:, None]
    column = plain = (above - below) / (2.0 * h)
    rounding = NOISE * np.abs(centre) / h
    best, error = column[-1], np.abs(column[-1] - column[-2]) + rounding[-1]
    for order in range(1, len(steps)):
        column, before = column[1:] + (column[1:] - column[:-1]) / (4.0**order - 1.0), column
        errors = np.abs(column - before[1:]) + 2.0 * rounding[order:]
        row = errors.argmin(axis=0)
        least = errors[row, np.arange(len(centre))]
        best, error = np.where(least < error, column[row, np.arange(len(centre))], best), np.minimum(least, error)
    earlier, last = np.abs(np.diff(plain[-3:], axis=0))
    is_rough = (last > 4.0 * rounding[-1]) & (earlier < EVEN * last)
    best, error = np.where(is_rough, plain[-1], best), np.where(is_rough, 4.0 * last, error)
    bend = np.abs(above - 2.0 * centre + below) / h
    kink = bend[-1] > np.maximum(KINK * bend[-2], 4.0 * rounding[-1])
    return [
        Bar(np.nan, inf) if is_kink else Bar(float(d), float(e))
        for d, e, is_kink in zip(best, error, kink, strict=True)
    ]
