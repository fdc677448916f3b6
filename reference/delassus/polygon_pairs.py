"""Contacts of a free polygon in their frames: its corners on lines, and discs on its edges and corners.

A disc on a corner is the corner on the disc's boundary: the frame has the opposite normal and tangent, and the same
rows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import atan2, hypot, pi
from typing import Any, NamedTuple

import numpy as np

from cases import Curve, Plate
from cases.contact.polygon_features import is_polygon
from cases.curves.chain import Chain
from cases.curves.corner import Corner, Edge
from cases.curves.element import Element
from cases.library import hill
from cases.scene.free_plates import PlateContact, parameter

from .bodies import ContactOfBodies, _frame
from .contacts import PairState, pair_at


class _Outline(NamedTuple):
    """A plate with one feature as outline."""

    outline: Any


@dataclass(frozen=True, eq=False)
class PolygonPair:
    """A contact of a polygon: that of one of its corners with a line, or that of a disc with one of its edges or
    corners, `element`. `track`, `plate`: the curves of its frame; `disc`: the disc, None on a line."""

    contact: PlateContact
    element: Element
    track: Curve
    plate: _Outline
    disc: Plate | None = None
    base: Plate | None = None
    has_unique_points = True
    arc_range = None

    @property
    def sides(self) -> set[int]:
        """The numbers of the plates."""
        return {side for side in (self.contact.body, self.contact.base) if side is not None}

    def effect(self, kind):
        """The effect of that kind between the two, or None."""
        return self.contact.effect(kind)

    def whole_xi1(self, xi1: float) -> float:
        """The parameter of the line or of the polygon's outline."""
        return xi1

    def whole_xi2(self, xi2: float) -> float:
        """The parameter of the outline of the plate that is named first."""
        return xi2

    def neighbour(self, way: int) -> PolygonPair:
        """The pair of the disc with the next edge or corner (`way` 1), or with the one before (−1)."""
        assert self.disc is not None and self.base is not None
        return disc_on(self.contact, self.disc, self.base, self._number + way)

    @property
    def _number(self) -> int:
        assert self.base is not None and isinstance(self.base.outline, Chain)
        return self.base.outline.elements.index(self.element)

    def inside(self, xi1: float) -> tuple[float, float]:
        """How far a parameter is beyond the element's start and before its end, in units of its width."""
        low, high = self.element.piece.span
        width = high - low
        return (xi1 - self.element.start) / width, (self.element.start + width - xi1) / width


def polygon_pair(contact: PlateContact, plates: Sequence[Plate], poses: np.ndarray) -> PolygonPair | None:
    """The pair of a contact in these poses (plates, 3 or more); None if it is none of a polygon."""
    if is_polygon(plates[contact.body]):
        return corner_pair(contact, plates[contact.body])
    if contact.base is None or not is_polygon(plates[contact.base]):
        return None
    return nearest_pair(contact, plates[contact.body], plates[contact.base], poses)


def corner_pair(contact: PlateContact, plate: Plate) -> PolygonPair:
    """The corner of a contact with a line."""
    assert isinstance(plate.outline, Chain) and contact.curve is not None
    (element,) = (one for one in plate.outline.elements if one.start == contact.circle.first and _is_corner(one))
    return PolygonPair(contact, element, contact.curve, _Outline(element.piece))


def _is_corner(element: Element) -> bool:
    return isinstance(element.piece, Corner)


def disc_on(contact: PlateContact, disc: Plate, base: Plate, number: int) -> PolygonPair:
    """A disc on the edge or corner of a polygon with that number, counted around it."""
    assert isinstance(base.outline, Chain) and disc.radius is not None
    element = base.outline.elements[number % len(base.outline.elements)]
    piece = element.piece
    if isinstance(piece, Corner):
        return PolygonPair(contact, element, hill(disc.radius), _Outline(piece), disc, base)
    low, high = (tuple(map(float, piece.point(s))) for s in piece.span)
    return PolygonPair(contact, element, Edge.between(high, low), _Outline(disc.outline), disc, base)  # type: ignore[arg-type]


def nearest_pair(contact: PlateContact, disc: Plate, base: Plate, poses: np.ndarray) -> PolygonPair:
    """A disc on the edge or corner of a polygon that is nearest in these poses, (plates, 3 or more)."""
    assert isinstance(base.outline, Chain)
    distances = [float(np.min(_distance(one, poses, contact))) for one in base.outline.elements]
    nearest = [k for k, distance in enumerate(distances) if distance <= min(distances) + 1e-12 * base.reach]
    # Both ends of an edge are corners: of equals the edge, unless the foot of its normal is beyond.
    corners = [k for k in nearest if _is_corner(base.outline.elements[k])]
    edges = [k for k in nearest if k not in corners]
    return disc_on(contact, disc, base, edges[0] if len(edges) == 1 and not corners else corners[0])


