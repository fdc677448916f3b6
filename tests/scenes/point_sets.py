"""Points of curves as users have them: exact and noisy, coarse and fine, open and closed, of instruments and drawings.

Twelve shapes, each measured in four ways: 48 sets. The shapes are formulas, so that the distance of a curve from what
was measured is known.
"""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np


class PointSet(NamedTuple):
    """Points (n, 2), m, with the tolerance of their errors (m, 0 for exact points); `shape` gives the true curve at
    parameters from 0 to 1."""

    name: str
    points: np.ndarray
    tolerance: float
    closed: bool
    shape: Callable[[np.ndarray], np.ndarray]

    @property
    def extent(self) -> float:
        """The larger side of the box around the points, m."""
        return float(np.ptp(self.points, axis=0).max())


def graph(low: float, high: float, height: Callable) -> Callable:
    """A graph y(x) between two x, m."""

    def shape(u):
        x = low + (high - low) * u
        return np.array([x, height(x)])

    return shape


def polar(radius: Callable, turns: float = 1.0) -> Callable:
    """A radius over the polar angle, m."""

    def shape(u):
        angle = 2 * np.pi * turns * u
        return radius(angle) * np.array([np.cos(angle), np.sin(angle)])

    return shape


def road(u):
    """A road of 400 m: three bends, in the plane of a map."""
    angle = 0.8 * np.sin(2 * np.pi * u) + 0.5 * np.sin(3 * np.pi * u)
    return np.array([400 * u, 40 * angle])


def coaster(u):
    """A lift hill, a drop and two camelbacks, 60 m long."""
    x = 60 * u
    return np.array(
        [
            x,
            14 * np.exp(-(((x - 12) / 6) ** 2))
            + 6 * np.exp(-(((x - 32) / 5) ** 2))
            + 3 * np.exp(-(((x - 48) / 4) ** 2)),
        ]
    )


OPEN = {
    "parabola": graph(-1, 1, lambda x: 0.6 * x**2),
    "cosine valley": graph(-3, 3, lambda x: -0.3 * np.cos(2 * x)),
    "valley with a bump": graph(-1, 1, lambda x: 0.6 * x**2 + 0.05 * np.exp(-(((x - 0.3) / 0.12) ** 2))),
    "hill": graph(-2, 2, lambda x: 0.7 * np.exp(-(x**2))),
    "ramp": graph(-2, 2, lambda x: 0.4 * (1 - np.tanh(2 * x))),
    "half-pipe": lambda u: np.array([1.5 * np.cos(np.pi * (1 + u)), np.sin(np.pi * (1 + u))]),
    "coaster": coaster,
    "road": road,
}
CLOSED = {
    "ellipse": lambda u: np.array([0.3 * np.cos(2 * np.pi * u), 0.2 * np.sin(2 * np.pi * u)]),
    "egg": polar(lambda a: 0.1 * (1 + 0.15 * np.cos(a))),
    "cam": polar(lambda a: 0.05 + 0.02 * np.exp(4 * (np.cos(a) - 1))),
    "bean": polar(lambda a: 0.2 * (1 + 0.3 * np.cos(2 * a) - 0.1 * np.sin(a))),
}


def point_sets() -> Iterator[PointSet]:
    """The 48 sets; the same in every run."""
    shapes = [(name, shape, False) for name, shape in OPEN.items()] + [
        (name, shape, True) for name, shape in CLOSED.items()
    ]
    for number, (name, shape, closed) in enumerate(shapes):
        rng = np.random.default_rng(number)

        def at(u, shape=shape):
            return shape(u).T

        def along(count, closed=closed):
            return np.linspace(0.0, 1.0, count, endpoint=not closed)

        size = float(np.ptp(at(along(200)), axis=0).max())
        yield PointSet(f"{name}, coarse", at(along(24)), 0.0, closed, shape)
        yield PointSet(f"{name}, fine", at(along(500)), 0.0, closed, shape)
        # An instrument: errors of a part in a thousand of the extent.
        noise = rng.normal(0.0, 1e-3 * size, (160, 2))
        yield PointSet(f"{name}, noisy", at(along(160)) + noise, 4e-3 * size, closed, shape)
        # A file: uneven places, rounded to four digits of the extent, some rows twice.
        uneven = np.sort((along(120) + rng.uniform(0.0, 0.4 / 120, 120)).clip(0.0, 1.0))
        digit = 10.0 ** np.floor(np.log10(size) - 3)
        rounded = np.round(at(uneven) / digit) * digit
        yield PointSet(
            f"{name}, of a file", np.repeat(rounded, 1 + (np.arange(120) % 17 == 0), axis=0), digit, closed, shape
        )
