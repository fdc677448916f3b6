"""Geometry of pictures, films and pages: points of the track and the plate. Needs no Matplotlib."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import cos, pi, sin
from typing import Any, NamedTuple

import numpy as np

from ..curves import Curve
from ..curves.chain import Chain
from ..curves.line_or_circle import as_line

# Corners of the polygon that shows a plate: the chords of a circle then deviate from it by 1/1,000 of its radius.
CORNERS = 73
# Points along a track: a picture is about 400 points wide.
_POINTS = 361
# Poses of a path for which the nearest points of a support are looked for: neighbours see the same part of it.
_PLACES = 100


class DrawnScene(NamedTuple):
    """The data of a case for a picture: track and outline, a label, whether Y (the direction of gravity) points down,
    the curves of its supports by their names, and of a block its width and height (m)."""

    track: Curve
    outline: Curve
    label: str
    down: bool = False
    supports: Mapping[str, Curve] = {}
    block: tuple[float, float] | None = None

    def of(self, plate: Any) -> DrawnScene:
        """The same scene for another plate."""
        return self._replace(outline=plate.outline, block=plate.drawn)

    def corners(self) -> np.ndarray:
        """Points of the outline in the plate's own frame, (2, n): CORNERS of a smooth one, the corners of others."""
        if self.block:
            return 0.5 * np.array([[-1, 1, 1, -1, -1], [-1, -1, 1, 1, -1]]) * np.array([self.block]).T
        return self.outline.point(_vertices(self.outline, np.linspace(*self.outline.span, CORNERS)))


class Instant(NamedTuple):
    """A pose (m, rad), the contact parameter on the track (NaN in flight), and the shade from 1 (dark) to 0 (light)."""

    x: float
    y: float
    theta: float
    xi1: float
    shade: float


def _vertices(curve: Curve, even: np.ndarray) -> np.ndarray:
    """The parameters at which a curve is drawn: `even` ones, of a chain its corners and as many on its bent pieces."""
    if not isinstance(curve, Chain):
        return even
    return curve.vertices(2 * pi / CORNERS)


def place_outline(scene: DrawnScene, at: Any) -> tuple[np.ndarray, np.ndarray]:
    """The outline's corners (2, n) and its spoke (2, 2) at a pose, in the fixed frame."""
    theta = drawn_angle(scene, at)
    turn = np.array([[cos(theta), -sin(theta)], [sin(theta), cos(theta)]])
    centre = np.array([[at.x], [at.y]])
    corners = turn @ scene.corners() + centre
    return corners, np.hstack([centre, centre if scene.block else corners[:, :1]])


def drawn_angle(scene: DrawnScene, at: Any) -> float:
    """The angle (rad) at which a plate is drawn in a pose: its own, but that of the track below a block."""
    if not scene.block:
        return float(at.theta)
    xi1 = at.xi1 if np.isfinite(at.xi1) else _below(scene.track, np.array([[at.x], [at.y]]))[0]
    return float(scene.track.tangent_angle(xi1))


def free_plates(case: Any, motion: Any, times: Any, shades: Sequence[float]) -> list[tuple[DrawnScene, list[Instant]]]:
    """The free plates of a case with their poses in a motion at some times, for `drawn_scene.draw`."""
    when, others = np.asarray(times, dtype=float), case.others if case else ()
    states = (motion.plate(other.name)(when) for other in others)
    return placed_plates(case, [(state.x, state.y, state.theta) for state in states], shades)


def placed_plates(
    case: Any, poses: Sequence[Sequence[np.ndarray]], shades: Sequence[float]
) -> list[tuple[DrawnScene, list[Instant]]]:
    """The free plates of a case at some times, by x, y and θ of each at these times, for `drawn_scene.draw`."""
    results = []
    for other, columns in zip(case.others if case else (), poses, strict=True):
        instants = [Instant(x, y, theta, np.nan, shade) for x, y, theta, shade in zip(*columns, shades, strict=True)]
        results.append((case.scene.of(other.plate), instants))
    return results


