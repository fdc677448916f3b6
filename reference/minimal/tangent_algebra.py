"""An algebra of sums of products of powers, with derivatives and sin² = 1 − cos²: it finds that a circle has a constant
speed and curvature.

It multiplies out, so it suits short formulas only: `TooLong` is raised for others.
"""

from __future__ import annotations

import re
from collections.abc import Container, Iterable
from fractions import Fraction
from math import isqrt

from cases.expression_graph import ONE, ZERO, Node, call, in_order, node

# A sum of more products is not multiplied out: those of lines, circles and ellipses have up to six.
MOST_PRODUCTS = 16
# A longer expression is not multiplied out, as it would take milliseconds and gain nothing.
MOST_OPERATIONS = 60

Number = int | Fraction
Powers = tuple[tuple["Factor", Number], ...]  # factors with their powers, sorted by their text

_HALF = Fraction(1, 2)


# Texts of the symbols that are positive: the lifted constants of formulas, and the plate's.
_SIZE = re.compile(r"symbol\(((\w+_)?c\d+|G|m)\)")


class TooLong(Exception):
    """A formula for which this algebra does not pay off."""


class Factor:
    """A symbol, a function of a sum, or a sum that is raised to a power; equal if the texts are equal."""

    __slots__ = ("text", "function", "argument")

    def __init__(self, function: str, argument: Node | Sum):
        self.function, self.argument = function, argument
        self.text = f"{function}({argument.text if isinstance(argument, Sum) else argument})"

    def __eq__(self, other) -> bool:
        return isinstance(other, Factor) and self.text == other.text

    def __hash__(self) -> int:
        return hash(self.text)

    def node(self) -> Node:
        if isinstance(self.argument, Node):
            return self.argument
        inner = self.argument.node()
        return inner if self.function == "sum" else call(self.function, inner)


class Sum:
    """A sum of products: the coefficient of each."""

    __slots__ = ("products",)

    def __init__(self, products: dict[Powers, Number]):
        if len(products) > MOST_PRODUCTS:
            raise TooLong
        self.products = products

    @property
    def text(self) -> str:
        """A text that equal sums share."""
        return "+".join(sorted(f"{c}*{[(f.text, str(p)) for f, p in powers]}" for powers, c in self.products.items()))

    def __add__(self, other: Sum) -> Sum:
        products = dict(self.products)
        for powers, coefficient in other.products.items():
            total = products.pop(powers, 0) + coefficient
            if total:
                products[powers] = total
        return Sum(products)

    def __sub__(self, other: Sum) -> Sum:
        return self + number(-1) * other

    def __mul__(self, other: Sum) -> Sum:
        result = number(0)
        for a, p in self.products.items():
            for b, q in other.products.items():
                result += _reduced(Sum({_times(a, b): p * q}))
        return result

    def __pow__(self, power: Number) -> Sum:
        if power == 0:
            return number(1)
        if len(self.products) == 1:
            ((powers, c),) = self.products.items()
            root = _number_power(c, power)
            if root is not None and all(isinstance(p * power, int) or _whole(p * power) for _, p in powers):
                if _whole(power) or all(_is_positive(f) or p % 2 for f, p in powers):
                    return Sum({tuple((f, _short(p * power)) for f, p in powers): root})
        if _whole(power) and 0 < power <= 4:
            result = self
            for _ in range(int(power) - 1):
                result = result * self
            return result
        return _factor("sum", self, power)

    def derivative(self, by: Node) -> Sum:
        """The derivative by a symbol."""
        result = number(0)
        for powers, coefficient in self.products.items():
            for factor, power in powers:
                slope = _slope(factor, by)
                if slope.products:
                    rest = Sum({_times(powers, ((factor, -1),)): coefficient * power})
                    result += rest * slope
        return result

    def node(self) -> Node:
        """As a node, with what all products share in front."""
        if not self.products:
            return ZERO
        shared = _shared(self.products) if len(self.products) > 1 else {}
        total = ZERO
        for powers, coefficient in self.products.items():
            total += _product_node(((f, p - shared.get(f, 0)) for f, p in powers), coefficient)
        return total * _product_node(shared.items(), 1) if shared else total


def shorter(value: Node, moving: Container[Node]) -> Node:
    """The node, multiplied out if it then has fewer operations that depend on symbols in `moving`."""
    before = operations([value], moving)
    if before > MOST_OPERATIONS:
        return value
    try:
        result = from_node(value).node()
    except TooLong:
        return value
    return result if operations([result], moving) < before else value


