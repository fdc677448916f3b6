"""Curves in the frame of their tangent: the quantities of track and outline in (27), as expressions in their sizes."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from functools import lru_cache
from typing import NamedTuple

from cases.curves.jets import S as _S
from cases.derivation import in_one_thread
from cases.formulas.expression_graph import ZERO, Node, call, derivatives, from_sympy, node, sqrt, substitute, symbol

from .tangent_algebra import TooLong, from_node, operations

_HALF = Fraction(1, 2)


# A simplified quantity has at most this part of the operations of the plain one.
SHORTER = 0.8


# The sizes of a corner: its position and the tangent's angle where it begins.
CORNER = ("x", "y", "start")


class Frame(NamedTuple):
    """A curve at one parameter: position in its own axes, and in the frame of its tangent the speed P, the second and
    third derivatives (a, b), c, the position (ht, hn); its unit tangent (tx, ty).

    At a corner the speed and all derivatives are zero, and `sign` is the rate at which the tangent turns: 1 or −1 per
    unit of the parameter. On a smooth curve `sign` is 0.
    """

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
    sign: int = 0

    @property
    def curvature(self) -> Node:
        return self.b / self.P**2

    @property
    def turning(self) -> Node:
        """k, the rate at which the tangent turns per unit of the parameter."""
        return node(self.sign) if self.sign else self.b / self.P

    @property
    def turning_rate(self) -> Node:
        """The derivative of k in the parameter."""
        return ZERO if self.sign else self.c / self.P - 2 * self.a * self.b / self.P**2


def frame(structure, parameter: Node, prefix: str) -> Frame:
    """The frame of a curve of that structure as a function of a parameter; the names of its sizes get the prefix.

    A corner's structure is the sign of its turn.
    """
    if isinstance(structure, int):
        return _corner(structure, parameter, prefix)
    (x, y), sizes = structure
    names = {symbol(size.name): symbol(prefix + size.name) for size in sizes}
    nodes = substitute(_frame(x, y)[:-1], {_S: parameter, **names})
    return Frame._make([*nodes, 0])


def _corner(sign: int, parameter: Node, prefix: str) -> Frame:
    """The frame of a corner: the point is fixed, and the tangent turns with the parameter."""
    x, y, start = (symbol(prefix + name) for name in CORNER)
    angle = start + parameter if sign > 0 else start - parameter
    tx, ty = call("cos", angle), call("sin", angle)
    return Frame(x, y, ZERO, ZERO, ZERO, ZERO, x * tx + y * ty, y * tx - x * ty, tx, ty, sign)


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
