"""Errors of ladders and grids against their costs: a rung that pays lies on the lower envelope."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import matplotlib
from matplotlib import pyplot as plt

from ...drawing.files import Drawn, save
from ...drawing.style import FAINT, STYLE, Looks, logarithmic
from .measure import QUANTITIES, Cell, points

_WORDS = (
    "Whether every rung pays",
    "Each point is one setting in the mean of the scenes; grey: a grid of all knobs; joined: the ladder's rungs. A "
    "rung pays if no grey point lies left of it and below.",
)


def draw(cells: Sequence[Cell], folder: Path) -> Iterator[Drawn]:
    """Write one figure: a row for each quantity, a column for each route."""
    found = {who: own for who, own in points(cells).items() if own}
    if not found:
        return
    looks = Looks(found)
    with matplotlib.rc_context(STYLE):
        figure, axes = plt.subplots(
            len(QUANTITIES), len(found), figsize=(3.2 * len(found), 5.6), layout="constrained", squeeze=False
        )
        for column, ((name, route), own) in enumerate(found.items()):
            for row, quantity in enumerate(QUANTITIES):
                ax = axes[row][column]
                rungs = [point for point in own if point.place.startswith("rung")]
                grid = [point for point in own if not point.place.startswith("rung")]
                ax.plot([p.cost for p in grid], [p.errors[row] for p in grid], ".", color=FAINT, markersize=4)
                ax.plot(
                    [p.cost for p in rungs],
                    [p.errors[row] for p in rungs],
                    "o-",
                    color=looks.colour(name),
                    markersize=4,
                )
                logarithmic(ax, "xy")
                ax.set_title(f"{name}, {route}" if not row else "")
                ax.set_ylabel(f"{quantity.replace('_', ' ')}: error / s" if not column else "")
        figure.supxlabel("CPU time / that of the case's median setting", fontsize=9)
        yield save(figure, folder, "settings", "", *_WORDS)
