"""How far a motion is from the truth: pose, slip, forces, energy; pure functions of trajectories. SI units."""

from __future__ import annotations

from math import nan
from typing import NamedTuple

import numpy as np

from cases import Case, State, Trajectory
from cases.mechanics import energy, kinetic_energy

# The square of what is larger overflows, or nearly.
_SQUARED = 1e150


class Distance(NamedTuple):
    """How far a motion is from the truth: largest and root-mean-square distance of the centre in m, of the angle in
    rad, of the slip velocity in m/s; distance of the last pose in m; mean errors of the normal force (NaN where the
    solver tells none) and of the mechanical energy, as parts of the true motion's own (`differences`)."""

    centre_max: float
    centre_rms: float
    angle_max: float
    angle_rms: float
    slip_max: float
    slip_rms: float
    final_pose: float = nan
    normal_force_mean: float = nan
    energy_mean: float = nan


# A force that is told for less than this part of the samples is not told.
_REPORTED = 0.5
# Even times at which a motion that is known between its steps is compared.
_EVEN = 1001


def differences(trajectory: Trajectory, truth: Trajectory, case: Case) -> dict[str, np.ndarray]:
    """Solver minus truth within the common time span, arrays of one length: at the solver's own times, or at even ones
    if it knows its motion between them (its steps are few, and doubled where the forces jump).

    Keys: t, x, y (m), centre (distance, m), angle, slip, xi1, xi2, normal_force (N), lambda (the paper's multiplier),
    and pose: root of the centre's distance squared plus the angle times the radius of gyration squared, m, which is the
    root-mean-square distance of the plate's points;
    force_share: the normal force's difference over the mean size of the true one at these times (not over m g, so that
    a case without gravity has one too);
    energy_share: the mechanical energy's difference over the true motion's largest kinetic energy.
    Angles that differ by whole turns at the start are counted from different zeros, and the turns are taken off.
    """
    times, found = _states(trajectory, truth)
    exact = truth(times)
    result = {"t": times, "centre": np.hypot(found.x - exact.x, found.y - exact.y)}
    for key, name in (
        ("x", "x"),
        ("y", "y"),
        ("angle", "theta"),
        ("slip", "slip"),
        ("xi1", "xi1"),
        ("xi2", "xi2"),
        ("normal_force", "normal_force"),
    ):
        result[key] = getattr(found, name) - np.asarray(getattr(exact, name))
    turns = np.round(result["angle"][:1] / (2 * np.pi))
    result["angle"] = result["angle"] - 2 * np.pi * (turns[0] if len(turns) else 0.0)
    result["lambda"] = result["normal_force"] / case.track.speed(np.asarray(exact.xi1))
    result["pose"] = np.hypot(result["centre"], case.plate.gyration * result["angle"])
    force = np.abs(np.asarray(exact.normal_force))
    press = float(force.mean()) if len(force) else nan
    fastest = np.max(kinetic_energy(case, exact), initial=0.0)
    result["force_share"] = result["normal_force"] / (press if press > 0.0 else nan)
    off = energy(case, found) - energy(case, exact)
    result["energy_share"] = off / (fastest if fastest > 0.0 else nan)
    return result


def _states(trajectory: Trajectory, truth: Trajectory) -> tuple[np.ndarray, State]:
    """Where the two are compared: times and the solver's states there, arrays."""
    if trajectory.dense is not None:
        times = np.linspace(trajectory.t[0], trajectory.t[-1], _EVEN)
        state = trajectory(times)
    else:
        times, state = trajectory.t, State(*(getattr(trajectory, name) for name in State._fields))
    common = (times >= truth.t[0]) & (times <= truth.t[-1])
    return times[common], State(*(np.asarray(values)[common] for values in state))


def distance(off: dict[str, np.ndarray]) -> Distance:
    """The largest and the root-mean-square of `differences`; NaN where there is nothing in common.

    Of force and energy the mean size: they jump at transitions and impacts, where a late solver is wrong by the whole
    jump for a short while; the largest error would not fall, and the root mean square with the root of that while only.
    """
    if not len(off["t"]):
        return Distance(*len(Distance._fields) * (nan,))
    values = []
    for key in ("centre", "angle", "slip"):
        # In flight there is no slip velocity.
        size = np.abs(off[key][np.isfinite(off[key])])
        size = size if len(size) else np.array([nan])
        values += [float(size.max()), _rms(size)]
    force = np.abs(off["force_share"][np.isfinite(off["force_share"])])
    told = len(force) >= _REPORTED * len(off["t"])
    values += [float(off["pose"][-1]), float(force.mean()) if told else nan, float(np.abs(off["energy_share"]).mean())]
    return Distance(*values)


def _rms(size: np.ndarray) -> float:
    """The root mean square; of what is so large that its square is no number, by parts of the largest."""
    top = float(size.max())
    unit = top if _SQUARED < top < np.inf else 1.0
    return unit * float(np.sqrt(np.mean((size / unit) ** 2)))
