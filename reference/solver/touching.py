"""Contacts in a pose: all pairs of elements without a gap, and the names of contacts."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import cast

import numpy as np

from cases import Case, Chain
from cases.contact.close_pairs import circles_around, close_pairs
from cases.contact.element_pairs import may_touch
from cases.contact.geometry import bends, clearance
from cases.contact.overlap_search import OVERLAPS
from cases.curves.corner import Corner, Piece
from cases.scene.couples import Couple, couples
from cases.scene.piece_case import PieceCase, piece_case_of
from cases.scene.supports import is_straight

from ..curvature_proof import curvatures
from ..scales import TOUCHES
from .places import place
from .plate_numbers import size, speed
from .regimes import AT_END

# Two contacts are one if their place, in units of the plate's reach, and direction differ by less than this: curves
# whose curvatures differ by a thousandth of 1/reach are apart by less than a pose's rounding there.
SAME_PLACE = 1e-5


@lru_cache(maxsize=256)
def pairs_that_touch(couple: Couple) -> tuple[PieceCase, ...]:
    """The pairs of elements of a couple that may touch before their neighbours do."""
    result = list[PieceCase]()
    for first in couple.track.elements:
        for second in couple.plate.outline.elements:
            both_corners = isinstance(first.piece, Corner) and isinstance(second.piece, Corner)
            if not both_corners and may_touch(first.piece, second.piece, bend_bounds):
                result.append(piece_case_of(couple, first.number, second.number))
    return tuple(result)


@lru_cache(maxsize=1024)
def bend_bounds(piece: Piece) -> tuple[float, float]:
    """Bounds on an element's curvature, 1/m, however fine its features; at a corner as `geometry.bends`."""
    return bends(piece) if isinstance(piece, Corner) else curvatures(piece)


def touching_contacts(
    case: Case, state: np.ndarray, part: float = TOUCHES, of: int | None = None
) -> Iterator[tuple[PieceCase, tuple[float, float]]]:
    """The pairs of elements that touch in a state of all plates, with their own parameters; `part`: of the plates' size
    and place, below which a gap is none; `of`: the number of the only couple that is looked at."""
    poses = np.asarray(state[: len(state) // 2], dtype=float)
    least, deepest = part * size(case, state), max(part, OVERLAPS) * size(case, state)
    for couple in couples(case) if of is None else (couples(case)[of],):
        yield from touching_of(couple, poses, least, deepest)


def touching_of(
    couple: Couple, poses: np.ndarray, least: float, deepest: float
) -> Iterator[tuple[PieceCase, tuple[float, float]]]:
    """The same of one couple in poses of all plates, with gaps between −deepest and least (m)."""
    x, y, theta = (float(v) for v in couple.relative_pose(poses))
    places = list[np.ndarray]()
    u, v, radius = circles_around(couple.track)
    is_near = np.hypot(u - x, v - y) <= radius + 1.001 * couple.plate.reach
    for pair in pairs_that_touch(couple):
        if not is_near[pair.first.number]:
            continue
        for at in close_pairs(*cast(tuple[Piece, Piece], pair.pieces), (x, y, theta), least):
            if not -deepest <= at.gap <= least or not inside(pair, at.xi1, at.xi2):
                continue
            if clearance(*pair.pieces, at.xi1, at.xi2) < 0.0:  # the gap is a largest one, next to an inflection
                continue
            where = place_on_track(pair, at.xi1)
            if all(np.abs(where - one).max() > SAME_PLACE for one in places):
                places.append(where)
                yield pair, (at.xi1, at.xi2)


def contacts_at_start(case: Case, state: Sequence[float]) -> list[tuple[PieceCase, tuple[float, float]]]:
    """The pairs of elements that touch where a motion begins: a motion that begins again in one of its states has its
    errors, so that contacts whose gap hardly changes may have one."""
    values, least, result = np.array(state), TOUCHES * size(case, state), list[tuple[PieceCase, tuple[float, float]]]()
    slow, half = OVERLAPS * speed(case, state), len(values) // 2
    for pair, points in touching_contacts(case, values, OVERLAPS):
        at = place(pair, state, points)
        if at.gap <= least or abs(float(at.lift_row @ values[half:])) <= slow:
            result.append((pair, points))
    return result


def place_on_track(pair: PieceCase, xi1: float) -> np.ndarray:
    """The point of a contact in units of the plate's reach, and its direction, (4,): next to a joint of two elements
    both have the same."""
    track = cast(Piece, pair.pieces[0])
    return np.array([*(track.point(xi1) / pair.plate.reach), *track.tangent(xi1)])


def inside(pair: PieceCase, xi1: float, xi2: float, turn: float = AT_END) -> bool:
    """Whether parameters lie between the ends of both elements, or at them; `turn`: within which (rad) the direction of
    a corner is at its end."""
    for piece, s in zip(cast(tuple[Piece, Piece], pair.pieces), (xi1, xi2), strict=True):
        low, high = piece.ends or (-np.inf, np.inf)
        error = turn if isinstance(piece, Corner) else AT_END
        if not low - error <= s <= high + error:
            return False
    return True


def name_of(pair: PieceCase, used: set[str]) -> str:
    """The name of a contact that begins: that of its couple, further ones numbered from 2. The corners of a plate among
    several on a straight line without ends have the numbers of their order in the outline, where these are free: a
    contact that came from an arc to a corner keeps its name."""
    couple = cast(Couple, pair.whole)
    outline, track = couple.plate.outline, couple.track
    if couple.whole.others and isinstance(outline, Chain) and is_straight(track):
        corners = [element.number for element in outline.elements if isinstance(element.piece, Corner)]
        number = pair.second.number % len(outline.elements)
        if number in corners and (name := _numbered(couple.pair_name, corners.index(number) + 1)) not in used:
            return name
    return next(name for i in range(1, len(used) + 2) if (name := _numbered(couple.pair_name, i)) not in used)


def _numbered(name: str, number: int) -> str:
    return name if number == 1 else f"{name} {number}"
