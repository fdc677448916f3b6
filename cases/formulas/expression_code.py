"""Python functions written from recorded expressions: on floats, on arrays, or by any functions that are given."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from ..derivation import in_one_thread
from . import late_sympy as sp
from .expression_graph import (
    ARITHMETIC,
    HALF,
    INTEGRAL,
    INTEGRANDS,
    MINUS,
    Node,
    from_sympy,
    in_order,
    is_exact,
    symbol,
)
from .quadrature import integral_function

# Python's parser reads at most two hundred nested brackets.
DEEPEST = 40

# Functions that written code may call, for floats and for arrays.
_NAMES = ("sin", "cos", "tan", "exp", "log", "sqrt", "sinh", "cosh", "tanh")
ON_FLOATS = {name: getattr(math, name) for name in (*_NAMES, "asin", "acos", "atan")}
ON_ARRAYS = {name: getattr(np, name) for name in _NAMES} | {
    name: getattr(np, f"arc{name[1:]}") for name in ("asin", "acos", "atan")
}


def python_function(
    arguments: Sequence[Node | Sequence[Node]],
    outputs: Iterable[Node],
    functions: Mapping[str, Callable],
    or_nan: bool = False,
) -> Callable[..., list]:
    """A function that returns the list of the outputs. Each argument is a node or a sequence of nodes; a node that is
    an argument is not computed. `functions` evaluates the elementary functions, by name: they decide whether arguments
    are floats, arrays or anything else. `or_nan`, for floats: all outputs are NaN where one of them has no value, in
    place of an exception."""
    texts: dict[Node, str] = {}
    names = [f"a{i}" for i in range(len(arguments))]
    for name, argument in zip(names, arguments, strict=True):
        if isinstance(argument, Node):
            texts[argument] = name
        else:
            texts.update({part: f"{name}_{k}" for k, part in enumerate(argument)})
    code = statements(texts, outputs)
    lines = [
        f"{', '.join(texts[part] if part in code.order else '_' for part in argument)}, = {name}"
        for name, argument in zip(names, arguments, strict=True)
        if not isinstance(argument, Node) and any(part in code.order for part in argument)
    ]
    values = f"[{', '.join(code.values)}]"
    if or_nan:
        lines = [*lines, *code.lines, f"values = {values}"]
        lines = ["    try:", *(f"        {line}" for line in lines), _or_nan(len(code.values))]
    else:
        lines = [f"    {line}" for line in [*lines, *code.lines, f"return {values}"]]
    scope: dict[str, Any] = {"isfinite": math.isfinite, "nan": math.nan, **functions}
    scope |= code.functions(functions)
    exec("\n".join([f"def evaluate({', '.join(names)}):", *lines]), scope)
    return scope["evaluate"]


class Statements(NamedTuple):
    """Expressions as Python code: the lines of assignments that they need, the text of each value, and all nodes in
    them."""

    lines: list[str]
    values: list[str]
    order: dict[Node, None]

    def functions(self, functions: Mapping[str, Callable]) -> dict[str, Callable]:
        """The functions of the integrals that the code calls; see `python_function` for `functions`."""
        return _integral_functions(self.order, functions)


def statements(arguments: Mapping[Node, str], outputs: Iterable[Node], variable: str = "v") -> Statements:
    """The code that computes some outputs from arguments with these names; its own variables begin with `variable`."""
    outputs, texts, lines = list(outputs), dict(arguments), list[str]()
    order = in_order(outputs, texts)
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
                lines.append(f"{variable}{len(lines)} = {text}")
                text, depths[current] = f"{variable}{len(lines) - 1}", 0
        texts[current] = text
    return Statements(lines, [texts[output] for output in outputs], order)


def _or_nan(count: int) -> str:
    """The end of a function on floats that raises nothing where an output has no value (a root of less than 0, an
    overflow): all outputs are NaN then, as on arrays. It is written into the function, because another function around
    it would take as long as a short one itself."""
    return f"""\
        isfinite(sum(values))  # a root of less than 0 is a complex number, for which this raises TypeError
        return values
    except (ArithmeticError, ValueError, TypeError):
        return [nan] * {count}"""


def _text(current: Node, texts: Mapping[Node, str]) -> str:
    if current.op == "number":
        return _number_text(current.args[0])
    if current.op == "symbol":
        raise KeyError(f"{current.name} is no argument of the function")
    x = texts[current.args[0]]
    if current.op.startswith(INTEGRAL):
        return f"{current.op}({', '.join(texts[argument] for argument in current.args)})"
    if current.op not in ARITHMETIC:
        return f"{current.op}({x})"
    if current.op == "**":
        power = current.args[1].args[0] if is_exact(current.args[1]) else None
        if power in (HALF, -HALF):
            return f"sqrt({x})" if power == HALF else f"(1/sqrt({x}))"
        if power == -1:
            return f"(1/{x})"
    if current.op == "*" and current.args[0] is MINUS:
        return f"(-{texts[current.args[1]]})"
    return f"({x}{current.op}{texts[current.args[1]]})"


def _number_text(value) -> str:
    if isinstance(value, Fraction):
        return f"({value.numerator}/{value.denominator})"
    return f"({value})" if isinstance(value, int) else f"({float(value)!r})"


@lru_cache(maxsize=256)
def _integral_value(name: str) -> Callable:
    """The function that evaluates an integral's node, on floats and arrays."""
    variable, formula, constants = INTEGRANDS[name]
    function = python_function([variable, *constants], [formula], ON_ARRAYS)
    return integral_function(lambda *values: function(*values)[0])


def _integral_functions(order: Iterable[Node], functions: Mapping[str, Callable]) -> dict[str, Callable]:
    """The functions of the integrals among some nodes. `functions` may have a wrapper, called "integral", for arguments
    of its own kind: it is given the value and the integrand, both functions of the same arguments."""
    result = {}
    for name in {n.op for n in order if n.op.startswith(INTEGRAL)}:
        result[name] = _integral_value(name)
        if INTEGRAL in functions:
            variable, formula, constants = INTEGRANDS[name]
            slope = python_function([variable, *constants], [formula], functions)
            result[name] = functions[INTEGRAL](result[name], slope)
    return result


@in_one_thread
def function_of(
    symbols: Sequence[sp.Symbol | Sequence[sp.Symbol]],
    formulas: Iterable[sp.Expr],
    functions: Mapping[str, Callable],
    or_nan: bool = False,
) -> Callable[..., list]:
    """A function of SymPy symbols that returns the list of some formulas' values, as `python_function` does."""
    arguments = [symbol(s.name) if isinstance(s, sp.Symbol) else [symbol(part.name) for part in s] for s in symbols]
    return python_function(arguments, map(from_sympy, formulas), functions, or_nan)
