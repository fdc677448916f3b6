"""What a plate does between impacts: how far it turns after each, and when it comes to rest.

Pure functions; SI units.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise
from math import isfinite, nan
from typing import NamedTuple

import numpy as np

from cases import Case, Mode, State, Trajectory
from cases.mechanics import kinetic_energy

from .ledger import LedgerRow

# A plate is at rest once its kinetic energy stays below this part of its largest: it has lost 99 % of its speed.
_AT_REST = 1e-4
# Times of a motion with dense output.
_EVEN = 4001


class ImpactRow(NamedTuple):
    """An impact of the truth, of a solver, or of both, with how far the plate turns afterwards before the next one:
    `swing` and `reference_swing`, rad. `event` numbers the rows from 1; the row with event 0 is the time of rest. Times
    in s; NaN where there is none."""

    event: int
    contact: str
    time: float
    reference_time: float
    swing: float
    reference_swing: float


def rows(case: Case, motion: Trajectory, truth: Trajectory, paired: Sequence[LedgerRow]) -> tuple[ImpactRow, ...]:
    """The impacts of a motion next to the truth's, and the times of rest; `paired`: their transitions."""
    landings = [row for row in paired if row.before is Mode.FLIGHT and row.after is not Mode.FLIGHT]
    own, true = (
        _swings(motion, [row.time for row in landings]),
        _swings(truth, [row.reference_time for row in landings]),
    )
    result = [ImpactRow(0, "", rest_time(case, motion), rest_time(case, truth), nan, nan)]
    for number, row in enumerate(landings, start=1):
        there = (own.get(row.time, nan), true.get(row.reference_time, nan))
        result.append(ImpactRow(number, row.contact, row.time, row.reference_time, *there))
    return tuple(result)


def _swings(motion: Trajectory, times: Sequence[float]) -> dict[float, float]:
    """The largest turn of the plate after each of the impacts and before the next, rad, by the impact's time."""
    t, state = _samples(motion)
    theta = np.asarray(state.theta)
    known = sorted(time for time in times if isfinite(time) and time <= t[-1])
    swings = {}
    for begin, end in pairwise([*known, float(t[-1])]):
        inside = (t >= begin) & (t <= end)
        at_impact = float(np.interp(begin, t, theta))
        swings[begin] = float(np.max(np.abs(theta[inside] - at_impact), initial=0.0))
    return swings


def rest_time(case: Case, motion: Trajectory) -> float:
    """The time after which the kinetic energy stays below a small part of its largest, s; NaN if the motion ends
    before."""
    t, state = _samples(motion)
    kinetic = np.asarray(kinetic_energy(case, state))
    moving = np.flatnonzero(kinetic > _AT_REST * float(np.max(kinetic, initial=0.0)))
    if not len(moving):
        return 0.0
    return float(t[moving[-1] + 1]) if moving[-1] + 1 < len(t) else nan


@lru_cache(maxsize=2)
def _samples(motion: Trajectory) -> tuple[np.ndarray, State]:
    """Times and states of a motion: at its own samples, or at even times if its steps are few. Cached, as all motions
    of a case are compared with one truth."""
    if motion.dense is None:
        return motion.t, State(*(getattr(motion, name) for name in State._fields))
    t = np.linspace(motion.t[0], motion.t[-1], _EVEN)
    return t, motion(t)
