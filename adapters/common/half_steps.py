"""Reads motions of engines with positions at k·h and velocities half a step later: pymunk, Box2D, pybullet.

That is semi-implicit Euler, the step of game engines, after a first step of h/2 (with substeps, one that is half a
substep short). Velocities at the positions' times are interpolated between their neighbours; a force is the momentum
that the contact adds in a step, over the step's length. On facets the force of a single step is noise about the true
one, and only its mean is meaningful. Independent of any engine.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from math import nan

import numpy as np

from cases import Case, Cost, CoulombFriction, Drive, Flight, Trajectory
from cases.motion.mechanics import gravity
from cases.moving_frame import relative_case
from cases.scene.contact_limits import touches_by_features
from cases.scene.free_plates import plates_of

from ..interface import EngineFailure
from . import plates_in_steps
from .driven_tracks import in_track_axes, rows_from_track, to_fixed_frame
from .facets import sharpest_bend, sway, track_kind
from .flights import LIFT_OFF_REASON, flights
from .one_contact import (
    MotionEnd,
    columns_of,
    domain_ends,
    first_of,
    follow,
    landing,
    moved_to_end,
    slip_and_forces,
    trajectory,
)
from .several_contacts import may_touch_twice, with_contacts
from .step_record import (
    StepRecord,
    check_rows,
    external_of,
    inertia_of,
    rates_at_poses,
    rest,
    spans,
    torsor_of,
    velocities_before,
)  # fmt: skip

__all__ = ["StepRecord", "rates_at_poses", "read", "rest"]


@dataclass(frozen=True)
class _MotionSamples:
    """Samples at the poses' times, arrays of one length.

    `t` (s); `pose`, `rates` (n, 3); `force` (n, 2) of the contact, N, and whether it is `pushing`; contact parameters
    and gap (m); `aloft`: samples in flight. `falling`: the velocities if there was no contact since the previous
    sample; `rising`: the velocities if there is none until the next ones, `after`.
    """

    t: np.ndarray
    pose: np.ndarray
    rates: np.ndarray
    falling: np.ndarray
    rising: np.ndarray
    after: np.ndarray
    force: np.ndarray
    pushing: np.ndarray
    xi1: np.ndarray
    xi2: np.ndarray
    gap: np.ndarray
    aloft: np.ndarray

    def __getitem__(self, places) -> _MotionSamples:
        """The samples at these indices."""
        return replace(self, **{name: getattr(self, name)[places] for name in self.__dataclass_fields__})


def read(record: StepRecord) -> Trajectory:
    """The motion at the poses' times, cut where the plate leaves its track. Raises EngineFailure if it is no motion.

    With Flight leaving the track does not end the motion. The rows of a driven track are read in the track's frame.
    """
    return to_fixed_frame(record.case, _read(_from_track(record) if record.case.effect(Drive) else record))


def _from_track(record: StepRecord) -> StepRecord:
    """The record as a driven track sees it; its load is what of each step's change of momentum is no contact force.

    Contact forces are the same in both frames. The load of the track's motion at an instant differs from its mean over
    a step by up to h²/24 times its second derivative, which would count as a contact force in flight.
    """
    case, rows = record.case, record.rows
    if len(rows) < 3 or not np.isfinite(rows).all():
        return record
    times, torsor = record.h * np.arange(len(rows)), torsor_of(record)
    rows = rows_from_track(case, rows, times, times + record.h * (1.0 - record.rest))
    seen = replace(record, case=relative_case(case), rows=rows, load=None)
    load = torsor_of(seen) - in_track_axes(case, times, torsor)
    lightest = min(plate.mass for plate in plates_of(case))
    pull = float(np.hypot(load[..., 0], load[..., 1]).max()) / lightest + float(np.hypot(*gravity(seen.case)))
    return replace(seen, load=load, pull=pull)


def _read(record: StepRecord) -> Trajectory:
    if record.case.others or touches_by_features(record.case):
        return plates_in_steps.read(record)
    case, samples = record.case, _samples(record)
    hop = _hop(record, samples)
    stretches = flights(samples.gap, samples.pushing, hop)
    if case.effect(Flight):
        for leaves, lands in stretches:
            samples.aloft[leaves:lands] = True
    end = _ending(record, samples, stretches, hop)
    samples = _both_sides(samples[: end.samples if end else len(samples.t)])
    table = _table(record, samples)
    creep = _creep(record, samples[~samples.aloft], table[~samples.aloft, 8])
    motion = trajectory(moved_to_end(table, end), end, creep, Cost(steps=len(record.rows)))
    return with_contacts(case, motion, partial(_clear, record)) if _may_touch_twice(record) else motion


def _may_touch_twice(record: StepRecord) -> bool:
    """Whether contacts are searched on the whole track: the engine finds them, and the disc may touch in two places."""
    return record.contacts is None and track_kind(record.case) == "chain" and may_touch_twice(record.case)


def _clear(record: StepRecord, xi1: np.ndarray) -> np.ndarray:
    """The gaps (m) below which contacts at these parameters are closed: hops of one step under gravity, and what the
    facets leave of the track's bend there (`_hop` has the sizes)."""
    case, bends, greatest = record.case, record.case.track.curvature, sharpest_bend(record.case)
    share = np.abs(bends(np.nan_to_num(xi1, nan=case.start.xi1))) / greatest if greatest > 0.0 else np.zeros(len(xi1))
    hop = 2.0 * float(np.hypot(*gravity(case))) * record.h**2
    return max(1e-6, 1e3 * record.rounding) * case.plate.inner + hop + 4.0 * record.rough * share


