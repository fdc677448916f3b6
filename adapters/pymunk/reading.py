"""How a run of pymunk is read: its rows as a Trajectory, and what ended the motion."""

from __future__ import annotations

from array import array
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import pymunk

from cases import Case, CoulombFriction, Flight, Trajectory
from cases.contact import Contact, slip_velocity, start_motion
from cases.trajectory import Cost

from ..common.follow import BEYOND, LANDED, LEFT, Follower, flights, lands_for_good
from ..interface import EngineFailure
from . import assisted, native
from .load import Drive


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
    # Six numbers to a row. Boxed ones would take ten times the memory, which is gigabytes for a long motion.
    rows: array[float] = field(default_factory=lambda: array("d"))


class _Contacts(NamedTuple):
    """Contact parameters and gap (m) of the leading poses that have a contact point, arrays of one length."""

    xi1: np.ndarray
    xi2: np.ndarray
    gap: np.ndarray


class _Rows(NamedTuple):
    """What the engine did, by row: pose, velocities at it, contact force (N).

    `falling`, `rising`: the velocities there if the plate flew from, or flies to, those half a step before, or after.
    """

    pose: np.ndarray
    rates: np.ndarray
    force: np.ndarray
    falling: np.ndarray
    rising: np.ndarray


class _Ending(NamedTuple):
    """How many samples belong to the motion, and what ended it; `time` if that lies before the last of them."""

    kept: int
    status: str = Trajectory.status
    reason: str = Trajectory.reason
    time: float = np.nan


def read(model: Model) -> Trajectory:
    """The motion at the poses' times, cut where the plate left its track. Raises EngineFailure if it is no motion."""
    case, rows = model.case, _rows(model)
    contacts = _told(model.guide) if model.guide else _follow(case, rows.pose)
    # A force is a difference of velocities over h: ten roundings of the velocity bound what it is off by.
    rounding = 10 * np.finfo(float).eps * case.plate.mass * float(np.abs(rows.rates[:, :2]).max()) / model.h
    strength = np.hypot(*rows.force.T)
    pressed = strength > 1e-9 * strength.max() + rounding
    hop = _hop(case, float(strength.max()), rows.rates, model.h, model.roughness)
    flown = flights(contacts.gap, pressed[: len(contacts.gap)], hop)
    ending = _ending(case, contacts, rows.pose, flown)
    if ending.status == "lift_off":
        first = int(np.argmax(contacts.gap > hop))
        ending = _let_go(ending, strength, np.flatnonzero(pressed[: ending.kept]), first, model.h)
    if ending.status == "landing":
        ending = _touched(ending, contacts.gap, model.h)
    return _trajectory(model, rows, contacts, flown, ending)


def _rows(model: Model) -> _Rows:
    case, rows, start = model.case, np.array(model.rows).reshape(-1, 6), start_motion(model.case)
    if not np.isfinite(rows).all():
        when = model.h * int(np.argmin(np.isfinite(rows).all(axis=1)))
        raise EngineFailure(f"pymunk's numbers are not finite from {when:.4g} s on.")
    pose, after = rows[:, :3], rows[:, 3:]
    before = np.vstack([[start.vx, start.vy, start.omega], after[:-1]])
    kick = np.full((len(rows), 1), model.h)
    kick[0] *= 0.5
    pushed = np.broadcast_to(case.plate.mass * native.pull(case), (len(rows), 2))
    if model.drive:
        pushed = pushed + _driven(model.drive)
    force = case.plate.mass * (after - before)[:, :2] / kick - pushed
    half = np.zeros_like(after)
    half[:, :2] = 0.5 * model.h * pushed / case.plate.mass
    rates = rates_at_poses(before, after, native.radii(case)[1])
    return _Rows(pose, rates, force, before + half, after - half)


