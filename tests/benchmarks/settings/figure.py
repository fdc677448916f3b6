"""The figure of the study: errors against costs; a rung on the lower envelope is worth its cost."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import matplotlib
from matplotlib import pyplot as plt

from reports.drawing.figure_files import FigureEntry, save
from reports.drawing.style import FAINT, STYLE, LineStyles, logarithmic

from .measure import SettingCell, points

_WORDS = (
    "Whether every rung is worth its cost",
    "Each point is one setting, averaged over the scenes; grey: a grid of all parameters; connected: the ladder's "
    "rungs. A rung is worth its cost if no grey point lies to the left of it and below it.",
)


def draw(cells: Sequence[SettingCell], folder: Path) -> Iterator[FigureEntry]:
    """Write one figure with a column for each route; yields its entry."""
    findings = {route_key: route_points for route_key, route_points in points(cells).items() if route_points}
    if not findings:
        return
    looks = LineStyles(findings)
    with matplotlib.rc_context(STYLE):
        figure, axes = plt.subplots(
            1, len(findings), figsize=(3.2 * len(findings), 3.2), layout="constrained", squeeze=False
        )
        for ax, ((name, route), route_points) in zip(axes[0], findings.items(), strict=True):
            rungs = [point for point in route_points if point.place.startswith("rung")]
            grid = [point for point in route_points if not point.place.startswith("rung")]
            ax.plot([p.cost for p in grid], [p.off for p in grid], ".", color=FAINT, markersize=4)
            ax.plot([p.cost for p in rungs], [p.off for p in rungs], "o-", color=looks.colour(name), markersize=4)
            logarithmic(ax, "xy")
            ax.set_title(f"{name}, {route}", loc="left")
        axes[0][0].set_ylabel("off: share of the error of ignoring friction")
        count = len({cell.case for cell in cells})
        figure.supxlabel(f"CPU time / that of the case's median setting (mean over n = {count} cases)", fontsize=9)
        yield save(figure, folder, "settings", "", *_WORDS)
