"""How figures look: colours by solver, dashes by route.

Colour tells the solver (Okabe and Ito's palette, safe for the colour-blind), dashes and markers the route, the same in
every figure of a report.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import cycle
from typing import Any

import matplotlib
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

import adapters

from ..running.records import REFERENCE, Experiment

matplotlib.use("Agg")  # pictures are files: no window is opened

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


class Looks:
    """Colour by solver, dashes and marker by route: the same in every figure, whichever solvers took part.

    Engines have their colours in alphabetical order, what else took part has the colours after theirs.
    """

    def __init__(self, routes: Iterable[tuple[str, str]]):
        """`routes`: who takes part, as solver and route, each solver's routes in its own order."""
        self._routes: dict[str, list[str]] = {}
        for solver, route in routes:
            known = self._routes.setdefault(solver, [])
            if route and route not in known:
                known.append(route)
        engines = adapters.engines()
        others = sorted(self._routes.keys() - {REFERENCE, *engines})
        self._colours = dict(zip((*engines, *others), cycle(PALETTE), strict=False)) | {REFERENCE: _REFERENCE}

    def colour(self, solver: str) -> str:
        """The solver's colour."""
        return self._colours[solver]

    def line(self, solver: str, route: str) -> dict[str, Any]:
        """Colour and dashes, as keywords of `plot`."""
        return {"color": self.colour(solver), "linestyle": _DASHES[self._place(solver, route) % len(_DASHES)]}

    def marker(self, solver: str, route: str) -> str:
        """The route's marker."""
        return _MARKERS[self._place(solver, route) % len(_MARKERS)]

    def _place(self, solver: str, route: str) -> int:
        return self._routes[solver].index(route)


def looks_of(experiment: Experiment) -> Looks:
    """How everybody in an experiment looks."""
    return Looks((run.solver, run.route) for run in experiment.runs)


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
