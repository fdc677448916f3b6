"""Line styles: a colour for each solver, dashes and a marker for each route, the same in all figures of all reports.

This module does not select a Matplotlib backend: a notebook may already have one.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from ..running.records import Experiment
from .colours import colours

_DASHES: tuple[Any, ...] = ("-", (0, (4, 1.5)), (0, (1, 1.2)), (0, (6, 1.5, 1, 1.5)))
_MARKERS = ("o", "s", "^", "D")
# Largest number of ticks on a logarithmic axis.
_MARKS = 6


class LineStyles:
    """Colour by solver, dashes and marker by route; the same in every figure, whichever solvers are present."""

    def __init__(self, routes: Iterable[tuple[str, str]]):
        """`routes`: pairs of solver and route, each solver's routes in its own order."""
        self._routes: dict[str, list[str]] = {}
        for solver, route in routes:
            routes_of_solver = self._routes.setdefault(solver, [])
            if route and route not in routes_of_solver:
                routes_of_solver.append(route)
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


def looks_of(experiment: Experiment) -> LineStyles:
    """The line styles of all solvers and routes of an experiment."""
    return LineStyles((run.solver, run.route) for run in experiment.runs)


class _Powers(LogLocator):
    """Ticks at powers of ten, and also at 2 and 5 times these where the axis has less than two decades."""

    def tick_values(self, vmin: float, vmax: float) -> Sequence[float]:
        self.set_params(subs=(1.0, 2.0, 5.0) if 0.0 < vmax < 100.0 * vmin else (1.0,))
        return super().tick_values(vmin, vmax)


def logarithmic(ax: Axes, which: str) -> None:
    """Make axes ("x", "y" or both) logarithmic with a few plain tick labels: 1, 0.1, 10⁻²."""
    for name in which:
        ax.set(**{f"{name}scale": "log"})
        axis = ax.xaxis if name == "x" else ax.yaxis
        axis.set_major_locator(_Powers(numticks=_MARKS))
        axis.set_major_formatter(FuncFormatter(_power))
        axis.set_minor_locator(NullLocator())


_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def _power(value: float, _position: int | None = None) -> str:
    mantissa, exponent = f"{value:.0e}".split("e")
    power = int(exponent)
    if abs(power) < (2 if mantissa == "1" else 4):
        return f"{value:g}"
    return ("" if mantissa == "1" else f"{mantissa}·") + "10" + str(power).translate(_SUPERSCRIPTS)
