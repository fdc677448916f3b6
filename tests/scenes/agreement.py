"""Agreement of the formulations on the whole sequence of a motion: one function for all random scenes."""

from __future__ import annotations

import numpy as np

import reference
from cases import Case
from reference import contact_frame

# Two integrations at 1e-13 over seconds: rounding grows with the motion; a grazing slip loses the square root of it.
TIME, STATE = 1e-8, 1e-6
# Steps of the second formulation per turn of the motion: with 150 it misses a slip of 2.5 ms that a belt's jerk makes.
STEPS_PER_TURN = 400


def check_same_sequence(case: Case, literal: bool = False) -> None:
    """Assert that both formulations (and, with `literal`, the paper's matrix) have the same sequence of modes, the same
    ending, times within TIME (s) and motions within STATE."""
    motion = reference.simulate(case, rtol=1e-13)
    times = np.linspace(0.0, 0.999 * min(case.duration, motion.t[-1]), 9)
    second = contact_frame.solve(case, rtol=1e-13, times=times, steps_per_turn=STEPS_PER_TURN, overlaps=True)
    answers = [(second.transitions, second.status)]
    if literal:
        printed = reference.simulate(case, rtol=1e-10, method="augmented")
        answers.append((printed.transitions, printed.status))
    for transitions, status in answers:
        assert [(t.before, t.after) for t in transitions] == [(t.before, t.after) for t in motion.transitions], case
        assert status == motion.status, case
        late = [abs(a.time - b.time) for a, b in zip(transitions, motion.transitions, strict=True)]
        assert max(late, default=0.0) <= TIME, case
    state = motion(times)
    rows = np.array([getattr(state, name) for name in contact_frame.MOTION])
    assert np.nanmax(np.abs(rows - second.motions)) <= STATE, case
