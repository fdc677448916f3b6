"""Phases of slip and roll of one contact, read from its samples, and the transitions between them.

Pure functions of trajectories. The same reading serves every solver that does not locate its transitions itself;
`transitions` splits a motion into contacts and flights. SI units.

Source of the reading's two laws: while slipping, (34) makes v smooth up to its zero, so a branch extrapolates to it;
after the cone saturates at t0, v' grows from zero, so v ~ (t - t0)^2 and sqrt(v) is linear.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from itertools import takewhile
from math import isfinite, nan
from typing import NamedTuple

import numpy as np

from cases import Mode, Trajectory, Transition

# A slip below this part of the motion's speed is rounding for every double-precision solver that sticks exactly: ten
# digits are lost at worst where a slip velocity is the difference of two speeds and a thousand steps add up.
ROUNDING = 1e-9
# Creep stays below the resolution a solver declares while friction is inside its cone; slip surely exceeds its double.
SURELY = 2.0
# A crossing of zero leaves at most one sample in the band and so two gaps between slipping samples; a roll needs more.
# Likewise a slip that lasts less, between others, is the overshoot of one step.
RESOLVABLE_GAPS = 2.5
# Degrees tried for the local polynomial, and widths: so many samples beyond those the degree needs (smooth branches),
# and such parts of the branch (noisy ones, where only many samples average the noise out).
_DEGREES, _SPARE, _PARTS = (1, 2, 3, 4, 5), (1, 3, 12), (16, 6, 3)
# A friction force this close to its bound (relative) may already be the sliding one of a regularised law.
_AT_BOUND = 2e-3


class Reading(NamedTuple):
    """First mode, transitions, and how far each time moves (s) when the samples it was read from are shifted."""

    first_mode: Mode
    transitions: tuple[Transition, ...]
    spreads: tuple[float, ...]


class _Phase(NamedTuple):
    """A stretch of samples with one sign of slip (0: none), as indices [start, stop)."""

    sign: int
    start: int
    stop: int


def read_contact(trajectory: Trajectory, mu: float | None = None) -> Reading:
    """First mode and transitions of one sampled contact, from t, slip, forces and slip_resolution alone.

    The end of slip (to roll, or a reversal) is where the slipping branch, extrapolated by a local polynomial, reaches
    zero; its last sample is left out, since it may straddle the kink. The onset of slip is where |T|/(mu N),
    extrapolated from the rolling branch, reaches one, or where sqrt(|v|), extrapolated back, reaches zero: whichever
    moves less when its samples are shifted. `mu` is the coefficient that bounds stick (0: no friction; None: unknown,
    forces are not used).

    Error on exact samples with n of them in a slip phase of the paper's application (0.6 s): half a gap for n = 8,
    1e-5 s for n = 30, 1e-8 s for n = 125, 1e-11 s for n = 600 (tests/judging/test_slip_phases.py holds it to that);
    noise of size d moves a time by up to some hundred d over the slope of v. A roll shorter than 2.5 samples is not
    seen, nor what would happen after the last of them.
    """
    t, v, force = _samples(trajectory, mu)
    if mu == 0.0:
        return _with_lift_off(Reading(Mode.SLIDE, (), ()), trajectory)
    speed = float(np.max(np.hypot(trajectory.vx, trajectory.vy), initial=0.0))
    band = max(SURELY * trajectory.slip_resolution, ROUNDING * speed)
    phases = _phases(t, v, band)
    events = [_event(t, v, force, a, b, trajectory.slip_resolution, band) for a, b in _pairs(phases)]
    # A slip that falls below what the solver resolves may be so slow that it would end after the last sample.
    events = list(takewhile(lambda event: event[0] <= t[-1], events))
    transitions = tuple(
        Transition(time, _mode(a.sign), _mode(b.sign), cause=cause)
        for (time, _, cause), (a, b) in zip(events, _pairs(phases), strict=False)
    )
    reading = Reading(_mode(phases[0].sign), transitions, tuple(spread for _, spread, _ in events))
    return _with_lift_off(reading, trajectory)


def _samples(trajectory: Trajectory, mu: float | None):
    """Times without doubles, slip, and the cone's use |T|/(mu N) (NaN where it is not known)."""
    keep = np.append(np.diff(trajectory.t) > 0, True)
    normal, friction = trajectory.normal_force[keep], trajectory.friction_force[keep]
    use = np.full(normal.shape, nan)
    if mu:
        is_known = np.isfinite(friction) & (normal > 0)
        use[is_known] = np.abs(friction[is_known]) / (mu * normal[is_known])
    return trajectory.t[keep], trajectory.slip[keep], use


