"""Reads a run of Exudyn: its sensor data as a Trajectory, and the event that ended the motion."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from math import pi, sqrt

import numpy as np

from cases import Case, Cost, Flight, PerfectlyRough, Trajectory, Unilateral

from ..common.driven_tracks import to_fixed_frame
from ..common.flights import LIFT_OFF_REASON, flights
from ..common.one_contact import (
    FORCES,
    TOUCH,
    ContactAlong,
    MotionEnd,
    domain_ends,
    first_of,
    landing,
    moved_to_end,
    trajectory,
)
from ..interface import EngineFailure, Setting
from . import native
from .system import ExudynSystem, clear_gap, rough_friction


@dataclass
class ExudynModel:
    """A case in the engine, for a driven track in the track's frame; after the run also its cost and, if the engine
    gave up, the engine's message. `outside` is the case in the fixed frame."""

    case: Case
    route: str
    setting: Setting
    system: ExudynSystem
    outside: Case
    cost: Cost = Cost()
    failure: str | None = None


def read(model: ExudynModel) -> Trajectory:
    """The run as a Trajectory, cut where the plate leaves its track. Raises EngineFailure if it is no motion."""
    motion = _with_one_contact(model) if model.system.contact else native.read(model.case, model.setting, model.system)
    if model.failure and motion.status == Trajectory.status:
        raise EngineFailure(f"Exudyn stopped at {motion.t[-1]:.4g} s: {model.failure}.")
    return to_fixed_frame(model.outside, replace(motion, cost=model.cost))


def _with_one_contact(model: ExudynModel) -> Trajectory:
    assert model.system.contact is not None
    case, setting, data = model.case, model.setting, model.system.data()
    contact = model.system.contact(data)
    count = len(contact.gap)
    rows = np.column_stack(
        [data.t[:count], data.pose[:count], data.velocity[:count]]
        + [contact.slip, contact.normal_force, contact.friction_force, contact.xi1, contact.xi2]
    )
    stretches = _flown(case, setting, contact)
    ends = [landing(case, data.t, contact.gap, stretches), *domain_ends(case, contact.xi1, contact.xi2)]
    if not case.effect(Flight):
        ends.append(_lift_off(case, setting, data.t, contact))
    end = first_of(ends)
    if end is None and contact.failure and not model.failure:
        raise EngineFailure(f"Exudyn's plate lost its track: {contact.failure}.")
    if case.effect(Flight):
        rows = _without_contact(model, rows, stretches)
    rows = moved_to_end(rows[: end.samples if end else count], end)
    return trajectory(rows, end, _creep(case, setting, rows[:, 9]), model.cost)


def _creep(case: Case, setting: Setting, friction_force: np.ndarray) -> float:
    """The slip velocity (m/s) of a sticking contact: zero for a constraint, else vreg times friction over its scale."""
    vreg = float(setting.get("vreg", 0.0))
    if not case.effect(PerfectlyRough):
        return vreg
    return vreg * max(1.0, float(np.abs(friction_force).max()) / rough_friction(case))


def _flown(case: Case, setting: Setting, contact: ContactAlong) -> list[tuple[int, int]]:
    """The ranges of samples in flight; none for a contact that may pull."""
    if case.effect(Unilateral) is None or "k" not in setting:
        return []
    return flights(contact.gap, contact.normal_force > 0.0, clear_gap(case, setting))


def _lift_off(case: Case, setting: Setting, t: np.ndarray, contact: ContactAlong) -> MotionEnd | None:
    """The lift-off, where the contact force of a leaving plate ends; None if it stays, or if the track also pulls."""
    if case.effect(Unilateral) is None:
        return None
    if "k" not in setting:
        return _pulling(contact)
    clear = np.flatnonzero(contact.gap > clear_gap(case, setting))
    if not clear.size:
        return None
    pushing = np.flatnonzero(contact.normal_force[: clear[0]] > 0.0)
    index = int(pushing[-1]) + 1 if pushing.size else 0
    share = 0.0
    if index >= 2:
        (t0, t1, t2), (N0, N1) = t[index - 2 : index + 1], contact.normal_force[index - 2 : index]
        # A force that does not decrease there (a bounce) has no zero to extrapolate to; the last push is the end.
        share = min(N1 / (N0 - N1) * (t1 - t0) / (t2 - t1), 1.0) if N0 > N1 else 0.0
    return MotionEnd(index, share, "lift_off", LIFT_OFF_REASON)


def _without_contact(model: ExudynModel, rows: np.ndarray, stretches: list[tuple[int, int]]) -> np.ndarray:
    """The rows without contact values in flight: slip and contact parameters are NaN, forces 0.

    An impact takes some periods of the contact's spring here. A contact between two flights that is no longer than that
    is an impact, and its force is not a contact force of the case.
    """
    rows, impact = rows.copy(), 4.0 * pi * sqrt(model.case.plate.mass / model.setting["k"])
    for (_, lands), (leaves, _) in pairwise(stretches):
        if rows[leaves - 1, 0] - rows[lands, 0] <= impact:
            rows[lands:leaves, TOUCH] = np.nan
    for start, stop in stretches:
        rows[start:stop, TOUCH] = np.nan
        rows[start:stop, FORCES] = 0.0
    return rows


def _pulling(contact: ContactAlong) -> MotionEnd | None:
    """The end of a unilateral motion, where a constraint would begin to pull."""
    pulling = np.flatnonzero(contact.normal_force < 0.0)
    if not pulling.size:
        return None
    index, share = int(pulling[0]), 0.0
    if index:
        before, after = contact.normal_force[index - 1 : index + 1]
        share = float(before / (before - after))
    return MotionEnd(index, share, "lift_off", LIFT_OFF_REASON)
