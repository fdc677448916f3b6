"""Where a moving plate meets its track: the time at which the gap of a pair of nearest points vanishes."""

from __future__ import annotations

from math import hypot, inf, pi
from typing import NamedTuple

import numpy as np

from cases import Case, DoesNotFit
from cases.contact import pose

from .contacts import AnyPair, PairState, pair_at
from .plate_motion import Motion

# Steps of Newton's method; its largest distance from the starting point, in plate's sizes; and its required final error
# in roundings of a position.
STEPS, FURTHEST, ENDS = 30, 0.25, 256.0
EPS = 2.0**-52
# A parameter beyond an end of a track by more than this is no rounding.
AT_END = 1e-9


class Touch(NamedTuple):
    """An instant at which the outline meets the track: time, (x, y, θ, vx, vy, ω), parameters, and the error of the
    time (s)."""

    time: float
    body: list[float]
    xi1: float
    xi2: float
    blur: float


def nearest(case: AnyPair, motion: Motion, time: float, near: tuple[float, float]) -> tuple[list[float], PairState]:
    """(x, y, θ, vx, vy, ω) at a time (s), and the pair of nearest points next to parameters. Raises DoesNotFit."""
    body = motion.bodies(np.array([time]))[:, 0].tolist()
    return body, pair_at(case, body, near)


def in_round(case: Case, theta: float, xi1: float, xi2: float) -> float:
    """The parameter ξ₂ of a contact in the round of the outline that belongs to the plate's angle (rad)."""
    return xi2 - round((theta - float(pose(case, xi1, xi2)[2])) / (2.0 * pi)) * (case.plate.outline.period or 0.0)


def meeting(case: AnyPair, size: float, motion: Motion, time: float, xi1: float, xi2: float) -> Touch | None:
    """Newton's method for the time at which the gap of nearest points vanishes, whose rate is their velocity of lift,
    and closes. None if it ends elsewhere, or beyond an end of the track."""
    best: Touch | None = None
    smallest, (x0, y0) = inf, motion.bodies(np.array([time]))[:2, 0].tolist()
    for _ in range(STEPS):
        if not (motion.edges[0] <= time <= motion.edges[-1]):
            return None
        try:
            body, pair = nearest(case, motion, time, (xi1, xi2))
        except DoesNotFit:
            break
        rounding, (xi1, xi2) = EPS * (size + abs(body[0]) + abs(body[1])), (pair.xi1, pair.xi2)
        if abs(pair.gap) < smallest:
            blur = 16.0 * rounding / max(abs(pair.lift), 1e-300) + 4.0 * float(np.spacing(time))
            best, smallest = Touch(time, body, xi1, xi2, blur) if pair.lift < 0.0 else None, abs(pair.gap)
        elif smallest <= ENDS * rounding:
            break  # no better than before: rounding
        if not pair.lift or not hypot(body[0] - x0, body[1] - y0) <= FURTHEST * size:
            break
        time -= pair.gap / pair.lift
    ends = case.track.ends
    if best is not None and ends and not ends[0] - AT_END <= best.xi1 <= ends[1] + AT_END:
        return None
    return best if smallest <= ENDS * EPS * (size + abs(x0) + abs(y0)) else None
