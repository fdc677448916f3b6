"""An algebra of sums of products of powers, with derivatives and sin² = 1 − cos²: it finds that a circle has a constant
speed and curvature.

It multiplies out, so it suits short formulas only: `TooLong` is raised for long ones.
"""

from __future__ import annotations

import re
from collections.abc import Container, Iterable, Mapping
from fractions import Fraction
from math import isqrt

from cases.formulas.expression_graph import ONE, ZERO, Node, call, derivatives, in_order, node

# A sum of more products is not multiplied out: those of lines, circles and ellipses have up to six.
MOST_PRODUCTS = 16
# Longer formulas, and expressions of several curves that are longer than FEW_NODES, are not multiplied out: it takes
# milliseconds and gains nothing.
MOST_NODES, FEW_NODES = 80, 40

Number = int | Fraction
Powers = tuple[tuple["Factor", Number], ...]  # factors with their powers, sorted by their text

_HALF = Fraction(1, 2)


# Names of the symbols that are positive: the lifted constants of formulas, and the plate's.
_SIZE = re.compile(r"(\w+_)?c\d+|G|m")


class TooLong(Exception):
    """A formula for which this algebra does not pay off."""


class Factor:
    """A symbol, a number, a function of a node, or a sum that is raised to a power; equal if the texts are equal.

    Arguments of functions stay as they are: exp(-(s - c)²) as exp(-s² + 2 c s - c²) overflows for a narrow bump, and a
    multiplied argument loses digits.
    """

    __slots__ = ("content", "text")

    def __init__(self, content: Node | Sum):
        self.content, self.text = content, content.text if isinstance(content, Sum) else repr(content)

    def __eq__(self, other) -> bool:
        return isinstance(other, Factor) and self.text == other.text

    def __hash__(self) -> int:
        return hash(self.text)

    def node(self) -> Node:
        return self.content.node() if isinstance(self.content, Sum) else self.content

    def is_function(self, name: str) -> bool:
        return isinstance(self.content, Node) and self.content.op == name

    def slope(self, by: Node) -> Sum:
        """The derivative by a symbol."""
        if isinstance(self.content, Sum):
            return self.content.derivative(by)
        return from_node(derivatives([self.content], by)[0])

    def is_positive(self) -> bool:
        """Whether it is positive: sizes are lifted as positive symbols, and a sum under a root is a square."""
        if isinstance(self.content, Sum) or self.content.op in ("exp", "cosh"):
            return True
        return self.content.op == "symbol" and _SIZE.fullmatch(self.content.name) is not None


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
                result += _reduce(Sum({_times(a, b): p * q}))
        return result

    def __pow__(self, power: Number) -> Sum:
        if power == 0:
            return number(1)
        if len(self.products) == 1:
            ((powers, c),) = self.products.items()
            root = _number_power(c, power)
            if root is not None and all(isinstance(p * power, int) or _whole(p * power) for _, p in powers):
                if _whole(power) or all(f.is_positive() or p % 2 for f, p in powers):
                    return Sum({tuple((f, _short(p * power)) for f, p in powers): root})
        if _whole(power) and 0 < power <= 4:
            result = self
            for _ in range(int(power) - 1):
                result = result * self
            return result
        return _factor(self, power)

    def derivative(self, by: Node) -> Sum:
        """The derivative by a symbol."""
        result = number(0)
        for powers, coefficient in self.products.items():
            for factor, power in powers:
                slope = factor.slope(by)
                if slope.products:
                    rest = Sum({_times(powers, ((factor, -1),)): coefficient * power})
                    result += rest * slope
        return result

    def node(self) -> Node:
        """As a node, with what all products share in front."""
        if not self.products:
            return ZERO
        common = _common_factors(self.products) if len(self.products) > 1 else {}
        total = ZERO
        for powers, coefficient in self.products.items():
            total += _product_node(((f, p - common.get(f, 0)) for f, p in powers), coefficient)
        return total * _product_node(common.items(), 1) if common else total


def shorter(value: Node, moving: Container[Node]) -> Node:
    """The node, multiplied out if it then has fewer operations that depend on symbols in `moving`."""
    if len(in_order([value])) > FEW_NODES:
        return value
    before = operations([value], moving)
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


def from_node(value: Node) -> Sum:
    """The sum of a node; raises TooLong."""
    order = in_order([value])
    if len(order) > MOST_NODES:
        raise TooLong
    sums: dict[Node, Sum] = {}
    for current in order:
        sums[current] = _convert(current, sums)
    return sums[value]


def _convert(value: Node, sums: Mapping[Node, Sum]) -> Sum:
    if value.op == "number" and isinstance(value.args[0], int | Fraction):
        return number(value.args[0])
    if value.op not in ("+", "-", "*", "/", "**"):
        return _factor(value)
    x, y = (sums[part] for part in value.args)
    if value.op == "**":
        power = value.args[1].args[0]
        if value.args[1].op != "number" or not isinstance(power, int | Fraction):
            raise TooLong
        return x**power
    return x + y if value.op == "+" else x - y if value.op == "-" else x * y if value.op == "*" else x * y**-1


def _factor(content: Node | Sum, power: Number = 1) -> Sum:
    return Sum({((Factor(content), power),): 1})


def _times(a: Powers, b: Powers) -> Powers:
    powers = dict(a)
    for factor, power in b:
        total = powers.pop(factor, 0) + power
        if total:
            powers[factor] = _short(total)
    return tuple(sorted(powers.items(), key=lambda item: item[0].text))


def _reduce(value: Sum) -> Sum:
    """A product without sin²: 1 − cos² in its place."""
    ((powers, coefficient),) = value.products.items()
    square = next((f for f, p in powers if f.is_function("sin") and p >= 2), None)
    if square is None:
        return value
    rest = Sum({_times(powers, ((square, -2),)): coefficient})
    return rest - rest * _factor(call("cos", square.node().args[0]), 2)


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


def _common_factors(products: Iterable[Powers]) -> dict[Factor, Number]:
    """The factors of all products, with their lowest powers."""
    first, *others = map(dict, products)
    common = first
    for powers in others:
        common = {f: min(p, powers[f]) for f, p in common.items() if f in powers}
    return common


def _product_node(powers: Iterable[tuple[Factor, Number]], coefficient: Number) -> Node:
    above, below = node(coefficient), ONE
    for factor, power in powers:
        if power > 0:
            above *= factor.node() ** node(power)
        elif power < 0:
            below *= factor.node() ** node(-power)
    return above / below
