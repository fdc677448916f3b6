"""The style of every figure of the suite, on screen and on paper."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from ..files.owned_folder import atomic_path

# Colours of a scene. The plate is slate like the reference's curves, because by default its motion is the reference's.
# Forces are amber, which is no solver's colour.
TRACK, PLATE, FORCE, FAINT = "#000000", "#33475b", "#e69f00", "#8a8a8a"

STYLE: Any = {
    "font.size": 9,
    "axes.titlesize": 9,
    "axes.labelsize": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e6e6e6",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.4,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "savefig.facecolor": "white",
    "svg.hashsalt": "slip-to-roll",  # equal data give equal files
    "svg.fonttype": "none",  # text stays text: outlines of glyphs would be most of a file
    "pdf.fonttype": 42,  # TrueType; some publishers reject the default Type 3 fonts
    "path.simplify": True,
    "path.simplify_threshold": 0.2,  # points: far less than a line's width
}


class Picture(Figure):
    """A figure independent of pyplot: a notebook shows it once, and no window keeps it in memory."""

    def __init__(self, *args, **kwargs):
        super().__init__(*args, **kwargs)
        FigureCanvasAgg(self)

    def __repr__(self) -> str:
        return f"<Picture of {len(self.axes)} panels; savefig(path) writes it as .svg, .pdf or .png>"

    def _repr_png_(self) -> bytes:
        buffer = BytesIO()
        self.savefig(buffer, format="png", dpi=110, bbox_inches="tight")
        return buffer.getvalue()

    def savefig(self, fname, **kwargs) -> None:
        """Save like Matplotlib's `savefig`, in the suite's style; a file is written completely or not at all."""
        with apply_style():
            if not isinstance(fname, str | Path):
                super().savefig(fname, **kwargs)
                return
            path = Path(fname)
            if not path.suffix and not kwargs.get("format"):
                path = path.with_name(f"{path.name}.{self.canvas.get_default_filetype()}")  # as Matplotlib does
            with atomic_path(path) as partial:
                super().savefig(partial, **kwargs)


@contextmanager
def apply_style() -> Iterator[None]:
    """A context in which figures are drawn and written in the suite's style."""
    with matplotlib.rc_context(STYLE):
        yield
