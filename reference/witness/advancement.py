"""First touch of a moving plate and its track by conservative advancement of the track's stretches.

Each stretch has a time before which the plate certainly does not begin to touch it: its distance, divided by a bound on
the rate at which that decreases, is a time without a touch. The earliest stretches advance; a stretch whose length
makes the bounds much wider is divided. Time itself is never divided, and the outline enters only by its signed
distance.

With the distance φ of the point s of a stretch of half length h, φ' along the track and φ̇ by time at its middle,

    φ(s, t + τ) ≥ φ + φ' s + c s²/2 + (φ̇ − L |s|) τ − A τ²/2,    |s| ≤ h,

where c contains the curvatures of both curves, L the rotation of φ's gradient, and A the accelerations, reduced by the
outline's curvature for a point that slides past. A first touch is tangential: while the gradient is not normal to the
track there is none. (Derived; the principle is that of conservative advancement between pairs of bodies.)
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .curve_bounds import CurveBounds
from .distance import PointDistances, TrackDistance
from .pairs import Touch
from .plate_motion import Limits, Motion, limits
from .stretches import Stretches, parts

# Number of stretches (the earliest) that advance at once; rounds per motion, each about a millisecond.
TOGETHER, MOST_ROUNDS = 128, 100_000
# A stretch is divided if its length reduces the time to less than this part of the time of its middle point alone: into
# two parts, or into MORE where those of all advance together, which takes no longer than one.
WORTH, MORE = 0.5, 16
# Bounds for points that slide past hold until the gradient has turned by this angle, rad.
STRAIGHT = 0.25
# Inside the outline, up to this part of its smallest radius, the gradient turns less than 1.5 times as fast.
INSIDE = 0.3
# A stretch this short (in plate's sizes) at a distance of a rounding touches.
SHORTEST = 1e-9
# A touch is searched for if the distance is below NEAR times the size and the tangents' angle below LEVEL (rad), and it
# would vanish at its present rate in SOON times the rest of the motion.
NEAR, LEVEL, SOON = 0.1, 0.5, 4.0

Locate = Callable[[Motion, float, float, float], Touch | None]
Counts = Callable[[Motion, Touch], bool]


class TooManyRounds(Exception):
    """The searches of a motion reached their limit on rounds."""


class Search:
    """The search for first touches of one plate and one track; counts its rounds."""

    def __init__(self, track: CurveBounds, distance: TrackDistance, locate: Locate):
        self.track, self.distance, self.locate, self.rounds = track, distance, locate, 0

    def first(
        self, motion: Motion, end: float, some: Stretches, since: np.ndarray, counts: Counts | None = None
    ) -> Touch | None:
        """The first touch on some stretches before a time (s), on each from its time `since` (n,) on, among those that
        `counts` accepts; None if there is none. Raises TooManyRounds."""
        if not some.number:
            return None
        t, attempts = since.copy(), np.zeros(some.number, dtype=bool)
        start = float(t.min())
        bounds = limits(motion, start, end)
        if self.distance.radius is not None:
            bounds = bounds._replace(spin=0.0, swing=0.0)
        earliest: Touch | None = None
        until = end
        while (t < until).any():
            self.rounds += 1
            if self.rounds > MOST_ROUNDS:
                raise TooManyRounds
            live = np.flatnonzero(t < until)
            if live.size > TOGETHER:
                live = live[np.argpartition(t[live], TOGETHER)[:TOGETHER]]
            now = some.some(live)
            points = self.distance.distances(motion.bodies(t[live]), now, bounds)
            rest = (earliest.time if earliest else end) - t[live]
            clear, alone = _clear(self.distance, points, now, now.half, bounds, rest)
            if earliest:  # the only possible touch on these stretches is already found
                alone &= (now.low <= earliest.xi1) & (earliest.xi1 <= now.high)
                clear = np.where(alone, np.inf, clear)
            best, _ = _clear(self.distance, points, now, 0.0 * now.half, bounds, rest)
            before = t[live]
            t[live] += clear
            going = t[live] < until
            arrival = before + np.maximum(points.phi, 0.0) / np.maximum(-points.rate, 1e-300)
            may = going & ~attempts[live] & (arrival - before <= SOON * rest)
            new = self._touch(motion, before, now, points, may, arrival, attempts, live)
            short = going & (now.half <= SHORTEST * self.distance.size)
            touching = np.flatnonzero(short & (np.abs(points.phi) <= points.fuzz) & (points.rate <= 0.0))
            if new is None and touching.size:
                k = touching[np.argmin(before[touching])]
                new = self._at(motion, float(before[k]), now, int(k))
            # A distance of a rounding that decreases can give no other touch; one that grows is tested again later.
            at_rounding = short & (np.abs(points.phi) <= points.fuzz)
            later = t[live] + 0.1 * (t[live] - start) + 4.0 * np.spacing(t[live])
            t[live] = np.where(at_rounding, np.where(points.rate <= 0.0, np.inf, later), t[live])
            if new is not None and counts is not None and not counts(motion, new):
                new = None
            if new is not None and new.time < (earliest.time if earliest else end):
                earliest = new
                until = earliest.time - earliest.blur
            stuck = t[live] <= before + np.spacing(before)
            split = live[going & ~short & ((clear < WORTH * best) | stuck)]
            if split.size:
                others = np.setdiff1d(np.arange(len(t)), split)
                count = MORE if MORE * split.size <= TOGETHER else 2
                some = some.some(others).join(parts(self.track, some.some(split), count))
                t = np.append(t[others], np.tile(t[split], count))
                attempts = np.append(attempts[others], np.zeros(count * split.size, dtype=bool))
        return earliest

    def _touch(
        self, motion: Motion, times: np.ndarray, now: Stretches, points: PointDistances, may: np.ndarray,
        arrival: np.ndarray, attempts: np.ndarray, live: np.ndarray,
    ) -> Touch | None:  # fmt: skip
        """A touch by Newton's method from the stretch that may touch first; each stretch is tried once."""
        may = may & (points.phi < NEAR * self.distance.size) & (points.rate < 0.0) & (points.angle < LEVEL)
        may &= (self.distance.sharpest + now.bend) * now.half < STRAIGHT
        candidates = np.flatnonzero(may)
        if not candidates.size:
            return None
        k = int(candidates[np.argmin(arrival[candidates])])
        attempts[live[k]] = True
        time = float(times[k])
        foot = self.distance.foot(motion.bodies(np.array([time]))[:, 0], float(now.x[k]), float(now.y[k]))
        touch = self.locate(motion, time, float(now.middle[k]), foot)
        wide = float(now.high[k] - now.low[k])
        if touch is None or not now.low[k] - wide <= touch.xi1 <= now.high[k] + wide:
            return None
        return touch if touch.time >= time - touch.blur else None

    def _at(self, motion: Motion, time: float, now: Stretches, k: int) -> Touch:
        """The middle of a short stretch as the touch, if Newton's method finds none: accurate to its rounding."""
        body = motion.bodies(np.array([time]))[:, 0]
        foot = self.distance.foot(body, float(now.x[k]), float(now.y[k]))
        return Touch(time, body.tolist(), float(now.middle[k]), foot, 0.0)