def operations(values: Iterable[Node], moving: Container[Node]) -> int:
    """The number of operations that depend on symbols in `moving`."""
    return sum(1 for part in in_order(values) if part.op != "symbol" and any(s in moving for s in part.symbols))


def number(value: Number) -> Sum:
    """A number as a sum."""
    return Sum({(): value} if value else {})


def from_node(value: Node, known: dict[Node, Sum] | None = None) -> Sum:
    """The sum of a node; raises TooLong."""
    known = {} if known is None else known
    if value not in known:
        known[value] = _converted(value, known)
    return known[value]


def _converted(value: Node, known: dict[Node, Sum]) -> Sum:
    if value.op == "number" and isinstance(value.args[0], int | Fraction):
        return number(value.args[0])
    if value.op in ("number", "symbol"):
        return _factor(value.op, value)
    x = from_node(value.args[0], known)
    if value.op == "**":
        power = value.args[1]
        if power.op != "number" or not isinstance(power.args[0], int | Fraction):
            raise TooLong
        return x ** power.args[0]
    if value.op not in "+-*/":
        return _factor(value.op, x)
    y = from_node(value.args[1], known)
    return x + y if value.op == "+" else x - y if value.op == "-" else x * y if value.op == "*" else x * y**-1


def _factor(function: str, argument: Node | Sum, power: Number = 1) -> Sum:
    return Sum({((Factor(function, argument), power),): 1})


def _times(a: Powers, b: Powers) -> Powers:
    powers = dict(a)
    for factor, power in b:
        total = powers.pop(factor, 0) + power
        if total:
            powers[factor] = _short(total)
    return tuple(sorted(powers.items(), key=lambda item: item[0].text))


def _reduced(value: Sum) -> Sum:
    """A product without sin²: 1 − cos² in its place."""
    ((powers, coefficient),) = value.products.items()
    square = next((f for f, p in powers if f.function == "sin" and p >= 2), None)
    if square is None:
        return value
    rest = Sum({_times(powers, ((square, -2),)): coefficient})
    return rest - rest * _factor("cos", square.argument, 2)


def _number_power(value: Number, power: Number) -> Number | None:
    """An exact power of a number, None if there is none."""
    if _whole(power):
        return _short(Fraction(value) ** int(power))
    if abs(power) != _HALF or value <= 0:
        return None
    value = Fraction(value)
    root = Fraction(isqrt(value.numerator), isqrt(value.denominator))
    return _short(root if power > 0 else 1 / root) if root**2 == value else None


def _whole(value: Number) -> bool:
    return Fraction(value).denominator == 1


def _short(value: Number) -> Number:
    return int(value) if _whole(value) else value


def _is_positive(factor: Factor) -> bool:
    """Whether the factor is positive: sizes are lifted as positive symbols, and a sum under a root is a square."""
    return factor.function in ("exp", "cosh", "sum") or _SIZE.fullmatch(factor.text) is not None


_SLOPES = {
    "sin": lambda u: _factor("cos", u),
    "cos": lambda u: number(-1) * _factor("sin", u),
    "tan": lambda u: number(1) + _factor("tan", u, 2),
    "exp": lambda u: _factor("exp", u),
    "log": lambda u: u**-1,
    "sinh": lambda u: _factor("cosh", u),
    "cosh": lambda u: _factor("sinh", u),
    "tanh": lambda u: number(1) - _factor("tanh", u, 2),
    "atan": lambda u: (number(1) + u**2) ** -1,
    "asin": lambda u: (number(1) - u**2) ** -_HALF,
    "acos": lambda u: number(-1) * (number(1) - u**2) ** -_HALF,
}


def _slope(factor: Factor, by: Node) -> Sum:
    if isinstance(factor.argument, Node):
        return number(1 if factor.argument is by else 0)
    inner = factor.argument.derivative(by)
    return (
        inner if factor.function == "sum" or not inner.products else _SLOPES[factor.function](factor.argument) * inner
    )


def _shared(products: Iterable[Powers]) -> dict[Factor, Number]:
    """The factors of all products, with their lowest powers."""
    first, *others = map(dict, products)
    shared = first
    for powers in others:
        shared = {f: min(p, powers[f]) for f, p in shared.items() if f in powers}
    return shared


def _product_node(powers: Iterable[tuple[Factor, Number]], coefficient: Number) -> Node:
    above, below = node(coefficient), ONE
    for factor, power in powers:
        if power > 0:
            above *= factor.node() ** node(power)
        elif power < 0:
            below *= factor.node() ** node(-power)
    return above / below
