"""Which of the samples with a small gap a contact is closed in. Pure functions of arrays (n,); gaps in metres."""

from __future__ import annotations

import numpy as np

# An opening of so many samples has one at most whose gap is known to grow.
SHORT_OPENING = 2
# A hop is lower than the one before it; after so many rounds none is left that samples could show.
MOST_ROUNDS = 50


def touching(gap: np.ndarray, closed: np.ndarray, rounding: float) -> np.ndarray:
    """The samples of each closed range whose gap is at most twice (noise) the largest one of its middle half, or zero
    within `rounding` (m).

    An opening under a force that fades grows as t³: a lift-off with a jerk of 10 m/s³ takes 30 ms for 50 µm.
    """
    result = closed.copy()
    for start, stop in ranges(closed):
        quarter = (stop - start) // 4
        level = max(rounding, 2.0 * float(np.max(gap[start + quarter : stop - quarter])))
        result[start:stop] = gap[start:stop] <= level
    return result


def by_gap(gap: np.ndarray, closed: np.ndarray, rounding: float) -> np.ndarray:
    """The closed samples by the gap alone: those `touching` in each range that is left of one, until no more are open
    (a plate that hops to rest does so ever lower), and openings between them that are too short to be more than noise.
    """
    for _ in range(MOST_ROUNDS):
        fewer = touching(gap, closed, rounding)
        if np.array_equal(fewer, closed):
            break
        closed = fewer
    return lasting(closed)


def lasting(closed: np.ndarray) -> np.ndarray:
    """The closed samples, and openings between them that are too short to be more than noise.

    All openings would be too many: a block that rocks to rest lifts its corners in turn by less than what a solver's
    penalty leaves.
    """
    result = closed.copy()
    for start, stop in ranges(~closed):
        if 0 < start and stop < len(closed) and stop - start <= SHORT_OPENING:
            result[start:stop] = True
    return result


def ranges(closed: np.ndarray) -> list[tuple[int, int]]:
    """The first sample of each range of closed samples, and the one after its last."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], closed, [False]]).astype(int))).tolist()
    return list(zip(edges[::2], edges[1::2], strict=True))


def from_first_to_last(closed: np.ndarray, pushing: np.ndarray) -> np.ndarray:
    """Each range of samples with a small gap, without what is before its first push and after its last one."""
    result = np.zeros(len(closed), dtype=bool)
    for start, stop in ranges(closed):
        pushes = start + np.flatnonzero(pushing[start:stop])
        if len(pushes):
            result[pushes[0] : pushes[-1] + 1] = True
    return result
