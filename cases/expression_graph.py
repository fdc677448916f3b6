"""Expressions recorded by plain arithmetic, their derivatives, and Python functions written from them.

Authors write curves and loads in SymPy; equations are derived on `Node`s. Equal expressions are one object, so that a
common part is computed once; sums with 0, products with 0 and 1 and double signs vanish as they are recorded, and
nothing else is changed: the operations of the written code are those of the derivation, in its order.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from fractions import Fraction
from functools import lru_cache
from typing import Any, NamedTuple
from weakref import WeakValueDictionary

import numpy as np
import sympy as sp

from .derivation import in_one_thread
from .quadrature import integral_function

_ARITHMETIC = ("+", "-", "*", "/", "**")
_EXACT = int | Fraction
_HALF = Fraction(1, 2)

# Python's parser reads at most two hundred nested brackets.
DEEPEST = 40

# Functions that written code may call, for floats and for arrays.
_NAMES = ("sin", "cos", "tan", "exp", "log", "sqrt", "sinh", "cosh", "tanh")
ON_FLOATS = {name: getattr(math, name) for name in (*_NAMES, "asin", "acos", "atan")}
ON_ARRAYS = {name: getattr(np, name) for name in _NAMES} | {
    name: getattr(np, f"arc{name[1:]}") for name in ("asin", "acos", "atan")
}


def _operator(op: str, swap: bool = False) -> Callable[[Node, Node | float | Fraction], Node]:
    """A node's method for an operation with a node or a number; `swap`: with the other one first."""

    def apply(self: Node, other: Node | float | Fraction) -> Node:
        if not isinstance(other, Node | int | float | Fraction):
            return NotImplemented
        return _make(op, node(other), self) if swap else _make(op, self, node(other))

    return apply


class Node:
    """A number, a symbol, or an operation on other nodes; `symbols` are those in it."""

    __slots__ = ("op", "args", "symbols", "__weakref__")
    op: str
    args: tuple
    symbols: frozenset[Node]

    __add__, __radd__ = _operator("+"), _operator("+", swap=True)
    __sub__, __rsub__ = _operator("-"), _operator("-", swap=True)
    __mul__, __rmul__ = _operator("*"), _operator("*", swap=True)
    __truediv__, __rtruediv__ = _operator("/"), _operator("/", swap=True)
    __pow__ = _operator("**")

    def __neg__(self) -> Node:
        return _make("*", _MINUS, self)

    def __abs__(self) -> Node:
        return call("abs", self)

    @property
    def name(self) -> str:
        """The name of a symbol."""
        return self.args[0]

    def __repr__(self) -> str:
        return str(self.args[0]) if self.op in ("number", "symbol") else f"{self.op}{self.args!r}"


_nodes: WeakValueDictionary[tuple, Node] = WeakValueDictionary()


@in_one_thread
def _record(op: str, *args) -> Node:
    """The node of an operation: always the same object for the same operation on the same nodes."""
    key = (op, type(args[0]), *args) if op == "number" else (op, *args)
    result = _nodes.get(key)
    if result is None:
        result = Node()
        result.op, result.args = op, args
        parts = args if op not in ("number", "symbol") else ()
        result.symbols = frozenset([result]) if op == "symbol" else frozenset().union(*(a.symbols for a in parts))
        _nodes[key] = result
    return result


def symbol(name: str) -> Node:
    """A symbol."""
    return _record("symbol", name)


def node(value) -> Node:
    """A number as a node; a node stays as it is."""
    if isinstance(value, Node):
        return value
    return _record("number", value.numerator if isinstance(value, Fraction) and value.denominator == 1 else value)


def call(function: str, *arguments: Node) -> Node:
    """A function of nodes: by its name in `cases.expressions`, or an integral, by its own."""
    return _record(function, *arguments)


_MINUS, ZERO, ONE = node(-1), node(0), node(1)


def sqrt(value: Node) -> Node:
    """The square root of a node."""
    return value**_HALF


def _is_exact(value: Node) -> bool:
    return value.op == "number" and isinstance(value.args[0], _EXACT)


def _opposite(value: Node) -> Node | None:
    """x if the node is −x."""
    return value.args[1] if value.op == "*" and value.args[0] is _MINUS else None


def _make(op: str, x: Node, y: Node) -> Node:
    """The node of x op y, without what changes no value."""
    if _is_exact(x) and _is_exact(y):
        a, b = x.args[0], y.args[0]
        if op in "+-*":
            return node(a + b if op == "+" else a - b if op == "-" else a * b)
        if op == "/" and b:
            return node(Fraction(a) / b)
        if op == "**" and isinstance(b, int) and (a or b > 0):
            return node(Fraction(a) ** b)
    return _RULES[op](x, y) or _record(op, x, y)