def _clear(
    plate: TrackDistance, points: PointDistances, some: Stretches, half: np.ndarray, bounds: Limits, rest: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The times (s) in which no point within `half` of the stretches' middles begins to touch, and which stretches have
    at most one touch during `rest`."""
    with np.errstate(all="ignore"):
        phi, most, spin = points.phi, points.most, bounds.spin
        low = phi - half
        shallow = low * plate.sharpest > -INSIDE
        turn = plate.sharpest / (1.0 + np.maximum(plate.sharpest * low, -INSIDE))
        turn = np.where(shallow, turn, np.inf)
        # With time the gradient turns faster: the nearer the plate, the faster.
        faster = most * plate.sharpest / (1.0 + np.clip(plate.sharpest * low, -INSIDE, 0.0))
        bent = (some.bend + turn) * half
        smooth = phi + half < plate.single
        gap = _closest(plate, points, some, half, bent)
        gap = np.where(smooth, np.fmax(gap, low), low)
        gap = np.where(gap > points.fuzz, gap, np.where(gap > -points.fuzz, 0.0, np.nan))
        # Largest difference between the rates of a stretch's points and of its middle.
        differs = spin * half + most * np.minimum(2.0, turn * half)
        closing = np.minimum(differs - points.rate, points.speed + spin * half)
        pull = points.pull + 2.0 * plate.hollow * most**2
        lasts = _falls(gap, closing, pull)
        # The outline bends away from a point that slides past it.
        within = np.minimum(STRAIGHT / faster, rest)
        swept = turn * half + faster * within
        along = np.abs(points.along) * np.cos(swept) - np.abs(points.rate) * np.sin(swept)
        along = np.maximum(along - spin * half - points.pull * within, 0.0)
        away = plate.bluntest / (1.0 + plate.bluntest * (np.maximum(phi, 0.0) + half + most * within))
        past = _falls(gap, closing, points.pull - away * np.where(swept < 1.0, along, 0.0) ** 2)
        lasts = np.fmax(lasts, np.minimum(past, within))
        # No touch begins while no tangents are parallel.
        lasts = np.fmax(lasts, np.where(shallow, (points.angle - bent) / (faster + spin), 0.0))
        if plate.hollow:  # the bounds hold only while the nearest point is unique
            lasts = np.where(smooth, np.minimum(lasts, (plate.single - phi - half) / most), 0.0)
        # In any case a distance changes no faster than the point moves, and no touch begins inside the plate.
        lasts = np.fmax(lasts, low / most)
        lasts = np.fmax(lasts, (-phi - half - points.fuzz) / most)
        later = bent + (faster + spin) * rest
        closes = points.rate + differs + (pull + faster * most) * rest < 0.0
        alone = closes & (later < STRAIGHT) & smooth & (_bending(plate, points, some, half, later) > 0.0)
        return np.where(lasts > 0.0, lasts, 0.0), alone


def _bending(
    plate: TrackDistance, points: PointDistances, some: Stretches, half: np.ndarray, bent: np.ndarray
) -> np.ndarray:
    """A lower bound on the second derivative of the distance along stretches, 1/m, while tangents turn by `bent`."""
    level = np.cos(np.minimum(points.angle + bent, np.pi))
    away = plate.bluntest / (1.0 + plate.bluntest * (np.maximum(points.phi, 0.0) + half))
    crest = np.where(some.valley > 0.0, -some.valley, -some.valley * level)
    return np.where(level > 0.0, crest + away * level**2, -some.bend) - 2.0 * plate.hollow


def _closest(
    plate: TrackDistance, points: PointDistances, some: Stretches, half: np.ndarray, bent: np.ndarray
) -> np.ndarray:
    """A lower bound on the distance of stretches, m."""
    slope, c = np.abs(points.slope), _bending(plate, points, some, half, bent)
    return np.where(
        slope < c * half, points.phi - 0.5 * slope**2 / c, points.phi - slope * half + 0.5 * c * half**2
    )  # fmt: skip


def _falls(gap: np.ndarray, closing: np.ndarray, pull: np.ndarray) -> np.ndarray:
    """The first zero of gap − closing τ − pull τ²/2 after τ = 0; infinite if there is none, NaN where the gap is."""
    inside = closing**2 + 2.0 * pull * gap
    root = np.sqrt(inside)
    late = np.where(pull > 0.0, (root - closing) / pull, np.inf)
    return np.where(inside < 0.0, np.inf, np.where(closing > 0.0, 2.0 * gap / (closing + root), late))
