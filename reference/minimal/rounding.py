"""Rounding of functions of a phase's state, by their changes where the state is moved by its own rounding."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from .modes import Phase

# Rounding of a component of a state: four units in the last place.
ULPS = 4.0 * float(np.finfo(float).eps)


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
