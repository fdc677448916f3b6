"""Contacts of plates of any shape along a motion, from poses and velocities alone.

Each plate forms a couple with the track, each support, and each other plate. In every sample the places are found at
which an element of the plate and one of the boundary are nearest; a contact is such a place, followed from sample to
sample.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from math import dist
from typing import NamedTuple

import numpy as np

from cases import Case
from cases.contact import belt_speed
from cases.contact.close_pairs import circles_around, close_pairs
from cases.contact.element_pairs import may_touch
from cases.contact.geometry import clearance
from cases.contact.shapes import guess, shapes
from cases.curves.corner import Corner
from cases.curves.element import Element
from cases.scene.contact_names import contact_name
from cases.scene.couples import Couple, couples
from cases.scene.free_plates import plates_of

from .pose_contact import PoseContact, cone_slope

# Places that are farther apart than this part of the smaller plate do not matter.
NEAR = 0.2
# A corner belongs to a place if the other curve's normal is outside its angle by less than this, rad: a side that lies
# flat is tilted by what the engine's overlap leaves, and the gap of its upper corner is known before it comes down.
TILT = 0.25
# Two places in one sample that are closer than this part of the smaller plate are one, as at a seam.
ONE_PLACE = 0.05
# From sample to sample a contact moves along the boundary by less than this part of the smaller plate.
STEP = 0.5


class Places(NamedTuple):
    """Places where a plate and a boundary are near, arrays (m,): the sample, both parameters and the gap (m)."""

    sample: np.ndarray
    xi1: np.ndarray
    xi2: np.ndarray
    gap: np.ndarray


def couple_contacts(
    case: Case, t: np.ndarray, poses: np.ndarray, rates: np.ndarray, clear: float, slip_lever: float
) -> list[PoseContact]:
    """The contacts of all couples of a case along a motion, those of one couple numbered in the order in which they
    first close; poses and rates (n, plates, 3). `clear`: the gap (m) below which a contact is closed. The engine's
    friction acts at the share `slip_lever` of the gap from the plate that is named first."""
    result = list[PoseContact]()
    for couple in couples(case):
        near = places_of(couple, poses)
        plate, boundary = couple.pair_name.split("/")
        for number, place in enumerate(_followed(couple, near, len(t), clear), start=1):
            name = contact_name(plate, boundary, number)
            result.append(_along(couple, name, place, t, poses, rates, slip_lever))
    return result


def size_of(couple: Couple) -> float:
    """The radius of the largest circle in the smaller plate of a couple, m."""
    plates = plates_of(couple.whole)
    return min(plates[body].inner for body in (couple.body, couple.base) if body is not None)


# --- places in each sample --------------------------------------------------------------------------------------------


def gaps_in(couple: Couple, poses: np.ndarray) -> np.ndarray:
    """The gaps (m) of the places where plate and boundary are near, in one pose of all plates (plates, 3)."""
    return places_of(couple, poses[None]).gap


def places_of(couple: Couple, poses: np.ndarray) -> Places:
    """The places where plate and boundary are near, in poses (n, plates, 3) of all plates; the nearest of each sample
    first."""
    most, columns = NEAR * size_of(couple), poses.reshape(len(poses), -1).T
    pose = np.array(np.broadcast_arrays(*couple.relative_pose(columns)), dtype=float)
    some = [np.empty((4, 0)), *_near_elements(couple, pose, most)]
    table = np.hstack(some)
    table = table[:, np.lexsort((np.abs(table[3]), table[0]))]
    alone, kept, last = np.zeros(table.shape[1], dtype=bool), list[np.ndarray](), -1.0
    for number, (sample, place) in enumerate(zip(table[0].tolist(), couple.track.point(table[1]).T, strict=True)):
        kept = kept if sample == last else []
        last = sample
        alone[number] = all(np.hypot(*(place - other)) > ONE_PLACE * size_of(couple) for other in kept)
        if alone[number]:
            kept.append(place)
    sample, *values = table[:, alone]
    return Places(sample.astype(int), *values)


def _near_elements(couple: Couple, pose: np.ndarray, most: float) -> Iterator[np.ndarray]:
    """The places of each two elements that touch, rows as `Places`."""
    u, v, radius = circles_around(couple.track)
    for first in couple.track.elements:
        far = np.hypot(u[first.number] - pose[0], v[first.number] - pose[1])
        near = np.flatnonzero(far <= radius[first.number] + couple.plate.reach + most)
        for second in couple.plate.outline.elements if len(near) else ():
            both = first.piece, second.piece
            if not all(isinstance(piece, Corner) for piece in both) and may_touch(*both):
                samples, *values = _of_elements(first, second, pose[:, near], most)
                yield np.array([near[samples], *values])


def _of_elements(first: Element, second: Element, pose: np.ndarray, most: float) -> list[np.ndarray]:
    """The places of two elements, rows as `Places` with the parameters of the whole curves."""
    form = shapes(first.piece, second.piece)
    if form is not None:
        gap = np.asarray(form.gap(*form.centre(*pose)))
        samples = np.flatnonzero(np.abs(gap) <= most)
        xi1, xi2 = guess(first.piece, second.piece, form, *pose[:, samples])
        gap = gap[samples]
    else:
        rows = [
            (sample, *pair)
            for sample, (x, y, theta) in enumerate(pose.T.tolist())
            for pair in close_pairs(first.piece, second.piece, (x, y, theta), most)
            if pair.gap >= -most and clearance(first.piece, second.piece, pair.xi1, pair.xi2) >= 0.0
        ]
        samples, xi1, xi2, gap = np.reshape(rows, (-1, 4)).T
        samples = samples.astype(int)
    (xi1, on_first), (xi2, on_second) = _on_element(first, xi1), _on_element(second, xi2)
    inside = on_first & on_second
    return [row[inside] for row in (samples, xi1, xi2, gap)]


def _on_element(element: Element, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Parameters of an element as those of the whole curve, and which lie on it: at a corner up to TILT beyond."""
    if element.piece.ends is None:
        return s + element.shift, np.ones(len(s), dtype=bool)
    low, high = element.span
    error = TILT if isinstance(element.piece, Corner) else ROUNDING_OF_ENDS * (high - low)
    return np.clip(s, low, high) + element.shift, (low - error <= s) & (s <= high + error)


