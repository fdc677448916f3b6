"""Figures as files: small SVG whose text stays text, signed with the command that makes them again; PDF for print.

Matplotlib is imported when a figure is made: a report whose figures are kept does without it."""

from __future__ import annotations

import hashlib
import re
from collections import Counter
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

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from matplotlib.transforms import Bbox

# Whether figures are also written as PDF: asked once by a command, and meant for all that it draws.
_PRINTED = ContextVar("printed", default=False)
# Whoever lacks Matplotlib's own typeface sees one as wide.
_TYPEFACES = "DejaVu Sans, Verdana, sans-serif"


# File systems hold names of 255 bytes; a figure's begins with its kind.
_READABLE_BYTES, _DIGITS = 150, 8


@dataclass(frozen=True)
class Drawn:
    """A figure that was written: its file's name without ending ("" if it failed), the case's label ("" for all), title
    and caption, and the solvers without whose results it was drawn, since with them it fails."""

    name: str
    case: str
    title: str
    caption: str
    left_out: tuple[LeftOut, ...] = ()


def file_name(label: str) -> str:
    """A case's label as part of a file name: what of it can be in one, and a digest of the exact label, so that no two
    labels share a name, also where upper and lower case are the same."""
    readable = "".join(c if c.isalnum() or c in "._-" else "_" for c in label).strip("._")
    exact = hashlib.sha256(label.encode(errors="surrogatepass")).hexdigest()
    return f"{readable.encode()[:_READABLE_BYTES].decode(errors='ignore')}_{exact[:_DIGITS]}"


@contextmanager
def for_print(wanted: bool = True) -> Iterator[None]:
    """Inside, if it is wanted, figures are also written as PDF."""
    before = _PRINTED.set(wanted)
    try:
        yield
    finally:
        _PRINTED.reset(before)


def printed() -> bool:
    """Whether figures are also written as PDF here; who draws in another process hands it over."""
    return _PRINTED.get()


@dataclass(frozen=True)
class Picture:
    """A figure as its files hold it: SVG, and as bytes a PNG and a PDF (none if empty)."""

    drawn: Drawn
    svg: str
    png: np.ndarray
    pdf: np.ndarray

    @classmethod
    def read(cls, drawn: Drawn, folder: Path) -> Picture:
        """What was written into the folder; nothing of a figure that failed."""
        svg, *others = (folder / f"{drawn.name}.{kind}" for kind in ("svg", "png", "pdf"))
        bytes_of = [_bytes(file.read_bytes() if drawn.name and file.exists() else b"") for file in others]
        return cls(drawn, svg.read_text(encoding="utf-8") if drawn.name else "", *bytes_of)

    def write(self, folder: Path) -> Drawn:
        """Write NAME.svg into the folder (and NAME.png, NAME.pdf); nothing of a figure that failed."""
        if not self.drawn.name:
            return self.drawn
        (folder / f"{self.drawn.name}.svg").write_text(self.svg, encoding="utf-8")
        for kind, content in (("png", self.png), ("pdf", self.pdf)):
            if len(content):
                (folder / f"{self.drawn.name}.{kind}").write_bytes(content.tobytes())
        return self.drawn


def picture(figure: Figure, name: str, case: str, title: str, caption: str, png: bool = False) -> Picture:
    """The figure as SVG (and PNG; PDF, `for_print`); the figure itself is forgotten."""
    from matplotlib import pyplot as plt

    text, dots, sheet = StringIO(), BytesIO(), BytesIO()
    trimmed = _laid_out(figure)
    figure.savefig(text, format="svg", metadata={"Date": None, "Creator": None}, bbox_inches=trimmed)
    if png:
        figure.savefig(dots, format="png", dpi=160, bbox_inches=trimmed)
    if printed():
        figure.savefig(sheet, format="pdf", metadata={"CreationDate": None, "Title": title}, bbox_inches=trimmed)
    plt.close(figure)
    drawn = Drawn(name, case, title, caption)
    return Picture(drawn, minify(text.getvalue()), _bytes(dots.getvalue()), _bytes(sheet.getvalue()))


def _laid_out(figure: Figure) -> Bbox:
    """Put everything in its place, once for all files, and return what it takes, in inches: Matplotlib's "tight" draws
    a figure one time more to find that out. Text is drawn by who shows the picture, in a font that may be a twentieth
    wider: labels at the sides get room for that."""
    from matplotlib import rcParams

    engine = figure.get_layout_engine()
    if engine:
        engine.execute(figure)
        figure.set_layout_engine("none")
    pad = rcParams["savefig.pad_inches"]
    return figure.get_tightbbox().padded(2.0 * pad, pad)


def _bytes(content: bytes) -> np.ndarray:
    return np.frombuffer(content, dtype=np.uint8)


def save(figure: Figure, folder: Path, name: str, case: str, title: str, caption: str, png: bool = False) -> Drawn:
    """Write NAME.svg into the folder (and NAME.png) and forget the figure."""
    return picture(figure, name, case, title, caption, png).write(folder)


