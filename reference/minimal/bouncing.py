"""Bouncing that comes to rest: infinitely many impacts in a finite time, whose limit is extrapolated.

From impact to impact the rebound's speed u shrinks by a factor that tends to a constant ρ < 1, and the rest of the
state (place, slip, spin) changes by amounts of the order of u. The states of all sequences with one limit lie on a
curve through it that is invariant under the map from impact to impact, with multiplier ρ, and as smooth as the map (a
stable fibre; Hirsch, Pugh & Shub, Invariant Manifolds, 1977: known to us, not looked up). So everything is a smooth
function of u, and the polynomial through a few impacts with well separated u, evaluated at u = 0 (Neville), is the
limit, whatever ρ is.

At one contact the rebound and the pull say how much time remains, so that the limit is known from bounces of a
hundredth of the natural time. The impacts of several contacts (`solver.hops`) have to be followed until plates move by
1e-9 of their size: of a disc that bounces with a coefficient of 0.8 that is 52 impacts instead of 42.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, sqrt
from typing import NamedTuple

import numpy as np

from cases import Case
from cases.contact import pose

from ..scales import EPS
from .impact import ContactVelocity
from .integrators.segment import Event, Segment
from .landing import Landing
from .modes import Phase, in_flight

# At most this many impacts are used for a limit, each with at most half the speed of the one before: a polynomial
# through points that are closer together would amplify their rounding.
MOST, APART = 6, 0.5
# The limit is accepted when one more impact changes it by no more than this part of the natural time (and of the
# distances and speeds reached in it), or when the theoretical error is as small.
NEGLIGIBLE = 1e-13
# Bounces count when the remaining time is below this part of the natural time, and while the ratio of two rebounds does
# not change by more than as much: u is small there.
SMALL = 2e-2
# An impact after which the plate flies is listed among the transitions if it closes with at least this part of the
# greatest closing speed since the plate last lay on its track: so the list of bouncing that comes to rest is finite.
# (Powers of round coefficients of restitution stay away from it.)
LISTING_PART = 7e-4
# A rebound that rises by no more roundings of positions than this does not count: bouncing is over. Its limit is
# extrapolated from the rebounds before it; if that fails (successive impacts end differently), bouncing ends here.
REBOUND_ROUNDINGS = 4


def is_unresolved(lift: float, pull: float, far: float) -> bool:
    """Whether a rebound with that speed (m/s), pulled back by that acceleration (m/s²), rises no higher than positions'
    rounding, of a plate at and of that size (m)."""
    return lift * lift <= 2.0 * pull * REBOUND_ROUNDINGS * EPS * far


class _Bounce(NamedTuple):
    landing: Landing
    after: ContactVelocity
    pull: float  # acceleration towards the track, m/s²
    natural: float  # s
    remaining: float  # estimated time until the limit, s


class Bounces:
    """The impacts of one motion so far."""

    def __init__(self, case: Case):
        self.case = case
        self.size = case.plate.gyration
        self.last: _Bounce | None = None
        self.ratio = inf
        self.some: list[_Bounce] = []  # bounces that count, with well separated speeds
        self.struck = -inf  # time of the last impact, s
        self.greatest = 0.0  # greatest closing speed since the plate last lay on its track, m/s

    def strike(self, since: float, landing: Landing) -> bool:
        """Record an impact that ends a flight begun at `since`; returns whether it is listed if the plate flies on."""
        closing = -landing.touch.lift
        if since > self.struck:  # the plate has lain on its track meanwhile
            self.last, self.some, self.ratio, self.greatest = None, [], inf, 0.0
        self.struck, self.greatest = landing.time, max(self.greatest, closing)
        return closing >= LISTING_PART * self.greatest

    def rebound(self, landing: Landing, after: ContactVelocity, pull: float) -> None:
        """Record the velocities after the last impact, with lift > 0, and the acceleration of the plate towards its
        track by gravity and load, m/s² (away from it if not positive)."""
        closing = -landing.touch.lift
        ratio = after.lift / closing if closing > 0.0 else inf
        natural = self._natural(landing, after, pull)
        remaining = 2.0 * after.lift / (pull * (1.0 - ratio)) if pull > 0.0 and ratio < 1.0 else inf
        self.last = _Bounce(landing, after, pull, natural, remaining)
        if not remaining <= SMALL * natural or abs(ratio - self.ratio) > SMALL:
            self.some.clear()
        if remaining <= SMALL * natural and (not self.some or after.lift <= APART * self.some[-1].after.lift):
            self.some = [*self.some[1 - MOST :], self.last]
        self.ratio = ratio

    def no_rebound(self) -> None:
        """Record an impact without lift: later rebounds do not continue the present sequence."""
        self.last, self.some, self.ratio = None, [], inf

    def _natural(self, landing: Landing, after: ContactVelocity, pull: float) -> float:
        """The shortest of the times in which the plate falls through its size, turns by a radian, the pull changes
        (after a lift-off it grows from nothing), and the contact passes an oscillation of track or outline."""
        if not pull > 0.0:
            return inf
        times = [sqrt(self.size / pull), 1.0 / abs(after.omega) if after.omega else inf]
        if self.last:
            last, since = self.last.landing, landing.time - self.last.landing.time
            changes = [(pull, abs(pull - self.last.pull))]
            places = (self.case.track, landing.xi1, last.xi1), (self.case.plate.outline, landing.xi2, last.xi2)
            changes += [
                (2.0 * curve.features.piece_length(at), abs(at - before))  # a piece is half an oscillation, or less
                for curve, at, before in places
                if curve.features
            ]
            times += [size * since / change for size, change in changes if change]
        return min(times)

    def limit(self, is_unresolved: bool = False) -> Landing | None:
        """The limit, without lift, if there are enough impacts to compute it to rounding; else None.

        `is_unresolved`: the last rebound is no higher than rounding, so further impacts would not improve the limit.
        """
        if self.last is None or not self.some:
            return None
        some = self.some
        if is_unresolved and some[-1] is not self.last:
            some = [*some[:-1], self.last]
        if len(some) < (2 if is_unresolved else 3) or some[-1] is not self.last:
            return None
        landing, after, _, natural, _ = self.last
        speeds = [b.after.lift for b in some]
        rows = [(b.landing.time + b.remaining, b.landing.xi1, b.landing.xi2, b.after.slip, b.after.omega) for b in some]
        limits = [extrapolate(speeds, column) for column in zip(*rows, strict=True)]
        time, xi1, xi2, slip, omega = (value for value, _ in limits)
        # A length that the motion covers in the natural time is as small as that.
        speeds = [float(c.speed(s)) for c, s in ((self.case.track, xi1), (self.case.plate.outline, xi2))]
        lengths = [self.size / speed if speed else 1.0 for speed in speeds]  # a corner's parameter is an angle
        scales = (natural, *lengths, self.size / natural, 1.0 / natural)
        agree = all(
            spread <= max(NEGLIGIBLE * scale, 4.0 * np.spacing(abs(value)))
            for (value, spread), scale in zip(limits, scales, strict=True)
        )
        # A slip that vanishes with the rebounds has a multiplier of its own, so that everything is a function of u and
        # of a power of u that is no whole number: a polynomial's theoretical error does not hold.
        vanishes = abs(slip) < SMALL * abs(after.slip)
        error = inf if vanishes else np.prod([b.remaining / b.natural for b in some])
        if not (agree or is_unresolved) and error > NEGLIGIBLE:
            return None
        # A slip or rotation that ended in the impacts is also zero at the limit.
        touch = ContactVelocity(slip if after.slip else 0.0, 0.0, omega if after.omega else 0.0)
        return Landing(time, xi1, xi2, float(pose(self.case, xi1, xi2)[2]), touch)

    def settling(self, flight: Phase, limit: Landing) -> Segment:
        """The segment between the last simulated impact and the limit: too short to show a flight."""
        assert self.last is not None
        landing, after = self.last.landing, self.last.after
        first, last = (
            tuple(map(float, in_flight(self.case, at.time, (at.xi1, at.xi2), touch.slip, touch.omega, touch.lift)))
            for at, touch in ((landing, after), (limit, limit.touch))
        )
        return straight(flight, landing.time, limit.time, first, last)


def straight(phase: Phase, start: float, end: float, first: tuple[float, ...], last: tuple[float, ...]) -> Segment:
    """The segment between the last impact that is simulated (s) and the limit of all, in these states."""
    states = StraightStates(start, end, first, last)
    return Segment.of(phase, np.array([start, end]), states, Event(None, end, last), 0)


@dataclass(frozen=True, eq=False, slots=True)
class StraightStates:
    """States that change linearly from one time (s) to another: times (n,) ↦ states (variables, n)."""

    start: float
    end: float
    first: tuple[float, ...]
    last: tuple[float, ...]

    def __call__(self, times: np.ndarray) -> np.ndarray:
        first, part = np.array(self.first), (times - self.start) / (self.end - self.start)
        return first[:, None] + np.outer(np.array(self.last) - first, part)


def extrapolate(at: Sequence[float], values: Sequence[float]) -> tuple[float, float]:
    """The value at 0 of the polynomials through the last one, two, … values (Neville), and the difference of the two
    that agree best: higher orders are closer to the limit until they amplify rounding."""
    column, (best, spread) = list(values), (values[-1], inf)
    for k in range(1, len(values)):
        before = column[-1]
        column = [
            column[i + 1] + (column[i + 1] - column[i]) * at[i + k] / (at[i] - at[i + k])
            for i in range(len(column) - 1)
        ]
        if abs(column[-1] - before) < spread:
            best, spread = column[-1], abs(column[-1] - before)
    return best, spread
