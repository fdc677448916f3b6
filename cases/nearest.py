"""Where a plate off its track is nearest to it, over the whole of both curves: what a landing is looked for with."""

from __future__ import annotations

from functools import lru_cache
from math import cos, inf, sin
from typing import NamedTuple

import numpy as np
from scipy.spatial import KDTree

from .case import Case
from .contact import Contact, find
from .curves import Curve
from .errors import DoesNotFit

# Points of the outline that are looked at: closer than the curvature of any smooth outline is likely to hide a nearer
# one between two of them, and Newton's method goes on from the nearest.
OUTLINE_POINTS = 128
# Points of the track to a size of the plate.
POINTS_A_SIZE = 24


class _Track(NamedTuple):
    """Samples of a track: parameters, points (n, 2), left normals (n, 2), and a tree to look points up in."""

    parameters: np.ndarray
    points: np.ndarray
    normals: np.ndarray
    tree: KDTree


def nearest(case: Case, x: float, y: float, theta: float) -> Contact | None:
    """The pair of points of outline and track with the smallest gap (m, signed), or None if the nearest points of the
    track are ends of it or lie on ends of an open outline: there is nothing to land on."""
    parameters, points = _outline(case.plate.outline)
    c, s = cos(theta), sin(theta)
    there = np.column_stack([x + c * points[0] - s * points[1], y + s * points[0] + c * points[1]])
    low, high = case.track.look
    while True:
        track = _track(case.track, low, high, _size(case.plate.outline))
        _, places = track.tree.query(there)
        apart = np.einsum("ij,ij->i", there - track.points[places], track.normals[places])
        # Past an end of the track, the gap along its normal means nothing.
        ends = (
            np.zeros(len(places), dtype=bool)
            if case.track.period
            else (places == 0) | (places == len(track.tree.data) - 1)
        )
        best = int(np.argmin(np.where(ends, inf, apart)))
        if not ends.any() or case.track.domain is not None or high - low > 1e6:
            break
        low, high = 2 * low, 2 * high  # a track without ends is looked at as far as the plate has come
    if ends[best]:
        return None
    guess = float(track.parameters[places[best]]), float(parameters[best])
    try:
        contact = find(case, x, y, theta, guess)
    except DoesNotFit:
        return Contact(*guess, float(apart[best]))
    if _outside(case.track, contact.xi1) or _outside(case.plate.outline, contact.xi2):
        return None
    # Newton's method may run to another pair, farther away; then the samples know better.
    return (
        contact
        if contact.gap <= apart[best] + _size(case.plate.outline) / POINTS_A_SIZE
        else Contact(*guess, float(apart[best]))
    )


def _outside(curve: Curve, parameter: float) -> bool:
    return curve.period is None and curve.domain is not None and not curve.domain[0] <= parameter <= curve.domain[1]


@lru_cache(maxsize=64)
def _outline(outline: Curve) -> tuple[np.ndarray, np.ndarray]:
    parameters = np.linspace(*outline.look, OUTLINE_POINTS + 1)[: OUTLINE_POINTS + (0 if outline.period else 1)]
    return parameters, outline.point(parameters)


@lru_cache(maxsize=64)
def _size(outline: Curve) -> float:
    """The largest extent of the outline, m."""
    return float(np.ptp(outline.point(np.linspace(*outline.look, 65)), axis=1).max())


@lru_cache(maxsize=64)
def _track(track: Curve, low: float, high: float, size: float) -> _Track:
    length = float(np.mean(track.speed(np.linspace(low, high, 65)))) * (high - low)
    # A hundred thousand points are looked up as quickly as a thousand; more take long to lay out.
    parameters = np.linspace(low, high, int(min(100_000, max(720, POINTS_A_SIZE * length / size))))
    points = track.point(parameters).T
    return _Track(parameters, points, track.normal(parameters).T, KDTree(points))
