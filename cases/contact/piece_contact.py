"""Contact between pieces of a chain: the pair of nearest points of two pieces.

With corners there are three kinds of pairs: a curve and a curve, a curve and a corner of the outline, a corner of the
track and a curve.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, partial
from typing import NamedTuple

from ..curves import Curve
from ..curves.chain import Chain
from ..curves.corner import Corner, Piece
from ..curves.element import Element
from ..errors import DoesNotFit
from . import geometry

# Rounding of a computed curvature of a flat side, 1/m.
FLAT = 1e-9


class Entry(NamedTuple):
    """Elements of track and outline, and parameters near their nearest points, in the chains' parameters."""

    first: Element
    second: Element
    s1: float
    s2: float


# Elements that a contact may pass between two poses, back and forth.
MOST_ELEMENTS = 100


def find(track: Piece, outline: Piece, x: float, y: float, theta: float, near: tuple[float, float]) -> geometry.Contact:
    """`geometry.find` where a curve is a chain: the nearest pair on the elements near a pair, or on those that follow.

    Raises DoesNotFit where there is none: two edges face each other, or two corners do.
    """
    if not isinstance(track, Chain) and not isinstance(outline, Chain):
        return geometry.find(track, outline, x, y, theta, near)
    entry = Entry(track.element_at(near[0]), outline.element_at(near[1]), *near)
    return find_from(track, outline, x, y, theta, entry)


def finder(track: Curve, outline: Curve) -> Callable[[float, float, float, tuple[float, float]], geometry.Contact]:
    """`find` for two curves, for many poses and first guesses."""
    if isinstance(outline, Corner) or isinstance(track, Chain) or isinstance(outline, Chain):
        return partial(find, track, outline)
    return geometry.pair_search(track, outline)


def find_from(track: Piece, outline: Piece, x: float, y: float, theta: float, entry: Entry) -> geometry.Contact:
    """The same, starting from a pair of elements."""
    for _ in range(MOST_ELEMENTS):
        contact = piece_gap(entry, x, y, theta)
        first, second = _beyond(track, entry.first, contact.xi1), _beyond(outline, entry.second, contact.xi2)
        if first == entry.first and second == entry.second:
            return contact
        if first != entry.first:  # one at a time
            entry = Entry(first, entry.second, first.clip(contact.xi1), contact.xi2)
        else:
            entry = Entry(entry.first, second, contact.xi1, second.clip(contact.xi2))
    raise DoesNotFit(f"no contact point near xi1 = {entry.s1:.6g}, xi2 = {entry.s2:.6g}")


def piece_gap(entry: Entry, x: float, y: float, theta: float) -> geometry.Contact:
    """The nearest pair of points of two elements in a pose, in the chains' parameters, and their gap (m, negative where
    they overlap). Raises DoesNotFit if there is none near."""
    some = (entry.first, entry.s1), (entry.second, entry.s2)
    near = [one.middle if isinstance(one.piece, Corner) else s - one.shift for one, s in some]
    xi1, xi2, gap = geometry.find(entry.first.piece, entry.second.piece, x, y, theta, (near[0], near[1]))
    return geometry.Contact(xi1 + entry.first.shift, xi2 + entry.second.shift, gap)


def _beyond(curve: Piece, element: Element, s: float) -> Element:
    """The neighbour of an element on whose side a parameter lies beyond its end; the element itself at an open end."""
    if not isinstance(curve, Chain):
        return element
    (low, high), place = element.piece.span, s - element.shift
    rounding = 64 * geometry.EPS * (1.0 + abs(s) + abs(element.shift))
    step = -1 if place < low - rounding else 1 if place > high + rounding else 0
    return curve.element(element.number + step) or element


@lru_cache(maxsize=256)
def excludes_second(track: Curve, outline: Curve) -> bool:
    """Whether convexity alone excludes a second contact: a convex plate on a track of straight pieces that bends to its
    right only. (It lies on a flat side where a piece ends.)"""
    pieces = [element.piece for element in outline.elements]
    if not outline.period or any(isinstance(p, Corner) and p.turn < 0.0 for p in pieces):
        return False
    if any(isinstance(p, Curve) and geometry.bends(p)[0] < -FLAT for p in pieces):
        return False
    under = [element.piece for element in track.elements]
    return all(p.turn < 0.0 if isinstance(p, Corner) else geometry.bends(p)[1] <= FLAT for p in under)
