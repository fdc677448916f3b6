"""Where a flight ends: the first instant at which the outline meets the track again, wherever that is.

The flight itself is integrated like any phase, without asking where the track is; then its gap is followed from look
to look. Looks are so close that the plate moves by a small part of its size, or of its gap where that is larger, and a
gap that turns around between two of them is looked at where it turns.

A flight that is over before the plate has moved by such a part, and whose gap's rate falls evenly, is a hop: there the
rate is known much better than the gap, which is the small difference of two places, and its integral vanishes where the
plate lands.
"""

from __future__ import annotations

from functools import lru_cache
from math import hypot, inf, isnan, nan
from typing import NamedTuple

import numpy as np
from numpy.polynomial import Chebyshev

from cases import Case, Curve
from cases.contact import Contact, pose
from cases.nearest import nearest

from .impact import Touch
from .integrators.segment import Segment
from .series import EPS

# Between two looks the plate moves by this part of its size, at most, while it is near its track.
CLOSE = 1 / 16
# Where a flight begins on the track, a first look one step later, or a quarter of it and so on, finds the gap growing.
# Sooner than this part of the step, positions do not resolve it: there is no flight.
SOONEST = 1e-9
# What looks for a landing may take in a motion, all told, in those of a disc: some twenty seconds.
MOST_LOOKS = 300_000
# A gap's rate falls evenly, or as a polynomial says, where they differ by a few roundings of the plate's speeds.
EVEN = 1e-14
# Where a polynomial through the rate is to be known: up to a little beyond where an even fall would land.
HOP = 1.0625
# How often that is looked for anew with the rate there: a pull that grows makes it longer than the first look says.
REFINED = 5
_LOOKS = 0.5 - 0.5 * np.cos(np.pi * np.arange(9) / 8)


class Landing(NamedTuple):
    """When (s) and where the outline meets the track, θ there, how the contact closes, and the arm to it (m)."""

    time: float
    xi1: float
    xi2: float
    theta: float
    touch: Touch
    arm_t: float
    arm_n: float


class TooMany(Exception):
    """A flight is followed no further: near its track the plate is too fast, or spins too fast."""


class Looks:
    """Looks at a motion's flights, the work that they took, and until when (s) the last flight has not landed."""

    def __init__(self, case: Case) -> None:
        self.case, self.done, self.flies_until = case, 0, nan
        # Of a disc one point is looked up (70 µs), of others all the outline (half a millisecond).
        self.each = 1 if case.plate.radius is not None else 8

    def at(self, segment: Segment, t: float) -> _Look:
        """A look at the time t, s. Raises TooMany once their work is used up."""
        if self.done >= MOST_LOOKS:
            raise TooMany
        self.done += self.each
        return _look(self.case, segment, t)


class _Look(NamedTuple):
    time: float
    contact: Contact | None
    rate: float  # of the gap, m/s
    speed: float  # of the plate's points, at most, m/s
    far: float  # half-way back to where tracks are drawn, m: off the ends of one there is no gap
    beyond: float = nan  # of a landing: how much later it is than the rounded time, s

    @property
    def gap(self) -> float:
        return self.contact.gap if self.contact else np.inf


def start_impact(case: Case, segment: Segment) -> Landing:
    """The impact that a start with a gap that closes is, also where the plate is pulled off its track; its velocities
    are the start's own, without rounding."""
    start, first = case.start, _look(case, segment, 0.0)
    landing = _landing(case, segment, first, start.xi1)
    return landing._replace(touch=Touch(start.slip, start.gap_rate, start.omega))


def first_landing(looks: Looks, segment: Segment, near: float, under_way: bool = False) -> Landing | None:
    """The first landing of a flight's segment; None if it flies on. Raises TooMany once the `looks` are used up.

    The parameters on closed curves are counted on from `near`, where the track was touched last. `under_way`: it
    goes on with a flight that did not land until then.
    """
    size = _reach(looks.case.plate.outline)
    start, end = float(segment.times[0]), float(segment.times[-1])
    looks.flies_until = start
    before = looks.at(segment, start)
    if under_way and before.contact and before.gap <= 0.0:
        return _landing(looks.case, segment, before, near)  # by a rounding
    leaves = not under_way and before.gap <= 1e-12 * size  # on the track, to the rounding of positions
    if before.contact and leaves:
        first = _first_look(looks, segment, before, size)
        if first is None:
            return _landing(looks.case, segment, before, near)
        if not isnan(first.beyond):
            return _landing(looks.case, segment, first, near)
        before = first
    while before.time < end:
        looks.flies_until = before.time
        step = _time_for(segment, before, min(before.gap, max(1e6 * size, before.far)), size)
        if leaves:
            step = min(step, before.time - start)  # what has just begun may end as soon
        now = looks.at(segment, min(before.time + step, end))
        turned = _turning(looks, segment, before, now) if before.rate < 0.0 < now.rate and now.gap > 0.0 else None
        for look in (turned, now):
            if look is not None and look.gap <= 0.0:
                return _locate(looks, segment, before, look, near)
        before = now
    return None


