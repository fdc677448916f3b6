"""Expressions recorded by plain arithmetic, and their derivatives; `expression_code` writes functions from them.

Authors write curves and loads in SymPy; equations are derived on `Node`s. Equal expressions are one object, so that a
common part is computed once; sums with 0, products with 0 and 1 and double signs vanish as they are recorded, and
nothing else is changed: the operations of the written code are those of the derivation, in its order.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Iterator, Mapping
from fractions import Fraction
from typing import Any, NamedTuple
from weakref import ref

from ..derivation import in_one_thread
from . import late_sympy as sp

ARITHMETIC = ("+", "-", "*", "/", "**")
_EXACT = (int, Fraction)
_NUMBERS = (int, float, Fraction)
HALF = Fraction(1, 2)
# Operations without nodes as their arguments.
_LEAVES = ("number", "symbol")


def _operator(op: str, swap: bool = False) -> Callable[[Node, Node | float | Fraction], Node]:
    """A node's method for an operation with a node or a number; `swap`: with the other one first."""

    def apply(self: Node, other: Node | float | Fraction) -> Node:
        if not isinstance(other, Node):
            if not isinstance(other, _NUMBERS):
                return NotImplemented
            other = node(other)
        return _make(op, other, self) if swap else _make(op, self, other)

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
        return _make("*", MINUS, self)

    def __abs__(self) -> Node:
        return call("abs", self)

    @property
    def name(self) -> str:
        """The name of a symbol."""
        return self.args[0]

    def __repr__(self) -> str:
        return str(self.args[0]) if self.op in _LEAVES else f"{self.op}{self.args!r}"


class _Reference(ref[Node]):
    """A reference to a node, which leaves the table with it."""

    __slots__ = ("key",)
    key: tuple


# A table of the kind of weakref.WeakValueDictionary, which takes three times as long.
_nodes: dict[tuple, _Reference] = {}
_NO_SYMBOLS: frozenset[Node] = frozenset()


def _forget(reference: _Reference) -> None:
    if _nodes.get(reference.key) is reference:  # a node of the same operation may have been made since
        del _nodes[reference.key]


def _record(op: str, *args) -> Node:
    """The node of an operation: always the same object for the same operation on the same nodes."""
    key = (op, type(args[0]), *args) if op == "number" else (op, *args)
    reference = _nodes.get(key)
    result = reference() if reference else None
    return _new(key, op, args) if result is None else result


@in_one_thread
def _new(key: tuple, op: str, args: tuple) -> Node:
    """The node of an operation that has none, unless another thread has made it meanwhile."""
    reference = _nodes.get(key)
    result = reference() if reference else None
    if result is None:
        result = Node()
        result.op, result.args = op, args
        result.symbols = frozenset([result]) if op == "symbol" else _NO_SYMBOLS
        if op not in _LEAVES:
            for part in args:  # sets are shared where one contains the other
                more = part.symbols
                result.symbols = more if more >= result.symbols else result.symbols | more
        reference = _Reference(result, _forget)
        reference.key = key
        _nodes[key] = reference
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
    """A function of nodes: by its name in `cases.formulas.expressions`, or an integral, by its own."""
    return _record(function, *arguments)


MINUS, ZERO, ONE = node(-1), node(0), node(1)


def sqrt(value: Node) -> Node:
    """The square root of a node."""
    return value**HALF


def is_exact(value: Node) -> bool:
    return value.op == "number" and isinstance(value.args[0], _EXACT)


def _opposite(value: Node) -> Node | None:
    """x if the node is −x."""
    return value.args[1] if value.op == "*" and value.args[0] is MINUS else None


def _make(op: str, x: Node, y: Node) -> Node:
    """The node of x op y, without what changes no value."""
    if is_exact(x) and is_exact(y):
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
        return opposite if x is MINUS else -(x * opposite)
    if y is MINUS:
        return -x
    for part, other in ((x, y), (y, x)):
        if part.op == "/" and part.args[1] is other:
            return part.args[0]
    return x.args[0] if x is y and x.op == "**" and x.args[1] is node(HALF) else None


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
    return (value.args[0], value.args[1].args[0]) if value.op == "**" and is_exact(value.args[1]) else (value, 1)


def _power(x: Node, y: Node) -> Node | None:
    if y is ONE or x is ONE:
        return x
    if y is ZERO:
        return ONE
    if not (is_exact(y) and isinstance(y.args[0], int)):
        return None
    if (opposite := _opposite(x)) is not None:
        return -(opposite**y) if y.args[0] % 2 else opposite**y
    base, power = _base_and_power(x)
    return base ** (power * y.args[0]) if base is not x else None


_RULES = {"+": _sum, "-": _difference, "*": _product, "/": _quotient, "**": _power}


# --- from SymPy -------------------------------------------------------------------------------------------------------


