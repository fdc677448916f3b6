"""How far a load in place or velocity lets a step of the second formulation go.

Every function that a formula may hold changes over a length of its own: exp and tanh over one, sine and cosine over a
part of a turn, a logarithm or a power over what its argument is away from zero. A step is short enough if no argument
moves by more than a quarter of that length, unless the function is constant there to rounding, as exp(u) and tanh(u)
are far from zero. Nothing is fitted and no load is evaluated: where a formula is even it is so by what is known of its
functions.
"""

from __future__ import annotations

from collections.abc import Callable
from math import exp, inf, log

import numpy as np
import sympy as sp

from cases import Load
from cases.derivation import in_one_thread
from cases.effects import MOTION, followed

# A step moves an argument by at most this part of its function's length: events are seen at the steps' ends only.
QUARTER = 0.25
# exp(-40) is far below rounding, also of the sum of a hundred such terms.
QUIET = 40.0
# A step of DOP853 takes in a radian of a wave.
WAVE = 4.0
# Powers up to the eighth too.
WHOLE = 8


class Evenness:
    """What the functions of a load's formulas are taken of, and over which length each of them changes."""

    @in_one_thread
    def __init__(self, load: Load):
        formulas = load.expression
        found = dict.fromkeys(
            (node, argument)
            for formula in formulas
            for node in sp.preorder_traversal(formula)
            if node.is_Function or node.is_Pow
            for argument in node.args
            if argument.has(*MOTION)
        )
        # What a function is multiplied by on its way to the force, as far as numbers say it.
        numbers = {abs(float(n)) for formula in formulas for n in formula.atoms(sp.Number)}
        quiet = QUIET + sum(abs(log(number)) for number in numbers if number)
        self._lengths = [_length(node, quiet) for node, _ in found]
        self._arguments = sp.lambdify(MOTION, [argument for _, argument in found], modules="numpy", cse=True)

    def allows(self, times: np.ndarray, bodies: np.ndarray) -> bool:
        """Whether a step may be that long: `times` (n,) and (x, y, θ, vx, vy, ω) along it, shape (6, n)."""
        with np.errstate(all="ignore"):
            rows = [np.broadcast_to(row, times.shape) for row in self._arguments(times, *bodies)]
        return all(_even(row, length) for row, length in zip(rows, self._lengths, strict=True))


Length = Callable[[float, float], float]


def _even(row: np.ndarray, length: Length) -> bool:
    # Between two of the places an argument may turn round, by no more than it moves from one to the next.
    beyond = float(np.max(np.abs(np.diff(row))))
    low, high = float(np.min(row)) - beyond, float(np.max(row)) + beyond
    return float(np.ptp(row)) <= QUARTER * length(low, high)


def evenness(load: Load | None) -> Evenness | None:
    """What has to be asked of a load before a step is taken; None where nothing has."""
    return Evenness(load) if load is not None and followed(load.expression) else None


def _length(node: sp.Expr, quiet: float) -> Length:
    """Over which length a function changes while its argument lies between two numbers."""
    if node.is_Pow:
        return _of_power(node, quiet)
    return {
        sp.sin: lambda low, high: WAVE,
        sp.cos: lambda low, high: WAVE,
        sp.exp: lambda low, high: inf if high <= -quiet else 1.0,
        sp.tanh: lambda low, high: inf if 2.0 * _nearest(low, high) >= quiet else 1.0,
        sp.atan: lambda low, high: max(1.0, _nearest(low, high)),
        sp.log: _nearest,
        sp.asin: _to_the_ends,
        sp.acos: _to_the_ends,
    }.get(type(node), lambda low, high: 1.0)


def _of_power(node: sp.Expr, quiet: float) -> Length:
    power = float(node.exp)
    if not (node.exp.is_Integer and power > 0):
        return lambda low, high: _nearest(low, high) / max(abs(power), 1.0)
    if power <= WHOLE:
        return lambda low, high: inf
    silent = exp(-quiet / power)  # below this the power is
    return lambda low, high: inf if (most := max(-low, high)) <= silent else most * WHOLE / power


def _nearest(low: float, high: float) -> float:
    """How near to zero the argument comes."""
    return max(low, -high, 0.0)


def _to_the_ends(low: float, high: float) -> float:
    """How near to -1 or 1, where arc sine and arc cosine end, the argument comes."""
    return max(1.0 - max(-low, high), 0.0)
