"""Checks of a finished step: the part of it that may be accepted.

An integrator computes a step from derivatives at its start, and these do not show a bump ahead (of a curve or a load).
The features of curves, and of loads in time, are known (`cases.formulas.features`): a step ends where a finer piece
begins. A load in place or velocity is sampled along the step itself (`load_check`). A step is also halved if its dense
output, in which events are searched, does not satisfy the equations.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.polynomial.polynomial import polyder, polyval

from cases.formulas.features import Features

from .load_check import ULPS, Course, resolved_part, roundings
from .modes import Phase

# Places in a step at which its states are sampled: between two of them they have at most one extremum.
PARTS = np.linspace(0.0, 1.0, 9)
# A step may go this far beyond its bound, in strides of the piece that begins there: interpolation covers that part.
BEYOND = 0.1
# Places in a step at which its defect is computed.
INSIDE = np.array([0.3, 0.6, 0.9])
# A repeated step has at most this part of its length, so that the number of retries is bounded: a bound that the step
# passes by only a rounding would give the same step again. Any length shrinks to a rounding of the time in 350 retries.
SHORTER = 0.9


class Expansion(NamedTuple):
    """A step by its Taylor polynomial: start, length (s), coefficients (variables, order + 1)."""

    start: float
    length: float
    coefficients: np.ndarray

    def states(self, parts: np.ndarray) -> np.ndarray:
        """States (variables, n) at these parts of the step, 0 to 1."""
        return polyval(self.length * parts, self.coefficients.T)

    def slopes(self, parts: np.ndarray) -> np.ndarray:
        """Their derivatives by time."""
        return polyval(self.length * parts, polyder(self.coefficients.T))

    @property
    def amplification(self) -> float:
        """The rounding of the slopes in parts of that of the rates, whose derivatives the coefficients are: each
        order adds that of its own."""
        return float(self.coefficients.shape[1])


def good_part(phase: Phase, course: Course, tolerance: float, most: float) -> float:
    """The part of a step that may be accepted at that tolerance, with a defect of at most `most`: 1, or at most
    SHORTER."""
    part = clear_part(phase, course, tolerance)
    if part < 1.0:
        return part
    times, states, slopes = course.start + course.length * INSIDE, course.states(INSIDE), course.slopes(INSIDE)
    if defect(phase, times, states, slopes, course.length) <= most:
        return 1.0
    rounding = _rounding(phase, course, times, states)
    return 1.0 if defect(phase, times, states, slopes, course.length, rounding) <= most else 0.5


def _rounding(phase: Phase, course: Course, times: np.ndarray, states: np.ndarray) -> np.ndarray:
    """Rounding of the slopes (variables, n) of a step at these times and states: that of the rates, amplified, and that
    of the states over the step."""

    def rates(times, states, parameters):
        each = zip(times.tolist(), states.T.tolist(), strict=True)
        return np.transpose([phase.system.rates_of_numbers(t, y, parameters) for t, y in each])

    of_rates, p = ULPS * np.abs(rates(times, states, phase.parameters)), phase.system.positions
    of_rates[p:] += roundings(phase, rates, times, states)[p:]  # the rates of positions are the speeds themselves
    return course.amplification * of_rates + ULPS * np.abs(states) / course.length


def clear_part(phase: Phase, course: Course, tolerance: float) -> float:
    """The part of a step that passes over no feature: 1, or at most SHORTER if a finer piece of a curve begins in it or
    the load is not resolved."""
    part = 1.0
    if phase.features:
        states, times = course.states(PARTS), course.start + course.length * PARTS
        part = min(_part(f, times if row is None else states[row]) for row, f in phase.features)
    if phase.checks_load:
        part = min(part, resolved_part(phase, course, tolerance))
    return part if part == 1.0 else min(part, SHORTER)


def _part(features: Features, way: np.ndarray) -> float:
    start, lowest, highest = float(way[0]), float(way.min()), float(way.max())
    low, high = features.clear(start, lowest), features.clear(start, highest)
    if low == lowest and high == highest:
        return 1.0
    beyond = np.flatnonzero((way < low - _slack(features, start, low)) | (way > high + _slack(features, start, high)))
    if not beyond.size:
        return 1.0
    i = int(beyond[0])
    bound = high if way[i] > high else low
    return float(PARTS[i - 1] + (PARTS[i] - PARTS[i - 1]) * (bound - way[i - 1]) / (way[i] - way[i - 1]))


def _slack(features: Features, start: float, bound: float) -> float:
    """The distance beyond its bound that a step may reach into the next piece."""
    about = 1e-6 * abs(bound - start)  # the bound may lie a rounding before the piece that it is the end of
    stride = features.finest(bound - about, bound + about)
    return BEYOND * stride if stride < np.inf else 0.0


def defect(
    phase: Phase,
    times: np.ndarray,
    states: np.ndarray,
    slopes: np.ndarray,
    length: float,
    rounding: np.ndarray | float = 0.0,
) -> float:
    """The defect of a step's dense output: the largest y' - f(t, y), times the step's length, in parts of the state's
    natural sizes in that step.

    `states` and `slopes` (variables, n): the dense output and its derivative at `times`; `length` of the step in s;
    `rounding` (variables, n): what the defect may be without being counted.
    """
    p, worst = phase.system.positions, 0.0
    units, free = _units(phase, states), np.broadcast_to(rounding, states.shape)
    for t, y, slope, less in zip(times.tolist(), states.T.tolist(), slopes.T.tolist(), free.T.tolist(), strict=True):
        rates = phase.system.rates_of_numbers(t, y, phase.parameters)
        for i, (rate, own) in enumerate(zip(rates, slope, strict=True)):
            # The size of a speed: the position's over the step's length, plus its own value.
            size = units[i] if i < p else units[i - p] / length + abs(y[i])
            worst = max(worst, length * (abs(own - rate) - less[i]) / size)
    return worst


def _units(phase: Phase, states: np.ndarray) -> list[float]:
    """The sizes of the positions in a step: the plate's own or, if smaller, the stride of the curve's finest piece.

    At the sharp end of an ellipse of 50:1 the tangent turns by a radian while the parameter changes by 0.02: an error
    in parts of the plate's size would be fifty times too large.
    """
    units = list(phase.lengths)
    for row, features in phase.features:
        if row is not None and row < len(units):
            units[row] = min(units[row], features.finest(float(states[row].min()), float(states[row].max())))
    return units
