"""How every figure of the suite looks: one style, on the screen and on paper."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from ..owned_folder import written

# What is drawn of a scene. The plate is slate, as the reference's curves are: its motion is the reference's unless
# somebody says otherwise. Forces are amber, which no solver has.
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
    "svg.fonttype": "none",  # text as text: glyphs as outlines are most of a file
    "pdf.fonttype": 42,  # letters that a publisher's tools take; the other kind is refused by some
    "path.simplify": True,
    "path.simplify_threshold": 0.2,  # of a point: less than a line's width by far
}


class Picture(Figure):
    """A figure that a notebook shows once, whatever else is imported, and that no window keeps alive."""

    def __init__(self, *args, **kwargs):
        super().__init__(*args, **kwargs)
        FigureCanvasAgg(self)

    def __repr__(self) -> str:
        return f"<Picture of {len(self.axes)} panels; savefig(path) writes it as .svg, .pdf or .png>"

    def _repr_png_(self) -> bytes:
        held = BytesIO()
        self.savefig(held, format="png", dpi=110, bbox_inches="tight")
        return held.getvalue()

    def savefig(self, fname, **kwargs) -> None:
        """As Matplotlib's, in the suite's style: text stays text. A file is written whole or not at all."""
        with styled():
            if not isinstance(fname, str | Path):
                super().savefig(fname, **kwargs)
                return
            path = Path(fname)
            if not path.suffix and not kwargs.get("format"):
                path = path.with_name(f"{path.name}.{self.canvas.get_default_filetype()}")  # as Matplotlib does
            with written(path) as partial:
                super().savefig(partial, **kwargs)


@contextmanager
def styled() -> Iterator[None]:
    """What is drawn and written inside has the suite's style."""
    with matplotlib.rc_context(STYLE):
        yield
