"""Area, centre of mass and second moment of an area inside a closed curve, by Green's theorem."""

from __future__ import annotations

from functools import lru_cache
from math import fsum
from typing import NamedTuple

import numpy as np

from ..errors import BadCurve
from . import Curve
from .chain import Chain

# Points of Gauss's rule on each part of a curve, exact for polynomials of order 31; parts are halved until integrals
# change by less than ROUNDING, at most so many times.
POINTS, HALVINGS, ROUNDING = 16, 12, 4e-16
_PLACES, _WEIGHTS = np.polynomial.legendre.leggauss(POINTS)
# The integrals of a curve with a kink in a derivative no longer change by more than this, m²/m².
ENOUGH = 1e-12


class Area(NamedTuple):
    """Area (m²), centroid (m), and second polar moment about the centroid (m⁴) inside a closed curve."""

    area: float
    x: float
    y: float
    polar_moment: float


@lru_cache(maxsize=256)
def area_inside(outline: Curve) -> Area:
    """The area inside a closed counter-clockwise outline. Raises BadCurve for an open one."""
    if not outline.period:
        raise BadCurve("a homogeneous plate needs a closed outline; give one whose ends meet")
    pieces = outline.pieces if isinstance(outline, Chain) else (outline,)
    x0, x1, y0, y1 = _box(pieces)
    # About the centre of the box first, then about the centroid: no digits are lost to a distant origin.
    x, y = 0.5 * (x0 + x1), 0.5 * (y0 + y1)
    for _ in range(2):
        area, first_x, first_y, moment = _integrals(pieces, x, y)
        x, y = x + first_x / area, y + first_y / area
    return Area(area, float(x), float(y), moment - area * ((first_x / area) ** 2 + (first_y / area) ** 2))


def _box(pieces: tuple[Curve, ...]) -> tuple[float, float, float, float]:
    points = np.column_stack([piece.point(np.linspace(*piece.span, 65)) for piece in pieces])
    return points[0].min(), points[0].max(), points[1].min(), points[1].max()


def _integrals(pieces: tuple[Curve, ...], x: float, y: float) -> tuple[float, ...]:
    """Area, first moments and second polar moment about (x, y)."""
    rows = [_along(piece, x, y) for piece in pieces]
    area, first_x, first_y, moment = (fsum(column) for column in zip(*rows, strict=True))
    return area, first_x, first_y, moment


def _divide(edges: np.ndarray, parts: int) -> np.ndarray:
    """The edges, with each interval between two of them divided into equal parts."""
    inner = edges[:-1, None] + np.diff(edges)[:, None] * (np.arange(parts) / parts)
    return np.append(inner.ravel(), edges[-1])


def _along(piece: Curve, x: float, y: float) -> tuple[float, ...]:
    """The contributions of one piece to the four integrals around the area."""
    before: np.ndarray | None = None
    for halving in range(HALVINGS + 1):
        edges = _divide(np.array(piece.knots or piece.span), 2**halving)
        half = 0.5 * np.diff(edges)
        s = ((edges[:-1] + half)[:, None] + half[:, None] * _PLACES).ravel()
        weights = (half[:, None] * _WEIGHTS).ravel()
        u, v, du, dv, *_ = piece.jets(s)
        u, v = u - x, v - y
        turn, far = u * dv - v * du, np.hypot(u, v)
        # The divergence theorem for the fields (x, y)/2, x(x, y)/3, y(x, y)/3 and (x² + y²)(x, y)/4.
        terms = np.array([turn / 2, u * turn / 3, v * turn / 3, far**2 * turn / 4]) * weights
        values = np.array([fsum(row) for row in terms])
        # Where an edge passes through the middle all terms are rounding, of products of this size.
        spans = far * np.hypot(du, dv) * weights
        sizes = np.array([spans.sum(), (far * spans).sum(), (far * spans).sum(), (far**2 * spans).sum()])
        if before is not None and np.all(np.abs(values - before) <= ROUNDING * sizes):
            break
        change, before = np.inf if before is None else float(np.max(np.abs(values - before) / sizes)), values
    else:
        if not change <= ENOUGH:
            raise BadCurve("the area inside the outline does not converge; give a smoother formula")
    return tuple(float(value) for value in values)
