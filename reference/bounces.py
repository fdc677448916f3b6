"""Bouncing that comes to rest: infinitely many impacts in a finite time, whose limit is found, not stepped through.

Flights shorten by a factor that tends to a constant ρ, so that the instants of the impacts and everything that changes
from one to the next tend to their limits like ρᵏ, ρ²ᵏ, …: Wynn's ε-algorithm removes these terms one after the other
without being told ρ (e.g. Brezinski & Redivo Zaglia, Extrapolation Methods, 1991, section 2.3).
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import inf, nan, sqrt
from typing import NamedTuple

import numpy as np

from cases import Case
from cases.contact import pose

from .arc import Arc, Stop
from .flight import Landing
from .impact import Touch
from .modes import Phase, in_flight

# At most the terms ρᵏ, ρ²ᵏ, ρ³ᵏ, ρ⁴ᵏ are removed: each costs two more impacts and digits to rounding.
MOST_TERMS = 4
# What is left of the time after m terms are removed, as a part of the natural time. The smaller the bounces, the less
# sure are their instants (the rounding of a position over a speed): there is nothing to gain below.
NEGLIGIBLE = 1e-13
# Bounces count from where the time that is left is this part of the natural time, and while the ratio of two flights
# does not change by more than as much: there the expansion in powers of ρᵏ holds.
SMALL = 2e-2


class Limit(NamedTuple):
    """Where bouncing comes to rest: when, the contact parameters and θ, slip and spin (without lift)."""

    time: float
    xi1: float
    xi2: float
    theta: float
    touch: Touch


class _Bounce(NamedTuple):
    landing: Landing
    after: Touch
    ratio: float
    pull: float  # what brought it back, m/s²; NaN where it is not known
    left: float  # estimated time until the limit, in natural times


class Bounces:
    """The impacts of one motion so far."""

    def __init__(self, case: Case):
        self.case = case
        self.size = case.plate.gyration
        self.last: list[_Bounce] = []

    def add(self, since: float, landing: Landing, after: Touch) -> None:
        """An impact that ends a flight begun at `since`, and the velocities after it, with lift > 0."""
        ratio, pull, left = -after.lift / landing.touch.lift, nan, inf
        if self.last and since > self.last[-1].landing.time:  # the plate has lain on its track meanwhile
            self.last.clear()
        if self.last:
            flown, rose = landing.time - self.last[-1].landing.time, self.last[-1].after.lift
            pull = (rose - landing.touch.lift) / flown
            natural = min(self.case.duration, sqrt(self.size / pull)) if pull > 0.0 else inf
            change = abs(pull - self.last[-1].pull)
            if change > 0.0:  # after a lift-off the pull grows from nothing, much faster than the plate swings
                natural = min(natural, flown * pull / change)
            left = 2.0 * after.lift / (pull * (1.0 - ratio)) / natural if pull > 0.0 and ratio < 1.0 else inf
        if left > SMALL or abs(ratio - self.last[-1].ratio) > SMALL:
            self.last.clear()
        self.last.append(_Bounce(landing, after, ratio, pull, left))

    def limit(self) -> Limit | None:
        """The limit, once enough impacts are known to find it to rounding."""
        terms = min((len(self.last) - 1) // 2, MOST_TERMS)
        if terms < 1 or self.last[-1].left ** (terms + 1) > NEGLIGIBLE:
            return None
        some = self.last[-(2 * terms + 1) :]
        places = np.array([b.landing[:3] for b in some])
        time, xi1, xi2 = (extrapolated(column) for column in places.T.tolist())
        slip, _, omega = (extrapolated(column) for column in np.array([b.after for b in some]).T.tolist())
        after = some[-1].after
        # A slip or a rotation that the impacts themselves end is none at the limit either.
        touch = Touch(slip if after.slip else 0.0, 0.0, omega if after.omega else 0.0)
        return Limit(time, xi1, xi2, float(pose(self.case, xi1, xi2)[2]), touch)

    def settling(self, flight: Phase, limit: Limit) -> Arc:
        """The time between the last impact that was stepped through and the limit: too short for a flight to show."""
        landing, after = self.last[-1].landing, self.last[-1].after
        first, last = (
            np.array(in_flight(self.case, (place.xi1, place.xi2), touch.slip, touch.omega, touch.lift))
            for place, touch in ((landing, after), (limit, limit.touch))
        )

        def states(times: np.ndarray) -> np.ndarray:
            part = (times - landing.time) / (limit.time - landing.time)
            return first[:, None] + np.outer(last - first, part)

        times = np.array([landing.time, limit.time])
        return Arc(flight, times, states, Stop(None, limit.time, tuple(last.tolist())), 0)


def extrapolated(sequence: Sequence[float]) -> float:
    """The limit of a sequence of odd length by Wynn's ε-algorithm, as far as its columns agree with each other."""
    before, now = [0.0] * (len(sequence) + 1), list(sequence)
    best, spread = now[-1], inf
    for column in range(1, len(sequence)):
        steps = [b - a for a, b in pairwise(now)]
        if any(step == 0.0 for step in steps):
            return best
        before, now = now, [before[i + 1] + 1.0 / step for i, step in enumerate(steps)]
        if column % 2 == 0:
            # A term like ρᵏ that is removed moves the limit by 1/(1 − ρ) times the last change, and ρ is hardly above
            # 0.97 for the second and third; what moves it more is rounding, blown up.
            if abs(now[-1] - best) > 30.0 * spread:
                return best
            best, spread = now[-1], abs(now[-1] - now[-2]) if len(now) > 1 else 0.0
    return best
