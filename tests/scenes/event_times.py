"""How well a motion's events are known where impacts amplify every difference, and whether two motions agree so far.

Over ripples each impact multiplies an earlier difference by up to ten: roundings of places at the first impacts, and of
the argument of the ripples' sine, move later ones by microseconds. (Flights 608 and 819, computed impact by impact with
45 digits: both formulations' errors grow as the effect of a small change of the start.)
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import reference
from cases import Case, Trajectory

# Times agree to KNOWN (s) where neither roundings nor tolerances move them. NUDGE is the change of the start's speeds
# whose effect shows the amplification, some ten roundings of a place at the first impact; an event that it moves by
# UNKNOWN (s) and all later ones are not compared.
KNOWN, NUDGE, UNKNOWN = 1e-9, 1e-12, 1e-6

# The times (s) of transitions and of the end, and what each is.
Events = list[tuple[float, str]]


def events(transitions, end: float, status: str) -> Events:
    """The events of a motion."""
    return [*((e.time, f"{e.before} > {e.after}") for e in transitions), (float(end), status)]


def agree_as_known(case: Case, motion: Trajectory, ours: Events, theirs: Events) -> bool:
    """Whether two lists of events have the same kinds and times, as far as those are known; `ours` are `motion`'s."""
    if _same(ours, theirs) == len(ours) == len(theirs) and np.all(_apart(ours, theirs) <= KNOWN):
        return True
    bars = _bars(case, motion)[: len(ours)]
    bars = bars[bars <= UNKNOWN]
    if len(bars) == len(ours) != len(theirs):
        return False
    return _same(ours, theirs) >= len(bars) and bool(np.all(_apart(ours, theirs)[: len(bars)] <= bars))


def _same(ours: Events, theirs: Events) -> int:
    """The number of events until the first that differ in kind."""
    pairs = enumerate(zip(ours, theirs, strict=False))
    return next((i for i, (a, b) in pairs if a[1] != b[1]), min(len(ours), len(theirs)))


def _apart(ours: Events, theirs: Events) -> np.ndarray:
    """The differences of the events' times, s."""
    return np.array([abs(a[0] - b[0]) for a, b in zip(ours, theirs, strict=False)])


def _bars(case: Case, motion: Trajectory) -> np.ndarray:
    """How well the time of each event is known (s): by a rougher tolerance, and by a start that differs a little."""
    ours, start, part = events(motion.transitions, motion.t[-1], motion.status), case.start, 1.0 + NUDGE
    nudged = replace(start, slip=start.slip * part, gap_rate=start.gap_rate / part, omega=start.omega * part)
    moved = np.zeros(len(ours))
    for other, rtol in ((case, 1e-12), (replace(case, start=nudged), 1e-13)):
        rough = reference.simulate(other, rtol=rtol)
        theirs = events(rough.transitions, rough.t[-1], rough.status)
        same = _same(ours, theirs)
        moved[:same] = np.maximum(moved[:same], _apart(ours, theirs)[:same])
        moved[same:] = np.inf
    return KNOWN + 10.0 * np.maximum.accumulate(moved)
