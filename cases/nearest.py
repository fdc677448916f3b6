"""Where a plate off its track is nearest to it, over the whole of both curves: what a landing is looked for with."""

from __future__ import annotations

from functools import lru_cache
from math import ceil, copysign, cos, hypot, inf, log2, sin
from typing import NamedTuple

import numpy as np

from .case_class import Case
from .contact import Contact, find
from .curves import Curve
from .errors import DoesNotFit
from .features import union

# Number of samples of the outline: so dense that a smooth outline is unlikely to have a nearer point between two of
# them. Newton's method starts at the nearest sample.
OUTLINE_POINTS = 128
# Points of the track to a size of the plate.
POINTS_A_SIZE = 24
# A hundred thousand points are looked up as quickly as a thousand; more take long to lay out.
MOST = 100_000
# With more coordinates than this to compare, points are looked up in so many parts, each near fewer stretches.
TOGETHER, PARTS = 4_000_000, 32
# Samples of ripples near a plate are looked up in blocks of this length if they are more than that.
BLOCK, MANY = 64, 4096
# A track without ends is looked at for at least so many sizes of the plate to either side of the start; while the plate
# is nearest to an end of that, for twice as many, so often at most.
AROUND, DOUBLINGS = 16.0, 40
# Newton's method has found the pair that the samples show if it is no more of their distances away from them.
NEIGHBOURS = 4.0
# Else the pair is looked for among samples as far to either side as this, in their distances, ever closer by this
# factor, so often at most; until they are so close, in parts of the plate's size: gaps are level there to rounding.
WINDOW, CLOSER, ROUNDS, LEVEL = 1.5, 8.0, 100, 1e-9
# Where no track is any more, m: squares of distances overflow there.
FARTHEST = 1e150
# From so many times a closed track's size away it is a point: which of its points is the nearest drowns in rounding.
SIGHT = 1e12
# Of distances, in parts of them.
ROUNDING = 1e-12


