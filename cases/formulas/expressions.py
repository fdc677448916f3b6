"""Formulas of authors: which expressions are allowed, and the separation of their sizes, so that one compilation serves
all sizes. Text is read by `cases.formulas.formula_text`; nothing here evaluates text.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from decimal import Decimal
from functools import lru_cache
from numbers import Rational
from typing import Any, NamedTuple

from ..errors import BadValue, CaseError, describe, real
from . import formula_symbols
from . import late_sympy as sp
from .expression_graph import HALF, Node
from .expression_graph import call as call_node

# What all solvers of the suite can differentiate, expand in series and compile; the derivatives stay among these.
_SMOOTH = ("acos", "asin", "atan", "cos", "cosh", "exp", "log", "sin", "sinh", "tan", "tanh")


def __getattr__(name: str) -> Any:
    """SymPy's pi and the symbol of every curve, made when they are first used."""
    return sp.pi if name == "pi" else formula_symbols.__getattr__(name)


def _function(name: str) -> Callable[..., Any]:
    """A function of numbers, expressions and nodes; SymPy's own evaluates text."""

    def call(*arguments: object) -> Any:
        if len(arguments) == 1 and isinstance(node := arguments[0], Node):
            return node**HALF if name == "sqrt" else call_node(name, node)
        return getattr(sp, name)(*(_expression(argument, f"the argument of {name}") for argument in arguments))

    call.__name__ = call.__qualname__ = name
    call.__doc__ = f"{name} of a number or an expression; raises BadValue for anything else."
    return call


acos, asin, atan, cos, cosh, exp, log, sin, sinh, tan, tanh = map(_function, _SMOOTH)
sqrt = _function("sqrt")
# What a formula may call.
FUNCTIONS: dict[str, Callable[..., Any]] = {
    f.__name__: f for f in (acos, asin, atan, cos, cosh, exp, log, sin, sinh, sqrt, tan, tanh)
}
# What a formula may contain by name.
NAMES = (*FUNCTIONS, "pi")


class _Classes(NamedTuple):
    """Classes of SymPy: the smooth functions, those that are written by these where an author's own function makes
    them, and special functions, which are integrals of elementary ones (NIST DLMF 7.2, 19.2: known to us, not looked
    up)."""

    smooth: tuple[type, ...]
    reciprocal: dict[Any, Callable[..., Any]]
    special: dict[Any, Callable[..., Any]]


@lru_cache(maxsize=1)
def _classes() -> _Classes:
    reciprocal: dict[Any, Callable[..., Any]] = {
        sp.sec: lambda u: 1 / cos(u), sp.csc: lambda u: 1 / sin(u), sp.cot: lambda u: cos(u) / sin(u),
        sp.sech: lambda u: 1 / cosh(u), sp.csch: lambda u: 1 / sinh(u), sp.coth: lambda u: cosh(u) / sinh(u),
        sp.asinh: lambda u: log(u + sqrt(u**2 + 1)), sp.acosh: lambda u: log(u + sqrt(u - 1) * sqrt(u + 1)),
        sp.atanh: lambda u: log((1 + u) / (1 - u)) / 2,
    }  # fmt: skip
    special: dict[Any, Callable[..., Any]] = {
        sp.fresnelc: lambda z: integral(lambda u: cos(sp.pi * u**2 / 2), z),
        sp.fresnels: lambda z: integral(lambda u: sin(sp.pi * u**2 / 2), z),
        sp.erf: lambda z: 2 / sqrt(sp.pi) * integral(lambda u: exp(-(u**2)), z),
        sp.elliptic_f: lambda z, m: integral(lambda u: 1 / sqrt(1 - m * sin(u) ** 2), z),
        sp.elliptic_e: lambda z, m: integral(lambda u: sqrt(1 - m * sin(u) ** 2), z),
    }
    return _Classes(tuple(getattr(sp, name) for name in _SMOOTH), reciprocal, special)


def integral(formula: Callable[[sp.Expr], sp.Expr], upper, lower=0) -> sp.Expr:
    """The integral of a formula from a number to an expression: integral(lambda u: cos(u**2), s). Raises BadValue."""
    probe = value_of(formula, formula_symbols.PARAMETER)
    variable = sp.Symbol(f"u{1 + integral_depth(probe)}", real=True)
    ends = (_expression(end, "an end of the integral") for end in (lower, upper))
    return sp.Integral(value_of(formula, variable), (variable, *ends))


