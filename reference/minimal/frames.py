"""Curves in the frame of their tangent: the quantities of track and outline in (27), as expressions in their sizes."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import sympy as sp

from cases.expressions import PARAMETER


class Frame(NamedTuple):
    """A curve at one parameter: position in its own axes, and in the frame of its tangent the speed P, the second and
    third derivatives (a, b), c, the position (ht, hn); its unit tangent (tx, ty)."""

    x: sp.Expr
    y: sp.Expr
    P: sp.Expr
    a: sp.Expr
    b: sp.Expr
    c: sp.Expr
    ht: sp.Expr
    hn: sp.Expr
    tx: sp.Expr
    ty: sp.Expr

    @property
    def curvature(self) -> sp.Expr:
        return short(self.b / self.P**2)


def frame(structure, parameter: sp.Symbol, prefix: str) -> Frame:
    """The frame of a curve of that structure as a function of a parameter; the names of its sizes get the prefix."""
    (x, y), symbols = structure
    sizes = tuple(sp.Symbol(prefix + s.name, positive=True) for s in symbols)
    rename = {PARAMETER: parameter, **dict(zip(symbols, sizes, strict=True))}
    return Frame(*(quantity.xreplace(rename) for quantity in _frame(x, y)))


# Sums of fractions multiply out to tens of thousands of operations, and SymPy takes very long to factor these; no
# expression of the catalogue has more than ninety.
FACTOR_LIMIT = 200


@lru_cache(maxsize=256)
def _frame(x: sp.Expr, y: sp.Expr) -> Frame:
    (xp, yp), (xs, ys), (xt, yt) = ((sp.diff(x, PARAMETER, order), sp.diff(y, PARAMETER, order)) for order in (1, 2, 3))
    P = sp.sqrt(_tidy(xp**2 + yp**2))
    return Frame(
        x=x,
        y=y,
        P=P,
        a=_tidy(xp * xs + yp * ys) / P,
        b=_tidy(xp * ys - yp * xs) / P,
        c=_tidy(xp * yt - yp * xt) / P,
        ht=_tidy(x * xp + y * yp) / P,
        hn=_tidy(xp * y - yp * x) / P,
        tx=xp / P,
        ty=yp / P,
    )


def _tidy(expression: sp.Expr) -> sp.Expr:
    """The shorter of a curve's expression and its trigonometric simplification; long expressions stay unchanged."""
    # Simplification pays for lines, circles and ellipses; beyond forty operations it takes seconds and gains little.
    if sp.count_ops(expression) > 40:
        return expression
    flat, inside = _expand_products(expression)
    return min((expression, flat.xreplace(inside), sp.trigsimp(flat).xreplace(inside)), key=sp.count_ops)


def short(expression: sp.Expr) -> sp.Expr:
    """The shortest of the expression, its expansion and its factored form; long ones and those with roots are
    unchanged."""
    # With a root among the generators, or with more terms than circles and lines bring, factoring takes seconds.
    if sp.count_ops(expression) > 60 or not all(power.exp.is_Integer for power in expression.atoms(sp.Pow)):
        return expression
    flat, inside = _expand_products(expression)
    if sp.count_ops(flat) > FACTOR_LIMIT:
        return expression
    shapes = (expression, flat.xreplace(inside), sp.factor(flat).xreplace(inside))
    return min((_sign_inside(e) for e in shapes), key=sp.count_ops)


def _expand_products(expression: sp.Expr) -> tuple[sp.Expr, dict]:
    """The expanded expression, with symbols for functions of sums (except sine and cosine), and their definitions.

    Arguments of functions stay as their author wrote them: exp(-(s - c)²) as exp(-s²) exp(2 c s) exp(-c²) overflows for
    a narrow bump, and an expanded argument loses digits.
    """
    functions = [e for e in expression.atoms(sp.Function) - expression.atoms(sp.sin, sp.cos) if e.has(sp.Add)]
    outermost = [e for e in functions if not any(e is not other and other.has(e) for other in functions)]
    names = {e: sp.Symbol(f"inside_{i}") for i, e in enumerate(sorted(outermost, key=sp.default_sort_key))}
    return sp.expand(expression.xreplace(names)), {name: e for e, name in names.items()}


def _sign_inside(expression: sp.Expr) -> sp.Expr:
    """Move a product's minus sign into a sum among its factors, where it costs nothing."""
    factors = list(expression.args) if expression.is_Mul else []
    at = next((i for i, factor in enumerate(factors) if factor.is_Add), None)
    if at is None or factors[0] != -1:
        return expression
    return sp.Mul(*factors[1:at], -factors[at], *factors[at + 1 :])
