"""The stretches of track and outline around a pair of nearest points in which no other pair can meet.

Where the outline, grown by the gap, bends more than the track, and both turn little, the outline lies above the track
like a convex graph above a line: it is nearest in one place.
"""

from __future__ import annotations

import numpy as np

from cases import Case
from cases.curves.corner import Corner, Piece

from .boxes import STRAIGHT, Cores
from .curve_pieces import BEND_HIGH, BEND_LOW, TURN, piece_bounds

# Number of tried stretches on each side of a pair: from half of the plate's reach, each half as long as the last.
MOST_TRIES = 20
# If no such stretch is found, as near a place where the plate no longer fits, points closer to the pair than this part
# of the reach count as the pair.
SAME = 1e-6
# A corner is a circle of the radius of a rounding, in parts of its distance from the centre of mass.
SHARPEST = 1e16
# Where the pair moves by less than this part of the shortest stretch, a shorter range would prove no more.
STILL = 0.1


def cores(case: Case, xi1: np.ndarray, xi2: np.ndarray, gap: np.ndarray) -> tuple[Cores, np.ndarray]:
    """The cores around n pairs whose parameters stay within `xi1` and `xi2`, (2, n), and whose gap (m) is at most that,
    (n,); and which of them shorter ranges may still prove. Cores that are not proven contain only the pair itself."""
    n, reach = len(gap), case.plate.reach
    lengths = np.append(reach * 0.5 ** np.arange(1, MOST_TRIES + 1), SAME * reach)
    track, outline = (_widen(curve, ends, lengths) for curve, ends in ((case.track, xi1), (case.plate.outline, xi2)))
    t = piece_bounds(case.track, *track.reshape(2, -1))
    if isinstance(case.plate.outline, Corner):
        turns, bend = 2.0 * t[TURN], np.full(t.shape[1], SHARPEST / reach)
    elif case.plate.radius is not None:
        turns, bend = 2.0 * t[TURN], np.full(t.shape[1], 1.0 / case.plate.radius)
    else:
        o = piece_bounds(case.plate.outline, *outline.reshape(2, -1))
        turns, bend = t[TURN] + o[TURN], o[BEND_LOW]
    gaps = np.tile(gap, len(lengths))
    with np.errstate(all="ignore"):
        steep = np.cos(np.minimum(turns, STRAIGHT)) ** -3
        outer_bend = np.where(bend * gaps > -1.0, bend / (1.0 + bend * gaps), -np.inf)
        alone = outer_bend * np.where(outer_bend < 0.0, steep, 1.0) > t[BEND_HIGH] * np.where(
            t[BEND_HIGH] > 0.0, steep, 1.0
        )
    alone = (alone & (turns < STRAIGHT)).reshape(len(lengths), n)
    proven = alone.any(axis=0)
    first = np.where(proven, np.argmax(alone, axis=0), len(lengths) - 1)
    which = np.arange(n)
    moves = np.maximum(_lengths(case.track, xi1), _lengths(case.plate.outline, xi2)) > STILL * lengths.min()
    return Cores(track[:, first, which], outline[:, first, which]), moves & ~proven


def _lengths(curve: Piece, ends: np.ndarray) -> np.ndarray:
    """The lengths (m) of ranges (2, n) of a parameter."""
    return np.asarray((ends[1] - ends[0]) * curve.speed(ends.mean(axis=0)))


def _widen(curve: Piece, ends: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """Ranges (2, n) of a parameter, widened on both sides by each of some lengths (m): (2, lengths, n). A corner has no
    length."""
    speed = np.ones(ends.shape[1]) if isinstance(curve, Corner) else np.asarray(curve.speed(ends.mean(axis=0)))
    wide = lengths[:, None] / speed
    return np.array([ends[0] - wide, ends[1] + wide])
