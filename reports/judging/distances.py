"""Errors of a motion relative to the truth: pose, slip, forces, energy. Pure functions of trajectories; SI units."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from math import nan
from typing import Any, NamedTuple

import numpy as np

from cases import Case, State, Trajectory
from cases.motion.mechanics import energy, kinetic_energy
from cases.motion.sampled_contacts import SampledPlates

# The square of a larger number is close to the largest double, or overflows.
_LARGEST_SQUARE_ROOT = 1e150


class Distance(NamedTuple):
    """Errors of a motion: largest and root-mean-square error of the centre in m, of the angle in rad, of the slip
    velocity in m/s; error of the last pose in m; mean errors of the normal force (NaN if the solver reports none) and
    of the mechanical energy, relative to the true motion (`differences`)."""

    centre_max: float
    centre_rms: float
    angle_max: float
    angle_rms: float
    slip_max: float
    slip_rms: float
    final_pose: float = nan
    normal_force_mean: float = nan
    energy_mean: float = nan


# Smallest fraction of the samples with a force for which a mean error of the force is computed.
_LEAST_SHARE = 0.5
# Number of evenly spaced times at which a dense motion is compared; `even_samples` has so many in place of each gap.
_EVEN, _PARTS = 1001, 4


@lru_cache(maxsize=4)
def even_samples(motion: Trajectory) -> Trajectory:
    """A dense motion at evenly spaced times, close enough for integrals with a relative error of 1e-4 by the
    trapezoidal rule: at every fourth `differences` compares it. A motion of samples is itself. Cached, as a motion is
    compared in several ways, and all motions of a case with one truth."""
    if motion.dense is None:
        return motion
    times = np.linspace(motion.t[0], motion.t[-1], _PARTS * (_EVEN - 1) + 1)
    return Trajectory(t=times, **motion(times)._asdict())


def differences(
    trajectory: Trajectory,
    truth: Trajectory,
    case: Case,
    whole: Mapping[str, np.ndarray] | None = None,
) -> dict[str, np.ndarray]:
    """Solver minus truth within the common time span, arrays of one length: at the solver's own times, or at evenly
    spaced times if its motion is dense (its steps are few, and doubled where the forces jump).

    Keys: t, x, y (m), centre (distance, m), angle, slip, xi1, xi2, normal_force (N),
    and pose: root of the centre's distance squared plus the angle times the radius of gyration squared, m, which is the
    root-mean-square distance of the plate's points; centre and pose are of the plate that is farthest off, the others
    of the case's plate; of each further plate "x of NAME", "y of NAME" and "angle of NAME";
    force_share: the difference of the normal force relative to the mean true force at these times (not to m g, so that
    it is also defined without gravity);
    energy_share: the difference of the mechanical energy relative to the true motion's largest kinetic energy.
    Whole turns between the angles at the start are subtracted: they only mean that angles are counted differently.
    `whole`: the differences of the motions of which these two are one contact. What all contacts share is taken from
    it, if its times are the same.
    """
    times, state = _states(trajectory, truth)
    exact = truth(times)
    if whole is None or not np.array_equal(whole["t"], times):
        whole = _of_plates(case, times, (trajectory, state), (truth, exact))
    result = {"t": times}
    for name in ("slip", "xi1", "xi2", "normal_force"):
        result[name] = getattr(state, name) - np.asarray(getattr(exact, name))
    force = np.abs(np.asarray(exact.normal_force))
    press = float(force.mean()) if len(force) else nan
    result["force_share"] = result["normal_force"] / (press if press > 0.0 else nan)
    return {**whole, **result}


def _of_plates(
    case: Case, times: np.ndarray, solvers: tuple[Trajectory, State], truths: tuple[Trajectory, State]
) -> dict[str, np.ndarray]:
    """The differences that all contacts share; `solvers`, `truths`: a motion and its states at these times."""
    own, true = (_of_all_plates(motion, times, now) for motion, now in (solvers, truths))
    result = _pose_differences(own, true, "")
    result["centre"], result["pose"] = farthest(case, own, true)
    for other in case.others:
        if isinstance(own, Trajectory) and isinstance(true, Trajectory):
            result |= _pose_differences(own.plate(other.name), true.plate(other.name), f" of {other.name}")
    fastest = np.max(kinetic_energy(case, true), initial=0.0)
    off = energy(case, own) - energy(case, true)
    result["energy_share"] = off / (fastest if fastest > 0.0 else nan)
    return result


def _pose_differences(one: State | Trajectory, other: State | Trajectory, of: str) -> dict[str, np.ndarray]:
    """The differences of the poses of a plate, with ` of NAME` in their keys."""
    x, y, angle = (np.asarray(getattr(one, q)) - np.asarray(getattr(other, q)) for q in ("x", "y", "theta"))
    return {f"x{of}": x, f"y{of}": y, f"angle{of}": _without_turns(angle)}


def farthest(case: Case, own: State | Trajectory, true: State | Trajectory) -> tuple[np.ndarray, np.ndarray]:
    """The largest error of the centre, m, and of the pose, m, over all plates that both motions have, at each time."""
    pairs = [(case.plate, own, true)]
    if isinstance(own, Trajectory) and isinstance(true, Trajectory):
        pairs += [(other.plate, own.plate(other.name), true.plate(other.name)) for other in case.others]
    centres, poses = [], []
    for plate, one, other in pairs:
        centres.append(np.hypot(np.asarray(one.x) - np.asarray(other.x), np.asarray(one.y) - np.asarray(other.y)))
        angle = _without_turns(np.asarray(one.theta) - np.asarray(other.theta))
        poses.append(np.hypot(centres[-1], plate.gyration * angle))
    return np.max(centres, axis=0), np.max(poses, axis=0)


def _without_turns(angle: np.ndarray) -> np.ndarray:
    """A difference of angles without its whole turns at the start."""
    turns = np.round(angle[:1] / (2 * np.pi))
    return angle - 2 * np.pi * (turns[0] if len(turns) else 0.0)


def _of_all_plates(motion: Trajectory, times: np.ndarray, first: State) -> State | Trajectory:
    """The states of all plates of a motion at these times, as a motion; with one plate those of it, `first`."""
    if motion.plate_columns is None:
        return first
    plates = {name: np.array(states_at(motion.plate(name), times)[:6]) for name in motion.plate_names}
    columns: dict[str, Any] = first._asdict()
    return Trajectory(t=times, **columns, plate_names=motion.plate_names, plate_columns=SampledPlates(times, plates))


def states_at(motion: Trajectory, times: np.ndarray) -> State:
    """The states of a motion at these times: its own samples, if they are among them."""
    if motion.dense is not None:
        return motion(times)
    inside = (motion.t >= times[0]) & (motion.t <= times[-1]) if len(times) else np.zeros(len(motion.t), dtype=bool)
    if np.array_equal(motion.t[inside], times):
        return states_of(motion, inside)
    return motion(times)


def _states(trajectory: Trajectory, truth: Trajectory) -> tuple[np.ndarray, State]:
    """The times at which both are compared, and the solver's states at these times, arrays."""
    samples, every = even_samples(trajectory), 1 if trajectory.dense is None else _PARTS
    common = np.zeros(len(samples.t), dtype=bool)
    common[::every] = (samples.t[::every] >= truth.t[0]) & (samples.t[::every] <= truth.t[-1])
    return samples.t[common], states_of(samples, common)


def states_of(motion: Trajectory, pick: slice | np.ndarray = slice(None)) -> State:
    """The states of a motion at some of its own samples, of its first plate and contact."""
    return State(*(np.asarray(getattr(motion, name))[pick] for name in State._fields))


def distance(off: dict[str, np.ndarray]) -> Distance:
    """The largest and the root-mean-square of `differences`; NaN where there is nothing in common.

    For force and energy the mean of the absolute error is used: they jump at transitions and impacts, where a solver
    that is late by a short time has an error of the whole jump. Refinement would not reduce the largest error, and the
    root mean square only with the square root of that time.
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
    has_force = len(force) >= _LEAST_SHARE * len(off["t"])
    force_mean = float(force.mean()) if has_force else nan
    values += [float(off["pose"][-1]), force_mean, float(np.abs(off["energy_share"]).mean())]
    return Distance(*values)


def _rms(size: np.ndarray) -> float:
    """The root mean square; scaled by the largest value if its square would overflow."""
    top = float(size.max())
    unit = top if _LARGEST_SQUARE_ROOT < top < np.inf else 1.0
    return unit * float(np.sqrt(np.mean((size / unit) ** 2)))
