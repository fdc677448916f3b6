"""A plate at rest: its dense output, and the time until which its contacts hold it under a load."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cases import Case, Load

from . import forces
from .decision import load_at
from .geometry import ContactPlace
from .regimes import body_of

# Looks at a load in time while it may end a rest, besides those that resolve its features.
LOOKS = 64


@dataclass(frozen=True)
class RestStates:
    """The dense output of a plate at rest."""

    state: tuple[float, ...]

    def __call__(self, times: np.ndarray) -> np.ndarray:
        return np.outer(self.state, np.ones_like(times))


@dataclass(frozen=True)
class StraightStates:
    """States that change linearly from one time (s) to another: times (n,) ↦ states (variables, n)."""

    start: float
    end: float
    first: tuple[float, ...]
    last: tuple[float, ...]

    def __call__(self, times: np.ndarray) -> np.ndarray:
        first, part = np.array(self.first), (times - self.start) / (self.end - self.start)
        return first[:, None] + np.outer(np.array(self.last) - first, part)


def limit_of_rest(case: Case, closed: Sequence[ContactPlace], start: float, y: Sequence[float]) -> float | None:
    """When the closed contacts cannot balance the load any more, s; None if they can until the motion's end."""
    from scipy.optimize import brentq

    sticks, units = [one.stick for one in closed], forces.units_of(case.plate.gyration)

    def margin(t: float) -> float:
        return forces.margin(closed, load_at(case, t, body_of(y)), units, sticks)

    load, end = case.effect(Load), case.duration
    looks = np.linspace(start, end, LOOKS)
    if load is not None and load.features is not None:
        looks = np.union1d(looks, load.features.nodes(start, end))
    last = start
    for look in looks[1:].tolist():
        if margin(look) < 0.0:
            return float(brentq(margin, last, look, xtol=1e-15, rtol=8.9e-16)) if margin(last) > 0.0 else last
        last = look
    return None
