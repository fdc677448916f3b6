"""Drawing of a scene: track and supports, and the plate at some instants."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_rgba

from .layout import DrawnScene, Instant, along_line, drawn_curves, place_outline
from .style import FORCE, PLATE, TRACK


def draw(
    ax: Any,
    scene: DrawnScene,
    path: np.ndarray,
    xi1: np.ndarray,
    instants: Sequence[Instant],
    others: Sequence[tuple[DrawnScene, Sequence[Instant]]] = (),
) -> None:
    """Draw track, supports and plate; `path`: the centre's, shape (2, n), with its contact parameters (NaN in flight).

    The spoke turns with the plate, and the dot is the contact point. In flight, the path of the centre is drawn.
    `others`: scenes of free plates, with their poses.
    """
    shown, places = path, xi1
    if others:
        further = np.array([(pose.x, pose.y) for _, poses in others for pose in poses]).T
        shown, places = np.hstack([path, further]), np.concatenate([xi1, along_line(scene.track, further)])
    for points in drawn_curves(scene, shown, places):
        ax.plot(*points, color=TRACK, linewidth=1.6)
    flying = np.where(np.isfinite(xi1), np.nan, path)
    if np.isfinite(flying).any():
        ax.plot(*flying, color=PLATE, linewidth=0.9, linestyle=(0, (2, 1.5)))
    _draw_plates(ax, [(one, pose) for one, poses in ((scene, instants), *others) for pose in poses])
    contacts = [float(pose.xi1) for poses in (instants, *(poses for _, poses in others)) for pose in poses]
    touching = np.array([scene.track.point(s) for s in contacts if np.isfinite(s)]).reshape(-1, 2)
    ax.plot(*touching.T, linestyle="", marker="o", markersize=3, color=FORCE)
    finish(ax, scene)


def _draw_plates(ax: Any, plates: Sequence[tuple[DrawnScene, Instant]]) -> None:
    """Draw outlines and spokes, as one artist each: of many, Matplotlib computes the limits again and again."""
    placed = [place_outline(*one) for one in plates]
    shades = [pose.shade for _, pose in plates]
    edges = [to_rgba(PLATE, 0.4 + 0.6 * shade) for shade in shades]
    insides = [to_rgba(PLATE, 0.08 + 0.22 * shade) for shade in shades]
    look: dict[str, Any] = dict(edgecolors=edges, linewidths=0.9)
    spokes = [np.transpose(spoke) for _, spoke in placed]
    outlines = [np.transpose(corners) for corners, _ in placed]
    ax.add_collection(PolyCollection(outlines, facecolors=insides, joinstyle="miter", **look))
    ax.add_collection(LineCollection(spokes, capstyle="projecting", zorder=2, **look))


def finish(ax: Any, scene: DrawnScene) -> None:
    """Set equal scales, gravity down the page, and the axis labels."""
    ax.set_aspect("equal")
    ax.locator_params(nbins=5)
    if scene.down and not ax.yaxis_inverted():
        ax.invert_yaxis()
    ax.set_xlabel("X / m")
    ax.set_ylabel("Y / m" + (" (points down)" if scene.down else ""))
