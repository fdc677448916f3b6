"""The output of the second formulation at requested times, recorded piece by piece."""

from __future__ import annotations

from math import pi

import numpy as np

from cases import Case
from cases.contact import belt_speed, pose
from cases.scene.piece_case import PieceCase


def bodies_in_contact(case: Case, times: np.ndarray, z: np.ndarray, turns: int) -> np.ndarray:
    """(x, y, θ, vx, vy, ω) of a plate in contact states (ξ₁, ξ₂, ω, v), shape (4, n), at times (n,); `turns` whole
    turns are added to the angle given by (6)."""
    xi1, xi2, w, v = z
    v = v + belt_speed(case, times)
    x, y, theta = pose(case, xi1, xi2)
    tangent, contact = case.track.tangent(xi1), case.track.point(xi1)
    vx = v * tangent[0] + w * (contact[1] - y)
    vy = v * tangent[1] - w * (contact[0] - x)
    return np.array([x, y, theta + 2 * pi * turns, vx, vy, w])


class Record:
    """States (4, n): ξ₁, ξ₂, ω, v, and motions (7, n): x, y, θ, vx, vy, ω, v, at n times; NaN where undefined."""

    def __init__(self, case: Case, times: np.ndarray):
        self.case, self.times = case, times
        self.states, self.motions = np.full((4, len(times)), np.nan), np.full((7, len(times)), np.nan)

    def __bool__(self) -> bool:
        return bool(len(self.times))

    def asks_between(self, start: float, end: float) -> bool:
        return bool(np.any((self.times > start) & (self.times < end)))

    def finite_until(self, end: float) -> bool:
        """Whether poses and velocities of all times up to `end` are numbers."""
        return bool(np.isfinite(self.motions[:6, self.times <= end]).all())

    def contact(self, start: float, end: float, z_at, turns: int, pieces: PieceCase | None = None) -> None:
        """Record contact from `start` to `end`; `z_at` maps an array of times to (ξ₁, ξ₂, ω, v), the parameters of
        `pieces` if they are given."""
        inside = (self.times >= start) & (self.times <= end)
        if not inside.any():
            return
        z = z_at(self.times[inside])
        if pieces:
            z = np.array([*pieces.to_whole(z[0], z[1]), z[2], z[3]])
        self.states[:, inside] = z
        self.motions[:, inside] = [*bodies_in_contact(self.case, self.times[inside], z, turns), z[3]]

    def flight(self, start: float, end: float, body_at) -> None:
        """Record flight from `start` to `end`; `body_at` maps an array of times to (x, y, θ, vx, vy, ω)."""
        inside = (self.times >= start) & (self.times <= end)
        if not inside.any():
            return
        self.motions[:6, inside] = bodies = body_at(self.times[inside])
        self.motions[6, inside] = np.nan
        self.states[:, inside], self.states[2, inside] = np.nan, bodies[5]
