"""Quantities as nodes of a graph, whose Taylor coefficients in time follow from each other (automatic differentiation).

Coefficients are intervals of mpmath, as pairs of its raw numbers: every operation rounds outward.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

from mpmath import iv
from mpmath.libmp import mpi_add, mpi_div, mpi_mul, mpi_neg, mpi_sub

Raw = tuple[Any, Any]


def raw(value: Fraction | int) -> Raw:
    """An interval that contains a rational number."""
    fraction = Fraction(value)
    return (iv.mpf(fraction.numerator) / iv.mpf(fraction.denominator))._mpi_


def number(pair: Raw) -> Any:
    """A raw interval as one of mpmath's."""
    return iv.make_mpf(pair)


ZERO: Raw = iv.mpf(0)._mpi_


def dot(a: Sequence[Raw], b: Sequence[Raw], low: int, high: int, k: int) -> Raw:
    """Σ a_j b_(k−j) for j from `low` to below `high`."""
    total, precision = ZERO, iv.prec
    for j in range(low, high):
        x, y = a[j], b[k - j]
        if x != ZERO and y != ZERO:
            total = mpi_add(total, mpi_mul(x, y, precision), precision)
    return total


class Graph:
    """Nodes in the order in which they are computed. A node is its index; `c[node]` are its coefficients."""

    def __init__(self) -> None:
        self.c: list[list[Raw]] = []
        self._rules: list[Callable[[int], Raw | None]] = []
        self._known: dict[Any, int] = {}
        self._keys: list[Any] = []

    def _node(self, key: Any, rule: Callable[[int], Raw | None]) -> int:
        if key not in self._known:
            self._known[key] = len(self.c)
            self._keys.append(key)
            self.c.append([])
            self._rules.append(rule)
        return self._known[key]

    def clear(self) -> None:
        for coefficients in self.c:
            coefficients.clear()

    def compute(self, k: int) -> None:
        """The k-th coefficients of all nodes, from the lower ones and the variables' k-th."""
        for coefficients, rule in zip(self.c, self._rules, strict=True):
            value = rule(k)
            if value is not None:
                coefficients.append(value)

    # --- nodes ----------------------------------------------------------------------------------------------------

    def variable(self, name: str) -> int:
        """A node whose coefficients are set from outside."""
        return self._node(("variable", name), lambda k: None)

    def constant(self, value: Fraction | int) -> int:
        fraction = Fraction(value)
        return self._node(("constant", fraction), lambda k: raw(fraction) if k == 0 else ZERO)

    def pi(self) -> int:
        return self._node("pi", lambda k: iv.pi._mpi_ if k == 0 else ZERO)

    def add(self, a: int, b: int) -> int:
        A, B = self._lists(a, b)
        return self._node(("+", a, b), lambda k: mpi_add(A[k], B[k], iv.prec))

    def sub(self, a: int, b: int) -> int:
        A, B = self._lists(a, b)
        return self._node(("-", a, b), lambda k: mpi_sub(A[k], B[k], iv.prec))

    def mul(self, a: int, b: int) -> int:
        A, B = self._lists(a, b)
        return self._node(("*", a, b), lambda k: dot(A, B, 0, k + 1, k))

    def sum_of_products(self, a: int, b: int, c: int, d: int) -> int:
        """a b + c d, which is a constant where it is q sin² u + q cos² u with a number q: intervals do not see that."""
        pairs = [(self._scale(x), self._scale(y)) for x, y in ((a, b), (c, d))]
        factors = {one[0] * other[0] for one, other in pairs}
        keys = [self._keys[part[1]] for pair in pairs for part in pair]
        if len(factors) == 1 and keys[0] == keys[1] and keys[2] == keys[3]:
            match keys[0], keys[2]:
                case (("sin", u), ("cos", w)) | (("cos", u), ("sin", w)) if u == w:
                    return self.constant(factors.pop())
        return self.add(self.mul(a, b), self.mul(c, d))

    def _scale(self, node: int) -> tuple[Fraction, int]:
        """A node as a number times another node."""
        match self._keys[node]:
            case ("*", a, b) if (factor := self._value(a)) is not None:
                scale, inner = self._scale(b)
                return factor * scale, inner
            case ("*", a, b) if (factor := self._value(b)) is not None:
                scale, inner = self._scale(a)
                return factor * scale, inner
            case ("/", a, b) if self._value(b):
                scale, inner = self._scale(a)
                return scale / (self._value(b) or 1), inner
            case ("-", a, b) if self._value(a) == 0:
                scale, inner = self._scale(b)
                return -scale, inner
        return Fraction(1), node

    def _value(self, node: int) -> Fraction | None:
        """The number of a constant node, else None."""
        key = self._keys[node]
        return key[1] if isinstance(key, tuple) and key[0] == "constant" else None

    def div(self, a: int, b: int) -> int:
        A, B = self._lists(a, b)

        def rule(k: int) -> Raw:
            Q = self.c[node]
            return divide(mpi_sub(A[k], dot(Q, B, 0, k, k), iv.prec), B[0])

        node = self._node(("/", a, b), rule)
        return node

    def sqrt(self, a: int) -> int:
        (A,) = self._lists(a)

        def rule(k: int) -> Raw:
            R = self.c[node]
            if k == 0:
                return iv.sqrt(_positive(A[0]))._mpi_
            return divide(mpi_sub(A[k], dot(R, R, 1, k, k), iv.prec), mpi_add(R[0], R[0], iv.prec))

        node = self._node(("sqrt", a), rule)
        return node

    def exp(self, a: int) -> int:
        (A,) = self._lists(a)

        def rule(k: int) -> Raw:
            return iv.exp(number(A[0]))._mpi_ if k == 0 else self._weigh(A, self.c[node], k)

        node = self._node(("exp", a), rule)
        return node

    def log(self, a: int) -> int:
        (A,) = self._lists(a)

        def rule(k: int) -> Raw:
            if k == 0:
                return iv.log(_positive(A[0]))._mpi_
            L = self.c[node]
            lower = ZERO
            for j in range(1, k):
                lower = mpi_add(lower, mpi_mul(raw(Fraction(j, k)), mpi_mul(L[j], A[k - j], iv.prec), iv.prec), iv.prec)
            return divide(mpi_sub(A[k], lower, iv.prec), A[0])

        node = self._node(("log", a), rule)
        return node

    def sin_cos(self, a: int) -> tuple[int, int]:
        (A,) = self._lists(a)

        def sine(k: int) -> Raw:
            return iv.sin(number(A[0]))._mpi_ if k == 0 else self._weigh(A, self.c[cosine_node], k)

        def cosine(k: int) -> Raw:
            return iv.cos(number(A[0]))._mpi_ if k == 0 else mpi_neg(self._weigh(A, self.c[sine_node], k))

        sine_node = self._node(("sin", a), sine)
        cosine_node = self._node(("cos", a), cosine)
        return sine_node, cosine_node

    def _weigh(self, A: Sequence[Raw], other: Sequence[Raw], k: int) -> Raw:
        """Σ j a_j o_(k−j)/k for j from 1 to k: the rule of a function whose derivative is `other`."""
        total = ZERO
        for j in range(1, k + 1):
            if A[j] != ZERO and other[k - j] != ZERO:
                total = mpi_add(total, mpi_mul(raw(j), mpi_mul(A[j], other[k - j], iv.prec), iv.prec), iv.prec)
        return divide(total, raw(k))

    def _lists(self, *nodes: int) -> list[list[Raw]]:
        return [self.c[node] for node in nodes]


def divide(a: Raw, b: Raw) -> Raw:
    if 0 in number(b):
        raise ZeroDivisionError("division by an interval that contains 0")
    return mpi_div(a, b, iv.prec)


def _positive(a: Raw) -> Any:
    value = number(a)
    if not value > 0:
        raise ZeroDivisionError("a root or logarithm of an interval that is not positive")
    return value
