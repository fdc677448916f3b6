"""The track divided into stretches at its features, with bounds on their curvature, for the second formulation."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cases import Curve

from .curve_bounds import CurveBounds


class Stretches(NamedTuple):
    """n stretches: the parameter's range; the middle's parameter, place and unit tangent; half the length at most (m);
    the largest absolute curvature, and the largest towards the plate (1/m)."""

    low: np.ndarray
    high: np.ndarray
    middle: np.ndarray
    x: np.ndarray
    y: np.ndarray
    tx: np.ndarray
    ty: np.ndarray
    half: np.ndarray
    bend: np.ndarray
    valley: np.ndarray

    @property
    def number(self) -> int:
        return len(self.low)

    def some(self, which: np.ndarray) -> Stretches:
        return Stretches(*(column[which] for column in self))

    def join(self, other: Stretches) -> Stretches:
        return Stretches(*(np.concatenate(pair) for pair in zip(self, other, strict=True)))


def between(track: CurveBounds, low: np.ndarray, high: np.ndarray) -> Stretches:
    """The stretches of a track between parameters."""
    middle, bounds = 0.5 * (low + high), track.extremes(low, high)
    x, y, xp, yp = track.curve.jets(middle)[:4]
    speed = np.hypot(xp, yp)
    return Stretches(
        low, high, middle, x, y, xp / speed, yp / speed, 0.5 * (high - low) * bounds.speed,
        np.maximum(bounds.most, -bounds.least), bounds.most,
    )  # fmt: skip


def parts(track: CurveBounds, some: Stretches, count: int) -> Stretches:
    """Each stretch in so many equal parts: the first ones, then the second ones, and so on."""
    edges = np.linspace(some.low, some.high, count + 1)
    return between(track, edges[:-1].ravel(), edges[1:].ravel())


def cut(track: CurveBounds, some: Stretches, ends: tuple[float, float]) -> Stretches:
    """The stretches, divided at both ends of a parameter range."""
    for end in ends:
        across = (some.low < end) & (end < some.high)
        if across.any():
            old, at = some.some(across), np.full(int(across.sum()), end)
            parts = between(track, np.concatenate([old.low, at]), np.concatenate([at, old.high]))
            some = some.some(~across).join(parts)
    return some


def evenly(curve: Curve, low: float, high: float, count: int) -> tuple[np.ndarray, float]:
    """Parameters at nearly even distances along a curve, and its length."""
    grid = np.linspace(low, high, 2049)
    speed = np.asarray(curve.speed(grid)) * np.ones_like(grid)
    length = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(grid))])
    return np.interp(np.linspace(0.0, length[-1], count), length, grid), float(length[-1])
