"""The longest step of the second formulation that a load in place or velocity, or friction by a formula, allows.

Every function in a formula changes over a characteristic length: exp and tanh over one, sine and cosine over a part of
a turn, a logarithm or a power over its argument's distance from zero. A step is short enough if no argument changes by
more than a quarter of that length, unless the function is constant there to rounding, as exp(u) and tanh(u) are far
from zero. Unlike in the first formulation, no polynomial is fitted and no load is evaluated: the bound follows from the
functions alone.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import exp, inf, log

import numpy as np

from cases import CoulombFriction, Load
from cases.derivation import in_one_thread
from cases.effects import checked_quantities
from cases.formulas import formula_symbols
from cases.formulas import late_sympy as sp
from cases.formulas.expression_code import ON_ARRAYS, function_of

# A step changes an argument by at most this part of the function's length: `dips` supposes short steps.
QUARTER = 0.25
# exp(-40) is far below rounding, also of the sum of a hundred such terms.
NEGLIGIBLE = 40.0
# A step of DOP853 covers a radian of a wave.
WAVE = 4.0
# It also covers a power up to the eighth.
LOW_POWER = 8


class FormulaScales:
    """The arguments of the functions in formulas of some symbols, and the lengths over which those functions change."""

    @in_one_thread
    def __init__(self, formulas: Sequence[sp.Expr], symbols: Sequence[sp.Symbol]):
        pairs = dict.fromkeys(
            (node, argument)
            for formula in formulas
            for node in sp.preorder_traversal(formula)
            if node.is_Function or node.is_Pow
            for argument in node.args
            if argument.has(*symbols)
        )
        # A force may contain a function multiplied by any of the formulas' numbers.
        numbers = {abs(float(n)) for formula in formulas for n in formula.atoms(sp.Number)}
        negligible = NEGLIGIBLE + sum(abs(log(number)) for number in numbers if number)
        self._lengths = [_length(node, negligible) for node, _ in pairs]
        self._arguments = function_of(symbols, [argument for _, argument in pairs], ON_ARRAYS)

    def allows(self, *values: np.ndarray) -> bool:
        """Whether a step is short enough, by the values of the symbols along it, each of shape (n,)."""
        with np.errstate(all="ignore"):
            rows = [np.broadcast_to(row, values[0].shape) for row in self._arguments(*values)]
        return all(_within(row, length) for row, length in zip(rows, self._lengths, strict=True))


Length = Callable[[float, float], float]


def _within(row: np.ndarray, length: Length) -> bool:
    # Between two of the times an argument may have an extremum, beyond them by no more than it changes from one to the
    # next.
    beyond = float(np.max(np.abs(np.diff(row))))
    low, high = float(np.min(row)) - beyond, float(np.max(row)) + beyond
    return float(np.ptp(row)) <= QUARTER * length(low, high)


def load_scales(load: Load | None) -> FormulaScales | None:
    """The bounds that a load sets on steps; None if it sets none."""
    if load is None or not checked_quantities(load.expression):
        return None
    return FormulaScales(load.expression, formula_symbols.MOTION)


def slip_scales(friction: CoulombFriction | None) -> FormulaScales | None:
    """The bounds that friction by a formula sets on steps of a slip; None if it sets none."""
    if friction is None or not friction.by_speed:
        return None
    formulas, symbols = [friction.mu], [formula_symbols.SLIP_SPEED]
    return FormulaScales(formulas, symbols) if checked_quantities(formulas, symbols) else None


def _length(node: sp.Expr, negligible: float) -> Length:
    """The length over which a function changes while its argument lies between two numbers."""
    if node.is_Pow:
        return _of_power(node, negligible)
    return {
        sp.sin: lambda low, high: WAVE,
        sp.cos: lambda low, high: WAVE,
        sp.exp: lambda low, high: inf if high <= -negligible else 1.0,
        sp.tanh: lambda low, high: inf if 2.0 * _nearest(low, high) >= negligible else 1.0,
        sp.atan: lambda low, high: max(1.0, _nearest(low, high)),
        sp.log: _nearest,
        sp.asin: _to_the_ends,
        sp.acos: _to_the_ends,
    }.get(type(node), lambda low, high: 1.0)


def _of_power(node: sp.Expr, negligible: float) -> Length:
    power = float(node.exp)
    if not (node.exp.is_Integer and power > 0):
        return lambda low, high: _nearest(low, high) / max(abs(power), 1.0)
    if power <= LOW_POWER:
        return lambda low, high: inf
    silent = exp(-negligible / power)  # below this the power is
    return lambda low, high: inf if (most := max(-low, high)) <= silent else most * LOW_POWER / power


def _nearest(low: float, high: float) -> float:
    """The argument's smallest distance from zero."""
    return max(low, -high, 0.0)


def _to_the_ends(low: float, high: float) -> float:
    """The argument's smallest distance from -1 and 1, where arc sine and arc cosine end."""
    return max(1.0 - max(-low, high), 0.0)
