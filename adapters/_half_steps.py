"""The motion out of an engine whose positions stand at k·h and velocities half a step later.

That is semi-implicit Euler, the step of game engines, after a first step of h/2 (with substeps, one that is half a
substep short). Velocities at the positions' times are weighted means of their neighbours: second order. Forces are what
the contact added to the momentum in a step, over its length. Nothing here knows an engine.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cases import Case, Cost, CoulombFriction, Trajectory
from cases.contact import Contact, find, slip_velocity, start_motion

from ._facets import pull, radii
from .interface import EngineFailure

# What a curve may raise where its expression has no value (DoesNotFit is one of them): beyond its domain.
BEYOND = (ValueError, ArithmeticError)


@dataclass(frozen=True)
class Noted:
    """What a run noted: rows (x, y, theta, vx, vy, omega) at every step of `h` s, `steps` + 1 if it ran to its end.

    `contacts`: those of the rows if the engine was told them, else they are found. `rough`: how far (m) the engine's
    shapes stand off the curves. `lever`: what share of the gap the engine puts between the plate and the point
    where friction acts. `rounding`: relative, of its numbers. `rest`: what the first step was short of, over h.
    """

    case: Case
    h: float
    steps: int
    rows: list[tuple[float, ...]] | np.ndarray
    contacts: list[Contact] | None = None
    rough: float = 0.0
    lever: float = 0.0
    rounding: float = float(np.finfo(float).eps)
    rest: float = 0.5


def rest(substeps: int) -> float:
    """What the first step is short of, over its length: half a substep."""
    return 0.5 / substeps


class _Ending(NamedTuple):
    """How many samples belong to the motion, and what ended it."""

    kept: int
    status: str = Trajectory.status
    reason: str = Trajectory.reason


def read(noted: Noted) -> Trajectory:
    """The motion at the poses' times, cut where the plate left its track. Raises EngineFailure if it is no motion."""
    case, h, rows = noted.case, noted.h, np.array(noted.rows)
    if len(rows) < 3 or not np.isfinite(rows).all():
        raise EngineFailure("its numbers are not finite, or there are fewer than three steps of them.")
    start, after = start_motion(case), rows[:, 3:]
    before = np.vstack([[start.vx, start.vy, start.omega], after[:-1]])
    rates = (1.0 - noted.rest) * before + noted.rest * after
    rates[0] = before[0]
    kick = np.full((len(rows), 1), h)
    kick[0] *= 1.0 - noted.rest
    force = case.plate.mass * ((after - before)[:, :2] / kick - pull(case))
    contacts = (noted.contacts or _follow(case, rows[:, :3]))[: len(rows)]
    xi1, xi2, gap = np.array(contacts, dtype=float).reshape(-1, 3).T
    ending = _ending(noted, xi1, xi2, gap, force, float(np.abs(rates[:, :2]).max()))
    kept = slice(ending.kept)
    xi1, xi2, gap, force, rates = xi1[kept], xi2[kept], gap[kept], force[kept], rates[kept]
    (x, y, theta), (vx, vy, omega) = rows[kept, :3].T, rates.T
    normal, tangent = case.track.normal(xi1), case.track.tangent(xi1)
    normal_force = np.sum(force.T * normal, axis=0)
    # With the centre moved by what the engine leaves between plate and contact, the lever is the engine's.
    moved = (1.0 - noted.lever) * gap * normal
    return Trajectory(
        t=h * np.arange(ending.kept), x=x, y=y, theta=theta, vx=vx, vy=vy, omega=omega, xi1=xi1, xi2=xi2,
        slip=slip_velocity(case, x - moved[0], y - moved[1], vx, vy, omega, xi1),
        normal_force=normal_force, friction_force=np.sum(force.T * tangent, axis=0),
        status=ending.status, reason=ending.reason, cost=Cost(steps=len(rows)),
        slip_resolution=_creep(case, xi1, rates, normal_force, h),
    )  # fmt: skip


def _follow(case: Case, poses: np.ndarray) -> list[Contact]:
    """The contacts of the poses, up to the first pose that has none near the one before."""
    start = start_motion(case)
    near, found = (start.xi1, start.xi2), list[Contact]()
    for x, y, theta in poses.tolist():
        try:
            contact = find(case, x, y, theta, near)
        except BEYOND:
            break
        near = contact[:2]
        found.append(contact)
    return found


def _ending(noted: Noted, xi1, xi2, gap, force: np.ndarray, speed: float) -> _Ending:
    """The first of the things that end a motion, or the end of its time."""
    case, found, asked = noted.case, len(gap), noted.steps + 1
    endings = [_Ending(asked)]
    through = gap < -radii(case)[0]
    if through.any():
        endings.append(_Ending(int(np.argmax(through)), "fell_through", "The plate passed through its track."))
    for name, curve, xi in (("track", case.track, xi1), ("outline", case.plate.outline, xi2)):
        if curve.domain and not curve.period:
            # Where there was no contact any more, the next one would have been about as far ahead as the last.
            xi = np.append(xi, 2 * xi[-1] - xi[-2]) if 1 < found < asked else xi
            outside = (xi < curve.domain[0]) | (xi > curve.domain[1])
            if outside.any():
                reason = f"The contact reached the end of the {name}'s domain."
                endings.append(_Ending(int(np.argmax(outside)), f"{name}_end", reason))
    if found < asked:
        endings.append(_Ending(found, "lost_track", "No point of the track is near the plate any more."))
    flown = gap > _hop(noted, force)
    if flown.any():
        strength = np.hypot(*force[: int(np.argmax(flown)) + 1].T)
        # A force is a difference of velocities over h: ten roundings of the velocity bound what it is off by.
        least = 1e-9 * strength.max() + 10 * noted.rounding * case.plate.mass * speed / noted.h
        pushed = np.flatnonzero(strength > least)
        kept = int(pushed[-1]) + 1 if pushed.size else 1
        endings.append(_Ending(kept, "lift_off", "The contact stopped pushing and the plate left its track."))
    return min(endings, key=lambda ending: ending.kept)


def _hop(noted: Noted, force: np.ndarray) -> float:
    """A gap in metres that only a plate in flight reaches.

    An engine lets a plate go for a step and catches it in the next: such hops are about ½ a h² with the acceleration a
    of gravity or contact; and facets stand off the curve. Four times that, and a millionth of the plate for rounding,
    is a flight; the cut goes back to the flight's beginning.
    """
    case = noted.case
    strongest = float(np.hypot(*pull(case))) + float(np.hypot(*force.T).max()) / case.plate.mass
    return 1e-6 * radii(case)[0] + 2.0 * strongest * noted.h**2 + 4.0 * noted.rough


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
    ease = 1 / plate.mass + radii(case)[1] ** 2 / plate.inertia
    missing = h * (friction.mu if friction else 0.0) * scatter * ease
    return float(0.5 * np.hypot(rates[:, 0], rates[:, 1]).max() * turn**2) + missing
