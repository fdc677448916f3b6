"""Touches of a plate with an end of an open curve: where its distance from that point vanishes.

Between two looks no point of the plate moves farther than the distance from the end, or than a thousandth of the
plate's size: a deeper entry than a ten-millionth of it is seen.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import cos, hypot, sin

import numpy as np
from scipy.optimize import brentq

from cases import Curve
from cases.contact.close_pairs import nearest_on
from cases.contact.overlap_search import depth_inside
from cases.scene.couples import CurveEnd, couples

from .plate_motion import Limits, Motion, limits

# The shortest way between two looks, in parts of the plate's reach.
SHORTEST = 1e-3
# An end is inside the plate, or apart from it, by more than this part of its reach: the error of contacts that stay
# closed.
DEPTH = 1e-11
# Contacts nearer than this part of the reach, or with directions that differ by less (rad), are one.
SAME = 1e-8

# The contacts of curves at a time: each curve with its parameter there.
Places = Callable[[float], Sequence[tuple[Curve, float]]]


class EndTouches:
    """The search for touches of one plate with one end of a curve."""

    def __init__(self, end: CurveEnd):
        self.curve, self.outline = couples(end.whole)[end.number].track, end.plate.outline
        self.reach, self.x, self.y = end.plate.reach, end.corner.x, end.corner.y

    def first(self, motion: Motion, times: tuple[float, float], bounds: Limits) -> float | None:
        """The first time in a step at which the plate comes to lie on the end; None if it does not. `bounds`: on its
        velocities."""
        (before, end), least, fastest = times, DEPTH * self.reach, bounds.speed + bounds.spin * self.reach

        def gap(t: float) -> float:
            return self.gap(motion.bodies(np.array([t]))[:3, 0])

        away = gap(before)
        while before < end:
            way = max(away, SHORTEST * self.reach)
            after = end if fastest * (end - before) <= way else before + way / fastest
            now = gap(after)
            if now < -least <= away:
                return float(brentq(gap, before, after, xtol=1e-15, rtol=8.9e-16)) if away > least else before
            before, away = after, now
        return None

    def gap(self, body: np.ndarray) -> float:
        """The distance of the end from the plate in a pose, m, negative inside."""
        return -depth_inside(self.outline, *self._own(body))

    def gap_in(self, plates: Callable[[np.ndarray], np.ndarray]) -> Callable[[float, np.ndarray], float]:
        """The same of states at times, of which `plates` takes poses and velocities."""
        return lambda t, y: self.gap(plates(y))

    def is_of(self, some: Sequence[tuple[Curve, float]], body: np.ndarray) -> bool:
        """Whether one of some contacts, each given by its curve and the parameter there, is at the end, which the plate
        touches in a pose, or has the same direction: a side lies flat on both."""
        direction = float(self.outline.tangent_angle(nearest_on(self.outline, *self._own(body)))) + body[2]
        for curve, xi1 in some:
            if curve == self.curve:
                (x, y), (tx, ty) = curve.point(xi1), curve.tangent(xi1)
                away, turn = hypot(x - self.x, y - self.y), hypot(tx - cos(direction), ty - sin(direction))
                if min(turn, away / self.reach) <= SAME:
                    return True
        return False

    def _own(self, body: np.ndarray) -> tuple[float, float]:
        """The end in the plate's frame."""
        u, v, c, s = self.x - body[0], self.y - body[1], cos(body[2]), sin(body[2])
        return float(c * u + s * v), float(c * v - s * u)


def first_end(
    ends: Sequence[EndTouches], motion: Motion, times: tuple[float, float], places: Places
) -> tuple[float, EndTouches] | None:
    """The first touch of an end in a step, and that end, at which no contact of its curve is; None without one.
    `places`: the contacts at a time, as in `EndTouches.is_of`."""
    bounds = limits(motion, *times)
    every = [(time, k) for k, end in enumerate(ends) if (time := end.first(motion, times, bounds)) is not None]
    for time, k in sorted(every):
        if not ends[k].is_of(places(time), motion.bodies(np.array([time]))[:3, 0]):
            return time, ends[k]
    return None