def _with_lift_off(reading: Reading, trajectory: Trajectory) -> Reading:
    if trajectory.status != "lift_off":
        return reading
    last = reading.transitions[-1].after if reading.transitions else reading.first_mode
    end = Transition(float(trajectory.t[-1]), last, Mode.FLIGHT, cause="the normal force vanishes")
    # The solver itself ended the motion there, at one of its own times; nothing was extrapolated.
    return Reading(reading.first_mode, (*reading.transitions, end), (*reading.spreads, nan))


def _mode(sign: int) -> Mode:
    return {1: Mode.SLIP_FORWARD, -1: Mode.SLIP_BACKWARD, 0: Mode.ROLL}[sign]


def _pairs(phases: Sequence[_Phase]):
    return list(zip(phases[:-1], phases[1:], strict=True))


def _phases(t: np.ndarray, v: np.ndarray, band: float) -> list[_Phase]:
    """Slip and roll phases: runs of one sign, without the stretches too short to be a roll."""
    runs = _runs(np.where(np.abs(v) > band, np.sign(v), 0).astype(int))
    signs = [np.full(r.stop - r.start, 0 if _is_overshoot(t, runs, i) else r.sign) for i, r in enumerate(runs)]
    runs = _runs(np.concatenate(signs))
    phases = [run for i, run in enumerate(runs) if run.sign or _is_roll(t, v, runs, i, band)]
    result: list[_Phase] = []
    for run in phases:
        if result and result[-1].sign == run.sign:
            run = _Phase(run.sign, result.pop().start, run.stop)
        result.append(run)
    return result


def _runs(signs: np.ndarray) -> list[_Phase]:
    edges = np.flatnonzero(np.diff(signs)) + 1
    starts, stops = [0, *edges.tolist()], [*edges.tolist(), len(signs)]
    return [_Phase(int(signs[a]), a, b) for a, b in zip(starts, stops, strict=True)]


def _is_overshoot(t: np.ndarray, runs: list[_Phase], i: int) -> bool:
    """Whether a slip between other phases is too short for its samples; at the ends of the motion none is."""
    if not 0 < i < len(runs) - 1:
        return False
    around = t[runs[i].start - 1 : runs[i].stop + 1]
    return bool(around[-1] - around[0] <= RESOLVABLE_GAPS * np.max(np.diff(around)))


def _is_roll(t: np.ndarray, v: np.ndarray, runs: list[_Phase], i: int, band: float) -> bool:
    """Whether the stretch lasts longer than its neighbours' slopes need to cross the band."""
    run, after = runs[i], runs[i + 1] if i + 1 < len(runs) else None
    if after is None:
        return True
    begin, end = max(run.start - 1, 0), run.stop
    crossing = band / _slope(t, v, slice(end, end + 3))
    if i > 0:
        crossing += band / _slope(t, v, slice(max(begin - 2, runs[i - 1].start), begin + 1))
    gap = float(np.max(np.diff(t[begin : end + 1])))
    return bool(t[end] - t[begin] > crossing + RESOLVABLE_GAPS * gap)


def _slope(t: np.ndarray, v: np.ndarray, where: slice) -> float:
    time, value = t[where], np.abs(v[where])
    slope = abs(value[-1] - value[0]) / (time[-1] - time[0]) if len(time) > 1 else 0.0
    return float(slope) or np.inf


def _event(t, v, use, before: _Phase, after: _Phase, resolution: float, band: float) -> tuple[float, float, str]:
    """Time, spread and cause of the change from one phase to the next."""
    if before.sign == 0:
        return _onset(t, v, use, before, after, resolution, band)
    slipping = _slipping(t, v, before, band)
    # Contaminated: the sample that may straddle the kink. Three are kept where there are no more.
    used = slipping[:-1] if len(slipping) > 3 else slipping
    end = t[after.start] + band / _slope(t, v, slice(int(used[-1]) - 1, int(used[-1]) + 1))
    estimate = branch_zero(t[used], np.abs(v[used]), float(end))
    cause = "slip ends" if after.sign == 0 else "slip reverses"
    if estimate is None:
        return (*_between(t, before.stop), cause)
    return (*estimate, cause)


def _slipping(t, v, phase: _Phase, band: float) -> np.ndarray:
    """Indices of the phase's samples that surely slip."""
    index = np.arange(phase.start, phase.stop)
    return index[phase.sign * v[index] > band]


