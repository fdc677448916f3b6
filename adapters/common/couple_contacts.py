"""Contacts of plates of any shape along a motion, from poses and velocities alone.

Each plate forms a couple with the track, each support, and each other plate. In every sample there are places at
which an element of the plate and one of the boundary are nearest; a contact is such a place, followed from sample to
sample.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from math import atan2, dist, pi
from typing import Any, NamedTuple

import numpy as np

from cases import Case, Curve
from cases.contact import belt_speed
from cases.contact.close_pairs import circles_around, close_pairs
from cases.contact.element_pairs import may_touch
from cases.contact.geometry import clearance
from cases.contact.shapes import Ring, guess, parameter_at, ring_of, shapes, with_direction
from cases.curves.corner import Corner
from cases.curves.element import Element
from cases.curves.line_or_circle import as_line
from cases.scene.contact_names import contact_name
from cases.scene.couples import Couple, couples
from cases.scene.free_plates import plates_of
from cases.scene.plate import is_convex

from .facets import visible_span
from .pose_contact import PoseContact, cone_slope

# Places that are farther apart than this part of the smaller plate do not matter.
NEAR = 0.2
# A corner or arc has a place if the other curve's normal is outside its angle by less than this, rad: a side that lies
# flat is tilted by what the engine's overlap leaves, and the gap of its upper end has a value before that comes down.
TILT = 0.25
# Two elements have a place at their joint, within this part of their length, and one of both is kept.
AT_END = 1e-9
# Two places in one sample that are closer than this part of the smaller plate are one, as at a seam.
ONE_PLACE = 0.05
# Samples of a curve: so many parts of the smaller plate apart, but at least and at most so many; and distances that are
# computed at once (80 MB).
FINENESS, FEWEST, MOST_SAMPLES, MOST_DISTANCES = 1 / 40, 721, 20_000, 10_000_000
# Samples of a closed outline, and steps of Newton's method from the nearest of samples: each squares the error.
OUTLINE_SAMPLES, FOOT_STEPS = 4_001, 6
# From sample to sample a contact moves along the boundary by less than this part of the smaller plate and the way of
# the plate.
STEP = 0.5


class Places(NamedTuple):
    """Places where a plate and a boundary are near, arrays (m,): the sample, both parameters and the gap (m)."""

    sample: np.ndarray
    xi1: np.ndarray
    xi2: np.ndarray
    gap: np.ndarray


# Of contact parameters (n,): the gaps (m) below which such contacts are closed.
Clear = Callable[[np.ndarray], np.ndarray]


def couple_contacts(
    case: Case,
    t: np.ndarray,
    poses: np.ndarray,
    rates: np.ndarray,
    clear: Clear,
    widest: float,
    slip_lever: float = 0.0,
) -> list[PoseContact]:
    """The contacts of all couples of a case along a motion, those of one couple numbered in the order in which they
    first close; poses and rates (n, plates, 3). `widest`: the largest of the `clear` gaps, m. The engine's friction
    acts at the share `slip_lever` of the gap from the plate that is named first."""
    result = list[PoseContact]()
    for couple in couples(case):
        plate, boundary = couple.pair_name.split("/")
        for number, place in enumerate(
            _followed(couple, places_of(couple, poses, widest), _ways(couple, poses), clear), start=1
        ):
            name = contact_name(plate, boundary, number)
            result.append(_along(couple, name, place, t, poses, rates, slip_lever))
    return result


def size_of(couple: Couple) -> float:
    """The size of the smaller plate of a couple, m: the radius of the largest circle in it; of a thin one a tenth of
    its reach."""
    plates = [plates_of(couple.whole)[body] for body in (couple.body, couple.base) if body is not None]
    return min(max(plate.inner, 0.1 * plate.reach) for plate in plates)


# --- places in each sample --------------------------------------------------------------------------------------------


class Gaps(NamedTuple):
    """The gaps (m) with which places matter: no plate's middle is beyond the other's curve, nor are they far apart."""

    low: float
    high: float

    def holds(self, gap: Any) -> Any:
        """Whether a gap is one of them, a number or an array."""
        return (gap >= self.low) & (gap <= self.high)


def places_of(couple: Couple, poses: np.ndarray, widest: float = 0.0) -> Places:
    """The places where plate and boundary are near, in poses (n, plates, 3) of all plates, with gaps up to `widest` (m)
    at least; the nearest of each sample first."""
    gaps = Gaps(-size_of(couple), max(NEAR * size_of(couple), widest))
    some = [np.empty((4, 0)), *_near_elements(couple, gaps, _relative(couple, poses))]
    table = np.hstack(some)
    table = table[:, np.lexsort((table[3], table[0]))]
    alone, nearer, last = np.zeros(table.shape[1], dtype=bool), list[np.ndarray](), -1.0
    for number, (sample, place) in enumerate(zip(table[0].tolist(), couple.track.point(table[1]).T, strict=True)):
        nearer = nearer if sample == last else []
        last = sample
        alone[number] = all(np.hypot(*(place - other)) > ONE_PLACE * size_of(couple) for other in nearer)
        if alone[number]:
            nearer.append(place)
    sample, *values = table[:, alone]
    return Places(sample.astype(int), *values)


def _relative(couple: Couple, poses: np.ndarray) -> np.ndarray:
    """The poses (3, n) of a couple's plate in the frame of its boundary, of those of all plates (n, plates, 3)."""
    columns = poses.reshape(len(poses), -1).T
    return np.array(np.broadcast_arrays(*couple.relative_pose(columns)), dtype=float)


