"""One colour a solver, in every figure and on the page; the only place that says which.

The suite's own solvers have fixed colours, so that a colour means the same in every report. Those of the engines on a
light ground are Okabe and Ito's ("Color Universal Design", 2008). The dark ones, and those of further solvers, were
searched for: of the same hue, and every pair as far apart as can be for readers who lack one kind of cone. The tests
measure it.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import cycle
from typing import NamedTuple

from ..running.records import REFERENCE


class Colour(NamedTuple):
    """A solver's colour on a light ground and on a dark one."""

    light: str
    dark: str


# The ground a page has: figures are drawn on the light one.
GROUND = Colour("#ffffff", "#14181d")
TRUTH = Colour("#000000", "#ffffff")
OWN = {
    REFERENCE: Colour("#33475b", "#ddeeff"),
    "box2d": Colour("#009e73", "#2ef29a"),
    "exudyn": Colour("#0072b2", "#2080ff"),
    "pybullet": Colour("#cc79a7", "#c06090"),
    "pymunk": Colour("#d55e00", "#ff5018"),
}
# For whatever else takes part, in alphabetical order: an adapter of somebody's, an exported motion.
OTHERS = (Colour("#3a1fd0", "#c9a6ff"), Colour("#552200", "#b87a4a"), Colour("#4f5300", "#f2ee3c"))


def colours(solvers: Iterable[str]) -> dict[str, Colour]:
    """The colour of each solver. More than three that the suite does not know share colours: their markers differ."""
    known = set(solvers)
    others = zip(sorted(known - OWN.keys()), cycle(OTHERS), strict=False)
    return {name: OWN[name] for name in OWN if name in known} | dict(others)
