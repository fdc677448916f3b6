"""How figures look and are written: colours by solver, dashes by route, small SVG files whose text stays text.

Colour tells the solver (Okabe and Ito's palette, safe for the colour-blind), dashes and markers the route, the same in
every figure of a report. Matplotlib without a display.
"""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass
from html import escape
from io import StringIO
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")

from matplotlib import pyplot as plt  # noqa: E402
from matplotlib.axes import Axes  # noqa: E402
from matplotlib.figure import Figure  # noqa: E402
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator  # noqa: E402

import adapters  # noqa: E402

from ..running.records import REFERENCE, Experiment, Run  # noqa: E402

# Okabe & Ito, "Color Universal Design" (2008), without the yellow, which is pale on white.
PALETTE = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00")
TRUTH, FAINT = "#000000", "#8a8a8a"
_REFERENCE = "#4d4d4d"
_DASHES: tuple[Any, ...] = ("-", (0, (4, 1.5)), (0, (1, 1.2)), (0, (6, 1.5, 1, 1.5)))
_MARKERS = ("o", "s", "^", "D")
# Points along a line: more than a panel of some 270 points' width needs, so that the page stays light.
POINTS = 200
# Marks on a logarithmic axis.
_MARKS = 6
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
    "path.simplify": True,
    "path.simplify_threshold": 0.2,  # of a point: less than a line's width by far
}
# Whoever lacks Matplotlib's own typeface sees one as wide.
_TYPEFACES = "DejaVu Sans, Verdana, sans-serif"


@dataclass(frozen=True)
class Drawn:
    """A figure that was written: its file's name without ending ("" if it failed), the case's label ("" for all), title
    and caption."""

    name: str
    case: str
    title: str
    caption: str


class Looks:
    """Colour by solver, dashes and marker by route, the same in every figure, whichever solvers took part."""

    def __init__(self, experiment: Experiment):
        solvers = sorted({run.solver for run in experiment.runs}.union(adapters.engines()) - {REFERENCE})
        self._colours = {REFERENCE: _REFERENCE} | {s: PALETTE[i % len(PALETTE)] for i, s in enumerate(solvers)}
        self._routes: dict[str, list[str]] = {}
        for run in experiment.runs:
            known = self._routes.setdefault(run.solver, [])
            if run.route and run.route not in known:
                known.append(run.route)

    def colour(self, run: Run) -> str:
        """The solver's colour."""
        return self._colours[run.solver]

    def line(self, run: Run) -> dict[str, Any]:
        """Colour and dashes, as keywords of `plot`."""
        return {"color": self.colour(run), "linestyle": _DASHES[self._place(run) % len(_DASHES)]}

    def marker(self, run: Run) -> str:
        """The route's marker."""
        return _MARKERS[self._place(run) % len(_MARKERS)]

    def _place(self, run: Run) -> int:
        return self._routes[run.solver].index(run.route)


def logarithmic(ax: Axes, which: str) -> None:
    """Logarithmic axes ("x", "y" or both) with a few plain marks: 1, 0.1, 10⁻²."""
    for name in which:
        ax.set(**{f"{name}scale": "log"})
        axis = ax.xaxis if name == "x" else ax.yaxis
        axis.set_major_locator(LogLocator(numticks=_MARKS))
        axis.set_major_formatter(FuncFormatter(_power))
        axis.set_minor_locator(NullLocator())


_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def _power(value: float, _position: int | None = None) -> str:
    mantissa, exponent = f"{value:.0e}".split("e")
    power = int(exponent)
    # Powers of ten alone: where an axis spans less than one there are others, which are written out.
    return f"{value:g}" if mantissa != "1" or abs(power) < 2 else "10" + str(power).translate(_RAISED)


def file_name(label: str) -> str:
    """A case's label as part of a file name."""
    return "".join(c if c.isalnum() or c in "._-" else "_" for c in label).strip("_")


