"""The colour of each solver in all figures and on the page.

The suite's own solvers have fixed colours, so that a colour means the same in every report. On a light background, the
engines' colours are Okabe and Ito's ("Color Universal Design", 2008). Those for a dark background and for further
solvers were computed: the same hue, and every pair as distinct as possible for readers who lack one kind of cone. The
tests measure this.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import cycle
from typing import NamedTuple

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


# Grades from blue to vermilion, a scale that colour-blind readers see.
GRADES = {
    "excellent": "#6baed6",
    "very good": "#9ecae1",
    "good": "#d0e4f2",
    "rough": "#fdebd3",
    "poor": "#f9c795",
    "unusable": "#ee8452",
    "not decided": "#d3cfdc",
}


def colours(solvers: Iterable[str]) -> dict[str, Colour]:
    """The colour of each solver. More than three unknown solvers share colours; their markers differ."""
    names = set(solvers)
    others = zip(sorted(names - FIXED_COLOURS.keys()), cycle(OTHERS), strict=False)
    return {name: FIXED_COLOURS[name] for name in FIXED_COLOURS if name in names} | dict(others)
