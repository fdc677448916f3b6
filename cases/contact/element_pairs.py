"""The nearest points of curves with pieces or corners: all pairs of an element of the track and one of the outline.

A pair of nearest points has a common normal: two smooth pieces where their tangents are parallel, a corner where the
direction to the other point is in its angle. Of each two elements the pairs are looked up on their own.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from math import atan2, cos, hypot, inf, pi, sin
from typing import NamedTuple

import numpy as np

from ..curves import Curve
from ..curves.chain import Chain
from ..curves.corner import Corner, Piece
from ..curves.curve_samples import squares
from ..curves.element import Element
from ..curves.outline import sizes_of
from ..errors import DoesNotFit
from .geometry import EPS, Contact, angle_on, bends, find
from .nearest_samples import nearest_samples

# Points of an outline's piece, next to one of which its nearest point to a corner or a line is.
PIECE_POINTS = 257
# Points of an element of a chain, which say how near it may be.
ELEMENT_POINTS = 33
# A place beyond the end of an element by this part of its width, or of a corner's angle by this, rad, is a rounding's;
# lengths differ by one within it, in parts of the plate's size and place.
SAME_PLACE = 1e-12

Pose = tuple[float, float, float]


class _ElementPoints(NamedTuple):
    """Points of the elements of a chain (elements, ELEMENT_POINTS, 2), and the distance of the farthest two next to
    each other of each element, m (elements,)."""

    points: np.ndarray
    spacings: np.ndarray

    def least(self, x: float, y: float) -> np.ndarray:
        """What the elements are away from a point at least, m."""
        return np.sqrt(squares(self.points, np.array([x, y])).min(axis=1)) - self.spacings


def may_touch(track: Piece, outline: Piece, bounds: Callable[[Piece], tuple[float, float]] = bends) -> bool:
    """Whether two elements may be nearest to each other between their ends: straight ones touch hollow ones at their
    ends only, and a corner that points away from the other curve does not touch it. `bounds`: of a piece's curvature,
    1/m."""
    if isinstance(track, Corner):
        return track.turn < 0.0 and (not isinstance(outline, Corner) or outline.turn > 0.0)
    if isinstance(outline, Corner):
        return outline.turn > 0.0
    is_below_side = outline.features is None and bounds(track)[0] >= 0.0
    return not is_below_side and not (track.features is None and bounds(outline)[1] <= 0.0)


def first_guesses(track: Piece, outline: Piece, x: float, y: float, theta: float) -> list[tuple[float, float]]:
    """Parameters from which Newton's method finds the pairs of two elements that are nearest in a pose."""
    if isinstance(track, Curve):
        is_straight = track.features is None
        if is_straight and isinstance(outline, Corner):
            return [(0.5 * sum(track.span), 0.5 * sum(outline.span))]
        return (
            _over_line(track, outline, (x, y, theta)) if is_straight else nearest_samples(track, outline, x, y, theta)
        )
    (u, v), grid = _in_frame(track, (x, y, theta)), np.linspace(*outline.span, PIECE_POINTS)
    return [(0.5 * sum(track.span), float(grid[i])) for i in _least(squares(outline.point(grid).T, np.array([u, v])))]


def _over_line(track: Curve, outline: Piece, pose: Pose) -> list[tuple[float, float]]:
    """The same of a straight track: where points of a piece are lowest over it."""
    s, grid = 0.5 * sum(track.span), np.linspace(*outline.span, PIECE_POINTS)
    (x, y, theta), (nx, ny) = pose, track.normal(s)
    c, w = cos(theta), sin(theta)
    u, v = outline.point(grid)
    tx, ty = track.tangent(s) / track.speed(s)
    px, py = x + c * u - w * v - track.point(s)[0], y + w * u + c * v - track.point(s)[1]
    return [(float(s + px[i] * tx + py[i] * ty), float(grid[i])) for i in _least(px * nx + py * ny)]


def _least(values: np.ndarray) -> list[int]:
    """Where values (n,) are at most those next to them."""
    padded = np.pad(values, 1, constant_values=inf)
    return np.flatnonzero((values <= padded[:-2]) & (values <= padded[2:])).tolist()


def _in_frame(corner: Corner, pose: Pose) -> tuple[float, float]:
    """A corner of the track in the frame of the plate."""
    u, v, c, s = corner.x - pose[0], corner.y - pose[1], cos(pose[2]), sin(pose[2])
    return c * u + s * v, c * v - s * u


def common_normals(track: Curve, outline: Curve, x: float, y: float, theta: float) -> list[Contact]:
    """Pairs of points with a common normal in a pose, each on an element of the track and one of the outline, between
    the ends of both, the one with the smallest gap (m, signed) first; all that may be the nearest, and others."""
    pose, results, nearest = (x, y, theta), list[Contact](), inf
    reach = sizes_of(outline).reach
    elements, least = track.elements, np.zeros(1)
    if len(elements) > 1:
        least = _element_points(track).least(x, y) - reach
    for number in np.argsort(least):
        if least[number] > nearest:
            break
        for second in outline.elements:
            if not may_touch(elements[number].piece, second.piece):
                continue
            some = _between(track, outline, elements[number], second, pose)
            results += some
            nearest = min([nearest, *(one.gap for one in some if one.gap > 0.0)])
    return sorted(results, key=lambda one: one.gap)


