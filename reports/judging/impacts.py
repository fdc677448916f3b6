"""What a plate does at impacts and between them: how fast it rebounds, by which impulses, how far it turns, and when it
comes to rest.

Pure functions; SI units.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import lru_cache
from itertools import pairwise, zip_longest
from math import isfinite, nan
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np

from cases import Case, Mode, Trajectory, Transition
from cases.contact import track_place
from cases.contact.nearest import nearest
from cases.motion import mechanics
from cases.motion.mechanics import kinetic_energy
from cases.scene.free_plates import POSE
from reference.impulses import impacts_of_samples

from . import doubts
from .distances import even_samples, states_of
from .ledger import LedgerRow

# Times of a transition and of its impact differ by less than this part of the motion's duration: by error bars.
_SAME_TIME = 1e-9
# A plate is at rest once its kinetic energy stays below this part of its largest: it has lost 99 % of its speed.
_AT_REST = 1e-4


class ImpactRow(NamedTuple):
    """An impact of the truth, of a solver, or of both, with how far the plate turns afterwards before the next one:
    `swing` and `reference_swing`, rad. `event` numbers the rows from 1; the row with event 0 is the time of rest. Times
    in s; NaN where there is none. With one contact: closing speed (m/s) and restitution, as in `Rebound`."""

    event: int
    contact: str
    time: float
    reference_time: float
    swing: float
    reference_swing: float
    closing: float = nan
    reference_closing: float = nan
    restitution: float = nan
    reference_restitution: float = nan


def rows(case: Case, motion: Trajectory, truth: Trajectory, ledger_rows: Sequence[LedgerRow]) -> tuple[ImpactRow, ...]:
    """The impacts of a motion next to the truth's of the same number at that contact, and the times of rest if either
    comes to rest; `ledger_rows`: their transitions."""
    landings = _in_order(row for row in ledger_rows if row.after is not Mode.FLIGHT)
    own = _swings(motion, [time for _, time, _ in landings])
    true = _swings(truth, [exact for *_, exact in landings])
    rests = rest_time(case, motion), rest_time(case, truth)
    result = [ImpactRow(0, "", *rests, nan, nan)] if any(map(isfinite, rests)) else []
    for number, (contact, time, exact) in enumerate(landings, start=1):
        result.append(ImpactRow(number, contact, time, exact, own.get(time, nan), true.get(exact, nan)))
    return tuple(result)


def _in_order(ledger_rows: Iterable[LedgerRow]) -> list[tuple[str, float, float]]:
    """Contact, time and the truth's time (s) of each landing in order: the nth at a contact with the truth's nth there.

    A solver that loses too much in each impact has few: the nearest in time to its fifth may be the truth's seventh,
    which follows another swing."""
    landings = [row for row in ledger_rows if row.before is Mode.FLIGHT]
    result = list[tuple[str, float, float]]()
    for contact in dict.fromkeys(row.contact for row in landings):
        here = [row for row in landings if row.contact == contact]
        own = sorted(row.time for row in here if isfinite(row.time))
        true = sorted(row.reference_time for row in here if isfinite(row.reference_time))
        result += [(contact, time, exact) for time, exact in zip_longest(own, true, fillvalue=nan)]
    return sorted(result, key=lambda one: one[2] if isfinite(one[2]) else one[1])


class ImpulseRow(NamedTuple):
    """What a contact does in an impact of the truth, and in that impact of a motion: times in s, impulses along normal
    and tangent in N s, work in J. NaN where the motion does not have the impact, where its velocities next to it are
    not known, or where velocities do not determine the impulse."""

    contact: str
    time: float
    reference_time: float
    normal: float
    reference_normal: float
    friction: float
    reference_friction: float
    work: float
    reference_work: float


def impulses(
    case: Case, motion: Trajectory, truth: Trajectory, ledger_rows: Sequence[LedgerRow]
) -> tuple[ImpulseRow, ...]:
    """The impulses of each contact in each impact of the truth, in the order of their times, next to a motion's.
    `ledger_rows`: their transitions; the nth landing at a contact is that of the truth's nth."""
    times = {row.reference_time: row.time for row in ledger_rows if row.pairing == "paired"}
    times |= {exact: time for _, time, exact in _in_order(ledger_rows) if isfinite(time)}

    def time_of(exact: float) -> float:
        near = min(times, key=lambda t: abs(t - exact), default=nan)
        return times[near] if abs(near - exact) <= _SAME_TIME * float(truth.t[-1]) else nan

    # Differences of poses have both sides of an impact in them.
    has_velocities = not all(doubts.are_differences(motion.plate(name)) for name in motion.plate_names)
    own = impacts_of_samples(case, truth, motion, time_of if has_velocities else lambda _: nan)
    return tuple(
        ImpulseRow(true.contact, a.time, true.time, a.normal, true.normal, a.friction, true.friction, a.work, true.work)
        for a, true in zip(own, truth.impacts, strict=True)
    )


def _swings(motion: Trajectory, times: Sequence[float]) -> dict[float, float]:
    """The largest turn of the plate after each of the impacts and before the next, rad, by the impact's time."""
    samples = even_samples(motion)
    t, theta = samples.t, samples.theta
    known = sorted(time for time in times if isfinite(time) and time <= t[-1])
    swings = {}
    for begin, end in pairwise([*known, float(t[-1])]):
        inside = (t >= begin) & (t <= end)
        at_impact = float(np.interp(begin, t, theta))
        swings[begin] = float(np.max(np.abs(theta[inside] - at_impact), initial=0.0))
    return swings


