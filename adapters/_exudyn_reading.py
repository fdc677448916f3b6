"""How a run of Exudyn is read: what its sensors stored as a Trajectory, and what ended the motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cases import Case, Cost, Curve, PerfectlyRough, Trajectory, Unilateral

from ._exudyn_system import Contact, Stored, System, rough_friction, scales
from .interface import EngineFailure, Setting

LEFT = "The contact stopped pushing and the plate left its track."
# Where the normal and the friction force stand in a row of a trajectory.
_FORCES = slice(8, 10)


@dataclass
class Model:
    """A case in the engine; after the run also what it cost and, if the engine gave up, what it said."""

    case: Case
    setting: Setting
    system: System
    cost: Cost = Cost()
    failure: str | None = None


def read(model: Model) -> Trajectory:
    """The run as a Trajectory, cut where the plate leaves its track. Raises EngineFailure if it is no motion."""
    stored = _stored(model.system)
    t, contact = stored.t, model.system.contact(stored)
    known = len(contact.gap)
    rows = np.column_stack(
        [t[:known], stored.pose[:known], stored.velocity[:known]]
        + [contact.slip, contact.normal_force, contact.friction_force, contact.xi1, contact.xi2]
    )
    end = first_ending(model.case, model.setting, rows[:, 0], contact)
    if end is None and model.failure:
        raise EngineFailure(f"Exudyn stopped at {t[-1]:.4g} s: {model.failure}.")
    if end is None and contact.lost:
        raise EngineFailure(f"Exudyn's plate lost its track: {contact.lost}.")
    if end is not None:
        rows = _cut(rows, end)
    t, x, y, theta, vx, vy, omega, slip, normal_force, friction_force, xi1, xi2 = rows.T
    return Trajectory(
        *(t, x, y, theta, vx, vy, omega, slip, normal_force, friction_force, xi1, xi2),
        status=Trajectory.status if end is None else end.status,
        reason=Trajectory.reason if end is None else end.reason,
        cost=model.cost,
        slip_resolution=_creep(model.case, model.setting, friction_force),
    )


def _creep(case: Case, setting: Setting, friction_force: np.ndarray) -> float:
    """The slip velocity (m/s) of what sticks: none for a constraint, and vreg times friction's share of its scale."""
    vreg = float(dict(setting.values).get("vreg", 0.0))
    if not case.effect(PerfectlyRough):
        return vreg
    return vreg * max(1.0, float(np.abs(friction_force).max()) / rough_friction(case))


def _stored(system: System) -> Stored:
    """The run's arrays; raises EngineFailure where they are no numbers."""
    pose, velocity = (system.system.GetSensorStoredData(sensor) for sensor in system.motion)
    force = pose[:, :1] if system.force is None else system.system.GetSensorStoredData(system.force)
    # An unstable explicit run ends without an error.
    if not all(np.isfinite(table).all() for table in (pose, velocity, force)):
        raise EngineFailure("Exudyn's run blew up: its coordinates are not finite numbers.")
    return Stored(pose[:, 0], pose[:, 1:4], velocity[:, 1:4], force[:, 1:])


class Ending(NamedTuple):
    """The motion ends between the samples `sample` − 1 and `sample`, after `share` of that step, and why."""

    sample: int
    share: float
    status: str
    reason: str


def first_ending(case: Case, setting: Setting, t: np.ndarray, contact: Contact) -> Ending | None:
    """What ends the motion before its time, or None."""
    endings = [lift_off(case, setting, t, contact)]
    endings += [_domain_end("track", case.track, contact.xi1), _domain_end("outline", case.plate.outline, contact.xi2)]
    return min((end for end in endings if end), key=lambda end: end[:2], default=None)


def lift_off(case: Case, setting: Setting, t: np.ndarray, contact: Contact) -> Ending | None:
    """Where the plate, on its way off the track, stops being pressed; None if it stays, or if the track also pulls.

    A penalty contact loses touch for an instant when it is set down without its deflection, and by rounding at a
    release with N = 0. It then rises by about the static deflection m g/k or by what gravity does in a step, g h²/2;
    a plate clear of its track by ten times as much has left, and it left where it was last pressed.
    """
    if case.effect(Unilateral) is None:
        return None
    if "k" not in dict(setting.values):
        return _pulled(contact)
    _, acceleration = scales(case)
    rise = acceleration * (case.plate.mass / setting["k"] + 0.5 * setting["h"] ** 2)
    clear = np.flatnonzero(contact.gap > 10.0 * rise)
    if not clear.size:
        return None
    pressed = np.flatnonzero(contact.normal_force[: clear[0]] > 0.0)
    index = int(pressed[-1]) + 1 if pressed.size else 0
    share = 0.0
    if index >= 2:
        (t0, t1, t2), (N0, N1) = t[index - 2 : index + 1], contact.normal_force[index - 2 : index]
        # A force that does not fall there (a bounce) has no zero to extrapolate to; the last press is the end.
        share = min(N1 / (N0 - N1) * (t1 - t0) / (t2 - t1), 1.0) if N0 > N1 else 0.0
    return Ending(index, share, "lift_off", LEFT)


def _pulled(contact: Contact) -> Ending | None:
    """Where a constraint would begin to pull."""
    pulled = np.flatnonzero(contact.normal_force < 0.0)
    if not pulled.size:
        return None
    index, share = int(pulled[0]), 0.0
    if index:
        before, after = contact.normal_force[index - 1 : index + 1]
        share = float(before / (before - after))
    return Ending(index, share, "lift_off", LEFT)


def _domain_end(name: str, curve: Curve, xi: np.ndarray) -> Ending | None:
    if curve.domain is None or curve.period:
        return None
    low, high = curve.domain
    outside = np.flatnonzero((xi < low) | (xi > high))
    # Rounding may put the start itself outside; it is on the curve.
    if not outside.size or not outside[0]:
        return None
    before, after = xi[outside[0] - 1 : outside[0] + 1]
    share = ((high if after > high else low) - before) / (after - before)
    return Ending(int(outside[0]), float(share), f"{name}_end", f"The contact reached the end of the {name}'s domain.")


def _cut(rows: np.ndarray, end: Ending) -> np.ndarray:
    """The rows of the motion up to its end, whose own row lies between two of the run's."""
    kept = rows[: max(end.sample, 1)]
    if end.share <= 0.0:
        return kept
    last = rows[end.sample - 1] + end.share * (rows[end.sample] - rows[end.sample - 1])
    if end.status == "lift_off":
        last[_FORCES] = 0.0
    return np.vstack([kept, last])
