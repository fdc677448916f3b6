"""States of the second formulation at several times: it predicts ends only, so one motion up to each of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import inf, nan
from typing import NamedTuple

import numpy as np

from cases import Case, Transition
from reference.witness import predict

# The names of the numbers of a `LastState.motion`.
MOTION = ("x", "y", "theta", "vx", "vy", "omega", "slip")


# A time (s) after the start in which an impact is over, and nothing moves.
MOMENT = 1e-30


class SecondStates(NamedTuple):
    """Transitions, status and end, and at n times (ξ₁, ξ₂, ω, v), shape (4, n), and what `MOTION` names,
    shape (7, n); NaN after the end."""

    transitions: tuple[Transition, ...]
    status: str
    end: float
    states: np.ndarray
    motions: np.ndarray


class LastState(NamedTuple):
    """The state at the end of a motion: contact parameters and what `MOTION` names, NaN in flight where it has none."""

    points: tuple[float, float]
    motion: tuple[float, ...]


class SecondMotion(NamedTuple):
    """Transitions, status, end (s), and the state there."""

    transitions: tuple[Transition, ...]
    status: str
    end: float
    last: LastState


def motion(case: Case, rtol: float = 1e-10, until: float = inf) -> SecondMotion:
    """The motion of one plate, at most until a time (s)."""
    answer = predict(replace(case, duration=min(case.duration, until)), rtol)
    *points, slip = answer.contacts[0] if len(answer.contacts) == 1 else (nan, nan, nan)
    return SecondMotion(*answer[:3], LastState((points[0], points[1]), (*answer.body, slip)))


def solve(
    case: Case, rtol: float = 1e-10, times: Sequence[float] | np.ndarray = (), until: float = inf
) -> SecondStates:
    """The motion of one contact, and its states at some times."""
    answer = motion(case, rtol, until)
    columns = np.full((9, len(times)), np.nan)
    for i, t in enumerate(np.asarray(times, dtype=float).tolist()):
        if t <= answer.end:
            last = answer.last if t == answer.end else motion(case, rtol, max(t, MOMENT)).last
            columns[:, i] = (*last.points, *last.motion)
    return SecondStates(*answer[:3], columns[[0, 1, 7, 8]], columns[2:])


def poses(case: Case, times: Sequence[float] | np.ndarray, rtol: float = 1e-13) -> np.ndarray:
    """(x, y, θ) of all plates, then their (vx, vy, ω), at n times of a motion, shape (6 plates, n)."""
    return np.array([predict(replace(case, duration=float(t)), rtol).body for t in times]).T
