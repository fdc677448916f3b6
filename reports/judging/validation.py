"""Whether what a solver hands back is a motion at all, and one that is told well enough to be judged.

Pure functions of trajectories. What fails `sound` is no motion; what `untold` or `jumps` say makes one wrong, whatever
its transitions.
"""

from __future__ import annotations

from itertools import pairwise
from math import isfinite

import numpy as np

from cases import Case, Trajectory

# Squares of what is drawn and compared have to be doubles.
LARGEST = 1e100
# A motion covers the truth's time if it ends no more than this many of its own steps from the ends of that.
LAST_STEPS = 2.5
# A stretch without samples is none that a solver left out if it is shorter than this many of its steps, or than this
# part of the motion.
LONG_STEPS, SHORT_PART = 10.0, 0.02
# Between two samples a centre moves by what the true motion's fastest speed explains, three times over (an engine may
# be off by its impacts), or by a tenth of the plate (a contact that pushes the plate out of its track).
FASTER, PUSHED = 3.0, 0.1

# What a run gave that is not `sound`.
UNSOUND = "numbers that are not finite or beyond all sizes, times that do not grow, or one sample only"


def sound(motion: Trajectory) -> bool:
    """Whether it is a motion: finite numbers of ordinary size, times that do not go back, transitions in order, and
    more than one sample unless it ends where it begins."""
    names = ("t", "x", "y", "theta", "vx", "vy", "omega")
    finite = all(bool(np.all(np.abs(getattr(motion, name)) <= LARGEST)) for name in names)  # NaN is not
    # In flight there is no slip, and then no place of contact either.
    finite = finite and bool(np.all((np.abs(motion.slip) <= LARGEST) | (np.isnan(motion.slip) & np.isnan(motion.xi1))))
    when = [event.time for event in motion.transitions]
    finite = finite and all(map(isfinite, when)) and all(a <= b for a, b in pairwise(when))
    enough = len(motion.t) > (motion.status == Trajectory.status)
    return finite and enough and bool(np.all(np.diff(motion.t) >= 0))


def untold(motion: Trajectory, begin: float, end: float | None) -> list[str]:
    """Phrases for what it leaves out of the time from `begin` to `end` (None: it may end when it likes), s."""
    if len(motion.t) == 1:
        return []  # it ends where it begins, and says so
    steps = np.diff(motion.t)
    step = float(np.median(steps[steps > 0.0])) if (steps > 0.0).any() else 0.0
    if motion.dense is not None:  # it is known between its steps, however long
        step = float(steps.max())
    missing = []
    if motion.t[0] > begin + LAST_STEPS * step:
        missing.append(f"begins at {motion.t[0]:.6g} s, the truth at {begin:.6g} s")
    if end is not None and motion.t[-1] < end - LAST_STEPS * step:
        missing.append(f"ends at {motion.t[-1]:.6g} s, the truth at {end:.6g} s")
    longest = int(np.argmax(steps))
    if motion.dense is None and steps[longest] > max(LONG_STEPS * step, SHORT_PART * (motion.t[-1] - motion.t[0])):
        missing.append(f"tells nothing between {motion.t[longest]:.6g} s and {motion.t[longest + 1]:.6g} s")
    return missing


def jumps(case: Case, motion: Trajectory, truth: Trajectory, far: float) -> list[str]:
    """Phrases for a centre that moves between two samples as the true motion never does, and for one that comes to lie
    farther from the truth (`far`, m) than that itself ever moves: no better than a plate that stays where it is."""
    fastest = float(np.hypot(truth.vx, truth.vy).max())
    way = np.hypot(np.diff(motion.x), np.diff(motion.y))
    beyond = way - FASTER * fastest * np.diff(motion.t) - PUSHED * case.plate.reach
    told = []
    if len(beyond) and np.max(beyond) > 0.0:
        i = int(np.argmax(beyond))
        told.append(f"jumps by {way[i]:.3g} m at {motion.t[i + 1]:.6g} s")
    moved = float(np.hypot(truth.x - truth.x[0], truth.y - truth.y[0]).max())
    if far > max(moved, case.plate.reach):
        told.append(f"strays {far:.3g} m from the truth, which moves by {moved:.3g} m")
    return told
