"""Contacts of one or several plates from the poses and velocities of a motion alone.

A contact is a place where a plate and a boundary are near (`couple_contacts`). It is closed while its gap is below what
the engine's step leaves and, where the change of momentum is known, while that needs it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from cases import Case, State, Trajectory
from cases.motion.sampled_contacts import SampledPlates
from cases.scene.contact_names import FIRST
from cases.scene.free_plates import names_of, plates_of

from .closed_samples import by_gap, from_first_to_last, ranges, touching
from .couple_contacts import couple_contacts
from .pose_contact import ROUNDING, forces_of, pushing, with_columns


def with_plates(
    case: Case,
    t: np.ndarray,
    poses: np.ndarray,
    rates: np.ndarray,
    clear: float,
    torsor: np.ndarray | None = None,
    slip_lever: float = 0.0,
    impact: float = 0.0,
) -> Trajectory:
    """`with_contacts` for `motion_of` the plates of a case."""
    return with_contacts(case, motion_of(case, t, poses, rates), clear, torsor, slip_lever, impact)


def motion_of(case: Case, t: np.ndarray, poses: np.ndarray, rates: np.ndarray) -> Trajectory:
    """A motion without contacts from (x, y, θ) and (vx, vy, ω) of all plates at the times `t`, shape (n, plates, 3)."""
    plates = {name: np.vstack([poses[:, i].T, rates[:, i].T]) for i, name in enumerate(names_of(case))}
    columns: dict[str, Any] = dict(zip(State._fields, [*plates[FIRST], *np.full((5, len(t)), np.nan)], strict=True))
    if case.others:
        columns |= {"plate_names": names_of(case), "plate_columns": SampledPlates(t, plates)}
    return Trajectory(t=t, **columns, case=case)


def with_contacts(
    case: Case,
    motion: Trajectory,
    clear: float,
    torsor: np.ndarray | None = None,
    slip_lever: float = 0.0,
    impact: float = 0.0,
) -> Trajectory:
    """The motion with the columns of each contact that closes at some time; of one plate in the order in which they
    first do.

    `clear`: the gap (m) below which a contact is closed. `torsor`: force (N) and moment (N m) of all contacts on each
    plate at the samples, shape (n, plates, 3); without it a contact is open as soon as its gap grows, and forces are
    not known. The engine's friction acts at the share `slip_lever` of the gap from the plate that is named first. A
    contact between two flights that does not last longer than `impact` (s) is an impact, closed at its first sample
    only.
    """
    plates = plates_of(case)
    poses, rates = poses_and_rates(motion)
    some = couple_contacts(case, motion.t, poses, rates, lambda xi1: np.full(len(xi1), clear), clear, slip_lever)
    if not some and not case.others:
        return motion
    closed, rounding = [one.gap <= clear for one in some], rounding_of(case, motion)
    if torsor is None:
        closed = [by_gap(one.gap, shut, rounding) for one, shut in zip(some, closed, strict=True)]
    else:
        turning, lengths = (np.array([getattr(p, name) for p in plates], dtype=float) for name in ("turns", "reach"))
        momenta = (torsor.reshape(poses.shape) / [(1.0, 1.0, length) for length in lengths]).reshape(len(poses), -1)
        steady = [touching(one.gap, shut, rounding) for one, shut in zip(some, closed, strict=True)]
        steady = pushing(some, closed, steady, momenta, lengths, turning)
        closed = [from_first_to_last(shut, holds) for shut, holds in zip(closed, steady, strict=True)]
    closed = [_with_instants(motion.t, shut, impact) for shut in closed]
    forces = np.full((len(some), 2, len(motion.t)), np.nan)
    if torsor is not None:
        forces = forces_of(some, closed, momenta, lengths, turning)
    return with_columns(motion, some, closed, forces)


def poses_and_rates(motion: Trajectory) -> tuple[np.ndarray, np.ndarray]:
    """(x, y, θ) and (vx, vy, ω) of all plates of a sampled motion, shape (n, plates, 3)."""
    own = [motion.x, motion.y, motion.theta, motion.vx, motion.vy, motion.omega]
    each = [motion.plate_columns(name, None)[:6] for name in motion.plate_names] if motion.plate_columns else [own]
    states = np.array(each).transpose(2, 0, 1)
    return states[..., :3], states[..., 3:]


def rounding_of(case: Case, motion: Trajectory) -> float:
    """The gap (m) that rounding may leave at a closed contact of a motion."""
    poses, _ = poses_and_rates(motion)
    return ROUNDING * (
        max(plate.reach for plate in plates_of(case)) + float(np.max(np.hypot(poses[..., 0], poses[..., 1])))
    )


def _with_instants(t: np.ndarray, closed: np.ndarray, impact: float) -> np.ndarray:
    """The closed samples, of contacts between two flights that last at most `impact` (s) only the first one."""
    result = closed.copy()
    for start, stop in ranges(closed):
        if 0 < start and stop < len(t) and t[stop - 1] - t[start] <= impact:
            result[start + 1 : stop] = False
    return result
