"""The geometry of many contacts at once: curves of one structure, with different sizes in each scenario.

The formulas are those of `cases.contact.geometry`, which has them for one pair of curves; here all arrays have shape
(n,).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cases import Curve


class CurvePoints(NamedTuple):
    """Points of curves with speed |R_p|, unit tangent and curvature there."""

    x: np.ndarray
    y: np.ndarray
    speed: np.ndarray
    tx: np.ndarray
    ty: np.ndarray
    curvature: np.ndarray


def places(curve: Curve, constants: tuple[np.ndarray, ...], s: np.ndarray) -> CurvePoints:
    """The points of curves of one structure at parameters `s`; `constants` are their sizes, each of shape (n,)."""
    x, y, xp, yp, xs, ys = (np.broadcast_to(row, s.shape) for row in curve.jets_of(s, constants)[:6])
    speed = np.hypot(xp, yp)
    return CurvePoints(x, y, speed, xp / speed, yp / speed, (xp * ys - yp * xs) / speed**3)


def rates(track: CurvePoints, outline: CurvePoints, slip, omega) -> tuple[np.ndarray, np.ndarray]:
    """(ξ̇₁, ξ̇₂) of contacts with that slip velocity and spin: (9) and (12) solved for them."""
    along = (omega - outline.curvature * slip) / (track.curvature - outline.curvature)
    return along / track.speed, (along - slip) / outline.speed


def slip_and_spin(track: CurvePoints, outline: CurvePoints, u1, u2) -> tuple[np.ndarray, np.ndarray]:
    """Slip velocity (12) and spin (9)."""
    track_speed, outline_speed = u1 * track.speed, u2 * outline.speed
    return track_speed - outline_speed, track.curvature * track_speed - outline.curvature * outline_speed


def energy(track: CurvePoints, outline: CurvePoints, slip, omega, pull: tuple, mass, inertia) -> np.ndarray:
    """Kinetic energy and potential of gravity `pull` (m/s², by component), J, as `cases.motion.mechanics.energy` counts
    it."""
    # The tangents agree (6), so that their angle is the plate's; the centre lies off the contact by (5).
    c, s = track.tx * outline.tx + track.ty * outline.ty, track.ty * outline.tx - track.tx * outline.ty
    rx, ry = c * outline.x - s * outline.y, s * outline.x + c * outline.y
    vx, vy = slip * track.tx + omega * ry, slip * track.ty - omega * rx
    kinetic = 0.5 * mass * (vx**2 + vy**2) + 0.5 * inertia * omega**2
    return kinetic - mass * (pull[0] * (track.x - rx) + pull[1] * (track.y - ry))


def level_parameters(track: Curve, outline: Curve, xi1: np.ndarray) -> np.ndarray:
    """The outline's parameters at which θ = 0 for contacts at `xi1`, NaN where there is none or more than one.

    `cases.contact.geometry.level_parameter` for many places of one track: Newton's method from a table.
    """
    low, high = outline.span
    grid = np.linspace(low, high, 721)
    angles = outline.tangent_angle(grid)
    goal = track.tangent_angle(xi1)
    if not outline.period or np.any(np.diff(angles) <= 0.0):
        return np.full(xi1.shape, np.nan)
    whole = np.floor((goal - angles[0]) / (2 * np.pi))  # turns beyond the table, counted again at the end
    goal = goal - 2 * np.pi * whole
    s = np.interp(goal, angles, grid)
    for _ in range(4):  # from a 720th of a turn: 1e-3, 1e-6, 1e-12, rounding
        here = places(outline, tuple(np.full(s.shape, c) for c in outline.constants), s)
        s = s - (outline.tangent_angle(s) - goal) / (here.curvature * here.speed)
    return s + whole * outline.period
