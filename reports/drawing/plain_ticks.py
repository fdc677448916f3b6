"""Ticks, grid and label of an axis as a few artists, for the same picture.

Matplotlib's axis has five artists for each tick, and measures every label three times: 40 % of a figure's time.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.font_manager import FontProperties
from matplotlib.lines import Line2D
from matplotlib.markers import TICKDOWN, TICKLEFT
from matplotlib.textpath import text_to_path
from matplotlib.transforms import ScaledTranslation, Transform

from .figure_files import writes_pdf

# Below curves, as Matplotlib's axis with `axes.axisbelow`.
_ZORDER = 0.5
# Part of an axis by which a tick at its end may lie outside by rounding.
_ROUNDING = 1e-9
# Distance of the common factor from its axis, points, and the height of a line of text, font sizes: Matplotlib's.
_OFFSET_PAD, _LINE_HEIGHT = 3.0, 1.0


def plain_ticks(ax: Axes, which: str = "xy", has_x_labels: bool = True) -> None:
    """Draw the ticks of axes ("x", "y" or both) in place of Matplotlib's; to be called last, when limits are final.
    `has_x_labels`: the horizontal axis has texts.

    A figure that is also for print keeps Matplotlib's, which change with its size."""
    if writes_pdf():
        return
    for name in which:
        axis = ax.xaxis if name == "x" else ax.yaxis
        places, texts, offset = _ticks(axis)
        grid(ax, name, places)
        label = axis.get_label_text()
        if name == "x" and not has_x_labels:
            texts, offset, label = [""] * len(places), "", ""
        (_draw_below if name == "x" else _draw_left)(ax, places, texts, label, offset)
        axis.set_visible(False)


def grid(ax: Axes, which: str, places: Sequence[float]) -> None:
    """Lines of the grid at places on one axis, as one path."""
    along = np.repeat(np.asarray(places, dtype=float), 3)
    across = np.tile([0.0, 1.0, np.nan], len(places))
    points, across_axes = (along, across), ax.get_xaxis_transform()
    if which == "y":
        points, across_axes = (across, along), ax.get_yaxis_transform()
    look: dict[str, Any] = dict(color=rcParams["grid.color"], linewidth=rcParams["grid.linewidth"], zorder=_ZORDER)
    ax.add_artist(Line2D(*points, transform=across_axes, **look))


def _ticks(axis: Any) -> tuple[list[float], list[str], str]:
    """The ticks inside the limits, their texts, and the common factor or summand of all texts."""
    places, formatter = axis.get_majorticklocs(), axis.get_major_formatter()
    texts = formatter.format_ticks(places)
    ends = axis.get_transform().transform(np.array([*axis.get_view_interval(), *places]))
    (low, high), inside = sorted(ends[:2]), ends[2:]
    margin = _ROUNDING * (high - low)
    visible = (inside >= low - margin) & (inside <= high + margin)
    return (
        [float(place) for place in places[visible]],
        [text for text, shows in zip(texts, visible, strict=True) if shows],
        formatter.get_offset(),
    )


def _draw_left(ax: Axes, places: Sequence[float], texts: Sequence[str], label: str, offset: str) -> None:
    transform, away = ax.get_yaxis_transform(), rcParams["ytick.major.size"] + rcParams["ytick.major.pad"]
    _marks(ax, np.zeros(len(places)), places, TICKLEFT, transform)
    label_transform = transform + _points(ax, -away, 0.0)
    for place, text in zip(places, texts, strict=True):
        ax.text(0.0, place, text, transform=label_transform, ha="right", va="center_baseline")
    if offset:
        ax.text(0.0, 1.0, offset, transform=ax.transAxes + _points(ax, 0.0, _OFFSET_PAD), ha="left", va="baseline")
    if label:
        away += max((_width(text, rcParams["font.size"]) for text in texts), default=0.0) + rcParams["axes.labelpad"]
        ax.text(
            0.0, 0.5, label, transform=ax.transAxes + _points(ax, -away, 0.0), rotation=90, rotation_mode="anchor",
            ha="center", va="bottom",
        )  # fmt: skip


def _draw_below(ax: Axes, places: Sequence[float], texts: Sequence[str], label: str, offset: str) -> None:
    transform, away = ax.get_xaxis_transform(), rcParams["xtick.major.size"] + rcParams["xtick.major.pad"]
    _marks(ax, places, np.zeros(len(places)), TICKDOWN, transform)
    label_transform = transform + _points(ax, 0.0, -away)
    for place, text in zip(places, texts, strict=True):
        if text:
            ax.text(place, 0.0, text, transform=label_transform, ha="center", va="top")
    away += _LINE_HEIGHT * rcParams["font.size"]
    if offset:
        shift = _points(ax, 0.0, -away - _OFFSET_PAD)
        ax.text(1.0, 0.0, offset, transform=ax.transAxes + shift, ha="right", va="top")
    if label:
        shift = _points(ax, 0.0, -away - rcParams["axes.labelpad"])
        ax.text(0.5, 0.0, label, transform=ax.transAxes + shift, ha="center", va="top")


def _marks(ax: Axes, x: Any, y: Any, marker: Any, transform: Transform) -> None:
    look: dict[str, Any] = dict(
        markersize=rcParams["xtick.major.size"], markeredgewidth=rcParams["xtick.major.width"],
        color=rcParams["xtick.color"], linestyle="", marker=marker,
    )  # fmt: skip
    ax.add_artist(Line2D(x, y, transform=transform, clip_on=False, zorder=_ZORDER, **look))


def _points(ax: Axes, right: float, up: float) -> Transform:
    """A shift in points."""
    return ScaledTranslation(right / 72.0, up / 72.0, ax.figure.dpi_scale_trans)


@lru_cache(maxsize=4096)
def _width(text: str, size: float) -> float:
    """The width of a text in points."""
    return text_to_path.get_text_width_height_descent(text, FontProperties(size=size), ismath=False)[0]