def along_line(track: Curve, path: np.ndarray) -> np.ndarray:
    """The parameters of a straight track's points below a path, shape (2, n)."""
    low = float(track.span[0])
    return low + track.tangent(low) @ (path - track.point(low)[:, None]) / float(track.speed(low))


def visible(scene: DrawnScene, path: np.ndarray, xi1: np.ndarray) -> np.ndarray:
    """Evenly spaced track parameters for drawing: all of a closed track, otherwise the part near the plate's path.

    `path`: the centre's, shape (2, n), with its contact parameters (NaN in flight).
    """
    track = scene.track
    if track.period:
        return _vertices(track, np.linspace(*track.span, _POINTS))
    flying = ~np.isfinite(xi1)
    parameters = np.concatenate([xi1[~flying], _below(track, path[:, flying])])
    low, high = float(np.min(parameters)), float(np.max(parameters))
    size = float(np.ptp(scene.corners(), axis=1).max())
    domain = track.domain or (-np.inf, np.inf)
    if isinstance(track, Chain):  # its parameter has no one speed
        return _vertices(track, np.zeros(0))
    more = 1.2 * size / float(track.speed(0.5 * (low + high)))
    return np.linspace(max(low - more, domain[0]), min(high + more, domain[1]), _POINTS)


def support_parameters(scene: DrawnScene, path: np.ndarray) -> dict[str, np.ndarray]:
    """The parameters at which each support is drawn, by its name: all of a closed one, otherwise the part near the
    plate's path, shape (2, n)."""
    some = path[:, :: max(1, path.shape[1] // _PLACES)]
    results = {}
    for name, curve in scene.supports.items():
        near = along_line(curve, some) if as_line(curve) else _below(curve, some)
        results[name] = visible(scene._replace(track=curve), some, near)
    return results


def drawn_curves(scene: DrawnScene, path: np.ndarray, xi1: np.ndarray) -> list[np.ndarray]:
    """Points (2, n) of the track and of each support, for drawing; arguments as of `visible`."""
    shown = support_parameters(scene, path)
    points = [curve.point(shown[name]) for name, curve in scene.supports.items()]
    return [scene.track.point(visible(scene, path, xi1)), *points]


def _below(track: Curve, path: np.ndarray) -> np.ndarray:
    """The approximate parameter of the track's point nearest to the centre, for each sample."""
    grid = np.linspace(*track.span, 1001)
    X, Y = track.point(grid)
    return np.array([grid[np.argmin(np.hypot(X - x, Y - y))] for x, y in path.T])


def shown_poses(motion: Any, times: np.ndarray, state: Any, most: int) -> tuple[list[Instant], list]:
    """The poses of a motion at the instants that a picture shows, with `most` of its transitions, and those of free
    plates, for `drawn_scene.draw`; `state`: that at the times."""
    samples = instants(times, [t.time for t in motion.transitions][:most])
    poses = [Instant(state.x[i], state.y[i], state.theta[i], state.xi1[i], shade) for i, shade in samples]
    return poses, free_plates(motion.case, motion, times[[i for i, _ in samples]], [shade for _, shade in samples])


def instants(times: np.ndarray, transitions: Sequence[float]) -> list[tuple[int, float]]:
    """(sample, shade from 1 to 0) at the start, the end, the transitions and evenly spaced times.

    An evenly spaced time within a tenth of the duration of another selected time is omitted.
    """
    instant_times = [float(times[0]), *transitions, float(times[-1])]
    for time in np.linspace(times[0], times[-1], 7)[1:-1]:
        if all(abs(time - other) > 0.1 * (times[-1] - times[0]) for other in instant_times):
            instant_times.append(float(time))
    places = sorted({int(np.argmin(np.abs(times - time))) for time in instant_times})
    return [(place, 1.0 - i / max(len(places) - 1, 1)) for i, place in enumerate(places)]
