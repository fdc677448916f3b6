"""Touches of curves with corners in a step, away from their contact: where the plate enters its track in a pose.

Both curves are polygons here whose sides turn by a hundredth of a radian. Between two samples no point of the plate
moves farther than a small part of its size, or than its distance from the track. Where a vertex of one curve is inside
the other, the gap of a pair of elements has closed: its zero is located on the curves themselves.
"""

from __future__ import annotations

from math import ceil, hypot, inf

import numpy as np

from cases import Case, DoesNotFit
from cases.contact.overlap_search import span
from cases.contact.piece_contact import Entry, excludes_second, find_from

from .chain_entries import Chains, entry_time
from .pairs import Touch, in_round
from .plate_motion import Motion, limits
from .touches import Places

# Between two samples the plate's points move by this part of its size, or by so much of the distance from the track; at
# most MOST samples are taken in a step.
STEP, OF_DISTANCE, MOST = 0.02, 0.5, 2000
# The stretch between two samples is halved so often, to see which pair of elements touches first.
HALVINGS = 25


class ChainTouches:
    """The search for touches of the curves of a case."""

    def __init__(self, case: Case, xi1: float):
        self.case, self.xi1, self.spread, self.middle = case, xi1, 0.0, (inf, inf)
        self.passing = False  # a plate is not stopped by the ends of an open track, and overlaps it while it passes one

    def first(self, motion: Motion, ends: tuple[float, float], places: Places, closed: bool) -> Touch | None:
        """The first touch between two times away from contacts at `places`, if there is one; `closed`: whether one of
        them touches."""
        track, outline = self.case.track, self.case.plate.outline
        if not outline.period or (closed and excludes_second(track, outline)):
            return None
        bounds, (before, end) = limits(motion, *ends), ends
        fastest, count = bounds.speed + bounds.spin * self.case.plate.reach, 0
        while before < end:
            chains = self._chains(*motion.bodies(np.array([before]))[:2, 0].tolist())
            x, y = motion.bodies(np.array([before]))[:2, 0].tolist()
            away = float(np.hypot(*(chains.points1 - [[x], [y]])).min()) - chains.reach - chains.longest
            way = max(STEP * chains.size, OF_DISTANCE * away)
            steps = min(ceil(fastest * (end - before) / way), MOST - count)
            after = before + (end - before) / steps if steps > 1 else end
            entry = self._entry(chains, motion, after, places)
            if entry is not None and not self.passing:
                touch = self._touch(chains, motion, entry, (before, after), places)
                if touch is not None:
                    return touch
            before, count, self.passing = after, count + 1, entry is not None
        return None

    def _chains(self, x: float, y: float) -> Chains:
        """The polygons of both curves, the track's as far as the plate comes near."""
        case, reach = self.case, self.case.plate.reach
        if hypot(x - self.middle[0], y - self.middle[1]) > self.spread + reach:
            self.spread, self.middle = (2.0 * (self.spread + reach), (x, y)) if self.middle[0] < inf else (0.0, (x, y))
            near = span(case.track, np.array([self.xi1]), 4.0 * (reach + self.spread))
            self.chains = Chains(case.track, case.plate.outline, *near)
        return self.chains

    def _entry(self, chains: Chains, motion: Motion, t: float, places: Places) -> Entry | None:
        points = places(np.array([t]))[:, 0, 0].tolist()
        return chains.entry(*motion.bodies(np.array([t]))[:3, 0].tolist(), *points[:1])

    def _touch(
        self, chains: Chains, motion: Motion, entry: Entry, times: tuple[float, float], places: Places
    ) -> Touch | None:
        """The touch by which the plate has entered its track between two times; None beyond an open track's ends."""
        (low, high), (start, _) = times, times
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            now = self._entry(chains, motion, middle, places)
            if now is None:
                low = middle
            else:
                high, entry = middle, now

        def pose_at(t: float) -> tuple[float, float, float]:
            x, y, theta = motion.bodies(np.array([t]))[:3, 0].tolist()
            return x, y, theta

        try:
            time = entry_time(pose_at, entry, start, high, float(motion.edges[0]))
        except DoesNotFit:
            time = high
        body = motion.bodies(np.array([time]))[:, 0].tolist()
        track, outline = self.case.track, self.case.plate.outline
        try:
            xi1, xi2, _ = find_from(track, outline, body[0], body[1], body[2], entry)
        except DoesNotFit:  # a corner on a corner
            return Touch(time, body, np.nan, np.nan, 0.0)
        if track.ends and not track.ends[0] <= xi1 <= track.ends[1]:
            return None
        return Touch(time, body, xi1, in_round(self.case, body[2], xi1, xi2), 0.0)
