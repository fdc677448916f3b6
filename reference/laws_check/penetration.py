"""How deep plates lie in tracks, supports and each other, at the samples of a motion. A positive depth is an overlap.

A disc and a convex polygon are exact. The outline of another plate is a polygon inside it, so that what it reports is
real. (An open outline encloses nothing.) The track is looked at from its left side only where it is a straight line;
where it is curved, a part of it lies inside the plate, as does an end of it that the plate has passed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from cases import Case, Chain, Curve, Plate
from cases.contact.nearest import contacts
from cases.contact.overlap_search import first_overlap
from cases.curves.line_or_circle import as_line
from cases.scene.free_plates import names_of, plates_of
from cases.scene.supports import TRACK

from .samples import PlateSamples

# Corners of the polygon inside a smooth outline, and the turn (rad) between those on a chain's arcs: it misses overlaps
# of a thousandth of the plate's size.
CORNERS, CHAIN_TURN = 96, 0.05
# Poses in which a track lies inside a polygon, whose depth is measured: the first ones.
MEASURED = 3


class Depth(NamedTuple):
    """Depths (m, negative: apart) of a pair of that name at times (s), of one shape."""

    pair: str
    times: np.ndarray
    depths: np.ndarray


@lru_cache(maxsize=256)
def corners_of(outline: Curve) -> np.ndarray | None:
    """Corners (k,) of a polygon inside an outline, complex, in the plate's frame; None if it encloses nothing."""
    if not outline.period:
        return None
    if isinstance(outline, Chain):
        s = outline.vertices(CHAIN_TURN)[:-1]
    else:
        s = np.linspace(*outline.span, CORNERS, endpoint=False)
    x, y = outline.point(s)
    corners = x + 1j * y
    return corners[np.abs(corners - np.roll(corners, 1)) > 1e-12 * np.abs(corners).max()]  # a side has a direction


@lru_cache(maxsize=256)
def line_of(curve: Curve) -> tuple[complex, complex] | None:
    """A point and the direction of a straight line without ends; None for another curve."""
    line = as_line(curve) if curve.domain is None else None
    return None if line is None else (complex(*line.point), complex(*line.direction))


def height_above(line: tuple[complex, complex], place: Any) -> Any:
    """The height of places above a line, m, complex numbers or arrays."""
    point, direction = line
    return (direction.conjugate() * (place - point)).imag


def depths(
    case: Case, times: np.ndarray, motions: Sequence[PlateSamples], near: dict[str, np.ndarray]
) -> Iterator[Depth]:
    """The depths of all pairs; times and samples of one shape, `near` as in `MotionSamples`."""
    names, plates = names_of(case), plates_of(case)
    curves = [(TRACK, case.track), *((support.name, support.curve) for support in case.supports)]
    for name, plate, one in zip(names, plates, motions, strict=True):
        for base, curve in curves:
            yield from _in_curve(f"{name}/{base}", curve, plate, one, times, near.get(base))
    for i in range(1, len(plates)):
        for j in range(i):
            depth = _in_plate((plates[i], motions[i]), (plates[j], motions[j]))
            if depth is not None:
                yield Depth(f"{names[i]}/{names[j]}", times, depth)


def _in_curve(
    pair: str, curve: Curve, plate: Plate, one: PlateSamples, times: np.ndarray, near: np.ndarray | None
) -> Iterator[Depth]:
    """A plate in a track or support."""
    line, corners = line_of(curve), corners_of(plate.outline)
    if line is not None:
        height = height_above(line, one.place)
        if plate.radius is not None:
            yield Depth(pair, times, plate.radius - height)
        elif corners is not None:
            lowest = (np.multiply.outer(np.conj(line[1]) * one.turn, corners)).imag.min(axis=-1)
            yield Depth(pair, times, -height - lowest)
        return
    if corners is None:
        return
    for end in curve.point(np.array(curve.ends)).T if curve.ends else ():
        own = (complex(*end) - one.place) * one.turn.conj()
        if (np.abs(own) < plate.reach).any():
            yield Depth(pair, times, -distance(own, corners) if plate.radius is None else plate.radius - np.abs(own))
    if near is None:
        return
    rows = (one.place.real, one.place.imag, np.angle(one.turn), times)
    x, y, theta, when = (np.ravel(row) for row in rows)
    for _ in range(MEASURED):
        overlap = first_overlap(curve, plate.outline, x, y, theta, near) if len(x) else None
        if overlap is None:
            return
        i, xi1 = overlap
        pose = float(x[i]), float(y[i]), float(theta[i])
        gaps = [one.gap for one in contacts(curve, plate.outline, *pose)]
        if min(gaps, default=0.0) >= 0.0 and not isinstance(curve, Chain):  # as of a ripple narrower than it is deep
            gaps.append(-abs(float(distance(_in_frame(curve, xi1, *pose), corners))))
        if gaps:
            yield Depth(pair, when[i : i + 1], -np.array([min(gaps)]))
        x, y, theta, when = (row[i + 1 :] for row in (x, y, theta, when))


def _in_frame(curve: Curve, s: float, x: float, y: float, theta: float) -> complex:
    """A point of a curve in the frame of a plate, complex."""
    return complex((complex(*curve.point(s)) - (x + 1j * y)) * np.exp(-1j * theta))


def _in_plate(first: tuple[Plate, PlateSamples], second: tuple[Plate, PlateSamples]) -> np.ndarray | None:
    """A disc in a disc or in a convex polygon; None for two polygons."""
    (plate, one), (other, base) = sorted((first, second), key=lambda each: each[0].radius is None)
    if plate.radius is None:
        return None
    if other.radius is not None:
        return plate.radius + other.radius - np.abs(one.place - base.place)
    corners = corners_of(other.outline)
    if corners is None:
        return None
    return plate.radius - distance((one.place - base.place) * base.turn.conj(), corners)


def distance(points: Any, corners: np.ndarray) -> np.ndarray:
    """The distance of points from a convex polygon, negative inside; complex. It vanishes on the sides of any other."""
    side = np.roll(corners, -1) - corners
    length = np.abs(side)
    offset = (np.asarray(points)[..., None] - corners) * (side.conj() / length)
    outside = -offset.imag
    nearest = np.abs(offset - np.clip(offset.real, 0.0, length)).min(axis=-1)
    inside = outside.max(axis=-1)
    return np.where(inside <= 0.0, inside, nearest)
