"""How a run of pymunk is read: its rows as a Trajectory, and what ended the motion."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import pymunk

from cases import Case, CoulombFriction, Trajectory
from cases.contact import Contact, Motion, find, slip_velocity, start_motion
from cases.trajectory import Cost

from . import _pymunk_assisted as assisted
from . import _pymunk_native as native
from ._pymunk_load import Drive
from .interface import EngineFailure


@dataclass
class Model:
    """One run: the space, its moving body, the step in seconds and how many, the recorded rows.

    `drive`: its load; `roughness`: sagitta in metres of the facets that stand for the curves; `guide`: what the
    assisted route tells.
    """

    case: Case
    route: str
    space: pymunk.Space
    body: pymunk.Body
    h: float
    steps: int
    drive: Drive | None = None
    roughness: float = 0.0
    guide: assisted.Guide | None = None
    rows: list[tuple[float, ...]] = field(default_factory=list)


class _Contacts(NamedTuple):
    """Contact parameters and gap (m) of the leading poses that have a contact point, arrays of one length."""

    xi1: np.ndarray
    xi2: np.ndarray
    gap: np.ndarray


class _Ending(NamedTuple):
    """How many samples belong to the motion, and what ended it."""

    kept: int
    status: str = Trajectory.status
    reason: str = Trajectory.reason


def read(model: Model) -> Trajectory:
    """The motion at the poses' times, cut where the plate left its track. Raises EngineFailure if it is no motion."""
    case, rows = model.case, np.array(model.rows)
    if not np.isfinite(rows).all():
        when = model.h * int(np.argmin(np.isfinite(rows).all(axis=1)))
        raise EngineFailure(f"pymunk's numbers are not finite from {when:.4g} s on.")
    start = start_motion(case)
    pose, after = rows[:, :3], rows[:, 3:]
    before = np.vstack([[start.vx, start.vy, start.omega], after[:-1]])
    rates = rates_at_poses(before, after)
    kick = np.full((len(rows), 1), model.h)
    kick[0] *= 0.5
    force = case.plate.mass * ((after - before)[:, :2] / kick - native.pull(case))
    if model.drive:
        force -= _driven(model.drive)
    contacts = _told(model.guide) if model.guide else _follow(case, start, pose)
    # A force is a difference of velocities over h: ten roundings of the velocity bound what it is off by.
    rounding = 10 * np.finfo(float).eps * case.plate.mass * float(np.abs(rates[:, :2]).max()) / model.h
    ending = _ending(case, contacts, pose, force, rounding, _hop(case, force, model.h, model.roughness))
    pose, rates, force = pose[: ending.kept], rates[: ending.kept], force[: ending.kept]
    xi1, xi2, gap = (part[: ending.kept] for part in contacts)
    x, y, theta = pose.T
    vx, vy, omega = rates.T
    # The engine sticks at the plate's own point, a gap away from the track's: with the centre moved by the gap the
    # lever arm is the engine's.
    nx, ny = case.track.normal(xi1)
    normal_force = force[:, 0] * nx + force[:, 1] * ny
    return Trajectory(
        t=np.linspace(0.0, case.duration, model.steps + 1)[: ending.kept],
        x=x,
        y=y,
        theta=theta,
        vx=vx,
        vy=vy,
        omega=omega,
        slip=slip_velocity(case, x - gap * nx, y - gap * ny, vx, vy, omega, xi1),
        normal_force=normal_force,
        friction_force=np.sum(force.T * case.track.tangent(xi1), axis=0),
        xi1=xi1,
        xi2=xi2,
        status=ending.status,
        reason=ending.reason,
        cost=Cost(steps=model.steps + 1),
        slip_resolution=_creep(case, xi1, rates, normal_force, model.h)
        + (0.0 if model.guide else _lag(case, xi1, pose, omega)),
    )


