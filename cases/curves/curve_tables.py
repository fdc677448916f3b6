"""Tables of a curve: lengths along it, its sizes, the direction of its tangent, its period and its features.

They are refined where even samples of the parameter would be too far apart.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Protocol

import numpy as np

from ..formulas.expression_graph import Node
from ..formulas.features import WINDOW, Features, largest, union
from . import parametrisation
from .parametrisation import MOST_ROUNDS

# Samples that are enough for any curve a person would draw, unless features require more.
SAMPLES = 720
# Entries of a table of tangent angles per `Curve.unit` of the parameter, and more where the tangent turns by more than
# TURN (rad) between two entries: half a turn would be miscounted. Also the most entries, and the most halvings.
ANGLES, TURN, MOST_ANGLES, HALVINGS = 32, 1.0, 200_000, 40


class CurveFormula(Protocol):
    """The interface of `cases.curves.Curve` that these tables use."""

    @property
    def domain(self) -> tuple[float, float] | None: ...
    @property
    def rows(self) -> tuple[Node, Node]: ...
    @property
    def period(self) -> float | None: ...
    @property
    def centres(self) -> tuple[float, ...]: ...
    @property
    def span(self) -> tuple[float, float]: ...
    @property
    def unit(self) -> float: ...
    @property
    def features(self) -> Features | None: ...
    def jets(self, s) -> np.ndarray: ...
    def point(self, s) -> np.ndarray: ...
    def speed(self, s): ...
    def curvature(self, s): ...
    def angle_table(self, span: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]: ...


def _with_features(curve: CurveFormula, grid: np.ndarray) -> np.ndarray:
    """The parameters, and further ones between them that resolve the curve's features."""
    return union(grid, curve.features.places(grid[0], grid[-1])) if curve.features else grid


def lengths(curve: CurveFormula, low: float, high: float) -> tuple[np.ndarray, np.ndarray]:
    """Parameters from `low` to `high`, and the arc length from the first to each, m.

    Without those at the ends where the curve is too large for a double.
    """
    grid = _with_features(curve, np.linspace(low, high, 4 * SAMPLES + 1))
    with np.errstate(all="ignore"):
        speed = curve.speed(grid)
    grid, speed = grid[np.isfinite(speed)], speed[np.isfinite(speed)]
    return grid, np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(grid))])


def sizes(curve: CurveFormula) -> tuple[float, float]:
    """The largest distance from the origin, and that or the smallest radius of curvature if it is smaller, m."""
    places = _with_features(curve, np.linspace(*curve.span, SAMPLES + 1))
    with np.errstate(all="ignore"):
        reach = float(np.nanmax(np.hypot(*curve.point(places))))
        bend = float(np.nanmax(np.abs(curve.curvature(places))))
    return reach, min(reach, 1.0 / bend) if bend > 0.0 else reach


def least_turning(curve: CurveFormula, count: int) -> float:
    """A lower bound of the total absolute turn, rad: that between even samples, each less than half a turn."""
    with np.errstate(all="ignore"):
        _, _, xp, yp, *_ = curve.jets(np.linspace(*curve.span, count + 1))
        return float(np.abs(np.angle(np.exp(1j * np.diff(np.arctan2(yp, xp))))).sum())


def total_turning(curve: CurveFormula) -> float:
    """The total absolute turn of the tangent along the whole curve, rad."""
    return float(np.abs(np.diff(curve.angle_table(curve.span)[1])).sum())


def corners(curve: CurveFormula, count: int, offset: float = 0.0) -> np.ndarray:
    """Parameters of the corners of a polygon of `count` sides along the whole curve, denser where it bends.

    For a closed curve the first corner is shifted by the fraction `offset` of a side.
    """
    grid, angle = curve.angle_table(curve.span)
    steps = np.hypot(*np.diff(curve.point(grid), axis=1))
    turns = np.abs(np.diff(angle))
    # Half of the sides are distributed by length, half by turning.
    parts = np.insert(np.cumsum(steps / steps.sum() + turns / max(float(turns.sum()), 1e-300)), 0, 0.0)
    values = np.interp((np.arange(count + 1) + offset) / count * parts[-1], parts, grid)
    if offset:
        values[-1] = values[0] + (grid[-1] - grid[0])
    return values


