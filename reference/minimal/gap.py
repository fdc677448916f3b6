"""The gap between a plate and its track at one pair of points, followed over time, and hops: flights that end before
the plate has moved noticeably.

At the start of a flight the gap is the small difference of two places, and its rate is much more precise. So the first
look is so early that the curves are polynomials until then: there the gap grows, or its rate falls linearly or as a
polynomial, and its integral vanishes where the plate lands.
"""

from __future__ import annotations

from functools import lru_cache
from math import cos, floor, hypot, inf, isnan, nan, pi, sin
from typing import NamedTuple

import numpy as np
from numpy.polynomial import Chebyshev

from cases import Case, Curve, DoesNotFit
from cases.contact import Contact, find
from cases.curves.curve_pieces import TooMuch

from .impact import ContactVelocity
from .integrators.segment import Segment

# Limit on gap evaluations (looks) in one motion: about twenty seconds.
MOST_LOOKS = 300_000
# Until the first look the plate moves by this part of its size, at most, and the pair by this part of a piece in which
# the curves are polynomials of some degree (`cases.formulas.features`).
CLOSE, PIECE = 1 / 16, 1 / 4
# The first look of a flight from the track is one step after its start, then a quarter of it and so on, until the gap
# grows. Below this part of the step positions do not resolve the gap: there is no flight.
SOONEST = 1e-9
# A gap's rate falls linearly, or as a polynomial, if the difference is a few roundings of the plate's speeds.
EVEN = 1e-14
# Range of the polynomial through the rate: slightly beyond the landing of a linear fall.
HOP = 1.0625
# Number of corrections of the landing time with the rate there: a varying acceleration changes the first estimate.
REFINEMENTS = 5
_LOOKS = 0.5 - 0.5 * np.cos(np.pi * np.arange(9) / 8)


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


def first_look(looks: Looks, segment: Segment, start: Look) -> Look | None:
    """A look soon after the start at which the gap is positive and grows, or a hop's landing (whose `beyond` is not
    NaN); None if the gap closes."""
    part = _time_for(segment, start, looks.case.plate.reach)
    soonest = SOONEST * part
    while part > soonest:
        look = looks.at(segment, start.time + part, start.pair)
        if look is None or not _is_resolved(looks.case, start, look):
            part *= 0.25
            continue
        if start.rate > 0.0 > look.rate:
            hop = _hop(looks, segment, start, look)
            if hop is not None:
                return hop
        if look.rate > 0.0 and look.gap > 0.0:
            return look
        # Half the time in which the rate falls to zero at its present slope (it may start at the size of a rounding).
        falls = start.rate > 0.0 > look.rate
        part *= min(max(0.5 * start.rate / (start.rate - look.rate), 1e-3), 0.5) if falls else 0.25
    return None


def _hop(looks: Looks, segment: Segment, start: Look, ahead: Look) -> Look | None:
    """The landing of a flight that begins at `start` on the track, if it is a hop that ends before `ahead`; else None.

    A rate that falls linearly vanishes half-way; otherwise the landing is the zero of the integral of a polynomial
    through a few looks, if that is as accurate as the rates themselves.
    """
    most, lasts, whole = ahead.time - start.time, inf, ahead
    for _ in range(REFINEMENTS):
        if not whole.rate < start.rate:
            return None
        before, lasts = lasts, 2.0 * start.rate * (whole.time - start.time) / (start.rate - whole.rate)
        if not lasts <= most:
            return None
        if abs(lasts - before) <= 0.5 * (HOP - 1.0) * lasts:
            break
        look = looks.at(segment, start.time + lasts, start.pair)
        if look is None:
            return None
        whole = look
    half = looks.at(segment, start.time + 0.5 * lasts, start.pair)
    if half is None:
        return None
    # Times are rounded, their differences are not.
    fall = (start.rate - whole.rate) / (whole.time - start.time)
    if abs(start.rate - fall * (half.time - start.time) - half.rate) <= EVEN * start.speed:
        lasts = 2.0 * start.rate / fall
    else:
        lasts = _uneven(looks, segment, start, lasts)
    landing = None if isnan(lasts) else looks.at(segment, start.time + lasts, start.pair)
    if landing is None or not landing.rate < 0.0:
        return None
    return landing._replace(beyond=lasts - (landing.time - start.time))


def _uneven(looks: Looks, segment: Segment, start: Look, lasts: float) -> float:
    """Duration of a hop whose rate does not fall linearly, about `lasts`; NaN if no polynomial fits."""
    samples = [start]
    for x in _LOOKS[1:]:
        look = looks.at(segment, start.time + x * HOP * lasts, start.pair)
        if look is None:
            return nan
        samples.append(look)
    parts = [(look.time - start.time) / (HOP * lasts) for look in samples]
    rate = Chebyshev.fit(parts, [look.rate for look in samples], len(samples) - 1, domain=(0.0, 1.0))
    if not np.max(np.abs(rate.coef[-2:])) <= 10.0 * EVEN * start.speed:
        return nan
    gap, x = rate.integ(lbnd=0.0), 1.0 / HOP
    for _ in range(5):  # Newton's method, from the landing of a linear fall, a few per cent away
        x -= float(gap(x) / rate(x))
    return x * HOP * lasts if 0.0 < x <= 1.0 else nan


def _time_for(segment: Segment, look: Look, size: float) -> float:
    """The time in which the plate's points move by a small part of its size, from the speeds before and after."""
    step = min(CLOSE * size / max(look.speed, 1e-300), float(segment.times[-1]) - look.time)
    while step * _speed(state(segment, look.time + step), size) > 2.0 * CLOSE * size:
        step *= 0.5  # a released plate has no speed at first
    return step


def _speed(now: list[float], size: float) -> float:
    """A bound on the speed of the points of a plate of that size, m/s."""
    _, _, _, vx, vy, omega = now
    return hypot(vx, vy) + abs(omega) * size


def _is_resolved(case: Case, start: Look, look: Look) -> bool:
    """Whether the pair moves between two looks by less than a part of a range in which the curves are polynomials."""
    curves = (case.track, case.plate.outline)
    return all(
        curve.features is None or abs(after - before) <= PIECE * curve.features.piece_length(before)
        for curve, before, after in zip(curves, start.pair, look.pair, strict=True)
    )
