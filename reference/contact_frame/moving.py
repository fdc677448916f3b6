"""A plate's motion as a search sees it: poses at any time, and bounds on its velocities and accelerations."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

# Bounds come from velocities at so many places of each smooth piece, and a margin.
NODES, MARGIN = 9, 1.25
# Differences of times shorter than so many of their roundings say nothing.
ROUNDINGS = 64 * 2.0**-52


class Motion(NamedTuple):
    """`bodies` maps times (n,) to (x, y, θ, vx, vy, ω), shape (6, n); it is smooth between the times `edges`."""

    bodies: Callable[[np.ndarray], np.ndarray]
    edges: np.ndarray


class Limits(NamedTuple):
    """Bounds until a time: speed (m/s), acceleration (m/s²), spin (rad/s), its rate (rad/s²)."""

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
    # Between two places a velocity goes beyond both by no more than its greatest rate times half of their distance.
    rest = 0.5 * float(between.max())
    return Limits(
        float(np.hypot(vx, vy).max()) + pull * rest, pull, float(np.abs(spin).max()) + swing * rest, swing
    )  # fmt: skip
