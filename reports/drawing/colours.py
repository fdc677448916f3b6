"""The colour and marker of each solver in all figures and on the page, and the colours of grades.

The suite's own solvers have fixed ones, so that they mean the same in every report. On a light background, the
engines' colours are Okabe and Ito's ("Color Universal Design", 2008). Those for a dark background and for further
solvers were computed: the same hue, and every pair as distinct as possible for readers who lack one kind of cone. The
tests measure this.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import cycle
from typing import Any, NamedTuple

from ..running.names import REFERENCE


class Colour(NamedTuple):
    """A solver's colour on a light and on a dark background."""

    light: str
    dark: str


# Backgrounds of the page: figures are drawn on the light one.
GROUND = Colour("#ffffff", "#14181d")
TRUTH = Colour("#000000", "#ffffff")
FIXED_COLOURS = {
    REFERENCE: Colour("#33475b", "#ddeeff"),
    "box2d": Colour("#009e73", "#2ef29a"),
    "exudyn": Colour("#0072b2", "#2080ff"),
    "pybullet": Colour("#cc79a7", "#c06090"),
    "pymunk": Colour("#d55e00", "#ff5018"),
}
# Colours of other solvers in alphabetical order: third-party adapters, exported motions.
OTHERS = (Colour("#3a1fd0", "#c9a6ff"), Colour("#552200", "#b87a4a"), Colour("#4f5300", "#f2ee3c"))
# Markers by Matplotlib's names; other solvers have the last one.
MARKERS = {REFERENCE: "s", "box2d": "^", "exudyn": "o", "pybullet": "v", "pymunk": "D"}
_OTHER_MARKERS = ("P", "X")

# Grades from pale to dark, in a grey that is no solver's colour and that every reader sees.
GRADES = {
    "excellent": "#f3f1ec",
    "very good": "#e3e0d8",
    "good": "#d0ccc1",
    "rough": "#bab5a7",
    "poor": "#a29c8c",
    "unusable": "#878070",
    "not decided": "#d3cfdc",
}


def colours(solvers: Iterable[str]) -> dict[str, Colour]:
    """The colour of each solver. More than three unknown solvers share colours; their markers may differ."""
    names = set(solvers)
    others = zip(sorted(names - FIXED_COLOURS.keys()), cycle(OTHERS), strict=False)
    return {name: FIXED_COLOURS[name] for name in FIXED_COLOURS if name in names} | dict(others)


def identifier(name: str) -> str:
    """A solver's name with only the characters that a CSS identifier allows."""
    return "".join(c if c.isascii() and (c.isalnum() or c in "_-") else "_" for c in name)


_DASHES: tuple[Any, ...] = ("-", (0, (4, 1.5)), (0, (1, 1.2)), (0, (6, 1.5, 1, 1.5)))


class LineStyles:
    """Colour and marker by solver, dashes by route; the same in every figure, whichever solvers are present."""

    def __init__(self, routes: Iterable[tuple[str, str]]):
        """`routes`: pairs of solver and route, each solver's routes in its own order."""
        self._routes: dict[str, list[str]] = {}
        for solver, route in routes:
            routes_of_solver = self._routes.setdefault(solver, [])
            if route and route not in routes_of_solver:
                routes_of_solver.append(route)
        self._colours = colours(self._routes)
        others = zip(sorted(self._routes.keys() - MARKERS.keys()), cycle(_OTHER_MARKERS), strict=False)
        self._markers = MARKERS | dict(others)

    def colour(self, solver: str) -> str:
        """The solver's colour on a light background."""
        return self._colours[solver].light

    def line(self, solver: str, route: str) -> dict[str, Any]:
        """Colour and dashes, as keywords of `plot`."""
        return {"color": self.colour(solver), "linestyle": _DASHES[self._place(solver, route) % len(_DASHES)]}

    def is_dashed(self, solver: str, route: str) -> bool:
        """Whether the line of a route is dashed: of a solver's first route it is not."""
        return bool(solver) and self._place(solver, route) > 0

    def marker(self, solver: str) -> str:
        """The solver's marker."""
        return self._markers[solver]

    def _place(self, solver: str, route: str) -> int:
        return self._routes[solver].index(route) if route else 0
