"""Text as an expression. No text is ever evaluated: Python's parser makes a tree of it, whose nodes are looked up in
two small tables, and every number and power is bounded before SymPy works anything out.
"""

from __future__ import annotations

import ast
import operator
import re
import warnings
from collections.abc import Callable, Mapping
from math import log10

from . import late_sympy as sp
from .expressions import DEEPEST, FUNCTIONS, LARGEST_NUMBER, LARGEST_POWER, MOST_PARTS, NAMES, admissible
from .time_steps import NoStep, rise

# A formula on a page or two; Python's own parser takes milliseconds for it.
LONGEST_TEXT = 4000

# A number of NumPy, as an f-string of one shows it inside a formula.
_NUMPY_FLOAT = re.compile(r"\bnp\.float64\(([-+.\deE]+)\)")
_OPERATIONS: dict[type[ast.AST], Callable[..., sp.Expr]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
}


class _FormulaError(Exception):
    """What is wrong with a text, as the end of a sentence that begins with it."""


def parse(
    text: str, variables: Mapping[str, sp.Symbol], what: str, error: type[Exception], time: sp.Symbol | None = None
) -> sp.Expr:
    """A text as an expression; only numbers, the variables, arithmetic and `FUNCTIONS` may occur, and with `time`, one
    of the variables, comparisons of it (1 or 0), also as "a if t < 0.5 else b".

    Raises `error` with one sentence that calls the text `what`.
    """
    if len(text) > LONGEST_TEXT:
        raise error(f"{what} has {len(text)} characters; give a formula of at most {LONGEST_TEXT}")
    quotation = repr(text if len(text) <= 80 else f"{text[:60]} … {text[-20:]}")
    try:
        with warnings.catch_warnings():  # Python's own about style are no answer to an author
            warnings.simplefilter("ignore")
            source = _NUMPY_FLOAT.sub(r"(\1)", text.strip())
            tree = ast.parse(source, mode="eval")
    except (SyntaxError, ValueError, RecursionError, MemoryError) as problem:
        raise error(f"{what} {quotation} cannot be read ({getattr(problem, 'msg', problem)})") from None
    if sum(1 for _ in ast.walk(tree)) > 4 * MOST_PARTS:  # an operation is a node of its own, and so is a name's use
        raise error(f"{what} {quotation} is too long a formula; give one of at most {MOST_PARTS} parts")
    try:
        expression = _FormulaReader(variables, source, time).read(tree.body, 0)
    except (_FormulaError, NoStep) as problem:
        raise error(f"{what} {quotation} {problem}") from None
    except (ArithmeticError, TypeError, ValueError) as problem:  # no number at all, such as 1/0 within a power
        raise error(f"{what} {quotation} cannot be read ({problem})") from None
    return admissible(expression, variables.values(), f"{what} {quotation}", error)


