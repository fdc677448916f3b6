"""The nearest points of curves with pieces or corners: all pairs of an element of the track and one of the outline.

A pair of nearest points has a common normal: two smooth pieces where their tangents are parallel, a corner where the
direction to the other point is in its angle. Of each two elements the pairs are looked up on their own.
"""

from __future__ import annotations

from collections.abc import Callable
from math import atan2, cos, hypot, inf, pi, sin

import numpy as np

from ..curves import Curve
from ..curves.chain import Chain
from ..curves.corner import Corner, Piece
from ..curves.element import Element
from ..curves.outline import sizes_of
from .close_pairs import Pose, circles_around, close_pairs, nearest_on
from .geometry import EPS, Contact, angle_on, bends

# A place beyond the end of an element by this part of its width, or of a corner's angle by this, rad, is a rounding's;
# lengths differ by one within it, in parts of the plate's size and place.
SAME_PLACE = 1e-12


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


def in_frame(x: float, y: float, pose: Pose) -> tuple[float, float]:
    """A point in the frame of the plate."""
    u, v, c, s = x - pose[0], y - pose[1], cos(pose[2]), sin(pose[2])
    return c * u + s * v, c * v - s * u


def common_normals(
    track: Curve, outline: Curve, x: float, y: float, theta: float, most: float | None = None
) -> list[Contact]:
    """Pairs of points with a common normal in a pose, each on an element of the track and one of the outline, between
    the ends of both, the one with the smallest gap (m, signed) first: all with a gap of at most `most`, or, with None,
    all that may be the nearest, and others."""
    pose, results, nearest = (x, y, theta), list[Contact](), inf
    elements, (u, v, radius) = track.elements, circles_around(track)
    least = np.hypot(u - x, v - y) - radius - sizes_of(outline).reach
    for number in np.argsort(least):
        first = elements[number]
        if least[number] > (nearest if most is None else most):
            break
        for second in outline.elements:
            if not may_touch(first.piece, second.piece):
                continue
            if isinstance(first.piece, Corner) and isinstance(second.piece, Corner):
                some = [_of_corners(first.piece, second.piece, pose)]
            else:
                some = close_pairs(first.piece, second.piece, pose, most)
            own = [one for pair in some for one in _on_both((track, first), (outline, second), pair)]
            results += own
            nearest = min([nearest, *(one.gap for one in own if one.gap > 0.0)])
    return sorted(results, key=lambda one: one.gap)


def nearest_on_elements(
    track: Curve, outline: Curve, x: float, y: float, theta: float, most: float | None = None
) -> list[Contact]:
    """Those of `common_normals` whose point of the track is the nearest to that of the outline: no track is behind."""
    every = common_normals(track, outline, x, y, theta, most)
    return [one for one in every if one.gap >= 0.0 or _is_nearest(track, outline, one, (x, y, theta))]


def _on_both(first: tuple[Curve, Element], second: tuple[Curve, Element], contact: Contact) -> list[Contact]:
    xi1, xi2 = _place(*first, contact.xi1), _place(*second, contact.xi2)
    return [] if xi1 is None or xi2 is None else [Contact(xi1, xi2, contact.gap)]


def _of_corners(track: Corner, outline: Corner, pose: Pose) -> Contact:
    """Two corners, whose normal is the direction from one to the other; they do not overlap."""
    u, v = in_frame(track.x, track.y, pose)
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
    return bool(np.hypot(*(track.point(nearest_on(track, px, py)) - (px, py))) >= most)
