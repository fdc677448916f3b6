"""Formulas of a record as nodes of a graph, with derivatives by the parameter s. Nothing of a record is executed."""

from __future__ import annotations

import ast
from collections.abc import Mapping
from fractions import Fraction

from .graph import Graph


class Formula:
    """A formula in the graph's variables, from its text: a syntax tree of numbers, names, + - * / ** and functions."""

    def __init__(self, graph: Graph, variables: Mapping[str, int]):
        self.graph, self.variables = graph, variables

    def node(self, tree: ast.expr) -> int:
        g = self.graph
        match tree:
            case ast.Constant(value=int() as value):
                return g.constant(value)
            case ast.Name(id="pi"):
                return g.pi()
            case ast.Name(id=name) if name in self.variables:
                return self.variables[name]
            case ast.UnaryOp(op=ast.USub(), operand=inner):
                return g.sub(g.constant(0), self.node(inner))
            case ast.BinOp(left=left, op=ast.Add(), right=right):
                return g.add(self.node(left), self.node(right))
            case ast.BinOp(left=left, op=ast.Sub(), right=right):
                return g.sub(self.node(left), self.node(right))
            case ast.BinOp(left=left, op=ast.Mult(), right=right):
                return g.mul(self.node(left), self.node(right))
            case ast.BinOp(left=left, op=ast.Div(), right=right):
                return g.div(self.node(left), self.node(right))
            case ast.BinOp(left=left, op=ast.Pow(), right=right):
                return self._power(self.node(left), rational(right))
            case ast.Call(func=ast.Name(id=name), args=[inner]):
                return self._call(name, self.node(inner))
        raise ValueError(f"a record has a formula that cannot be read: {ast.unparse(tree)}")

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
            grows, falls = g.exp(a), g.exp(g.sub(g.constant(0), a))
            odd, even = g.sub(grows, falls), g.add(grows, falls)
            return g.div(odd, even) if name == "tanh" else g.div(odd if name == "sinh" else even, g.constant(2))
        if name in ("sqrt", "exp", "log"):
            return getattr(g, name)(a)
        raise ValueError(f"a record has the function {name}, which the checker does not cover")


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


def parse(text: str) -> ast.expr:
    return ast.parse(text, mode="eval").body


def derivative(tree: ast.expr) -> ast.expr:
    """The derivative by s of a formula in s, by the rules of calculus."""
    zero, one = ast.Constant(0), ast.Constant(1)
    if not _has_parameter(tree):
        return zero
    match tree:
        case ast.Name():
            return one
        case ast.UnaryOp(operand=inner):
            return _minus(zero, derivative(inner))
        case ast.BinOp(left=left, op=ast.Add() | ast.Sub(), right=right):
            return _simple(derivative(left), tree.op, derivative(right))
        case ast.BinOp(left=left, op=ast.Mult(), right=right):
            return _plus(_times(derivative(left), right), _times(left, derivative(right)))
        case ast.BinOp(left=left, op=ast.Div(), right=right) if not _has_parameter(right):
            return _over(derivative(left), right)
        case ast.BinOp(left=left, op=ast.Div(), right=right):
            above = _minus(_times(derivative(left), right), _times(left, derivative(right)))
            return _over(above, _times(right, right))
        case ast.BinOp(left=left, op=ast.Pow(), right=right):
            n = rational(right)
            lower = _over(ast.Constant((n - 1).numerator), ast.Constant((n - 1).denominator))
            factor = _over(ast.Constant(n.numerator), ast.Constant(n.denominator))
            return _times(_times(factor, ast.BinOp(left, ast.Pow(), lower)), derivative(left))
        case ast.Call(func=ast.Name(id=name), args=[inner]):
            return _times(_outer(name, inner), derivative(inner))
    raise ValueError(f"a record has a formula that cannot be read: {ast.unparse(tree)}")


def _has_parameter(tree: ast.expr) -> bool:
    return any(isinstance(node, ast.Name) and node.id == "s" for node in ast.walk(tree))


def _outer(name: str, u: ast.expr) -> ast.expr:
    """The derivative of a function at u."""

    def call(other: str) -> ast.expr:
        return ast.Call(ast.Name(other), [u], [])

    one = ast.Constant(1)
    rules = {
        "sin": call("cos"),
        "cos": _minus(ast.Constant(0), call("sin")),
        "tan": _plus(one, _times(call("tan"), call("tan"))),
        "sinh": call("cosh"),
        "cosh": call("sinh"),
        "tanh": _minus(one, _times(call("tanh"), call("tanh"))),
        "exp": call("exp"),
        "log": _over(one, u),
        "sqrt": _over(one, _times(ast.Constant(2), call("sqrt"))),
    }
    if name not in rules:
        raise ValueError(f"a record has the function {name}, which the checker does not cover")
    return rules[name]


def _simple(a: ast.expr, op: ast.operator, b: ast.expr) -> ast.expr:
    """a op b without terms and factors that are zero or one."""
    if isinstance(op, ast.Mult) and (_is(a, 0) or _is(b, 1)) or isinstance(op, ast.Div) and (_is(a, 0) or _is(b, 1)):
        return a
    if isinstance(op, ast.Mult) and (_is(b, 0) or _is(a, 1)) or isinstance(op, ast.Add) and _is(a, 0):
        return b
    if isinstance(op, ast.Add | ast.Sub) and _is(b, 0):
        return a
    return ast.BinOp(a, op, b)


def _is(tree: ast.expr, value: int) -> bool:
    return isinstance(tree, ast.Constant) and tree.value == value


def _plus(a: ast.expr, b: ast.expr) -> ast.expr:
    return _simple(a, ast.Add(), b)


def _minus(a: ast.expr, b: ast.expr) -> ast.expr:
    return _simple(a, ast.Sub(), b)


def _times(a: ast.expr, b: ast.expr) -> ast.expr:
    return _simple(a, ast.Mult(), b)


def _over(a: ast.expr, b: ast.expr) -> ast.expr:
    return _simple(a, ast.Div(), b)
