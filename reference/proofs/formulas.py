"""Formulas evaluated on power series with ball coefficients (Arb).

Each coefficient of a result is a ball that contains the exact coefficient for every choice of the arguments'
coefficients in their balls.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import sympy as sp
from flint import arb, arb_series, ctx, fmpq


def _hyperbolic(u: arb_series) -> tuple[arb_series, arb_series]:
    e = u.exp()
    return e, 1 / e


_FUNCTIONS: dict[type, Callable[[Any], Any]] = {
    sp.sin: lambda u: u.sin(),
    sp.cos: lambda u: u.cos(),
    sp.tan: lambda u: u.tan(),
    sp.exp: lambda u: u.exp(),
    sp.log: lambda u: u.log(),
    sp.asin: lambda u: u.asin(),
    sp.acos: lambda u: u.acos(),
    sp.atan: lambda u: u.atan(),
    sp.sinh: lambda u: (_hyperbolic(u)[0] - _hyperbolic(u)[1]) / 2,
    sp.cosh: lambda u: (_hyperbolic(u)[0] + _hyperbolic(u)[1]) / 2,
    sp.tanh: lambda u: 1 - 2 / ((2 * u).exp() + 1),
}


class Formula:
    """Expressions as operations on series: called with one series per symbol, it returns one per expression."""

    def __init__(self, symbols: Sequence[sp.Symbol], expressions: Sequence[sp.Expr]):
        self._symbols = tuple(symbols)
        self._steps, self._results = sp.cse(list(expressions))
        self._constants: dict[tuple[sp.Expr, int], arb] = {}

    def __call__(self, *arguments: arb_series) -> list[arb_series]:
        values: dict[sp.Expr, Any] = dict(zip(self._symbols, arguments, strict=True))
        for symbol, expression in self._steps:
            values[symbol] = self._value(expression, values)
        return [as_series(self._value(expression, values)) for expression in self._results]

    def _value(self, node: sp.Expr, values: dict[sp.Expr, Any]) -> Any:
        if node in values:
            return values[node]
        if not node.free_symbols:
            return self._constant(node)
        if isinstance(node, sp.Add | sp.Mul):
            first, *others = (self._value(part, values) for part in node.args)
            for other in others:
                first = first + other if isinstance(node, sp.Add) else first * other
            return first
        if isinstance(node, sp.Pow):
            return power(self._value(node.base, values), node.exp)
        return _FUNCTIONS[type(node)](as_series(self._value(node.args[0], values)))

    def _constant(self, node: sp.Expr) -> arb:
        key = node, ctx.prec
        if key not in self._constants:
            self._constants[key] = constant(node)
        return self._constants[key]


def as_series(value: Any) -> arb_series:
    return value if isinstance(value, arb_series) else arb_series([value])


def power(base: Any, exponent: sp.Expr) -> Any:
    """A power with a rational exponent. Half-integer exponents are roots; others need a positive base."""
    if isinstance(exponent, sp.Integer):
        result, n = as_series(base), abs(int(exponent))
        value = result
        for _ in range(n - 1):
            value = value * result
        return value if exponent > 0 else 1 / value
    if exponent == sp.Rational(1, 2):
        return as_series(base).sqrt()
    if exponent == -sp.Rational(1, 2):
        return as_series(base).rsqrt()
    return (as_series(base).log() * constant(exponent)).exp()


def constant(node: sp.Expr) -> arb:
    """A number: rationals, π, e, and smooth functions of them, as a ball."""
    if isinstance(node, sp.Rational):
        return arb(fmpq(int(node.p), int(node.q)))
    if node is sp.pi:
        return arb.pi()
    if node is sp.E:
        return arb(1).exp()
    if isinstance(node, sp.Add | sp.Mul):
        first, *others = (constant(part) for part in node.args)
        for other in others:
            first = first + other if isinstance(node, sp.Add) else first * other
        return first
    if isinstance(node, sp.Pow):
        return constant(node.base) ** constant(node.exp)
    value = _FUNCTIONS[type(node)](arb_series([constant(node.args[0])], 1))
    return value[0]