def _distance(element: Element, poses: np.ndarray, contact: PlateContact) -> float:
    """The distance of a disc's centre from an edge or a corner, m."""
    assert contact.base is not None
    x, y, theta = (float(v) for v in poses[contact.base][:3])
    c, s = np.cos(theta), np.sin(theta)
    dx, dy = poses[contact.body][0] - x, poses[contact.body][1] - y
    place = np.array([c * dx + s * dy, c * dy - s * dx])
    if _is_corner(element):
        return float(hypot(*(place - element.piece.point(0.0))))
    low, high = (np.asarray(element.piece.point(v)) for v in element.piece.span)
    share = min(max(float((place - low) @ (high - low)) / float((high - low) @ (high - low)), 0.0), 1.0)
    return float(hypot(*(place - low - share * (high - low))))


@pair_at.register(PolygonPair)
def _polygon_pair_at(pair: PolygonPair, body: Sequence[float] | np.ndarray, near: tuple[float, float]) -> PairState:
    """The contact in a state of all plates."""
    half, values = len(body) // 2, np.asarray(body, dtype=float)
    states = [(*values[i : i + 3], *values[half + i : half + i + 3]) for i in range(0, half, 3)]
    if pair.disc is None:
        one, gap, xi1, xi2 = _corner_on_line(pair, states)
    elif _is_corner(pair.element):
        one, gap, xi1, xi2 = _disc_on_corner(pair, states)
    else:
        one, gap, xi1, xi2 = _disc_on_edge(pair, states)
    lift_row, slip_row, lift_bias, slip_bias = _frame(one, states)
    velocity = values[half:]
    lift, slip = float(lift_row @ velocity), float(slip_row @ velocity)
    return PairState(pair, xi1, xi2, gap, lift, slip, lift_row, slip_row, lift_bias, slip_bias, 0.0)  # type: ignore[arg-type]


def _rotate(point, theta: float) -> np.ndarray:
    c, s = np.cos(theta), np.sin(theta)
    return np.array([c * point[0] - s * point[1], s * point[0] + c * point[1]])


def _frame_contact(pair: PolygonPair, xi1: float, xi2: float, body: int, base: int | None) -> ContactOfBodies:
    return ContactOfBodies(pair, xi1, xi2, body, base)  # type: ignore[arg-type]


def _in_round(angle: float, element: Element) -> float:
    """The parameter of the outline where the tangent at a corner has a direction (rad) in the plate's frame."""
    corner = element.piece
    assert isinstance(corner, Corner)
    middle = 0.5 * corner.turn
    return element.start + middle + (angle - corner.start - middle + pi) % (2.0 * pi) - pi


def _corner_on_line(pair: PolygonPair, states) -> tuple[ContactOfBodies, float, float, float]:
    own, low = pair.contact.body, float(pair.track.span[0])
    x, y, theta, *_ = states[own]
    point, tangent = pair.track.point(low), pair.track.tangent(low)
    place = np.array([x, y]) + _rotate(pair.plate.outline.point(0.0), theta)
    xi1 = low + float((place - point) @ tangent) / float(pair.track.speed(low))
    gap = float((place - pair.track.point(xi1)) @ pair.track.normal(xi1))
    xi2 = _in_round(atan2(tangent[1], tangent[0]) - theta, pair.element)
    return _frame_contact(pair, xi1, xi2 - pair.element.start, own, None), gap, xi1, xi2


def _disc_on_edge(pair: PolygonPair, states) -> tuple[ContactOfBodies, float, float, float]:
    own, base = pair.contact.body, pair.contact.base
    assert base is not None and pair.disc is not None
    (x, y, theta, *_), (u, v, turn, *_) = states[own], states[base]
    place = _rotate((x - u, y - v), -turn)
    tangent = pair.track.tangent(0.0)
    along = float((place - pair.track.point(0.0)) @ tangent)  # from the edge's end: clockwise
    gap = float((place - pair.track.point(along)) @ pair.track.normal(0.0)) - float(pair.disc.radius or 0.0)
    direction = atan2(tangent[1], tangent[0]) + turn
    xi2 = float(parameter(pair.disc.outline, direction - 0.5 * pi - theta))
    xi1 = pair.element.start + pair.track.span[1] - along
    return _frame_contact(pair, along, xi2, own, base), gap, xi1, xi2


def _disc_on_corner(pair: PolygonPair, states) -> tuple[ContactOfBodies, float, float, float]:
    disc, base = pair.contact.body, pair.contact.base
    assert base is not None and pair.disc is not None
    (x, y, theta, *_), (u, v, turn, *_) = states[disc], states[base]
    arm = _rotate(pair.plate.outline.point(0.0), turn)
    dx, dy = u + arm[0] - x, v + arm[1] - y  # from the disc's centre to the corner
    gap = hypot(dx, dy) - float(pair.disc.radius or 0.0)
    # The polygon's outline runs counter-clockwise: across the direction to the disc.
    xi1 = _in_round(atan2(-dy, -dx) + 0.5 * pi - turn, pair.element)
    xi2 = float(parameter(pair.disc.outline, atan2(dy, dx) - theta))
    return _frame_contact(pair, atan2(dx, dy) + theta, xi1 - pair.element.start, base, disc), gap, xi1, xi2
