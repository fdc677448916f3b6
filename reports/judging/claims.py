"""Whether the modes that a solver names are those of its own samples. Pure functions; SI units."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cases import Mode, Trajectory

from . import doubts
from .phases import phases_of
from .slip_phases import RESOLVABLE_GAPS, ROUNDING, SURELY


def claims_hold(motion: Trajectory) -> bool:
    """Whether the modes that a motion's solver names are those of its own samples: it slips nowhere by more than twice
    its creep where it is said to roll, and nowhere the other way where it is said to slip, except next to a change.

    True for a motion that names none, and for one that is known at every time."""
    if motion.first_mode is None or motion.dense is not None:
        return True
    least, end = RESOLVABLE_GAPS * doubts.gap(motion), float(motion.t[-1])
    signs = {Mode.ROLL: 0.0, Mode.REST: 0.0, Mode.SLIP_FORWARD: 1.0, Mode.SLIP_BACKWARD: -1.0}
    phases = [p for p in phases_of(motion.first_mode, motion.transitions, end) if p.mode in signs]
    inside = [(motion.t > p.begin + least) & (motion.t < p.end - least) & np.isfinite(motion.slip) for p in phases]
    rolls = np.abs(motion.slip[_any(motion, [i for p, i in zip(phases, inside, strict=True) if not signs[p.mode]])])
    creep = float(np.quantile(rolls, 0.5)) if len(rolls) else 0.0
    largest = SURELY * max(creep, motion.slip_resolution, ROUNDING * float(np.hypot(motion.vx, motion.vy).max()))
    wrong = [
        (np.abs(motion.slip[i]) > largest) & (np.sign(motion.slip[i]) != signs[phase.mode])
        for phase, i in zip(phases, inside, strict=True)
    ]
    return sum(int(samples.sum()) for samples in wrong) <= RESOLVABLE_GAPS


def _any(motion: Trajectory, groups: Sequence[np.ndarray]) -> np.ndarray:
    return np.logical_or.reduce(groups) if groups else np.zeros(len(motion.t), dtype=bool)
