"""A driven track in the second formulation: the plate's motion in the track's frame, from forces in the fixed one.

By numbers at each instant: place, velocity and force of the plate are turned into the fixed frame and back, and the
acceleration of the track's frame is subtracted from the plate's. Nothing is derived symbolically here.
"""

from __future__ import annotations

from dataclasses import replace
from math import cos, isfinite, sin

import numpy as np

from cases import Case, Drive, Gravity, Load, Plate
from cases.moving_surface import TrackPlace
from cases.scene.free_plates import loads_of, plates_of

from .loads import load_scales
from .steps import StepFailure

# Effects that a driven scene replaces by a load in the track's frame.
REPLACED = (Drive, Gravity, Load)


def case_at_rest(case: Case, drive: Drive) -> Case:
    """The case on a track at rest without weight and loads, with the start as the track sees it."""
    effects = tuple(e for e in case.effects if not isinstance(e, REPLACED))
    return replace(case, effects=effects, start=replace(case.start, omega=case.start.omega - drive.at(0.0).spin))


def in_fixed_frame(place: TrackPlace, body) -> list:
    """(x, y, θ, vx, vy, ω) in the fixed frame, of numbers or arrays in the track's frame."""
    x, y, theta, vx, vy, omega = body
    c, s = np.cos(place.angle), np.sin(place.angle)
    rx, ry = c * x - s * y, s * x + c * y
    ux, uy = c * vx - s * vy - place.spin * ry, s * vx + c * vy + place.spin * rx
    return [place.x + rx, place.y + ry, theta + place.angle, place.vx + ux, place.vy + uy, omega + place.spin]


def in_track_frame(place: TrackPlace, body) -> list:
    """The same from the fixed frame to the track's."""
    x, y, theta, vx, vy, omega = body
    x, y, vx, vy, omega = place.seen_from_track(x, y, vx, vy, omega)
    return [x, y, theta - place.angle, vx, vy, omega]


class DriveLoad:
    """Force and moment on a plate of a driven case, with its load, in the track's frame."""

    def __init__(self, case: Case, drive: Drive, plate: Plate, load: Load | None):
        self.plate, self.drive = plate, drive
        gravity = case.effect(Gravity)
        self.weight = [plate.mass * part for part in gravity.vector] if gravity else [0.0, 0.0]
        self.load = load.at if load else None
        self.features = [feature for feature in (drive.features, load.features if load else None) if feature]
        self._scales = load_scales(load)

    def at(self, t: float, *body: float) -> list[float]:
        """(F_x, F_y, M) in N and N m at (x, y, θ, vx, vy, ω) in the track's frame."""
        place, m, J = self._place(t), self.plate.mass, self.plate.inertia
        fx, fy = self.weight
        moment = 0.0
        if self.load:
            lx, ly, moment = self.load(t, *map(float, in_fixed_frame(place, body)))
            fx, fy = fx + lx, fy + ly
        x, y, _, vx, vy, _ = body
        c, s = cos(place.angle), sin(place.angle)
        # The acceleration of the frame's point below the plate, and Coriolis's, in the axes of the frame.
        ax = c * place.ax + s * place.ay - place.swing * y - place.spin**2 * x - 2.0 * place.spin * vy
        ay = c * place.ay - s * place.ax + place.swing * x - place.spin**2 * y + 2.0 * place.spin * vx
        turning = J * place.swing if place.swing else 0.0  # the inertia may be infinite
        return [c * fx + s * fy - m * ax, c * fy - s * fx - m * ay, moment - turning]

    def _place(self, t: float) -> TrackPlace:
        place = self.drive.at(t)
        if not all(map(isfinite, place)):
            raise StepFailure(f"the drive has no value at t = {t:.9g} s; end the case before")
        return place

    @property
    def scales(self) -> DriveLoad | None:
        """What bounds the steps: this, if the case has a load that depends on place or velocity."""
        return self if self._scales else None

    def allows(self, times: np.ndarray, *bodies: np.ndarray) -> bool:
        """Whether the load allows a step through these states in the track's frame."""
        assert self._scales is not None
        return self._scales.allows(times, *in_fixed_frame(self.drive.at_times(times), bodies))


def loads_of_drive(case: Case) -> tuple[DriveLoad, ...]:
    """The loads of all plates of a driven case; none for a track at rest."""
    drive = case.effect(Drive)
    if drive is None:
        return ()
    return tuple(DriveLoad(case, drive, *one) for one in zip(plates_of(case), loads_of(case), strict=True))
