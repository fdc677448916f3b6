"""Recognise lines and circles, for solvers with such shapes and without general curves."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .chain import Chain
from .curves import Curve


class Line(NamedTuple):
    """A straight line: its point at parameter zero of the span, and its unit direction of increasing parameter."""

    point: np.ndarray
    direction: np.ndarray


class Circle(NamedTuple):
    """A circle: centre, radius, and whether it bends to its left (a plate on its left is then inside it)."""

    centre: np.ndarray
    radius: float
    left: bool


# Seventeen samples decide: a curve that agrees with a line or a circle there in position and direction, to the
# rounding of its own sizes, is one for any solver's purpose.
_SAMPLES, _ROUNDING = 17, 1e-12


def as_line(curve: Curve) -> Line | None:
    """The curve as a line, or None if it is none."""
    if isinstance(curve, Chain):
        return None
    s = np.linspace(*curve.span, _SAMPLES)
    tangents = curve.tangent(s)
    if np.abs(tangents - tangents[:, :1]).max() > _ROUNDING:
        return None
    return Line(curve.point(float(s[0])), tangents[:, 0])


def as_circle(curve: Curve) -> Circle | None:
    """The curve as a circle (or an arc of one), or None if it is none."""
    if isinstance(curve, Chain):
        return None
    s = np.linspace(*curve.span, _SAMPLES)
    bend = curve.curvature(s)
    if bend[0] == 0.0 or np.ptp(bend) > _ROUNDING * abs(bend[0]):
        return None
    centres = curve.point(s) + curve.normal(s) / bend
    if np.ptp(centres, axis=1).max() > _ROUNDING * np.abs(1 / bend[0]) * 10:
        return None
    return Circle(centres.mean(axis=1), float(abs(1 / bend.mean())), bool(bend[0] > 0))
