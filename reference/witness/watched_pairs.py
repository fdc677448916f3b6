"""The pairs of curves that are watched, what follows at the ends of their elements, and which contacts share plates."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf
from typing import NamedTuple

import numpy as np

from cases import Case, Chain
from cases.contact import start_motion
from cases.contact.nearest import nearest_pair
from cases.curves.corner import Corner
from cases.scene.couples import Couple
from cases.scene.free_plates import start_poses
from cases.scene.limits import Scope, limit
from cases.scene.piece_case import PieceCase, has_pieces, neighbour, piece_case_of

from .contacts import AnyPair, is_of_couple, plates_at


def start_of_plates(case: Case) -> np.ndarray:
    """(x, y, θ) of all plates where a motion begins, then their (vx, vy, ω)."""
    poses = start_poses(case)
    poses[0] = start_motion(case)[:6]  # on a belt
    return np.concatenate([poses[:, :3].ravel(), poses[:, 3:].ravel()])


class PieceEnd(NamedTuple):
    """The nearest end of a piece that a contact's points may reach: how far it is, in units of the piece's width, the
    pieces that follow (None: an end of an open curve), the curve (0: the track), and the parameters there."""

    distance: float
    following: PieceCase | None
    curve: int
    points: tuple[float, float]


def piece_end(pair: PieceCase, points: tuple[float, float]) -> PieceEnd:
    """The nearest end of a contact's pieces at these parameters of theirs; of a couple only one of the boundary:
    on the plate each corner is watched."""
    ends, is_couple = [PieceEnd(inf, None, 0, points)], is_of_couple(pair)
    for i, (piece, s) in enumerate(zip(pair.pieces, points, strict=True)):
        has_ends = isinstance(piece, Corner) or not (piece.period or piece.domain is None)
        if not has_ends or (is_couple and (i == 1 or not isinstance(pair.whole.track, Chain))):
            continue
        (low, high), following = piece.span, None
        way = -1 if s - low < high - s else 1
        following = neighbour(pair, i == 0, way)
        at = [*points]
        if following is not None:
            at[i] = following.pieces[i].span[0 if way > 0 else 1]
        ends.append(PieceEnd(min(s - low, high - s) / (high - low), following, i, (at[0], at[1])))
    return min(ends)


def is_by_pieces(case: Case) -> bool:
    """Whether a plate's one contact goes from pair to pair of the pieces of its curves, and others are searched for."""
    if case.others or case.supports or not has_pieces(case):
        return False
    return isinstance(case.track, Chain) or bool(limit(case, Scope.SHAPES) or limit(case, Scope.SEVERAL_CONTACTS))


def sides_of(pair: AnyPair) -> set[int]:
    """The numbers of the plates at a contact."""
    return {side for side in plates_at(pair) if side is not None}


def watched_pairs(couple: Couple, poses: np.ndarray) -> list[tuple[PieceCase, tuple[float, float]]]:
    """The pairs of elements of a couple that are watched, with parameters near their nearest points in some poses: that
    of each corner of a polygon on a line, or the nearest one of two plates, or of a smooth plate and a line."""
    track, outline = couple.track, couple.plate.outline
    if isinstance(outline, Chain) and couple.base is None:
        corners = [element for element in outline.elements if isinstance(element.piece, Corner)]
        return [(piece_case_of(couple, 0, e.number), (float(track.span[0]), e.middle)) for e in corners]
    one = nearest_pair(track, outline, *couple.relative_pose(poses))
    assert one is not None
    pair = piece_case_of(couple, track.element_at(one.xi1).number, outline.element_at(one.xi2).number)
    return [(pair, (one.xi1 - pair.first.shift, one.xi2 - pair.second.shift))]


def common_slips(pairs: Sequence[AnyPair]) -> int:
    """How many of some contacts are second corners of a plate on one line: the friction of both is not unique."""
    lines = [pair.whole for pair in pairs if plates_at(pair)[1] is None]
    return len(lines) - len(set(lines))


def groups(pairs: Sequence[AnyPair]) -> list[list[int]]:
    """The places of contacts in groups that share plates."""
    results = list[list[int]]()
    for k, pair in enumerate(pairs):
        own = [some for some in results if any(sides_of(pairs[i]) & sides_of(pair) for i in some)]
        results = [some for some in results if some not in own] + [sorted([k, *(i for some in own for i in some)])]
    return results
