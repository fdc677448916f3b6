"""Formulas of effects: their check, their values on floats, and their features in time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import fields
from typing import Any

import numpy as np

from ..derivation import in_one_thread
from ..errors import BadValue
from . import expressions, features, formula_text, time_steps
from . import late_sympy as sp
from .expression_code import ON_ARRAYS, ON_FLOATS, function_of
from .expression_graph import from_sympy, symbol


class WithFormulas:
    """A dataclass with formulas: it travels to another process as its fields; what is compiled from them stays."""

    def __reduce__(self):
        values = [getattr(self, field.name) for field in fields(self)]  # type: ignore[arg-type]
        if not any(hasattr(one, "args") for one in values):
            return type(self), tuple(values)
        return _restore, (type(self), *(expressions.as_tree(one) if hasattr(one, "args") else one for one in values))


@in_one_thread
def _restore(kind: type, *values: Any) -> Any:
    """What a process sent."""
    return kind(*map(expressions.from_tree, values))


@in_one_thread
def formula_in(
    symbols: Sequence[sp.Symbol], what: str, value: sp.Expr | str | float, time: sp.Symbol | None = None
) -> sp.Expr:
    """A number, a text or an expression as an expression in `symbols`; with `time`, one of them, it may have steps
    (`time_steps`). Raises BadValue, which names it `what`."""
    if isinstance(value, str):
        return formula_text.parse(value, {symbol.name: symbol for symbol in symbols}, what, BadValue, time)
    if expressions.as_expression(value) is None:
        raise BadValue(
            f"{what} is {expressions.shortened(value)}; give a number, or a formula in "
            f"{', '.join(symbol.name for symbol in symbols)} as text, such as '0.5*sin(3*t)' (cases.fit_waves makes "
            "one of samples)"
        )
    if time is not None and isinstance(value, sp.Expr) and value.has(sp.Piecewise, sp.Heaviside):
        try:
            value = time_steps.without_steps(value, time)
        except time_steps.NoStep as problem:
            raise BadValue(f"{what} {problem}") from None
    return expressions.admissible(value, symbols, what, BadValue)


def values_of(symbols: Sequence[sp.Symbol], formulas_: Sequence[sp.Expr]) -> Callable[..., list[float]]:
    """A function of `symbols` -> values of formulas, on floats; NaN where one of them has no value."""
    return function_of(symbols, formulas_, ON_FLOATS, or_nan=True)


def features_in_time(time: sp.Symbol, formulas_: Sequence[sp.Expr]) -> features.Features | None:
    """Where the parts of formulas that depend on time alone change, and how finely; None if there are none.

    Resolved on windows of absolute time, so that they are the same whatever a motion's duration.
    """
    parts = features.alone(formulas_, time)
    if not parts:
        return None
    function = function_of((time,), parts, ON_ARRAYS)

    def values(t):
        rows = np.array([np.broadcast_to(row, t.shape) for row in function(t)], dtype=float)
        return rows, rows

    centres = features.centres(map(from_sympy, parts), symbol(time.name))
    to_come = [centre for centre in centres if centre >= 0.0]
    return features.Features(values, centres, sizes=features.largest(values, 0.0, features.WINDOW, to_come))
