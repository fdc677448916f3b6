"""Recognise lines and circles, for solvers with such shapes and without general curves."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from . import Curve
from .chain import Chain


class Line(NamedTuple):
    """A straight line: its point at parameter zero of the span, and its unit direction of increasing parameter."""

    point: np.ndarray
    direction: np.ndarray


class Circle(NamedTuple):
    """A circle: centre, radius, and whether it bends to its left (a plate on its left is then inside it)."""

    centre: np.ndarray
    radius: float
    left: bool


# A curve that agrees with a line or a circle in position and direction at so many places, and at those that show its
# finest features, to the rounding of its own sizes, is one.
_SAMPLES, _ROUNDING = 17, 1e-12


def _places(curve: Curve) -> Iterator[np.ndarray]:
    yield np.linspace(*curve.span, _SAMPLES)
    if curve.features is not None:
        yield curve.features.nodes(*curve.span)


@lru_cache(maxsize=1024)
def as_line(curve: Curve) -> Line | None:
    """The curve as a line, or None if it is none."""
    if isinstance(curve, Chain):
        return None
    for s in _places(curve):
        tangents = curve.tangent(s)
        if np.abs(tangents - tangents[:, :1]).max() > _ROUNDING:
            return None
    return Line(curve.point(curve.span[0]), curve.tangent(curve.span[0]))


@lru_cache(maxsize=1024)
def as_circle(curve: Curve) -> Circle | None:
    """The curve as a circle (or an arc of one), or None if it is none."""
    if isinstance(curve, Chain):
        return None
    for s in _places(curve):
        bend = curve.curvature(s)
        if bend[0] == 0.0 or np.ptp(bend) > _ROUNDING * abs(bend[0]):
            return None
    s = next(_places(curve))
    bend = curve.curvature(s)
    centres = curve.point(s) + curve.normal(s) / bend
    if np.ptp(centres, axis=1).max() > _ROUNDING * np.abs(1 / bend[0]) * 10:
        return None
    return Circle(centres.mean(axis=1), float(abs(1 / bend.mean())), bool(bend[0] > 0))
