"""Curves in the frame of their tangent: the quantities of track and outline in (27), as expressions in their sizes."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from functools import lru_cache
from typing import NamedTuple

from cases.derivation import in_one_thread
from cases.expression_graph import Node, derivatives, from_sympy, sqrt, substitute, symbol
from cases.expressions import PARAMETER

from .tangent_algebra import TooLong, from_node, operations

_S, _HALF = symbol(PARAMETER.name), Fraction(1, 2)


# A simplified quantity has at most this part of the operations of the plain one.
SHORTER = 0.8


class Frame(NamedTuple):
    """A curve at one parameter: position in its own axes, and in the frame of its tangent the speed P, the second and
    third derivatives (a, b), c, the position (ht, hn); its unit tangent (tx, ty)."""

    x: Node
    y: Node
    P: Node
    a: Node
    b: Node
    c: Node
    ht: Node
    hn: Node
    tx: Node
    ty: Node

    @property
    def curvature(self) -> Node:
        return self.b / self.P**2


def frame(structure, parameter: Node, prefix: str) -> Frame:
    """The frame of a curve of that structure as a function of a parameter; the names of its sizes get the prefix."""
    (x, y), sizes = structure
    names = {symbol(size.name): symbol(prefix + size.name) for size in sizes}
    return Frame(*substitute(_frame(x, y), {_S: parameter, **names}))


@lru_cache(maxsize=256)
@in_one_thread
def _frame(x, y) -> Frame:
    x, y = from_sympy(x), from_sympy(y)
    P_square, *plain = _products(x, y, lambda row: derivatives([row], _S)[0])
    P = sqrt(P_square)
    try:
        P_square, *short = _products(from_node(x), from_node(y), lambda row: row.derivative(_S))
        root = P_square**_HALF
        # Not by `_pays_off`: numerators over a plain speed are multiplied out by other identities than its square, and
        # what cancels then leaves 1e-10 of the energy of an ellipse of 0.5 m by 0.01 m.
        if operations([root.node()], {_S}) < operations([P], {_S}):
            P, short = root.node(), [(quantity * root**-1).node() for quantity in short]
        else:
            short = [quantity.node() / P for quantity in short]
    except TooLong:
        return Frame(x, y, P, *(quantity / P for quantity in plain))
    pairs = ((quantity / P, other) for quantity, other in zip(plain, short, strict=True))
    return Frame(x, y, P, *(other if _pays_off(other, quantity) else quantity for quantity, other in pairs))


def _pays_off(short: Node, plain: Node) -> bool:
    """Whether a simplified quantity replaces the plain one, which shares its parts with the other quantities."""
    return operations([short], {_S}) <= SHORTER * operations([plain], {_S})


def _products(x, y, derive: Callable) -> tuple:
    """P² and the numerators of a, b, c, ht, hn, tx, ty, which are divided by P."""
    xp, yp = derive(x), derive(y)
    xs, ys = derive(xp), derive(yp)
    xt, yt = derive(xs), derive(ys)
    return (
        xp * xp + yp * yp,
        xp * xs + yp * ys,
        xp * ys - yp * xs,
        xp * yt - yp * xt,
        x * xp + y * yp,
        xp * y - yp * x,
        xp,
        yp,
    )
