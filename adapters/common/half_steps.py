"""The motion out of an engine whose positions stand at k·h and velocities half a step later.

That is semi-implicit Euler, the step of game engines, after a first step of h/2 (with substeps, one that is half a
substep short). Velocities at the positions' times are weighted means of their neighbours: second order. Forces are what
the contact added to the momentum in a step, over its length. Nothing here knows an engine.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import nan
from typing import NamedTuple

import numpy as np

from cases import Case, Cost, CoulombFriction, Flight, Trajectory
from cases.contact import Contact, slip_velocity, start_motion

from ..interface import EngineFailure
from .facets import pull, radii
from .follow import BEYOND, LANDED, LEFT, Follower, flights, lands_for_good


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


@dataclass(frozen=True)
class Samples:
    """Samples at the poses' times: arrays of one length; `aloft` where no contact is.

    `t` (s); `pose` (n, 3); `before`: velocities (n, 3) if nothing pushed since those the engine told; `rebound`,
    `resting`: the next it told, without and with the gravity since then; `rates`: means; `force` (n, 2) of the
    contact, N; contact parameters and gap (m).
    """

    t: np.ndarray
    pose: np.ndarray
    before: np.ndarray
    rebound: np.ndarray
    resting: np.ndarray
    rates: np.ndarray
    force: np.ndarray
    xi1: np.ndarray
    xi2: np.ndarray
    gap: np.ndarray
    aloft: np.ndarray

    def __getitem__(self, places) -> Samples:
        """The samples at these places."""
        return replace(self, **{name: getattr(self, name)[places] for name in self.__dataclass_fields__})

    @property
    def landings(self) -> np.ndarray:
        """The places of the first samples after flights."""
        return np.flatnonzero(self.aloft[:-1] & ~self.aloft[1:]) + 1


class _Ending(NamedTuple):
    """How many samples belong to the motion, and what ended it."""

    kept: int
    status: str = Trajectory.status
    reason: str = Trajectory.reason


def read(noted: Noted) -> Trajectory:
    """The motion at the poses' times, cut where the plate left its track. Raises EngineFailure if it is no motion.

    Where the case has Flight the plate's leaving is no end.
    """
    samples, hop = _samples(noted)
    ending = _ending(noted, samples, hop)
    samples = samples[: ending.kept]
    if samples.aloft.any():
        samples = _both_sides(samples)
    case, up, xi1 = noted.case, samples.aloft, samples.xi1
    normal, tangent = case.track.normal(xi1), case.track.tangent(xi1)
    (x, y, theta), (vx, vy, omega), force = samples.pose.T, samples.rates.T, samples.force.T
    normal_force = np.where(up, 0.0, np.sum(force * normal, axis=0))
    # With the centre moved by what the engine leaves between plate and contact, the lever is the engine's.
    moved = (1.0 - noted.lever) * samples.gap * normal
    slip = slip_velocity(case, x - moved[0], y - moved[1], vx, vy, omega, xi1)
    return Trajectory(
        t=samples.t, x=x, y=y, theta=theta, vx=vx, vy=vy, omega=omega,
        xi1=np.where(up, np.nan, xi1), xi2=np.where(up, np.nan, samples.xi2), slip=np.where(up, np.nan, slip),
        normal_force=normal_force, friction_force=np.where(up, 0.0, np.sum(force * tangent, axis=0)),
        status=ending.status, reason=ending.reason, cost=Cost(steps=len(noted.rows)),
        slip_resolution=_creep(case, samples[~up], normal_force[~up], noted.h),
    )  # fmt: skip


def _samples(noted: Noted) -> tuple[Samples, float]:
    """Everything at the poses' times, up to the first pose without contact, and the gap (m) only a flight reaches."""
    case, h, rows = noted.case, noted.h, np.array(noted.rows)
    if len(rows) < 3 or not np.isfinite(rows).all():
        raise EngineFailure("its numbers are not finite, or there are fewer than three steps of them.")
    start, after = start_motion(case), rows[:, 3:]
    before = np.vstack([[start.vx, start.vy, start.omega], after[:-1]])
    late, gravity = np.full((len(rows), 1), noted.rest * h), np.append(pull(case), 0.0)
    late[0] = 0.0
    ahead = h * (1.0 - noted.rest)
    kick = late + ahead
    force = case.plate.mass * ((after - before) / kick - gravity)[:, :2]
    rates = (before * ahead + after * late) / kick
    pressed = _pressed(noted, force, float(np.abs(rates[:, :2]).max()))
    flies = case.effect(Flight) is not None
    hop = _hop(noted, rates, force if not flies else None)
    contacts = (noted.contacts or _follow(case, rows[:, :3]))[: len(rows)]
    xi1, xi2, gap = np.array(contacts, dtype=float).reshape(-1, 3).T
    count = len(gap)
    up = np.zeros(count, dtype=bool)
    for leaves, lands in flights(gap, pressed[:count], hop) if flies else ():
        up[leaves:lands] = True
    samples = Samples(
        t=h * np.arange(count), pose=rows[:count, :3], xi1=xi1, xi2=xi2, gap=gap, aloft=up,
        before=(before + late * gravity)[:count], rebound=(after - ahead * gravity)[:count], resting=after[:count],
        rates=rates[:count], force=force[:count],
    )  # fmt: skip
    return samples, hop


def _follow(case: Case, poses: np.ndarray) -> list[Contact]:
    """The contacts of the poses, up to the first pose without one, unless the plate may fly."""
    follower, found = Follower(case), list[Contact]()
    for x, y, theta in poses.tolist():
        try:
            found.append(follower(x, y, theta))
        except BEYOND:
            break
    return found


