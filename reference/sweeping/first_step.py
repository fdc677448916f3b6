"""The first short step of a phase, for many scenarios at once.

A phase begins with a guard at zero that is known to grow. An integrator that searches for that guard's zero would find
the start again, or miss a slip that ends soon after. So a first step leaves the start. It is such a small part of the
motion's time scale that two half steps of the classical Runge–Kutta method are exact to rounding, which is checked.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..minimal.integrators.first_step import PART, dip, runge_kutta
from ..scales import EPS
from .decisions import Columns, rows

# The step is PART of the motion's time scale: its fifth power, which is the method's error, is rounding. The whole step
# and the two half steps may differ by this many roundings of the state's natural sizes.
ROUNDINGS = 64 * EPS
# A slip or spin below this part of the plate's speed may still be zero: it is a difference of speeds that carry
# rounding errors. The slip of the paper's disc, released on the level wall, grows to 1e-3 of the speed here.
CLEAR = 1e-12


class FirstSteps(NamedTuple):
    """Times (n,) and states (variables, n) after the step, and where they are valid (`sound`)."""

    times: np.ndarray
    states: np.ndarray
    sound: np.ndarray


def leave(now: Columns, t: np.ndarray, y: np.ndarray, end: np.ndarray) -> FirstSteps:
    """The states after a first short step from `t`; `sound` where all guards are positive there and half-way, and do
    not reach zero between."""
    p = now.system.positions
    largest_rate = _largest_rate(now, t, y)
    h = np.minimum(PART / largest_rate, end - t)
    whole = _step(now, t, y, h)
    half = _step(now, t, y, 0.5 * h)
    later = _step(now, t + 0.5 * h, half, 0.5 * h)
    sizes = [*now.lengths, *(length / h for length in now.lengths)][: len(y)]
    scale = np.array([np.broadcast_to(size, t.shape) for size in sizes])
    scale[p:] += np.abs(y[p:])
    sound = np.isfinite(largest_rate) & (largest_rate > 0.0) & (h > 0.0)
    sound &= (np.abs(whole - later) <= ROUNDINGS * (scale + np.abs(y))).all(axis=0)
    velocities = [name in now.system.condition_rates for name in now.system.guards]
    values = [rows(now.system.guards_of_arrays(t, y, now.parameters), len(t))]
    for part, state in ((0.5, half), (1.0, later)):
        values.append(rows(now.system.guards_of_arrays(t + part * h, state, now.parameters), len(t)))
        least = np.outer(velocities, CLEAR * now.size * now.fastest(state))
        sound &= (values[-1] > least).all(axis=0)
    sound &= ~dip(*values)[0].any(axis=0)
    return FirstSteps(t + h, later, sound)


def _largest_rate(now: Columns, t: np.ndarray, y: np.ndarray) -> np.ndarray:
    """The largest rate at which the states change, 1/s, from their speeds, accelerations and contact forces."""
    p = now.system.positions
    forces = now.system.record(*now.system.outputs_of_arrays(t, y, now.parameters))
    fastest = np.sqrt(np.maximum(np.abs(forces.normal), np.abs(forces.friction)) / now.size)
    rates = rows(now.system.rates_of_arrays(t, y, now.parameters), len(t))
    for acceleration, length in zip(rates[p:], now.lengths, strict=False):
        fastest = np.maximum(fastest, np.sqrt(np.abs(acceleration) / length))
    return np.maximum(fastest, now.fastest(y))


def _step(now: Columns, t: np.ndarray, y: np.ndarray, h: np.ndarray) -> np.ndarray:
    """The states (variables, n) after steps h (s)."""
    return runge_kutta(lambda s, x: rows(now.system.rates_of_arrays(s, x, now.parameters), len(t)), t, y, h)


def course(now: Columns, t: np.ndarray, y: np.ndarray, guard: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A guard's first and second time derivative at its zero, and its size before that, each (n,)."""
    h = 10.0 * PART / _largest_rate(now, t, y)
    values = []
    for part in (-2.0, -1.0, 0.0, 1.0, 2.0):
        there = _step(now, t, y, part * h)
        values.append(rows(now.system.guards_of_arrays(t + part * h, there, now.parameters), len(t))[guard])
    before, back, here, on, after = values
    slope = (8.0 * (on - back) - (after - before)) / (12.0 * h)
    bend = (16.0 * (on + back) - (after + before) - 30.0 * here) / (12.0 * h * h)
    return slope, bend, np.abs(slope) / _largest_rate(now, t, y) + np.abs(here)