def angles(curve: CurveFormula, span: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Parameters on that range and the tangent's continuous angle; within half a turn of 0 at `Curve.span[0]`."""
    count = int(min(MOST_ANGLES, max(4 * SAMPLES, ANGLES * (span[1] - span[0]) / curve.unit))) + 1
    grid = _with_features(curve, np.linspace(*span, count))
    for _ in range(HALVINGS):
        values, rate = _turning(curve, grid)
        coarse = np.diff(grid) * np.maximum(rate[1:], rate[:-1]) > TURN
        if not coarse.any() or len(grid) > MOST_ANGLES:
            break
        grid = np.sort(np.append(grid, 0.5 * (grid[:-1] + grid[1:])[coarse]))
    # The branch is fixed where the span begins, so that wider tables agree with narrower ones.
    anchor = np.interp(curve.span[0], grid, values)
    return grid, values - 2 * np.pi * np.floor((anchor + np.pi) / (2 * np.pi))


def _turning(curve: CurveFormula, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The tangent's angles (rad), and its rate of turn (rad per parameter unit), 0 where that is not finite."""
    _, _, xp, yp, xs, ys, _, _ = curve.jets(s)
    with np.errstate(all="ignore"):
        rate = np.abs(xp * ys - yp * xs) / (xp * xp + yp * yp)
    return np.unwrap(np.arctan2(yp, xp)), np.where(np.isfinite(rate), rate, 0.0)


def period(curve: CurveFormula) -> float | None:
    """The parameter's period of a closed curve with one formula, else None; see `Curve.period`."""
    if curve.domain is not None:
        start, length = curve.domain[0], curve.domain[1] - curve.domain[0]
        probes = np.array([start])
    else:
        common = parametrisation.period(curve.rows)
        if common is None:
            return None
        length, probes = common, common / (2 * np.pi) * np.array([0.1, 1.3, 2.9])

    def jets(s: np.ndarray) -> np.ndarray:
        return parametrisation.scale(curve.jets(s), length / (2 * np.pi))

    with np.errstate(all="ignore"):
        here, there = jets(probes), jets(probes + length)
    # A closed curve's ends agree to the rounding of its own sizes; 1e-9 of them is far above that and far below
    # any gap a person would author.
    near = 1e-9 * np.max(np.abs(here))
    if not np.all(np.abs(here - there) <= near):
        return None
    if curve.domain is None:  # (cos 3s, sin 3s) is a circle, and not one run round three times
        parts = length / np.arange(MOST_ROUNDS, 1, -1)
        again = jets((probes[:, None] + parts).ravel()).reshape(8, len(probes), len(parts))
        repeats = np.all(np.abs(again - here[:, :, None]) <= near, axis=(0, 1))
        if repeats.any():
            return float(parts[np.argmax(repeats)])
    return float(length)


@lru_cache(maxsize=256)
def features_of(curve: CurveFormula) -> Features:
    """Where the curvature and speed of a curve with one formula change; kept for equal curves: a scene is often made
    again with another friction."""

    def bend_and_speed(s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        _, _, xp, yp, xs, ys, _, _ = curve.jets(s)
        speed = np.hypot(xp, yp)
        return np.array([(xp * ys - yp * xs) / speed**3, speed]), np.array([np.hypot(xs, ys) / speed**2, speed])

    ends = curve.span if curve.domain is not None or curve.period else None
    centres = curve.centres
    # Bends are known to rounding of the sharpest one; a speed, which may grow without bound, of its own.
    sizes = largest(bend_and_speed, *curve.span, centres) * [1.0, 0.0] if ends is None else 0.0
    window = WINDOW * curve.unit
    return Features(bend_and_speed, centres, ends, bool(curve.period), sizes, window)
