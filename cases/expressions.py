"""What an author writes as a formula: read from text, and its sizes lifted out so that one compilation serves all."""

from __future__ import annotations

import ast
from collections.abc import Mapping, Sequence

import sympy as sp
from sympy import acos, asin, atan, cos, cosh, exp, log, pi, sin, sinh, sqrt, tan, tanh

# Of every curve.
PARAMETER = sp.Symbol("s", real=True)

# What a formula may call.
FUNCTIONS = dict(
    acos=acos, asin=asin, atan=atan, cos=cos, cosh=cosh, exp=exp, log=log, pi=pi,
    sin=sin, sinh=sinh, sqrt=sqrt, tan=tan, tanh=tanh,
)  # fmt: skip

_NODES = (ast.Expression, ast.BinOp, ast.UnaryOp, ast.Call, ast.Name, ast.Load, ast.Constant)
# Double precision ends at 10**308.
_LARGEST_POWER = 308
_ARITHMETIC = (ast.Add, ast.Sub, ast.Mult, ast.Div, ast.Pow, ast.USub, ast.UAdd)


def parse(text: str, variables: Mapping[str, sp.Symbol], what: str, error: type[Exception]) -> sp.Expr:
    """A text as an expression; only numbers, the variables, arithmetic and `FUNCTIONS` may occur.

    Raises `error` with one sentence that calls the text `what`.
    """
    known = {**FUNCTIONS, **variables}
    try:
        nodes = list(ast.walk(ast.parse(text, mode="eval")))
    except (SyntaxError, ValueError, RecursionError, MemoryError) as problem:
        raise error(f"{what} {text!r} cannot be read ({getattr(problem, 'msg', problem)})") from None
    for node in nodes:
        if isinstance(node, ast.BitXor):
            raise error(f"{what} {text!r} has a ^; write ** for a power")
        if isinstance(node, ast.Name) and node.id not in known:
            use = f"{', '.join(variables)} and {', '.join(sorted(FUNCTIONS))}"
            raise error(f"{what} {text!r} has {node.id!r}; use {use}")
        number = not isinstance(node, ast.Constant) or isinstance(node.value, int | float)
        if not isinstance(node, _NODES + _ARITHMETIC) or not number:
            raise error(f"{what} {text!r} is more than arithmetic in {', '.join(variables)}; write it as an expression")
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow) and not _is_short_power(node.right):
            raise error(f"{what} {text!r} has a power that is no number up to {_LARGEST_POWER}; write a smaller one")
    try:
        return sp.parse_expr(text, local_dict=known)
    except Exception as problem:  # a function called with the wrong number of arguments, a name used as a number, …
        raise error(f"{what} {text!r} cannot be read ({problem})") from None


def _is_short_power(exponent: ast.expr) -> bool:
    """Whether an exponent is a formula, or a number of ordinary size: SymPy works out powers of whole numbers."""
    parts = list(ast.walk(exponent))
    if any(isinstance(part, ast.Name) for part in parts):
        return True
    numbers = [p.value for p in parts if isinstance(p, ast.Constant) and isinstance(p.value, int | float)]
    return len(numbers) == 1 and abs(numbers[0]) <= _LARGEST_POWER


def constants(expressions: Sequence[sp.Expr]) -> tuple[float, ...]:
    """The magnitudes of the floating-point constants in the order in which the expressions name them, each once."""
    sizes: dict[float, None] = {}
    for part in expressions:
        for node in sp.preorder_traversal(part):
            if isinstance(node, sp.Float):
                sizes.setdefault(abs(float(node)))
    return tuple(sizes)


def lifted(expressions: Sequence[sp.Expr]) -> tuple[tuple[sp.Expr, ...], tuple[sp.Symbol, ...]]:
    """The expressions with ±c0, ±c1, … (all positive) for their constants, and those symbols."""
    values = constants(expressions)
    symbols = tuple(sp.Symbol(f"c{i}", positive=True) for i in range(len(values)))
    size = dict(zip(values, symbols, strict=True))
    floats = {f for e in expressions for f in e.atoms(sp.Float)}
    replace = {f: size[abs(float(f))] * (1 if f > 0 else -1) for f in floats}
    return tuple(e.xreplace(replace) for e in expressions), symbols


def as_tree(expression: sp.Basic):
    """An expression as (function, argument, …) of such trees, with numbers and symbols for leaves, to be pickled.

    SymPy's own pickles work an expression out anew as they are read, which multiplies out what an author factored.
    """
    return (expression.func, *map(as_tree, expression.args)) if expression.args else expression


def from_tree(tree) -> sp.Basic:
    """The expression of a tree, to the last bracket."""
    if not isinstance(tree, tuple):
        return tree
    function, *arguments = tree
    as_it_stands = {"evaluate": False} if issubclass(function, sp.Add | sp.Mul | sp.Pow | sp.Function) else {}
    return function(*map(from_tree, arguments), **as_it_stands)
