"""Features of an outline that may touch a straight line: a smooth outline itself; of a chain its corners and its arcs.

An arc is continued to its whole circle, so that the point nearest to a line is unique. The circle must not be looked
at where it would leave the plate: beyond an arc that ends at a corner, as that of a half disc does, the corner touches.
"""

from __future__ import annotations

from functools import lru_cache
from math import pi
from typing import NamedTuple

import numpy as np

from ..curves import Curve
from ..curves.chain import Chain
from ..curves.corner import Corner, Edge, Piece, turning
from ..curves.element import Element

# Curvature and speed of an arc change by less than this part: the rounding of a formula's derivatives.
SAME = 1e-9
# A circle lies inside the plate's convex hull if it leaves it by at most this part of the plate's size: rounding.
INSIDE = 1e-12
# Angles (rad) beyond an arc's end at which its circle is compared with the hull: this many from the least one on.
LEAST, ANGLES = 1e-6, 500


class ArcRange(NamedTuple):
    """The parameters between which an arc's circle is compared with a line, and the numbers of the features to which a
    contact passes at each end; None where another feature touches before the contact arrives there."""

    low: float
    high: float
    before: int | None
    after: int | None

    @property
    def neighbours(self) -> frozenset[int]:
        """The features that touch a line only outside this range."""
        return frozenset(number for number in (self.before, self.after) if number is not None)


@lru_cache(maxsize=256)
def features(outline: Curve) -> tuple[Piece, ...]:
    """What of an outline may touch a straight line: a smooth one itself, of a chain its corners and pieces that
    bulge, in the outline's order."""
    if not isinstance(outline, Chain):
        return (outline,)
    return tuple(element.piece for element in outline.elements if _may_touch(element.piece))


def is_arc(piece: Curve) -> bool:
    """Whether a piece is an arc of a circle whose parameter is an angle or a length."""
    s = np.linspace(*piece.span, 17)
    bend, speed = piece.curvature(s), np.asarray(piece.speed(s))
    return bool(np.ptp(bend) <= SAME * abs(bend[0]) and np.ptp(speed) <= SAME * speed[0])


@lru_cache(maxsize=256)
def arc_ranges(outline: Curve) -> tuple[ArcRange | None, ...]:
    """For each feature of an outline of edges and arcs the range of an arc; None for a corner, and for an arc whose
    whole circle lies inside the plate's convex hull."""
    if not isinstance(outline, Chain):
        return (None,)
    elements = outline.elements
    numbers = {i: k for k, i in enumerate(i for i, e in enumerate(elements) if _may_touch(e.piece))}
    return tuple(
        None if isinstance(elements[i].piece, Corner) else _range(outline, i, numbers) for i in numbers
    )  # fmt: skip


@lru_cache(maxsize=256)
def sides(outline: Curve) -> tuple[Piece, ...]:
    """What of a convex polygon may touch a hill: its edges and corners in their order; nothing of another outline."""
    if not isinstance(outline, Chain) or not outline.is_closed:
        return ()
    every = tuple(element.piece for element in outline.elements)
    is_convex = all(piece.turn > 0.0 if isinstance(piece, Corner) else isinstance(piece, Edge) for piece in every)
    return every if is_convex else ()


def side_ranges(outline: Curve) -> tuple[ArcRange | None, ...]:
    """For each of `sides` the range of an edge, at whose ends a contact passes to a corner; None for a corner."""
    every = sides(outline)
    return tuple(
        None if isinstance(piece, Corner) else ArcRange(*piece.span, (i - 1) % len(every), (i + 1) % len(every))
        for i, piece in enumerate(every)
    )


def _may_touch(piece: Piece) -> bool:
    if isinstance(piece, Corner):
        return piece.turn > 0.0
    return not isinstance(piece, Edge) and bool(np.max(piece.curvature(np.linspace(*piece.span, 17))) > 0.0)


def _range(outline: Chain, i: int, numbers: dict[int, int]) -> ArcRange | None:
    """The range of the arc that is element i of an outline."""
    elements, piece = outline.elements, outline.elements[i].piece
    low, high = piece.span
    if len(elements) == 1:
        return None
    rate = turning(piece, 0.5 * (low + high))
    rest = 2.0 * pi - rate * (high - low)
    before, after = (i - 1) % len(elements), (i + 1) % len(elements)
    passes = [_passes(elements[i], elements[k]) for k in (before, after)]
    spare = [0.0 if ends else _inside(outline, piece, rest, way) for ends, way in zip(passes, (-1, 1), strict=True)]
    if min(spare) >= rest:
        return None
    # Half the way, where the circle lies inside the plate: the features of two ends do not overlap.
    low, high = low - 0.5 * spare[0] / rate, high + 0.5 * spare[1] / rate
    return ArcRange(low, high, *(numbers[k] if ends else None for ends, k in zip(passes, (before, after), strict=True)))


def _passes(arc: Element, other: Element) -> bool:
    """Whether a contact that leaves an arc at its end passes to that neighbour: a corner, or an arc that bends as much
    or more."""
    piece, own = other.piece, float(arc.piece.curvature(arc.low))
    if isinstance(piece, Corner):
        return piece.turn > 0.0
    return _may_touch(piece) and float(piece.curvature(other.low)) >= own * (1.0 - SAME)


def _inside(outline: Chain, piece: Piece, rest: float, way: int) -> float:
    """The angle (rad, at most `rest`) beyond an end of an arc up to which its circle lies inside the convex hull."""
    s = piece.span[1 if way > 0 else 0]
    radius = 1.0 / float(piece.curvature(s))
    centre = piece.point(s) + radius * piece.normal(s)
    beyond = np.geomspace(LEAST, max(rest, 2.0 * LEAST), ANGLES)
    angles = float(piece.tangent_angle(s)) - 0.5 * pi + way * beyond
    directions = np.array([np.cos(angles), np.sin(angles)])
    leaves = directions.T @ centre + radius > _support(outline, angles) + INSIDE * outline.sizes[0]
    return float(beyond[int(np.argmax(leaves)) - 1]) if leaves.any() else rest


def _support(outline: Chain, angles: np.ndarray) -> np.ndarray:
    """How far an outline of edges and arcs reaches in directions (rad), m."""
    directions = np.array([np.cos(angles), np.sin(angles)])
    ends = np.array([element.piece.point(element.piece.span[0]) for element in outline.elements])
    reach = (ends @ directions).max(axis=0)
    for element in outline.elements:
        piece = element.piece
        if isinstance(piece, Corner) or not _may_touch(piece):
            continue
        low, high = piece.span
        first, last = (float(piece.tangent_angle(s)) - 0.5 * pi for s in (low, high))
        radius = 1.0 / float(piece.curvature(low))
        faces = (angles - first) % (2.0 * pi) <= last - first
        far = (piece.point(low) + radius * piece.normal(low)) @ directions + radius
        reach = np.where(faces, np.maximum(reach, far), reach)
    return reach
