"""Driven tracks (`cases.Drive`) for engines: the track's places in steps, and motions seen from the track.

An engine whose bodies can be moved by prescription carries the track's shapes on such a body. Its poses are then read
in the frame of the track, where the case is `cases.moving_frame.relative_case`. Independent of any engine.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cases import BadValue, Case, Drive, Trajectory
from cases.contact import track_place
from cases.motion.trajectory import State
from cases.moving_frame import in_fixed_frame, relative_case

Place = tuple[float, float, float]


def refuses(case: Case) -> str | None:
    """Why a case with a driven track cannot be read in the frame of its track, or None."""
    try:
        relative_case(case)
    except BadValue as problem:
        return f"{problem}."
    return None


def to_fixed_frame(case: Case, motion: Trajectory) -> Trajectory:
    """A motion of `relative_case(case)` in the fixed frame, with its samples; of a case without Drive, itself."""
    if case.effect(Drive) is None:
        return motion
    fixed = in_fixed_frame(case, motion)
    columns: dict[str, Any] = {name: np.asarray(getattr(fixed, name)) for name in State._fields}
    return replace(motion, **columns, plate_columns=fixed.plate_columns)


def by_track(case: Case, motion: Trajectory, complete: Callable[[Case, Trajectory], Trajectory]) -> Trajectory:
    """`complete(case, motion)`; on a driven track in its frame, so that the contacts and slips are relative to it."""
    if case.effect(Drive) is None:
        return complete(case, motion)
    place = track_place(case, motion.t)
    x, y, vx, vy, omega = place.seen_from_track(motion.x, motion.y, motion.vx, motion.vy, motion.omega)
    seen = replace(motion, x=x, y=y, theta=motion.theta - place.angle, vx=vx, vy=vy, omega=omega)
    return to_fixed_frame(case, complete(relative_case(case), seen))


@dataclass(frozen=True)
class PrescribedSteps:
    """The prescribed motion of a track's body in steps of h (s): constant velocities from one place to the next."""

    drive: Drive
    h: float

    def place(self, step: int) -> Place:
        """Place (m) and angle (rad) at the beginning of a step."""
        return self.drive.at(step * self.h)[:3]

    def velocities(self, step: int) -> Place:
        """The velocities (m/s, rad/s) that move it to its place at the next step."""
        here, there = self.place(step), self.place(step + 1)
        vx, vy, spin = ((b - a) / self.h for a, b in zip(here, there, strict=True))
        return vx, vy, spin

    @property
    def start(self) -> tuple[Place, Place]:
        """Place and velocities at t = 0."""
        at = self.drive.at(0.0)
        return (at.x, at.y, at.angle), (at.vx, at.vy, at.spin)


def rows_from_track(case: Case, rows: np.ndarray, poses_at: np.ndarray, velocities_at: np.ndarray) -> np.ndarray:
    """Rows (x, y, theta, vx, vy, omega) as the track sees them, shape (n, 6), or (n, plates, 6) of several plates.

    Poses and velocities may be of different times (s), as an engine's are. The velocity of a frame that turns needs the
    place too, which is that of the pose, moved by the velocity until the velocity's time.
    """
    if rows.ndim == 3:
        each = [rows_from_track(case, own, poses_at, velocities_at) for own in rows.transpose(1, 0, 2)]
        return np.array(each).transpose(1, 0, 2)
    x, y, theta, vx, vy, omega = rows.T
    at = track_place(case, poses_at)
    c, s, dx, dy = np.cos(at.angle), np.sin(at.angle), x - at.x, y - at.y
    pose = c * dx + s * dy, c * dy - s * dx, theta - at.angle
    later = velocities_at - poses_at
    at = track_place(case, velocities_at)
    c, s, dx, dy = np.cos(at.angle), np.sin(at.angle), x + later * vx - at.x, y + later * vy - at.y
    ux, uy = vx - at.vx + at.spin * dy, vy - at.vy - at.spin * dx
    return np.column_stack([*pose, c * ux + s * uy, c * uy - s * ux, omega - at.spin])


def in_track_axes(case: Case, times: np.ndarray, torsor: np.ndarray) -> np.ndarray:
    """Forces (N) and moments (N m) at some times (s) along the axes of the driven track, shape (n, 3) or
    (n, plates, 3)."""
    if torsor.ndim == 3:
        return np.stack([in_track_axes(case, times, own) for own in torsor.transpose(1, 0, 2)], axis=1)
    (fx, fy, moment), angle = torsor.T, track_place(case, times).angle
    c, s = np.cos(angle), np.sin(angle)
    return np.column_stack([c * fx + s * fy, c * fy - s * fx, moment])
