"""The contact geometry of a case, by which all solvers are judged: contact points and slip velocity.

Independent of solvers. `cases.contact.geometry` has the mathematics, and documents results and exceptions.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from ..effects import Belt, Drive
from ..errors import BadValue
from ..moving_surface import TrackPlace
from . import geometry, piece_contact
from .geometry import Contact, MotionPoint
from .overlap_search import first_overlap

if TYPE_CHECKING:
    from ..scene.case_class import Case

__all__ = [
    "Contact",
    "MotionPoint",
    "belt_speed",
    "clearance",
    "find",
    "finder",
    "follow",
    "in_track_frame",
    "overlap",
    "pose",
    "slip_velocity",
    "start_motion",
    "track_place",
    "velocity",
]


@lru_cache(maxsize=1024)
def start_motion(case: Case) -> MotionPoint:
    """The case's start as pose, velocities and contact rates."""
    belt, drive, start = case.effect(Belt), case.effect(Drive), case.start
    if drive is not None:
        return _on_moving_track(case, drive)
    if belt is None:
        return start.motion(case.track, case.plate.outline)
    moving = replace(start, slip=start.slip + belt.at(0.0)[0])
    return moving.motion(case.track, case.plate.outline)._replace(slip=start.slip)


def _on_moving_track(case: Case, drive: Drive) -> MotionPoint:
    """The start in the fixed frame: that in the track's frame, carried along by the track."""
    place, start = drive.at(0.0), case.start
    still = replace(start, omega=start.omega - place.spin, slip=start.slip + belt_speed(case, 0.0))
    own = still.motion(case.track, case.plate.outline)
    x, y, vx, vy, _ = map(float, place.seen_from_outside(own.x, own.y, own.vx, own.vy, 0.0))
    theta = own.theta + place.angle
    return own._replace(x=x, y=y, theta=theta, vx=vx, vy=vy, omega=start.omega, slip=start.slip)


def track_place(case: Case, t) -> TrackPlace:
    """Place, angle and rates of the track's frame at a time or an array of times; all 0 without Drive."""
    drive = case.effect(Drive)
    if drive is None:
        return TrackPlace(*[0.0] * 9)
    return drive.at(t) if np.ndim(t) == 0 else drive.at_times(t)


def belt_speed(case: Case, t):
    """The speed of the track's surface along the track, m/s, at a time or an array of times; 0 without Belt."""
    belt = case.effect(Belt)
    if belt is None:
        return 0.0
    return belt.at(t)[0] if np.ndim(t) == 0 else belt.at_arrays(np.asarray(t, dtype=float))


def pose(case: Case, xi1, xi2):
    """(x, y, theta) of the plate that touches at (xi1, xi2): (6) gives θ, (5) gives R₀. Numbers or arrays."""
    return geometry.pose(case.track, case.plate.outline, xi1, xi2)


def velocity(case: Case, xi1: float, xi2: float, slip: float, omega: float) -> MotionPoint:
    """The plate's motion in contact if its point there has the velocity `slip` (m/s, along the track's tangent, not
    relative to a belt) and the plate the spin `omega`."""
    return geometry.velocity(case.track, case.plate.outline, xi1, xi2, slip, omega)


def find(case: Case, x: float, y: float, theta: float, near: tuple[float, float]) -> Contact:
    """The pair of points where outline and track come closest, starting from the pair `near`."""
    return piece_contact.find(case.track, case.plate.outline, x, y, theta, near)


def finder(case: Case) -> Callable[[float, float, float, tuple[float, float]], Contact]:
    """`find` for a case, for many poses: a function of x, y, theta and near."""
    return piece_contact.finder(case.track, case.plate.outline)


def follow(case: Case, x, y, theta) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(xi1, xi2, gap) along a sequence of poses that begins at the case's start, each from the previous one.

    Raises DoesNotFit where the plate loses its track; all arrays have the length of the poses.
    """
    start = start_motion(case)
    near, rows = (start.xi1, start.xi2), []
    for x_now, y_now, theta_now in zip(x, y, theta, strict=True):
        contact = find(case, float(x_now), float(y_now), float(theta_now), near)
        near = (contact.xi1, contact.xi2)
        rows.append(contact)
    xi1, xi2, gap = np.array(rows, dtype=float).reshape(-1, 3).T
    return xi1, xi2, gap


def slip_velocity(case: Case, x, y, vx, vy, omega, xi1, t=None):
    """(11) along the track's unit tangent at `xi1`: velocity of the plate's material point there, relative to the
    track's surface. Numbers or arrays.

    `t`: the times (s), for a case with Belt or Drive. Raises BadValue if they are missing there.
    """
    if t is None and (case.effect(Belt) is not None or case.effect(Drive) is not None):
        raise BadValue("the track or its surface moves; give the times t to slip_velocity")
    if case.effect(Drive) is not None:
        x, y, vx, vy, omega = track_place(case, t).seen_from_track(x, y, vx, vy, omega)
    slip = geometry.slip_velocity(case.track, x, y, vx, vy, omega, xi1)
    return slip if t is None else slip - belt_speed(case, t)


def in_track_frame(case: Case, t, x, y, theta):
    """Poses (x, y, theta) at the times t as a driven track sees them; those of a track at rest are returned as is."""
    if case.effect(Drive) is None:
        return x, y, theta
    place = track_place(case, t)
    seen_x, seen_y, *_ = place.seen_from_track(x, y, 0.0, 0.0, 0.0)
    return seen_x, seen_y, theta - place.angle


def clearance(case: Case, xi1, xi2):
    """Outline's curvature minus track's, 1/m: positive where the plate fits (admissible contact)."""
    return geometry.clearance(case.track, case.plate.outline, xi1, xi2)


def overlap(case: Case, x: float, y: float, theta: float) -> float | None:
    """A track parameter that lies inside the plate in that pose, or None. A track without ends is searched near the
    start."""
    pose = (np.array([value]) for value in (x, y, theta, case.start.xi1))
    overlapping = first_overlap(case.track, case.plate.outline, *pose)
    return overlapping[1] if overlapping else None
