"""States of the second formulation at several times: it predicts ends only, so one motion up to each of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from cases import Case, Transition
from reference import witness
from reference.witness import predict


class SecondStates(NamedTuple):
    """Transitions, status and end, and at n times (ξ₁, ξ₂, ω, v), shape (4, n), and what `witness.MOTION` names,
    shape (7, n); NaN after the end."""

    transitions: tuple[Transition, ...]
    status: str
    end: float
    states: np.ndarray
    motions: np.ndarray


def solve(case: Case, rtol: float = 1e-10, times: Sequence[float] | np.ndarray = (), **options) -> SecondStates:
    """The motion of one contact, as `witness.solve`."""
    answer = witness.solve(case, rtol, **options)
    columns = np.full((9, len(times)), np.nan)
    for i, t in enumerate(np.asarray(times, dtype=float).tolist()):
        if t <= answer.end:
            last = witness.solve(case, rtol, **(options | {"until": t})).last
            columns[:, i] = (*last.points, *last.motion)
    return SecondStates(*answer[:3], columns[[0, 1, 7, 8]], columns[2:])


def poses(case: Case, times: Sequence[float] | np.ndarray, rtol: float = 1e-13) -> np.ndarray:
    """(x, y, θ) of all plates, then their (vx, vy, ω), at n times of a motion, shape (6 plates, n)."""
    return np.array([predict(replace(case, duration=float(t)), rtol).body for t in times]).T
