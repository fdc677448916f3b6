"""Interval arithmetic on arrays: bounds on the values of a formula on an interval of its parameter.

An `Interval` can be passed to functions that were compiled for NumPy arrays, such as a curve's jets. Bounds are not
rounded outward: callers must allow for some roundings. A formula that is undefined somewhere on an interval has the
bounds ±inf there. (Moore, Interval Analysis, 1966: known to us, not looked up.)
"""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce
from typing import Any

import numpy as np

TURN = 2.0 * np.pi
HUGE = 1e300


class Interval:
    """Numbers between `low` and `high`, arrays of one shape."""

    __slots__ = ("high", "low")

    def __init__(self, low, high):
        self.low, self.high = low, high

    def __array_ufunc__(self, ufunc, method, *inputs, **options):
        function = _FUNCTIONS.get(ufunc.__name__)
        if function is None or method != "__call__" or options:
            return NotImplemented
        with np.errstate(all="ignore"):
            return function(*inputs)

    def __neg__(self) -> Interval:
        return Interval(-self.high, -self.low)

    def __pos__(self) -> Interval:
        return self

    def __add__(self, other) -> Interval:
        return _sum(self, other)

    __radd__ = __add__

    def __sub__(self, other) -> Interval:
        return _sum(self, -other)

    def __rsub__(self, other) -> Interval:
        return _sum(-self, other)

    def __mul__(self, other) -> Interval:
        return _product(self, other)

    __rmul__ = __mul__

    def __truediv__(self, other) -> Interval:
        return _product(self, _inverse(other) if isinstance(other, Interval) else 1.0 / np.asarray(other, dtype=float))

    def __rtruediv__(self, other) -> Interval:
        return _product(_inverse(self), other)

    def __pow__(self, exponent) -> Interval:
        return _power(self, exponent)

    def __rpow__(self, base) -> Interval:
        return _rising(np.exp)(self * np.log(base))

    @property
    def size(self) -> np.ndarray:
        """The largest absolute value."""
        return np.maximum(np.abs(self.low), np.abs(self.high))

    @property
    def least(self) -> np.ndarray:
        """The smallest absolute value."""
        return np.maximum(np.maximum(self.low, -self.high), 0.0)

    def within(self, other: Interval) -> Interval:
        """The intersection of two bounds on the same quantity."""
        return Interval(np.fmax(self.low, other.low), np.fmin(self.high, other.high))


def bounds(value, like: np.ndarray) -> Interval:
    """A value as an interval of that array's shape: a number has zero width; undefined values become ±inf."""
    low, high = (value.low, value.high) if isinstance(value, Interval) else (value, value)
    low, high = np.broadcast_to(low, like.shape), np.broadcast_to(high, like.shape)
    return Interval(np.where(np.isnan(low), -np.inf, low), np.where(np.isnan(high), np.inf, high))


def _sum(a: Interval, b) -> Interval:
    if isinstance(b, Interval):
        return Interval(a.low + b.low, a.high + b.high)
    return Interval(a.low + b, a.high + b)


def _product(a: Interval, b) -> Interval:
    if isinstance(b, Interval):
        corners = [a.low * b.low, a.low * b.high, a.high * b.low, a.high * b.high]
    else:
        corners = [a.low * b, a.high * b]
    low, high = reduce(np.minimum, corners), reduce(np.maximum, corners)
    if np.isnan(low).any():  # nothing times infinity, of a factor that is exactly zero
        corners = [np.where(np.isnan(corner), 0.0, corner) for corner in corners]
        low, high = reduce(np.minimum, corners), reduce(np.maximum, corners)
    return Interval(low, high)


def _inverse(a: Interval) -> Interval:
    across = (a.low <= 0.0) & (a.high >= 0.0)
    return Interval(np.where(across, -np.inf, 1.0 / a.high), np.where(across, np.inf, 1.0 / a.low))


def _power(a: Interval, exponent) -> Interval:
    if isinstance(exponent, Interval):
        return _rising(np.exp)(exponent * _rising(np.log)(a))
    if exponent < 0:
        return _inverse(_power(a, -exponent))
    if exponent == round(exponent) and round(exponent) % 2 == 0:
        return _finite_bounds(a.least**exponent, a.size**exponent)
    return _rising(lambda x: x**exponent)(a)  # NaN below zero where it is a root


def _rising(function: Callable) -> Callable[[Interval], Interval]:
    return lambda a: _finite_bounds(function(a.low), function(a.high))


def _falling(function: Callable) -> Callable[[Interval], Interval]:
    return lambda a: _finite_bounds(function(a.high), function(a.low))


def _finite_bounds(low: np.ndarray, high: np.ndarray) -> Interval:
    """The interval with ±inf where a bound is undefined; infinite values become large numbers, so that their difference
    is not NaN."""
    return Interval(
        np.where(np.isnan(low), -np.inf, np.minimum(low, HUGE)),
        np.where(np.isnan(high), np.inf, np.maximum(high, -HUGE)),
    )


def _cosine(a: Interval) -> Interval:
    ends = np.cos(a.low), np.cos(a.high)
    top = np.floor(a.high / TURN) >= np.ceil(a.low / TURN)
    bottom = np.floor(a.high / TURN - 0.5) >= np.ceil(a.low / TURN - 0.5)
    whole = ~np.isfinite(a.low + a.high)
    return Interval(
        np.where(bottom | whole, -1.0, np.minimum(*ends)),
        np.where(top | whole, 1.0, np.maximum(*ends)),
    )


def _sine(a: Interval) -> Interval:
    return _cosine(Interval(a.low - 0.25 * TURN, a.high - 0.25 * TURN))


def _hyperbolic_cosine(a: Interval) -> Interval:
    return _finite_bounds(np.cosh(a.least), np.cosh(a.size))


def _tangent(a: Interval) -> Interval:
    """Unbounded where a pole lies between the ends."""
    pole = np.floor(a.high / np.pi - 0.5) >= np.ceil(a.low / np.pi - 0.5)
    return Interval(np.where(pole, -np.inf, np.tan(a.low)), np.where(pole, np.inf, np.tan(a.high)))


def _absolute(a: Interval) -> Interval:
    return Interval(a.least, a.size)


_FUNCTIONS: dict[str, Callable[..., Any]] = {
    "add": lambda a, b: a + b if isinstance(a, Interval) else b + a,
    "subtract": lambda a, b: a - b if isinstance(a, Interval) else -b + a,
    "multiply": lambda a, b: a * b if isinstance(a, Interval) else b * a,
    "divide": lambda a, b: a / b if isinstance(a, Interval) else Interval.__rtruediv__(b, a),
    "power": lambda a, b: a**b if isinstance(a, Interval) else Interval.__rpow__(b, a),
    "negative": lambda a: -a,
    "positive": lambda a: a,
    "square": lambda a: a**2,
    "absolute": _absolute,
    "sqrt": _rising(np.sqrt),
    "exp": _rising(np.exp),
    "log": _rising(np.log),
    "sin": _sine,
    "cos": _cosine,
    "tan": _tangent,
    "arcsin": _rising(np.arcsin),
    "arccos": _falling(np.arccos),
    "arctan": _rising(np.arctan),
    "sinh": _rising(np.sinh),
    "cosh": _hyperbolic_cosine,
    "tanh": _rising(np.tanh),
}