def value_of(formula: Callable[[sp.Expr], Any], variable: sp.Symbol) -> sp.Expr:
    """What an author's function returns for a symbol; raises BadValue unless it is a number or an expression."""
    if not callable(formula):
        raise BadValue(f"a formula is {shortened(formula)}; give a function of its variable, as lambda u: 2 * u")
    try:
        value = formula(variable)
    except CaseError:
        raise
    except Exception as problem:  # an author's code can raise anything
        raise BadValue(f"a formula fails ({describe(problem)}); give a function of its variable") from problem
    return _expression(value, "the value of a formula")


def _expression(value: object, what: str) -> sp.Expr:
    """A number or an expression as one of SymPy's; raises BadValue for anything else."""
    expression = as_expression(value)
    if expression is None:
        raise BadValue(f"{what} is {shortened(value)}; give a number or an expression")
    return expression


def integral_depth(expression: sp.Basic) -> int:
    """How many integrals contain each other in an expression: 0 without any."""
    return max((1 + integral_depth(node.function) for node in expression.atoms(sp.Integral)), default=0)


# Limits on formulas that take long to derive and compile: of those tried that reach them, products of 12 to 27 factors,
# nested up to six times, the slowest takes 2 s. The longest of the catalogue has 58 parts, is 7 deep and nests two
# functions; a measured curve of ten terms is 22 deep.
MOST_PARTS, DEEPEST, MOST_NESTING = 300, 40, 6
# SymPy multiplies whole powers out; the library's own curves go up to it.
LARGEST_POWER = 64
# A curvature is divided by a length's cube; 1e308 is a double's end.
LARGEST_NUMBER = 1e100


def admissible(value: object, variables: Iterable[sp.Symbol], what: str, error: type[Exception]) -> sp.Expr:
    """A number or an expression as an expression that every solver can work with; text is neither.

    What has an equal among the smooth functions is written by it (sec, coth, 2**s). Raises `error`, with one sentence
    that calls the value `what`, for anything that is no formula of the variables, or too large a one.
    """
    expression, symbols = as_expression(value), tuple(variables)
    if expression is None:
        names = ", ".join(symbol.name for symbol in symbols)
        raise error(f"{what} is {shortened(value)}; give a number or an expression in {names}")
    if _check(expression, symbols, what, error):
        expression = _rewrite(expression)
        _check(expression, symbols, what, error)
    return expression


def as_expression(value: object) -> sp.Expr | None:
    """A number or an expression as one of SymPy's, None for anything else: SymPy's own conversion evaluates text, also
    inside lists and dicts, and keeps the few digits of NumPy's short floats in all that is worked out with them."""
    if isinstance(value, sp.Expr):
        return value
    number = real(value)
    if number is None:
        return None
    return sp.sympify(value) if isinstance(value, Rational | Decimal) else sp.Float(number)  # the former exactly