# Two elements have a place at their joint, within this part of their length, and `places_of` keeps one.
ROUNDING_OF_ENDS = 1e-9


# --- a place from sample to sample ------------------------------------------------------------------------------------


def _followed(couple: Couple, near: Places, samples: int, clear: float) -> list[Places]:
    """The places of a couple that are closed at some time, over all samples, NaN where they are not near."""
    found, rows = list[np.ndarray](), len(near.sample)
    # A place is known from where it first closes; the second turn finds it before that, while it is near.
    for order, closes in ((range(rows), near.gap <= clear), (range(rows)[::-1], np.zeros(rows, dtype=bool))):
        _follow(couple, found, order, near, closes, samples)
    return [_of_rows(couple, near, rows) for rows in found]


def _follow(
    couple: Couple, found: list[np.ndarray], order: Iterable[int], near: Places, closes: np.ndarray, samples: int
) -> None:
    """Add each row of `near` in an order to the nearest contact of those `found` (the row in each sample, -1 if none),
    which has none in its sample, or to a new one if it `closes`."""
    points, reach = couple.track.point(near.xi1).T.tolist(), STEP * size_of(couple)
    last = [points[int(rows[rows >= 0][0])] for rows in found]
    for i in order:
        at, here = int(near.sample[i]), points[i]
        known = next((k for k, rows in enumerate(found) if rows[at] == i), None)
        if known is None:
            free = [k for k, rows in enumerate(found) if rows[at] < 0 and dist(last[k], here) <= reach]
            known = min(free, key=lambda k: dist(last[k], here), default=None)
        if known is None and closes[i]:
            known = len(found)
            found.append(np.full(samples, -1))
            last.append(here)
        if known is not None:
            found[known][at], last[known] = i, here


def _of_rows(couple: Couple, near: Places, rows: np.ndarray) -> Places:
    """The places of a contact over all samples; parameters of closed curves are counted on from round to round."""
    is_near = rows >= 0
    some, columns = rows[is_near], list[np.ndarray]()
    for values, period in zip(near[1:], (couple.track.period, couple.plate.outline.period, None), strict=True):
        column = np.full(len(rows), np.nan)
        column[is_near] = np.unwrap(values[some], period=period) if period else values[some]
        columns.append(column)
    return Places(np.arange(len(rows)), *columns)


def _along(
    couple: Couple, name: str, place: Places, t: np.ndarray, poses: np.ndarray, rates: np.ndarray, slip_lever: float
) -> PoseContact:
    """A contact along a motion; NaN where its place is not near."""
    body, base = couple.body, couple.base
    places, tangent = (np.full((2, len(t)), np.nan) for _ in range(2))
    near = np.isfinite(place.gap)
    places[:, near], tangent[:, near] = couple.track.point(place.xi1[near]), couple.track.tangent(place.xi1[near])
    origin = np.zeros((2, len(t)))
    if base is not None:
        origin, turn = poses[:, base, :2].T, poses[:, base, 2]
        places, tangent = origin + turned(places, turn), turned(tangent, turn)
    normal = np.array([-tangent[1], tangent[0]])
    places = places + (1.0 - slip_lever) * place.gap * normal
    arm, base_arm = places - poses[:, body, :2].T, places - origin
    velocity = velocity_at(rates[:, body], arm)
    if base is not None:
        velocity = velocity - velocity_at(rates[:, base], base_arm)
    slip = np.sum(velocity * tangent, axis=0) - belt_speed(couple, t)
    return PoseContact(
        name, body, base, cone_slope(couple.effect), place.gap, slip, tangent, normal, couple.whole_xi1(place.xi1),
        place.xi2, arm, np.zeros_like(arm) if base is None else base_arm,
    )  # fmt: skip


def turned(vectors: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Vectors (2, n) turned by angles (n,), rad."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * vectors[0] - s * vectors[1], s * vectors[0] + c * vectors[1]])


def velocity_at(rates: np.ndarray, arm: np.ndarray) -> np.ndarray:
    """The velocity (2, n) of a plate's point at `arm` (2, n) from its origin, of rates (n, 3)."""
    vx, vy, omega = rates.T
    return np.array([vx - omega * arm[1], vy + omega * arm[0]])