class _Stretches(NamedTuple):
    """Samples of a curve in stretches of equal length, to look up which is nearest: their points (stretches, length,
    2), a centre (stretches, 2) and the farthest of them from it, m (stretches,).

    (SciPy's trees are as quick, and take a seventh of a second to import, more than a first motion does.)
    """

    points: np.ndarray
    centres: np.ndarray
    radii: np.ndarray

    @classmethod
    def of(cls, points: np.ndarray) -> _Stretches:
        """Short ones, of the cube root of the samples' number; the last sample (n, 2) fills the last of them up."""
        length = int(np.ceil(np.cbrt(len(points))))
        fill = np.minimum(np.arange(-(-len(points) // length) * length), len(points) - 1)
        stretches = points[fill].reshape(-1, length, 2)
        centres = stretches.mean(axis=1)
        return cls(stretches, centres, np.sqrt(_squares(stretches, centres[:, None]).max(axis=1)))

    def nearest(self, there: np.ndarray, ball: tuple[float, float, float] | None = None) -> np.ndarray:
        """Which sample is the nearest to each of the points (m, 2), the first of equal ones; `ball`: the middle and the
        radius of a circle around the points, where they are known.

        Stretches are looked into unless they begin farther away than another ends, whichever of the points one asks.
        """
        if len(there) > PARTS and len(there) * self.points.size > TOGETHER:
            return np.concatenate([self.nearest(part) for part in np.array_split(there, PARTS)])
        if ball is None:
            middle = there.mean(axis=0)
            ball = (*middle.tolist(), float(np.sqrt(_squares(there, middle).max())))
        x, y, radius = ball
        away = np.hypot(self.centres[:, 0] - x, self.centres[:, 1] - y)
        most = (float((away + self.radii).min()) + 2.0 * radius) * (1.0 + ROUNDING)
        some = (away - self.radii <= most).nonzero()[0]
        index = _squares(self.points[some].reshape(-1, 2), there[:, None]).argmin(axis=1)
        length = self.points.shape[1]
        return some[index // length] * length + index % length


def _squares(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Squares of distances of points, m²; coordinates are the last axis."""
    x, y = a[..., 0] - b[..., 0], a[..., 1] - b[..., 1]
    return x * x + y * y


class _CurveSamples(NamedTuple):
    """Samples of a curve: parameters, how far from each the next ones are, the same in m, points (n, 2), left normals
    (n, 2), curvatures, the points in stretches to look them up in, and which samples show features."""

    parameters: np.ndarray
    widths: np.ndarray
    spacings: np.ndarray
    points: np.ndarray
    normals: np.ndarray
    bends: np.ndarray
    stretches: _Stretches
    fine: np.ndarray

    @classmethod
    def of(cls, curve: Curve, low: float, high: float, count: int) -> _CurveSamples:
        """So many samples at even distances along the curve, more for ripples, and what shows its features besides."""
        resolving = _resolving(curve, low, high)
        parameters, fine = curve.even(low, high, max(count, resolving)), np.zeros(0)
        if resolving > count:
            fine = parameters[1:-1]
        elif curve.features:
            # All but the two ends that it begins with.
            fine = curve.features.places(low, high)[1:-1]
            parameters = union(parameters, fine)
        parameters = parameters[np.isfinite(curve.point(parameters)).all(axis=0)]
        gaps = np.diff(parameters)
        widths = np.maximum(np.append(gaps, gaps[-1]), np.insert(gaps, 0, gaps[0]))
        if curve.period:  # the two ends are one point
            parameters, widths = parameters[:-1], widths[:-1]
        points, normals, bends, speeds = _course(curve, parameters)
        fine_samples = np.searchsorted(parameters, fine)
        return cls(parameters, widths, widths * speeds, points, normals, bends, _Stretches.of(points), fine_samples)

    def off(self, there: np.ndarray, places: np.ndarray) -> np.ndarray:
        """How far (m, positive on the left) the points (m, 2) are off the curve near those samples."""
        return _off(there - self.points[places], self.normals[places], self.bends[places])


def _resolving(curve: Curve, low: float, high: float) -> int:
    """The number of even samples that resolve features of one scale; 0 if there are several scales."""
    intervals = curve.features.intervals_of_one_scale(low, high) if curve.features else 0
    return min(MOST, intervals + 1) if intervals else 0


def _course(curve: Curve, parameters: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Points (n, 2), left normals (n, 2), curvatures (n,) and speeds (n,) of a curve."""
    _, _, xp, yp, xs, ys, _, _ = jets = curve.jets(parameters)
    speed = np.hypot(xp, yp)
    return jets[:2].T, np.column_stack([-yp, xp]) / speed[:, None], (xp * ys - yp * xs) / speed**3, speed


def _off(from_point: np.ndarray, normals: np.ndarray, bends: np.ndarray) -> np.ndarray:
    """The distances of places, seen from points of a curve (m, 2), from the circles that osculate it there, m, positive
    on its left.

    A sample may be half a sample's distance from the nearest point, so distances along its normal are too small by that
    times the angle between the normals.
    """
    (nx, ny), (dx, dy) = normals.T, from_point.T
    twice = 2.0 * (dx * nx + dy * ny) - bends * (dx * dx + dy * dy)
    return twice / (1.0 + np.sqrt(np.maximum(1.0 - bends * twice, 0.0)))


class _Guess(NamedTuple):
    """A pair of samples of track and outline, how far they are apart along the track's normal (m), and how far the next
    samples are: in the two parameters, and both together in m."""

    xi1: float
    xi2: float
    apart: float
    width1: float
    width2: float
    spacing: float


def nearest(case: Case, x: float, y: float, theta: float) -> Contact | None:
    """The pair of points of outline and track with the smallest gap (m, signed), or None if the nearest points of the
    track are ends of it or lie on ends of an open outline, or if it is out of sight: there is nothing to land on.

    Raises DoesNotFit if there is such a pair and it is not found.
    """
    if max(abs(x), abs(y)) > FARTHEST or _out_of_sight(case, x, y):
        return None
    track, guess = _of_disc(case, x, y, theta) if case.plate.radius is not None else (None, None)
    if track is None or guess is None:
        track, guess = _of_outline(case, x, y, theta)
    poking = _poking(case, track, x, y, theta)
    if poking is not None and (guess is None or poking.apart < guess.apart):
        guess = poking
    if guess is None:
        return None
    nearer: list[Contact] = []
    for _ in range(ROUNDS):
        pair, is_neighbour = _pair_from(case, x, y, theta, guess)
        if pair is not None and is_neighbour:
            if _at_an_end(case, pair):
                return None
            return min([pair, *nearer], key=_gap)
        if pair is not None and pair.gap <= guess.apart and not _at_an_end(case, pair):
            nearer.append(pair)
        if _at_an_end(case, guess):
            return None
        if guess.spacing <= LEVEL * _size(case.plate.outline):
            return min([Contact(*guess[:3]), *nearer], key=_gap)
        guess = _closer(case, x, y, theta, guess)
    raise DoesNotFit(f"the point of the track nearest to the pose ({x:.6g}, {y:.6g}), theta = {theta:.6g} is not found")


def _pair_from(case: Case, x: float, y: float, theta: float, guess: _Guess) -> tuple[Contact | None, bool]:
    """What Newton's method finds from a pair of samples, and whether that is the pair which they show; None if it finds
    none, or one far from them.

    The foot on ripples of samples of the outline is as far away as these are apart, and may be on another ripple.
    """
    try:
        contact = find(case, x, y, theta, guess[:2])
    except DoesNotFit:
        return None, False
    along, around = abs(contact.xi1 - guess.xi1), abs(contact.xi2 - guess.xi2)
    away = along * float(case.track.speed(guess.xi1))
    # A gap that differs by more than the samples are apart is another pair's, or that of no nearest pair at all.
    if abs(contact.gap - guess.apart) > guess.spacing or not around <= NEIGHBOURS * guess.width2:
        return None, False
    is_neighbour = along <= NEIGHBOURS * guess.width1
    return (contact, is_neighbour) if is_neighbour or away <= NEIGHBOURS * guess.spacing else (None, False)


def _gap(contact: Contact) -> float:
    return contact.gap


def _closer(case: Case, x: float, y: float, theta: float, guess: _Guess) -> _Guess:
    """The nearest pair among closer samples around a pair; as far apart as before where it lies at their edge."""
    track, outline = case.track, case.plate.outline
    xi1, xi2 = _window(track, guess.xi1, guess.width1), _window(outline, guess.xi2, guess.width2)
    c, s = cos(theta), sin(theta)
    u, v = outline.point(xi2)
    there = np.column_stack([x + c * u - s * v, y + s * u + c * v])
    points, normals, bends, _ = _course(track, xi1)
    feet = _squares(there[:, None], points[None]).argmin(axis=1)
    apart = _off(there - points[feet], normals[feet], bends[feet])
    best = int(np.argmin(apart))
    foot = int(feet[best])
    inside = 0 < best < len(xi2) - 1 and 0 < foot < len(xi1) - 1
    inside = inside or bool(apart[best] >= guess.apart - ROUNDING * (abs(x) + abs(y) + _size(outline)))
    widths = (width / CLOSER if inside else width for width in guess[3:])
    return _Guess(float(xi1[foot]), float(xi2[best]), float(apart[best]), *widths)


def _window(curve: Curve, middle: float, width: float) -> np.ndarray:
    """Parameters around one, as far as the curve goes."""
    count = int(2 * WINDOW * CLOSER) + 1
    low, high = middle - WINDOW * width, middle + WINDOW * width
    if curve.domain is not None and not curve.period:
        low, high = max(low, curve.domain[0]), min(high, curve.domain[1])
    return np.linspace(low, high, count)


def _at_an_end(case: Case, pair: Contact | _Guess) -> bool:
    """Whether it lies at or beyond an end of track or outline."""
    return _ends(case.track, pair.xi1) or _ends(case.plate.outline, pair.xi2)


def _ends(curve: Curve, parameter: float) -> bool:
    domain = curve.domain
    return domain is not None and not curve.period and not domain[0] < parameter < domain[1]


def _out_of_sight(case: Case, x: float, y: float) -> bool:
    """Whether a closed track is so far away that it has no sides any more."""
    if not case.track.period:
        return False
    px, py = case.track.jet(0.0)[:2]
    return hypot(x - px, y - py) > SIGHT * (_size(case.track) + _size(case.plate.outline))


def _of_outline(case: Case, x: float, y: float, theta: float) -> tuple[_CurveSamples, _Guess | None]:
    """Samples of the track and the nearest pair with any outline; no pair if those of the track are ends of it."""
    outline = _outline(case.plate.outline)
    c, s = cos(theta), sin(theta)
    (u, v), (mu, mv, radius) = outline.points.T, _ball(case.plate.outline)
    there = np.column_stack([x + c * u - s * v, y + s * u + c * v])
    track, places, ends = _below(case, there, (x + c * mu - s * mv, y + s * mu + c * mv, radius))
    apart = track.off(there, places)
    # Past an end of the track, the gap along its normal means nothing.
    best = int(np.argmin(np.where(ends, inf, apart)))
    return track, None if ends[best] else _pair(track, int(places[best]), outline, best, float(apart[best]))


def _of_disc(case: Case, x: float, y: float, theta: float) -> tuple[_CurveSamples, _Guess | None]:
    """The same of a disc, which is as far from its track as its centre less its radius: one point is looked up and not
    all of its outline."""
    radius = case.plate.radius
    assert radius is not None
    track, places, ends = _below(case, np.array([[x, y]]), (x, y, 0.0))
    if ends[0]:
        return track, None
    place, outline = int(places[0]), _outline(case.plate.outline)
    (px, py), (nx, ny) = track.points[place].tolist(), track.normals[place].tolist()
    (u, v), c, s = outline.points.T, cos(theta), sin(theta)
    against = int(np.argmin((c * nx + s * ny) * u + (c * ny - s * nx) * v))
    dx, dy = x - px, y - py
    apart = copysign(hypot(dx, dy), dx * nx + dy * ny) - radius
    return track, _pair(track, place, outline, against, apart)


def _pair(track: _CurveSamples, place: int, outline: _CurveSamples, on_outline: int, apart: float) -> _Guess:
    return _Guess(
        float(track.parameters[place]),
        float(outline.parameters[on_outline]),
        apart,
        float(track.widths[place]),
        float(outline.widths[on_outline]),
        float(track.spacings[place] + outline.spacings[on_outline]),
    )


def _below(
    case: Case, there: np.ndarray, ball: tuple[float, float, float]
) -> tuple[_CurveSamples, np.ndarray, np.ndarray]:
    """Samples of the track, which of them are nearest to the points `there` (within that circle), and whether these
    are its ends."""
    curve, size = case.track, _size(case.plate.outline)
    endless = curve.domain is None and not curve.period
    low, high = _around(case, ball, size) if endless else curve.span
    for _ in range(DOUBLINGS):
        track = _track(curve, low, high, size)
        places = track.stretches.nearest(there, ball)
        last = len(track.parameters) - 1
        ends = np.zeros(len(places), dtype=bool) if curve.period else (places == 0) | (places == last)
        whole = not endless or (track.parameters[0] > low and track.parameters[-1] < high)
        if whole or not ends.any():
            break
        low, high = low - 0.5 * (high - low), high + 0.5 * (high - low)
    return track, places, ends


def _around(case: Case, ball: tuple[float, float, float], size: float) -> tuple[float, float]:
    """The stretch of a track without ends that is looked at first: some sizes of the plate to either side of the start,
    as many times doubled as the plate is farther away."""
    xi1, (x, y, _) = case.start.xi1, ball
    X, Y, Xp, Yp = case.track.jet(xi1)[:4]
    away = hypot(x - X, y - Y) / (AROUND * size)
    margin = AROUND * size / hypot(Xp, Yp) * 2.0 ** ceil(log2(max(2.0 * away, 1.0)))
    return xi1 - margin, xi1 + margin


def _poking(case: Case, track: _CurveSamples, x: float, y: float, theta: float) -> _Guess | None:
    """The pair with the smallest gap among the points of the track's features, which may lie between two points of the
    outline; None if no feature is near."""
    if not len(track.fine) or not case.plate.outline.period:
        return None
    outline = _outline(case.plate.outline)
    c, s = cos(theta), sin(theta)
    u, v = track.points[track.fine, 0] - x, track.points[track.fine, 1] - y
    points_in_plate = np.column_stack([c * u + s * v, c * v - s * u])
    near = np.flatnonzero(np.hypot(*points_in_plate.T) <= 1.5 * case.plate.outline.sizes[0])
    if near.size > MANY:
        near = _lowest_blocks(points_in_plate, near, outline)
    if not near.size:
        return None
    places = outline.stretches.nearest(points_in_plate[near])
    apart = -outline.off(points_in_plate[near], places)
    best = int(np.argmin(apart))
    return _pair(track, int(track.fine[near[best]]), outline, int(places[best]), float(apart[best]))


def _lowest_blocks(points: np.ndarray, near: np.ndarray, outline: _CurveSamples) -> np.ndarray:
    """Which of the samples `near` of the track may be the nearest to an outline: blocks of them whose first is farther
    from it than another by more than a block's length are left out."""
    blocks = near[: len(near) // BLOCK * BLOCK].reshape(-1, BLOCK)
    firsts = points[blocks[:, 0]]
    lengths = np.hypot(*(points[blocks] - firsts[:, None]).transpose(2, 0, 1)).max(axis=1)
    apart = -outline.off(firsts, outline.stretches.nearest(firsts))
    rest = near[len(near) // BLOCK * BLOCK :]
    return np.append(blocks[apart - lengths <= apart.min()].ravel(), rest)


@lru_cache(maxsize=64)
def _outline(outline: Curve) -> _CurveSamples:
    return _CurveSamples.of(outline, *outline.span, OUTLINE_POINTS + 1)


@lru_cache(maxsize=64)
def _ball(outline: Curve) -> tuple[float, float, float]:
    """The middle and the radius of a circle around the outline, m."""
    points = _outline(outline).points
    middle = points.mean(axis=0)
    return (*middle.tolist(), float(np.sqrt(_squares(points, middle).max())))


@lru_cache(maxsize=64)
def _size(outline: Curve) -> float:
    """The largest extent of the outline, m."""
    return float(np.ptp(outline.point(np.linspace(*outline.span, 65)), axis=1).max())


@lru_cache(maxsize=64)
def _track(track: Curve, low: float, high: float, size: float) -> _CurveSamples:
    length = track.length(low, high)
    return _CurveSamples.of(track, low, high, int(min(MOST, max(720, POINTS_A_SIZE * length / size))))
