"""Reads motions of several free plates of engines with positions at k·h and velocities half a step later.

Like `half_steps`, for all plates at once: velocities at the poses' times are interpolated, and the forces of a step are
the momentum that it adds to each plate, over its length.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cases import Case, Cost, CoulombFriction, Trajectory
from cases.motion.mechanics import gravity
from cases.scene.free_plates import plate_contacts, plates_of, start_poses

from ..interface import EngineFailure
from .feature_contacts import with_plates
from .half_steps import rates_at_poses


@dataclass(frozen=True)
class PlatesRecord:
    """The record of a run: rows (x, y, theta, vx, vy, omega) of every plate at every step of `h` s, shape (n, plates,
    6), `steps` + 1 if it is complete. `rough`, `lever`, `rounding` and `rest` are those of `half_steps.StepRecord`;
    `wider` (m): by how much the engine's discs are larger than the case's, whose outlines slip where they roll."""

    case: Case
    h: float
    steps: int
    rows: np.ndarray
    rough: float = 0.0
    lever: float = 0.0
    rounding: float = float(np.finfo(float).eps)
    rest: float = 0.5
    wider: float = 0.0


def read(record: PlatesRecord) -> Trajectory:
    """The motion at the poses' times. Raises EngineFailure if it is no motion."""
    case, h, rows = record.case, record.h, record.rows
    plates = plates_of(case)
    if len(rows) < 3:
        raise EngineFailure("The engine returned fewer than three steps.")
    is_finite = np.isfinite(rows).all(axis=(1, 2))
    if not is_finite.all():
        raise EngineFailure(f"The engine's numbers are not finite from {h * int(np.argmin(is_finite)):.4g} s on.")
    before = np.concatenate([start_poses(case)[None, :, 3:], rows[:-1, :, 3:]])
    old, new = before.reshape(len(rows), -1), rows[..., 3:].reshape(len(rows), -1)
    rates = rates_at_poses(old, new, [plate.reach for plate in plates], record.rest).reshape(before.shape)
    spans = np.full(len(rows), h)
    spans[0] = h * (1.0 - record.rest)
    pull = np.append(gravity(case), 0.0)
    inertia = np.array([(p.mass, p.mass, p.inertia if p.turns else 1.0) for p in plates])
    torsor = inertia * ((rows[..., 3:] - before) / spans[:, None, None] - pull)
    clear = max(1e-6, 1e3 * record.rounding) * min(plate.inner for plate in plates) + 4.0 * record.rough
    clear += 2.0 * float(np.hypot(*gravity(case))) * h**2
    t = np.linspace(0.0, case.duration, record.steps + 1)[: len(rows)]
    motion = with_plates(case, t, rows[..., :3], rates, clear, torsor, record.lever)
    return replace(motion, slip_resolution=_creep(record, motion, torsor), cost=Cost(steps=len(rows)))


def _creep(record: PlatesRecord, motion: Trajectory, torsor: np.ndarray) -> float:
    """The slip velocity (m/s) that remains where the engine sticks: along a direction that turns within a step, with a
    normal force that scatters from step to step (`half_steps` has the derivation), and of discs that are wider."""
    case, friction = record.case, record.case.effect(CoulombFriction)
    creep, slips = 0.0, {name: columns.slip for name, columns in motion.contacts.items()}
    # A step with an impact or a lift-off, and its neighbours, have other forces.
    changes = np.zeros(len(motion.t) - 1, dtype=bool)
    for slip in slips.values():
        changes |= np.diff(np.isfinite(slip).astype(int)) != 0
    lasting = ~np.convolve(changes, np.ones(5), mode="same").astype(bool)
    for i, plate in enumerate(plates_of(case)):
        ease = 1.0 / plate.mass + (plate.reach**2 / plate.inertia if plate.turns else 0.0)
        scatter = np.abs(np.diff(np.hypot(*torsor[:, i, :2].T)))[lasting]
        usual = 0.5 * float(np.percentile(scatter, 99)) if len(scatter) else 0.0
        creep = max(creep, record.h * (friction.at_rest if friction else 0.0) * usual * ease)
    speed, turn = float(np.hypot(record.rows[..., 3], record.rows[..., 4]).max()), 0.0
    for contact in plate_contacts(case):
        if contact.base is None or contact.name not in slips:
            continue
        between = record.rows[:, contact.body, :2] - record.rows[:, contact.base, :2]
        turns = np.abs(np.diff(np.unwrap(np.arctan2(between[:, 1], between[:, 0]))))
        turn = max(turn, float(np.max(turns, initial=0.0, where=np.isfinite(np.diff(slips[contact.name])))))
    return creep + 0.5 * speed * turn**2 + record.wider * float(np.abs(record.rows[..., 5]).max())
