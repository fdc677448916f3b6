"""A plate's motion for touch searches: poses at any time, and bounds on velocities and accelerations."""

from __future__ import annotations

from collections.abc import Callable
from math import pi
from typing import NamedTuple

import numpy as np

from cases import Case
from cases.contact import belt_speed, pose

# Bounds are computed from velocities at this many nodes of each smooth piece, times a margin.
NODES, MARGIN = 9, 1.25
# Time differences below this many roundings are ignored.
ROUNDINGS = 64 * 2.0**-52


class Motion(NamedTuple):
    """`bodies` maps times (n,) to (x, y, θ, vx, vy, ω), shape (6, n); it is smooth between the times `edges`."""

    bodies: Callable[[np.ndarray], np.ndarray]
    edges: np.ndarray


class Limits(NamedTuple):
    """Bounds over a time span: speed (m/s), acceleration (m/s²), spin (rad/s), its rate (rad/s²)."""

    speed: float
    pull: float
    spin: float
    swing: float


def limits(motion: Motion, start: float, end: float) -> Limits:
    """Bounds on a motion between two times."""
    inner = motion.edges[(motion.edges > start) & (motion.edges < end)]
    edges = np.concatenate([[start], inner, [end]])
    parts = 0.5 - 0.5 * np.cos(np.pi * np.arange(NODES) / (NODES - 1))
    times = edges[:-1, None] + np.diff(edges)[:, None] * parts
    _, _, _, vx, vy, spin = motion.bodies(times.ravel()).reshape(6, *times.shape)
    between = np.diff(times, axis=1)
    per = 1.0 / np.where(between > ROUNDINGS * max(abs(start), abs(end)), between, np.inf)
    pull = MARGIN * float((np.hypot(np.diff(vx, axis=1), np.diff(vy, axis=1)) * per).max())
    swing = MARGIN * float((np.abs(np.diff(spin, axis=1)) * per).max())
    # Between two nodes a velocity exceeds both values by at most its greatest rate times half of the interval.
    rest = 0.5 * float(between.max())
    return Limits(
        float(np.hypot(vx, vy).max()) + pull * rest, pull, float(np.abs(spin).max()) + swing * rest, swing
    )  # fmt: skip


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
