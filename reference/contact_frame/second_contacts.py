"""Search for a second contact of a plate that lies on its track, for the second formulation."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cases import Case

from .pairs import Touch, refine
from .plate_motion import Motion, limits
from .sampling import bodies_in_contact
from .surroundings import Surroundings

# A step in which the contact is not proven to be the only one around it is halved while it moves by more than this part
# of the plate's reach, at most HALVINGS times.
LONG_WAY, HALVINGS = 0.1, 10
# A touch counts if the gap one step before was more than this many roundings of a position: next to the contact of a
# flat side the gap is only rounding.
ROUNDINGS = 1024 * 2.0**-52
# Places in a step at which the contact is sampled, and how far it may go beyond them, as a part of their range.
PLACES, BEYOND = np.linspace(0.0, 1.0, 5), 0.1

States = Callable[[np.ndarray], np.ndarray]


class Overlaps:
    """The search for a touch away from the contact during a phase, in each step of the integration."""

    def __init__(self, case: Case, around: Surroundings, turns: int):
        self.case, self.around, self.turns = case, around, turns
        self.touch: Touch | None = None
        self.step = 0.0

    def before(self, t: float, z) -> float:
        """The time from t to the touch, s; positive if none is found."""
        return 1.0 if self.touch is None else self.touch.time - t

    def look(self, z_at: States, start: float, end: float) -> None:
        """Search a step; `z_at` maps times to (ξ₁, ξ₂, ω, v), shape (4, n). Raises TooManyRounds."""

        def bodies(times: np.ndarray) -> np.ndarray:
            return bodies_in_contact(self.case, times, z_at(times), self.turns)

        motion, todo = Motion(bodies, np.array([start, end])), [(start, end, 0)]
        self.step = end - start
        while todo and self.touch is None:
            start, end, depth = todo.pop()
            x, y = bodies(np.array([start]))[:2, 0].tolist()
            way = limits(motion, start, end).speed * (end - start)
            some = self.around.near(x, y, self.around.reach + way)
            if self.around.fits(some):
                continue
            places = z_at(start + (end - start) * PLACES)[:2]
            low, high = places.min(axis=1), places.max(axis=1)
            more = BEYOND * (high - low)
            (first, second), (last, final) = (low - more).tolist(), (high + more).tolist()
            own = self.around.own((first, last), (second, final))
            far = (last - first) * float(self.case.track.speed(first)) > LONG_WAY * self.around.reach
            if own is None and far and depth < HALVINGS:
                middle = 0.5 * (start + end)
                todo += [(middle, end, depth + 1), (start, middle, depth + 1)]
                continue
            some, inside = self.around.inside(some, own or self.around.at(first, last))
            rest = some.some(~inside)
            self.touch = self.around.search.first(motion, end, rest, np.full(rest.number, start), self._is_resolved)

    def _is_resolved(self, motion: Motion, touch: Touch) -> bool:
        """Whether there was a gap at the touch one step before."""
        body = motion.bodies(np.array([touch.time - self.step]))[:, 0].tolist()
        pair = refine(self.around.scene, body, touch.xi1, touch.xi2, self.around.size)
        return pair is not None and pair.gap > ROUNDINGS * (self.around.reach + abs(body[0]) + abs(body[1]))
