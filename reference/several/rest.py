"""A plate at rest: its dense output, and the time until which its contacts hold it under a load."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import isinf
from typing import cast

import numpy as np

from cases import Case, Load

from ..minimal.integrators.segment import Segment
from ..minimal.series import EPS
from . import forces
from .decision import BALANCED, limits_of_couples, load_at, margin_on_belts
from .geometry import ContactPlace, places
from .regimes import SeveralPhase, body_of, contacts_of, pairs_of, regime_of

# Looks at a load in time while it may end a rest, besides those that resolve its features.
LOOKS = 64
# A root is located to roundings of its time, the finest that SciPy allows, whatever the unit of time.
SOONEST, FINEST = 1e-300, 4.0 * EPS
# Looks in each step of a motion; the steps resolve the features of belts and loads.
LOOKS_IN_STEP = 4


@dataclass(frozen=True)
class RestStates:
    """The dense output of a plate at rest."""

    state: tuple[float, ...]

    def __call__(self, times: np.ndarray) -> np.ndarray:
        return np.outer(self.state, np.ones_like(times))


def limit_of_rest(
    case: Case, closed: Sequence[ContactPlace], start: float, y: Sequence[float], turn: int | None = None
) -> float | None:
    """When the closed contacts cannot balance the load any more, s; None if they can until the motion's end. `turn`: as
    in `SeveralRegime`."""
    sticks, units = [one.stick for one in closed], forces.units_of(case.plate)
    couples = limits_of_couples(closed, turn)

    def margin(t: float) -> float:
        return forces.margin(closed, load_at(case, t, body_of(y)), units, sticks, couples)

    load, end = case.effect(Load), case.duration
    looks = np.linspace(start, end, LOOKS)
    if load is not None and load.features is not None:
        looks = np.union1d(looks, load.features.nodes(start, end))
    return _first_loss(margin, looks.tolist())


def limit_on_belts(segment: Segment) -> float | None:
    """When the forces of contacts with more than three rows reach their limit in a segment, s; None if they do not.
    Raises numpy.linalg.LinAlgError where the rows come to contradict each other."""
    phase = cast(SeveralPhase, segment.phase)

    def margin(t: float) -> float:
        state = segment.states(np.array([t]))[:, 0].tolist()
        every = places(contacts_of(phase.case, regime_of(phase)), body_of(state), pairs_of(state))
        value = margin_on_belts(phase, t, state, every)
        if isinf(value):
            raise np.linalg.LinAlgError("the plate sticks to belts whose motions differ")
        return value

    return first_loss_in(segment, margin)


def first_loss_in(segment: Segment, margin: Callable[[float], float]) -> float | None:
    """When a margin is lost in a segment, s; None if it is not at any look in its steps."""
    steps = np.unique(segment.times)
    parts = np.arange(1, LOOKS_IN_STEP + 1) / LOOKS_IN_STEP
    looks = (steps[:-1, None] + np.diff(steps)[:, None] * parts).ravel()
    return _first_loss(margin, [float(steps[0]), *looks.tolist()])


def _first_loss(margin: Callable[[float], float], looks: list[float]) -> float | None:
    """When a margin is lost, s, located to rounding; None if it is not at any of these times. One that touches zero is
    kept: it is known to its rounding only."""
    from scipy.optimize import brentq

    last = looks[0]
    for look in looks:
        value = margin(look)
        if value < BALANCED:
            return float(brentq(margin, last, look, xtol=SOONEST, rtol=FINEST)) if margin(last) > 0.0 else last
        last = look if value > 0.0 else last
    return None
