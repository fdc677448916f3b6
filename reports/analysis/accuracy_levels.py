"""Which accuracy a ladder has reached, and which only a lucky rung met.

The error of one number, such as the time of an event, changes its sign where it likes: a coarse rung may be right by
chance. So a rung is worth the largest error, doubt of the reading included, that it or any finer rung has; a finer rung
whose motion is wrong leaves it worth nothing. Rungs without a motion (refused, crashed, timed out) say nothing here:
they have rows of their own.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, isfinite, nan
from typing import NamedTuple

from ..running.records import Run, Truth
from . import quantities

# The accuracies that are asked for: what a game, a robot and a numerical analyst would want, and what is left.
ACCURACIES = (1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12)


class Rung(NamedTuple):
    """What a rung of a ladder is worth: its error, the doubt of its reading, the largest sum of both at this rung and
    all finer ones (infinite if the motion of one of them is wrong), and how many finer rungs there are to tell."""

    error: float
    doubt: float
    standing: float
    finer: int


def rungs(ladder: Sequence[Run], quantity: str) -> list[Rung | None]:
    """Of each run of a ladder, coarse to fine, what it is worth; None where it is not right or tells no error."""
    found: list[Rung | None] = []
    worst, finer = 0.0, 0
    for run in reversed(ladder):
        rung = None
        size = quantities.error(run, quantity) if run.outcome == "right" else nan
        if isfinite(size):
            doubt = quantities.doubt(run, quantity)
            worst = max(worst, size + doubt)
            rung = Rung(size, doubt, worst, finer)
        elif run.outcome == "wrong":
            worst = inf
        finer += rung is not None or run.outcome == "wrong"
        found.append(rung)
    return found[::-1]


def finest_level(ladder: Sequence[Run], quantity: str, truth: Truth) -> float:
    """The finest of the accuracies that the ladder reached, NaN where it reached none. No truth is better than ten
    times its bar."""
    floor = quantities.ABOVE * quantities.bar(truth, quantity, {})
    # What a ladder reached at all, its finest rung has.
    standing = min((rung.standing for rung in rungs(ladder, quantity) if rung), default=inf)
    return min((level for level in ACCURACIES if max(standing, floor) <= level), default=nan)
