"""A case on one pair of pieces: the contact lies on one smooth piece or corner of the track and one of the outline.

On each pair the equations of contact are smooth. A motion goes from pair to pair: where the contact reaches the end of
a piece, the next piece follows, with the same slip velocity and spin, since position and direction are continuous
along a chain.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from math import pi
from typing import cast

from ..contact.geometry import clearance
from ..curves import Curve
from ..curves.chain import Chain
from ..curves.corner import Corner, Piece
from ..curves.element import Element
from .case_class import Case
from .case_part import CasePart, with_outline
from .start import Start


class PieceCase(CasePart):
    """A case whose track and outline are one piece each of those of `whole`; contact parameters are the pieces' own.

    `first`, `second`: the elements of track and outline. It is made by `pieces_at` and `neighbour`, not by hand.
    """

    first: Element
    second: Element

    def __reduce__(self):
        return piece_case_of, (self.whole, *self.key)

    @property
    def pieces(self) -> tuple[Piece, Piece]:
        """The pieces of track and outline."""
        return self.first.piece, self.second.piece

    def to_whole(self, xi1, xi2):
        """Contact parameters of the pieces as those of the whole curves."""
        return xi1 + self.first.shift, xi2 + self.second.shift

    @property
    def turn(self) -> float:
        """The plate's angle in the whole case less the one that the pieces give, a multiple of 2π."""
        return 2 * pi * (self.first.turns - self.second.turns)


def has_pieces(case: Case) -> bool:
    """Whether the case's track or outline is a chain."""
    return isinstance(case.track, Chain) or isinstance(case.plate.outline, Chain)


def pieces_at(case: Case, xi1: float, xi2: float) -> PieceCase:
    """The case on the pieces at two parameters of its curves."""
    return piece_case_of(case, case.track.element_at(xi1).number, case.plate.outline.element_at(xi2).number)


def neighbour(case: PieceCase, of_track: bool, step: int) -> PieceCase | None:
    """The case on the next piece (`step` 1) or the one before (−1) of track or outline; None at an open end."""
    curve = case.whole.track if of_track else case.whole.plate.outline
    first, second = case.first.number, case.second.number
    number = (first if of_track else second) + step
    if curve.element(number) is None:
        return None
    return piece_case_of(case.whole, number, second) if of_track else piece_case_of(case.whole, first, number)


def is_concave(case: PieceCase) -> bool:
    """Whether the contact would lie in a corner that points away from the other curve: a second contact comes first."""
    track, outline = case.pieces
    return (isinstance(track, Corner) and track.turn > 0.0) or (isinstance(outline, Corner) and outline.turn < 0.0)


def corner_on_corner(case: PieceCase) -> bool:
    """Whether both pieces are corners."""
    return all(isinstance(piece, Corner) for piece in case.pieces)


# A plate lies flat where an edge of it and one of the track differ by less than this direction (rad), and touches a
# corner within this distance (m): the rounding of an angle after some turns, and of a place some metres away.
LEVEL = 1e-11


def lies_flat(case: PieceCase, xi1: float, xi2: float) -> bool:
    """Whether a plate that touches at these parameters of its pieces lies along its track: on a piece that does not
    bend more than the track, or at a corner with the direction of such a piece that ends there."""
    if not any(isinstance(piece, Corner) for piece in case.pieces):
        return not clearance(*case.pieces, xi1, xi2) > 0.0
    for i, step, distance, following in _next_pieces(case, (xi1, xi2), of_corners=True):
        ends = [xi1, xi2]
        ends[i] = following.pieces[i].span[0 if step > 0 else 1]
        if abs(distance) <= LEVEL and not clearance(*following.pieces, *ends) > 0.0:
            return True
    return False


def corners_meet(case: PieceCase, xi1: float, xi2: float) -> bool:
    """Whether a corner touches a corner at these parameters: also one that touches the end of a piece next to it."""
    return touching_corners(case, xi1, xi2) is not None


def touching_corners(case: PieceCase, xi1: float, xi2: float) -> PieceCase | None:
    """The case on the corners that `corners_meet`; None if they do not."""
    if corner_on_corner(case):
        return case
    some = (xi1, xi2)
    for i, _, distance, following in _next_pieces(case, some, of_corners=False):
        if abs(distance) * float(case.pieces[i].speed(some[i])) <= LEVEL and corner_on_corner(following):
            return following
    return None


def _next_pieces(
    case: PieceCase, places: tuple[float, float], of_corners: bool
) -> Iterator[tuple[int, int, float, PieceCase]]:
    """Of a corner on a piece: the neighbours of the corner, or of the piece, each with the number of its curve, its
    side, how far its end is from the contact's parameter, and the case on it."""
    for i, (piece, s) in enumerate(zip(case.pieces, places, strict=True)):
        if isinstance(piece, Corner) is not of_corners or isinstance(case.pieces[1 - i], Corner) is of_corners:
            continue
        low, high = piece.span
        for step, distance in ((-1, s - low), (1, high - s)):
            following = neighbour(case, i == 0, step)
            if following is not None:
                yield i, step, distance, following


@lru_cache(maxsize=4096)
def piece_case_of(whole: Case, first: int, second: int) -> PieceCase:
    """The case on the elements of track and outline with these numbers."""
    on_track, on_outline = whole.track.element(first), whole.plate.outline.element(second)
    assert on_track is not None and on_outline is not None
    # Corners have the methods of curves that the equations of contact use.
    track, outline = cast(Curve, on_track.piece), cast(Curve, on_outline.piece)
    is_whole = whole.track is track and whole.plate.outline is outline
    start = whole.start if is_whole else Start(on_track.middle, on_outline.middle)
    plate = with_outline(whole.plate, outline)
    return PieceCase.of(
        whole, (first, second), track=track, plate=plate, start=start, first=on_track, second=on_outline
    )
