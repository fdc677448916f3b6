"""Figures of the parts of an error: each setting of a route's grid with its error and the parameter to refine next."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import isfinite
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from ...drawing.figure_files import FigureEntry, file_name, save
from ...drawing.style import STYLE
from .measure import QUANTITIES, ErrorCell, Grid, advice, by_route

_WORDS = (
    "The parts of an error",
    "Each square is one setting: the step becomes finer downwards, the model to the right (the numbers below a column "
    "are its parameters, in the order of the axis label). Colour: size of the error. The word is the parameter that "
    "reduces it most if refined alone by one level; “all”: only all together reduce it; –: nothing does. Grey: no such "
    "result.",
)
# The third quantity would repeat the second: a motion that loses energy ends at another position.
_QUANTITIES = ("first_transition_time", "energy_lost")


def draw(cells: Sequence[ErrorCell], folder: Path) -> Iterator[FigureEntry]:
    """Write a figure for each case with a grid; yields the entries of the figures."""
    with matplotlib.rc_context({**STYLE, "axes.grid": False}):
        for case in dict.fromkeys(cell.case for cell in cells if cell.setting.keys()):
            groups = {
                route_key: group
                for route_key, group in by_route(cells).items()
                if route_key[0] == case and group[0].setting.keys()
            }
            figure = maps({f"{solver}, {route}": Grid(group) for (_, solver, route), group in groups.items()}, case)
            yield save(figure, folder, f"error_parts_{file_name(case)}", case, *_WORDS)


def maps(grids: dict[str, Grid], title: str) -> Figure:
    """A figure with a row of maps for each quantity and a column for each route."""
    widths = [max(4, len(_columns(grid))) for grid in grids.values()]
    figure, axes = plt.subplots(
        len(_QUANTITIES), len(grids), figsize=(0.44 * sum(widths) + 2.0, 6.2), layout="constrained", squeeze=False,
        width_ratios=widths,
    )  # fmt: skip
    for quantity, line in zip(_QUANTITIES, axes, strict=True):
        sizes = [_size(grid, place, quantity) for grid in grids.values() for place in grid.cells]
        positive = [size for size in sizes if isfinite(size) and size > 0.0]
        norm = LogNorm(min(positive), max(positive)) if positive and min(positive) < max(positive) else None
        for ax, (name, grid) in zip(line, grids.items(), strict=True):
            image = _map(ax, grid, quantity, norm)
            ax.set_title(name)
        label = f"{quantity.replace('_', ' ')}: error / {QUANTITIES[quantity]}"
        figure.colorbar(image, ax=line.tolist(), label=label, pad=0.01)
    figure.suptitle(title, fontweight="bold", fontsize=10)
    return figure


def _columns(grid: Grid) -> list[tuple[int, ...]]:
    """Places of the model's parameters for any step; the last parameter changes slowest."""
    return sorted({place[1:] for place in grid.cells}, key=lambda place: place[::-1])


def _size(grid: Grid, place: Sequence[int], quantity: str) -> float:
    return float(np.linalg.norm(grid.error(place, quantity)))


def _map(ax: Axes, grid: Grid, quantity: str, norm):
    columns, steps = _columns(grid), grid.levels[0]
    table = np.array([[_size(grid, (row, *place), quantity) for place in columns] for row in range(len(steps))])
    ax.set_facecolor("#d0d0d0")
    image = ax.imshow(np.where(table > 0.0, table, np.nan), norm=norm, cmap="viridis_r", aspect="auto")
    for row, line in enumerate(table):
        for column, size in enumerate(line):
            word = advice(grid, (row, *columns[column]), quantity)[0] if isfinite(size) else ""
            dark = norm is not None and isfinite(size) and size > 0.0 and norm(size) > 0.5
            word, colour = "–" if word == "none" else _fitting(word), "white" if dark else "black"
            ax.text(column, row, word, ha="center", va="center", fontsize=7, color=colour)
    values = [[levels[at] for levels, at in zip(grid.levels[1:], place, strict=True)] for place in columns]
    ax.set_xticks(range(len(columns)), ["\n".join(map(_short, each)) for each in values], fontsize=6.5)
    ax.set_yticks(range(len(steps)), [f"{h:.2g}" for h in steps], fontsize=7)
    ax.set_xlabel(", ".join(grid.parameters[1:]))
    ax.set_ylabel("step h / s")
    ax.tick_params(length=0)
    return image


def _fitting(word: str) -> str:
    """A parameter's name shortened to the width of a square; the axis label has the full name."""
    return word if len(word) < 7 else f"{word[:5]}."


def _short(value: float | int) -> str:
    return str(value) if isinstance(value, int) else f"{value:.1e}".replace("e+0", "e").replace("e-0", "e-")