def _trajectory(model: Model, rows: _Rows, contacts: _Contacts, flown: list[tuple[int, int]], ending: _Ending):
    """The kept rows with slip and forces along the track; in flight there are none."""
    case, kept = model.case, ending.kept
    (x, y, theta), (vx, vy, omega) = rows.pose[:kept].T, rows.rates[:kept].T
    xi1, xi2, gap = (part[:kept] for part in contacts)
    # The engine sticks at the plate's own point, a gap away from the track's: with the centre moved by the gap the
    # lever arm is the engine's.
    nx, ny = case.track.normal(xi1)
    normal_force = rows.force[:kept, 0] * nx + rows.force[:kept, 1] * ny
    friction_force = np.sum(rows.force[:kept].T * case.track.tangent(xi1), axis=0)
    slip = slip_velocity(case, x - gap * nx, y - gap * ny, vx, vy, omega, xi1)
    creep = _creep(case, xi1, rows.rates[:kept], normal_force, model.h)
    if model.guide is None:
        creep += _lag(case, xi1, rows.pose[:kept], omega)
    if case.effect(Flight):
        for leaves, lands in flown:
            for values in (slip, xi1, xi2):
                values[leaves:lands] = np.nan
            for values in (normal_force, friction_force):
                values[leaves:lands] = 0.0
    t = np.linspace(0.0, case.duration, model.steps + 1)[:kept]
    columns = [t, x, y, theta, vx, vy, omega, slip, normal_force, friction_force, xi1, xi2]
    if case.effect(Flight):
        columns = _both_sides(columns, rows, flown)
    if np.isfinite(ending.time):
        t = columns[0]
        share = (ending.time - t[-2]) / (t[-1] - t[-2])
        columns = [np.append(values[:-1], values[-2] + share * (values[-1] - values[-2])) for values in columns]
        # Where contact ends, or has not begun, nothing presses.
        columns[8][-1] = columns[9][-1] = 0.0
    t, x, y, theta, vx, vy, omega, slip, normal_force, friction_force, xi1, xi2 = columns
    return Trajectory(
        *(t, x, y, theta, vx, vy, omega, slip, normal_force, friction_force, xi1, xi2),
        status=ending.status,
        reason=ending.reason,
        cost=Cost(steps=model.steps + 1),
        slip_resolution=creep,
    )


def _both_sides(columns: list[np.ndarray], rows: _Rows, flown: list[tuple[int, int]]) -> list[np.ndarray]:
    """The columns with two rows for every landing that is no end: as the plate flew there, and as it goes on.

    An impact has no duration, so the force of its step is none of a contact: it is not known (NaN).
    """
    table, kept = np.column_stack(columns), len(columns[0])
    landings = [landing for _, landing in flown if landing < kept - 1]
    nowhere = [np.nan, 0.0, 0.0, np.nan, np.nan]
    for landing in reversed(landings):
        flying = [*table[landing, :4], *rows.falling[landing], *nowhere]
        bounces = any(start == landing + 1 for start, _ in flown)
        if bounces:
            table[landing, 4:7], table[landing, 7:] = rows.rising[landing], [np.nan, np.nan, np.nan, np.nan, np.nan]
        table[landing, 8:10] = np.nan
        table = np.insert(table, landing, flying, axis=0)
    return list(table.T)


def _let_go(ending: _Ending, strength: np.ndarray, pushes: np.ndarray, first: int, h: float) -> _Ending:
    """The ending moved to where the force vanishes, before the sample `first` that is surely off the track.

    The weaker a contact, the more steps lie between two that push; the force over a hop is the push over its steps. It
    is extrapolated by a line through the last six, for no longer than the last hop: another push would have come.
    """
    last = pushes[-7:]
    if len(last) < 3:
        return ending
    hops = np.diff(last)
    slope, level = np.polyfit(0.5 * (last[:-1] + last[1:] - 1), strength[last[:-1]] / hops, 1)
    if slope >= 0.0:
        return ending
    vanishes = float(np.clip(-level / slope, last[-1], min(first, last[-1] + hops[-1])))
    return ending._replace(kept=max(int(np.ceil(vanishes)) + 1, 2), time=vanishes * h)


