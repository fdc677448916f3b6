"""Formulas of a record as nodes of a graph, with derivatives by the parameter s. Nothing of a record is executed."""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction

from .graph import Graph

# A formula's node and, where a variable is s, the nodes of its first and second derivative by s.
Jet = tuple[int, int, int]


class Formula:
    """A formula in the graph's variables, from its text: a syntax tree of numbers, names, + - * / ** and functions."""

    def __init__(self, graph: Graph, variables: Mapping[str, int]):
        self.graph, self.variables = graph, variables
        self.zero = graph.constant(0)

    def node(self, text: str) -> int:
        """The node of a formula."""
        return self.jet(text)[0]

    def jet(self, text: str) -> Jet:
        """The nodes of a formula and of its derivatives by s. Raises ValueError if it cannot be read."""
        return self._jet(ast.parse(text, mode="eval").body)

    def _jet(self, tree: ast.expr) -> Jet:
        g, zero = self.graph, self.zero
        match tree:
            case ast.Constant(value=int() as value):
                return g.constant(value), zero, zero
            case ast.Name(id="pi"):
                return g.pi(), zero, zero
            case ast.Name(id=name) if name in self.variables:
                return self.variables[name], g.constant(int(name == "s")), zero
            case ast.UnaryOp(op=ast.USub(), operand=inner):
                x, y, z = (g.sub(zero, part) for part in self._jet(inner))
                return x, y, z
            case ast.BinOp(left=left, op=ast.Add() | ast.Sub() as op, right=right):
                x, y, z = map(g.add if isinstance(op, ast.Add) else g.sub, self._jet(left), self._jet(right))
                return x, y, z
            case ast.BinOp(left=left, op=ast.Mult(), right=right):
                return self._product(self._jet(left), self._jet(right))
            case ast.BinOp(left=left, op=ast.Div(), right=right):
                return self._quotient(self._jet(left), self._jet(right))
            case ast.BinOp(left=left, op=ast.Pow(), right=right):
                u, n = self._jet(left), rational(right)
                slopes = ((n, n - 1), (n * (n - 1), n - 2))
                return self._chain(
                    u, self._power(u[0], n), lambda: [g.mul(g.constant(c), self._power(u[0], m)) for c, m in slopes]
                )
            case ast.Call(func=ast.Name(id=name), args=[inner]):
                u = self._jet(inner)
                value = self._call(name, u[0])
                return self._chain(u, value, lambda: self._slopes(name, u[0], value))
        raise ValueError(f"a record has a formula that cannot be read: {ast.unparse(tree)}")

    def _product(self, a: Jet, b: Jet) -> Jet:
        g = self.graph
        first = g.add(g.mul(a[1], b[0]), g.mul(a[0], b[1]))
        ends = g.add(g.mul(a[2], b[0]), g.mul(a[0], b[2]))
        return g.mul(a[0], b[0]), first, g.add(ends, g.mul(g.constant(2), g.mul(a[1], b[1])))

    def _quotient(self, a: Jet, b: Jet) -> Jet:
        g = self.graph
        value = g.div(a[0], b[0])
        if b[1:] == (self.zero, self.zero):
            return value, self._over(a[1], b[0]), self._over(a[2], b[0])
        first = g.div(g.sub(a[1], g.mul(value, b[1])), b[0])
        rest = g.add(g.mul(value, b[2]), g.mul(g.constant(2), g.mul(first, b[1])))
        return value, first, g.div(g.sub(a[2], rest), b[0])

    def _over(self, a: int, b: int) -> int:
        return a if a == self.zero else self.graph.div(a, b)

    def _chain(self, u: Jet, value: int, slopes: Callable[[], Sequence[int]]) -> Jet:
        """A function of u, whose value is given and its first and second derivative are computed if u has one."""
        if u[1:] == (self.zero, self.zero):
            return value, self.zero, self.zero
        g, (first, second) = self.graph, slopes()
        return value, g.mul(first, u[1]), g.add(g.mul(second, g.mul(u[1], u[1])), g.mul(first, u[2]))

    def _power(self, base: int, exponent: Fraction) -> int:
        g = self.graph
        if exponent.denominator == 2:
            base, exponent = g.sqrt(base), exponent * 2
        if exponent.denominator != 1:
            return g.exp(g.mul(g.constant(exponent), g.log(base)))
        result = g.constant(1)
        for _ in range(abs(exponent.numerator)):
            result = g.mul(result, base)
        return result if exponent >= 0 else g.div(g.constant(1), result)

    def _call(self, name: str, a: int) -> int:
        g = self.graph
        if name in ("sin", "cos"):
            return g.sin_cos(a)[name == "cos"]
        if name == "tan":
            return g.div(*g.sin_cos(a))
        if name in ("sinh", "cosh", "tanh"):
            grows, falls = g.exp(a), g.exp(g.sub(self.zero, a))
            odd, even = g.sub(grows, falls), g.add(grows, falls)
            return g.div(odd, even) if name == "tanh" else g.div(odd if name == "sinh" else even, g.constant(2))
        if name in ("sqrt", "exp", "log"):
            return getattr(g, name)(a)
        raise ValueError(f"a record has the function {name}, which the checker does not cover")

    def _slopes(self, name: str, a: int, value: int) -> tuple[int, int]:
        """The first and second derivative of a function at a, where it has the value."""
        g, one, two = self.graph, self.graph.constant(1), self.graph.constant(2)
        opposite, twice = g.sub(self.zero, value), g.mul(two, value)
        if name in ("sin", "cos"):
            other = self._call("cos" if name == "sin" else "sin", a)
            return other if name == "sin" else g.sub(self.zero, other), opposite
        if name in ("tan", "tanh"):
            first = (g.add if name == "tan" else g.sub)(one, g.mul(value, value))
            return first, g.mul(twice if name == "tan" else g.sub(self.zero, twice), first)
        if name in ("sinh", "cosh"):
            return self._call("cosh" if name == "sinh" else "sinh", a), value
        if name == "exp":
            return value, value
        first = g.div(one, a if name == "log" else twice)
        return first, g.sub(self.zero, g.mul(first, first) if name == "log" else g.div(first, g.mul(two, a)))


def rational(tree: ast.expr) -> Fraction:
    """A number written with integers, + - * / and brackets."""
    match tree:
        case ast.Constant(value=int() as value):
            return Fraction(value)
        case ast.UnaryOp(op=ast.USub(), operand=inner):
            return -rational(inner)
        case ast.BinOp(left=left, op=ast.Div(), right=right):
            return rational(left) / rational(right)
    raise ValueError(f"a record has an exponent that is no rational number: {ast.unparse(tree)}")
