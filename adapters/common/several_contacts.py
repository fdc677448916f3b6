"""Contacts of a plate that touches its track in several places, from the poses of a motion alone.

Engines report a pose and velocities at each step; which places of the track the plate touches follows from the case's
geometry. A contact is a place where the distance between track and plate is smallest. It is closed while the gap
is below what the engine's step and facets leave. Lengths in metres.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cases import Case, Chain, Flight, Trajectory
from cases.contact import pose, slip_velocity
from cases.contact.nearest import contacts
from cases.curves.corner import Corner
from cases.motion.trajectory import CONTACT
from cases.scene.contact_limits import touches_by_features
from cases.scene.contact_pairs import pairs
from cases.scene.supports import is_hill

from . import feature_contacts
from .closed_samples import by_gap
from .facets import round_plate, visible_span
from .feature_contacts import feet, of_pair, poses_and_rates
from .pose_contact import PoseContact, cone_slope, with_columns

# Samples of the track within the disc's radius: two places that are closer than two of them are one.
_PER_RADIUS = 40
# Most samples of a track, and most distances that are computed at once (80 MB).
_MOST_SAMPLES, _MOST_DISTANCES = 20_000, 10_000_000
# Places that are farther from the disc than this part of its radius do not matter.
_NEAR = 0.2
# Steps of Newton's method for a parameter: each squares the error.
_NEWTON = 6


@dataclass(frozen=True)
class _Place:
    """A place of the track over the samples, arrays (n,): both parameters, and the gap; NaN where it is not near."""

    xi1: np.ndarray
    xi2: np.ndarray
    gap: np.ndarray


def refuses(case: Case) -> str | None:
    """Why the several contacts of a case, on supports or on its track, do not follow from its poses, or None."""
    return feature_contacts.refuses(case, True) if touches_by_features(case) else supports(case)


def supports(case: Case) -> str | None:
    """Why the contacts of such a case cannot be distinguished here, in one sentence, or None."""
    if round_plate(case) is None and not _has_corners(case):
        return "Several contacts are computed for round plates only, and for curves with corners."
    return None


def _has_corners(case: Case) -> bool:
    return isinstance(case.track, Chain) or isinstance(case.plate.outline, Chain)


def may_touch_twice(case: Case) -> bool:
    """Whether a plate may touch the track in two places at once, as far as this module supports it.

    Between two places that a disc touches the track bends more than the disc: its arc has the same ends and tangents as
    the disc's and is outside of it, so its curvature is at least 1/r somewhere, or it has a hollow corner.
    """
    circle, track = round_plate(case), case.track
    if _has_corners(case) and (case.effect(Flight) is None or is_hill(track)):
        return False
    if circle is None:
        return _has_corners(case)
    if any(isinstance(one.piece, Corner) and one.piece.turn > 0.0 for one in track.elements):
        return True
    bend = track.curvature(np.linspace(*visible_span(case), 2001))
    return bool(np.max(bend) * circle.radius >= 1.0)


def with_contacts(
    case: Case, motion: Trajectory, clear: Callable[[np.ndarray], np.ndarray], rounding: float | None = None
) -> Trajectory:
    """The motion with the columns of each contact, if its plate touches the track in more than one place; else the
    motion as it is.

    `clear`: of contact parameters (n,), the gaps (m) below which such contacts are closed; with `rounding` (m) one that
    opens slowly is open as soon as its gap grows beyond that. The trajectory's own slip,
    forces and parameters are then those of the first closed contact. With one closed contact its forces are the
    motion's, with more they are unknown (NaN): the momentum gives only their sum. Where none is closed the plate flies.
    """
    if supports(case) is not None:
        return motion
    places = _places(case, motion, clear)
    if len(places) < 2:
        return motion
    every = [_contact(case, motion, *each) for each in places.items()]
    closed = [place.gap <= clear(place.xi1) for place in places.values()]
    if rounding is not None:
        closed = [by_gap(one.gap, shut, rounding) for one, shut in zip(every, closed, strict=True)]
    alone = np.where(np.sum(closed, axis=0) == 1, 1.0, np.nan)
    force = alone * _force(case, motion)
    forces = [np.array([np.sum(force * axis, axis=0) for axis in (one.normal, one.tangent)]) for one in every]
    return with_columns(motion, every, closed, forces)


def _force(case: Case, motion: Trajectory) -> np.ndarray:
    """The force of the track on the plate, shape (2, n), N: from the motion's columns, those of its own contact."""
    xi1 = np.nan_to_num(motion.xi1, nan=case.start.xi1)
    return motion.normal_force * case.track.normal(xi1) + motion.friction_force * case.track.tangent(xi1)


