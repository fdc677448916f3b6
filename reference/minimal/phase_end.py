"""The end of a phase: what follows it, its limits, and the guards at the ends of pieces."""

from __future__ import annotations

from math import ceil, log10
from typing import NamedTuple

import numpy as np

from cases.scene.piece_case import PieceCase

from ..endings import COMPLETION, Ending
from .integrators.segment import Segment
from .modes import Regime

# A motion ends where MANY phases together take less than NO_TIME of its time scale, or STUCK in a row no time at all.
MANY, NO_TIME, STUCK = 1000, 1e-9, 50

# Limit on the steps of one run: their record, which is made when samples are requested, fills a gigabyte or two. (A
# hundred thousand changes of a limping wheel take 830,000.)
MOST_STEPS = 1_000_000

# Relative error of an event's location, whatever the tolerance of the motion that led there.
LOCATION_ERROR = 1e-12

# Values within this part of a bound are at it where phases of zero length follow each other: a thousand times the
# location's error.
ROUGH = 1e-9

# From this many phases of zero length in a row (a slip that begins, ends and begins again), values within ROUGH of a
# bound count as being at it.
IDLE = 4


def error_range(error: float) -> list[float]:
    """Relative errors from an event's to that of the motion, by powers of ten."""
    count = 1 + ceil(log10(max(error, LOCATION_ERROR) / LOCATION_ERROR))
    return np.geomspace(LOCATION_ERROR, max(error, LOCATION_ERROR), count).tolist()


# Guards at the ends of a piece: whether it is the track's, and which way the contact leaves it.
PIECE_ENDS = {
    "track_start": (True, -1),
    "track_end": (True, 1),
    "outline_start": (False, -1),
    "outline_end": (False, 1),
}


class Step(NamedTuple):
    """The result of a phase: its segments, time, place (ξ₁, ξ₂) and cause of its end, and the full state and regime
    that follow, or the ending."""

    segments: tuple[Segment, ...]
    time: float
    place: tuple[float, float] = (np.nan, np.nan)
    cause: str = ""
    state: tuple[float, ...] = ()
    regime: Regime | None = None
    ending: Ending = COMPLETION
    is_listed: bool = True  # whether an impact between two flights is listed
    pieces: PieceCase | None = None  # those that the contact passes to
