"""Where a plate off its track is nearest to it, over the whole of both curves: what a landing is looked for with."""

from __future__ import annotations

from functools import lru_cache
from math import cos, hypot, inf, sin
from typing import NamedTuple

import numpy as np

from .case import Case
from .contact import Contact, find
from .curves import Curve
from .errors import DoesNotFit

# Points of the outline that are looked at: closer than the curvature of any smooth outline is likely to hide a nearer
# one between two of them, and Newton's method goes on from the nearest.
OUTLINE_POINTS = 128
# Points of the track to a size of the plate.
POINTS_A_SIZE = 24
# Where no track is any more, m: squares of distances overflow there.
FARTHEST = 1e150
# From so many times a closed track's size away it is a point: which of its points is the nearest drowns in rounding.
SEEN = 1e12
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
        filled = np.minimum(np.arange(-(-len(points) // length) * length), len(points) - 1)
        stretches = points[filled].reshape(-1, length, 2)
        centres = stretches.mean(axis=1)
        return cls(stretches, centres, np.sqrt(_squares(stretches, centres[:, None]).max(axis=1)))

    def nearest(self, there: np.ndarray) -> np.ndarray:
        """Which sample is the nearest to each of the points (m, 2), the first of equal ones.

        Stretches are looked into unless they begin farther away than another ends, whichever of the points one asks.
        """
        middle = there.mean(axis=0)
        spread = 2.0 * float(np.sqrt(_squares(there, middle).max()))
        away = np.sqrt(_squares(middle, self.centres))
        some = np.flatnonzero(away - self.radii <= ((away + self.radii).min() + spread) * (1.0 + ROUNDING))
        found = _squares(self.points[some].reshape(-1, 2), there[:, None]).argmin(axis=1)
        length = self.points.shape[1]
        return some[found // length] * length + found % length


def _squares(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Squares of distances of points whose coordinates stand last, m²."""
    x, y = a[..., 0] - b[..., 0], a[..., 1] - b[..., 1]
    return x * x + y * y


class _Track(NamedTuple):
    """Samples of a track: parameters, points (n, 2), left normals (n, 2), the same in stretches to look points up in,
    and which of them show features."""

    parameters: np.ndarray
    points: np.ndarray
    normals: np.ndarray
    stretches: _Stretches
    fine: np.ndarray


class _Guess(NamedTuple):
    """A pair of samples of track and outline and how far they are apart along the track's normal, m."""

    xi1: float
    xi2: float
    apart: float


def nearest(case: Case, x: float, y: float, theta: float) -> Contact | None:
    """The pair of points of outline and track with the smallest gap (m, signed), or None if the nearest points of the
    track are ends of it or lie on ends of an open outline, or if it is out of sight: there is nothing to land on."""
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
    try:
        contact = find(case, x, y, theta, guess[:2])
    except DoesNotFit:
        return Contact(*guess)
    if _outside(case.track, contact.xi1) or _outside(case.plate.outline, contact.xi2):
        return None
    # Newton's method may run to another pair, farther away; then the samples know better. Beside features it may also
    # run to one that is no nearest pair at all.
    off = contact.gap - guess.apart
    wrong = (abs(off) if len(track.fine) else off) > _size(case.plate.outline) / POINTS_A_SIZE
    return Contact(*guess) if wrong else contact


def _out_of_sight(case: Case, x: float, y: float) -> bool:
    """Whether a closed track is so far away that it has no sides any more."""
    if not case.track.period:
        return False
    px, py = case.track.jet(0.0)[:2]
    return hypot(x - px, y - py) > SEEN * (_size(case.track) + _size(case.plate.outline))


def _of_outline(case: Case, x: float, y: float, theta: float) -> tuple[_Track, _Guess | None]:
    """Samples of the track and the nearest pair with any outline; no pair if those of the track are ends of it."""
    parameters, points, _, _ = _outline(case.plate.outline)
    c, s = cos(theta), sin(theta)
    there = np.column_stack([x + c * points[0] - s * points[1], y + s * points[0] + c * points[1]])
    track, places, ends = _below(case, there)
    apart = np.einsum("ij,ij->i", there - track.points[places], track.normals[places])
    # Past an end of the track, the gap along its normal means nothing.
    best = int(np.argmin(np.where(ends, inf, apart)))
    if ends[best]:
        return track, None
    return track, _Guess(float(track.parameters[places[best]]), float(parameters[best]), float(apart[best]))


def _of_disc(case: Case, x: float, y: float, theta: float) -> tuple[_Track, _Guess | None]:
    """The same of a disc, which is as far from its track as its centre less its radius: one point is looked up and not
    all of its outline."""
    radius = case.plate.radius
    assert radius is not None
    track, places, ends = _below(case, np.array([[x, y]]))
    if ends[0]:
        return track, None
    (px, py), (nx, ny) = track.points[places[0]].tolist(), track.normals[places[0]].tolist()
    parameters, points, _, _ = _outline(case.plate.outline)
    c, s = cos(theta), sin(theta)
    against = int(np.argmin((c * nx + s * ny) * points[0] + (c * ny - s * nx) * points[1]))
    apart = (x - px) * nx + (y - py) * ny - radius
    return track, _Guess(float(track.parameters[places[0]]), float(parameters[against]), apart)


def _below(case: Case, there: np.ndarray) -> tuple[_Track, np.ndarray, np.ndarray]:
    """Samples of the track, which of them are nearest to the points `there`, and whether these are its ends."""
    low, high = case.track.span
    while True:
        track = _track(case.track, low, high, _size(case.plate.outline))
        places = track.stretches.nearest(there)
        ends = np.zeros(len(places), dtype=bool)
        if not case.track.period:
            ends = (places == 0) | (places == len(track.parameters) - 1)
        if not ends.any() or case.track.domain is not None or high - low > 1e6:
            return track, places, ends
        low, high = 2 * low, 2 * high  # a track without ends is looked at as far as the plate has come


def _poking(case: Case, track: _Track, x: float, y: float, theta: float) -> _Guess | None:
    """The pair with the smallest gap among the points of the track's features, which may lie between two points of the
    outline; None if no feature is near."""
    if not len(track.fine) or not case.plate.outline.period:
        return None
    parameters, points, normals, stretches = _outline(case.plate.outline)
    c, s = cos(theta), sin(theta)
    u, v = track.points[track.fine, 0] - x, track.points[track.fine, 1] - y
    seen = np.column_stack([c * u + s * v, c * v - s * u])
    near = np.flatnonzero(np.hypot(*seen.T) <= 1.5 * float(np.hypot(*points).max()))
    if not near.size:
        return None
    places = stretches.nearest(seen[near])
    apart = np.einsum("ij,ij->i", points.T[places] - seen[near], normals[places])
    best = int(np.argmin(apart))
    return _Guess(float(track.parameters[track.fine[near[best]]]), float(parameters[places[best]]), float(apart[best]))


def _outside(curve: Curve, parameter: float) -> bool:
    return curve.period is None and curve.domain is not None and not curve.domain[0] <= parameter <= curve.domain[1]


@lru_cache(maxsize=64)
def _outline(outline: Curve) -> tuple[np.ndarray, np.ndarray, np.ndarray, _Stretches]:
    """Samples of an outline: parameters (n,), points (2, n), left normals (n, 2), and the same in stretches."""
    parameters = np.linspace(*outline.span, OUTLINE_POINTS + 1)
    if outline.features:
        parameters = np.union1d(parameters, outline.features.places(*outline.span))
    parameters = parameters[:-1] if outline.period else parameters
    points = outline.point(parameters)
    return parameters, points, outline.normal(parameters).T, _Stretches.of(points.T)


@lru_cache(maxsize=64)
def _size(outline: Curve) -> float:
    """The largest extent of the outline, m."""
    return float(np.ptp(outline.point(np.linspace(*outline.span, 65)), axis=1).max())


@lru_cache(maxsize=64)
def _track(track: Curve, low: float, high: float, size: float) -> _Track:
    length = float(np.mean(track.speed(np.linspace(low, high, 65)))) * (high - low)
    # A hundred thousand points are looked up as quickly as a thousand; more take long to lay out.
    parameters = np.linspace(low, high, int(min(100_000, max(720, POINTS_A_SIZE * length / size))))
    fine = np.zeros(0)
    if track.features:
        # All but the two ends that it begins with.
        fine = track.features.places(low, high)[1:-1]
        parameters = np.union1d(parameters, fine)
    points = track.point(parameters).T
    shown = np.searchsorted(parameters, fine)
    return _Track(parameters, points, track.normal(parameters).T, _Stretches.of(points), shown)
