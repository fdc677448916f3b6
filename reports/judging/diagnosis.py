"""Probable causes of a submitted motion's errors: velocities of other times than the poses, a mirrored axis, another
unit, an undeclared creep.

Pure functions; each returns a sentence, or "". Nothing is corrected: the motion is judged unchanged.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import pi

import numpy as np

from cases import Case, Trajectory
from cases.contact import slip_velocity

# Velocities count as half a step away from the poses if their offset is within these bounds, in steps, and if removing
# the offset leaves at most this fraction of their error.
HALF, LARGEST_REST = (0.25, 0.75), 0.3
# An axis counts as mirrored, or a column as in another unit, if changing it leaves at most this fraction of the error.
NEARER = 0.1
# Fewest samples within the truth's duration for a diagnosis.
LEAST = 3
# A plate that turns by less (rad) does not turn: an angle of this size counts as much as all of its way. (By a smaller
# one the rounding of angles would outweigh every error of places.)
STILL = 1e-3

# The signs of x, y and theta in each image of a motion.
_IMAGES = {
    "x": (-1, 1, 1),
    "y": (1, -1, 1),
    "theta": (1, 1, -1),
    "x and theta": (-1, 1, -1),
    "y and theta": (1, -1, -1),
    "x and y": (-1, -1, 1),
}

# Columns in units that are common elsewhere: name, unit, and the unit in seconds, metres or radians.
_UNITS = (
    *((name, unit, size) for name in ("x", "y") for unit, size in
      (("millimetres", 1e-3), ("centimetres", 1e-2), ("kilometres", 1e3), ("inches", 0.0254), ("feet", 0.3048))),
    *(("t", unit, size) for unit, size in
      (("minutes", 60.0), ("hours", 3600.0), ("milliseconds", 1e-3), ("microseconds", 1e-6))),
    ("theta", "degrees", pi / 180.0),
    ("theta", "turns", 2.0 * pi),
)  # fmt: skip

Columns = Mapping[str, np.ndarray]


def half_step(columns: Columns) -> str:
    """A sentence if the velocities of a table are half a step before or after its poses, as with semi-implicit steps.

    To first order v(t + s h) = v + s h v̇: the offset s is fitted to the difference between the rates and the slopes of
    the poses.
    """
    t, shifts = columns["t"], dict[str, float]()
    for rate, name in (("vx", "x"), ("vy", "y"), ("omega", "theta")):
        if rate in columns:
            slope = np.gradient(columns[name], t, edge_order=2)
            shifts[rate] = _shift(columns[rate], slope, np.gradient(slope, t) * np.gradient(t))
    shifts = {rate: shift for rate, shift in shifts.items() if shift}
    if not shifts:
        return ""
    when = "before" if sum(shifts.values()) < 0.0 else "after"
    return (
        f"{', '.join(shifts)} seem to stand half a step {when} the poses, as a semi-implicit step leaves them: slip, "
        "and what is read from it, is off by what half a step changes; write velocities of the poses' times"
    )


def slip_half_a_step_beside(case: Case, motion: Trajectory) -> str:
    """A sentence if the slip of a motion is half a step before or after its poses, though its velocities are not."""
    touches = np.isfinite(motion.xi1) & np.isfinite(motion.slip)
    t, column = motion.t[touches], motion.slip[touches]
    if len(t) < 3:
        return ""
    values = (getattr(motion, name)[touches] for name in ("x", "y", "vx", "vy", "omega", "xi1"))
    own = slip_velocity(case, *values)
    shift = _shift(column, own, np.gradient(own, t) * np.gradient(t))
    if not shift:
        return ""
    when = "before" if shift < 0.0 else "after"
    return (
        f"slip seems to stand half a step {when} the poses: every transition is off by as much; "
        "write the slip of the poses' times"
    )


def _shift(column: np.ndarray, own: np.ndarray, growth: np.ndarray) -> float:
    """The offset of a column in time, in steps, if it is about half a step and explains the column's error; else 0.

    `own`: the values that follow from the other columns; `growth`: their change from one sample to the next.
    """
    off = column - own
    # Kinks of the motion are few and large: the middle nine tenths decide.
    usual = np.abs(off) <= np.quantile(np.abs(off), 0.9)
    off, growth = off[usual], growth[usual]
    size = float(growth @ growth)
    if size == 0.0:
        return 0.0
    shift = float(off @ growth) / size
    rest = off - shift * growth
    explains = rest @ rest <= LARGEST_REST**2 * (off @ off)
    return shift if HALF[0] <= abs(shift) <= HALF[1] and explains else 0.0


def mirror_axis(columns: Columns, truth: Trajectory) -> str:
    """A sentence if mirroring an axis brings the poses of a table much closer to the truth."""
    images = {name: dict(zip(("x", "y", "theta"), signs, strict=True)) for name, signs in _IMAGES.items()}
    name = _much_nearer(columns, truth, images)
    if not name:
        return ""
    verb = "seem" if " and " in name else "seems"
    return (
        f"{name} {verb} to be mirrored: turned round, the motion comes much nearer to the truth; give x to the right, "
        "y upwards, and theta counter-clockwise"
    )


def other_unit(columns: Columns, truth: Trajectory) -> str:
    """A sentence if reading one column in another unit brings a table much closer to the truth."""
    images = {f"{name} seems to be in {unit}": {name: factor} for name, unit, factor in _UNITS}
    seems = _much_nearer(columns, truth, images)
    return seems and (f"{seems}: read so, the motion comes much nearer to the truth; give seconds, metres and radians")


def _much_nearer(columns: Columns, truth: Trajectory, images: Mapping[str, Mapping[str, float]]) -> str:
    """The name of the image (factors of columns) of a table that is closest to the truth; "" if it is not much closer
    than the table itself."""
    whole = truth(np.linspace(truth.t[0], truth.t[-1], len(columns["t"])))
    # Angles are converted to lengths by the whole motion's ratio of both.
    size = float(np.hypot(np.ptp(whole.x), np.ptp(whole.y))) / max(float(np.ptp(whole.theta)), STILL)

    @np.errstate(over="ignore", invalid="ignore")  # the values may be of any size
    def off(factors: Mapping[str, float]) -> float:
        t, x, y, theta = (factors.get(name, 1.0) * columns[name] for name in ("t", "x", "y", "theta"))
        inside = t <= truth.t[-1]
        if inside.sum() < LEAST:
            return np.inf
        true = truth(t[inside])
        turn = theta[inside] - true.theta
        turn = size * (turn - 2 * pi * np.round(turn[0] / (2 * pi)))
        return float(np.sqrt(np.mean(np.hypot(x[inside] - true.x, y[inside] - true.y) ** 2 + turn**2)))

    name = min(images, key=lambda image: off(images[image]))
    return name if off(images[name]) < NEARER * off({}) else ""
