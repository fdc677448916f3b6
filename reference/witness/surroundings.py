"""The track around a plate in stretches, found by a k-d tree of their middles, and the range that a contact
excludes."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from math import ceil, floor

import numpy as np
from scipy.spatial import cKDTree

from cases import Curve
from cases.scene.contact_pairs import PairCase

from .advancement import Search
from .curve_bounds import CurveBounds
from .distance import TrackDistance
from .pairs import meeting
from .steps import StepFailure
from .stretches import Stretches, between, cut, evenly

# Initial length of stretches as a part of the plate's size; the track's features may need shorter ones.
LENGTH = 1 / 8
# A track longer than this many plates is not searched for landings, nor one with more stretches than fit a gigabyte.
LONGEST_TRACK, MOST_STRETCHES = 1e7, 4_000_000
# A window of an endless track begins with MARGIN sizes on each side, and is widened MOST_WIDENINGS times at most.
MARGIN, MOST_WIDENINGS = 8.0, 60
# A stretch around a contact without another contact is tried from half of the plate's reach downwards; if none is
# found, points closer than SAME times the size count as the contact: far above the error of Newton's method.
MOST_TRIES, SAME = 20, 1e-6
# Over such a stretch both curves turn by less than this, rad.
STRAIGHT = 0.5


class Surroundings:
    """Track and plate of a case, and the searches for where they touch."""

    def __init__(self, case: PairCase, xi1: float):
        self.case, self.distance = case, TrackDistance(case)
        self.reach, self.size = self.distance.reach, self.distance.size
        self.track, self.outline = CurveBounds(case.track), CurveBounds(case.plate.outline)
        self.search = Search(self.track, self.distance, partial(meeting, case, self.size))
        track = case.track
        self.endless = track.domain is None and not track.period
        if self.endless:
            margin = MARGIN * self.size / float(track.speed(xi1))
            self._sample(xi1 - margin, xi1 + margin)
        else:
            self._sample(*track.span)

    def _sample(self, low: float, high: float) -> None:
        track = self.case.track
        _, length = evenly(track, low, high, 3)
        if not length <= LONGEST_TRACK * self.size:
            raise StepFailure(
                f"landings are searched on {length:.3g} m of track by a plate of {self.size:.3g} m; "
                "give a larger plate or a shorter track"
            )
        count = int(min(max(16, length / (LENGTH * self.size)), MOST_STRETCHES))
        edges, _ = evenly(track, low, high, count + 1)
        if track.features:
            edges = np.union1d(edges, track.features.places(low, high))
        if len(edges) > MOST_STRETCHES:
            raise StepFailure("landings are searched on a track with too many features; give a shorter one")
        self.low, self.high = low, high
        self.stretches = between(self.track, edges[:-1], edges[1:])
        # Closed and convex: it turns to its left everywhere, once around.
        self.convex = bool(track.period) and bool(np.all(self.stretches.bend <= self.stretches.valley))
        self.longest = float(self.stretches.half.max())
        self.tree = cKDTree(np.column_stack([self.stretches.x, self.stretches.y]))

    def away(self, x: float, y: float) -> float:
        """A lower bound on the plate's distance from its track with its centre of mass at (x, y), m; negative if it may
        touch."""
        for _ in range(MOST_WIDENINGS):
            far, i = self.tree.query([x, y])
            if not self.endless or not self._widen(int(i)):
                return float(far) - self.longest - self.reach
        raise StepFailure(f"the plate at ({x:.9g}, {y:.9g}) m is too far from its endless track; end the case before")

    def _widen(self, i: int) -> bool:
        """Widen the window of an endless track if stretch i is close to one of its ends; returns whether it did."""
        margin, width = self.stretches.number // 8, self.high - self.low
        before, after = i < margin, i >= self.stretches.number - margin
        if before or after:
            self._sample(self.low - width * before, self.high + width * after)
        return before or after

    def near(self, x: float, y: float, radius: float) -> Stretches:
        """The stretches within a distance (m) of a place, in the order of their parameter ranges."""
        for _ in range(MOST_WIDENINGS):
            which = np.array(sorted(self.tree.query_ball_point([x, y], radius + self.longest)), dtype=int)
            ends = which[[0, -1]] if which.size else which
            if not self.endless or not any(self._widen(int(i)) for i in ends):
                break
        some = self.stretches.some(which)
        return some.some(np.hypot(some.x - x, some.y - y) <= radius + some.half)

    def inside(self, some: Stretches, own: tuple[float, float]) -> tuple[Stretches, np.ndarray]:
        """The stretches divided at the ends of a parameter range, and a mask of those in it."""
        period, shifts = self.case.track.period, [0.0]
        if period:
            low, high = self.case.track.span
            turns = range(floor((low - own[1]) / period), ceil((high - own[0]) / period) + 1)
            shifts = [period * turn for turn in turns]
        for shift in shifts:
            some = cut(self.track, some, (own[0] + shift, own[1] + shift))
        inside = np.zeros(some.number, dtype=bool)
        for shift in shifts:
            inside |= (own[0] + shift <= some.middle) & (some.middle <= own[1] + shift)
        return some, inside

    def fits(self, some: Stretches) -> bool:
        """Whether the curvatures alone exclude a second touch on nearby stretches: the outline bends more everywhere
        than they do, and they are the graph of a function, or parts of a convex closed curve."""
        if not some.number or not self.distance.bluntest > max(float(some.valley.max()), 0.0):
            return not some.number
        if self.convex:
            return True
        one_piece = bool(np.all(some.low[1:] == some.high[:-1]))
        angles = np.arctan2(some.ty, some.tx)
        turning = np.angle(np.exp(1j * (angles - angles[0])))
        return one_piece and float(np.ptp(turning)) + 2.0 * float((some.bend * some.half).max()) < 0.9 * np.pi

    def own(self, xi1: Sequence[float], xi2: Sequence[float]) -> tuple[float, float] | None:
        """The range of the track's parameter around a contact, whose parameters stay in the given ranges, in which the
        plate touches nowhere else: the outline bends more than the track there, and both turn little. None if no such
        range is found."""
        lengths = self.reach * 0.5 ** np.arange(1, MOST_TRIES + 1)
        first, second = _widen(self.case.track, xi1, lengths), _widen(self.case.plate.outline, xi2, lengths)
        (highest, _, turning), (_, least, more) = self.track.over(*first), self.outline.over(*second)
        alone = (least > np.maximum(highest, 0.0)) & (turning + more < STRAIGHT)
        if not alone.any():
            return None
        longest = int(np.argmax(alone))
        return float(first[0][longest]), float(first[1][longest])

    def at(self, low: float, high: float) -> tuple[float, float]:
        """The parameter range that counts as the contact itself if `own` finds none."""
        first, last = _widen(self.case.track, (low, high), np.array(SAME * self.size))
        return float(first), float(last)


def _widen(curve: Curve, ends: Sequence[float], lengths: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A range of a curve's parameter, widened on both sides by each of some lengths (m)."""
    low, high = ends[0] - lengths / float(curve.speed(ends[0])), ends[1] + lengths / float(curve.speed(ends[1]))
    if curve.ends:
        low, high = np.maximum(low, curve.ends[0]), np.minimum(high, curve.ends[1])
    return low, high