def _both_sides(samples: Samples) -> Samples:
    """The samples with every landing doubled: before it the plate flies, after it with the velocities it rebounds."""
    count, at = len(samples.t), samples.landings
    order = np.sort(np.concatenate([np.arange(count), at]))
    first = np.searchsorted(order, at)
    told = samples[order]
    # Where the next sample flies, it bounced; else it stays, with a force that a step's impulse does not tell.
    bounced = samples.aloft[np.minimum(at + 1, count - 1)]
    told.rates[first] = samples.before[at]
    told.rates[first + 1] = np.where(bounced[:, None], samples.rebound[at], samples.resting[at])
    told.aloft[first], told.aloft[first + 1] = True, bounced
    told.force[first + 1] = nan
    return told


def _pressed(noted: Noted, force: np.ndarray, speed: float) -> np.ndarray:
    """Where the contact pushed.

    A force is a difference of velocities over h: ten roundings of the velocity bound what it is off by.
    """
    strength = np.hypot(*force.T)
    return strength > 1e-9 * strength.max() + 10 * noted.rounding * noted.case.plate.mass * speed / noted.h


def _ending(noted: Noted, samples: Samples, hop: float) -> _Ending:
    """The first of the things that end a motion, or the end of its time."""
    case, found, asked, gap = noted.case, len(samples.gap), noted.steps + 1, samples.gap
    endings = [_Ending(asked)]
    through = gap < -radii(case)[0]
    if through.any():
        endings.append(_Ending(int(np.argmax(through)), "fell_through", "The plate passed through its track."))
    for name, curve, xi in (("track", case.track, samples.xi1), ("outline", case.plate.outline, samples.xi2)):
        if curve.domain and not curve.period:
            # Where there was no contact any more, the next one would have been about as far ahead as the last.
            xi = np.append(xi, 2 * xi[-1] - xi[-2]) if 1 < found < asked else xi
            up = np.append(samples.aloft, np.zeros(len(xi) - found, dtype=bool))
            outside = ~up & ((xi < curve.domain[0]) | (xi > curve.domain[1]))
            if outside.any():
                reason = f"The contact reached the end of the {name}'s domain."
                endings.append(_Ending(int(np.argmax(outside)), f"{name}_end", reason))
    if found < asked:
        endings.append(_Ending(found, "lost_track", "No point of the track is near the plate any more."))
    endings.append(_flight_ending(noted, samples, hop))
    return min(endings, key=lambda ending: ending.kept)


def _flight_ending(noted: Noted, samples: Samples, hop: float) -> _Ending:
    """Where leaving the track, or landing on it, is the end."""
    case, never = noted.case, _Ending(noted.steps + 1)
    if case.effect(Flight):
        landed = samples.landings
        return _Ending(int(landed[0]) + 1, "landing", LANDED) if lands_for_good(case) and landed.size else never
    flown = samples.gap > hop
    if not flown.any():
        return never
    speed = float(np.abs(samples.rates[:, :2]).max())
    pushed = np.flatnonzero(_pressed(noted, samples.force[: int(np.argmax(flown)) + 1], speed))
    kept = int(pushed[-1]) + 1 if pushed.size else 1
    return _Ending(kept, "lift_off", LEFT)


def _hop(noted: Noted, rates: np.ndarray, force: np.ndarray | None) -> float:
    """A gap in metres that only a plate in flight reaches.

    An engine lets a plate go for a step and catches it in the next: such hops are about ½ a h² with the acceleration a
    of gravity or contact (`force`; None where there may be impacts: what the track's bend asks for); and facets stand
    off the curve. Four times that, and a millionth of the plate or a thousand roundings of it, is a flight.
    """
    case = noted.case
    if force is None:
        bend = np.abs(case.track.curvature(np.linspace(*case.track.look, 721))).max()
        push = float(bend * (rates[:, :2] ** 2).sum(axis=1).max())
    else:
        push = float(np.hypot(*force.T).max()) / case.plate.mass
    strongest = float(np.hypot(*pull(case))) + push
    return max(1e-6, 1e3 * noted.rounding) * radii(case)[0] + 2.0 * strongest * noted.h**2 + 4.0 * noted.rough


def _creep(case: Case, samples: Samples, normal_force: np.ndarray, h: float) -> float:
    """The slip velocity (m/s) that remains where the engine sticks, in all but one step in a hundred.

    It sticks with the velocities of a half step, along a tangent that turns by some angle a in a step: the mean of
    two such velocities misses by v a²/8 at the centre, and by as much at the contact, whose lever turns too; doubled
    for plates whose outline bends more than the track. And on facets the normal force scatters from step to step:
    where it falls short, so does friction, for one step.
    """
    # Only from one step to the next: a flight between two samples turns by much.
    next_step = np.diff(samples.t) <= 1.5 * h
    turn = float(np.abs(np.diff(case.track.tangent_angle(samples.xi1)))[next_step].max(initial=0.0))
    # Half the difference of two neighbours is their distance from what they scatter about; the rarest are jumps.
    jumps = np.abs(np.diff(normal_force))[next_step]
    jumps = jumps[np.isfinite(jumps)]
    scatter = 0.5 * float(np.percentile(jumps, 99)) if jumps.size else 0.0
    friction, plate = case.effect(CoulombFriction), case.plate
    ease = 1 / plate.mass + radii(case)[1] ** 2 / plate.inertia
    missing = h * (friction.mu if friction else 0.0) * scatter * ease
    speed = float(np.hypot(samples.rates[:, 0], samples.rates[:, 1]).max(initial=0.0))
    return 0.5 * speed * turn**2 + missing
