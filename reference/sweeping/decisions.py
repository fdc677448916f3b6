"""What follows, for many scenarios at once: that part of `minimal.decision` that values alone decide, on arrays.

Where a value is too close to its bound to tell, and where none follows, it is not decided here.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..minimal.decision import close, vanishes
from ..minimal.modes import Regime
from ..minimal.system import System

NO_DECISION = -1


class Columns(NamedTuple):
    """A regime's equations and what of many scenarios they need: `parameters` (p, n), the plate's radius of gyration
    `size` (n,), the same in units of each position, `lengths`, and the `places` of its variables in a full state."""

    regime: Regime
    system: System
    parameters: np.ndarray
    size: np.ndarray
    lengths: tuple[np.ndarray, ...]
    places: list[int]

    def only(self, indices: np.ndarray) -> Columns:
        """Those of some scenarios."""
        parameters, lengths = self.parameters[:, indices], tuple(unit[indices] for unit in self.lengths)
        return self._replace(parameters=parameters, size=self.size[indices], lengths=lengths)


def decide(among: Sequence[Columns], t: np.ndarray, y: np.ndarray, error: float) -> np.ndarray:
    """The place in `among` of the first regime that follows from full states `y` (rows, n) at `t`, or UNDECIDED."""
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
    """Where the candidate's conditions hold just after t for sure, and where they do not for sure."""
    system, own = candidate.system, y[candidate.places]
    values = rows(system.conditions_of_arrays(t, own, candidate.parameters), len(t))
    if not len(values):
        return np.ones(len(t), dtype=bool), np.zeros(len(t), dtype=bool)
    if system.condition_rates:
        names = list(system.conditions)
        rates = rows(system.condition_rates_of_arrays(t, own, candidate.parameters), len(t))
        speeds = [abs(u) / unit for u, unit in zip(own[system.positions :], candidate.lengths, strict=False)]
        bound = vanishes(error) * candidate.size * np.max(speeds, axis=0)
        for name, rate in zip(system.condition_rates, rates, strict=True):
            row = names.index(name)
            values[row] = np.where(np.abs(values[row]) <= bound, rate, values[row])
    certain = np.isfinite(values).all(axis=0)
    scale = np.abs(values).max(axis=0)
    certain &= ~(np.abs(values) <= close(error) * scale).any(axis=0)
    holds = (values > 0.0).all(axis=0)
    return certain & holds, certain & ~holds


def rows(values: Sequence, n: int) -> np.ndarray:
    """What a compiled function returned, as rows (k, n); a constant one is a number."""
    rows = np.empty((len(values), n))
    for row, value in zip(rows, values, strict=True):
        row[:] = value
    return rows