class Rebound(NamedTuple):
    """One impact on the track: its time (s), the closing speed along the track's normal (m/s), and the speed with which
    the plate leaves, over the closing speed: 0 if it stays."""

    time: float
    closing: float
    restitution: float


@lru_cache(maxsize=4)
def rebounds(case: Case, motion: Trajectory, events: tuple[Transition, ...]) -> tuple[Rebound, ...]:
    """The impacts of a motion with one contact among its transitions, from its velocities in flight before and after.

    Velocities are extrapolated to the impact with gravity and load. Impacts without a sample in flight on both sides
    are omitted; where the plate stays, none is needed after it. Cached, as all motions of a case are compared with one
    truth."""
    samples = even_samples(motion)
    t = samples.t
    # Solvers with impacts of finite duration report no force in them.
    aloft = np.isnan(samples.xi1) & ~np.isnan(samples.normal_force)
    edges, result = [-np.inf, *(event.time for event in events), np.inf], list[Rebound]()
    # A central difference next to an impact has velocities of both sides in it.
    skip = int(doubts.are_differences(motion))
    for event, last, following in zip(events, edges[:-2], edges[2:], strict=True):
        before = np.flatnonzero(aloft & (t > last) & (t < event.time))
        before = before[: len(before) - skip]
        after = np.flatnonzero(aloft & (t > event.time) & (t < following))[skip:]
        stays = event.after is not Mode.FLIGHT
        if event.before is Mode.FLIGHT and len(before) and (stays or len(after)):
            i = int(before[-1])
            closing = -normal_speed(case, samples, i, i, event.time)
            leaves = 0.0 if stays else normal_speed(case, samples, int(after[0]), i, event.time)
            if closing > 0.0:
                result.append(Rebound(event.time, closing, leaves / closing))
    return tuple(result)


def rebound_rows(own: Sequence[Rebound], true: Sequence[Rebound]) -> tuple[ImpactRow, ...]:
    """The nth impact of a motion with one contact next to the truth's nth."""
    none = Rebound(nan, nan, nan)
    return tuple(
        ImpactRow(number, "", a.time, b.time, nan, nan, a.closing, b.closing, a.restitution, b.restitution)
        for number, (a, b) in enumerate(zip_longest(own, true, fillvalue=none), start=1)
    )


def normal_speed(case: Case, samples: Trajectory, k: int, pose: int, time: float) -> float:
    """The velocity at a time, from sample k in flight, of the outline's point that is nearest to the track in sample
    `pose`, relative to the track along its normal there, m/s; 0 where no point of the track is near."""
    now = SimpleNamespace(**{name: getattr(samples, name)[k : k + 1] for name in ("t", *POSE)})
    force = mechanics.loads(case, now)[:, 0]
    later = time - now.t[0]
    turning = float(now.omega[0]) + later * force[2] / case.plate.inertia
    velocity = np.array([now.vx[0], now.vy[0]]) + later * (mechanics.gravity(case) + force[:2] / case.plate.mass)
    x, y, theta = (float(values[pose]) for values in (samples.x, samples.y, samples.theta))
    place = track_place(case, time)
    x, y, vx, vy, turning = place.seen_from_track(x, y, velocity[0], velocity[1], turning)
    contact = nearest(case, x, y, theta - place.angle)
    if contact is None:
        return 0.0
    lever = np.asarray(case.track.point(contact.xi1)) - (x, y)
    there = np.array([vx, vy]) + turning * np.array([-lever[1], lever[0]])
    return float(np.asarray(case.track.normal(contact.xi1)) @ there)


def rebound_note(own: Sequence[Rebound], law: float, energy_change: float) -> str:
    """What the impacts of a motion show, in a phrase; "" if there are none. `law`: the case's restitution;
    `energy_change`: the mechanical energy at the end, less the truth's, as a share of the largest kinetic energy."""
    if not own:
        return ""
    values = sorted(one.restitution for one in own if one.restitution != 0.0) or [0.0]
    low, high = (f"{value:.3g}" for value in (values[0], values[-1]))
    texts = [f"restitution {low if low == high else f'{low} to {high}'} (law {law:g})"]
    stays = [one.closing for one in own if one.restitution == 0.0]
    if stays and law > 0.0:
        texts.append(f"does not bounce at {max(stays):.2g} m/s")
    if abs(energy_change) > _ENERGY:
        texts.append(f"{abs(100.0 * energy_change):.2g} % of the energy {'gained' if energy_change > 0.0 else 'lost'}")
    return ", ".join(texts)


# A smaller share of the energy is not mentioned.
_ENERGY = 1e-3


def rest_time(case: Case, motion: Trajectory) -> float:
    """The time after which the kinetic energy stays below a small part of its largest, s; NaN if the motion ends
    before."""
    samples = even_samples(motion)
    t, kinetic = samples.t, np.asarray(kinetic_energy(case, states_of(samples)))
    moving = np.flatnonzero(kinetic > _AT_REST * float(np.max(kinetic, initial=0.0)))
    if not len(moving):
        return 0.0
    return float(t[moving[-1] + 1]) if moving[-1] + 1 < len(t) else nan