def _touched(ending: _Ending, gap: np.ndarray, h: float) -> _Ending:
    """The ending moved to where the gap closes, as it closes between the last sample in flight and the first pressed.

    A contact that is told presses at the beginning of the step in which the plate would land; it lands at its end.
    """
    before, after = gap[ending.kept - 2 : ending.kept]
    share = min(before / (before - after), 2.0) if before > after else 1.0
    return ending._replace(time=(ending.kept - 2 + share) * h)


def rates_at_poses(before: np.ndarray, after: np.ndarray, size: float) -> np.ndarray:
    """Velocities at the poses' times from those half a step before and after, arrays (n, 3); the first is the start's.

    The mean of the two is off by h²/8 of the second derivative, as much as the engine itself; that is taken off by the
    smaller of the second differences to either side, so that none reaches across a jump of the acceleration. (All
    three from one side: only together do they make a slip velocity. Spin counts by the plate's `size`, m.)
    """
    bend = np.diff(after, 2, axis=0)
    left, right = np.vstack([bend[:1], bend]), np.vstack([bend, bend[-1:]])
    scale = np.array([1.0, 1.0, size])
    nearer = np.linalg.norm(left * scale, axis=1) < np.linalg.norm(right * scale, axis=1)
    smaller = np.where(nearer[:, None], left, right)
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


def _follow(case: Case, pose: np.ndarray) -> _Contacts:
    """The contacts of the poses, up to the first that has none although the plate may not fly."""
    follower, rows = Follower(case), []
    for x, y, theta in pose.tolist():
        try:
            rows.append(follower(x, y, theta))
        except BEYOND:
            break
    return _table(rows)


def _ending(case: Case, contacts: _Contacts, pose: np.ndarray, flown: list[tuple[int, int]]) -> _Ending:
    """The first of the things that end a motion, or the end of its time."""
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
    if flown and case.effect(Flight) is None:
        endings.append(_Ending(max(flown[0][0], 1), "lift_off", LEFT))
    landed = [landing for _, landing in flown if landing < found]
    if landed and lands_for_good(case):
        endings.append(_Ending(landed[0] + 1, "landing", LANDED))
    return min(endings, key=lambda ending: ending.kept)


def _hop(case: Case, strongest: float, rates: np.ndarray, h: float, roughness: float) -> float:
    """A gap in metres that only a plate in flight reaches.

    An engine lets a plate go for a step and catches it in the next: such hops are about ½ a h² with the acceleration a
    of gravity or contact; and facets stand off the curve by their sagitta (`roughness`). Four times that, and a
    millionth of the plate for rounding, is a flight. The `strongest` force (N) of a plate that flies is an impact's;
    what its path and its spin ask for takes its place.
    """
    smallest, largest = native.radii(case)
    pushed = strongest / case.plate.mass
    if case.effect(Flight):
        speed = np.hypot(rates[:, 0], rates[:, 1]) + np.abs(rates[:, 2]) * largest
        pushed = float(speed.max()) ** 2 / smallest
    return 1e-6 * smallest + 2.0 * (float(np.hypot(*native.pull(case))) + pushed) * h**2 + 4.0 * roughness


def _creep(case: Case, xi1: np.ndarray, rates: np.ndarray, normal_force: np.ndarray, h: float) -> float:
    """The slip velocity (m/s) that remains where the engine sticks, in all but one step in a hundred.

    It sticks with the velocities of a half step, along a tangent that turns by some angle a in a step: the mean of
    two such velocities misses by v a²/8 at the centre, and by as much at the contact, whose lever turns too; doubled
    for plates whose outline bends more than the track. And on facets the normal force scatters from step to step:
    where it falls short, so does friction, for one step.
    """
    turns = np.abs(np.diff(case.track.tangent_angle(xi1)))
    turn = float(np.max(turns[np.isfinite(turns)], initial=0.0))
    # Half the difference of two neighbours is their distance from what they scatter about; the rarest are jumps.
    jumps = np.abs(np.diff(normal_force))
    jumps = jumps[np.isfinite(jumps)]
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
    lagging = lagging[np.isfinite(lagging)]
    return float(np.percentile(lagging, 99)) if lagging.size else 0.0
