"""Touches in a step at places that are not watched: the first of a smooth plate and one curve."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cases import DoesNotFit
from cases.scene.contact_pairs import PairCase

from .pairs import Touch, nearest
from .plate_motion import Motion, limits
from .surroundings import Surroundings

# A step is halved while a contact that is not proven to be the only one around it moves by more than this part of the
# plate's reach, at most HALVINGS times.
LONG_WAY, HALVINGS = 0.1, 10
# A touch next to a contact counts if the gap one step before was more than this many roundings of a position: next to
# the contact of a flat side the gap is only rounding.
ROUNDINGS = 1024 * 2.0**-52
# Places in a step at which contacts are sampled, and how far they may go beyond them, as a part of their range.
PLACES, BEYOND = np.linspace(0.0, 1.0, 5), 0.1

# Maps times (n,) to the parameters of the watched contacts, shape (contacts, 2, n).
Places = Callable[[np.ndarray], np.ndarray]


class Touches:
    """The search for touches of one pair of curves, around its watched contacts."""

    def __init__(self, case: PairCase, xi1: float):
        self.case, self.around = case, Surroundings(case, xi1)

    def first(self, motion: Motion, ends: tuple[float, float], places: Places, closed: bool) -> Touch | None:
        """The first touch between two times away from contacts at `places`, if there is one; `closed`: whether one of
        them touches. Raises TooManyRounds."""
        (start, end), around = ends, self.around
        x, y = motion.bodies(np.array([start]))[:2, 0].tolist()
        way = limits(motion, start, end).speed * (end - start)
        if around.away(x, y) > way:
            return None
        some = around.near(x, y, around.reach + way)
        if not some.number or (closed and around.fits(some)):
            return None
        return self._among(motion, ends, places, HALVINGS)

    def _among(self, motion: Motion, ends: tuple[float, float], places: Places, halvings: int) -> Touch | None:
        (start, end), around = ends, self.around
        x, y = motion.bodies(np.array([start]))[:2, 0].tolist()
        some = around.near(x, y, around.reach + limits(motion, start, end).speed * (end - start))
        contacts = places(start + (end - start) * PLACES)
        for low, high in zip(contacts.min(axis=2), contacts.max(axis=2), strict=True):
            low, high = low - BEYOND * (high - low), high + BEYOND * (high - low)
            (first, second), (last, final) = low.tolist(), high.tolist()
            own = around.own((first, last), (second, final))
            far = (last - first) * float(self.case.track.speed(first)) > LONG_WAY * around.reach
            if own is None and far and halvings:
                middle = 0.5 * (start + end)
                parts = ((start, middle), (middle, end))
                every = (self._among(motion, part, places, halvings - 1) for part in parts)
                return next((touch for touch in every if touch is not None), None)
            some, inside = around.inside(some, own or around.at(first, last))
            some = some.some(~inside)
        since = np.full(some.number, start)
        return around.search.first(motion, end, some, since, self._is_resolved if len(contacts) else None)

    def _is_resolved(self, motion: Motion, touch: Touch) -> bool:
        """Whether there was a gap at the touch one step before."""
        number = min(max(int(np.searchsorted(motion.edges, touch.time)), 1), len(motion.edges) - 1)
        step = motion.edges[number] - motion.edges[number - 1]
        try:
            body, pair = nearest(self.case, motion, touch.time - step, (touch.xi1, touch.xi2))
        except DoesNotFit:
            return False
        return pair.gap > ROUNDINGS * (self.around.reach + abs(body[0]) + abs(body[1]))
