"""A curve as a figure, with the points that it was made from."""

from __future__ import annotations

from typing import Any

import numpy as np

from .style import FORCE, TRACK, Picture, apply_style

# Samples of a curve, more than a figure has pixels across.
SAMPLES = 2001


def plot(curve: Any, points: np.ndarray | None = None) -> Picture:
    """The curve, the points given, and their largest distance from it in the title."""
    with apply_style():
        figure = Picture(figsize=(5.0, 3.2), layout="constrained")
        ax = figure.subplots()
        draw(ax, curve, points)
    return figure


def draw(ax, curve: Any, points: np.ndarray | None = None) -> None:
    """Draw a `cases.Curve` into axes, with the points given."""
    if points is not None:
        ax.plot(*points.T, linestyle="none", marker=".", markersize=3, color=FORCE)
    low, high = curve.span
    ax.plot(*curve.point(np.linspace(low, high, SAMPLES)), color=TRACK)
    ax.set_aspect("equal")
    ax.locator_params(nbins=5)
    ax.set_xlabel("X / m")
    ax.set_ylabel("Y / m")
    if curve.residual is not None:
        ax.set_title(f"largest distance of a point: {1e3 * curve.residual:.3g} mm")
