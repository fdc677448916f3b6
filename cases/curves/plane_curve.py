"""What follows from the place and the derivatives of a curve: its tangent, curvature, length, period and features.

Tables are refined where even samples of the parameter would be too far apart.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable
from functools import lru_cache
from math import atan2, floor, hypot, isfinite, nan
from typing import Any

import numpy as np

from ..derivation import derived
from ..errors import BadValue, CaseError, finite, numbers, point, real, whole
from ..formulas.expression_graph import derivatives
from ..formulas.features import WINDOW, Features, centres, largest, union
from . import parametrisation
from .element import OneElement
from .jets import S, jet_function
from .pieces import CurvePieces

# The range looked at when a curve without a domain has no period, in units in which it changes: a hundred of them
# either way would already overflow a cosh; ten are what a drawing shows.
UNBOUNDED_SPAN = (-10.0, 10.0)
# Samples that are enough for any curve a person would draw, unless features require more.
SAMPLES = 720
# Entries of a table of tangent angles per `unit` of the parameter, and more where the tangent turns by more than TURN
# (rad) between two entries: half a turn would be miscounted. Also the most entries, and the most halvings.
ANGLES, TURN, MOST_ANGLES, HALVINGS = 32, 1.0, 200_000, 40


class PlaneCurve(OneElement):
    """A curve by one formula, or in pieces with formulas of their own; `cases.curves.Curve` has the formulas."""

    domain: tuple[float, float] | None
    may_cross: bool
    # Of a curve in pieces: these; such a curve has no single formula.
    parts: CurvePieces | None
    # The formulas with symbols for their sizes, the values of these, and the formulas with their values.
    structure: Any
    constants: Any
    rows: Any

    # --- evaluation -------------------------------------------------------------------------------------------------

    @derived
    def _jet(self) -> Callable:
        if self.parts is not None:
            at = self.parts.jet
            return lambda s, constants: at(s)
        return jet_function(self.structure, on_arrays=False)

    @derived
    def _jets(self) -> Callable:
        return jet_function(self.structure, on_arrays=True)

    def jet(self, s: float) -> tuple[float, ...]:
        """(x, y, x_p, y_p, x_s, y_s, x_t, y_t) at one parameter: position and the first three derivatives. Raises
        BadValue where the formula has no value that fits a double."""
        number = s if isinstance(s, float) else finite("parameter of a curve", s)
        function, constants = self._jet, self.constants
        try:
            return function(number, constants)
        except CaseError:
            raise
        except (ArithmeticError, ValueError) as problem:
            raise BadValue(f"the curve has no place at the parameter {number:g} ({problem}); give another") from None

    def jets(self, s) -> np.ndarray:
        """The same for an array of parameters, shape (8, n)."""
        s = np.atleast_1d(numbers("parameters of a curve", s))
        if self.parts is not None:
            return self.parts.jets(s)
        jets = np.empty((8, *s.shape))
        for row, values in zip(jets, self._jets(s, self.constants), strict=True):
            row[...] = values  # a constant one is a number
        return jets

    def jets_of(self, s: Any, constants: tuple) -> list:
        """The same rows for curves of this structure with sizes of their own, each of the parameters' shape (n,); a
        constant row may be a number. Parameters may be anything that NumPy's functions take, such as intervals; of a
        curve in pieces they are arrays, and it has no sizes."""
        if self.parts is not None:
            return list(self.parts.jets(s))
        return self._jets(s, constants)

    def point(self, s) -> np.ndarray:
        """Position, shape (2,) for a number, (2, n) for an array."""
        return np.array(self.jet(s)[:2]) if _is_number(s) else self.jets(s)[:2]

    def tangent(self, s) -> np.ndarray:
        """Unit tangent, shape (2,) for a number, (2, n) for an array."""
        d = np.array(self.jet(s)[2:4]) if _is_number(s) else self.jets(s)[2:4]
        return d / np.hypot(d[0], d[1])

    def speed(self, s):
        """|R_p| in metres per unit of the parameter."""
        if _is_number(s):
            return hypot(*self.jet(s)[2:4])
        return np.hypot(*self.jets(s)[2:4])

    def curvature(self, s):
        """Signed curvature in 1/m, positive where the curve bends to its left."""
        _, _, xp, yp, xs, ys, _, _ = self.jet(s) if _is_number(s) else self.jets(s)
        return (xp * ys - yp * xs) / np.hypot(xp, yp) ** 3

    def length(self, low: float, high: float) -> float:
        """The length of the curve between two parameters, m, to a part in a thousand or so: what samples need."""
        return float(self._lengths(finite("low", low), finite("high", high))[1][-1])

    def even(self, low: float, high: float, count: int) -> np.ndarray:
        """So many parameters from `low` to `high` at nearly even distances along the curve."""
        count = whole("count of parameters", count, 1, MOST_ANGLES)
        grid, lengths = self._lengths(finite("low", low), finite("high", high))
        return np.interp(np.linspace(0.0, lengths[-1], count), lengths, grid)

    def _lengths(self, low: float, high: float) -> tuple[np.ndarray, np.ndarray]:
        """Parameters from `low` to `high`, and the arc length from the first to each, m; without those at the ends
        where the curve is too large for a double."""
        grid = self._with_features(np.linspace(low, high, 4 * SAMPLES + 1))
        with np.errstate(all="ignore"):
            speed = self.speed(grid)
        grid, speed = grid[np.isfinite(speed)], speed[np.isfinite(speed)]
        return grid, np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(grid))])

    # --- the curve as a whole ---------------------------------------------------------------------------------------

    @derived
    def sizes(self) -> tuple[float, float]:
        """The largest distance from the origin, and that or the smallest radius of curvature if it is smaller, m."""
        places = self._with_features(np.linspace(*self.span, SAMPLES + 1))
        with np.errstate(all="ignore"):
            reach = float(np.nanmax(np.hypot(*self.point(places))))
            bend = float(np.nanmax(np.abs(self.curvature(places))))
        return reach, min(reach, 1.0 / bend) if bend > 0.0 else reach

    @property
    def ends(self) -> tuple[float, float] | None:
        """The parameters of both ends of the curve; None if it is closed, or has no domain."""
        return None if self.period else self.domain

    @derived
    def period(self) -> float | None:
        """The parameter's period of a closed curve, else None.

        A curve with a domain is closed if position and three derivatives agree at both ends; one without a domain if
        its formulas have a common period: the shortest part of that after which it repeats itself (looked at in a few
        places, to rounding).
        """
        if self.parts is not None:
            return self.parts.period
        if self.domain is not None:
            length, probes = self.domain[1] - self.domain[0], np.array([self.domain[0]])
        else:
            common = parametrisation.period(self.rows)
            if common is None:
                return None
            length, probes = common, common / (2 * np.pi) * np.array([0.1, 1.3, 2.9])

        def jets(s: np.ndarray) -> np.ndarray:
            return parametrisation.scale(self.jets(s), length / (2 * np.pi))

        with np.errstate(all="ignore"):
            here, there = jets(probes), jets(probes + length)
        # A closed curve's ends agree to the rounding of its own sizes; 1e-9 of them is far above that and far below
        # any gap a person would author.
        near = 1e-9 * np.max(np.abs(here))
        if not np.all(np.abs(here - there) <= near):
            return None
        if self.domain is None:  # (cos 3s, sin 3s) is a circle, and not one run round three times
            shorter = length / np.arange(parametrisation.MOST_ROUNDS, 1, -1)
            again = jets((probes[:, None] + shorter).ravel()).reshape(8, len(probes), len(shorter))
            repeats = np.all(np.abs(again - here[:, :, None]) <= near, axis=(0, 1))
            if repeats.any():
                return float(shorter[np.argmax(repeats)])
        return float(length)

    @derived
    def unit(self) -> float:
        """How much of the parameter makes the curve change: what windows and samples of a curve without ends count in.

        A period over 2π for a closed curve.
        """
        if self.domain is not None or self.period:
            low, high = self.span
            return (high - low) / (2 * np.pi)
        places = parametrisation.places(self.centres)
        with np.errstate(all="ignore"):
            return parametrisation.unit(places, self.jets(places))

    @derived
    def span(self) -> tuple[float, float]:
        """A range of the parameter that shows the whole curve (one turn of a closed one)."""
        if self.domain is not None:
            return self.domain
        if self.period:
            return 0.0, self.period
        low, high = UNBOUNDED_SPAN
        return low * self.unit, high * self.unit

    @derived
    def centres(self) -> tuple[float, ...]:
        """Special points of the formula: centres of bumps and steps, poles, knots."""
        return centres(self.rows, S) if self.parts is None else self.parts.breaks[1:-1]

    @derived
    def features(self) -> Features | None:
        """Where its curvature and speed change, and how finely; None for a straight line run through evenly."""
        if self.parts is not None:
            return Features.of_edges(self.parts.edges, bool(self.period))
        if not any(S in slope.symbols for slope in derivatives(self.structure[0], S)):
            return None
        return features_of(self)

    def _with_features(self, grid: np.ndarray) -> np.ndarray:
        """The parameters, and further ones between them that resolve the curve's features."""
        return union(grid, self.features.places(grid[0], grid[-1])) if self.features else grid

    # --- the direction of the tangent -------------------------------------------------------------------------------

    def tangent_angle(self, s):
        """Direction of the tangent in radians, continuous along the curve (it gains 2π in each turn of a closed one).

        For a number or an array; this is what makes the plate's rotation θ a function of (ξ₁, ξ₂) alone, by (6).
        """
        return self.place(s)[1]

    def place(self, s) -> tuple[Any, Any]:
        """`point` (of a number: a pair of numbers) and `tangent_angle` from one evaluation."""
        if _is_number(s):
            number = real(s) or 0.0
            x, y, xp, yp = self.jet(number)[:4]
            angle, near = atan2(yp, xp), self._rough_tangent_angle_at(number)
            turns = (near - angle) / (2 * np.pi)
            return (x, y), angle + 2 * np.pi * round(turns) if isfinite(turns) else nan
        s = numbers("parameters of a curve", s)
        jets = self.jets(s)
        principal = np.arctan2(jets[3], jets[2]).reshape(s.shape)
        turns = np.round((self._rough_tangent_angle(s) - principal) / (2 * np.pi))
        return jets[:2], principal + 2 * np.pi * turns

    def _rough_tangent_angle(self, s: np.ndarray) -> np.ndarray:
        """The continuous tangent angle to within much less than half a turn, from a table."""
        low, high = self.span
        if self.period:
            turns = np.floor((s - low) / self.period)
            grid, angles = self.angle_table(self.span)
            return np.interp(s - turns * self.period, grid, angles) + turns * (angles[-1] - angles[0])
        if self.domain is None and s.size:
            while s.min() < low or s.max() > high:
                low, high = 2 * low, 2 * high
        return np.interp(s, *self.angle_table((low, high)))

    def _rough_tangent_angle_at(self, s: float) -> float:
        """The same at one parameter, without arrays, which take ten times as long."""
        low, high = self.span
        turns = 0
        if not isfinite(s) or (not self.period and self.domain is None and not low <= s <= high):
            return float(self._rough_tangent_angle(np.asarray(s)))
        if self.period:
            turns = floor((s - low) / self.period)
            s -= turns * self.period
        grid, angles = self._angle_lists
        after = bisect_right(grid, s)
        if after == 0 or after == len(grid):  # only by rounding, or outside the domain
            angle = angles[0 if after == 0 else -1]
        else:
            slope = (angles[after] - angles[after - 1]) / (grid[after] - grid[after - 1])
            angle = slope * (s - grid[after - 1]) + angles[after - 1]
        return angle + turns * (angles[-1] - angles[0]) if self.period else angle

    @derived
    def _angle_lists(self) -> tuple[list[float], list[float]]:
        grid, angles = self.angle_table(self.span)
        return grid.tolist(), angles.tolist()

    def angle_table(self, span: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
        """Parameters on that range, and the tangent's continuous angle there: what `tangent_angle` counts turns by. It
        is within half a turn of 0 at `span[0]` of the curve."""
        return self._angle_table(point("range of the parameter", span))

    @lru_cache(maxsize=64)  # noqa: B019 - curves are few, small and live as long as their case
    def _angle_table(self, span: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
        count = int(min(MOST_ANGLES, max(4 * SAMPLES, ANGLES * (span[1] - span[0]) / self.unit))) + 1
        grid = self._with_features(np.linspace(*span, count))
        for _ in range(HALVINGS):
            _, _, xp, yp, xs, ys, _, _ = self.jets(grid)
            with np.errstate(all="ignore"):
                rate = np.abs(xp * ys - yp * xs) / (xp * xp + yp * yp)
            values, rate = np.unwrap(np.arctan2(yp, xp)), np.where(np.isfinite(rate), rate, 0.0)
            coarse = np.diff(grid) * np.maximum(rate[1:], rate[:-1]) > TURN
            if not coarse.any() or len(grid) > MOST_ANGLES:
                break
            grid = np.sort(np.append(grid, 0.5 * (grid[:-1] + grid[1:])[coarse]))
        # The branch is fixed where the span begins, so that wider tables agree with narrower ones.
        anchor = np.interp(self.span[0], grid, values)
        return grid, values - 2 * np.pi * np.floor((anchor + np.pi) / (2 * np.pi))


def _is_number(s) -> bool:
    """Whether it is one parameter, not an array of them; the most common type is tested first. Raises BadValue for
    what is no number."""
    if isinstance(s, float):
        return True
    if np.ndim(s):
        return False
    if real(s) is None:
        raise BadValue(f"the parameter of a curve is {s!r}; give a number or an array")
    return True


@lru_cache(maxsize=256)
def features_of(curve: PlaneCurve) -> Features:
    """Where the curvature and speed of a curve with one formula change; kept for equal curves: a scene is often made
    again with another friction."""

    def bend_and_speed(s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        _, _, xp, yp, xs, ys, _, _ = curve.jets(s)
        speed = np.hypot(xp, yp)
        return np.array([(xp * ys - yp * xs) / speed**3, speed]), np.array([np.hypot(xs, ys) / speed**2, speed])

    ends = curve.span if curve.domain is not None or curve.period else None
    # Bends are known to rounding of the sharpest one; a speed, which may grow without bound, of its own.
    sizes = largest(bend_and_speed, *curve.span, curve.centres) * [1.0, 0.0] if ends is None else 0.0
    return Features(bend_and_speed, curve.centres, ends, bool(curve.period), sizes, WINDOW * curve.unit)