def _sum(x: Node, y: Node) -> Node | None:
    if x is ZERO or y is ZERO:
        return y if x is ZERO else x
    if (opposite := _opposite(y)) is not None:
        return x - opposite
    return y - opposite if (opposite := _opposite(x)) is not None else None


def _difference(x: Node, y: Node) -> Node | None:
    if y is ZERO:
        return x
    if x is ZERO or x is y:
        return ZERO if x is y else -y
    return x + opposite if (opposite := _opposite(y)) is not None else None


def _product(x: Node, y: Node) -> Node | None:
    if x is ZERO or y is ZERO:
        return ZERO
    if x is ONE or y is ONE:
        return y if x is ONE else x
    # Signs move outwards, so that they meet and vanish.
    if (opposite := _opposite(x)) is not None:
        return -(opposite * y)
    if (opposite := _opposite(y)) is not None:
        return opposite if x is _MINUS else -(x * opposite)
    if y is _MINUS:
        return -x
    for part, other in ((x, y), (y, x)):
        if part.op == "/" and part.args[1] is other:
            return part.args[0]
    return x.args[0] if x is y and x.op == "**" and x.args[1] is node(_HALF) else None


def _quotient(x: Node, y: Node) -> Node | None:
    if x is ZERO or y is ONE:
        return x
    if x is y:
        return ONE
    for part, other in ((x, y), (y, x)):
        if (opposite := _opposite(part)) is not None:
            return -(opposite / other if part is x else other / opposite)
    (a, p), (b, q) = _base_and_power(x), _base_and_power(y)
    if a is b:
        return a ** (p - q)
    if x.op == "*" and y in x.args:
        return x.args[1 if x.args[0] is y else 0]
    return x * b**-q if q < 0 else None


def _base_and_power(value: Node) -> tuple[Node, Any]:
    """(a, p) of a**p with a number p."""
    return (value.args[0], value.args[1].args[0]) if value.op == "**" and _is_exact(value.args[1]) else (value, 1)


def _power(x: Node, y: Node) -> Node | None:
    if y is ONE or x is ONE:
        return x
    if y is ZERO:
        return ONE
    if not (_is_exact(y) and isinstance(y.args[0], int)):
        return None
    if (opposite := _opposite(x)) is not None:
        return -(opposite**y) if y.args[0] % 2 else opposite**y
    base, power = _base_and_power(x)
    return base ** (power * y.args[0]) if base is not x else None


_RULES = {"+": _sum, "-": _difference, "*": _product, "/": _quotient, "**": _power}


# --- from SymPy -------------------------------------------------------------------------------------------------------


@in_one_thread
def from_sympy(expression: sp.Basic, replace: Mapping[sp.Basic, Node] | None = None) -> Node:
    """The node of a formula; symbols keep their names, unless `replace` has other nodes for them."""
    return _from_sympy(sp.sympify(expression), dict(replace or {}))


def _from_sympy(expression: Any, nodes: dict[sp.Basic, Node]) -> Node:
    if expression not in nodes:
        nodes[expression] = _new_node(expression, nodes)
    return nodes[expression]


def _new_node(expression: Any, nodes: dict[sp.Basic, Node]) -> Node:
    if expression.is_Symbol:
        return symbol(expression.name)
    if expression.is_Rational:
        return node(Fraction(int(expression.p), int(expression.q)))
    if expression.is_number:  # π, √2, a floating-point number: SymPy's own value, for any precision
        return node(float(expression) if expression.is_Float else expression)
    if expression.is_Add:
        first, *rest = (_from_sympy(part, nodes) for part in expression.args)
        return sum(rest, first)
    if expression.is_Mul:
        above, below = ONE, ONE
        for part in expression.args:
            if part.is_Pow and part.exp.is_Rational and part.exp < 0:
                below *= _raise(part.base, -part.exp, nodes)
            else:
                above *= _from_sympy(part, nodes)
        return above / below
    if expression.is_Pow and expression.base is not sp.E:
        return _raise(expression.base, expression.exp, nodes)
    if isinstance(expression, sp.Integral):
        return _integral(expression, nodes)
    argument = expression.args[-1]
    return call("exp" if expression.is_Pow else type(expression).__name__, _from_sympy(argument, nodes))


class _Integrand(NamedTuple):
    """What an integral's node means: the bound variable, the integrand, and the constants in it."""

    variable: Node
    formula: Node
    constants: tuple[Node, ...]


