"""Check that a step resolves a load that depends on place or velocity.

A step's length follows from derivatives at its start, which do not show a load that begins later. But the states along
the step are smooth functions of time, and so are, if the step is not too long, the arguments of the load's functions:
those of exp(-((x - 2)/w)²) and tanh(vx/w) are nearly a parabola and a straight line, however small w is. Such a
function changes quickly near a zero or an extremum of its argument, otherwise so slowly that a few samples show it. So
the load is sampled at a few places of the step and, at decreasing distances, around those zeros and extrema: a
polynomial through every second of these places must agree with all other samples. The derivatives at the start then
determine the load on the whole step, and the zeros of a guard are found.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

import numpy as np
from numpy.polynomial import chebyshev

from ..scales import frequencies
from .modes import Phase

# Degree of the polynomial through a load: where it agrees to rounding, the next singularity of the load (in the complex
# plane) is ten steps away, and the Taylor series of order 12 at the step's start is as accurate at its end.
DEGREE = 8
# Chebyshev–Lobatto points of a step: the load's polynomial goes through every second one and is tested at the others.
# The arguments' go through all: their zeros have to be known much better than to the width of the change there.
PLACES = 0.5 * (1.0 - np.cos(np.pi * np.arange(2 * DEGREE + 1) / (2 * DEGREE)))
_TO_COEFFICIENTS = np.linalg.inv(chebyshev.chebvander(2.0 * PLACES - 1.0, 2 * DEGREE))
_THROUGH_EVERY_SECOND = np.linalg.inv(chebyshev.chebvander(2.0 * PLACES[::2] - 1.0, DEGREE))
_AT_THE_OTHERS = chebyshev.chebvander(2.0 * PLACES[1::2] - 1.0, DEGREE) @ _THROUGH_EVERY_SECOND
# An argument is resolved if its last coefficients are at most this part of its size: its zeros are then known to this
# part of the step, and a change that is no narrower than a tenth of that is found.
ARGUMENT = 1e-10
# Grid for sign changes of the arguments and their slopes: sixteen places per half wave of the highest polynomial.
_GRID = np.linspace(-1.0, 1.0, 16 * DEGREE + 1)
_VALUES = chebyshev.chebvander(_GRID, 2 * DEGREE)
_SLOPES = chebyshev.chebval(_GRID, chebyshev.chebder(np.eye(2 * DEGREE + 1))).T
# An argument larger than this on all of a step has neither a zero nor an extremum that matters there, and may overflow:
# that of 1/(1 + exp(u)) from u = 710 on.
LARGE = 1e60
# Last coefficients below this part of the largest are rounding.
TRIM = 1e-15
# Roots of a polynomial so near to the real axis are real to rounding: those of two that have just met are 1e-7 off it.
NEARLY_REAL = 1e-6
# Around such a place the load is sampled this many times, each time at half the distance, down to 1e-12 of the step.
HALVINGS = 40
_CLOSER = 0.5 ** np.arange(1.0, HALVINGS + 1.0)
_AROUND = np.concatenate([-_CLOSER, [0.0], _CLOSER])
# A polynomial agrees with the load if its error is at most this part of the acting forces, a hundredth of the
# tolerance; below 1e-13 it is rounding, above 1e-6 decisions would be wrong.
PART, FINEST, COARSEST = 1e-2, 1e-13, 1e-6
# The factor by which a polynomial amplifies the rounding of the load.
ROUNDINGS = 16.0
# After this many halvings a step is shorter than a rounding of any time at which it may begin.
MOST_HALVINGS = 100


# Rounding of a component of a state: four units in the last place.
ULPS = 4.0 * float(np.finfo(float).eps)


class Course(Protocol):
    """A step's dense output."""

    @property
    def start(self) -> float:
        """The start of the step, s."""

    @property
    def length(self) -> float:
        """The length of the step, s."""

    def states(self, parts: np.ndarray) -> np.ndarray:
        """States (variables, n) at these parts of the step, 0 to 1."""

    def slopes(self, parts: np.ndarray) -> np.ndarray:
        """Their derivatives by time."""

    @property
    def amplification(self) -> float:
        """The rounding of the slopes in parts of that of the rates."""


def resolved_part(phase: Phase, course: Course, tolerance: float) -> float:
    """The part of a step on which the load of the phase is resolved: 1, 1/2, 1/4, …"""
    part, acting = 1.0, _acting(phase, course)
    bound = min(max(PART * tolerance, FINEST), COARSEST)
    for _ in range(MOST_HALVINGS):
        if _is_resolved(phase, course, part, bound, acting):
            break
        part *= 0.5
    return part


def _acting(phase: Phase, course: Course) -> float | np.ndarray:
    """The size of the forces at the start of the step, N: weight, and the force that accelerates the plate. In flight
    that of each force, as none changes the speed of another (a fast fall does not hide a moment)."""
    often = frequencies(phase, course.start, course.states(np.zeros(1))[:, 0].tolist())
    fastest = np.array(often) if phase.flies else max(often, default=0.0)
    return phase.case.weight + phase.case.plate.mass * phase.size * fastest**2


