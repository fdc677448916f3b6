"""What of a scene is drawn, and where: numbers for pictures, films and pages. Needs no Matplotlib."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, sin
from typing import Any, NamedTuple

import numpy as np

from ..curves import Curve

# Corners of a plate as drawn: a circle's chords then leave it by a thousandth of its radius.
CORNERS = 73
# Points along a track: a picture is some 400 points wide.
_POINTS = 361


class Scene(NamedTuple):
    """What a picture needs of a case: its two curves, its name, and whether Y points down the page (gravity's way)."""

    track: Curve
    outline: Curve
    label: str
    down: bool = False

    def corners(self) -> np.ndarray:
        """Points of the outline in the plate's own frame, (2, CORNERS)."""
        return self.outline.point(np.linspace(*self.outline.span, CORNERS))


class Instant(NamedTuple):
    """A pose (m, rad), the contact parameter on the track (NaN in flight), and from 1 to 0 how dark it is drawn."""

    x: float
    y: float
    theta: float
    xi1: float
    shade: float


def placed(scene: Scene, at: Any) -> tuple[np.ndarray, np.ndarray]:
    """The outline's corners (2, n) and its spoke (2, 2) at a pose, in the fixed frame."""
    turn = np.array([[cos(at.theta), -sin(at.theta)], [sin(at.theta), cos(at.theta)]])
    centre = np.array([[at.x], [at.y]])
    corners = turn @ scene.corners() + centre
    return corners, np.hstack([centre, corners[:, :1]])


def visible(scene: Scene, path: np.ndarray, xi1: np.ndarray) -> np.ndarray:
    """Even track parameters worth drawing: all of a closed track, else what the plate visits and a little more.

    `path`: the centre's, shape (2, n), with its contact parameters (NaN in flight).
    """
    track = scene.track
    if track.period:
        return np.linspace(*track.span, _POINTS)
    flying = ~np.isfinite(xi1)
    visited = np.concatenate([xi1[~flying], _below(track, path[:, flying])])
    low, high = float(np.min(visited)), float(np.max(visited))
    size = float(np.ptp(scene.corners(), axis=1).max())
    more = 1.2 * size / float(track.speed(0.5 * (low + high)))
    domain = track.domain or (-np.inf, np.inf)
    return np.linspace(max(low - more, domain[0]), min(high + more, domain[1]), _POINTS)


def _below(track: Curve, path: np.ndarray) -> np.ndarray:
    """Roughly the track parameter that is nearest to the centre, for each sample."""
    grid = np.linspace(*track.span, 1001)
    X, Y = track.point(grid)
    return np.array([grid[np.argmin(np.hypot(X - x, Y - y))] for x, y in path.T])


def instants(times: np.ndarray, transitions: Sequence[float]) -> list[tuple[int, float]]:
    """(sample, shade from 1 to 0) of the start, the transitions and even times, not closer than a tenth apart."""
    wanted = [float(times[0]), *transitions, float(times[-1])]
    for time in np.linspace(times[0], times[-1], 7)[1:-1]:
        if all(abs(time - other) > 0.1 * (times[-1] - times[0]) for other in wanted):
            wanted.append(float(time))
    places = sorted({int(np.argmin(np.abs(times - time))) for time in wanted})
    return [(place, 1.0 - i / max(len(places) - 1, 1)) for i, place in enumerate(places)]