# --- samples ----------------------------------------------------------------------------------------------------------


def _samples(record: StepRecord) -> _MotionSamples:
    """All samples at the poses' times, up to the first pose without contact; `aloft` is still False everywhere."""
    case, rows = record.case, record.rows
    check_rows(record)
    pose, after, before = rows[:, :3], rows[:, 3:], velocities_before(record)
    late, ahead = spans(record)
    inertia, external, force = inertia_of(case), external_of(record), torsor_of(record)[:, :2]
    rates = rates_at_poses(before, after, case.plate.reach, record.rest)
    xi1, xi2, gap = columns_of((record.contacts or follow(case, pose)[0])[: len(rows)])
    if not len(gap):
        raise EngineFailure("The plate has no contact point with its track where it begins.")
    length = slice(len(gap))
    return _MotionSamples(
        t=np.linspace(0.0, case.duration, record.steps + 1)[length], pose=pose[length], rates=rates[length],
        falling=(before + late * external / inertia)[length], rising=(after - ahead * external / inertia)[length],
        after=after[length], force=force[length], pushing=_pushing(record, force, rates)[length],
        xi1=xi1, xi2=xi2, gap=gap, aloft=np.zeros(len(gap), dtype=bool),
    )  # fmt: skip


def _pushing(record: StepRecord, force: np.ndarray, rates: np.ndarray) -> np.ndarray:
    """Which samples have a contact force.

    A force is a difference of velocities over h: ten roundings of the velocity bound its error.
    """
    speed, strength = float(np.abs(rates[:, :2]).max()), np.hypot(*force.T)
    return strength > 1e-9 * strength.max() + 10 * record.rounding * record.case.plate.mass * speed / record.h


def _both_sides(samples: _MotionSamples) -> _MotionSamples:
    """The samples with two for every landing: before it, in flight, and after it; the last sample only in flight.

    An impact has no duration, and the velocities before and after it have no mean. If the next sample is in flight, the
    plate bounced; else it stays, with an unknown force, since a step's impulse does not give it, and the velocities of
    the next step: some engines only close the remaining gap in the step that lands.
    """
    count = len(samples.t)
    at = np.flatnonzero(samples.aloft[:-1] & ~samples.aloft[1:]) + 1
    lasting = at[at < count - 1]
    order = np.sort(np.concatenate([np.arange(count), lasting]))
    first, last = np.searchsorted(order, at), np.searchsorted(order, lasting) + 1
    rebounds = samples.aloft[lasting + 1]
    both = samples[order]
    both.rates[first], both.aloft[first] = samples.falling[at], True
    both.rates[last] = np.where(rebounds[:, None], samples.rising[lasting], samples.after[lasting + 1])
    both.aloft[last], both.force[last] = rebounds, nan
    return both


def _table(record: StepRecord, samples: _MotionSamples) -> np.ndarray:
    """The columns of a Trajectory, shape (n, 12); in flight there are neither contact parameters, slip nor forces."""
    own = samples
    at = slip_and_forces(record.case, own.t, own.pose, own.rates, own.force, own.xi1, own.gap, record.lever)
    touch = np.column_stack([*at, own.xi1, own.xi2])
    touch[own.aloft] = nan, 0.0, 0.0, nan, nan
    return np.column_stack([own.t, own.pose, own.rates, touch])


# --- how a motion ends ------------------------------------------------------------------------------------------------


def _ending(
    record: StepRecord, samples: _MotionSamples, stretches: list[tuple[int, int]], hop: float
) -> MotionEnd | None:
    """The first event that ends the motion, or None."""
    case, there, gap = record.case, len(samples.t), samples.gap
    xi1, xi2 = (np.where(samples.aloft, nan, xi) for xi in (samples.xi1, samples.xi2))
    ends = [*domain_ends(case, xi1, xi2), landing(case, samples.t, gap, stretches, late=1)]
    through = gap < -case.plate.inner
    if through.any():
        ends.append(MotionEnd(int(np.argmax(through)), 0.0, "fell_through", "The plate passed through its track."))
    if not case.effect(Flight) and (gap > hop).any():
        ends.append(_lift_off(samples, int(np.argmax(gap > hop))))
    if there < record.steps + 1 and 1 < there:
        # After the last contact, extrapolate the next one linearly.
        ends += domain_ends(case, *(np.append(xi, 2 * xi[-1] - xi[-2]) for xi in (xi1, xi2)))
    if there < record.steps + 1:
        ends.append(MotionEnd(there, 0.0, "lost_track", "No point of the track is near the plate any more."))
    end = first_of(ends)
    return end._replace(share=0.0) if end and end.sample == there else end


