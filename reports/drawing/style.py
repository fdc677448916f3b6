"""How figures look beside `cases.pictures.style`: a colour for each solver, dashes and a marker for each route.

They are the same in every figure of every report.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from cases.pictures.style import FAINT, STYLE

from ..running.records import Experiment
from .colours import TRUTH as _TRUTH
from .colours import colours

__all__ = ["FAINT", "POINTS", "STYLE", "TRUTH", "Looks", "logarithmic", "looks_of", "ordinal"]

TRUTH = _TRUTH.light
_DASHES: tuple[Any, ...] = ("-", (0, (4, 1.5)), (0, (1, 1.2)), (0, (6, 1.5, 1, 1.5)))
_MARKERS = ("o", "s", "^", "D")
# Points along a line: more than a panel of some 270 points' width needs, so that the page stays light.
POINTS = 150
# Marks on a logarithmic axis.
_MARKS = 6


def ordinal(count: int) -> list[str]:
    """Colours for so many things that are no solvers and have an order, such as coefficients of friction."""
    # The yellow end is pale on white.
    return [to_hex(colormaps["cividis"](0.85 * i / max(count - 1, 1))) for i in range(count)]


class Looks:
    """Colour by solver, dashes and marker by route: the same in every figure, whichever solvers took part."""

    def __init__(self, routes: Iterable[tuple[str, str]]):
        """`routes`: who takes part, as solver and route, each solver's routes in its own order."""
        self._routes: dict[str, list[str]] = {}
        for solver, route in routes:
            known = self._routes.setdefault(solver, [])
            if route and route not in known:
                known.append(route)
        self._colours = colours(self._routes)

    def colour(self, solver: str) -> str:
        """The solver's colour."""
        return self._colours[solver].light

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
