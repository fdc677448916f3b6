"""The rigid plate: its outline, mass and inertia, and derived sizes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import sqrt
from typing import NamedTuple

import numpy as np

from .curves import Curve
from .errors import BadCurve, BadValue, positive
from .library import circle


@dataclass(frozen=True, repr=False)
class Plate:
    """A rigid plate: its outline in its own frame, whose origin is the centre of mass; mass in kg, inertia in kg m².

    The outline runs counter-clockwise around the plate (BadCurve if it is closed and runs the other way).
    """

    outline: Curve
    mass: float
    inertia: float

    def __post_init__(self):
        if not isinstance(self.outline, Curve):
            raise BadValue(f"the outline is {self.outline!r}; give a Curve")
        object.__setattr__(self, "mass", positive("mass of the plate", self.mass))
        object.__setattr__(self, "inertia", positive("inertia of the plate", self.inertia))
        if _runs_clockwise(self.outline):
            raise BadCurve("the outline runs clockwise; reverse its parameter so that the plate is on its left")

    def __repr__(self) -> str:
        shape = f"radius={self.radius:.6g}" if self.radius else repr(self.outline)
        return f"{'disc' if self.radius else 'Plate'}({shape}, mass={self.mass:.6g}, inertia={self.inertia:.6g})"

    @property
    def gyration(self) -> float:
        """Radius of gyration about the centre of mass, m."""
        return sqrt(self.inertia / self.mass)

    @property
    def inner(self) -> float:
        """The smallest distance of the outline from the centre of mass, m."""
        return _sizes(self.outline).inner

    @property
    def reach(self) -> float:
        """The largest distance of the outline from the centre of mass, m."""
        return _sizes(self.outline).reach

    @property
    def width(self) -> float:
        """The larger side of the box about the outline, m."""
        return _sizes(self.outline).width

    @property
    def radius(self) -> float | None:
        """Radius in metres if the outline is a circle about the centre of mass, else None."""
        return _sizes(self.outline).radius


@lru_cache(maxsize=256)
def _runs_clockwise(outline: Curve) -> bool:
    low, high = outline.span
    return bool(outline.period and outline.tangent_angle(high) < outline.tangent_angle(low))


class _Sizes(NamedTuple):
    inner: float
    reach: float
    width: float
    radius: float | None


@lru_cache(maxsize=256)
def _sizes(outline: Curve) -> _Sizes:
    """The sizes of a plate that depend only on its outline, about the outline's origin."""
    # Half a degree apart; distances are stationary at their extremes, so the error is about 1e-5.
    points = outline.point(np.linspace(*outline.span, 721))
    away = np.hypot(*points)
    return _Sizes(float(away.min()), float(away.max()), float(np.ptp(points, axis=1).max()), _radius(outline))


def _radius(outline: Curve) -> float | None:
    s = np.linspace(*outline.span, 17)
    r = np.hypot(*outline.point(s))
    bend = outline.curvature(s)
    # Rounding of a handful of operations; a real outline that round is a disc for every purpose here.
    round_enough = np.ptp(r) <= 1e-13 * r.max() and np.all(np.abs(bend * r - 1.0) <= 1e-12)
    return float(r.mean()) if round_enough and outline.period else None


def disc(radius: float, mass: float, inertia: float | None = None) -> Plate:
    """A disc about its centre of mass; inertia ½ m r² (homogeneous) if none is given."""
    radius, mass = positive("radius of the disc", radius), positive("mass of the disc", mass)
    return Plate(circle(radius), mass, 0.5 * mass * radius * radius if inertia is None else inertia)
