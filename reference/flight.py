"""Where a flight ends: the first instant at which the outline meets the track again, wherever that is.

The flight itself is integrated like any phase, without asking where the track is; then its gap is followed from look
to look. Looks are so close that the plate moves by a small part of its size, or of its gap where that is larger, and a
gap that turns around between two of them is looked at where it turns.
"""

from __future__ import annotations

from math import hypot
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from cases import Case
from cases.contact import Contact, pose
from cases.nearest import nearest

from .arc import Arc
from .impact import Touch

# Between two looks the plate moves by this part of its size, at most, while it is near its track.
CLOSE = 1 / 16
# Where a flight begins on the track, a first look one step later, or a quarter of it and so on, finds the gap growing.
# Sooner than this part of the step, positions do not resolve it: there is no flight.
SOONEST = 1e-9


class Landing(NamedTuple):
    """When (s) and where the outline meets the track, θ there, how the contact closes, and the arm to it (m)."""

    time: float
    xi1: float
    xi2: float
    theta: float
    touch: Touch
    arm_t: float
    arm_n: float


class _Look(NamedTuple):
    time: float
    contact: Contact | None
    rate: float  # of the gap, m/s

    @property
    def gap(self) -> float:
        return self.contact.gap if self.contact else np.inf


def first_landing(case: Case, arc: Arc, end: float, near: float) -> Landing | None:
    """The first landing of a flight's arc before `end`; None if it flies on.

    The parameters on closed curves are counted on from `near`, where the track was touched last.
    """
    size = _reach(case)
    start = float(arc.times[0])
    before = _look(case, arc, start)
    leaves = before.gap <= 1e-12 * size  # on the track, to the rounding of positions
    if before.contact and leaves:
        first = _first_look(case, arc, start, end, size)
        if first is None:
            return _landing(case, arc, start, before.contact, near)
        before = first
    while before.time < end:
        step = _time_for(arc, before.time, max(CLOSE * size, 0.5 * min(before.gap, 1e6 * size)), size)
        if leaves:
            step = min(step, before.time - start)  # what has just begun may end as soon
        now = _look(case, arc, min(before.time + step, end))
        turned = _turning(case, arc, before, now) if before.rate < 0.0 < now.rate and now.gap > 0.0 else None
        for look in (turned, now):
            if look is not None and look.gap <= 0.0:
                return _locate(case, arc, before, look, near)
        before = now
    return None


def _first_look(case: Case, arc: Arc, start: float, end: float, size: float) -> _Look | None:
    """A look soon after the start at which the gap is positive and grows; None if it closes from the start."""
    lift = _look(case, arc, start).rate
    part = min(_time_for(arc, start, CLOSE * size, size), end - start)
    soonest = SOONEST * part
    while part > soonest:
        look = _look(case, arc, start + part)
        if look.rate > 0.0 and look.gap > 0.0:
            return look
        # Half the time in which the rate falls to zero, as it has fallen until now (it may begin at a mere rounding).
        part *= min(max(0.5 * lift / (lift - look.rate), 1e-3), 0.5) if lift > 0.0 > look.rate else 0.25
    return None


def _reach(case: Case) -> float:
    """The farthest point of the outline from the centre of mass, m."""
    return float(np.hypot(*case.plate.outline.point(np.linspace(*case.plate.outline.look, 65))).max())


def _time_for(arc: Arc, t: float, way: float, size: float) -> float:
    """How long the plate's points take for about that way (m), from the speeds before and after."""
    left = float(arc.times[-1]) - t
    step = min(way / max(_speed(arc, t, size), 1e-300), left)
    while step * _speed(arc, t + step, size) > 2.0 * way:
        step *= 0.5  # a plate that is let go has no speed yet, and gains it
    return step


def _speed(arc: Arc, t: float, size: float) -> float:
    """A bound on the speed of the plate's points at that time, m/s."""
    _, _, _, vx, vy, omega = _state(arc, t)
    return hypot(vx, vy) + abs(omega) * size


def _state(arc: Arc, t: float) -> list[float]:
    """(x, y, θ, vx, vy, ω)."""
    return arc.states(np.array([t]))[:, 0].tolist()


def _look(case: Case, arc: Arc, t: float) -> _Look:
    state = _state(arc, t)
    contact = nearest(case, *state[:3])
    return _Look(t, contact, _touch(case, state, contact)[0].lift if contact else 0.0)


def _touch(case: Case, state: list[float], contact: Contact) -> tuple[Touch, float, float]:
    """Velocity of the plate's nearest point along tangent and normal of the track's, the spin, and the arm."""
    x, y, _, vx, vy, omega = state
    (tx, ty), (X, Y) = case.track.tangent(contact.xi1), case.track.point(contact.xi1)
    # The outline's point lies off the track's by the gap along the normal.
    rx, ry = X - contact.gap * ty - x, Y + contact.gap * tx - y
    px, py = vx - omega * ry, vy + omega * rx
    touch = Touch(float(px * tx + py * ty), float(py * tx - px * ty), omega)
    return touch, float(rx * tx + ry * ty), float(ry * tx - rx * ty)


def _turning(case: Case, arc: Arc, before: _Look, now: _Look) -> _Look:
    """The look at which the gap stops closing between two looks."""
    return _look(case, arc, brentq(lambda t: _look(case, arc, t).rate, before.time, now.time, xtol=1e-15, rtol=8.9e-16))


def _locate(case: Case, arc: Arc, before: _Look, now: _Look, near: float) -> Landing:
    """The zero of the gap between a look above and one below the track."""
    size = _reach(case)

    def gap(t: float) -> float:
        # Of the pair that is the nearest at that time: one followed from elsewhere may lead to another.
        return min(_look(case, arc, t).gap, size)

    if not gap(now.time) < 0.0 < gap(before.time):
        assert now.contact is not None  # its gap is a number
        return _landing(case, arc, now.time, now.contact, near)
    time = brentq(gap, before.time, now.time, xtol=1e-16, rtol=8.9e-16)
    landed = _look(case, arc, time).contact
    assert landed is not None
    return _landing(case, arc, time, landed, near)


def _landing(case: Case, arc: Arc, t: float, contact: Contact, near: float) -> Landing:
    state = _state(arc, t)
    touch, arm_t, arm_n = _touch(case, state, contact)
    return Landing(t, *_counted_on(case, contact, state[2], near), state[2], touch, arm_t, arm_n)


def _counted_on(case: Case, contact: Contact, theta: float, near: float) -> tuple[float, float]:
    """The contact's parameters with the whole turns that bring the track's next to `near` and give θ itself by (6)."""
    period, again = case.track.period or 0.0, case.plate.outline.period or 0.0
    xi1 = contact.xi1 + period * round((near - contact.xi1) / period) if period and again else contact.xi1
    turns = round((float(pose(case, xi1, contact.xi2)[2]) - theta) / (2 * np.pi))
    return (xi1, contact.xi2 + turns * again) if again else (xi1 - turns * period, contact.xi2)