def _lift_off(samples: _MotionSamples, surely: int) -> MotionEnd:
    """The lift-off where the force vanishes: after the last sample with a push, before that `surely` off the track.

    The weaker a contact, the more steps are between two pushes; the mean force over a hop is the push over its steps.
    It is extrapolated by a line through the last six, at most over the last hop, where another push would have
    occurred. (An engine with drag of its own never stops pushing; its plate leaves where it is certainly off the
    track.)
    """
    last = np.flatnonzero(samples.pushing[: surely + 1])[-7:]
    end = MotionEnd(int(last[-1]) + 1 if last.size else 1, 0.0, "lift_off", LIFT_OFF_REASON)
    if len(last) < 3 or last[-1] == surely:
        return end
    hops, strength = np.diff(last), np.hypot(*samples.force[last[:-1]].T)
    slope, level = np.polyfit(0.5 * (last[:-1] + last[1:] - 1), strength / hops, 1)
    if slope >= 0.0:
        return end
    vanishes = float(np.clip(-level / slope, last[-1], min(surely, last[-1] + hops[-1])))
    sample = max(int(np.ceil(vanishes)), 1)
    return end._replace(sample=sample, share=vanishes - (sample - 1))


def _hop(record: StepRecord, samples: _MotionSamples) -> float:
    """A gap in metres that only a plate in flight reaches.

    An engine may lose the contact in one step and regain it in the next: such hops are about ½ a h² with the
    acceleration a of gravity or contact; and facets have a distance from the curve. Four times that, plus a millionth
    of the plate or a thousand roundings of its size, is a flight. With Flight the largest force is an impact's, so the
    acceleration by the curvatures of track and outline is used instead.
    """
    case, plate = record.case, record.case.plate
    if case.effect(Flight):
        bend = sharpest_bend(case)
        speed, spin = np.hypot(*samples.rates[:, :2].T).max(), np.abs(samples.rates[:, 2]).max()
        push = bend * float(speed) ** 2 + sway(plate.outline) * float(spin) ** 2
    else:
        push = float(np.hypot(*samples.force.T).max()) / plate.mass
    strongest = (float(np.hypot(*gravity(case))) if record.pull is None else record.pull) + push
    return max(1e-6, 1e3 * record.rounding) * plate.inner + 2.0 * strongest * record.h**2 + 4.0 * record.rough


# --- the creep of a sticking contact ----------------------------------------------------------------------------------


def _creep(record: StepRecord, samples: _MotionSamples, normal_force: np.ndarray) -> float:
    """The slip velocity (m/s) that remains where the engine sticks; 99th percentile over the steps.

    The engine sticks with the velocities of a half step, along a tangent that turns by an angle a in a step: the mean
    of two such velocities has an error v a²/8 at the centre, and as much at the contact, whose lever turns too; doubled
    for plates whose outline bends more than the track. On facets the normal force also scatters from step to step:
    where it is too small, friction is too small for one step.
    """
    case, h = record.case, record.h
    # Only between consecutive steps: the tangent may turn much during a flight.
    next_step = np.diff(samples.t) <= 1.5 * h
    turns = np.abs(np.diff(case.track.tangent_angle(samples.xi1)))[next_step]
    turn = float(turns[np.isfinite(turns)].max(initial=0.0))
    # Half the difference of two neighbours is their distance from the mean; the rarest are jumps.
    scatter = 0.5 * _usual(np.abs(np.diff(normal_force))[next_step])
    friction, plate = case.effect(CoulombFriction), case.plate
    ease = 1 / plate.mass + plate.reach**2 / plate.inertia
    missing = h * (friction.at_rest if friction else 0.0) * scatter * ease
    speed = float(np.hypot(samples.rates[:, 0], samples.rates[:, 1]).max(initial=0.0))
    lag = _lag(case, samples)[next_step] if record.contacts is None else np.empty(0)
    return 0.5 * speed * turn**2 + missing + _usual(lag)


def _lag(case: Case, samples: _MotionSamples) -> np.ndarray:
    """The slip velocity (m/s) by the lever's change from each sample to the next, if the engine finds the contact.

    The engine sticks with the lever of the step's beginning. The lever along the normal of a plate that is no disc
    changes, and in the middle of the step it differs by half of its change.
    """
    normal = case.track.normal(samples.xi1)
    lever = np.sum((case.track.point(samples.xi1) - samples.pose[:, :2].T) * normal, axis=0)
    return 0.5 * np.abs(samples.rates[1:, 2] * np.diff(lever))


def _usual(values: np.ndarray) -> float:
    """The 99th percentile of the finite values; 0 if there are none."""
    values = values[np.isfinite(values)]
    return float(np.percentile(values, 99)) if values.size else 0.0
