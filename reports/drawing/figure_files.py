"""Files of figures: small SVG with text as text and the command that reproduces it; PDF for print.

Matplotlib is imported only when a figure is made, so a report whose figures are all cached does not need it.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from html import escape
from io import BytesIO, StringIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..running.per_solver import LeftOut
from .minify_svg import minify
from .print_layout import fit_to_print

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from matplotlib.transforms import Bbox

# Whether figures are also written as PDF: set once by a command, for all its figures.
_WRITES_PDF = ContextVar("printed", default=False)

# File systems limit names to 255 bytes; a figure's name also has a prefix for its kind.
_READABLE_BYTES, _DIGITS = 150, 8


@dataclass(frozen=True)
class FigureEntry:
    """A figure in a folder: file name without ending ("" if it failed), label of the case ("" for all), title, caption,
    and the solvers whose results are omitted because the figure fails with them."""

    name: str
    case: str
    title: str
    caption: str
    left_out: tuple[LeftOut, ...] = ()


def file_name(label: str) -> str:
    """A case's label as part of a file name: its allowed characters and a digest of the exact label.

    The digest makes names unique, also on file systems that ignore upper and lower case.
    """
    readable = "".join(c if c.isalnum() or c in "._-" else "_" for c in label).strip("._")
    return f"{readable.encode()[:_READABLE_BYTES].decode(errors='ignore')}_{short_digest(label)}"


def short_digest(label: str) -> str:
    """The first digits of the SHA-256 of a label."""
    return hashlib.sha256(label.encode(errors="surrogatepass")).hexdigest()[:_DIGITS]


@contextmanager
def for_print(also_pdf: bool = True) -> Iterator[None]:
    """A context in which figures are also written as PDF, if `also_pdf`."""
    before = _WRITES_PDF.set(also_pdf)
    try:
        yield
    finally:
        _WRITES_PDF.reset(before)


def writes_pdf() -> bool:
    """Whether figures are also written as PDF; code that draws in another process must pass this on."""
    return _WRITES_PDF.get()


@dataclass(frozen=True)
class FigureContent:
    """The contents of a figure's files: SVG text, and bytes of a PNG and a PDF (empty if there is none)."""

    entry: FigureEntry
    svg: str
    png: np.ndarray
    pdf: np.ndarray

    @classmethod
    def read(cls, entry: FigureEntry, folder: Path) -> FigureContent:
        """Read the files of a figure from the folder; empty contents for a figure that failed."""
        svg, *others = (folder / f"{entry.name}.{kind}" for kind in ("svg", "png", "pdf"))
        bytes_of = [_bytes(file.read_bytes() if entry.name and file.exists() else b"") for file in others]
        return cls(entry, svg.read_text(encoding="utf-8") if entry.name else "", *bytes_of)

    def write(self, folder: Path) -> FigureEntry:
        """Write NAME.svg to the folder (and NAME.png, NAME.pdf); nothing for a figure that failed."""
        if not self.entry.name:
            return self.entry
        (folder / f"{self.entry.name}.svg").write_text(self.svg, encoding="utf-8")
        for kind, content in (("png", self.png), ("pdf", self.pdf)):
            if len(content):
                (folder / f"{self.entry.name}.{kind}").write_bytes(content.tobytes())
        return self.entry


def picture(
    figure: Figure, name: str, case: str, title: str, caption: str, png: bool = False, has_margins: bool = False
) -> FigureContent:
    """Convert the figure to SVG (and PNG; inside `for_print` also PDF) and close it.

    `has_margins`: its margins have room for all labels, so that no bounding box is computed."""
    from matplotlib import pyplot as plt

    from .style import STYLE
    from .svg_canvas import SvgCanvas

    text, dots, sheet = StringIO(), BytesIO(), BytesIO()
    # Whether text stays text is decided when a file is written, which may be after the figure's own style has ended.
    with plt.rc_context(STYLE):
        SvgCanvas(figure)
        box = figure.bbox_inches if has_margins else _laid_out(figure)
        figure.savefig(text, format="svg", metadata={"Date": None, "Creator": None}, bbox_inches=box)
        if png:
            figure.savefig(dots, format="png", dpi=160, bbox_inches=box)
        if writes_pdf():
            page = fit_to_print(figure)
            figure.savefig(sheet, format="pdf", metadata={"CreationDate": None, "Title": title}, bbox_inches=page)
    plt.close(figure)
    entry = FigureEntry(name, case, title, caption)
    return FigureContent(entry, minify(text.getvalue()), _bytes(_with_palette(dots)), _bytes(sheet.getvalue()))


def _with_palette(dots: BytesIO) -> bytes:
    """The PNG with a palette of 256 colours, a third of its size: figures have few colours and their edges."""
    from PIL import Image

    if not dots.getbuffer().nbytes:
        return b""
    result = BytesIO()
    Image.open(dots).convert("RGB").quantize(256, dither=Image.Dither.NONE).save(result, "PNG", optimize=True)
    return result.getvalue()


def _laid_out(figure: Figure) -> Bbox:
    """Compute the layout once for all files and return the bounding box in inches.

    Matplotlib's "tight" option would draw the figure once more for this. The viewer draws the text of an SVG in a font
    that may be 5 % wider, so the box has room for that at the sides.
    """
    from matplotlib import rcParams

    engine = figure.get_layout_engine()
    if engine:
        engine.execute(figure)
        # With an engine, Matplotlib would draw the figure once more before it is written; print lays it out again.
        figure.set_layout_engine("none" if writes_pdf() else None)
    pad = rcParams["savefig.pad_inches"]
    return figure.get_tightbbox().padded(3.0 * pad, pad)


def _bytes(content: bytes) -> np.ndarray:
    return np.frombuffer(content, dtype=np.uint8)


def save(
    figure: Figure, folder: Path, name: str, case: str, title: str, caption: str, png: bool = False
) -> FigureEntry:
    """Write NAME.svg to the folder (and NAME.png) and close the figure."""
    return picture(figure, name, case, title, caption, png).write(folder)


def embed_command(folder: Path, entry: FigureEntry, command: str) -> None:
    """Write the command that reproduces a figure into its file; a figure that failed has no file."""
    if not entry.name:
        return
    file = folder / f"{entry.name}.svg"
    text = file.read_text(encoding="utf-8")
    start = text.index(">", text.index("<svg")) + 1
    words = f"<desc>{escape(entry.title)}. Make it again: {escape(command)}</desc>"
    file.write_text(text[:start] + words + text[start:], encoding="utf-8")
