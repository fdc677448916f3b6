"""Files of figures: SVG with text as text and the command that reproduces it; PDF for print.

Matplotlib is imported only when a figure is made, so that a command without figures does not need it.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from html import escape
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Whether figures are also written as PDF: set once by a command, for all its figures.
_WRITES_PDF = ContextVar("printed", default=False)

# File systems limit names to 255 bytes; a figure's name also has a prefix for its kind.
_READABLE_BYTES, _DIGITS = 150, 8


@dataclass(frozen=True)
class FigureEntry:
    """A figure in a folder: file name without ending ("" if it failed), label of its case ("" for all), its words."""

    name: str
    case: str
    title: str
    caption: str


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


def save(
    figure: Figure, folder: Path, name: str, case: str, title: str, caption: str, png: bool = False
) -> FigureEntry:
    """Write NAME.svg to the folder (and NAME.png; inside `for_print` also NAME.pdf) and close the figure."""
    from matplotlib import pyplot as plt

    from .style import STYLE

    kinds: dict[str, dict[str, Any]] = {"svg": {"metadata": {"Date": None, "Creator": None}}}
    kinds |= {"png": {"dpi": 160}} if png else {}
    kinds |= {"pdf": {"metadata": {"CreationDate": None, "Title": title}}} if writes_pdf() else {}
    # Whether text stays text is decided when a file is written, which may be after the figure's own style has ended.
    with plt.rc_context(STYLE):
        for kind, how in kinds.items():
            content = BytesIO()
            figure.savefig(content, format=kind, bbox_inches="tight", **how)
            (folder / f"{name}.{kind}").write_bytes(_with_palette(content) if kind == "png" else content.getvalue())
    plt.close(figure)
    return FigureEntry(name, case, title, caption)


def _with_palette(dots: BytesIO) -> bytes:
    """The PNG with a palette of 256 colours, a third of its size: figures have few colours and their edges."""
    from PIL import Image

    result = BytesIO()
    Image.open(dots).convert("RGB").quantize(256, dither=Image.Dither.NONE).save(result, "PNG", optimize=True)
    return result.getvalue()


def embed_command(folder: Path, entry: FigureEntry, command: str) -> None:
    """Write the command that reproduces a figure into its file; a figure that failed has no file."""
    if not entry.name:
        return
    file = folder / f"{entry.name}.svg"
    text = file.read_text(encoding="utf-8")
    start = text.index(">", text.index("<svg")) + 1
    words = f"<desc>{escape(entry.title)}. Make it again: {escape(command)}</desc>"
    file.write_text(text[:start] + words + text[start:], encoding="utf-8")