@in_one_thread
def from_sympy(expression: sp.Basic | Node, replace: Mapping[sp.Basic, Node] | None = None) -> Node:
    """The node of a formula; symbols keep their names, unless `replace` has other nodes for them. A node stays one."""
    if isinstance(expression, Node):
        return substitute([expression], {symbol(key.name): value for key, value in (replace or {}).items()})[0]
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
INTEGRANDS: dict[str, _Integrand] = {}
INTEGRAL = "integral"


def _integral(expression: sp.Integral, nodes: dict[sp.Basic, Node]) -> Node:
    """The node of an integral: its arguments are the upper limit, the lower one and the integrand's constants."""
    variable, lower, upper = expression.limits[0]
    formula, bound = _from_sympy(expression.function, nodes), symbol(variable.name)
    constants = tuple(sorted(formula.symbols - {bound}, key=lambda constant: constant.name))
    integrand = _Integrand(bound, formula, constants)
    name = next((name for name, one in INTEGRANDS.items() if one == integrand), f"{INTEGRAL}{len(INTEGRANDS)}")
    INTEGRANDS[name] = integrand
    return call(name, _from_sympy(upper, nodes), _from_sympy(lower, nodes), *constants)


def _integrand_at(current: Node) -> Node:
    """The integrand at the upper limit of an integral: its derivative by that."""
    variable, formula, constants = INTEGRANDS[current.op]
    upper, _, *values = current.args
    return substitute([formula], {variable: upper, **dict(zip(constants, values, strict=True))})[0]


def _raise(base, power, nodes: dict[sp.Basic, Node]) -> Node:
    return _from_sympy(base, nodes) ** _from_sympy(power, nodes)


# --- walks ------------------------------------------------------------------------------------------------------------


def in_order(outputs: Iterable[Node], leaves: Container[Node] = ()) -> dict[Node, None]:
    """All nodes in the outputs, each once and after its parts; the parts of `leaves` are left out."""
    order: dict[Node, None] = {}
    todo = list(outputs)[::-1]
    while todo:
        current = todo[-1]
        if current in order:
            todo.pop()
            continue
        is_leaf = current.op in _LEAVES or current in leaves
        missing = [] if is_leaf else [part for part in current.args if part not in order]
        if missing:
            todo += missing[::-1]
        else:
            order[todo.pop()] = None
    return order


def integral_depth(formula: Node) -> int:
    """How many integrals contain each other in a formula: 0 without any."""
    inside = (INTEGRANDS[current.op].formula for current in preorder(formula) if current.op.startswith(INTEGRAL))
    return max((1 + integral_depth(integrand) for integrand in inside), default=0)


def lift_numbers(formulas: Iterable[Node]) -> tuple[list[Node], tuple[Node, ...], tuple[float, ...]]:
    """The formulas with ±c0, ±c1, … for their floating-point numbers, those symbols, and the numbers' sizes, each once
    and in the order in which the formulas name them."""
    formulas = [node(formula) for formula in formulas]
    numbers = [current for formula in formulas for current in _leaves(formula) if isinstance(current.args[0], float)]
    sizes = tuple(dict.fromkeys(abs(number.args[0]) for number in numbers))
    symbols = {size: symbol(f"c{i}") for i, size in enumerate(sizes)}
    signed = {number: symbols[abs(number.args[0])] * (1 if number.args[0] > 0 else -1) for number in numbers}
    return substitute(formulas, signed), tuple(symbols.values()), sizes


def _leaves(formula: Node) -> Iterator[Node]:
    """The numbers and symbols in a formula, from left to right."""
    todo = [formula]
    while todo:
        current = todo.pop()
        if current.op in _LEAVES:
            yield current
        else:
            todo += current.args[::-1]


def preorder(formula: Node) -> Iterator[Node]:
    """All nodes in a formula but numbers and symbols, each once and before its parts."""
    todo, seen = [formula], set[Node]()
    while todo:
        current = todo.pop()
        if current.op not in _LEAVES and current not in seen:
            seen.add(current)
            yield current
            todo += current.args[::-1]


def substitute(outputs: Iterable[Node], replace: Mapping[Node, Node]) -> list[Node]:
    """The outputs with other nodes for some of their parts."""
    outputs = list(outputs)
    results: dict[Node, Node] = {}
    for current in in_order(outputs):
        results[current] = replace[current] if current in replace else _with_parts(current, results)
    return [results[output] for output in outputs]


def _with_parts(current: Node, results: Mapping[Node, Node]) -> Node:
    if current.op in _LEAVES:
        return current
    parts = [results[part] for part in current.args]
    return _make(current.op, *parts) if current.op in ARITHMETIC else call(current.op, *parts)


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
    if current.op.startswith(INTEGRAL):
        return _integrand_at(current) * dx
    if current.op not in ARITHMETIC:
        return _SLOPES[current.op](x) * dx
    y, dy = current.args[1], slopes[current.args[1]]
    if current.op == "+":
        return dx + dy
    if current.op == "-":
        return dx - dy
    if current.op == "*":
        return dx * y + x * dy
    return (dx - current * dy) / y if current.op == "/" else y * x ** (y - 1) * dx