def _near_elements(couple: Couple, gaps: Gaps, pose: np.ndarray) -> Iterator[np.ndarray]:
    """The places of each two elements that touch, rows as `Places`."""
    u, v, radius = circles_around(couple.track)
    for first in couple.track.elements:
        far = np.hypot(u[first.number] - pose[0], v[first.number] - pose[1])
        near = np.flatnonzero(far <= radius[first.number] + couple.plate.reach + gaps.high)
        for second in couple.plate.outline.elements if len(near) else ():
            both = first.piece, second.piece
            if not all(isinstance(piece, Corner) for piece in both) and may_touch(*both):
                samples, *values = _of_elements(couple, gaps, first, second, pose[:, near])
                yield np.array([near[samples], *values])


def _of_elements(couple: Couple, gaps: Gaps, first: Element, second: Element, pose: np.ndarray) -> list[np.ndarray]:
    """The places of two elements, rows as `Places` with the parameters of the whole curves."""
    both, form = (first.piece, second.piece), shapes(first.piece, second.piece)
    if form is not None:
        gap = np.asarray(form.gap(*form.centre(*pose)))
        samples = np.flatnonzero(gaps.holds(gap))
        xi1, xi2 = guess(*both, form, *pose[:, samples])
        gap = gap[samples]
    elif ring := ring_of(second.piece):
        samples, xi1, gap = _ring_on_curve(couple, gaps, first.piece, ring, pose)
        xi2 = with_direction(second.piece, first.piece.tangent_angle(xi1) - pose[2, samples])
    elif (line := as_line(first.piece)) and second.piece.period and is_convex(second.piece):
        xi2 = _with_tangent(second.piece, atan2(line.direction[1], line.direction[0]) - pose[2])
        x, y = pose[:2] + rotate(second.piece.point(xi2), pose[2])
        gap = (y - line.point[1]) * line.direction[0] - (x - line.point[0]) * line.direction[1]
        samples = np.flatnonzero(gaps.holds(gap))
        xi1, xi2, gap = parameter_at(first.piece, x, y)[samples], xi2[samples], gap[samples]
    else:
        rows = [
            (sample, *pair)
            for sample, (x, y, theta) in enumerate(pose.T.tolist())
            for pair in close_pairs(*both, (x, y, theta), gaps.high)
            if gaps.holds(pair.gap) and clearance(*both, pair.xi1, pair.xi2) >= 0.0
        ]
        number, xi1, xi2, gap = np.reshape(rows, (-1, 4)).T
        samples = number.astype(int)
    xi1, on_first = _on_element(first, xi1, isinstance(first.piece, Corner))
    xi2, on_second = _on_element(second, xi2, ring_of(second.piece) is not None)
    inside = on_first & on_second
    return [row[inside] for row in (samples, xi1, xi2, gap)]


