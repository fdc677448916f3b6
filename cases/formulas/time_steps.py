"""Steps in time: comparisons of t, and SymPy's Piecewise and Heaviside, as rises within about a microsecond.

A rise is (1 + tanh((t − t₀)/w))/2, smooth, so that it is integrated, certified and checked as any formula; of a double
it is exactly 0 before t₀ − 19 w and exactly 1 after t₀ + 19 w.
"""

from __future__ import annotations

from math import isfinite

from . import late_sympy as sp

# The w of a step at t₀ ≤ 1 s, s, and its part of a later t₀. What follows from a step is late by about as much. At 1e-9
# some motions are not certified, and steps of an integrator shrink to roundings of t₀.
RISE = 1e-7


class NoStep(Exception):
    """Why a comparison is no step in time, as the end of a sentence that begins with the formula."""


def rise(difference: sp.Expr, time: sp.Symbol) -> sp.Expr:
    """1 where a difference is positive, 0 where it is negative; raises NoStep unless it is linear in time alone."""
    slope = sp.diff(difference, time)
    if sp.sympify(difference).free_symbols != {time} or not slope.is_number or not isfinite(slope) or slope == 0:
        raise NoStep(f"compares other than {time} with a number; write a step in time such as {time} > 0.5")
    at = sp.nsimplify(-difference.subs(time, 0) / slope, rational=True)
    width = RISE * max(1.0, abs(float(at)))
    return (1 + sp.tanh((time - at) * (1 if slope > 0 else -1) / sp.Float(width))) / 2


def without_steps(formula: sp.Expr, time: sp.Symbol) -> sp.Expr:
    """A formula with its Piecewise and Heaviside in time as rises; raises NoStep for those of other quantities, and for
    a Piecewise that has no value at some times."""

    def of_piecewise(*pairs: sp.Tuple) -> sp.Expr:
        total, left = sp.Integer(0), sp.Integer(1)
        for value, condition in pairs:
            share = truth(condition, time)
            total, left = total + left * share * value, left * (1 - share)
        if left != 0:
            raise NoStep("has a Piecewise without a value at some times; end it with (0, True)")
        return total

    replaced = formula.replace(sp.Piecewise, of_piecewise)
    return replaced.replace(sp.Heaviside, lambda argument, *_: rise(argument, time))


def truth(condition: sp.Basic, time: sp.Symbol) -> sp.Expr:
    """1 where a condition in time holds, else 0."""
    if condition in (sp.true, sp.false):
        return sp.Integer(int(condition == sp.true))
    if isinstance(condition, sp.And):
        return sp.Mul(*(truth(part, time) for part in condition.args))
    if isinstance(condition, sp.Or):
        return 1 - sp.Mul(*(1 - truth(part, time) for part in condition.args))
    if isinstance(condition, sp.Not):
        return 1 - truth(condition.args[0], time)
    if isinstance(condition, sp.Gt | sp.Ge | sp.Lt | sp.Le):
        return rise(condition.gts - condition.lts, time)
    raise NoStep(f"has the condition {condition}; write a step in time such as {time} > 0.5")
