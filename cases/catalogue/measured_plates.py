"""A plate whose outline is known as points only."""

from functools import lru_cache
from pathlib import Path

from cases import Curve, Plate, case
from cases.catalogue.common_scenes import case_on_track
from cases.library import line

# How far the file's points may be from the outline, m: their last digit is 0.1 mm.
DIGITS = 2e-4


@lru_cache(maxsize=8)
def _homogeneous(path: Path, mass: float) -> Plate:
    """A homogeneous plate with the outline that fits the file's points, moved to its centre of mass."""
    return Plate.homogeneous(Curve.spline(path, smoothing=DIGITS, closed=True), mass)


@case
def pebble_on_incline(mu=0.1, slope=0.15, omega=-4.0, m=1.0, g=9.81, duration=1.0):
    """A pebble thrown down an incline, its outline a spline along 36 points of a file.

    Why: what a user with a measured shape needs; the spline has every derivative the equations ask for, and reports the
    largest distance of a point (`plate.outline.residual`).
    Source: this suite; the points are made to look measured, in pebble.csv in the same folder.
    """
    plate = _homogeneous(Path(__file__).with_name("pebble.csv"), m)
    return case_on_track(line(slope), plate, mu, g, duration, xi2=0.75 * plate.outline.span[1], omega=omega)
