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
from math import inf

import numpy as np

from ..scales import EPS
from .integrators.segment import Event, Segment
from .modes import Phase

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
