"""When forces of contacts reach their limit: of plates at rest under a load, and of forces that are not unique."""

from __future__ import annotations

from collections.abc import Callable
from math import inf

import numpy as np

from cases import Case
from cases.scene.free_plates import loads_of

from ..minimal.integrators.segment import Segment
from ..scales import EPS

# A load is balanced if the least weight is no more negative than its rounding.
BALANCE = -1e-11
# Looks at a load in time while it may end a rest, besides those that resolve its features.
LOOKS = 64
# A root is located to roundings of its time, the finest that SciPy allows.
FINEST = 4.0 * EPS
# A balance that is lost within this part of the time between two looks is lost at once.
AT_ONCE = 1e-6
# Looks in each step of a motion; the steps resolve the features of belts and loads.
LOOKS_IN_STEP = 4


def looks_at_load(case: Case, start: float) -> list[float]:
    """Times (s) from a start to the end of a case's motion that resolve its loads."""
    end, looks = case.duration, np.linspace(start, case.duration, LOOKS)
    for load in loads_of(case):
        if load is not None and load.features is not None:
            looks = np.union1d(looks, load.features.nodes(start, end))
    return looks.tolist()


def first_loss_in(segment: Segment, margin: Callable[[float], float]) -> float | None:
    """When a margin is lost in a segment, s; None if it is not at any look in its steps."""
    steps = np.unique(segment.times)
    parts = np.arange(1, LOOKS_IN_STEP + 1) / LOOKS_IN_STEP
    looks = (steps[:-1, None] + np.diff(steps)[:, None] * parts).ravel()
    return first_loss(margin, [float(steps[0]), *looks.tolist()])


def first_loss(margin: Callable[[float], float], looks: list[float]) -> float | None:
    """When a margin is lost, s, located to rounding; None if it is not at any of these times. One that touches zero is
    kept: it is known to its rounding only."""
    from scipy.optimize import brentq

    last = looks[0]
    for look in looks:
        value = margin(look)
        if value < BALANCE:
            # Without friction a load is balanced at single instants: no weights of any sign have its direction then. A
            # margin that is a rounding and shrinks is lost at once, too.
            now, soon = margin(last), margin(last + AT_ONCE * (look - last))
            if soon == -inf or not now > 0.0 or soon < now <= -BALANCE:
                return last
            return float(brentq(lambda t: max(margin(t), -1.0), last, look, xtol=EPS * (look - last), rtol=FINEST))
        last = look if value > 0.0 else last
    return None