def _check(whole: sp.Expr, variables: Sequence[sp.Symbol], what: str, error: type[Exception]) -> bool:
    """Whether something in the expression has to be rewritten; raises `error` if it contains something else."""
    classes, foreign, parts, todo = _classes(), False, 0, [(whole, 1, 0)]
    while todo:
        node, depth, nesting = todo.pop()
        parts += 1
        if parts > MOST_PARTS or depth > DEEPEST or nesting > MOST_NESTING:
            raise error(
                f"{what} is too long a formula; give one of at most {MOST_PARTS} parts, {DEEPEST} brackets and "
                f"{MOST_NESTING} functions inside each other"
            )
        if isinstance(node, sp.Symbol):
            if node not in variables:
                raise error(f"{what} has {node.name!r}; use {', '.join(s.name for s in variables)} alone")
        elif node in (sp.nan, sp.zoo, sp.oo, -sp.oo, sp.I):
            raise error(f"{what} holds {node}, which is no finite real number; give finite real numbers")
        elif node.is_number and node.is_real is False:  # a root or a logarithm of less than 0
            raise error(f"{what} holds {str(node)[:40]}, which is no real number; give real numbers")
        elif isinstance(node, sp.Number):
            if abs(node) > LARGEST_NUMBER:
                raise error(
                    f"{what} holds {float_text(node)}; give numbers up to {LARGEST_NUMBER:g}, whose cubes a double can "
                    "hold"
                )
        elif isinstance(node, sp.Pow):
            power = node.exp
            if power.is_number and (power.is_real is not True or abs(power) > LARGEST_POWER):
                raise error(f"{what} has a power that is no number up to {LARGEST_POWER}; write a smaller one")
            foreign = foreign or not power.is_number
            nesting += not power.is_Integer
        elif isinstance(node, classes.smooth):
            nesting += 1
        elif type(node) in classes.reciprocal:
            foreign, nesting = True, nesting + 2
        elif type(node) in classes.special and len(node.args) < 3 and formula_symbols.PARAMETER in variables:
            foreign, nesting = True, nesting + 2
        elif isinstance(node, sp.Integral) and all(v.name[0] in "su" for v in variables):
            first, *others = node.limits
            if others or len(first) != 3 or first[1].free_symbols:
                raise error(f"{what} has an integral without two limits of which the lower is a number; give both")
            bound, lower, upper = first
            foreign = _check(node.function, (bound,), what, error) or foreign
            todo += [(upper, depth + 1, nesting + 1), (lower, depth + 1, nesting)]
            continue
        elif not (isinstance(node, sp.Add | sp.Mul) or node in (sp.pi, sp.E)):
            raise error(
                f"{what} has {type(node).__name__}, which is not smooth or not known to all solvers; write it with "
                f"{', '.join(sorted(NAMES))} (sqrt(u**2 + 1e-6) is a smooth magnitude, tanh(u/1e-3) a smooth "
                "sign); curves are joined by constructions.piecewise, and with corners by Chain"
            )
        todo += [(argument, depth + 1, nesting) for argument in node.args]
    return foreign


def _rewrite(node: sp.Expr) -> sp.Expr:
    """The expression with reciprocal functions and powers of formulas written by smooth ones."""
    arguments = [_rewrite(argument) for argument in node.args]
    for rewritten in (_classes().reciprocal, _classes().special):
        if type(node) in rewritten:
            return rewritten[type(node)](*arguments)
    if isinstance(node, sp.Pow) and not arguments[1].is_number:
        base, power = arguments
        # exp(s log 2) would be turned back into 2**s; a rounded logarithm is not.
        return exp(power * (sp.Float(float(log(base))) if base.is_number and base.is_positive else log(base)))
    return node.func(*arguments) if node.args else node


def float_text(number: sp.Expr) -> str:
    """A number of any size in a few characters."""
    return str(sp.N(number, 3))


def shortened(value: object) -> str:
    """What was given, shortened: a list may hold anything."""
    text = repr(value) if isinstance(value, str | bytes | int | float | complex | None) else type(value).__name__
    return text if len(text) <= 60 else f"{text[:40]} … {text[-15:]}"


def constants(expressions: Sequence[sp.Expr]) -> tuple[float, ...]:
    """The magnitudes of the floating-point constants in the order in which the expressions name them, each once."""
    sizes: dict[float, None] = {}
    for part in expressions:
        for node in sp.preorder_traversal(part):
            if isinstance(node, sp.Float):
                sizes.setdefault(abs(float(node)))
    return tuple(sizes)


def lift_constants(expressions: Sequence[sp.Expr]) -> tuple[tuple[sp.Expr, ...], tuple[sp.Symbol, ...]]:
    """The expressions with ±c0, ±c1, … (all positive) for their constants, and those symbols."""
    values = constants(expressions)
    symbols = tuple(sp.Symbol(f"c{i}", positive=True) for i in range(len(values)))
    size = dict(zip(values, symbols, strict=True))
    floats = {f for e in expressions for f in e.atoms(sp.Float)}
    replace = {f: size[abs(float(f))] * (1 if f > 0 else -1) for f in floats}
    return tuple(e.xreplace(replace) for e in expressions), symbols


def as_tree(expression: sp.Basic):
    """An expression as (function, argument, …) of such trees, with numbers and symbols for leaves, to be pickled.

    Reading SymPy's own pickles evaluates the expression again, which multiplies out what an author factored.
    """
    return (expression.func, *map(as_tree, expression.args)) if expression.args else expression


def from_tree(tree) -> sp.Basic:
    """The expression of a tree, to the last bracket."""
    if not isinstance(tree, tuple):
        return tree
    function, *arguments = tree
    as_it_stands = {"evaluate": False} if issubclass(function, sp.Add | sp.Mul | sp.Pow | sp.Function) else {}
    return function(*map(from_tree, arguments), **as_it_stands)
