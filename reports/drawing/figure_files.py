"""Files of figures: small SVG with text as text and the command that reproduces it; PDF for print.

Matplotlib is imported only when a figure is made, so a report whose figures are all cached does not need it.
"""

from __future__ import annotations

import hashlib
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from html import escape
from io import BytesIO, StringIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..running.per_solver import LeftOut
from .print_layout import fit_to_print

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from matplotlib.transforms import Bbox

# Whether figures are also written as PDF: set once by a command, for all its figures.
_WRITES_PDF = ContextVar("printed", default=False)
# Matplotlib's typeface first; the fallbacks are equally wide.
_TYPEFACES = "DejaVu Sans, Verdana, sans-serif"


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

    text, dots, sheet = StringIO(), BytesIO(), BytesIO()
    # Whether text stays text is decided when a file is written, which may be after the figure's own style has ended.
    with plt.rc_context(STYLE):
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
        figure.set_layout_engine("none")
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


def minify(svg: str) -> str:
    """Shorten an SVG without visible change.

    Coordinates are rounded to a tenth of a point, points that a curve's shape does not need are left out, shared styles
    become classes, lines of a grid and marks of an axis become one path each, and metadata is removed.
    """
    svg = re.sub(r"<\?xml.*?\?>|<!DOCTYPE.*?>|<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    # Marks are small: a hundredth of a point shows in their shape.
    svg = re.sub(r'( id="[^"]*")? d="([^"]*)"', lambda m: f'{m[1] or ""} d="{_path(m[2], 2 if m[1] else 1)}"', svg)
    # Matplotlib before 3.9 lists the place of every letter of some texts.
    svg = re.sub(r' (x|y)="([^"]*)"', lambda m: f' {m[1]}="{" ".join(_short(float(n)) for n in m[2].split())}"', svg)
    svg = re.sub(r"\s*\n\s*", "\n", svg)
    svg = re.sub(r'<g id="[^"]*"', "<g", svg)  # groups are named and never referred to
    for place, name in enumerate(dict.fromkeys(re.findall(r' id="([^"]*)"', svg))):
        svg = svg.replace(f'"{name}"', f'"i{place}"')
        svg = re.sub(rf'#{re.escape(name)}(?=["\)])', f"#i{place}", svg)  # one name may be the prefix of another
    svg = re.sub(
        r"(rotate\([-\d.]+) ([-\d.]+) ([-\d.]+)\)",
        lambda m: f"{m[1]} {_short(float(m[2]))} {_short(float(m[3]))})",
        svg,
    )
    svg = re.sub(r'font-family: [^;"]*;? ?|(?<=style="); | transform="rotate\(-?0 [^"]*"', "", svg)
    svg = _join_segments(_bare_groups(_unique_ids(_styles_once(svg))))
    return svg.replace("<svg ", f'<svg font-family="{_TYPEFACES}" ', 1).strip() + "\n"


# A path with at least this many points is a curve: its points are close to each other. Those this near (points, 1/72
# inch) to the line between their neighbours are left out: lines are three to five times as wide.
_CURVE, _NEAR = 30, 0.3


def _short(value: float, digits: int = 1) -> str:
    """The number without zeros that it does not need: .5, -.5, 3."""
    text = f"{value:.{digits}f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text.replace("0.", ".", 1) if text.startswith(("0.", "-0.")) else text


def _path(text: str, digits: int = 1) -> str:
    """A path rounded to so many digits, with relative coordinates, which take half the characters; of a curve only the
    points that its shape needs."""
    words = re.findall(r"[A-Za-z]|-?[0-9.]+(?:e[-+]?[0-9]+)?", text)
    if not set(filter(str.isalpha, words)) <= set("MLz"):
        return re.sub(
            r" (?=[A-Za-z-])|(?<=[A-Za-z]) ",
            "",
            " ".join(w if w.isalpha() else _short(float(w), digits) for w in words),
        )
    if len(words) < 3 * _CURVE:
        return _relative(words, digits)
    starts = [place for place, word in enumerate(words) if word == "M"]
    parts = [words[begin:end] for begin, end in zip(starts, [*starts[1:], len(words)], strict=True)]
    return "".join(_relative(_simplify(part), digits) for part in parts)


def _relative(words: Sequence[str], digits: int) -> str:
    words_out, before, here = [], "", (0.0, 0.0)
    for command, x, y in re.findall(r"(z|[ML])(?: ([^\sA-Za-z]\S*) (\S+))?", " ".join(words)):
        if command == "z":
            words_out.append("z")
        else:
            # Differences of rounded positions, so that rounding errors do not add up.
            there = round(float(x), digits), round(float(y), digits)
            shift = there if command == "M" else (there[0] - here[0], there[1] - here[1])
            pair = f"{_short(shift[0], digits)} {_short(shift[1], digits)}".replace(" -", "-")
            letter = "M" if command == "M" else "l" if before != "L" else "" if pair.startswith("-") else " "
            words_out.append(letter + pair)
            here = there
        before = command
    return "".join(words_out)


def _simplify(words: Sequence[str]) -> list[str]:
    """The words of a part of a path without the points near the line between their neighbours (Ramer, Douglas and
    Peucker's method)."""
    end = list(words[-1:]) if words[-1] == "z" else []
    points = np.array([float(word) for word in words if not word.isalpha()]).reshape(-1, 2)
    corners, spans = {0, len(points) - 1}, [(0, len(points) - 1)]
    while spans:
        first, last = spans.pop()
        if last - first < 2:
            continue
        chord, others = points[last] - points[first], points[first + 1 : last] - points[first]
        along = np.clip(others @ chord / max(float(chord @ chord), 1e-12), 0.0, 1.0)
        distance = np.hypot(*(others - along[:, None] * chord).T)
        if distance.max() > _NEAR:
            middle = first + 1 + int(distance.argmax())
            corners.add(middle)
            spans += [(first, middle), (middle, last)]
    path = [word for i in sorted(corners) for word in ("L" if i else "M", *map(str, points[i]))]
    return [*path, *end]


# A segment: a path of two points, as a line of a grid; and a mark that repeats a segment, as the ticks of an axis do.
_SEGMENT = re.compile(r'<path d="(M[-\d. ]+)l(-?[\d.]+) ?(-?[\d.]+)"([^>]*)/>')
_MARK = re.compile(r'<use xlink:href="#([^"]*)" x="([^"]*)" y="([^"]*)"/>')
_MARKER = re.compile(r'<path id="([^"]*)" d="M0 0(l[-\d. ]+)" (class="[^"]*")/>')
# What Matplotlib writes between the lines and marks of an axis, over which none of them is drawn.
_OF_AXIS = re.compile(r"<text\b[^>]*>[^<]*</text>|<defs>(?:<path[^>]*/>)*</defs>")
_ELEMENT = re.compile(rf"{_OF_AXIS.pattern}|<[^>]*>|[^<]+")


def _join_segments(svg: str) -> str:
    """Join segments with the same attributes that only texts and other segments separate into one path."""
    markers = {name: (shift, look) for name, shift, look in _MARKER.findall(svg)}

    def as_segment(use: re.Match) -> str:
        if use[1] not in markers:
            return use[0]
        shift, look = markers[use[1]]
        return f'<path d="M{use[2]} {use[3]}{shift}" {look}/>'

    parts: list[str] = []
    paths: dict[str, int] = {}  # attributes of the segments since the last other element, and their path's place
    for element in _ELEMENT.findall(_MARK.sub(as_segment, svg)):
        segment = _SEGMENT.fullmatch(element)
        if segment is None:
            paths = paths if _OF_AXIS.fullmatch(element) else {}
            parts.append(element)
            continue
        begin, x, y, look = segment.groups()
        line = begin + (f"v{y}" if x == "0" else f"h{x}" if y == "0" else f"l{x} {y}".replace(" -", "-"))
        if look in paths:
            parts[paths[look]] += line
        else:
            paths[look] = len(parts) + 1
            parts += ['<path d="', line, f'"{look}/>']
    svg = "".join(parts)
    unused = [name for name in markers if f'"#{name}"' not in svg]
    for name in unused:
        svg = re.sub(rf'<path id="{name}"[^>]*/>', "", svg)
    return svg.replace("<defs></defs>", "")


def _unique_ids(svg: str) -> str:
    """Remove the class of a marker if the path that it repeats has the same class."""
    classes = dict(re.findall(r'<path id="([^"]*)" d="[^"]*" class="([^"]*)"', svg))
    return re.sub(
        r'(<use xlink:href="#([^"]*)"[^>]*?) class="([^"]*)"',
        lambda m: m[1] if classes.get(m[2]) == m[3] else m[0],
        svg,
    )


def _bare_groups(svg: str) -> str:
    """Remove groups without attributes."""
    parts, bare = [], []
    for part in re.split(r"(<g\b[^>]*>|</g>)", svg):
        if part.startswith("<g") and part.endswith("/>"):
            parts.append(part)  # an empty element
        elif part.startswith("<g"):
            bare.append(part == "<g>")
            parts.append("" if bare[-1] else part)
        else:
            parts.append("" if part == "</g>" and bare.pop() else part)
    return re.sub(r">\n+<", "><", "".join(parts))


def _styles_once(svg: str) -> str:
    """Replace styles that several elements share by classes of a style sheet."""
    counts = Counter(re.findall(r'style="([^"]*)"', svg))
    names = {style: f"c{i}" for i, style in enumerate(style for style, count in counts.items() if count > 1)}
    svg = re.sub(r'style="([^"]*)"', lambda m: f'class="{names[m[1]]}"' if m[1] in names else m[0], svg)
    sheet = "".join(f".{name}{{{style}}}\n" for style, name in names.items())
    return svg.replace("</style>", f"\n{sheet}</style>", 1)
