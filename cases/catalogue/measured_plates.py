"""A plate whose outline is known as points only."""

from functools import lru_cache
from math import pi
from pathlib import Path

import numpy as np

from cases import Case, CoulombFriction, Curve, Gravity, Plate, Start, Unilateral, case
from cases.library import line


@lru_cache(maxsize=8)
def _homogeneous(path: Path, mass: float) -> Plate:
    """A homogeneous plate with the outline that fits the file's points, moved to its centre of mass."""
    outline = Curve.from_csv(path, closed=True)
    # Green's theorem on 4096 points of a periodic curve: the trapezium rule converges faster than any power.
    x, y, xp, yp = outline.jets(2 * pi * np.arange(4096) / 4096)[:4]
    step = 2 * pi / 4096
    area = step * np.sum(x * yp - y * xp) / 2
    cx, cy = step * np.sum(x * x * yp) / (2 * area), -step * np.sum(y * y * xp) / (2 * area)
    about_origin = step * np.sum(x**3 * yp - y**3 * xp) / 3
    inertia = mass * (about_origin / area - cx**2 - cy**2)
    X, Y = outline.expression
    return Plate(Curve(lambda s: (X - float(cx), Y - float(cy)), residual=outline.residual), mass, float(inertia))


@case
def pebble_on_incline(mu=0.1, slope=0.15, omega=-4.0, m=1.0, g=9.81, duration=1.0):
    """A pebble thrown down an incline, its outline a fit through 36 points of a file.

    Why: what a user with a measured shape needs; the fit has every derivative the equations ask for, and tells its own
    residual (`plate.outline.residual`).
    Source: this suite; the points are made to look measured, in pebble.csv beside this file.
    """
    return Case(
        track=line(slope),
        plate=_homogeneous(Path(__file__).with_name("pebble.csv"), m),
        effects=(Gravity(g), CoulombFriction(mu), Unilateral()),
        start=Start(xi1=0.0, xi2=-pi / 2, omega=omega),
        duration=duration,
    )