def _contact(case: Case, motion: Trajectory, name: str, place: _Place) -> PoseContact:
    near = np.isfinite(place.gap)
    xi1 = np.where(near, place.xi1, case.start.xi1)
    slip = slip_velocity(case, motion.x, motion.y, motion.vx, motion.vy, motion.omega, xi1, motion.t)
    arm = case.track.point(xi1) - np.array([motion.x, motion.y])
    return PoseContact(
        name, 0, None, cone_slope(case.effect), place.gap, slip, case.track.tangent(xi1), case.track.normal(xi1),
        np.where(near, xi1, np.nan), np.where(near, place.xi2, np.nan),
        arm, np.zeros_like(arm),
    )  # fmt: skip


def _outline_parameter(case: Case, xi1: np.ndarray, theta: np.ndarray) -> np.ndarray:
    """The outline's parameter by (6) for a plate that touches at `xi1` with the angle `theta`: the angle falls by 2 π
    over the outline's period."""
    slope = -2.0 * np.pi / float(case.plate.outline.period or 2.0 * np.pi)
    xi2 = np.zeros(len(xi1))
    for _ in range(_NEWTON):
        xi2 = xi2 + (theta - np.asarray(pose(case, xi1, xi2)[2])) / slope
    return xi2


# --- places of the track ----------------------------------------------------------------------------------------------


def _places(case: Case, motion: Trajectory, clear: Callable[[np.ndarray], np.ndarray]) -> dict[str, _Place]:
    """The places that the plate touches at some time, named in the order in which it first does."""
    sample, *values = (_of_corners if _has_corners(case) else _of_disc)(case, motion)
    xi1, _, gap = values
    is_closed = gap <= clear(xi1)
    # Within half the radius a place is the same as in the sample before. A chain's parameter is its length, but at a
    # corner, where the speed is 0.
    reach = 0.5 * case.plate.inner / (float(case.track.speed(case.start.xi1)) or 1.0)
    places = list[_Place]()
    forward = np.lexsort((np.abs(gap), sample)).tolist()
    _follow(places, forward, sample, values, reach, lambda i: bool(is_closed[i]), len(motion.t))
    # A place is known from where it is first touched on; the second call finds it before that, while it is near.
    _follow(places, forward[::-1], sample, values, reach, lambda i: False, len(motion.t))
    names = [CONTACT, *(f"{CONTACT} {number}" for number in range(2, len(places) + 1))]
    return dict(zip(names, places, strict=False))


def _follow(
    places: list[_Place], order: list[int], sample: np.ndarray, values: list[np.ndarray], reach: float,
    is_new: Callable[[int], bool], count: int,
) -> None:  # fmt: skip
    """Write each of the places `order` into the nearest one of `places` that has none in its sample, or a new one."""
    last = [float(place.xi1[np.isfinite(place.xi1)][0]) for place in places]
    for i in order:
        at, (here, there, gap) = int(sample[i]), (float(column[i]) for column in values)
        free = [k for k, place in enumerate(places) if not np.isfinite(place.xi1[at])]
        nearest = min(free, key=lambda k: abs(last[k] - here), default=None)
        own = next((k for k, place in enumerate(places) if place.xi1[at] == here), None)
        if own is not None:
            last[own] = here
            continue
        if nearest is None or abs(last[nearest] - here) > reach:
            if not is_new(i):
                continue
            nearest = len(places)
            places.append(_Place(*np.full((3, count), np.nan)))
            last.append(here)
        place = places[nearest]
        place.xi1[at], place.xi2[at], place.gap[at] = here, there, gap
        last[nearest] = here


