"""The formula of a curve as an author writes it: a function or two texts, checked, and its domain."""

from __future__ import annotations

import re

import numpy as np

from ..errors import BadCurve, BadValue, finite
from ..formulas import expressions, formula_symbols, formula_text
from ..formulas import late_sympy as sp

# Letters of a formula that a curve shows of itself.
_LONGEST_FORMULA = 80
# The least width of a domain, whose inverse a formula may hold, and the parameters in it that must be different
# doubles: a curve's tables have fewer than a million entries.
NARROWEST, MOST_ENTRIES = 1.0 / expressions.LARGEST_NUMBER, 1e6


def check_domain(domain) -> tuple[float, float] | None:
    if domain is None:
        return None
    try:
        low, high = domain
    except (TypeError, ValueError):
        raise BadValue(f"domain is {domain!r}; give a pair (a, b) of numbers, or None") from None
    low, high = finite("start of the domain", low), finite("end of the domain", high)
    if not low < high:
        raise BadValue(f"domain is ({low:g}, {high:g}); give the smaller number first")
    if high - low < max(NARROWEST, MOST_ENTRIES * np.spacing(max(abs(low), abs(high)))):
        raise BadValue(
            f"domain is {high - low:g} wide from {low:g}, too narrow for different numbers; give a wider one"
        )
    return (low, high)


def _from_strings(texts: tuple[str, str]) -> tuple[sp.Expr, sp.Expr]:
    """A pair of strings as expressions in s."""
    variables = {"s": formula_symbols.PARAMETER}
    x, y = (formula_text.parse(text, variables, "the curve's coordinate", BadCurve) for text in texts)
    return x, y


def as_expression(function) -> tuple[sp.Expr, sp.Expr]:
    if isinstance(function, tuple) and len(function) == 2 and all(isinstance(part, str) for part in function):
        texts = function
        function = lambda s: _from_strings(texts)  # noqa: E731 - one way on for both ways to write
    if not callable(function):
        what = repr(function) if isinstance(function, int | float | str) else type(function).__name__
        raise BadCurve(
            f"a curve is a function of its parameter, not {what}; give lambda s: (X, Y), or Curve.spline(points)"
        )
    try:
        s = formula_symbols.PARAMETER
        pair = tuple(function(s))
        x, y = pair
    except BadCurve:
        raise
    except Exception as problem:
        raise BadCurve(
            f"the curve's function fails ({problem}); return a pair (X, Y) made with the functions of cases.curves"
        ) from problem
    x, y = (expressions.admissible(part, (s,), "the curve's coordinate", BadCurve) for part in (x, y))
    return x, y


def shorten(text: str) -> str:
    """A formula that fits into a line; of one through measured points the beginning."""
    text = re.sub(r"\d+\.\d{7,}", lambda number: f"{float(number[0]):.6g}", text)
    return text if len(text) <= _LONGEST_FORMULA else f"{text[:_LONGEST_FORMULA]} …"