def _onset(t, v, use, before: _Phase, after: _Phase, resolution: float, band: float) -> tuple[float, float, str]:
    estimates, last = [], float(t[before.stop - 1])
    rolling = np.arange(before.start + 1, before.stop - 1)
    at_bound = np.flatnonzero(use[rolling] >= 1.0 - _AT_BOUND)
    # A regularised law stays saturated from here on; an isolated high value earlier is noise and stays in.
    if len(at_bound) and at_bound[-1] == len(rolling) - 1:
        breaks = np.flatnonzero(np.diff(at_bound) > 1)
        rolling = rolling[: at_bound[breaks[-1] + 1] if len(breaks) else at_bound[0]]
    if len(rolling) > 3 and np.all(np.isfinite(use[rolling])):
        zero = branch_zero(t[rolling], 1.0 - use[rolling], float(t[after.start]))
        if zero:
            estimates.append((*zero, "friction reaches its bound"))
    index = np.arange(after.start + 1, after.stop)[::-1]
    # A regularised law's slip grows from its creep, another's from zero; the one that fits moves less.
    for creep in {0.0, resolution} if len(index) > 3 else ():
        zero = branch_zero(-t[index], np.sqrt(np.maximum(np.abs(v[index]) - creep, 0.0)), float(-t[before.start]))
        # Slip that jumps, by an impact elsewhere, does not grow from zero: its branch is above the last rolling sample.
        if zero and _square(last, -zero[0], t[after.start], abs(v[after.start])) <= SURELY * band + creep:
            estimates.append((-zero[0], zero[1], "slip grows from zero"))
    if not estimates:
        return (*_between(t, before.stop), "slip grows from zero")
    return min(estimates, key=lambda estimate: estimate[1])


def _square(time: float, begin: float, end: float, value: float) -> float:
    """The value at a time of what grows with the square of time from zero at `begin` to `value` at `end`."""
    return value * (max(time - begin, 0.0) / (end - begin)) ** 2 if end > begin else 0.0


def _between(t: np.ndarray, i: int) -> tuple[float, float]:
    """The middle of the gap before sample i, where no branch can be extrapolated."""
    return 0.5 * float(t[i - 1] + t[i]), 0.5 * float(t[i] - t[i - 1])


def branch_zero(t: np.ndarray, y: np.ndarray, end: float) -> tuple[float, float] | None:
    """Where the branch y >= 0 reaches zero after its last sample and by about `end`, and how sure that is.

    Local polynomials of several degrees and widths are tried, each on the last samples and on windows an eighth and
    a quarter of their width earlier; the one whose zero moves least is taken, and its movement is the spread.
    None if none has a zero.
    """
    gap = float(t[-1] - t[max(len(t) - 4, 0)]) / min(3, len(t) - 1) if len(t) > 1 else 0.0
    if gap <= 0.0:
        return None
    tau, limit = (t - t[-1]) / gap, (end - float(t[-1])) / gap + 1.0
    best: tuple[float, float] | None = None
    for last, between, earliest in _zeros(tau, y, limit).tolist():
        spread = max(last, between, earliest) - min(last, between, earliest)
        # NaN where a window has no zero.
        if isfinite(last + between + earliest) and (best is None or spread < best[1]):
            best = (last, spread)
    if best is None:
        return _chord(t, y, end)
    return float(t[-1]) + best[0] * gap, best[1] * gap


class _Windows(NamedTuple):
    """The samples that polynomials are fitted to, for a branch of so many.

    `groups`: the samples' indices, a row for each window, with −1 for none. `fits`: for each degree the windows that it
    is fitted to, numbered through all groups, shape (n, 3): the last samples and two windows before them."""

    groups: tuple[np.ndarray, ...]
    fits: tuple[tuple[int, np.ndarray], ...]