def rates_at_poses(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Velocities at the poses' times from those half a step before and after, arrays (n, 3); the first is the start's.

    The mean of the two is off by h²/8 of the second derivative, as much as the engine itself; that is taken off by the
    smaller of the second differences to either side, so that none reaches across a jump of the acceleration.
    """
    bend = np.diff(after, 2, axis=0)
    left, right = np.vstack([bend[:1], bend]), np.vstack([bend, bend[-1:]])
    smaller = np.where(np.abs(left) < np.abs(right), left, right)
    rates = 0.5 * (before + after)
    rates[0] = before[0]
    rates[1:] -= smaller / 8.0
    return rates


def _driven(drive: Drive) -> np.ndarray:
    """The load's forces (F_x, F_y) of every step. Raises EngineFailure if its formula had no value."""
    if drive.problem:
        raise EngineFailure(f"The load has no value somewhere: {drive.problem}") from drive.problem
    return np.array(drive.rows)


def _told(guide: assisted.Guide) -> _Contacts:
    """The contacts the engine was told. Raises EngineFailure if telling it failed."""
    if guide.problem:
        raise EngineFailure(f"The contact could not be told to pymunk: {guide.problem}") from guide.problem
    return _table(guide.contacts)


def _table(contacts: list[Contact]) -> _Contacts:
    xi1, xi2, gap = np.array(contacts, dtype=float).reshape(-1, 3).T
    return _Contacts(xi1, xi2, gap)


def _follow(case: Case, start: Motion, pose: np.ndarray) -> _Contacts:
    """The contacts of the poses, up to the first pose that has none near the one before."""
    near, rows = (start.xi1, start.xi2), []
    for x, y, theta in pose.tolist():
        try:
            contact = find(case, x, y, theta, near)
        except assisted.BEYOND:
            break
        near = (contact.xi1, contact.xi2)
        rows.append(contact)
    return _table(rows)


def _ending(
    case: Case, contacts: _Contacts, pose: np.ndarray, force: np.ndarray, rounding: float, hop: float
) -> _Ending:
    """The first of the things that end a motion, or the end of its time.

    A contact pushes with more than the `rounding` (N) of the forces; a gap (m) above `hop` is a flight.
    """
    found = len(contacts.gap)
    endings = [_Ending(len(pose))]
    smallest, _ = native.radii(case)
    through = contacts.gap < -smallest
    if through.any():
        endings.append(_Ending(int(np.argmax(through)), "fell_through", "The plate passed through its track."))
    for name, curve, xi in (("track", case.track, contacts.xi1), ("outline", case.plate.outline, contacts.xi2)):
        if curve.domain and not curve.period:
            # Where there was no contact any more, the next one would have been about as far ahead as the last.
            xi = np.append(xi, 2 * xi[-1] - xi[-2]) if 1 < found < len(pose) else xi
            outside = (xi < curve.domain[0]) | (xi > curve.domain[1])
            if outside.any():
                reason = f"The contact reached the end of the {name}'s domain."
                endings.append(_Ending(int(np.argmax(outside)), f"{name}_end", reason))
    if found < len(pose):
        endings.append(_Ending(found, "lost_track", "No point of the track is near the plate any more."))
    flown = contacts.gap > hop
    if flown.any():
        strength = np.hypot(*force[: int(np.argmax(flown)) + 1].T)
        pushed = np.flatnonzero(strength > 1e-9 * strength.max() + rounding)
        kept = int(pushed[-1]) + 1 if pushed.size else 1
        endings.append(_Ending(kept, "lift_off", "The contact stopped pushing and the plate left its track."))
    return min(endings, key=lambda ending: ending.kept)


def _hop(case: Case, force: np.ndarray, h: float, roughness: float) -> float:
    """A gap in metres that only a plate in flight reaches.

    An engine lets a plate go for a step and catches it in the next: such hops are about ½ a h² with the acceleration a
    of gravity or contact; and facets stand off the curve by their sagitta (`roughness`). Four times that, and a
    millionth of the plate for rounding, is a flight; the cut goes back to the flight's beginning.
    """
    strongest = float(np.hypot(*native.pull(case))) + float(np.hypot(*force.T).max()) / case.plate.mass
    return 1e-6 * native.radii(case)[0] + 2.0 * strongest * h**2 + 4.0 * roughness


def _creep(case: Case, xi1: np.ndarray, rates: np.ndarray, normal_force: np.ndarray, h: float) -> float:
    """The slip velocity (m/s) that remains where the engine sticks, in all but one step in a hundred.

    It sticks with the velocities of a half step, along a tangent that turns by some angle a in a step: the mean of
    two such velocities misses by v a²/8 at the centre, and by as much at the contact, whose lever turns too; doubled
    for plates whose outline bends more than the track. And on facets the normal force scatters from step to step:
    where it falls short, so does friction, for one step.
    """
    turn = float(np.abs(np.diff(case.track.tangent_angle(xi1))).max(initial=0.0))
    # Half the difference of two neighbours is their distance from what they scatter about; the rarest are jumps.
    jumps = np.abs(np.diff(normal_force))
    scatter = 0.5 * float(np.percentile(jumps, 99)) if jumps.size else 0.0
    friction, plate = case.effect(CoulombFriction), case.plate
    ease = 1 / plate.mass + native.radii(case)[1] ** 2 / plate.inertia
    missing = h * (friction.mu if friction else 0.0) * scatter * ease
    return float(0.5 * np.hypot(rates[:, 0], rates[:, 1]).max() * turn**2) + missing


def _lag(case: Case, xi1: np.ndarray, pose: np.ndarray, omega: np.ndarray) -> float:
    """The slip velocity (m/s) that the engine's own shapes leave in stick, in all but one step in a hundred.

    The engine sticks with the lever of the step's beginning. Along the normal that of a plate that is no disc grows or
    shrinks, and in the middle of the step it differs by half of its change.
    """
    lever = np.sum((case.track.point(xi1) - pose[:, :2].T) * case.track.normal(xi1), axis=0)
    lagging = 0.5 * np.abs(omega[1:] * np.diff(lever))
    return float(np.percentile(lagging, 99)) if lagging.size else 0.0
