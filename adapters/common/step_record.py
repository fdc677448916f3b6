"""The record of an engine's steps, with poses at k·h and velocities half a step later: velocities at the poses' times,
and the momentum that the contacts add in each step. For one plate, or for several (rows of shape (n, plates, 6))."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cases import Case
from cases.contact import Contact
from cases.motion.mechanics import gravity
from cases.scene.free_plates import plates_of

from ..interface import EngineFailure
from .starts import starts_of


@dataclass(frozen=True)
class StepRecord:
    """The record of a run: rows (x, y, theta, vx, vy, omega) at every step of `h` s, `steps` + 1 if it is complete;
    shape (n, 6), or (n, plates, 6) for several plates.

    `contacts`: the rows' contacts if the adapter set them, else they are computed. `load`: the Load of each
    plate in each step, (F_x, F_y, M) in N and N m, shape (n, 3) or (n, plates, 3). `rough`: distance (m) of the
    engine's shapes from the curves. `lever`: the fraction of the gap between the plate and the point where the engine's
    friction acts. `rounding`: the relative rounding of its numbers. `rest`: the part of h by which the first step was
    shorter. `pull`: acceleration of a free plate (m/s²), by default gravity's. `wider` (m): by how much the engine's
    discs are larger than the case's, whose outlines slip where they roll.
    """

    case: Case
    h: float
    steps: int
    rows: np.ndarray
    contacts: list[Contact] | None = None
    load: np.ndarray | None = None
    rough: float = 0.0
    lever: float = 0.0
    rounding: float = float(np.finfo(float).eps)
    rest: float = 0.5
    pull: float | None = None
    wider: float = 0.0


def rest(substeps: int) -> float:
    """The part of a step by which the first one is shorter: half a substep."""
    return 0.5 / substeps


def check_rows(record: StepRecord) -> None:
    """Raise EngineFailure for rows that are no motion."""
    if len(record.rows) < 3:
        raise EngineFailure("The engine returned fewer than three steps.")
    if not np.isfinite(record.rows).all():
        when = record.h * int(np.argmin(np.isfinite(record.rows).reshape(len(record.rows), -1).all(axis=1)))
        raise EngineFailure(f"The engine's numbers are not finite from {when:.4g} s on.")


def velocities_before(record: StepRecord) -> np.ndarray:
    """The velocities before each row's pose, shape (n, 3) or (n, plates, 3): the start's, then those after the pose
    before."""
    first = starts_of(record.case)[:, 3:]
    return np.concatenate([first[None] if record.case.others else first, record.rows[:-1, ..., 3:]])


def spans(record: StepRecord) -> tuple[np.ndarray, float]:
    """The times (s) from the velocities before each pose to it, an axis of n, and from it to those after it."""
    late = np.full((len(record.rows), *[1] * (record.rows.ndim - 1)), record.rest * record.h)
    late[0] = 0.0
    return late, record.h * (1.0 - record.rest)


def inertia_of(case: Case) -> np.ndarray:
    """Mass, mass and moment of inertia, shape (3,), of several plates (plates, 3); 1 for a plate that does not turn,
    whose spin no moment changes."""
    every = np.array([(plate.mass, plate.mass, plate.inertia if plate.turns else 1.0) for plate in plates_of(case)])
    return every if case.others else every[0]


def external_of(record: StepRecord) -> np.ndarray:
    """Gravity and load in each step: force (N) and moment (N m), shape (n, 3) or that of the inertia."""
    every = np.array([(1.0, 1.0, float(plate.turns)) for plate in plates_of(record.case)])
    turns = every if record.case.others else every[0]
    load = np.zeros(3) if record.load is None else record.load * turns
    return np.append(gravity(record.case), 0.0) * inertia_of(record.case) + load


def torsor_of(record: StepRecord) -> np.ndarray:
    """Force (N) and moment (N m) of the contacts in each step, like the velocities: the momentum that it adds, over its
    length, without gravity and load."""
    late, ahead = spans(record)
    change = record.rows[..., 3:] - velocities_before(record)
    return inertia_of(record.case) * change / (late + ahead) - external_of(record)


def rates_at_poses(
    before: np.ndarray, after: np.ndarray, size: float | Sequence[float], rest: float = 0.5
) -> np.ndarray:
    """Velocities at the poses' times, interpolated from those `rest` of a step before and 1 − `rest` of a step after.

    Arrays (n, 3); the first row is the start's. Linear interpolation has an error of rest (1 − rest)/2 h² times the
    second derivative, as large as the engine's own. It is corrected by the smaller of the second differences to either
    side, so that none extends across a jump of the acceleration. (All components use the same side, because a slip
    velocity combines them. Spin is scaled by the plate's `size`, m; of several plates there are 3 columns each.)
    """
    bend = np.diff(after, 2, axis=0)
    earlier, later = np.vstack([bend[:1], bend]), np.vstack([bend, bend[-1:]])
    scale = np.array([value for each in np.atleast_1d(size) for value in (1.0, 1.0, each)])
    nearer = np.linalg.norm(earlier * scale, axis=1) < np.linalg.norm(later * scale, axis=1)
    smaller = np.where(nearer[:, None], earlier, later)
    rates = (1.0 - rest) * before + rest * after
    rates[0] = before[0]
    rates[1:] -= 0.5 * rest * (1.0 - rest) * smaller
    return rates
