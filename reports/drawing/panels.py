"""The empty panels of the figure of motions, made once per process: to make axes and ticks takes a third of a figure's
time, and only the lines differ from case to case."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

from .figure_files import writes_pdf
from .palette import logarithmic

# Fixed margins with room for all labels: automatic layout, or a search for the bounding box, would take a third of the
# figure's time.
_PLACES = {"left": 0.1, "right": 0.99, "bottom": 0.04, "top": 0.93, "wspace": 0.29, "hspace": 0.12}


def blank_panels(rows: int, **look: Any) -> tuple[Figure, np.ndarray]:
    """A figure of so many rows of two panels with a common time axis, the right ones logarithmic, as if it were new;
    the next call empties it.

    `look`: the size of the figure, and what else `Figure` takes."""
    if writes_pdf():
        _panels.cache_clear()  # for print a figure's size and texts are changed for good
    figure, axes = _panels(rows, tuple(sorted(look.items())))
    for legend in list(figure.legends):
        legend.remove()
    for ax in axes.flat:
        _empty(ax)
    return figure, axes


@lru_cache(maxsize=1)
def _panels(rows: int, look: tuple) -> tuple[Figure, np.ndarray]:
    figure = Figure(**dict(look))  # not by pyplot, which closes its figures
    axes = figure.subplots(rows, 2, sharex=True, squeeze=False, gridspec_kw=_PLACES)
    for ax in axes[:, 1]:
        logarithmic(ax, "y")
    return figure, axes


def _empty(ax: Axes) -> None:
    """Remove the data of an axes and what they changed."""
    for artist in (*ax.lines, *ax.collections, *ax.texts, *ax.patches):
        artist.remove()
    ax.set_prop_cycle(None)
    ax.dataLim = Bbox.null()
    # Matplotlib takes these for the limits of axes without data, which follow later data; logarithmic: with a margin.
    ax.set_xlim(0.0, 1.0, emit=False, auto=True)
    ax.set_ylim(*((0.0, 1.0) if ax.get_yscale() == "linear" else (10.0**-0.05, 10.0**1.05)), auto=True)
