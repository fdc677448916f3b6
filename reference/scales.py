"""The scales with which quantities are compared, each with the reason why it cannot vanish with the quantity."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from math import ceil, frexp, ldexp, log10, sqrt
from typing import Any, Protocol

import numpy as np

from cases import Load, Plate


class PhaseNumbers(Protocol):
    """What scales need of a phase: its equations, their parameters, and the plate's size in units of each position."""

    @property
    def system(self) -> Any: ...
    @property
    def parameters(self) -> tuple[float, ...]: ...
    @property
    def lengths(self) -> tuple[float, ...]: ...


# --- time ---------------------------------------------------------------------------------------------------------


def frequency(phase: PhaseNumbers, t: float, y: Sequence[float]) -> float:
    """How fast a state changes, 1/s: the largest of `frequencies`; 0 without motion and acceleration; infinite or NaN
    if the state is not finite. Short and long are relative to it, never to the duration of the case."""
    return max(frequencies(phase, t, y), default=0.0)


def frequencies(phase: PhaseNumbers, t: float, y: Sequence[float]) -> list[float]:
    """How fast each position changes, 1/s: the larger of speed over size and √(acceleration over size)."""
    rates = phase.system.rates_of_numbers(t, tuple(y), phase.parameters)
    p = phase.system.positions
    # A motion from rest covers its own size in √(size/acceleration).
    return [
        max(abs(u) / size, sqrt(abs(u_dot) / size))
        for u, u_dot, size in zip(y[p:], rates[p:], phase.lengths, strict=False)
    ]


# The largest speed of a surface in a step is that at so many instants inside it.
LOOKS = 8


def looks_between(times: np.ndarray) -> np.ndarray:
    """Instants inside steps (s). The speeds of a motion are compared with the largest of them all: one that returns to
    zero at the end of each step, as that of a belt which turns back, would vanish with the slip on it."""
    parts = (np.arange(LOOKS) + 0.5) / LOOKS
    return (times[:-1, None] + np.diff(times)[:, None] * parts).ravel()


# --- places -------------------------------------------------------------------------------------------------------

# A gap below this part of the plates' size and place is none: the rounding of an event's pose.
TOUCHES = 1e-12


# --- speeds -------------------------------------------------------------------------------------------------------

# Relative rounding of a number.
EPS = 2.0**-52
# Velocities below this part of a motion's largest speed are the roundings of a constraint that has just begun.
STILL = 1e-11


def slip_error(error: float) -> float:
    """The part of the plate's speed below which a slip or a spin counts as zero in a state of that relative error: at
    an event a thousand times its error; at a start the rounding of a difference of two speeds."""
    return 1e3 * error if error > EPS else 8 * EPS


def speed_scale(acceleration: float, length: float) -> float:
    """The speed (m/s) that a load of that acceleration (m/s²) gives over a length (m), as that of a fall from a plate's
    size. A state at rest has no speed of its own with which its roundings could be compared; without a load it is 0."""
    return sqrt(2.0 * acceleration * length)


# --- accelerations ------------------------------------------------------------------------------------------------


def approach_scale(phase: PhaseNumbers, t: float, y: Sequence[float]) -> float:
    """The size of what `Elimination.free_approach` is a sum of, m/s², at a state of the phase's own variables.

    It is how far the sum would be off if time, state, parameters and each operation were off by one part in one. Where
    a plate at rest is lifted, weight and load cancel: the sum, all forces of the contact and all accelerations vanish
    together there, and this does not.
    """
    return phase.system.approach_error(t, y, phase.parameters)


def load_acceleration(plate: Plate, load: Load, t: float, body: Sequence[float] | np.ndarray) -> float:
    """A load of a plate (x, y, θ, vx, vy, ω) per mass, m/s², each component alone, as they may cancel."""
    fx, fy, moment = load.at(t, *map(float, body))
    return (abs(fx) + abs(fy) + abs(moment) / plate.gyration) / plate.mass


# --- forces -------------------------------------------------------------------------------------------------------


def force_scale(largest: float, mass: float, acceleration: float, speed: float, size: float) -> float:
    """The scale of a motion's contact forces, N: the largest of them at all times, or what weight and load (m/s²), or
    that speed (m/s) on a path of that size (m), would make. Forces on a straight weightless track are roundings
    alone."""
    return max(largest, mass * max(acceleration, speed * speed / size))


def power_of_two(value: float) -> float:
    """The power of two above a positive value: products with it add no rounding, and nearby values have the same."""
    return ldexp(1.0, frexp(value)[1]) if value else 0.0


# --- inverse masses -----------------------------------------------------------------------------------------------


def inverse_mass_scale(delassus: np.ndarray) -> float:
    """The size of a matrix from contact forces to rates, 1/kg: its largest diagonal entry, which is positive as each
    contact can accelerate some plate; 1 without contacts. In units of it the matrix has no unit of mass. It is rounded
    to a power of two, so that these units add no rounding."""
    largest = float(np.abs(np.diag(delassus)).max(initial=0.0))
    return power_of_two(largest) or 1.0


# --- phases -----------------------------------------------------------------------------------------------------

# A motion ends where MANY phases together take less than NO_TIME of its time scale, or STUCK in a row no time at all.
MANY, NO_TIME, STUCK = 1000, 1e-9, 50

# Limit on the steps of one run: their record, which is made when samples are requested, fills a gigabyte or two. (A
# hundred thousand changes of a limping wheel take 830,000.)
MOST_STEPS = 1_000_000

# Relative error of an event's location, whatever the tolerance of the motion that led there.
LOCATION_ERROR = 1e-12

# Values within this part of a bound are at it where phases of zero length follow each other: a thousand times the
# location's error.
ROUGH = 1e-9

# From this many phases of zero length in a row (a slip that begins, ends and begins again), values within ROUGH of a
# bound count as being at it.
IDLE = 4


@lru_cache(maxsize=64)
def error_range(error: float) -> tuple[float, ...]:
    """Relative errors from an event's to that of the motion, by powers of ten."""
    count = 1 + ceil(log10(max(error, LOCATION_ERROR) / LOCATION_ERROR))
    return tuple(np.geomspace(LOCATION_ERROR, max(error, LOCATION_ERROR), count).tolist())
