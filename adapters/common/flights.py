"""Plates that leave their track and meet it again: their nearest points to it, and the samples in flight."""

from __future__ import annotations

from math import hypot, inf, nan, pi

import numpy as np

from cases import Case, Flight, Impact
from cases.contact import Contact, finder, start_motion
from cases.contact.nearest import nearest

LIFT_OFF_REASON = "The contact stopped pushing and the plate left its track."
LANDING_REASON = "The plate meets its track again, and the case names no Impact."
# Exceptions of a curve where its expression has no value, beyond its domain (DoesNotFit is one of them).
BEYOND = (ValueError, ArithmeticError)
# A plate that is farther from its track than this part of its size may be nearer to another place of the track.
NEAR = 0.1
# A plate that is certainly this many of its sizes off the track needs no search.
FAR = 1.0
# A turn (rad) between two poses from which on the outline's last point may lead to another one: from a quarter of a
# turn on, to that opposite.
LARGE_TURN = 1.0


class Follower:
    """Finds the contact along a motion that begins at the case's start, each from the previous one.

    For a plate that may fly the whole track is searched once it is well off it. While it cannot have come back there is
    no search: the parameters are NaN, and the gap is a lower bound. `near`: the largest gap, in sizes of the plate, at
    which the contact that follows from the last one counts.
    """

    def __init__(self, case: Case, near: float = NEAR):
        self.case, self.flies = case, case.effect(Flight) is not None
        self._find = finder(case)
        start = start_motion(case)
        self.near, self.theta = (start.xi1, start.xi2), start.theta
        self.size, self.most = case.plate.reach, near * case.plate.reach
        # The pose and gap of the last search in flight.
        self.last_pose: tuple[float, float, float] = (nan, nan, nan)
        self.gap = 0.0

    def __call__(self, x: float, y: float, theta: float) -> Contact:
        """The contact of a pose; raises one of BEYOND for a plate that has lost its track and may not fly."""
        turn, self.theta = theta - self.theta, theta
        if abs(turn) > LARGE_TURN and self.case.plate.outline.period:
            self.near = self.near[0], self.near[1] - turn * self.case.plate.outline.period / (2.0 * pi)
        if not self.flies:
            contact = self._find(x, y, theta, self.near)
            self.near = contact[:2]
            return contact
        x0, y0, theta0 = self.last_pose
        # No point of the plate has moved by more than this since.
        clearance = self.gap - hypot(x - x0, y - y0) - self.size * abs(theta - theta0)
        if clearance > FAR * self.size:
            return Contact(nan, nan, clearance)
        try:
            contact = self._find(x, y, theta, self.near)
            if contact.gap <= self.most:
                self.gap = 0.0
                return self._at(contact)
        except BEYOND:
            pass
        other = nearest(self.case, x, y, theta)
        if other is None:
            # Beyond an end of the track; search again when the plate has moved by its own size.
            other = Contact(nan, nan, self.size)
        else:
            other = self._at(_with_turns(self.case, other, theta))
        self.last_pose, self.gap = (x, y, theta), other.gap
        return other

    def _at(self, contact: Contact) -> Contact:
        self.near = (contact.xi1, contact.xi2)
        return contact


def _with_turns(case: Case, contact: Contact, theta: float) -> Contact:
    """The contact with whole turns added to its parameters, so that (6) gives θ itself."""
    xi1, xi2, gap = contact
    angle = float(case.track.tangent_angle(xi1) - case.plate.outline.tangent_angle(xi2))
    turns = round((angle - theta) / (2 * pi))
    if case.plate.outline.period:
        return Contact(xi1, xi2 + turns * case.plate.outline.period, gap)
    return Contact(xi1 - turns * (case.track.period or 0.0), xi2, gap)


def flights(gap: np.ndarray, pushing: np.ndarray, clear: float) -> list[tuple[int, int]]:
    """Ranges of samples [start, stop) in flight: from the last push of the track to the next one.

    A range counts if the gap (m) exceeds `clear` in it: shorter ones are the hops of a contact that is detected by its
    overlap, once a step. `pushing`: for each sample, whether the track pushes.
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[False], ~pushing, [False]]).astype(int)))
    stretches = zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)
    return [(a, b) for a, b in stretches if np.max(gap[a:b], initial=-inf) > clear]


def lands_for_good(case: Case) -> bool:
    """Whether the first landing ends the motion."""
    return case.effect(Flight) is not None and case.effect(Impact) is None
