"""Reads motions with several contacts or plates of engines with positions at k·h and velocities half a step later.

The contacts follow from the poses and from the momentum that each step adds to each plate (`contacts_from_poses`).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cases import Cost, CoulombFriction, Trajectory
from cases.motion.mechanics import gravity
from cases.scene.couples import couples
from cases.scene.free_plates import plates_of

from .contacts_from_poses import with_plates
from .step_record import StepRecord, check_rows, rates_at_poses, torsor_of, velocities_before


def read(record: StepRecord) -> Trajectory:
    """The motion at the poses' times. Raises EngineFailure if it is no motion."""
    check_rows(record)
    case, h, rows, plates = record.case, record.h, record.rows, plates_of(record.case)
    shape = (len(rows), len(plates), 3)
    before, after = (each.reshape(len(rows), -1) for each in (velocities_before(record), rows[..., 3:]))
    rates = rates_at_poses(before, after, [plate.reach for plate in plates], record.rest).reshape(shape)
    torsor = torsor_of(record).reshape(shape)
    clear = max(1e-6, 1e3 * record.rounding) * min(plate.inner for plate in plates) + 4.0 * record.rough
    # On a track that turns gravity is one of the loads.
    clear += 2.0 * float(np.hypot(*gravity(case)) or record.pull or 0.0) * h**2
    t = np.linspace(0.0, case.duration, record.steps + 1)[: len(rows)]
    motion = with_plates(case, t, rows[..., :3].reshape(shape), rates, clear, torsor, record.lever)
    creep = _creep(record, motion, torsor) if case.others else _creep_of_one(record, motion, torsor[:, 0])
    return replace(motion, slip_resolution=creep, cost=Cost(steps=len(rows)))


def _creep_of_one(record: StepRecord, motion: Trajectory, torsor: np.ndarray) -> float:
    """`_creep` of one plate; friction acts on the levers of a step's beginning, which turn by its spin."""
    friction, plate = record.case.effect(CoulombFriction), record.case.plate
    scatter = 0.5 * float(np.percentile(np.abs(np.diff(np.hypot(*torsor[:, :2].T))), 99))
    ease = 1 / plate.mass + plate.reach**2 / plate.inertia
    lag = 0.0 if plate.radius else 0.5 * record.h * float(np.max(motion.omega**2)) * plate.reach
    return record.h * (friction.at_rest if friction else 0.0) * scatter * ease + lag


def _creep(record: StepRecord, motion: Trajectory, torsor: np.ndarray) -> float:
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
    for couple in couples(case):
        if couple.base is None:
            continue
        between = record.rows[:, couple.body, :2] - record.rows[:, couple.base, :2]
        turns = np.abs(np.diff(np.unwrap(np.arctan2(between[:, 1], between[:, 0]))))
        for name in (name for name in slips if name.split()[0] == couple.pair_name):
            turn = max(turn, float(np.max(turns, initial=0.0, where=np.isfinite(np.diff(slips[name])))))
    return creep + 0.5 * speed * turn**2 + record.wider * float(np.abs(record.rows[..., 5]).max())
