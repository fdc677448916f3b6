"""Quantities as nodes of a graph, whose Taylor coefficients in time follow from each other (automatic differentiation).

Coefficients are fixed-point balls, and they are those of powers of (time since the step's start)/σ. With σ near the
step's length all of them are of the size of their quantity, as fixed-point numbers should be.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from operator import mul as product
from typing import Any

from .balls import ZERO, Ball, FixedPoint, add, sub


class Row:
    """The coefficients of a node: middles, their sizes, radii, and sizes with radii."""

    __slots__ = ("m", "a", "r", "w")

    def __init__(self) -> None:
        self.m, self.a, self.r, self.w = list[int](), list[int](), list[int](), list[int]()

    def append(self, ball: Ball) -> None:
        m, r = ball
        a = -m if m < 0 else m
        self.m.append(m)
        self.a.append(a)
        self.r.append(r)
        self.w.append(a + r)

    def clear(self) -> None:
        for part in (self.m, self.a, self.r, self.w):
            part.clear()

    def __getitem__(self, k: int) -> Ball:
        return self.m[k], self.r[k]

    def balls(self, count: int) -> list[Ball]:
        return list(zip(self.m[:count], self.r[:count], strict=True))

    def cut(self, low: int, high: int) -> Row:
        """A part of the row."""
        part = Row()
        part.m, part.a, part.r, part.w = (own[low:high] for own in (self.m, self.a, self.r, self.w))
        return part


def convolution(A: Row, B: Row) -> tuple[int, int]:
    """Σ a_j b_(n−j), where b_n is the last coefficient of B, up to the end of the shorter row, with twice the bits."""
    middle = sum(map(product, A.m, reversed(B.m)))
    radius = sum(map(product, A.w, reversed(B.r))) + sum(map(product, A.r, reversed(B.a)))
    return middle, radius


class Graph:
    """Nodes in the order in which they are computed. A node is its index; `c[node]` are its coefficients."""

    def __init__(self, arithmetic: FixedPoint) -> None:
        self.f = arithmetic
        self.c: list[Row] = []
        self._rules: list[Callable[[int], Ball | None]] = []
        self._weighted: dict[int, Row] = {}
        self._known: dict[Any, int] = {}
        self._keys: list[Any] = []

    def _node(self, key: Any, rule: Callable[[int], Ball | None]) -> int:
        if key not in self._known:
            self._known[key] = len(self.c)
            self._keys.append(key)
            self.c.append(Row())
            self._rules.append(rule)
        return self._known[key]

    def clear(self) -> None:
        for row in (*self.c, *self._weighted.values()):
            row.clear()

    def compute(self, k: int) -> None:
        """The k-th coefficients of all nodes, from the lower ones and the variables' k-th."""
        for row, rule in zip(self.c, self._rules, strict=True):
            value = rule(k)
            if value is not None:
                row.append(value)

    # --- nodes ----------------------------------------------------------------------------------------------------

    def variable(self, name: str) -> int:
        """A node whose coefficients are set from outside."""
        return self._node(("variable", name), lambda k: None)

    def constant(self, value: Fraction | int) -> int:
        ball = self.f.of(value)
        return self._node(("constant", Fraction(value)), lambda k: ball if k == 0 else ZERO)

    def pi(self) -> int:
        ball = self.f.pi()
        return self._node("pi", lambda k: ball if k == 0 else ZERO)

    def add(self, a: int, b: int) -> int:
        if self._value(a) == 0 or self._value(b) == 0:
            return b if self._value(a) == 0 else a
        A, B = self.c[a], self.c[b]
        return self._node(("+", a, b), lambda k: add(A[k], B[k]))

    def sub(self, a: int, b: int) -> int:
        if self._value(b) == 0:
            return a
        A, B = self.c[a], self.c[b]
        return self._node(("-", a, b), lambda k: sub(A[k], B[k]))

    def mul(self, a: int, b: int) -> int:
        A, B, factors = self.c[a], self.c[b], (self._value(a), self._value(b))
        if 0 in factors:
            return self.constant(0)
        if 1 in factors:
            return b if factors[0] == 1 else a
        f = self.f
        if factors != (None, None):
            one, other = (A, B) if factors[0] is not None else (B, A)
            return self._node(("*", a, b), lambda k: f.mul(one[0], other[k]))
        return self._node(("*", a, b), lambda k: f.rounded(*convolution(A, B)))

    def sum_of_products(self, a: int, b: int, c: int, d: int) -> int:
        """a b + c d, which is a constant where it is q sin² u + q cos² u with a number q: balls do not see that."""
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
        A, B, f = self.c[a], self.c[b], self.f
        if self._value(b) is not None:
            return self._node(("/", a, b), lambda k: f.div(A[k], B[0]))

        def rule(k: int) -> Ball:
            return f.div(sub(A[k], f.rounded(*convolution(self.c[node], B))), B[0])

        node = self._node(("/", a, b), rule)
        return node

    def sqrt(self, a: int) -> int:
        A, f = self.c[a], self.f

        def rule(k: int) -> Ball:
            if k == 0:
                return f.sqrt(A[0])
            R = self.c[node]
            inner = R.cut(1, k)
            m, r = R[0]
            return f.div(sub(A[k], f.rounded(*convolution(inner, inner))), (2 * m, 2 * r))

        node = self._node(("sqrt", a), rule)
        return node

    def exp(self, a: int) -> int:
        A, f = self.c[a], self.f

        def rule(k: int) -> Ball:
            return f.function("exp", A[0]) if k == 0 else self._integral(a, self.c[node], k)

        node = self._node(("exp", a), rule)
        return node

    def log(self, a: int) -> int:
        A, f = self.c[a], self.f

        def rule(k: int) -> Ball:
            if k == 0:
                return f.function("log", A[0])
            weighted = self._weights(node, k - 1)
            lower = f.over(f.rounded(*convolution(weighted, A.cut(0, k))), k)
            return f.div(sub(A[k], lower), A[0])

        node = self._node(("log", a), rule)
        return node

    def sin_cos(self, a: int) -> tuple[int, int]:
        A, f = self.c[a], self.f

        def sine(k: int) -> Ball:
            return f.function("sin", A[0]) if k == 0 else self._integral(a, self.c[cosine_node], k)

        def cosine(k: int) -> Ball:
            if k == 0:
                return f.function("cos", A[0])
            m, r = self._integral(a, self.c[sine_node].cut(0, k), k)
            return -m, r

        sine_node = self._node(("sin", a), sine)
        cosine_node = self._node(("cos", a), cosine)
        return sine_node, cosine_node

    def _integral(self, a: int, other: Row, k: int) -> Ball:
        """Σ j a_j o_(k−j)/k for j from 1 to k: the rule of a function of a whose derivative is `other`, of length k."""
        return self.f.over(self.f.rounded(*convolution(self._weights(a, k), other)), k)

    def _weights(self, node: int, k: int) -> Row:
        """The coefficients 1 … k of a node, each times its index."""
        weighted, own = self._weighted.setdefault(node, Row()), self.c[node]
        for j in range(len(weighted.m) + 1, k + 1):
            m, r = own[j]
            weighted.append((j * m, j * r))
        return weighted
