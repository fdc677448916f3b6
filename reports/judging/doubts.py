"""The part of a score that may be due to a motion's samples: their spacing in time, and their noise.

A sample is compared with the cubic through its neighbours. The difference is noise, or would be resolved by finer
sampling; in both cases smaller differences are not attributed to the solver.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cases import Mode, Trajectory

from .phases import ModePhase
from .slip_phases import RESOLVABLE_GAPS, Reading

# Three quarters of the samples are no rougher than the roughness: kinks and impacts are fewer than the rest.
_QUANTILE = 0.75
# Slip is certain where it exceeds this many times the roughness: normal noise does so in one of 700 samples.
_CERTAIN = 2.0
# The spread of a transition's time is the smallest that several extrapolations have, so it may be smaller than their
# error; by 1.6 times at most in the catalogue.
_SPREADS = 2.0
# Velocities that agree with central differences of the poses to this part of the fastest are these differences.
_SAME_RATE = 1e-9
# Differences round off the kinks of slip, for all extrapolations alike: their spread is too small by twice as much.
_WIDER = 2.0


def gap(motion: Trajectory) -> float:
    """The time between samples, s, that nine tenths of the motion's do not exceed."""
    return float(np.quantile(np.diff(motion.t), 0.9)) if len(motion.t) > 1 else 0.0


def _residuals(t: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Each value minus the cubic through its two neighbours on each side; NaN where there are fewer."""
    result = np.full(len(t), np.nan)
    if len(t) < 5:
        return result
    nodes = np.stack([t[:-4], t[1:-3], t[3:-1], t[4:]])
    near = np.stack([values[:-4], values[1:-3], values[3:-1], values[4:]])
    middle, cubic = t[2:-2], np.zeros(len(t) - 4)
    with np.errstate(divide="ignore", invalid="ignore"):  # two equal times mark a jump: nothing is smooth there
        for k in range(4):
            others = [j for j in range(4) if j != k]
            cubic += near[k] * np.prod([(middle - nodes[j]) / (nodes[k] - nodes[j]) for j in others], axis=0)
    result[2:-2] = values[2:-2] - cubic
    result[~np.isfinite(result)] = np.nan
    return result


def roughness(t: np.ndarray, values: np.ndarray) -> float:
    """The distance of a quantity's samples from a smooth curve, in its unit; 0 if there are too few samples.

    Noise with the standard deviation s has 1.6 s: the residual's is 1.39 s, and three quarters of a normal distribution
    are within 1.15 of its standard deviations.
    """
    size = np.abs(_residuals(t, values))
    size = size[np.isfinite(size)]
    return float(np.quantile(size, _QUANTILE)) if len(size) else 0.0


def are_differences(motion: Trajectory) -> bool:
    """Whether the velocities are central differences of the poses, to nine digits, and know no more than these."""
    if len(motion.t) < 5 or not np.all(np.diff(motion.t) > 0.0):
        return False
    for rate, pose in (("vx", "x"), ("vy", "y"), ("omega", "theta")):
        values, own = getattr(motion, pose), getattr(motion, rate)[1:-1]
        rounding = 4.0 * np.finfo(float).eps * np.abs(values).max() / np.diff(motion.t).min()
        if not np.all(np.abs(np.gradient(values, motion.t)[1:-1] - own) <= _SAME_RATE * np.abs(own).max() + rounding):
            return False
    return True


def of_differences(motion: Trajectory, reach: float) -> float:
    """The mean error of a slip velocity that follows from differences, m/s, for a plate of this reach (m).

    A difference over two gaps h is the mean of the rate v over them: v + h² v''/6 where v is smooth, and off by h/4
    times the change of v' at a kink. Second differences of v are six times, and twice, as large.
    """
    vx, vy, omega = (np.diff(rate, 2) for rate in (motion.vx, motion.vy, motion.omega))
    errors = 0.5 * (np.hypot(vx, vy) + reach * np.abs(omega))
    return float(errors[np.isfinite(motion.slip[1:-1])].sum()) / len(motion.t)


def time(motion: Trajectory, reading: Reading, reach: float, is_sharp: bool = False) -> float:
    """The sum of the doubts of all transition times of a reading, s.

    Where the reading does not extrapolate (a landing, or a motion that its solver ends), an engine with a fixed step
    has the transition at the end of the step that it falls into: the doubt is the time between the samples around it.
    So it is, at least, where the coefficient of friction changes with the slip speed (`is_sharp`): slip then begins and
    ends within speeds that no sample shows, and not as a polynomial of the samples next to it.
    """
    signals, spreads = {True: reach * motion.omega, False: motion.slip}, _SPREADS
    if are_differences(motion):
        spreads *= _WIDER
    noise = {turns: roughness(motion.t, values) for turns, values in signals.items()}
    total = 0.0
    for event, spread in zip(reading.transitions, reading.spreads, strict=True):
        if event.before is not event.after:
            least = _gap_at(motion.t, event.time) if is_sharp or not np.isfinite(spread) else 0.0
            total += max(spreads * np.nan_to_num(spread), least)
        if Mode.FLIGHT not in (event.before, event.after):
            turns = Mode.REST in (event.before, event.after)
            begins = event.before in (Mode.ROLL, Mode.REST)
            total += _time_below_noise(motion.t, np.abs(signals[turns]), _CERTAIN * noise[turns], event.time, begins)
    return float(total)


def _gap_at(t: np.ndarray, event: float) -> float:
    """The time between the samples around an event, or before it where a sample is at it, s."""
    i = int(np.clip(np.searchsorted(t, event), 1, len(t) - 1))
    return float(t[i] - t[i - 1])


def _time_below_noise(t: np.ndarray, size: np.ndarray, noise: float, event: float, begins: bool) -> float:
    """The time around an event in which the slip is below its noise, s, from a straight line through the nearest sample
    above the noise, or from a parabola where slip begins (slip then grows with the square of time)."""
    above = np.flatnonzero(size > noise)
    if noise == 0.0 or not len(above):
        return 0.0
    place = int(np.searchsorted(t[above], event))
    nearest = above[np.clip([place - 1, place], 0, len(above) - 1)]
    i = int(nearest[np.argmin(np.abs(t[nearest] - event))])
    share = noise / float(size[i])
    return abs(float(t[i]) - event) * (np.sqrt(share) if begins else share)


def unresolved(
    motion: Trajectory, phases: Sequence[ModePhase], slips: Sequence[float], hops: Sequence[float] = ()
) -> float:
    """The total duration, s, of those phases of the truth that a motion's samples cannot resolve: phases and flights
    between impacts (`hops`, s) shorter than a few gaps, and phases whose largest slip (`slips`, m/s) is below the
    noise."""
    least, noise = RESOLVABLE_GAPS * gap(motion), _CERTAIN * roughness(motion.t, motion.slip)
    slow = sum(
        phase.duration
        for phase, largest in zip(phases, slips, strict=True)
        if phase.duration < least or 0.0 < largest < noise
    )
    return slow + sum(hop for hop in hops if hop < least)
