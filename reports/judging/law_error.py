"""How far a sampled motion is from the law of friction, without any truth: from its samples alone."""

from __future__ import annotations

from math import nan
from typing import NamedTuple

import numpy as np

from cases import Belt, Case, CoulombFriction, Drive, Gravity, Load, Trajectory
from cases.contact.nearest import nearest
from cases.errors import DoesNotFit
from cases.own_effects import own_effects

# Intervals between samples at which the law is looked at: of more, so many that are evenly distributed.
MOST_INTERVALS = 1000
# Slip below this part of the largest, and pressure below this part of the median, is left out: near zero both are
# differences of roundings. A plate that is higher than this part of its size flies.
SLIPS, PRESSES, FLIES = 0.02, 0.05, 0.05
_COLUMNS = ("t", "x", "y", "theta", "vx", "vy", "omega")


class LawError(NamedTuple):
    """The error of the law of friction in units of μ N while the plate slips: its median and the value that 90 % of the
    intervals do not exceed; and the time (s) at which it is largest. NaN where the law is not looked at."""

    median: float = nan
    upper: float = nan
    time: float = nan


def law_error(case: Case, motion: Trajectory) -> LawError:
    """|T + sign(slip) μ N| / (μ N) of the forces that changed the velocities from sample to sample.

    N and T are the components of m Δv/Δt less weight and load at the point of the track that is nearest to the plate;
    slip is that of the mean velocities. An error of the method of first order in the step remains where forces change
    within it. NaN with a moving track, several plates or contacts, effects of packages, and without friction.
    """
    friction, drive = case.effect(CoulombFriction), case.effect(Drive)
    if friction is None or drive is not None or case.others or case.supports or own_effects(case.effects):
        return LawError()
    keep = np.concatenate([np.diff(motion.t) > 0.0, [True]])
    t, x, y, theta, vx, vy, omega = (getattr(motion, name)[keep] for name in _COLUMNS)
    if len(t) < 2:
        return LawError()
    some = np.unique(np.linspace(0, len(t) - 2, min(len(t) - 1, MOST_INTERVALS)).astype(int))
    length = t[some + 1] - t[some]
    middle = [0.5 * (row[some] + row[some + 1]) for row in (t, x, y, theta, vx, vy, omega)]
    gain = ((vx + 1j * vy)[some + 1] - (vx + 1j * vy)[some]) / length
    rows = [_forces(case, gain[i], *(float(row[i]) for row in middle)) for i in range(len(some))]
    normal, tangential, slip = np.array(rows).T
    return _error(friction, middle[0], normal, tangential, slip)


def _forces(
    case: Case, gain: complex, t: float, x: float, y: float, theta: float, vx: float, vy: float, omega: float
) -> tuple[float, float, float]:
    """Normal and friction force (N) and slip velocity (m/s) at the nearest point of the track; NaN in flight."""
    plate = case.plate
    try:
        pair = nearest(case, x, y, theta)
    except DoesNotFit:
        pair = None
    if pair is None or pair.gap > FLIES * plate.reach:
        return nan, nan, nan
    gravity, load, belt = case.effect(Gravity), case.effect(Load), case.effect(Belt)
    force = plate.mass * (gain - (complex(*gravity.vector) if gravity else 0j))
    if load is not None:
        force -= complex(*load.at(t, x, y, theta, vx, vy, omega)[:2])
    force *= complex(*case.track.tangent(pair.xi1)).conjugate()
    lever = complex(*case.track.point(pair.xi1)) - complex(x, y)
    moving = (complex(vx, vy) + 1j * omega * lever) * complex(*case.track.tangent(pair.xi1)).conjugate()
    return force.imag, force.real, moving.real - (belt.at(t)[0] if belt else 0.0)


def _error(
    friction: CoulombFriction, t: np.ndarray, normal: np.ndarray, tangential: np.ndarray, slip: np.ndarray
) -> LawError:
    touches = np.isfinite(slip)
    if not touches.any():
        return LawError()
    slips = touches & (np.abs(slip) > SLIPS * np.abs(slip[touches]).max())
    slips &= normal > PRESSES * np.median(np.abs(normal[touches]))
    if not slips.any():
        return LawError()
    bound = friction.at(np.abs(slip[slips])) * normal[slips]
    error = np.abs(tangential[slips] + np.sign(slip[slips]) * bound) / bound
    return LawError(float(np.median(error)), float(np.quantile(error, 0.9)), float(t[slips][np.argmax(error)]))