def embed_command(folder: Path, drawn: Drawn, command: str) -> None:
    """Write into the figure's file by which command it is made again; a figure that failed has none."""
    if not drawn.name:
        return
    file = folder / f"{drawn.name}.svg"
    text = file.read_text(encoding="utf-8")
    start = text.index(">", text.index("<svg")) + 1
    words = f"<desc>{escape(drawn.title)}. Make it again: {escape(command)}</desc>"
    file.write_text(text[:start] + words + text[start:], encoding="utf-8")


def minify(svg: str) -> str:
    """The same picture in fewer characters: coordinates to a hundredth of a point (of curves to a tenth), what many
    parts share said once, nothing that only tools read."""
    svg = re.sub(r"<\?xml.*?\?>|<!DOCTYPE.*?>|<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    svg = re.sub(r' d="([^"]*)"', lambda m: f' d="{_path(m[1])}"', svg)
    svg = re.sub(r' (x|y)="([^"]*)"', lambda m: f' {m[1]}="{_short(float(m[2]))}"', svg)
    svg = re.sub(r"\s*\n\s*", "\n", svg)
    svg = re.sub(r'<g id="[^"]*"', "<g", svg)  # groups are named and never referred to
    for place, name in enumerate(dict.fromkeys(re.findall(r' id="([^"]*)"', svg))):
        svg = svg.replace(f'"{name}"', f'"i{place}"')
        svg = re.sub(rf'#{re.escape(name)}(?=["\)])', f"#i{place}", svg)  # one name may begin another
    svg = re.sub(r'font-family: [^;"]*;? ?|(?<=style="); | transform="rotate\(-?0 [^"]*"', "", svg)
    svg = _bare_groups(_used_once(_styles_once(svg)))
    return svg.replace("<svg ", f'<svg font-family="{_TYPEFACES}" ', 1).strip() + "\n"


# A path of so many points is a curve: they stand close to each other.
_CURVE = 30


def _short(value: float, digits: int = 2) -> str:
    text = f"{value:.{digits}f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def _path(text: str) -> str:
    """A path through the same points, of a curve to a tenth of a point (its line is ten times as wide), else to a
    hundredth; its straight pieces as differences, which take half the characters."""
    words = re.findall(r"[A-Za-z]|-?[0-9.]+(?:e[-+]?[0-9]+)?", text)
    if not set(filter(str.isalpha, words)) <= set("MLz"):
        return re.sub(
            r" (?=[A-Za-z-])|(?<=[A-Za-z]) ", "", " ".join(w if w.isalpha() else _short(float(w)) for w in words)
        )
    told, before, here = [], "", (0.0, 0.0)
    digits = 2 if len(words) < 3 * _CURVE else 1
    for command, x, y in re.findall(r"(z|[ML])(?: ([^\sA-Za-z]\S*) (\S+))?", " ".join(words)):
        if command == "z":
            told.append("z")
        else:
            # Differences of what was written, so that roundings do not add up.
            there = round(float(x), digits), round(float(y), digits)
            shift = there if command == "M" else (there[0] - here[0], there[1] - here[1])
            pair = f"{_short(shift[0], digits)} {_short(shift[1], digits)}".replace(" -", "-")
            letter = "M" if command == "M" else "l" if before != "L" else "" if pair.startswith("-") else " "
            told.append(letter + pair)
            here = there
        before = command
    return "".join(told)


def _used_once(svg: str) -> str:
    """Marks without the class that what they repeat has itself."""
    classes = dict(re.findall(r'<path id="([^"]*)" d="[^"]*" class="([^"]*)"', svg))
    return re.sub(
        r'(<use xlink:href="#([^"]*)"[^>]*?) class="([^"]*)"',
        lambda m: m[1] if classes.get(m[2]) == m[3] else m[0],
        svg,
    )


def _bare_groups(svg: str) -> str:
    """Without groups that say nothing of what they hold."""
    told, bare = [], []
    for part in re.split(r"(<g\b[^>]*>|</g>)", svg):
        if part.startswith("<g") and part.endswith("/>"):
            told.append(part)  # it holds nothing, and is closed
        elif part.startswith("<g"):
            bare.append(part == "<g>")
            told.append("" if bare[-1] else part)
        else:
            told.append("" if part == "</g>" and bare.pop() else part)
    return re.sub(r">\n+<", "><", "".join(told))


def _styles_once(svg: str) -> str:
    """Styles that several parts have, as classes of a style sheet."""
    counts = Counter(re.findall(r'style="([^"]*)"', svg))
    names = {style: f"c{i}" for i, style in enumerate(style for style, count in counts.items() if count > 1)}
    svg = re.sub(r'style="([^"]*)"', lambda m: f'class="{names[m[1]]}"' if m[1] in names else m[0], svg)
    sheet = "".join(f".{name}{{{style}}}\n" for style, name in names.items())
    return svg.replace("</style>", f"\n{sheet}</style>", 1)
