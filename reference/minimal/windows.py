"""A motion in short windows of time: the plate's pose in each as polynomials, with bounds on its changes."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from ..scales import EPS

# Polynomials of this degree go through a window.
DEGREE = 16
# A window whose last coefficients are larger than this part of the largest is halved, at most HALVINGS times.
TAIL_PART, HALVINGS = 1e-13, 8
# Roundings of a place computed from some coefficients.
ROUNDINGS = 16

Poses = Callable[[np.ndarray], np.ndarray]


class Windows(NamedTuple):
    """n windows: start and end (s), the polynomials of x, y, θ, shape (n, 3, degree + 1), those of their rates, and
    bounds: on speed (m/s) and spin (rad/s), on their rates (m/s², rad/s²), and on the polynomials' error (m)."""

    start: np.ndarray
    end: np.ndarray
    places: np.ndarray
    rates: np.ndarray
    speed: np.ndarray
    spin: np.ndarray
    pull: np.ndarray
    swing: np.ndarray
    error: np.ndarray

    def at(self, which: np.ndarray, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(x, y, θ) and (vx, vy, ω) at one time in each of the windows `which`, each of shape (3, m)."""
        start, end = self.start[which], self.end[which]
        z = (2.0 * times - start - end) / (end - start)
        return _values(self.places[which], z), _values(self.rates[which], z)


def windows(poses: Poses, edges: np.ndarray, size: float) -> Windows:
    """The windows between the times `edges`, halved where the polynomials are not accurate. `poses` maps times (m,) to
    (x, y, θ), shape (3, m); `size` (m) is the plate's, by which a turn moves its points."""
    start, end = edges[:-1], edges[1:]
    places = _fit(poses, start, end)
    for _ in range(HALVINGS):
        coarse = (_tail(places) > TAIL_PART * _scale(places, size)).any(axis=1)
        if not coarse.any():
            break
        middle = 0.5 * (start[coarse] + end[coarse])
        halves = np.concatenate([start[coarse], middle]), np.concatenate([middle, end[coarse]])
        new_places = _fit(poses, *halves)
        start, end, places = (
            np.concatenate([old[~coarse], new])
            for old, new in zip((start, end, places), (*halves, new_places), strict=True)
        )
    order = np.argsort(start)
    start, end, places = start[order], end[order], places[order]
    tail, scale = _tail(places), _scale(places, size)
    error = np.max((tail + ROUNDINGS * EPS * scale) * np.array([1.0, 1.0, size]), axis=1)
    places = places[:, :, : _count_terms(places)]
    per_second = 2.0 / (end - start)[:, None, None]
    rates = derivative(places) * per_second
    changes = np.abs(derivative(rates) * per_second).sum(axis=2)
    most = np.abs(rates).sum(axis=2)
    return Windows(
        start, end, places, rates, np.hypot(most[:, 0], most[:, 1]), most[:, 2],
        np.hypot(changes[:, 0], changes[:, 1]), changes[:, 2], error,
    )  # fmt: skip


def derivative(coefficients: np.ndarray) -> np.ndarray:
    """Chebyshev coefficients of the derivatives of polynomials, along the last axis."""
    return coefficients @ _derivatives(coefficients.shape[-1])


@lru_cache(maxsize=64)
def _derivatives(count: int) -> np.ndarray:
    return chebyshev.chebder(np.eye(count), axis=1)


def _fit(poses: Poses, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Chebyshev coefficients of x, y, θ, shape (n, 3, DEGREE + 1)."""
    nodes, to_coefficients = _nodes()
    times = 0.5 * (start + end)[:, None] + 0.5 * (end - start)[:, None] * nodes
    values = poses(times.ravel()).reshape(3, len(start), len(nodes))
    return (values @ to_coefficients.T).transpose(1, 0, 2)


@lru_cache(maxsize=1)
def _nodes() -> tuple[np.ndarray, np.ndarray]:
    """Chebyshev's nodes and the matrix from values there to coefficients."""
    nodes = chebyshev.chebpts1(DEGREE + 1)
    return nodes, np.linalg.inv(chebyshev.chebvander(nodes, DEGREE))


def _tail(places: np.ndarray) -> np.ndarray:
    """The last two coefficients' size, (n, 3)."""
    return np.abs(places[:, :, -2:]).sum(axis=2)


def _scale(places: np.ndarray, size: float) -> np.ndarray:
    """The sizes by which places and angle are rounded, (n, 3)."""
    rows = np.abs(places).sum(axis=2)
    far = rows[:, 0] + rows[:, 1] + size
    return np.array([far, far, 1.0 + rows[:, 2]]).T


def _count_terms(places: np.ndarray) -> int:
    """The number of coefficients that exceed rounding in any window, at least two."""
    large = np.abs(places) > 0.1 * EPS * np.abs(places).sum(axis=2)[:, :, None]
    return max(2, int(np.flatnonzero(large.any(axis=(0, 1)))[-1]) + 1) if large.any() else 2


def _values(coefficients: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Clenshaw's recurrence, one polynomial for each z: coefficients (m, 3, k), z (m,), values (3, m)."""
    parts = coefficients.transpose(2, 1, 0)
    if len(parts) == 1:
        return parts[0] + 0.0 * z
    b1, b2 = parts[-1], np.zeros_like(parts[0])
    twice = 2.0 * z
    for part in parts[-2:0:-1]:
        b1, b2 = part + twice * b1 - b2, b1
    return parts[0] + z * b1 - b2