def _of_corners(case: Case, motion: Trajectory) -> list[np.ndarray]:
    """All places near a plate with corners, or on a track with corners: the sample that they belong to, both parameters
    and the gap, arrays (m,). A corner at the end of a side that lies flat is one, however the side is tilted."""
    poses, rates = poses_and_rates(motion)
    rows = [
        (sample, *contact)
        for sample, pose in enumerate(poses[:, 0].tolist())
        for contact in contacts(case.track, case.plate.outline, *pose)
    ]
    corners = [pair for pair in pairs(case) if isinstance(pair.plate.outline, Corner)]
    every = [np.reshape(rows, (-1, 4)).T]
    for one in (of_pair(pair, motion.t, poses, rates, 0.0) for pair in corners):
        every.append(np.array([np.arange(len(motion.t)), one.xi1, one.xi2, one.gap]))
    table = np.hstack(every)
    table = table[:, np.abs(table[3]) <= _NEAR * case.plate.inner]
    table = table[:, np.lexsort((np.abs(table[3]), table[0]))]
    # Two elements that meet at a seam have one place there.
    places, kept = case.track.point(table[1]).T, dict[float, list[np.ndarray]]()
    alone = np.zeros(len(places), dtype=bool)
    for number, (sample, place) in enumerate(zip(table[0].tolist(), places, strict=True)):
        others = kept.setdefault(sample, [])
        alone[number] = all(np.hypot(*(place - other)) > 2.0 * case.plate.inner / _PER_RADIUS for other in others)
        if alone[number]:
            others.append(place)
    sample, *values = table[:, alone]
    return [sample.astype(int), *values]


def _of_disc(case: Case, motion: Trajectory) -> list[np.ndarray]:
    """The same of a disc on a smooth track."""
    circle = round_plate(case)
    assert circle is not None, "checked by supports()"
    c, s = np.cos(motion.theta), np.sin(motion.theta)
    own_x, own_y = float(circle.centre[0]), float(circle.centre[1])
    centre = np.array([motion.x + c * own_x - s * own_y, motion.y + s * own_x + c * own_y])
    low, high = visible_span(case)
    length = float(np.mean(case.track.speed(np.linspace(low, high, 721)))) * (high - low)
    count = int(min(max(_PER_RADIUS * length / circle.radius, 721), _MOST_SAMPLES))
    grid = case.track.even(low, high, count)
    points, width = case.track.point(grid), np.max(np.diff(grid))
    samples, starts = list[np.ndarray](), list[np.ndarray]()
    block = max(_MOST_DISTANCES // count, 1)
    for begin in range(0, len(motion.t), block):
        part = centre[:, begin : begin + block]
        square = (points[0] - part[0][:, None]) ** 2 + (points[1] - part[1][:, None]) ** 2
        inner = square[:, 1:-1]
        lowest = (inner < square[:, :-2]) & (inner <= square[:, 2:]) & (inner <= ((1.0 + _NEAR) * circle.radius) ** 2)
        row, column = np.nonzero(lowest)
        samples.append(begin + row)
        starts.append(grid[column + 1])
    sample, start = np.concatenate(samples), np.concatenate(starts)
    there = centre[:, sample]
    xi1 = feet(case.track, there, start, width)
    gap = np.sum((there - case.track.point(xi1)) * case.track.normal(xi1), axis=0) - circle.radius
    return [sample, xi1, _outline_parameter(case, xi1, motion.theta[sample]), gap]
