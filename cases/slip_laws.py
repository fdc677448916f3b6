"""Friction coefficients that depend on the slip velocity: formulas in v, the slip speed in m/s.

A slip that ends passes v = 0, and solvers follow the formula a little below it to find the instant. So it has to be
smooth there. With an infinite slope at v = 0, as in 0.3 - sqrt(v), several motions from rest would be possible.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .errors import BadValue, not_negative, real
from .formulas import expressions, features, formula_symbols, formula_text
from .formulas import late_sympy as sp
from .formulas.expression_code import ON_ARRAYS, ON_FLOATS, function_of
from .formulas.expression_graph import from_sympy, symbol
from .formulas.formula_symbols import __getattr__ as __getattr__

# The name of the slip speed, m/s.
_V = str(formula_symbols.NAMES["SLIP_SPEED"])

# A coefficient has to be a number of at least zero at all speeds up to this, m/s; it is sampled at so many of them.
FASTEST, SAMPLES = 1e6, 1001
# Distances below v = 0 at which it needs a value, m/s.
_BELOW = (-1e-9, -1e-12)
# Parts of a speed by which samples lie around the places where its functions change: peaks may be that narrow.
_AROUND = 10.0 ** -np.arange(1.0, 10.0)


def coefficient(what: str, value: object) -> float | sp.Expr:
    """A constant coefficient as a float, a formula of `SLIP_SPEED` as an expression; raises BadValue."""
    if isinstance(value, str):
        value = formula_text.parse(value, {_V: formula_symbols.SLIP_SPEED}, what, BadValue)
    if real(value) is None and isinstance(value, sp.Expr) and not value.is_number:
        expression = expressions.admissible(value, (formula_symbols.SLIP_SPEED,), what, BadValue)
        if expression.has(formula_symbols.SLIP_SPEED):
            _check(what, expression)
            return expression
        value = expression
    if real(value) is None:
        raise BadValue(
            f"{what} is {expressions.shortened(value)}; give a number, or a formula in v, the slip speed, as text, "
            "such as '0.2 + 0.1*exp(-v/0.05)' (cases.fit_friction makes one of samples)"
        )
    return not_negative(what, value)


def function(expression: sp.Expr) -> Callable:
    """A function of the speed, a number or an array, that returns the coefficient; NaN where it has no value."""
    speed = [formula_symbols.SLIP_SPEED]
    on_numbers, on_arrays = (function_of(speed, [expression], functions) for functions in (ON_FLOATS, ON_ARRAYS))

    def value(speed):
        if isinstance(speed, np.ndarray):
            return np.broadcast_to(on_arrays(speed)[0], speed.shape)
        try:
            return float(on_numbers(speed)[0])
        except (ArithmeticError, ValueError, TypeError):  # Python's root of less than 0 is a complex number
            return float("nan")

    return value


def _check(what: str, expression: sp.Expr) -> None:
    """Raise BadValue if the formula has no value at some speed, or a negative one, or none just below v = 0."""
    centres = np.array([c for c in features.centres([from_sympy(expression)], symbol(_V)) if 0.0 < c <= FASTEST])
    around = np.concatenate([centres, *(centres * (1.0 + sign * part) for sign in (1, -1) for part in _AROUND)])
    speeds = np.sort(np.concatenate([[0.0], np.geomspace(1e-9, FASTEST, SAMPLES), around]))
    with np.errstate(all="ignore"):
        values, below = function(expression)(speeds), function(expression)(np.array(_BELOW))
    wrong = ~((values >= 0.0) & np.isfinite(values))
    if wrong.any():
        speed, value = speeds[wrong][0], values[wrong][0]
        found = f"is {value:.3g}" if np.isfinite(value) else "has no finite value"
        raise BadValue(
            f"{what} {str(expression)!r} {found} at v = {speed:.3g} m/s; give a formula that is a number of at least 0 "
            f"for v from 0 to {FASTEST:g} m/s"
        )
    if values[0] == 0.0:
        raise BadValue(
            f"{what} {str(expression)!r} is 0 at v = 0; give a formula greater than 0 there (a Load in vx can act as "
            "friction without a bound at rest)"
        )
    if not np.isfinite(below).all():
        raise BadValue(
            f"{what} {str(expression)!r} is not smooth at v = 0; write it so that it also has values just below, for "
            "example sqrt(v + 1e-6) for sqrt(v)"
        )
