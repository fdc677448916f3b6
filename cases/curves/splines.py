"""Splines through measured points: quintic, with four continuous derivatives, by SciPy's B-splines.

The parameter is the length of the chords between the points, in metres. Without smoothing the spline passes through
every point; with it, no point is farther from the curve than a given tolerance.
"""

from __future__ import annotations

import warnings
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ..derivation import in_one_thread
from ..errors import BadCurve, BadValue
from ..formulas import formula_symbols
from ..formulas import late_sympy as sp
from .jets import Structure
from .pieces import CurvePieces

# Curvatures need two derivatives, their rates a third: a quintic spline has one more that is continuous.
DEGREE = 5
# A smoothing spline is searched by halving its tolerance on the sum of squares, at most this many times: the last is
# 1e-12 of the first, which is interpolation for any measurement.
HALVINGS = 40
# Points closer together than this part of the curve's extent are one point: below the rounding of a file's digits.
SAME = 1e-12
# The chord from the last point of a closed curve to the first may be so many times the longest other one: a quarter of
# a circle that is left out shows from eight points on, and hands place points more evenly than that.
GAP = 2.0


class Spline(NamedTuple):
    """The pieces of a spline, and the largest distance from a point to it at the point's parameter (m)."""

    pieces: CurvePieces
    residual: float


def spline(points: np.ndarray, smoothing: float, closed: bool) -> Spline:
    """The quintic spline through points (n, 2) in order along the curve, or within `smoothing` (m) of each.

    A closed one may repeat its first point at the end. Raises BadValue for points that are no such array, BadCurve for
    a closed curve whose points leave a part of it out.
    """
    points = _check(points, closed)
    around = np.vstack([points, points[:1]]) if closed else points
    s = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(around, axis=0).T))])
    x, y = _smooth(s, around, smoothing, closed) if smoothing else _interpolate(s, around, closed)
    breaks = np.unique(x.x[(x.x >= s[0]) & (x.x <= s[-1])])
    rows = np.concatenate([_coefficients(x, breaks), _coefficients(y, breaks)], axis=1)
    off = np.hypot(x(s) - around[:, 0], y(s) - around[:, 1])
    ends = tuple(breaks.tolist())
    pieces = CurvePieces(
        ends, (_structure(DEGREE),), (0,) * (len(breaks) - 1), ends[:-1], tuple(map(tuple, rows.tolist())),
        order=DEGREE - 1, period=ends[-1] - ends[0] if closed else None,
    )  # fmt: skip
    return Spline(pieces, float(off.max()))


def _interpolate(s: np.ndarray, points: np.ndarray, closed: bool):
    """Piecewise polynomials of x and y through the points."""
    from scipy.interpolate import PPoly, make_interp_spline  # slow to import, and most scenes have formulas

    kind = "periodic" if closed else None
    return [PPoly.from_spline(make_interp_spline(s, column, k=DEGREE, bc_type=kind)) for column in points.T]


def _smooth(s: np.ndarray, points: np.ndarray, tolerance: float, closed: bool):
    """The same of the spline with few knots that misses no point by more than the tolerance (m)."""
    from scipy.interpolate import PPoly, splev, splprep

    squares = len(points) * tolerance**2
    for _ in range(HALVINGS):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that it could not reach a sum of squares: the next one is smaller
            (knots, (cx, cy), degree), _ = splprep(points.T, u=s, s=squares, k=DEGREE, per=int(closed))
        off = np.hypot(*(np.array(splev(s, (knots, (cx, cy), degree))) - points.T))
        if off.max() <= tolerance:
            return [PPoly.from_spline((knots, column, degree)) for column in (cx, cy)]
        squares *= 0.5
    return _interpolate(s, points, closed)


def _coefficients(polynomials, breaks: np.ndarray) -> np.ndarray:
    """The coefficients of each piece from the highest power down, by its distance from the knot before it: (n, 6)."""
    which = np.searchsorted(polynomials.x, breaks[:-1], side="right") - 1
    return polynomials.c[:, which].T


@lru_cache(maxsize=8)
@in_one_thread
def _structure(degree: int) -> Structure:
    """A pair of polynomials of s − q0, with a symbol for each coefficient."""
    names = [sp.Symbol(f"q{i}", real=True) for i in range(2 * degree + 3)]
    origin, *coefficients = names
    rows: list[sp.Expr] = []
    for some in (coefficients[: degree + 1], coefficients[degree + 1 :]):
        row: sp.Expr = some[0]
        for coefficient in some[1:]:
            row = row * (formula_symbols.PARAMETER - origin) + coefficient
        rows.append(row)
    return (rows[0], rows[1]), tuple(names)


def _check(points: np.ndarray, closed: bool) -> np.ndarray:
    """The points without repetitions of the one before; raises BadValue or BadCurve."""
    bad = ~np.isfinite(points).all(axis=1)
    if bad.any():
        raise BadValue(f"point {int(np.argmax(bad)) + 1} is not finite; leave it out")
    chords = np.hypot(*np.diff(points, axis=0).T)
    same = SAME * float(np.ptp(points, axis=0).max()) if len(points) else 0.0
    points = points[np.concatenate([np.ones(min(len(points), 1), dtype=bool), chords > same])]
    if closed and len(points) > 1 and np.hypot(*(points[0] - points[-1])) <= same:
        points = points[:-1]
    if len(points) < DEGREE + 1:
        raise BadValue(
            f"{len(points)} different points are not enough for a quintic spline; give at least {DEGREE + 1}"
        )
    chords = np.hypot(*np.diff(np.vstack([points, points[:1]]), axis=0).T)
    if closed and chords[-1] > GAP * chords[:-1].max():
        raise BadCurve(
            f"the last point is {chords[-1]:.3g} m from the first, {chords[-1] / chords[:-1].max():.2g} times as far "
            "as any two others: a part of the closed curve has no points; give points there, or closed=False"
        )
    return points