class _FormulaReader:
    """Walks a syntax tree from its leaves up; rejects what no table contains."""

    def __init__(self, variables: Mapping[str, sp.Symbol], source: str, time: sp.Symbol | None = None):
        self._variables, self._source, self._time = variables, source, time

    def read(self, node: ast.expr, depth: int) -> sp.Expr:
        """The expression of one node."""
        if depth > 2 * DEEPEST:  # a sum of many terms is nested in Python's tree, and flat in SymPy's
            raise _FormulaError(f"has more than {2 * DEEPEST} brackets or terms inside each other; shorten it")
        match node:
            case ast.Constant(value=bool()):
                pass
            case ast.Constant(value=int() | float() as value):
                return self._number(value, node)
            case ast.Name():
                return self._name(node.id)
            case ast.UnaryOp() if type(node.op) in _OPERATIONS:
                return _OPERATIONS[type(node.op)](self.read(node.operand, depth + 1))
            case ast.BinOp(op=ast.BitXor()):
                raise _FormulaError("has a ^; write ** for a power")
            case ast.BinOp(op=ast.Pow()):
                return _power(self.read(node.left, depth + 1), self.read(node.right, depth + 1))
            case ast.BinOp() if type(node.op) in _OPERATIONS:
                return _OPERATIONS[type(node.op)](self.read(node.left, depth + 1), self.read(node.right, depth + 1))
            case ast.Compare() if self._time is not None:
                return self._steps(node, self._time, depth + 1)
            case ast.BoolOp() | ast.UnaryOp(op=ast.Not()) if self._time is not None:
                return self._truth(node, self._time, depth)
            case ast.IfExp() if self._time is not None:
                is_so, *both = (self.read(part, depth + 1) for part in (node.test, node.body, node.orelse))
                return is_so * both[0] + (1 - is_so) * both[1]
            case ast.Call(func=ast.Name(id=name), args=[argument], keywords=[]):
                return self._call(name, self.read(argument, depth + 1))
            case ast.Call(func=ast.Name(id=name)) if name in FUNCTIONS:
                raise _FormulaError(f"gives {name} other than one argument; give it one")
        raise _FormulaError(f"is more than arithmetic in {', '.join(self._variables)}; write it as an expression")

    def _truth(self, node: ast.expr, time: sp.Symbol, depth: int) -> sp.Expr:
        """Comparisons of time that are combined by and, or, not, as 1 or 0."""
        match node:
            case ast.Compare():
                return self._steps(node, time, depth + 1)
            case ast.UnaryOp(op=ast.Not()):
                return 1 - self._truth(node.operand, time, depth + 1)
            case ast.BoolOp():
                parts = [self._truth(value, time, depth + 1) for value in node.values]
                return sp.Mul(*parts) if isinstance(node.op, ast.And) else 1 - sp.Mul(*(1 - part for part in parts))
        raise _FormulaError("combines other than comparisons by and, or, not; write a product or a sum")

    def _steps(self, node: ast.Compare, time: sp.Symbol, depth: int) -> sp.Expr:
        """Comparisons of time, such as 0.2 < t <= 0.5, as 1 or 0."""
        result = sp.Integer(1)
        for left, how, right in zip([node.left, *node.comparators], node.ops, node.comparators, strict=False):
            if not isinstance(how, ast.Lt | ast.LtE | ast.Gt | ast.GtE):
                raise _FormulaError("compares other than by <, <=, > or >=; give one of these")
            difference = self.read(left, depth) - self.read(right, depth)
            result *= rise(difference if isinstance(how, ast.Gt | ast.GtE) else -difference, time)
        return result

    def _number(self, value: int | float, node: ast.expr) -> sp.Expr:
        if not abs(value) <= LARGEST_NUMBER:
            raise _FormulaError(f"has a number beyond {LARGEST_NUMBER:g}; give a smaller one")
        if isinstance(value, int):
            return sp.Integer(value)
        # By its digits, as it was written: quadruple precision has use for more than a double holds.
        return sp.Float((ast.get_source_segment(self._source, node) or repr(value)).replace("_", ""))

    def _name(self, name: str) -> sp.Expr:
        if name in self._variables:
            return self._variables[name]
        if name == "pi":
            return sp.pi
        if name in NAMES:
            raise _FormulaError(f"has {name} without its argument; write {name}(…)")
        raise _FormulaError(f"has {name!r}; use {', '.join(self._variables)} and {', '.join(sorted(NAMES))}")

    def _call(self, name: str, argument: sp.Expr) -> sp.Expr:
        if name not in FUNCTIONS:
            raise _FormulaError(f"has {name!r}; use {', '.join(self._variables)} and {', '.join(sorted(NAMES))}")
        return FUNCTIONS[name](argument)


def _power(base: sp.Expr, exponent: sp.Expr) -> sp.Expr:
    """A power, worked out only if it is of ordinary size."""
    if exponent.is_number:
        size = complex(exponent.evalf(15))
        if not abs(size) <= LARGEST_POWER:  # NaN is none either
            raise _FormulaError(f"has a power that is no number up to {LARGEST_POWER}; write a smaller one")
        if base.is_number:
            length = abs(complex(base.evalf(15)))
            if length > 0.0 and abs(size) * abs(log10(length)) > log10(LARGEST_NUMBER):
                raise _FormulaError(f"has a power beyond {LARGEST_NUMBER:g}; give a smaller one")
    return base**exponent
