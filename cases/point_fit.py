"""Curves through measured points, as one expression: a Fourier fit of a closed curve, a Chebyshev fit of an open one.

The parameter follows the chords' length, s from 0 to 2π (closed) or −1 to 1 (open). Both fits are smooth to every
order, so the third derivatives the paper needs exist and are finite.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import NamedTuple

import numpy as np
import sympy as sp

from . import user_files
from .errors import BadCurve, BadValue
from .expressions import PARAMETER, cos, sin

# More terms than this follow the noise of a measurement before its shape, and make the equations slow.
MOST_TERMS = 10
# Points missed by less than this part of the curve's size are met: about what a caliper reads off a hand-sized plate.
CLOSE_ENOUGH = 1e-3


# Bytes of a file of points: a hundred thousand of them.
LARGEST_FILE = 4 * 2**20

# The folder of the case file that is being read, from which its paths count; outside of one: where one works.
_folder: ContextVar[Path] = ContextVar("_folder", default=Path())


@contextmanager
def paths_count_from(folder: Path) -> Iterator[None]:
    """Inside, relative paths of points count from that folder."""
    before = _folder.set(folder)
    try:
        yield
    finally:
        _folder.reset(before)


# A heading names its columns; a first row with a typing error has a digit, a sign or nothing where a name begins.
_HEADING = re.compile(r"\s*[^\W\d_]")


class Fit(NamedTuple):
    """The expressions of X and Y, the parameter's domain, and the largest distance from a point to its fit (m)."""

    expression: tuple[sp.Expr, sp.Expr]
    domain: tuple[float, float] | None
    residual: float


