"""Checks of a motion by itself: whether it is one, which times it leaves out, and where it jumps.

Pure functions of trajectories. A solver's result that is not `sound` is not a motion; `gaps` and `jumps` are remarks in
the reason of a run.
"""

from __future__ import annotations

from itertools import pairwise
from math import isfinite, nan
from typing import NamedTuple

import numpy as np

from cases import Case, Trajectory

# Squares of all compared numbers have to be doubles.
LARGEST = 1e100
# A motion covers the truth's time if it begins and ends within this many of its own steps of the truth's ends.
LAST_STEPS = 2.5
# A time without samples is a gap if it is longer than this many steps of the motion and than this part of its duration.
LONG_STEPS, SHORT_PART = 10.0, 0.02
# Between two samples a centre moves by at most three times the way at the true motion's fastest speed (impacts of an
# engine can be faster), plus a tenth of the plate's size (a contact that pushes the plate out of its track).
FASTER, PUSH = 3.0, 0.1

# Angles, rad: a truth that turns by less does not turn; a plate that turns by more where it does not is said to tip.
STILL, TIPS = 1e-3, 1e-2

# Description of a result that is not `sound`.
UNSOUND = "numbers that are not finite or beyond all sizes, times that do not grow, or one sample only"


class Residuals(NamedTuple):
    """Residuals of a motion; NaN where the motion lacks the quantities for them.

    `energy`: largest of |E(t) − E(0) − work of friction|, over the energy that moves; `energy_drift`: its slope, 1/s;
    `gap`: largest distance of the two reported contact points (5) over the plate's size, `gap_drift` its slope, m/s;
    `tangency`: largest sine between the tangents at the reported contact parameters (6).
    """

    energy: float = nan
    energy_drift: float = nan
    gap: float = nan
    gap_drift: float = nan
    tangency: float = nan


def sound(motion: Trajectory) -> bool:
    """Whether the numbers are finite and of ordinary size, times do not decrease, transitions are in order, and there
    is more than one sample unless the motion ends where it begins."""
    names = ("t", "x", "y", "theta", "vx", "vy", "omega")
    finite = all(bool(np.all(np.abs(getattr(motion, name)) <= LARGEST)) for name in names)  # NaN is not
    # In flight there is no slip, and then no place of contact either.
    finite = finite and bool(np.all((np.abs(motion.slip) <= LARGEST) | (np.isnan(motion.slip) & np.isnan(motion.xi1))))
    when = [event.time for event in motion.transitions]
    finite = finite and all(map(isfinite, when)) and all(a <= b for a, b in pairwise(when))
    enough = len(motion.t) > (motion.status == Trajectory.status)
    return finite and enough and bool(np.all(np.diff(motion.t) >= 0))


def usual_step(motion: Trajectory) -> float:
    """The motion's usual step, s; the longest where it is known between its steps."""
    steps = np.diff(motion.t)
    steps = steps[steps > 0.0]
    if not len(steps):
        return 0.0
    return float(np.median(steps) if motion.dense is None else steps.max())


def gaps(motion: Trajectory, begin: float, end: float | None) -> list[str]:
    """Phrases for the times that the motion leaves out between `begin` and `end`, s (None: it may end at any time)."""
    if len(motion.t) == 1:
        return []  # it ends where it begins, and has that status
    steps, step = np.diff(motion.t), usual_step(motion)
    missing = []
    if motion.t[0] > begin + LAST_STEPS * step:
        missing.append(f"begins at {motion.t[0]:.6g} s, the truth at {begin:.6g} s")
    if end is not None and motion.t[-1] < end - LAST_STEPS * step:
        missing.append(f"ends at {motion.t[-1]:.6g} s, the truth at {end:.6g} s")
    longest = int(np.argmax(steps))
    if motion.dense is None and steps[longest] > max(LONG_STEPS * step, SHORT_PART * (motion.t[-1] - motion.t[0])):
        missing.append(f"has no samples between {motion.t[longest]:.6g} s and {motion.t[longest + 1]:.6g} s")
    return missing


def tips(motion: Trajectory, truth: Trajectory) -> list[str]:
    """A phrase for a plate that turns where the truth does not: by how much, from when to when."""
    inside = motion.t <= truth.t[-1]
    turn = np.abs(motion.theta[inside] - motion.theta[0])
    if np.ptp(truth.theta) > STILL or not np.max(turn, initial=0.0) > TIPS:
        return []
    away = motion.t[inside][turn > STILL]
    return [
        f"turns by up to {np.degrees(turn.max()):.2g} degrees between {away[0]:.4g} s and {away[-1]:.4g} s; "
        "the truth does not turn"
    ]


def jumps(case: Case, motion: Trajectory, truth: Trajectory, far: float) -> list[str]:
    """Phrases for a centre that moves between two samples by more than the true motion explains, and for one whose
    distance from the truth (`far`, m) exceeds the truth's own path: no better than a plate at rest."""
    fastest = float(np.hypot(truth.vx, truth.vy).max())
    lengths = np.hypot(np.diff(motion.x), np.diff(motion.y))
    beyond = lengths - FASTER * fastest * np.diff(motion.t) - PUSH * case.plate.reach
    remarks = []
    if len(beyond) and np.max(beyond) > 0.0:
        i = int(np.argmax(beyond))
        remarks.append(f"jumps by {lengths[i]:.3g} m at {motion.t[i + 1]:.6g} s")
    extent = float(np.hypot(truth.x - truth.x[0], truth.y - truth.y[0]).max())
    if far > max(extent, case.plate.reach):
        remarks.append(f"strays {far:.3g} m from the truth, which moves by {extent:.3g} m")
    return remarks