def _first_look(looks: Looks, segment: Segment, start: _Look, size: float) -> _Look | None:
    """A look soon after the start at which the gap is positive and grows, or a hop's landing; None if it closes."""
    part = _time_for(segment, start, 0.0, size)
    soonest = SOONEST * part
    while part > soonest:
        look = looks.at(segment, start.time + part)
        if start.rate > 0.0 > look.rate:
            hop = _hop(looks, segment, start, look)
            if hop is not None:
                return hop
        if look.rate > 0.0 and look.gap > 0.0:
            return look
        # Half the time in which the rate falls to zero, as it has fallen until now (it may begin at a mere rounding).
        falls = start.rate > 0.0 > look.rate
        part *= min(max(0.5 * start.rate / (start.rate - look.rate), 1e-3), 0.5) if falls else 0.25
    return None


def _hop(looks: Looks, segment: Segment, start: _Look, ahead: _Look) -> _Look | None:
    """The landing of a flight that begins at `start` on the track, if it is a hop over before `ahead`.

    A rate that falls evenly vanishes half-way; where a polynomial through a few looks is as good as the rates
    themselves, its integral's zero is the landing.
    """
    most, lasts, whole = ahead.time - start.time, inf, ahead
    for _ in range(REFINED):
        if not whole.rate < start.rate:
            return None
        before, lasts = lasts, 2.0 * start.rate * (whole.time - start.time) / (start.rate - whole.rate)
        if not lasts <= most:
            return None
        if abs(lasts - before) <= 0.5 * (HOP - 1.0) * lasts:
            break
        whole = looks.at(segment, start.time + lasts)
    half = looks.at(segment, start.time + 0.5 * lasts)
    # Times are rounded, what is between them is not.
    fall = (start.rate - whole.rate) / (whole.time - start.time)
    if abs(start.rate - fall * (half.time - start.time) - half.rate) <= EVEN * start.speed:
        lasts = 2.0 * start.rate / fall
    else:
        lasts = _uneven(looks, segment, start, lasts)
    if isnan(lasts):
        return None
    landing = looks.at(segment, start.time + lasts)
    beyond = lasts - (landing.time - start.time)
    return landing._replace(beyond=beyond) if landing.contact is not None and landing.rate < 0.0 else None


def _uneven(looks: Looks, segment: Segment, start: _Look, lasts: float) -> float:
    """How long a hop lasts whose rate falls unevenly, about `lasts`; NaN where a polynomial does not tell."""
    seen = [start, *(looks.at(segment, start.time + x * HOP * lasts) for x in _LOOKS[1:])]
    parts = [(look.time - start.time) / (HOP * lasts) for look in seen]
    rate = Chebyshev.fit(parts, [look.rate for look in seen], len(seen) - 1, domain=(0.0, 1.0))
    if not np.max(np.abs(rate.coef[-2:])) <= 10.0 * EVEN * start.speed:
        return nan
    gap, x = rate.integ(lbnd=0.0), 1.0 / HOP
    for _ in range(5):  # Newton's method, from the landing of an even fall, a few parts in a hundred away
        x -= float(gap(x) / rate(x))
    return x * HOP * lasts if 0.0 < x <= 1.0 else nan


@lru_cache(maxsize=256)
def _reach(outline: Curve) -> float:
    """The farthest point of the outline from the centre of mass, m."""
    return float(np.hypot(*outline.point(np.linspace(*outline.span, 65))).max())


def _time_for(segment: Segment, look: _Look, gap: float, size: float) -> float:
    """How long the plate's points take for the gap, or a small part of its size, from the speeds before and after."""
    left = float(segment.times[-1]) - look.time
    step = min(max(gap, CLOSE * size) / max(look.speed, 1e-300), left)
    while step * _speed(_state(segment, look.time + step), size) > max(gap, 2.0 * CLOSE * size):
        step *= 0.5  # a plate that is let go has no speed yet, and gains it
    return step