def _is_resolved(phase: Phase, course: Course, part: float, bound: float, acting: float | np.ndarray) -> bool:
    """Whether the load is resolved on that part of the step: its polynomial's error is at most `bound` of the
    forces."""
    places = part * PLACES
    arguments, forces = _quantities(phase, course, places)
    small = ~(np.min(np.abs(arguments), axis=1) > LARGE)
    least = np.where(np.arange(len(arguments)) < phase.system.check_layout.of_order_one, 1.0, 0.0)[small]
    arguments = arguments[small]
    if not (np.isfinite(arguments).all() and np.isfinite(forces).all()):
        return False
    coefficients = _TO_COEFFICIENTS @ arguments.T
    tails, sizes = np.max(np.abs(coefficients[-2:]), axis=0), np.maximum(np.max(np.abs(arguments), axis=1), least)
    misfit = np.max(np.abs(forces[:, ::2] @ _AT_THE_OTHERS.T - forces[:, 1::2]), axis=1)
    largest = np.max(np.abs(forces), axis=1)
    errors, error = ARGUMENT * sizes, bound * (acting + (largest if phase.flies else np.max(largest)))
    if np.any(misfit > error) or np.any(tails > errors):
        of_arguments, of_forces = _roundings(phase, course, places)
        errors = np.fmax(errors, ROUNDINGS * of_arguments[small])
        error = np.fmax(error, ROUNDINGS * of_forces)
        if not (np.all(misfit <= error) and np.all(tails <= errors)):
            return False
    events = _events(coefficients)
    if not len(events):
        return True
    samples = np.unique((events[:, None] + _AROUND).clip(0.0, 1.0))
    there = _quantities(phase, course, part * samples)[1]
    polynomial = chebyshev.chebval(2.0 * samples - 1.0, _THROUGH_EVERY_SECOND @ forces[:, ::2].T)
    misfit = np.max(np.abs(polynomial - there), axis=1)  # NaN, which is not less than what is allowed, without a value
    if np.any(misfit > error):
        error = np.fmax(error, ROUNDINGS * _roundings(phase, course, part * samples)[1])
    return bool(np.all(misfit <= error))


def _events(coefficients: np.ndarray) -> np.ndarray:
    """Zeros and extrema (0 to 1) of arguments with these Chebyshev coefficients (degree + 1, k)."""
    parts = [np.empty(0)]
    for matrix, order in ((_VALUES, 0), (_SLOPES, 1)):
        signs = matrix @ coefficients >= 0.0
        for k in np.flatnonzero((signs[1:] != signs[:-1]).any(axis=0)):
            own = coefficients[:, k]
            # Most are straight lines or parabolas except for rounding.
            own = chebyshev.chebtrim(own, TRIM * float(np.max(np.abs(own))))
            roots = chebyshev.chebroots(chebyshev.chebder(own, order))
            parts.append(roots.real[np.abs(roots.imag) <= NEARLY_REAL])
    every = 0.5 * (1.0 + np.concatenate(parts))
    return every[(every >= 0.0) & (every <= 1.0)]


def _quantities(phase: Phase, course: Course, parts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Arguments (k, n), and the forces: friction by a formula, the load's force and moment over the radius of gyration
    (3 or 4, n; N) at these parts of the step."""
    times, states = course.start + course.length * parts, course.states(parts)
    with np.errstate(all="ignore"):  # what has no value, or overflows, is looked for in the result
        rows = phase.system.load_quantities_of_arrays(times, states, phase.parameters)
    forces = phase.system.check_layout.forces
    every = np.empty((len(rows), len(parts)))
    for own, row in zip(every, rows, strict=True):
        own[:] = row  # a constant one is a number
    every[-1] /= phase.size
    return every[:-forces], every[-forces:]


def _roundings(phase: Phase, course: Course, parts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rounding of each of `_quantities`, the largest at these parts of the step."""
    times, states = course.start + course.length * parts, course.states(parts)
    rows = np.max(roundings(phase, phase.system.load_quantities_of_arrays, times, states), axis=1)
    forces = phase.system.check_layout.forces
    rows[-1] /= phase.size
    return rows[:-forces], rows[-forces:]


def roundings(
    phase: Phase, of: Callable[..., Sequence[float | np.ndarray]], times: np.ndarray, states: np.ndarray
) -> np.ndarray:
    """Rounding (rows, n) of the rows of(times, states (variables, n), parameters): the sum of their changes if time and
    each component of the states are moved by its rounding, one after another.

    A speed is moved by the rounding of the largest, as equations contain differences of speeds: that of the centre of
    a disc that spins in place is one.
    """
    p, sizes = phase.system.positions, np.abs(np.vstack([times, states]))
    speeds, units = sizes[1 + p :], np.array(phase.lengths)[: len(states) - p, None]
    if len(speeds):
        speeds[:] = np.max(speeds / units, axis=0) * units
    count, n = sizes.shape
    samples = np.tile(np.vstack([times, states]), count + 1)
    for k in range(count):
        samples[k, k * n : (k + 1) * n] += ULPS * sizes[k]
    with np.errstate(all="ignore"):  # a load's exp(u) may overflow where 1/(1 + exp(u)) vanishes
        rows = of(samples[0], samples[1:], phase.parameters)
        values = np.array([np.broadcast_to(row, samples.shape[1]) for row in rows]).reshape(len(rows), count + 1, n)
        return np.sum(np.abs(values[:, :-1] - values[:, -1:]), axis=1)