def _ring_on_curve(
    couple: Couple, gaps: Gaps, curve: Curve, ring: Ring, pose: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The places where a circle or corner of a plate is nearest to a curve, in poses (3, n): samples, parameters and
    gaps (m), from the nearest of samples of the curve."""
    centre = pose[:2] + rotate(np.array([[ring.x], [ring.y]]), pose[2])
    size = size_of(couple)
    is_endless = curve.ends is None and not curve.period
    low, high = visible_span(couple.whole) if is_endless and curve is couple.whole.track else curve.span
    length = float(np.mean(curve.speed(np.linspace(low, high, FEWEST)))) * (high - low)
    count = int(min(max(length / (FINENESS * size), FEWEST), MOST_SAMPLES))
    grid = np.asarray(curve.even(low, high, count))
    points, far = curve.point(grid), ring.radius + gaps.high
    samples, starts = list[np.ndarray](), list[np.ndarray]()
    block = max(MOST_DISTANCES // count, 1)
    for begin in range(0, centre.shape[1], block):
        x, y = centre[:, begin : begin + block, None]
        square = (points[0] - x) ** 2 + (points[1] - y) ** 2
        inner = np.pad(square, ((0, 0), (1, 1)), constant_values=np.inf)
        lowest = (square < inner[:, :-2]) & (square <= inner[:, 2:]) & (square <= (far + FINENESS * size) ** 2)
        row, column = np.nonzero(lowest)
        samples.append(begin + row)
        starts.append(grid[column])
    sample = np.concatenate(samples)
    xi1 = _feet(curve, centre[:, sample], np.concatenate(starts), float(np.max(np.diff(grid))))
    gap = np.sum((centre[:, sample] - curve.point(xi1)) * curve.normal(xi1), axis=0) - ring.radius
    near = gaps.holds(gap)
    return sample[near], xi1[near], gap[near]


def _with_tangent(outline: Curve, angle: np.ndarray) -> np.ndarray:
    """The parameters (n,) at which the tangent of a closed convex outline has these angles, rad: there a line of that
    angle touches it, by (6). Newton's method from the nearest of its samples."""
    samples = np.linspace(*outline.span, OUTLINE_SAMPLES)
    angles = np.unwrap(np.asarray(outline.tangent_angle(samples)))
    target = angles[0] + (angle - angles[0]) % (2.0 * pi)
    xi2 = np.interp(target, angles, samples)
    for _ in range(FOOT_STEPS):
        off = target - np.asarray(outline.tangent_angle(xi2))
        off -= 2.0 * pi * np.round(off / (2.0 * pi))
        xi2 = xi2 + off / (np.asarray(outline.curvature(xi2)) * np.asarray(outline.speed(xi2)))
    return xi2


def _feet(track: Curve, place: np.ndarray, start: np.ndarray, width: float) -> np.ndarray:
    """The parameters (n,) of the points of a curve nearest to places (2, n), by Newton's method from the nearest of
    samples that are `width` apart."""
    xi1 = start
    for _ in range(FOOT_STEPS):
        off = place - track.point(xi1)
        along = np.sum(off * track.tangent(xi1), axis=0)
        with np.errstate(invalid="ignore"):  # at a corner the curvature is infinite, and the speed is 0
            bend = 1.0 - track.curvature(xi1) * np.sum(off * track.normal(xi1), axis=0)
            rate = np.where(bend > 0.0, bend, 1.0) * track.speed(xi1)
        step = np.divide(along, rate, out=np.zeros_like(along), where=(rate > 0.0) & np.isfinite(rate))
        xi1 = np.clip(xi1 + np.clip(step, -width, width), start - width, start + width)
    return xi1


def _on_element(element: Element, s: np.ndarray, turns: bool) -> tuple[np.ndarray, np.ndarray]:
    """Parameters of an element as the whole curve's, and which lie on it; if it `turns`, as a corner or an arc of
    the plate, up to TILT beyond."""
    piece = element.piece
    if piece.ends is None:
        return s + element.shift, np.ones(len(s), dtype=bool)
    low, high = element.span
    rate = 1.0 if isinstance(piece, Corner) else abs(float(piece.curvature(low) * piece.speed(low)))
    error = TILT / rate if turns else AT_END * (high - low)
    return np.clip(s, low, high) + element.shift, (low - error <= s) & (s <= high + error)


# --- a place from sample to sample ------------------------------------------------------------------------------------


def _ways(couple: Couple, poses: np.ndarray) -> np.ndarray:
    """How far (m) a point of the plate moves, as seen from the boundary, from sample to sample: the longer way of those
    before and after each."""
    x, y, theta = _relative(couple, poses)
    way = np.hypot(np.diff(x), np.diff(y)) + couple.plate.reach * np.abs(np.diff(theta))
    return np.maximum(np.append(0.0, way), np.append(way, 0.0))


def _followed(couple: Couple, near: Places, ways: np.ndarray, clear: Clear) -> list[Places]:
    """The places of a couple that are closed at some time, over all samples, NaN where they are not near."""
    contacts, rows = list[np.ndarray](), len(near.sample)
    # The first turn has a contact from where it first closes on, the second one before that, while it is near.
    for order, begins in ((range(rows), near.gap <= clear(near.xi1)), (range(rows)[::-1], np.zeros(rows, dtype=bool))):
        _follow(couple, contacts, order, near, begins, ways)
    return [_of_rows(couple, near, rows) for rows in contacts]


def _follow(
    couple: Couple, contacts: list[np.ndarray], order: Iterable[int], near: Places, begins: np.ndarray, ways: np.ndarray
) -> None:
    """Add each row of `near` in an order to the nearest of the `contacts` (rows by sample, -1: none) that has none in
    its sample, or to a new one if it `begins` one."""
    points, reaches = couple.track.point(near.xi1).T.tolist(), (STEP * size_of(couple) + ways).tolist()
    last = [points[int(rows[rows >= 0][0])] for rows in contacts]
    for i in order:
        at, here = int(near.sample[i]), points[i]
        number = next((k for k, rows in enumerate(contacts) if rows[at] == i), None)
        if number is None:
            free = [k for k, rows in enumerate(contacts) if rows[at] < 0 and dist(last[k], here) <= reaches[at]]
            number = min(free, key=lambda k: dist(last[k], here), default=None)
        if number is None and begins[i]:
            number = len(contacts)
            contacts.append(np.full(len(ways), -1))
            last.append(here)
        if number is not None:
            contacts[number][at], last[number] = i, here


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
        places, tangent = origin + rotate(places, turn), rotate(tangent, turn)
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


def rotate(vectors: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Vectors (2, n) turned by angles (n,), rad."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * vectors[0] - s * vectors[1], s * vectors[0] + c * vectors[1]])


def velocity_at(rates: np.ndarray, arm: np.ndarray) -> np.ndarray:
    """The velocity (2, n) of a plate's point at `arm` (2, n) from its origin, of rates (n, 3)."""
    vx, vy, omega = rates.T
    return np.array([vx - omega * arm[1], vy + omega * arm[0]])