def _speed(state: list[float], size: float) -> float:
    """A bound on the speed of the plate's points, m/s."""
    _, _, _, vx, vy, omega = state
    return hypot(vx, vy) + abs(omega) * size


def _state(segment: Segment, t: float) -> list[float]:
    """(x, y, θ, vx, vy, ω)."""
    return segment.states(np.array([t]))[:, 0].tolist()


def _look(case: Case, segment: Segment, t: float) -> _Look:
    state = _state(segment, t)
    contact = nearest(case, *state[:3])
    rate = _touch(case, state, contact)[0].lift if contact else 0.0
    return _Look(t, contact, rate, _speed(state, _reach(case.plate.outline)), 0.5 * hypot(*state[:2]))


def _touch(case: Case, state: list[float], contact: Contact) -> tuple[Touch, float, float]:
    """Velocity of the plate's nearest point along tangent and normal of the track's, the spin, and the arm."""
    x, y, _, vx, vy, omega = state
    X, Y, Xp, Yp = case.track.jet(contact.xi1)[:4]
    speed = hypot(Xp, Yp)
    tx, ty = Xp / speed, Yp / speed
    # The outline's point lies off the track's by the gap along the normal.
    rx, ry = X - contact.gap * ty - x, Y + contact.gap * tx - y
    px, py = vx - omega * ry, vy + omega * rx
    return Touch(px * tx + py * ty, py * tx - px * ty, omega), rx * tx + ry * ty, ry * tx - rx * ty


def _turning(looks: Looks, segment: Segment, before: _Look, now: _Look) -> _Look:
    """The look at which the gap stops closing between two looks."""
    from scipy.optimize import brentq  # slow to import, and most motions never fly

    return looks.at(
        segment, brentq(lambda t: looks.at(segment, t).rate, before.time, now.time, xtol=1e-15, rtol=8.9e-16)
    )


def _locate(looks: Looks, segment: Segment, above: _Look, below: _Look, near: float) -> Landing:
    """The zero of the gap between a look above and one below the track: Newton's method, kept between the two.

    Each look is at the pair that is the nearest at that time: one followed from elsewhere may lead to another.
    """
    x, y, *_ = _state(segment, below.time)
    rounding = 0.5 * EPS * (_reach(looks.case.plate.outline) + abs(x) + abs(y))
    now, low, high = below, above.time, below.time
    while abs(now.gap) > rounding and above.gap > 0.0:
        time = now.time - now.gap / now.rate if now.rate < 0.0 else low
        if abs(time - now.time) <= np.spacing(high) or high - low <= 2.0 * np.spacing(high):
            break
        now = looks.at(segment, time if low < time < high else 0.5 * (low + high))
        low, high = (now.time, high) if now.gap > 0.0 else (low, now.time)
    now = now if now.contact else below
    near_enough = now.rate < 0.0 and abs(now.gap) <= -4.0 * now.rate * np.spacing(high)
    return _landing(looks.case, segment, now._replace(beyond=-now.gap / now.rate if near_enough else nan), near)


def _landing(case: Case, segment: Segment, look: _Look, near: float) -> Landing:
    """The landing at a look, whose time is rounded: what is left of it moves the state on.

    Rounded times alone would change the energy of a plate that bounces for long.
    """
    t, contact, state = look.time, look.contact, _state(segment, look.time)
    assert contact is not None  # it has a gap
    if not isnan(look.beyond):
        rates = segment.phase.system.rates_of_numbers(t, state, segment.phase.parameters)
        state = [value + look.beyond * rate for value, rate in zip(state, rates, strict=True)]
    touch, arm_t, arm_n = _touch(case, state, contact)
    return Landing(t, *_counted_on(case, contact, state[2], near), state[2], touch, arm_t, arm_n)


def _counted_on(case: Case, contact: Contact, theta: float, near: float) -> tuple[float, float]:
    """The contact's parameters with the whole turns that bring the track's next to `near` and give θ itself by (6)."""
    period, again = case.track.period or 0.0, case.plate.outline.period or 0.0
    xi1 = contact.xi1 + period * round((near - contact.xi1) / period) if period and again else contact.xi1
    turns = round((float(pose(case, xi1, contact.xi2)[2]) - theta) / (2 * np.pi))
    return (xi1, contact.xi2 + turns * again) if again else (xi1 - turns * period, contact.xi2)