def save(figure: Figure, folder: Path, name: str, case: str, title: str, caption: str, png: bool = False) -> Drawn:
    """Write NAME.svg into the folder (and NAME.png) and forget the figure."""
    text = StringIO()
    figure.savefig(text, format="svg", metadata={"Date": None, "Creator": None}, bbox_inches="tight")
    (folder / f"{name}.svg").write_text(small(text.getvalue()), encoding="utf-8")
    if png:
        figure.savefig(folder / f"{name}.png", dpi=160, bbox_inches="tight")
    plt.close(figure)
    return Drawn(name, case, title, caption)


def sign(folder: Path, drawn: Drawn, command: str) -> None:
    """Write into the figure's file by which command it is made again; a figure that failed has none."""
    if not drawn.name:
        return
    file = folder / f"{drawn.name}.svg"
    text = file.read_text(encoding="utf-8")
    start = text.index(">", text.index("<svg")) + 1
    words = f"<desc>{escape(drawn.title)}. Make it again: {escape(command)}</desc>"
    file.write_text(text[:start] + words + text[start:], encoding="utf-8")


def small(svg: str) -> str:
    """The same picture in fewer characters: coordinates to a hundredth of a point, what many parts share said once,
    nothing that only tools read."""
    svg = re.sub(r"<\?xml.*?\?>|<!DOCTYPE.*?>|<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    svg = re.sub(r' d="([^"]*)"', lambda m: f' d="{_path(m[1])}"', svg)
    svg = re.sub(r' (x|y)="([^"]*)"', lambda m: f' {m[1]}="{_short(float(m[2]))}"', svg)
    svg = re.sub(r"\s*\n\s*", "\n", svg)
    svg = re.sub(r'<g id="[^"]*"', "<g", svg)  # groups are named and never referred to
    for place, name in enumerate(dict.fromkeys(re.findall(r' id="([^"]*)"', svg))):
        svg = svg.replace(f'"{name}"', f'"i{place}"').replace(f"#{name}", f"#i{place}")
    svg = re.sub(r'font-family: [^;"]*;? ?|(?<=style="); | transform="rotate\(-?0 [^"]*"', "", svg)
    svg = _styles_once(svg)
    return svg.replace("<svg ", f'<svg font-family="{_TYPEFACES}" ', 1).strip() + "\n"


def _short(value: float) -> str:
    text = f"{value:.2f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def _path(text: str) -> str:
    """A path through the same points; its straight pieces as differences, which take half the characters."""
    words = re.findall(r"[A-Za-z]|-?[0-9.]+(?:e[-+]?[0-9]+)?", text)
    if not set(filter(str.isalpha, words)) <= set("MLz"):
        return re.sub(
            r" (?=[A-Za-z-])|(?<=[A-Za-z]) ", "", " ".join(w if w.isalpha() else _short(float(w)) for w in words)
        )
    told, before, here = [], "", (0.0, 0.0)
    for command, x, y in re.findall(r"([MLz])(?: (\S+) (\S+))?", " ".join(words)):
        if command == "z":
            told.append("z")
        else:
            # Differences of what was written, so that roundings do not add up.
            there = round(float(x), 2), round(float(y), 2)
            shift = there if command == "M" else (there[0] - here[0], there[1] - here[1])
            pair = f"{_short(shift[0])} {_short(shift[1])}".replace(" -", "-")
            letter = "M" if command == "M" else "l" if before != "L" else "" if pair.startswith("-") else " "
            told.append(letter + pair)
            here = there
        before = command
    return "".join(told)


def _styles_once(svg: str) -> str:
    """Styles that several parts have, as classes of a style sheet."""
    counts = Counter(re.findall(r'style="([^"]*)"', svg))
    names = {style: f"c{i}" for i, style in enumerate(style for style, count in counts.items() if count > 1)}
    svg = re.sub(r'style="([^"]*)"', lambda m: f'class="{names[m[1]]}"' if m[1] in names else m[0], svg)
    sheet = "".join(f".{name}{{{style}}}\n" for style, name in names.items())
    return svg.replace("</style>", f"\n{sheet}</style>", 1)
