"""Files of figures: SVG with text as text and the command that reproduces it; PDF for print.

Matplotlib is imported only when a figure is made, so that a command without figures does not need it.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure

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
    return f"{readable_name(label)}_{short_digest(label)}"


def readable_name(label: str) -> str:
    """The allowed characters of a label, as many as a file's name may have."""
    readable = "".join(c if c.isalnum() or c in "._-" else "_" for c in label).strip("._")
    return readable.encode()[:_READABLE_BYTES].decode(errors="ignore")


def short_digest(label: str) -> str:
    """The first digits of the SHA-256 of a label."""
    return hashlib.sha256(label.encode(errors="surrogatepass")).hexdigest()[:_DIGITS]


def file_kinds(paper: bool) -> tuple[str, ...]:
    """The kinds of a figure's files: SVG and PNG, and for `paper` PDF."""
    return ("svg", "png", "pdf") if paper else ("svg", "png")


def save(
    figure: Figure, folder: Path, name: str, case: str, title: str, caption: str, kinds: Sequence[str] = ("svg",)
) -> FigureEntry:
    """Write NAME.svg to the folder, or files of these `kinds`, and close the figure."""
    from matplotlib import pyplot as plt

    from .style import STYLE

    how: dict[str, dict[str, Any]] = {
        "svg": {"metadata": {"Date": None, "Creator": None}},
        "png": {"dpi": 160},
        "pdf": {"metadata": {"CreationDate": None, "Title": title}},
    }
    # Whether text stays text is decided when a file is written, which may be after the figure's own style has ended.
    with plt.rc_context(STYLE):
        for kind in kinds:
            content = BytesIO()
            figure.savefig(content, format=kind, bbox_inches="tight", **how[kind])
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
