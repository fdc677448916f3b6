"""Formulas on intervals of their arguments, by interval arithmetic on arrays: an enclosure that is much wider than the
values at some points says that more happens between them. (Moore, Kearfott & Cloud 2009, Introduction to Interval
Analysis: known to us, not looked up. Roundings are not directed: what is looked for is a thousandth of a force.)"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from functools import lru_cache

import numpy as np

from cases.formulas.expression_graph import Node, in_order

Interval = tuple[np.ndarray, np.ndarray]
# Beyond this an exponential function is infinite anyway.
LARGEST = 700.0


def _sum(a: Interval, b: Interval) -> Interval:
    return a[0] + b[0], a[1] + b[1]


def _difference(a: Interval, b: Interval) -> Interval:
    return a[0] - b[1], a[1] - b[0]


def _product(a: Interval, b: Interval) -> Interval:
    every = np.array(np.broadcast_arrays(*(np.multiply(p, q) for p in a for q in b)))
    every = np.where(np.isnan(every), 0.0, every)  # zero times infinite
    return every.min(axis=0), every.max(axis=0)


def _inverse(b: Interval) -> Interval:
    low, high = np.divide(1.0, b[1]), np.divide(1.0, b[0])
    has_zero = (b[0] <= 0.0) & (b[1] >= 0.0)
    return np.where(has_zero, -np.inf, low), np.where(has_zero, np.inf, high)


def _power(a: Interval, exponent: float | Fraction | int) -> Interval:
    if exponent == 0:
        return np.ones_like(a[0]), np.ones_like(a[1])
    if exponent < 0:
        return _inverse(_power(a, -exponent))
    if exponent != int(exponent):
        a = np.maximum(a[0], 0.0), np.maximum(a[1], 0.0)
    ends = a[0] ** float(exponent), a[1] ** float(exponent)
    low, high = np.minimum(*ends), np.maximum(*ends)
    if exponent == int(exponent) and int(exponent) % 2 == 0:
        low = np.where((a[0] < 0.0) & (a[1] > 0.0), 0.0, low)
    return low, high


def _sine(a: Interval) -> Interval:
    """Of a wave with its largest values at π/2 + 2πk."""
    ends = np.sin(a[0]), np.sin(a[1])
    low, high = np.minimum(*ends), np.maximum(*ends)
    has_top = np.floor((a[1] - 0.5 * np.pi) / (2 * np.pi)) >= np.ceil((a[0] - 0.5 * np.pi) / (2 * np.pi))
    has_bottom = np.floor((a[1] + 0.5 * np.pi) / (2 * np.pi)) >= np.ceil((a[0] + 0.5 * np.pi) / (2 * np.pi))
    return np.where(has_bottom, -1.0, low), np.where(has_top, 1.0, high)


def _tangent(a: Interval) -> Interval:
    has_pole = np.floor((a[1] + 0.5 * np.pi) / np.pi) > np.floor((a[0] + 0.5 * np.pi) / np.pi)
    return np.where(has_pole, -np.inf, np.tan(a[0])), np.where(has_pole, np.inf, np.tan(a[1]))


def _even(function: Callable) -> Callable[[Interval], Interval]:
    """A function that is even and grows with the size of its argument."""

    def values(a: Interval) -> Interval:
        ends = function(a[0]), function(a[1])
        low = np.where((a[0] < 0.0) & (a[1] > 0.0), function(0.0), np.minimum(*ends))
        return low, np.maximum(*ends)

    return values


def _growing(function: Callable, low: float = -np.inf, high: float = np.inf) -> Callable[[Interval], Interval]:
    """A function that grows, where it has values."""
    return lambda a: (function(np.clip(a[0], low, high)), function(np.clip(a[1], low, high)))


def _arc_cosine(a: Interval) -> Interval:
    return np.arccos(np.clip(a[1], -1.0, 1.0)), np.arccos(np.clip(a[0], -1.0, 1.0))


_BINARY = {"+": _sum, "-": _difference, "*": _product, "/": lambda a, b: _product(a, _inverse(b))}
_UNARY: dict[str, Callable[[Interval], Interval]] = {
    "sin": _sine,
    "cos": lambda a: _sine((a[0] + 0.5 * np.pi, a[1] + 0.5 * np.pi)),
    "tan": _tangent,
    "exp": _growing(np.exp, -LARGEST, LARGEST),
    "log": _growing(np.log, 1e-300),
    "sinh": _growing(np.sinh, -LARGEST, LARGEST),
    "tanh": _growing(np.tanh),
    "asin": _growing(np.arcsin, -1.0, 1.0),
    "atan": _growing(np.arctan),
    "cosh": _even(np.cosh),
    "abs": _even(np.abs),
    "acos": _arc_cosine,
}


@lru_cache(maxsize=256)
def _order(formula: Node) -> tuple[Node, ...]:
    return tuple(in_order([formula]))


def enclosure(formula: Node, arguments: Mapping[str, Interval]) -> Interval | None:
    """The range of a formula's values on intervals of its arguments, by name, arrays (n,); None if it has an operation
    that is not known here, such as an integral."""
    values: dict[Node, Interval] = {}
    for current in _order(formula):
        if current.op == "symbol":
            values[current] = arguments[current.name]
        elif current.op == "number":
            number = np.array(float(current.args[0]))
            values[current] = number, number
        elif current.op == "**":
            base, exponent = current.args
            if exponent.op != "number":
                return None
            values[current] = _power(values[base], exponent.args[0])
        elif current.op in _BINARY:
            values[current] = _square_or(current, values)
        elif current.op in _UNARY:
            values[current] = _UNARY[current.op](values[current.args[0]])
        else:
            return None
    return values[formula]


def _square_or(current: Node, values: Mapping[Node, Interval]) -> Interval:
    """An operation with two arguments; the product of one with itself is a square."""
    one, other = current.args
    if current.op == "*" and one is other:
        return _power(values[one], 2)
    return _BINARY[current.op](values[one], values[other])