@lru_cache(maxsize=64)
def _windows(count: int) -> _Windows:
    """The windows of a branch of so many samples. Those of few samples form one group, which is fitted in one call."""
    widths = {}
    for degree in _DEGREES:
        sizes = {degree + 1 + spare for spare in _SPARE} | {count // part for part in _PARTS}
        widths[degree] = [width for width in sizes if degree + 2 <= width <= count - max(2, width // 4)]
    few = _DEGREES[-1] + 1 + max(_SPARE)
    in_order = sorted({width for sizes in widths.values() for width in sizes})
    groups = [[w for w in in_order if w <= few], *([w] for w in in_order if w > few)]
    rows = {width: 3 * i + np.arange(3) for i, width in enumerate(in_order)}
    fits = ((degree, np.array([rows[width] for width in sizes])) for degree, sizes in widths.items() if sizes)
    return _Windows(tuple(_indices(count, group) for group in groups if group), tuple(fits))


def _indices(count: int, widths: Sequence[int]) -> np.ndarray:
    """The samples of each width's windows: the last, and those ending an eighth and a quarter of the width earlier."""
    size = max(*widths, _DEGREES[-1] + 2)  # at least one for each column
    result = np.full((3 * len(widths), size), -1)
    for i, width in enumerate(widths):
        for k, shift in enumerate((0, max(1, width // 8), max(2, width // 4))):
            result[3 * i + k, :width] = np.arange(count - shift - width, count - shift)
    return result


def _zeros(tau: np.ndarray, y: np.ndarray, limit: float) -> np.ndarray:
    """First zero after the last sample of each polynomial, shape (n, 3) as in `_Windows`; NaN if there is none.

    The zeros of all polynomials of a degree are computed in one call, as eigenvalues of their companion matrices."""
    groups, fits = _windows(len(tau))
    if not fits:
        return np.empty((0, 3))
    # In windows, so that no unit of time counts.
    spans = np.concatenate([-tau[group[:, 0]] for group in groups])
    factors = np.concatenate([_factors(tau, y, group) for group in groups])
    return np.concatenate(
        [_zeros_of(_fits(factors[rows.ravel()], degree), spans[rows.ravel()], limit) for degree, rows in fits]
    ).reshape(-1, 3)


def _factors(tau: np.ndarray, y: np.ndarray, samples: np.ndarray) -> np.ndarray:
    """The triangular factors of the windows' powers of time, from the lowest on, and of y as the last column.

    The leading part of a factor is that of the lower powers alone, so that it has the least-squares fits of all
    degrees; rows of zeros, for windows of fewer samples, change nothing.
    """
    columns = np.ones((*samples.shape, _DEGREES[-1] + 2))
    columns[..., 1] = tau[samples] / -tau[samples[:, :1]]
    for power in range(2, _DEGREES[-1] + 1):
        columns[..., power] = columns[..., power - 1] * columns[..., 1]
    columns[..., -1] = y[samples]
    columns[samples < 0] = 0.0
    return np.asarray(np.linalg.qr(columns, mode="r"))


def _fits(factors: np.ndarray, degree: int) -> np.ndarray:
    """The least-squares polynomials of a degree, shape (n, degree + 1), from the highest power; 0 if there is none."""
    size = degree + 1
    powers, right, fits = factors[:, :size, :size], factors[:, :size, -1], np.zeros((len(factors), size))
    is_regular = np.diagonal(powers, axis1=1, axis2=2).all(axis=1)  # not so for times that agree to rounding
    fits[is_regular] = np.linalg.solve(powers[is_regular], right[is_regular, :, None])[..., 0]
    fits[~np.isfinite(fits).all(axis=1)] = 0.0
    return fits[:, ::-1]


def _zeros_of(fits: np.ndarray, spans: np.ndarray, limit: float) -> np.ndarray:
    """First zeros of polynomials of one degree, in the unit of the spans."""
    degree, zeros, is_full = fits.shape[1] - 1, np.full(len(fits), nan), fits.all(axis=1)
    for k in np.flatnonzero(~is_full & fits.any(axis=1)):  # of a lower degree, or with zeros at 0
        zeros[k] = _first(np.roots(fits[k]), spans[k], limit)
    companion = np.zeros((int(is_full.sum()), degree, degree))
    companion[:, 0] = -fits[is_full, 1:] / fits[is_full, :1]
    below = np.arange(degree - 1)
    companion[:, below + 1, below] = 1.0
    zeros[is_full] = _first(np.linalg.eigvals(companion), spans[is_full, None], limit)
    return zeros


def _first(roots: np.ndarray, span: np.ndarray | float, limit: float) -> np.ndarray:
    """The smallest of each row's real roots, in windows of that span, from 0 to the limit; NaN if there is none."""
    real = span * roots.real
    in_reach = (np.abs(roots.imag) <= 1e-9 * (1.0 + np.abs(roots.real))) & (real >= 0.0) & (real <= limit)
    least = np.min(np.where(in_reach, real, np.inf), axis=-1, initial=np.inf)
    return np.where(np.isfinite(least), least, nan)


def _chord(t: np.ndarray, y: np.ndarray, end: float) -> tuple[float, float] | None:
    """The straight line through the last two samples, for branches of too few samples; unsure by half a gap."""
    if len(t) < 2 or y[-1] >= y[-2]:
        return None
    zero = float(t[-1] + y[-1] * (t[-1] - t[-2]) / (y[-2] - y[-1]))
    return (min(zero, end), 0.5 * float(t[-1] - t[-2]))
