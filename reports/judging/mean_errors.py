"""The mean errors of a motion over the truth's time, also over the time of which it says nothing. SI units."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from cases import Case, Plate, State, Trajectory

from .validation import LAST_STEPS, LONG_STEPS, SHORT_PART, usual_step

# Even times at which a gap between samples is looked at.
_EVEN = 1001


def end_of_samples(motion: Trajectory, end: float) -> float:
    """The end of the time that the motion covers: the truth's, if it comes within a few steps of that, else its own."""
    own = float(motion.t[-1])
    return end if own >= end - LAST_STEPS * usual_step(motion) else own


def sample_gaps(motion: Trajectory) -> list[tuple[float, float]]:
    """The spans at the beginning and between samples, s, of which the motion says nothing."""
    spans, step = [], usual_step(motion)
    if motion.t[0] > LAST_STEPS * step:
        spans.append((0.0, float(motion.t[0])))
    if motion.dense is None:
        long = max(LONG_STEPS * step, SHORT_PART * float(motion.t[-1] - motion.t[0]))
        spans += [(float(motion.t[i]), float(motion.t[i + 1])) for i in np.flatnonzero(np.diff(motion.t) > long)]
    return spans


def _silent_spans(motion: Trajectory, end: float) -> list[tuple[float, float]]:
    """The spans up to the time `end`, s, of which the motion says nothing."""
    gaps, last = sample_gaps(motion), end_of_samples(motion, end)
    return [*gaps, (last, end)] if last < end else gaps


def complete_times(motion: Trajectory, end: float) -> np.ndarray:
    """The times of the motion's samples up to the time `end`, s, and where it says nothing even ones as near to each
    other as its samples are (up to 1001 in a span)."""
    step, times = usual_step(motion), [motion.t]
    for begin, stop in _silent_spans(motion, end):
        count = min((stop - begin) / step, _EVEN) if step > 0.0 else _EVEN
        times.append(np.linspace(begin, stop, int(count) + 1))
    result = np.unique(np.concatenate(times))
    return result[result <= end]


def mean_errors(
    motion: Trajectory, truth: Trajectory, off: Mapping[str, np.ndarray], case: Case
) -> tuple[float, float]:
    """Root-mean-square pose error, m, and mean slip error, m/s, over the truth's time.

    Where the motion says nothing the plate counts as standing still where it was last; where one of both is in flight
    there is no slip error."""
    end, t = float(truth.t[-1]), off["t"]
    gaps = sample_gaps(motion)
    spans = _silent_spans(motion, end)
    square, slip, total = _integrals(t, off["pose"], off["slip"], gaps)
    for begin, stop in spans:
        a, b = min(begin, end), min(stop, end)
        if b > a:
            times = np.linspace(a, b, _EVEN)
            pose, still = _standing(motion, truth, times, begin, case)
            more = _integrals(times, pose, still, [])
            square, slip, total = square + more[0], slip + more[1], total + more[2]
    if total == 0.0:  # the truth ends where it begins
        return float(np.max(off["pose"], initial=0.0)), 0.0
    return float(np.sqrt(square / total)), slip / total


def _integrals(
    t: np.ndarray, pose: np.ndarray, slip: np.ndarray, gaps: Sequence[tuple[float, float]]
) -> tuple[float, float, float]:
    """Integrals over time of the squared pose error and of the size of the slip error, and the time, by trapezoids."""
    h = np.diff(t)
    for begin, stop in gaps:
        h = np.where((t[:-1] >= begin) & (t[1:] <= stop), 0.0, h)
    square, size = pose**2, np.abs(slip)
    slips = 0.5 * (size[:-1] + size[1:])
    return (
        float(np.sum(0.5 * (square[:-1] + square[1:]) * h)),
        float(np.sum(np.where(np.isfinite(slips), slips, 0.0) * h)),
        float(np.sum(h)),
    )


def _standing(
    motion: Trajectory, truth: Trajectory, times: np.ndarray, begin: float, case: Case
) -> tuple[np.ndarray, np.ndarray]:
    """Pose and slip errors at the times of a plate at rest in its last pose before the time `begin`."""
    true = truth(times)
    poses = [_standing_pose(case.plate, motion, truth, true, begin)]
    for other in case.others:
        one, exact = motion.plate(other.name), truth.plate(other.name)
        poses.append(_standing_pose(other.plate, one, exact, exact(times), begin))
    return np.max(poses, axis=0), np.asarray(true.slip)


def _standing_pose(plate: Plate, motion: Trajectory, truth: Trajectory, true: State, begin: float) -> np.ndarray:
    i = max(int(np.searchsorted(motion.t, begin, side="right")) - 1, 0)
    first = truth(float(np.clip(motion.t[0], 0.0, truth.t[-1])))
    turns = 2 * np.pi * np.round((motion.theta[0] - first.theta) / (2 * np.pi))
    angle = motion.theta[i] - turns - np.asarray(true.theta)
    centre = np.hypot(motion.x[i] - np.asarray(true.x), motion.y[i] - np.asarray(true.y))
    return np.hypot(centre, plate.gyration * angle)
