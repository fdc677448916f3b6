"""Reads a run of Exudyn: its sensor data as a Trajectory, and the event that ended the motion."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from math import pi, sqrt
from typing import NamedTuple

import numpy as np

from cases import Case, Cost, Curve, Flight, PerfectlyRough, Trajectory, Unilateral

from ..common.driven_tracks import to_fixed_frame
from ..common.flights import LANDING_REASON, LIFT_OFF_REASON, flights, lands_for_good
from ..interface import EngineFailure, Setting
from . import native
from .system import ExudynContact, ExudynSystem, clear_gap, rough_friction

# Columns of the normal and the friction force in a row of a trajectory; and all columns that only a contact has.
_FORCES, _TOUCH = slice(8, 10), slice(7, 12)


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
    data = model.system.data()
    contact = model.system.contact(data)
    count = len(contact.gap)
    rows = np.column_stack(
        [data.t[:count], data.pose[:count], data.velocity[:count]]
        + [contact.slip, contact.normal_force, contact.friction_force, contact.xi1, contact.xi2]
    )
    stretches = _flown(model.case, model.setting, contact)
    end = first_ending(model.case, model.setting, rows[:, 0], contact, stretches)
    if end is None and contact.failure and not model.failure:
        raise EngineFailure(f"Exudyn's plate lost its track: {contact.failure}.")
    if model.case.effect(Flight):
        rows = _without_contact(model, rows, stretches)
    if end is not None:
        rows = _until(rows, end)
    t, x, y, theta, vx, vy, omega, slip, normal_force, friction_force, xi1, xi2 = rows.T
    return Trajectory(
        *(t, x, y, theta, vx, vy, omega, slip, normal_force, friction_force, xi1, xi2),
        status=Trajectory.status if end is None else end.status,
        reason=Trajectory.reason if end is None else end.reason,
        slip_resolution=_creep(model.case, model.setting, friction_force),
    )


def _creep(case: Case, setting: Setting, friction_force: np.ndarray) -> float:
    """The slip velocity (m/s) of a sticking contact: zero for a constraint, else vreg times friction over its scale."""
    vreg = float(setting.get("vreg", 0.0))
    if not case.effect(PerfectlyRough):
        return vreg
    return vreg * max(1.0, float(np.abs(friction_force).max()) / rough_friction(case))


class MotionEnd(NamedTuple):
    """The end of a motion: after the fraction `share` of the step from sample `sample` − 1 to `sample`, and why."""

    sample: int
    share: float
    status: str
    reason: str


def first_ending(
    case: Case, setting: Setting, t: np.ndarray, contact: ExudynContact, stretches: list[tuple[int, int]]
) -> MotionEnd | None:
    """The first event that ends the motion early, or None."""
    endings = [_landing(case, t, contact, stretches) if case.effect(Flight) else lift_off(case, setting, t, contact)]
    endings += [_domain_end("track", case.track, contact.xi1), _domain_end("outline", case.plate.outline, contact.xi2)]
    return min((end for end in endings if end), key=lambda end: end[:2], default=None)


def _flown(case: Case, setting: Setting, contact: ExudynContact) -> list[tuple[int, int]]:
    """The ranges of samples in flight; none for a contact that may pull."""
    if case.effect(Unilateral) is None or "k" not in setting:
        return []
    return flights(contact.gap, contact.normal_force > 0.0, clear_gap(case, setting))


def lift_off(case: Case, setting: Setting, t: np.ndarray, contact: ExudynContact) -> MotionEnd | None:
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


def _landing(case: Case, t: np.ndarray, contact: ExudynContact, stretches: list[tuple[int, int]]) -> MotionEnd | None:
    """The landing of a plate without Impact, extrapolated from the last step of flight.

    (In the step that lands the contact already brakes the plate.)
    """
    landings = [(start, landing) for start, landing in stretches if landing < len(contact.gap)]
    if not landings or not lands_for_good(case):
        return None
    start, landing = landings[0]
    share = 1.0
    if landing - start >= 2:
        (t0, t1, t2), (before, after) = t[landing - 2 : landing + 1], contact.gap[landing - 2 : landing]
        share = min(after / (before - after) * (t1 - t0) / (t2 - t1), 1.0) if before > after else 1.0
    return MotionEnd(landing, float(share), "landing", LANDING_REASON)


def _without_contact(model: ExudynModel, rows: np.ndarray, stretches: list[tuple[int, int]]) -> np.ndarray:
    """The rows without contact values in flight: slip and contact parameters are NaN, forces 0.

    An impact takes some periods of the contact's spring here. A contact between two flights that is no longer than that
    is an impact, and its force is not a contact force of the case.
    """
    rows, impact = rows.copy(), 4.0 * pi * sqrt(model.case.plate.mass / model.setting["k"])
    for (_, lands), (leaves, _) in pairwise(stretches):
        if rows[leaves - 1, 0] - rows[lands, 0] <= impact:
            rows[lands:leaves, _TOUCH] = np.nan
    for start, stop in stretches:
        rows[start:stop, _TOUCH] = np.nan
        rows[start:stop, _FORCES] = 0.0
    return rows


def _pulling(contact: ExudynContact) -> MotionEnd | None:
    """The end of a unilateral motion, where a constraint would begin to pull."""
    pulling = np.flatnonzero(contact.normal_force < 0.0)
    if not pulling.size:
        return None
    index, share = int(pulling[0]), 0.0
    if index:
        before, after = contact.normal_force[index - 1 : index + 1]
        share = float(before / (before - after))
    return MotionEnd(index, share, "lift_off", LIFT_OFF_REASON)


def _domain_end(name: str, curve: Curve, xi: np.ndarray) -> MotionEnd | None:
    if curve.domain is None or curve.period:
        return None
    low, high = curve.domain
    outside = np.flatnonzero((xi < low) | (xi > high))
    # Rounding may put the start itself outside; it is on the curve.
    if not outside.size or not outside[0]:
        return None
    before, after = xi[outside[0] - 1 : outside[0] + 1]
    share = ((high if after > high else low) - before) / (after - before)
    return MotionEnd(
        int(outside[0]), float(share), f"{name}_end", f"The contact reached the end of the {name}'s domain."
    )


def _until(rows: np.ndarray, end: MotionEnd) -> np.ndarray:
    """The rows of the motion up to its end, with the end as an interpolated last row."""
    rows_before = rows[: max(end.sample, 1)]
    if end.share <= 0.0:
        return rows_before
    last = rows[end.sample - 1] + end.share * (rows[end.sample] - rows[end.sample - 1])
    # The force is zero where contact ends or begins.
    if end.status in ("lift_off", "landing"):
        last[_FORCES] = 0.0
    return np.vstack([rows_before, last])
