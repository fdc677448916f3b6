"""Integrals of a formula up to a parameter, as functions that are as quick and smooth as elementary ones.

The integrand is resolved once by Chebyshev polynomials on intervals, which are halved until the last coefficients are
rounding; their antiderivatives are then evaluated by Clenshaw's recurrence (Trefethen, Approximation Theory and
Approximation Practice: known to us, not looked up).
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev

from ..derivation import in_one_thread
from ..errors import BadCurve

# Degree on an interval, and the last coefficients as a part of the largest at which it counts as resolved.
DEGREE, ROUNDING = 24, 4e-16
# An interval is halved at most this many times, and a table has at most this many intervals on each side.
HALVINGS, MOST = 60, 20_000
_NODES = chebyshev.chebpts1(DEGREE + 1)
_TO_COEFFICIENTS = np.linalg.inv(chebyshev.chebvander(_NODES, DEGREE))


class Antiderivative:
    """The integral of a function of one variable from `start`, tabulated outwards as far as it is requested."""

    def __init__(self, function: Callable, start: float):
        self._function, self._width = function, 1.0
        self._edges, self._starts = [start], list[float]()
        self._rows: list[list[float]] = []

    def number(self, x: float) -> float:
        """Its value at a number."""
        i = self._piece(x, x)(x)
        low, high = self._edges[i], self._edges[i + 1]
        return self._starts[i] + _clenshaw(self._rows[i], (2.0 * x - low - high) / (high - low))

    def array(self, x: np.ndarray) -> np.ndarray:
        """Its values at an array, shape (n,)."""
        if not x.size:
            return np.zeros(x.shape)
        finite = np.where(np.isfinite(x), x, self._edges[0])
        self._piece(float(finite.min()), float(finite.max()))
        edges = np.array(self._edges)
        i = np.clip(np.searchsorted(edges, finite, side="right") - 1, 0, len(edges) - 2)
        low, high = edges[i], edges[i + 1]
        rows = np.array(self._rows)[i].T
        values = np.array(self._starts)[i] + _clenshaw(rows, (2.0 * finite - low - high) / (high - low))
        return np.where(np.isfinite(x), values, np.nan)

    def _piece(self, low: float, high: float) -> Callable[[float], int]:
        """Extend the table over (low, high); returns the function that finds a parameter's interval."""
        if not self._rows or high > self._edges[-1] or low < self._edges[0]:
            self._extend(low, high)
        return lambda x: min(max(bisect_right(self._edges, x) - 1, 0), len(self._rows) - 1)

    @in_one_thread
    def _extend(self, low: float, high: float) -> None:
        while not self._rows or self._edges[-1] < high:
            begin = self._edges[-1]
            end, row = self._resolve(begin, 1.0)
            total = self._starts[-1] + _clenshaw(self._rows[-1], 1.0) if self._rows else 0.0
            self._edges, self._starts, self._rows = [*self._edges, end], [*self._starts, total], [*self._rows, row]
        while self._edges[0] > low:
            end, row = self._resolve(self._edges[0], -1.0)
            total = self._starts[0] - _clenshaw(row, 1.0)
            self._edges, self._starts, self._rows = [end, *self._edges], [total, *self._starts], [row, *self._rows]

    def _resolve(self, begin: float, side: float) -> tuple[float, list[float]]:
        """The other end of an interval that begins there, and the antiderivative's coefficients on it."""
        if len(self._rows) >= MOST:
            raise BadCurve(f"the integral has too many features up to {begin:.6g}; give a shorter domain")
        width = 2.0 * self._width
        for _ in range(HALVINGS):
            low, high = sorted((begin, begin + side * width))
            middle, half = 0.5 * (low + high), 0.5 * (high - low)
            with np.errstate(all="ignore"):
                values = np.broadcast_to(self._function(middle + half * _NODES), _NODES.shape)
            c = _TO_COEFFICIENTS @ values
            if np.isfinite(c).all() and np.abs(c[-3:]).max() <= ROUNDING * DEGREE * np.abs(c).max():
                self._width = width
                return begin + side * width, (half * chebyshev.chebint(c, lbnd=-1.0)).tolist()
            width *= 0.5
        raise BadCurve(f"the integral is not finite beyond {begin:.6g}; give a domain that leaves that out")


def _clenshaw(row, z):
    """Clenshaw's recurrence: the value of a Chebyshev series, for numbers or arrays."""
    b1, b2, twice = row[-1], 0.0, 2.0 * z
    for c in row[-2:0:-1]:
        b1, b2 = c + twice * b1 - b2, b1
    return row[0] + z * b1 - b2


def integral_function(integrand: Callable) -> Callable:
    """The function (x, start, *constants) ↦ the integral of `integrand`(u, *constants) from `start` to x.

    x is a float, an array or an interval (anything with `low` and `high`); constants are floats, or arrays like x.
    """

    @lru_cache(maxsize=256)
    def table(start: float, constants: tuple[float, ...]) -> Antiderivative:
        return Antiderivative(lambda u: integrand(u, *constants), start)

    def value(x: Any, start: Any, *constants: Any) -> Any:
        if hasattr(x, "low") and hasattr(x, "high"):  # the mean value theorem about the middle
            middle = 0.5 * (x.low + x.high)
            return integrand(x, *constants) * (x - middle) + value(middle, start, *constants)
        numbers = [start, *constants]
        if any(np.ndim(number) for number in numbers):
            rows = np.broadcast_arrays(x, *numbers)
            return np.array([value(*row) for row in np.array(rows).T.tolist()])
        integral = table(float(start), tuple(map(float, constants)))
        return integral.array(np.asarray(x)) if np.ndim(x) else integral.number(float(x))

    return value
