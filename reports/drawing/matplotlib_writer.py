"""A figure of a file or of a notebook: the same data as in the page, drawn by Matplotlib."""

from __future__ import annotations

from math import isfinite
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import NullLocator

from cases.pictures.style import FAINT, Picture

from .colours import TRUTH, LineStyles
from .traces import Diagram, Panel, PlotScale, Trace, apart

# Height of a line of text as a share of a panel's, and mean width of a letter of size 8 as a share of a panel's.
_LINE, _LETTER = 0.075, 5.0 / 270.0
# Markers of points beyond an axis, by its side: below and above.
_ARROWS = {"x": {-1: 8, 1: 9}, "y": {-1: 11, 1: 10}}


def draw(diagram: Diagram, looks: LineStyles, width: float = 7.6, height: float = 2.9) -> Picture:
    """The figure; sizes in inches, of a row. The style is that of the caller's context."""
    figure = Picture(figsize=(width, height * len(diagram.rows)), layout="constrained")
    rows = figure.subfigures(len(diagram.rows), 1, squeeze=False)[:, 0]
    for row, panels in zip(rows, diagram.rows, strict=True):
        for ax, panel in zip(row.subplots(1, len(panels), squeeze=False)[0], panels, strict=True):
            _panel(ax, panel, looks)
    first = figure.axes[0]
    first.set_title(diagram.title, loc="left", pad=18, fontweight="bold")
    if not any(trace.label for row in diagram.rows for panel in row for trace in panel.traces):
        first.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure


def _panel(ax: Axes, panel: Panel, looks: LineStyles) -> None:
    scales = {}
    for name, axis in (("x", panel.x), ("y", panel.y)):
        values = (value for trace in panel.traces for value in getattr(trace, name))
        scale = scales[name] = PlotScale(axis, values, 0.0, 1.0)
        ax.set(**{f"{name}scale": "log" if axis.is_log else "linear", f"{name}label": axis.label})
        # The ticks of the page.
        along = ax.xaxis if name == "x" else ax.yaxis
        along.set_minor_locator(NullLocator())
        along.set_ticks(*zip(*scale.ticks(), strict=True))
        ax.set(**{f"{name}lim": (scale.low, scale.high)})
    if panel.title:
        ax.set_title(panel.title, loc="left", pad=18 if panel.spans else None)
    for span in panel.spans:
        if span.is_shaded:
            ax.axvspan(span.low, span.high, color="#eeeeee", zorder=0)
        ax.axvline(span.low, color=FAINT, linewidth=0.7, zorder=0.5)
        middle = scales["x"](0.5 * (span.low + span.high))
        if scales["x"](span.high) - scales["x"](span.low) > _LETTER * len(span.name):
            ax.text(middle, 1.01, span.name, transform=ax.transAxes, ha="center", color="#555555", fontsize=8)
    for level in panel.levels:
        ax.axhline(level, color=FAINT, linewidth=0.6, zorder=0.5)
    for trace in panel.traces:
        _trace(ax, trace, scales, looks)
    _label(ax, panel, scales, looks)


def _trace(ax: Axes, trace: Trace, scales: dict[str, PlotScale], looks: LineStyles) -> None:
    if not trace.solver:
        ax.plot(trace.x, trace.y, color=TRUTH.light, linewidth=2.6, alpha=0.25, label="truth")
        return
    look, marker = looks.line(trace.solver, trace.route), looks.marker(trace.solver)
    name = f"{trace.solver}, {trace.route}" if trace.route else trace.solver
    shape: Any = {"marker": marker, "markersize": 6} if trace.is_marked else {}
    ax.plot([], [], **look, **shape, label=name)
    if trace.is_line:
        ax.plot(trace.x, trace.y, **look, linewidth=1.1)
    if trace.low:
        ax.vlines(trace.x, trace.low, trace.high, color=look["color"], linewidth=1.0)
    for i, (x, y) in enumerate(zip(trace.x, trace.y, strict=True) if trace.is_marked else ()):
        if not isfinite(x) or not isfinite(y):
            continue
        sides = [(axis, side) for axis, value in (("x", x), ("y", y)) if (side := scales[axis].side(value))]
        kind = _ARROWS[sides[0][0]][sides[0][1]] if sides else marker
        ax.plot(
            np.clip(x, scales["x"].low, scales["x"].high), np.clip(y, scales["y"].low, scales["y"].high), marker=kind,
            markersize=6, color=look["color"], markerfacecolor="white" if i in trace.hollow else look["color"],
            alpha=0.3 if i in trace.pale else 1.0, clip_on=not sides, linestyle="",
        )  # fmt: skip


def _label(ax: Axes, panel: Panel, scales: dict[str, PlotScale], looks: LineStyles) -> None:
    """Names at the lines, moved apart where they would overlap."""
    named = [trace for trace in panel.traces if trace.label]
    points = [trace.label_point for trace in named]
    heights = apart([scales["y"](y) for _, y in points], _LINE, 0.0, 1.0)
    for trace, (x, _), height in zip(named, points, heights, strict=True):
        ax.annotate(
            trace.label, (scales["x"](x), height), (5, 0), xycoords="axes fraction", textcoords="offset points",
            color=looks.colour(trace.solver), va="center", fontsize=8.5, annotation_clip=False,
        )  # fmt: skip