# By the names of the nodes' operations.
_INTEGRANDS: dict[str, _Integrand] = {}
_INTEGRAL = "integral"


def _integral(expression: sp.Integral, nodes: dict[sp.Basic, Node]) -> Node:
    """The node of an integral: its arguments are the upper limit, the lower one and the integrand's constants."""
    variable, lower, upper = expression.limits[0]
    formula, bound = _from_sympy(expression.function, nodes), symbol(variable.name)
    constants = tuple(sorted(formula.symbols - {bound}, key=lambda constant: constant.name))
    integrand = _Integrand(bound, formula, constants)
    name = next((name for name, known in _INTEGRANDS.items() if known == integrand), f"{_INTEGRAL}{len(_INTEGRANDS)}")
    _INTEGRANDS[name] = integrand
    return call(name, _from_sympy(upper, nodes), _from_sympy(lower, nodes), *constants)


def _integrand_at(current: Node) -> Node:
    """The integrand at the upper limit of an integral: its derivative by that."""
    variable, formula, constants = _INTEGRANDS[current.op]
    upper, _, *values = current.args
    return substitute([formula], {variable: upper, **dict(zip(constants, values, strict=True))})[0]


@lru_cache(maxsize=256)
def _integral_value(name: str) -> Callable:
    """The function that evaluates an integral's node, on floats and arrays."""
    variable, formula, constants = _INTEGRANDS[name]
    function = python_function([variable, *constants], [formula], ON_ARRAYS)
    return integral_function(lambda *values: function(*values)[0])


def _integral_functions(order: Iterable[Node], functions: Mapping[str, Callable]) -> dict[str, Callable]:
    """The functions of the integrals among some nodes. `functions` may have a wrapper, called "integral", for arguments
    of its own kind: it is given the value and the integrand, both functions of the same arguments."""
    result = {}
    for name in {n.op for n in order if n.op.startswith(_INTEGRAL)}:
        result[name] = _integral_value(name)
        if _INTEGRAL in functions:
            variable, formula, constants = _INTEGRANDS[name]
            slope = python_function([variable, *constants], [formula], functions)
            result[name] = functions[_INTEGRAL](result[name], slope)
    return result


def _raise(base, power, nodes: dict[sp.Basic, Node]) -> Node:
    return _from_sympy(base, nodes) ** _from_sympy(power, nodes)


# --- walks ------------------------------------------------------------------------------------------------------------


def in_order(outputs: Iterable[Node], leaves: Container[Node] = ()) -> dict[Node, None]:
    """All nodes in the outputs, each once and after its parts; the parts of `leaves` are left out."""
    order: dict[Node, None] = {}
    todo = list(outputs)[::-1]
    while todo:
        current = todo[-1]
        is_leaf = current in order or current.op in ("number", "symbol") or current in leaves
        missing = [] if is_leaf else [part for part in current.args if part not in order]
        if missing:
            todo += missing[::-1]
        else:
            order[todo.pop()] = None
    return order


def substitute(outputs: Iterable[Node], replace: Mapping[Node, Node]) -> list[Node]:
    """The outputs with other nodes for some of their parts."""
    outputs = list(outputs)
    results: dict[Node, Node] = {}
    for current in in_order(outputs):
        results[current] = replace[current] if current in replace else _with_parts(current, results)
    return [results[output] for output in outputs]


def _with_parts(current: Node, results: Mapping[Node, Node]) -> Node:
    if current.op in ("number", "symbol"):
        return current
    parts = [results[part] for part in current.args]
    return _make(current.op, *parts) if current.op in _ARITHMETIC else call(current.op, *parts)


_SLOPES: dict[str, Callable[[Node], Node]] = {
    "sin": lambda u: call("cos", u),
    "cos": lambda u: -call("sin", u),
    "tan": lambda u: 1 + call("tan", u) ** 2,
    "exp": lambda u: call("exp", u),
    "log": lambda u: 1 / u,
    "sinh": lambda u: call("cosh", u),
    "cosh": lambda u: call("sinh", u),
    "tanh": lambda u: 1 - call("tanh", u) ** 2,
    "asin": lambda u: 1 / sqrt(1 - u**2),
    "acos": lambda u: -1 / sqrt(1 - u**2),
    "atan": lambda u: 1 / (1 + u**2),
}


