"""Agreement of the formulations on the whole sequence of a motion: one function for all random scenes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import remainder

import numpy as np
import pytest

import reference
from cases import Case, Trajectory, Transition
from cases.motion.trajectory import CONTACT
from cases.scene.free_plates import names_of, plates_of
from reference.certification.witnesses import _by_second
from reference.endings import CAUSES
from tests.scenes import second as second_states

# Two integrations at 1e-13 over seconds: rounding grows with the motion; a grazing slip loses the square root of it.
TIME, STATE = 1e-8, 1e-6


def check_same_sequence(case: Case, literal: bool = False) -> None:
    """Assert that both formulations have the same sequence of modes, the same ending, times within TIME (s) and motions
    within STATE; with `literal`, also the paper's matrix and the eliminated equations.

    The matrix is slow, takes 1e-10, and is compared with the eliminated equations by the same steps. A motion of 1e-13
    may differ by more: by 1.4e-8 s where the last bounce of an ellipse on a shaken wave is 9.8e-8 s later for a start
    that is 1e-8 m farther. By the same steps the two differ by 7.6e-14 s there.
    """
    motion = reference.simulate(case, rtol=1e-13)
    problem = _difference_of_second(case, motion)
    assert not problem, f"second formulation: {problem}: {case}"
    if literal:
        printed, eliminated = (reference.simulate(case, rtol=1e-10, method=m) for m in ("augmented", "dop853"))
        problem = _difference_of_sequence(eliminated, printed)
        assert not problem, f"paper's matrix: {problem}: {case}"


def _difference_of_second(case: Case, motion: Trajectory) -> str:
    """How the second formulation's motion differs; "" if it agrees."""
    times = np.linspace(0.0, 0.999 * min(case.duration, motion.t[-1]), 9)
    second = second_states.solve(case, rtol=1e-13, times=times)
    problem = _difference_of_sequence(motion, second)
    if problem:
        return problem
    if abs(second.end - motion.t[-1]) > TIME:
        return f"it ends at {second.end:.12g} s instead of {motion.t[-1]:.12g} s"
    state = motion(times)
    rows = np.array([getattr(state, name) for name in second_states.MOTION])
    distance = np.abs(rows - second.motions)
    both = ~np.isnan(distance)
    worst = float(np.max(distance, where=both, initial=0.0))
    return f"its motion is {worst:.3g} away" if worst > STATE else ""


def _difference_of_sequence(motion: Trajectory, other) -> str:
    """How transitions and status of another motion differ; "" if they agree."""
    here, there = ([(t.before, t.after) for t in each.transitions] for each in (motion, other))
    if here != there:
        return f"its modes are {there} instead of {here}"
    if other.status != motion.status:
        return f"its status is {other.status} instead of {motion.status}"
    late = [abs(a.time - b.time) for a, b in zip(other.transitions, motion.transitions, strict=True)]
    return f"a transition is {max(late):.3g} s away" if max(late, default=0.0) > TIME else ""


# Impacts within this time (s) before bouncing comes to rest close with about a thousandth of the largest speed: which
# of them are small, and so not listed, depends on where a formulation begins to count.
SMALL_IMPACTS = 2e-3


def check_several_contacts(case: Case) -> Trajectory:
    """Assert that both formulations of a motion with several contacts have the same transitions, end and poses; returns
    the motion. Transitions are compared by time and place: the second formulation numbers contacts otherwise."""
    motion, second = reference.simulate(case, rtol=1e-13), _by_second(case, "second", 1e-12)
    assert motion.status == second.status
    assert motion.t[-1] == pytest.approx(second.end, abs=1e-9)
    outlines = {name: plate.outline for name, plate in zip(names_of(case), plates_of(case), strict=True)}
    rests = [t.time for t in motion.transitions if t.cause == CAUSES["rest"]]
    ours, theirs = (in_order(each, rests) for each in (motion.transitions, second.transitions))
    assert [(t.before, t.after) for t in ours] == [(t.before, t.after) for t in theirs]
    for a, b in zip(ours, theirs, strict=True):
        assert a.time == pytest.approx(b.time, abs=1e-9)
        off = a.xi1 - b.xi1
        if (base := curve_of(a).partition("/")[2]) in outlines:  # up to whole rounds of the outline
            off = remainder(off, outlines[base].span[1] - outlines[base].span[0])
        assert abs(off) < 1e-7
        assert curve_of(a) == curve_of(b)
    times = float(motion.t[-1]) * np.array([0.3, 0.6, 0.9]) if motion.t[-1] else np.empty(0)
    poses, states = motion(times), second_states.poses(case, times, 1e-12)
    for name, row in zip(("x", "y", "theta"), states[:3] if len(times) else (), strict=False):
        np.testing.assert_allclose(getattr(poses, name), row, rtol=0.0, atol=1e-8)
    return motion


def curve_of(transition: Transition) -> str:
    """The couple of a contact; one that is the only one may have no name."""
    return (transition.contact or CONTACT).partition(" ")[0]


def in_order(transitions: Iterable[Transition], rests: Sequence[float]) -> list[Transition]:
    """Transitions by time, those of one instant by contact's curve and place, without small impacts before `rests`."""
    some = [t for t in transitions if not any(-SMALL_IMPACTS < t.time - rest < -1e-9 for rest in rests)]
    result, begin = list[Transition](), 0
    for k, one in enumerate(some):
        if k + 1 == len(some) or some[k + 1].time - one.time > 1e-9:
            result += sorted(some[begin : k + 1], key=lambda t: (curve_of(t), round(t.xi1, 6)))
            begin = k + 1
    return result
