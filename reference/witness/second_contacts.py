"""Search for a second contact of a plate that lies on its track, for the second formulation.

Steps of the integration are searched in lots, so that a touch may be found some steps after it.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable

import numpy as np

from cases import Case

from .pairs import Touch, nearest
from .plate_motion import Motion, bodies_in_contact, limits
from .surroundings import Surroundings

# Steps searched together: the search of several takes hardly longer than that of one. They end where the plate has
# moved by FAR of its reach.
TOGETHER, FAR = 16, 0.02
# Steps in which the contact is not proven to be the only one around it are searched in two lots. A single one is halved
# while the contact moves by more than this part of the plate's reach, at most HALVINGS times.
LONG_WAY, HALVINGS = 0.1, 10
# A touch counts if the gap one step before was more than this many roundings of a position: next to the contact of a
# flat side the gap is only rounding.
ROUNDINGS = 1024 * 2.0**-52
# Places in a step at which the contact is sampled, and how far it may go beyond them, as a part of their range.
PLACES, BEYOND = np.linspace(0.0, 1.0, 5), 0.1

States = Callable[[np.ndarray], np.ndarray]


class Overlaps:
    """The search for a touch away from the contact during a phase, in lots of steps of the integration."""

    def __init__(self, case: Case, around: Surroundings, turns: int):
        self.case, self.around, self.turns = case, around, turns
        self.touch: Touch | None = None
        self.state: list[float] | None = None  # (ξ₁, ξ₂, ω, v) of the contact then
        self.edges: list[float] = []
        self.waiting: list[States] = []

    def before(self, t: float, z) -> float:
        """The time from t to the touch, s, or to the start of the step after which it was found if that is later;
        positive if none is found."""
        return 1.0 if self.touch is None else max(self.touch.time, self.edges[-2]) - t

    def by(self, t: float) -> Touch | None:
        """The touch, if one was found up to the time t, s."""
        return self.touch if self.touch is not None and self.touch.time <= t else None

    def look(self, z_at: States, start: float, end: float) -> None:
        """Take a step into the search; `z_at` maps times to (ξ₁, ξ₂, ω, v), shape (4, n). Raises TooManyRounds."""
        self.edges = [*self.edges, end] if self.waiting else [start, end]
        self.waiting.append(z_at)
        x, y = self._bodies(np.array([self.edges[0], end]))[:2]
        if len(self.waiting) >= TOGETHER or np.hypot(*np.diff([x, y]))[0] > FAR * self.around.reach:
            self.finish()

    def finish(self) -> None:
        """Search the steps that wait for it. Raises TooManyRounds."""
        if not self.waiting:
            return
        motion, todo = Motion(self._bodies, np.array(self.edges)), [(tuple(self.edges), 0)]
        while todo and self.touch is None:
            edges, depth = todo.pop()
            start, end = edges[0], edges[-1]
            x, y = self._bodies(np.array([start]))[:2, 0].tolist()
            way = limits(motion, start, end).speed * (end - start)
            some = self.around.near(x, y, self.around.reach + way)
            if self.around.fits(some):
                continue
            low, high = self._range(edges)
            (first, second), (last, final) = low.tolist(), high.tolist()
            own = self.around.own((first, last), (second, final))
            if own is None and len(edges) > 2:
                half = len(edges) // 2
                todo += [(edges[half:], depth), (edges[: half + 1], depth)]
                continue
            far = (last - first) * float(self.case.track.speed(first)) > LONG_WAY * self.around.reach
            if own is None and far and depth < HALVINGS:
                middle = 0.5 * (start + end)
                todo += [((middle, end), depth + 1), ((start, middle), depth + 1)]
                continue
            some, inside = self.around.inside(some, own or self.around.at(first, last))
            rest = some.some(~inside)
            self.touch = self.around.search.first(motion, end, rest, np.full(rest.number, start), self._is_resolved)
        if self.touch is not None:
            self.state = self._states(np.array([self.touch.time]))[:, 0].tolist()
        self.waiting = []

    def _states(self, times: np.ndarray) -> np.ndarray:
        """(ξ₁, ξ₂, ω, v) in the waiting steps, shape (4, n)."""
        step = np.searchsorted(self.edges[1:-1], times, side="right")
        states = np.empty((4, len(times)))
        for number in np.unique(step).tolist():
            states[:, step == number] = self.waiting[number](times[step == number])
        return states

    def _bodies(self, times: np.ndarray) -> np.ndarray:
        """(x, y, θ, vx, vy, ω) there, shape (6, n)."""
        return bodies_in_contact(self.case, times, self._states(times), self.turns)

    def _range(self, edges: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
        """The range of both parameters of the contact in some steps, or in a part of one."""
        starts, ends = np.array(edges[:-1]), np.array(edges[1:])
        places = self._states((starts[:, None] + (ends - starts)[:, None] * PLACES).ravel())[:2]
        places = places.reshape(2, len(starts), len(PLACES))
        low, high = places.min(axis=2), places.max(axis=2)
        more = BEYOND * (high - low)
        return (low - more).min(axis=1), (high + more).max(axis=1)

    def _is_resolved(self, motion: Motion, touch: Touch) -> bool:
        """Whether there was a gap at the touch one step before."""
        number = min(max(bisect_right(self.edges, touch.time), 1), len(self.waiting))
        step = self.edges[number] - self.edges[number - 1]
        body = motion.bodies(np.array([touch.time - step]))[:, 0].tolist()
        pair = nearest(self.around.case, body, touch.xi1, touch.xi2)
        return pair is not None and pair.gap > ROUNDINGS * (self.around.reach + abs(body[0]) + abs(body[1]))