def derivatives(outputs: Iterable[Node], by: Node) -> list[Node]:
    """The outputs' derivatives by a symbol, which no exponent contains."""
    outputs = list(outputs)
    slopes: dict[Node, Node] = {}
    for current in in_order(outputs):
        slopes[current] = _slope(current, slopes, by) if by in current.symbols else ZERO
    return [slopes[output] for output in outputs]


def _slope(current: Node, slopes: Mapping[Node, Node], by: Node) -> Node:
    if current is by:
        return ONE
    x, dx = current.args[0], slopes[current.args[0]]
    if current.op.startswith(_INTEGRAL):
        return _integrand_at(current) * dx
    if current.op not in _ARITHMETIC:
        return _SLOPES[current.op](x) * dx
    y, dy = current.args[1], slopes[current.args[1]]
    if current.op == "+":
        return dx + dy
    if current.op == "-":
        return dx - dy
    if current.op == "*":
        return dx * y + x * dy
    return (dx - current * dy) / y if current.op == "/" else y * x ** (y - 1) * dx


# --- Python code ------------------------------------------------------------------------------------------------------


def python_function(
    arguments: Sequence[Node | Sequence[Node]], outputs: Iterable[Node], functions: Mapping[str, Callable]
) -> Callable[..., list]:
    """A function that returns the list of the outputs. Each argument is a node or a sequence of nodes; a node that is
    an argument is not computed. `functions` evaluates the elementary functions, by name: they decide whether arguments
    are floats, arrays or anything else."""
    outputs = list(outputs)
    texts: dict[Node, str] = {}
    names = []
    for i, argument in enumerate(arguments):
        names.append(f"a{i}")
        if isinstance(argument, Node):
            texts[argument] = names[-1]
        else:
            texts.update({part: f"a{i}_{k}" for k, part in enumerate(argument)})
    order = in_order(outputs, texts)
    lines = [
        f"    {', '.join(texts[part] if part in order else '_' for part in argument)}, = {name}"
        for name, argument in zip(names, arguments, strict=True)
        if not isinstance(argument, Node) and any(part in order for part in argument)
    ]
    uses: dict[Node, int] = dict.fromkeys(order, 0)
    for current in [
        *(part for n in order if n not in texts and n.op not in ("number", "symbol") for part in n.args),
        *outputs,
    ]:
        uses[current] += 1
    depths: dict[Node, int] = dict.fromkeys(texts, 0)
    for current in order:
        if current in texts:
            continue
        text, depths[current] = _text(current, texts), 0
        if current.op != "number":
            depths[current] = 1 + max(depths[part] for part in current.args)
            if uses[current] > 1 or depths[current] > DEEPEST:
                lines.append(f"    v{len(lines)} = {text}")
                text, depths[current] = f"v{len(lines) - 1}", 0
        texts[current] = text
    lines.append(f"    return [{', '.join(texts[output] for output in outputs)}]")
    scope = dict(functions) | _integral_functions(order, functions)
    exec("\n".join([f"def evaluate({', '.join(names)}):", *lines]), scope)
    return scope["evaluate"]


def _text(current: Node, texts: Mapping[Node, str]) -> str:
    if current.op == "number":
        return _number_text(current.args[0])
    if current.op == "symbol":
        raise KeyError(f"{current.name} is no argument of the function")
    x = texts[current.args[0]]
    if current.op.startswith(_INTEGRAL):
        return f"{current.op}({', '.join(texts[argument] for argument in current.args)})"
    if current.op not in _ARITHMETIC:
        return f"{current.op}({x})"
    if current.op == "**":
        power = current.args[1].args[0] if _is_exact(current.args[1]) else None
        if power in (_HALF, -_HALF):
            return f"sqrt({x})" if power == _HALF else f"(1/sqrt({x}))"
        if power == -1:
            return f"(1/{x})"
    if current.op == "*" and current.args[0] is _MINUS:
        return f"(-{texts[current.args[1]]})"
    return f"({x}{current.op}{texts[current.args[1]]})"


def _number_text(value) -> str:
    if isinstance(value, Fraction):
        return f"({value.numerator}/{value.denominator})"
    return f"({value})" if isinstance(value, int) else f"({float(value)!r})"


@in_one_thread
def function_of(
    symbols: Sequence[sp.Symbol | Sequence[sp.Symbol]], formulas: Iterable[sp.Expr], functions: Mapping[str, Callable]
) -> Callable[..., list]:
    """A function of SymPy symbols that returns the list of some formulas' values, as `python_function` does."""
    arguments = [symbol(s.name) if isinstance(s, sp.Symbol) else [symbol(part.name) for part in s] for s in symbols]
    return python_function(arguments, map(from_sympy, formulas), functions)
