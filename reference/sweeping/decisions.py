"""Mode decisions for many scenarios at once: the part of `minimal.decision` that needs only values, on arrays.

A scenario remains undecided here if a value is too close to its bound, or if no regime follows.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..minimal.decision import close
from ..minimal.modes import Regime
from ..minimal.system import System
from ..scales import slip_error

NO_DECISION = -1


class Columns(NamedTuple):
    """A regime's equations and the data of many scenarios that they need: `parameters` (p, n), the plate's radius of
    gyration `size` (n,), the same in units of each position, `lengths`, and the rows `places` of its variables in a
    full state."""

    regime: Regime
    system: System
    parameters: np.ndarray
    size: np.ndarray
    lengths: tuple[np.ndarray, ...]
    places: list[int]

    def only(self, indices: np.ndarray) -> Columns:
        """The columns of some scenarios."""
        parameters, lengths = self.parameters[:, indices], tuple(unit[indices] for unit in self.lengths)
        return self._replace(parameters=parameters, size=self.size[indices], lengths=lengths)

    def fastest(self, own: np.ndarray) -> np.ndarray:
        """The largest of the speeds over size, 1/s (n,), of the regime's own variables; 0 of one without speeds."""
        speeds = [np.abs(u) / unit for u, unit in zip(own[self.system.positions :], self.lengths, strict=False)]
        return np.max(speeds, axis=0) if speeds else np.zeros(own.shape[1])


def decide(among: Sequence[Columns], t: np.ndarray, y: np.ndarray, error: float) -> np.ndarray:
    """The index in `among` of the first regime that follows from full states `y` (rows, n) at `t`, or NO_DECISION."""
    choices = np.full(len(t), NO_DECISION)
    remaining = np.arange(len(t))
    for place, candidate in enumerate(among):
        if not remaining.size:
            break
        yes, no = follows(candidate.only(remaining), t[remaining], y[:, remaining], error)
        choices[remaining[yes]] = place
        remaining = remaining[no]
    return choices


def follows(candidate: Columns, t: np.ndarray, y: np.ndarray, error: float) -> tuple[np.ndarray, np.ndarray]:
    """Where the candidate's conditions certainly hold just after t, and where they certainly do not."""
    system, own = candidate.system, y[candidate.places]
    values = rows(system.conditions_of_arrays(t, own, candidate.parameters), len(t))
    if not len(values):
        return np.ones(len(t), dtype=bool), np.zeros(len(t), dtype=bool)
    if system.condition_rates:
        names = list(system.conditions)
        rates = rows(system.condition_rates_of_arrays(t, own, candidate.parameters), len(t))
        bound = slip_error(error) * candidate.size * candidate.fastest(own)
        for name, rate in zip(system.condition_rates, rates, strict=True):
            row = names.index(name)
            values[row] = np.where(np.abs(values[row]) <= bound, rate, values[row])
    certain = np.isfinite(values).all(axis=0)
    scale = np.abs(values).max(axis=0)
    certain &= ~(np.abs(values) <= close(error) * scale).any(axis=0)
    holds = (values > 0.0).all(axis=0)
    return certain & holds, certain & ~holds


def rows(values: Sequence, n: int) -> np.ndarray:
    """The values that a compiled function returned, as rows (k, n); a constant value may be a number."""
    rows = np.empty((len(values), n))
    for row, value in zip(rows, values, strict=True):
        row[:] = value
    return rows
