"""A plate's motion for touch searches: poses at any time, and bounds on velocities and accelerations."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

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