def nearest_on_elements(track: Curve, outline: Curve, x: float, y: float, theta: float) -> list[Contact]:
    """Those of `common_normals` whose point of the track is the nearest to that of the outline: no track is behind."""
    every = common_normals(track, outline, x, y, theta)
    return [one for one in every if one.gap >= 0.0 or _is_nearest(track, outline, one, (x, y, theta))]


def _between(track: Curve, outline: Curve, first: Element, second: Element, pose: Pose) -> list[Contact]:
    """The pairs of two elements in a pose, in the curves' parameters."""
    both = (track, first), (outline, second)
    if isinstance(first.piece, Corner) and isinstance(second.piece, Corner):
        return _on_both(*both, _of_corners(first.piece, second.piece, pose))
    return pairs_from(*both, pose, first_guesses(first.piece, second.piece, *pose))


def pairs_from(
    first: tuple[Curve, Element], second: tuple[Curve, Element], pose: Pose, guesses: list[tuple[float, float]]
) -> list[Contact]:
    """The pairs of nearest points, between the ends of an element of the track and one of the outline, to which
    Newton's method goes from parameters of both; in the curves' parameters."""
    results = list[Contact]()
    for guess in guesses:
        try:
            results += _on_both(first, second, find(first[1].piece, second[1].piece, *pose, guess))
        except DoesNotFit:  # it ends nowhere
            continue
    return results


def _on_both(first: tuple[Curve, Element], second: tuple[Curve, Element], contact: Contact) -> list[Contact]:
    xi1, xi2 = _place(*first, contact.xi1), _place(*second, contact.xi2)
    return [] if xi1 is None or xi2 is None else [Contact(xi1, xi2, contact.gap)]


def _of_corners(track: Corner, outline: Corner, pose: Pose) -> Contact:
    """Two corners, whose normal is the direction from one to the other; they do not overlap."""
    u, v = _in_frame(track, pose)
    # In the plate's frame; the tangent is the normal, turned back by a right angle.
    dx, dy = outline.x - u, outline.y - v
    direction = atan2(-dx, dy)
    near = 0.5 * sum(track.span), 0.5 * sum(outline.span)
    xi1, xi2 = angle_on(track, direction + pose[2], near[0]), angle_on(outline, direction, near[1])
    return Contact(xi1, xi2, hypot(dx, dy))


def _place(curve: Curve, element: Element, s: float) -> float | None:
    """The curve's parameter at that of an element; None beyond the element's ends."""
    piece = element.piece
    turn = 2.0 * pi if isinstance(piece, Corner) else piece.period or inf
    if not isinstance(curve, Chain) and not curve.ends:
        return s
    (low, high) = element.span
    # The parameter next to the middle of the piece, within its own range to rounding.
    s = s - turn * round((s - element.middle) / turn) if turn < inf else s
    rounding = SAME_PLACE * (1.0 if isinstance(piece, Corner) else high - low) + 4.0 * EPS * abs(s)
    if not low - rounding <= s <= high + rounding:
        return None
    if not isinstance(curve, Chain):
        return min(max(s, low), high)
    # At a joint a parameter may belong to the neighbour: a rounding keeps it on this element.
    first, last = element.start, element.start + (high - low)
    return min(max(s + element.shift, float(np.nextafter(first, inf))), float(np.nextafter(last, -inf)))


def _is_nearest(track: Curve, outline: Curve, contact: Contact, pose: Pose) -> bool:
    """Whether no point of the track is nearer to the outline's point of a contact than its own, by more than a
    rounding."""
    (x, y, theta), (u, v) = pose, outline.point(contact.xi2)
    px, py = x + cos(theta) * u - sin(theta) * v, y + sin(theta) * u + cos(theta) * v
    most = abs(contact.gap) - SAME_PLACE * (abs(px) + abs(py) + sizes_of(outline).reach)
    if len(track.elements) == 1 and track.features is None:
        return True
    least = _element_points(track).least(px, py) if len(track.elements) > 1 else np.zeros(1)
    return all(_distance(track.elements[i].piece, px, py) >= most for i in np.flatnonzero(least < most).tolist())


def _distance(piece: Piece, x: float, y: float) -> float:
    """How far a point is from a piece, m."""
    if isinstance(piece, Corner):
        return hypot(piece.x - x, piece.y - y)
    point, ends = Corner(x, y, 0.0, 0.0), piece.ends or (-inf, inf)
    guess = nearest_samples(piece, point, 0.0, 0.0, 0.0)[0] if piece.features else (0.5 * sum(piece.span), 0.0)
    try:
        s = find(piece, point, 0.0, 0.0, 0.0, guess).xi1
    except DoesNotFit:  # an end
        s = guess[0]
    u, v = piece.point(min(max(s, ends[0]), ends[1]))
    return hypot(u - x, v - y)


@lru_cache(maxsize=64)
def _element_points(chain: Chain) -> _ElementPoints:
    points = np.array([one.piece.point(np.linspace(*one.span, ELEMENT_POINTS)).T for one in chain.elements])
    longest = np.sqrt(squares(points[:, 1:], points[:, :-1]).max(axis=1))
    return _ElementPoints(points, longest)