def fit(points, closed: bool) -> Fit:
    """The fit with the fewest terms that misses no point by more than a thousandth of the curve's size.

    `points` has shape (n, 2), metres, in order along the curve; a closed one may repeat its first point at the end.
    Raises BadValue for points that are no such array, BadCurve where no fit comes close enough.
    """
    points = _check(points, closed)
    s = _chord_parameter(points, closed)
    size = float(np.ptp(points, axis=0).max())
    # Twice as many points as coefficients: a fit that met every point would say nothing about the places between.
    most = min(MOST_TERMS, (len(points) // 2 - 1) // 2 if closed else len(points) // 2 - 1)
    for terms in range(1, most + 1):
        basis = _fourier(s, terms) if closed else np.polynomial.chebyshev.chebvander(s, terms)
        coefficients = np.linalg.lstsq(basis, points, rcond=None)[0]
        residual = float(np.hypot(*(basis @ coefficients - points).T).max())
        if residual <= CLOSE_ENOUGH * size:
            if closed:
                _check_one_round(coefficients, terms)
            expression = _fourier_expression if closed else _chebyshev_expression
            x, y = (expression(column) for column in coefficients.T)
            return Fit((x, y), None if closed else (-1.0, 1.0), residual)
    raise BadCurve(
        f"a fit with {most} terms misses the points by {residual:.3g} m, more than a thousandth of their extent; "
        "give more points, in order along the curve, of a curve without corners"
    )


def read(path: str | Path) -> np.ndarray:
    """Points from a CSV file of two columns x, y in metres, with or without a heading; shape (n, 2).

    A relative path counts from the case file that names it, else from the working folder.
    Raises UnknownName for a file that is not there, BadValue, with the line, for one that holds something else.
    """
    what = "file of points"
    path = user_files.existing(what, Path(_folder.get(), user_files.place(what, path)))
    rows = []
    try:
        lines = list(csv.reader(user_files.text(what, path, LARGEST_FILE).splitlines()))
    except csv.Error as problem:
        raise BadValue(f"{path} is no CSV text ({problem}); give two columns x,y in metres") from None
    data_rows = [(n, row) for n, row in enumerate(lines, start=1) if row and not row[0].lstrip().startswith("#")]
    for number, row in data_rows:
        try:
            x, y = (float(cell) for cell in row)
        except ValueError:
            if number == data_rows[0][0] and all(_HEADING.match(cell) for cell in row):
                continue
            raise BadValue(f"{path}:{number} is {','.join(row)!r}; give two numbers x,y in metres") from None
        rows.append((x, y))
    return np.array(rows, dtype=float).reshape(-1, 2)


def as_points(source) -> np.ndarray:
    """Points (n, 2) from an array, a pandas frame with columns x and y, or the name of a CSV file."""
    if isinstance(source, str | Path):
        return read(source)
    columns = getattr(source, "columns", None)
    if columns is not None and {"x", "y"} <= set(columns):
        source = source[["x", "y"]]
    try:
        points = np.array(source, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise BadValue("points are not numbers; give a list of pairs (x, y) in metres") from None
    if points.ndim != 2 or points.shape[1] != 2:
        raise BadValue(f"points have shape {points.shape}; give pairs (x, y), shape (n, 2)")
    return points


def _check(points, closed: bool) -> np.ndarray:
    try:
        points = np.array(points, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise BadValue("points are not numbers; give a list of pairs (x, y) in metres") from None
    if points.ndim != 2 or points.shape[1] != 2:
        raise BadValue(f"points have shape {points.shape}; give pairs (x, y), shape (n, 2)")
    bad = ~np.isfinite(points).all(axis=1)
    if bad.any():
        raise BadValue(f"point {int(np.argmax(bad)) + 1} is not finite; leave it out")
    if closed and len(points) > 1 and np.array_equal(points[0], points[-1]):
        points = points[:-1]
    if len(points) < 8:
        raise BadValue(f"{len(points)} points are not enough for a smooth curve; give at least 8")
    if closed:
        _check_round(points)
    same = np.flatnonzero(np.all(points[1:] == points[:-1], axis=1))
    if same.size:
        raise BadValue(f"points {same[0] + 1} and {same[0] + 2} are the same; leave one out")
    return points


# The chord from the last point to the first may be so many times the longest other one: a quarter of a circle left out
# shows from eight points on, and hands place points more evenly than that.
GAP = 2.0


def _check_round(points: np.ndarray) -> None:
    """Raises BadCurve for points of a closed curve that leave a part of it out."""
    chords = np.hypot(*np.diff(np.vstack([points, points[:1]]), axis=0).T)
    if chords[-1] > GAP * chords[:-1].max():
        raise BadCurve(
            f"the last point lies {chords[-1]:.3g} m from the first, {chords[-1] / chords[:-1].max():.2g} times as far "
            "as any two others: a part of the closed curve has no points; give points there, or closed=False"
        )


def _check_one_round(coefficients: np.ndarray, terms: int) -> None:
    """Raises BadCurve where a closed fit turns more than once."""
    sides = np.diff(_fourier(np.linspace(0.0, 2 * np.pi, 722), terms) @ coefficients, axis=0)
    angles = np.unwrap(np.arctan2(sides[:, 1], sides[:, 0]))
    rounds = round(abs(float(angles[-1] - angles[0])) / (2 * np.pi))
    if rounds > 1:
        raise BadCurve(f"the points go {rounds} times round; give those of one round")


def _chord_parameter(points: np.ndarray, closed: bool) -> np.ndarray:
    around = np.vstack([points, points[:1]]) if closed else points
    length = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(around, axis=0).T))])
    return 2 * np.pi * length[:-1] / length[-1] if closed else 2 * length / length[-1] - 1


def _fourier(s: np.ndarray, terms: int) -> np.ndarray:
    waves = [wave(k * s) for k in range(1, terms + 1) for wave in (np.cos, np.sin)]
    return np.column_stack([np.ones_like(s), *waves])


def _fourier_expression(c: np.ndarray) -> sp.Expr:
    waves = [wave(k * PARAMETER) for k in range(1, len(c) // 2 + 1) for wave in (cos, sin)]
    return sp.Add(*(sp.Float(float(a)) * wave for a, wave in zip(c, [sp.Integer(1), *waves], strict=True)))


def _chebyshev_expression(c: np.ndarray) -> sp.Expr:
    # Horner's form of the same polynomial: at most ten terms on −1 … 1 lose three digits of the fit's sixteen.
    result: sp.Expr = sp.Integer(0)
    for a in reversed(np.polynomial.chebyshev.cheb2poly(c)):
        result = result * PARAMETER + sp.Float(float(a))
    return result
