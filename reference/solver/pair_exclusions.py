"""Pairs of elements in which a contact in view is the only one, and which pairs a contact passes between."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cases.contact.shapes import shapes
from cases.curves.corner import Corner
from cases.scene.piece_case import PieceCase, is_concave, neighbour

from .places import in_round
from .regimes import AT_END
from .touching import bend_bounds


def excluded_by(in_view: Sequence[PieceCase]) -> set[tuple[int, int]]:
    """The numbers, within one round, of pairs in which no other contact than the watched one is possible: the pair
    itself, if its nearest points are unique, and then those with a neighbour to which the contact passes smoothly."""
    result = set[tuple[int, int]]()
    for pair in in_view:
        if is_unique(pair) or shapes(*pair.pieces) is not None:
            result.add(in_round(pair))
        elif not fits_everywhere(pair):
            continue  # a second contact may be at the other end
        for of_track in (True, False):
            for step in (-1, 1):
                other = neighbour(pair, of_track, step)
                if other is not None and _passes(pair, other, of_track):
                    result.add(in_round(other))
    return result


def across_joints(pair: PieceCase, points: np.ndarray) -> set[tuple[int, int]]:
    """The numbers of the pairs beyond the joints of both elements, if a contact is at both: it has the same place. A
    corner is one place, a joint on both sides."""
    result = set[tuple[int, int]]()
    steps = [
        [
            step
            for step, end in zip((-1, 1), piece.ends or (), strict=False)
            if isinstance(piece, Corner) or abs(s - end) <= AT_END
        ]
        for piece, s in zip(pair.pieces, points, strict=True)
    ]
    for one in steps[0]:
        beside = neighbour(pair, True, one)
        across = [neighbour(beside, False, other) for other in steps[1]] if beside is not None else []
        result |= {in_round(other) for other in across if other is not None}
    return result


def is_at_inner_corner(pair: PieceCase, *points: float) -> bool:
    """Whether a contact lies at an end of an element that joins a corner inside which curves touch on both sides."""
    ends = [
        neighbour(pair, k == 0, step)
        for k, (piece, s) in enumerate(zip(pair.pieces, points, strict=True))
        for step, end in zip((-1, 1), piece.ends or (), strict=False)
        if abs(s - end) <= AT_END
    ]
    return any(one is not None and is_concave(one) for one in ends)


def are_neighbours(one: PieceCase, other: PieceCase) -> bool:
    """Whether a contact of one pair passes to the other."""
    beside = (neighbour(one, of_track, step) for of_track in (True, False) for step in (-1, 1))
    return any(pair is not None and in_round(pair) == in_round(other) for pair in beside)


def is_unique(pair: PieceCase) -> bool:
    """Whether the nearest points of two elements are the only ones: that of the plate bulges, that of the track does
    not bend towards it."""
    track, outline = pair.pieces
    return bend_bounds(outline)[0] >= 0.0 and bend_bounds(track)[1] <= 0.0


def fits_everywhere(pair: PieceCase) -> bool:
    """Whether the element of the plate bends more than that of the track, wherever they touch."""
    track, outline = pair.pieces
    return bend_bounds(outline)[0] > bend_bounds(track)[1]


def _passes(pair: PieceCase, other: PieceCase, of_track: bool) -> bool:
    """Whether a contact passes to a neighbour without another one before: at a corner that points to the other curve,
    if that does not bend towards it, or where the curves fit each other."""
    track, outline = other.pieces
    piece = track if of_track else outline
    if not isinstance(piece, Corner):
        return fits_everywhere(other)
    if of_track:
        return piece.sign < 0 and bend_bounds(outline)[0] >= 0.0
    return piece.sign > 0 and bend_bounds(track)[1] <= 0.0
