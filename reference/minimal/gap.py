"""The gap between a plate and its track at one pair of points, followed over time."""

from __future__ import annotations

from functools import lru_cache
from math import cos, floor, hypot, nan, pi, sin
from typing import NamedTuple

import numpy as np

from cases import Case, Curve, DoesNotFit
from cases.contact import Contact, find

from .curve_pieces import TooMuch
from .impact import ContactVelocity
from .integrators.segment import Segment

# Limit on gap evaluations (looks) in one motion: about twenty seconds.
MOST_LOOKS = 300_000


class Look(NamedTuple):
    """A pair of points at a time (s): the contact, the gap's rate, the speed of the centre of mass and a bound on that
    of the plate's points (m/s), whether the tangents point the same way, and, for a landing, its exact time minus the
    rounded time (s)."""

    time: float
    contact: Contact
    rate: float
    centre: float
    speed: float
    facing: bool
    beyond: float = nan

    @property
    def gap(self) -> float:
        return self.contact.gap

    @property
    def pair(self) -> tuple[float, float]:
        """The pair's parameters."""
        return self.contact.xi1, self.contact.xi2


class Looks:
    """Evaluates pairs of points in the flights of a motion, and counts the evaluations."""

    def __init__(self, case: Case) -> None:
        self.case, self.count = case, 0

    def at(self, segment: Segment, t: float, near: tuple[float, float], far_turn: bool = False) -> Look | None:
        """The pair next to `near` at the time t, s; None if there is none. Raises TooMuch at the limit on looks.

        `far_turn`: the plate may have turned far since `near`; its outline is convex.
        """
        if self.count >= MOST_LOOKS:
            raise TooMuch
        self.count += 1
        now = state(segment, t)
        if far_turn:
            near = near[0], facing(self.case, near[0], now[2])
        try:
            contact = find(self.case, now[0], now[1], now[2], near)
        except DoesNotFit:
            return None
        at, _, _ = touch(self.case, now, contact)
        centre = hypot(now[3], now[4])
        points = centre + abs(now[5]) * self.case.plate.reach
        return Look(t, contact, at.lift, centre, points, _same_way(self.case, contact, now[2]))


def _same_way(case: Case, contact: Contact, theta: float) -> bool:
    """Whether the tangents of a pair point in the same direction, not in opposite ones."""
    _, _, tx, ty, *_ = case.track.jet(contact.xi1)
    _, _, u, v, *_ = case.plate.outline.jet(contact.xi2)
    c, s = cos(theta), sin(theta)
    return tx * (c * u - s * v) + ty * (s * u + c * v) > 0.0


def facing(case: Case, xi1: float, theta: float) -> float:
    """Roughly the parameter of a convex outline whose tangent is parallel to the track's at `xi1`."""
    parameters, angles = _angles(case.plate.outline)
    angle = float(case.track.tangent_angle(xi1)) - theta
    if case.plate.outline.period:
        angle -= 2.0 * pi * floor((angle - angles[0]) / (2.0 * pi))
    return float(np.interp(angle, angles, parameters))


@lru_cache(maxsize=64)
def _angles(outline: Curve) -> tuple[np.ndarray, np.ndarray]:
    """Parameters of a convex outline and its tangent's angles there, which rise."""
    parameters = np.linspace(*outline.span, 721)
    return parameters, np.asarray(outline.tangent_angle(parameters))


def state(segment: Segment, t: float) -> list[float]:
    """(x, y, θ, vx, vy, ω)."""
    return segment.states(np.array([t]))[:, 0].tolist()


def touch(case: Case, now: list[float], contact: Contact) -> tuple[ContactVelocity, float, float]:
    """Velocity of the plate's point of a pair along tangent and normal of the track's, the spin, and the arm."""
    x, y, _, vx, vy, omega = now
    X, Y, Xp, Yp = case.track.jet(contact.xi1)[:4]
    along = hypot(Xp, Yp)
    tx, ty = Xp / along, Yp / along
    # The outline's point lies off the track's by the gap along the normal.
    rx, ry = X - contact.gap * ty - x, Y + contact.gap * tx - y
    px, py = vx - omega * ry, vy + omega * rx
    return ContactVelocity(px * tx + py * ty, py * tx - px * ty, omega), rx * tx + ry * ty, ry * tx - rx * ty
