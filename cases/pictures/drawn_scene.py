"""Drawing of a scene: track and supports, and the plate at some instants."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

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
    for scene_of_one, instant in [(one, pose) for one, poses in ((scene, instants), *others) for pose in poses]:
        corners, spoke = place_outline(scene_of_one, instant)
        edge, inside = 0.4 + 0.6 * instant.shade, 0.08 + 0.22 * instant.shade
        ax.fill(*corners, facecolor=(PLATE, inside), edgecolor=(PLATE, edge), linewidth=0.9)
        ax.plot(*spoke, color=PLATE, linewidth=0.9, alpha=edge)
        if np.isfinite(instant.xi1):
            ax.plot(*scene.track.point(float(instant.xi1)), marker="o", markersize=3, color=FORCE)
    finish(ax, scene)


def finish(ax: Any, scene: DrawnScene) -> None:
    """Set equal scales, gravity down the page, and the axis labels."""
    ax.set_aspect("equal")
    ax.locator_params(nbins=5)
    if scene.down and not ax.yaxis_inverted():
        ax.invert_yaxis()
    ax.set_xlabel("X / m")
    ax.set_ylabel("Y / m" + (" (points down)" if scene.down else ""))
