"""The start of a motion, what follows its transitions, and its end: the status names a condition that holds there."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from cases import Impact, Mode, StartPose, Trajectory, Unilateral
from cases.contact.geometry import level_parameter
from cases.contact.overlap_search import depth_inside
from cases.motion.trajectory import CONTACT
from cases.scene.couples import curve_ends
from cases.scene.free_plates import names_of, plates_of

from ..endings import (
    ACCUMULATION,
    BREAKDOWN,
    COMPLETION,
    ENDS,
    FLAT,
    LANDING_END,
    LIFT_OFF,
    NO_MODE,
    NOT_UNIQUE,
)  # fmt: skip
from . import events
from .impact_check import impact_at, is_impact, passes_piece
from .laws import Defects, MotionScales
from .meetings import meetings
from .next_motion import Consistent, NextMotions, next_motions
from .samples import CLOSE, MotionSamples, PlateSamples, law_at
from .tolerances import AMPLIFICATION, EPS, PARTS, SLIP, TOUCHES
from .touches import TouchNow, is_at_joint, plates_at, row_of, touch, touches_at

# Accelerations that differ by less than this part of the largest are one.
SAME = 1e-6
# A place at the end of a track, in parts of its length.
AT_END = 1e-12
# Of a normal equation that is so nearly singular no program finds the forces: Painlevé's paradox.
SINGULAR = 1e5
MEETINGS = (LANDING_END[0], FLAT[0])
# Points of a pair closer than this part of the plate's size are one.
APART = 1e-5
CURVE_ENDS = (ENDS["track_end"][0], ENDS["outline_end"][0])
NO_MOTION = (NO_MODE[0], ACCUMULATION[0], BREAKDOWN)


def _one(law: str, place: str, t: float, size: float, scale: float, unit: str, floor: float = 0.0) -> Defects:
    return Defects(law, place, np.array([t]), np.array([size]), scale, unit, floor)


# --- start ------------------------------------------------------------------------------------------------------------


def start_defects(samples: MotionSamples, scales: MotionScales, rtol: float) -> Iterator[Defects]:
    """The motion begins where and as the case says."""
    case, plates = samples.case, plates_at(samples, 0, 0)
    start, one = case.start, _start_touch(samples)
    if start.xi2 is None:
        yield _one("angle of the start", "plate", 0.0, abs(float(plates.angle[0])), 1.0, "rad", 1e-13)
    off = abs(one.gap - start.gap * 1j * one.tangent)
    yield _one("place of the start", one.law.name, 0.0, off, scales.extent, "m", 1e-12)
    for i, other in enumerate(case.others, start=1):
        pose = other.start
        assert isinstance(pose, StartPose)
        far = abs(plates.place[i] - complex(pose.x, pose.y))
        yield _one("place of the start", other.name, 0.0, far, scales.extent, "m", 1e-12)
    yield from _first_velocities(samples, scales, rtol)


def _start_touch(samples: MotionSamples) -> TouchNow:
    """Where the case's start has its contact, or the points between which it gives the gap."""
    case, start = samples.case, samples.case.start
    xi2 = level_parameter(case.track, case.plate.outline, start.xi1) if start.xi2 is None else start.xi2
    return touch(case, law_at(case, CONTACT), Mode.FLIGHT, plates_at(samples, 0, 0), start.xi1, xi2, 0.0)


def before_start(samples: MotionSamples) -> PlateSamples:
    """The plates at the start with the velocities that the case gives them: before an impact, if there is one."""
    case, start, one, plates = samples.case, samples.case.start, _start_touch(samples), plates_at(samples, 0, 0)
    belt = float(one.law.belt.at(0.0)[0]) if one.law.belt else 0.0
    spins = np.array([start.omega, *(other.start.omega for other in case.others)])
    lever = one.point + one.gap - plates.place[0]
    first = one.tangent * complex(start.slip + belt, start.gap_rate) - 1j * start.omega * lever
    velocities = np.array([first, *(complex(other.start.vx, other.start.vy) for other in case.others)])
    return plates._replace(velocity=velocities, spin=spins)


def jump_at_start(samples: MotionSamples, scales: MotionScales) -> np.ndarray:
    """By how much the velocity of each plate at the start is another one than the case's, m/s."""
    before, after = before_start(samples), plates_at(samples, 0, 0)
    return np.abs(after.velocity - before.velocity) + np.array(scales.reach) * np.abs(after.spin - before.spin)


def begins_with_impact(samples: MotionSamples, scales: MotionScales, rtol: float) -> bool:
    """Whether velocities have changed by an impact at the start."""
    least = SLIP + AMPLIFICATION * float(scales.condition[0]) + PARTS * rtol
    return samples.case.effect(Impact) is not None and jump_at_start(samples, scales).max() > least * scales.speed


def _first_velocities(samples: MotionSamples, scales: MotionScales, rtol: float) -> Iterator[Defects]:
    """The velocities are those of the case's start, or these have changed by an impact."""
    if begins_with_impact(samples, scales, rtol):
        yield from impact_at(samples, scales, (before_start(samples), plates_at(samples, 0, 0)), 0, 0.0, rtol)
        return
    floor = SLIP + AMPLIFICATION * float(scales.condition[0])
    for name, size in zip(names_of(samples.case), jump_at_start(samples, scales).tolist(), strict=True):
        yield _one("velocity of the start", name, 0.0, size, scales.speed, "m/s", floor)


# --- what follows -----------------------------------------------------------------------------------------------------


def following_defects(samples: MotionSamples, scales: MotionScales) -> Iterator[Defects]:
    """After the start and each transition the motion's acceleration is one that the laws allow, and no other is."""
    last, near = float(samples.end[-1]), CLOSE * float(samples.end[-1])
    listed = np.array([0.0, *(change.time for change in samples.transitions)])
    instants = [t for t in samples.start.tolist() if np.abs(listed - t).min() <= near]
    for t in instants:
        step = int(np.searchsorted(samples.start, t))
        if t >= last or samples.is_straight[step] or passes_piece(samples, t):
            continue
        follow = next_motions(samples, scales, t)
        if follow is None:
            continue
        others = [one for one in _held(samples, follow) if one.is_strict]
        apart = max((_apart(one.rates, follow.own) for one in others), default=0.0)
        yield _one("next motion is the only one", "", t, apart, 1.0, "of the acceleration", follow.noise)
        nearest = min((_apart(one.rates, follow.own) for one in follow.every), default=np.inf)
        yield _one("next motion obeys the laws", "", t, nearest, 1.0, "of the acceleration", follow.noise)


def _apart(one: np.ndarray, other: np.ndarray) -> float:
    return float(np.abs(one - other).max())


def _held(samples: MotionSamples, follow: NextMotions) -> list[Consistent]:
    """The consistent motions with the most contacts that stick, where static friction is larger than that of slip: a
    contact that may stick does. The samples' own counts also where a force vanishes."""
    every, frictions = follow.every, [contact.law.friction for contact in samples.contacts]
    if not any(friction.stick > friction.at_rest for friction in frictions if friction is not None):
        return every
    sticking = [sum(mode[0] == "stick" for mode in one.modes) for one in every]
    holds = [one.is_strict or _apart(one.rates, follow.own) <= follow.noise for one in every]
    most = max((count for count, is_held in zip(sticking, holds, strict=True) if is_held), default=0)
    return [one for count, one in zip(sticking, every, strict=True) if count >= most]


# --- end --------------------------------------------------------------------------------------------------------------


def end_defects(
    samples: MotionSamples, scales: MotionScales, motion: Trajectory, duration: float, rtol: float
) -> Iterator[Defects]:
    """The condition that the status names holds at the end, and the motion does not last longer than its case."""
    status, end = motion.status, float(motion.t[-1])
    far = end - duration
    yield _one("ends at its duration", "", end, abs(far) if status == COMPLETION[0] else far, duration, "s", 4 * EPS)
    if status == LIFT_OFF[0]:
        yield from _lift_off(samples, scales, end)
    elif status in CURVE_ENDS:
        yield from _curve_end(samples, end, is_track=status == CURVE_ENDS[0])
    elif status in MEETINGS:
        yield from _meeting(samples, scales, end)
    elif status == NOT_UNIQUE or status in NO_MOTION and scales.condition[-1] < SINGULAR:
        if samples.case.effect(Impact) is not None and _may_be_impact(samples, scales, rtol):
            return
        follow = next_motions(samples, scales, end, is_end=True)
        if follow is not None and not (
            any(c.law.is_rough for c in samples.contacts) and not any(one.is_strict for one in follow.every)
        ):
            yield _of_next_motions(follow, status, end)


def _of_next_motions(follow: NextMotions, status: str, end: float) -> Defects:
    """Several motions are consistent, or none: ties of conditions have one acceleration."""
    strict = [one.rates for one in follow.every if one.is_strict]
    if status == NOT_UNIQUE:
        is_one = all(_apart(rates, strict[0]) < SAME for rates in strict)
        return _one("several motions are consistent", "", end, float(is_one), 1.0, "motions", 0.5)
    rates = [one.rates for one in follow.every]
    goes_on = bool(rates) and all(_apart(one, rates[0]) < SAME for one in rates)
    return _one("no motion is consistent", "", end, float(goes_on), 1.0, "motions", 0.5)


def _lift_off(samples: MotionSamples, scales: MotionScales, end: float) -> Iterator[Defects]:
    """The normal force of a contact vanishes, and its slope is negative, or a corner slides off a corner."""
    if samples.case.effect(Unilateral) is None:
        return
    step = len(samples.start) - 1
    closed = [(c, row) for c in samples.contacts if (row := row_of(c, step)) is not None]
    every = [
        events.vanishing(samples, scales, events.normal_guard(samples, scales, contact, row), contact.law.name, step)
        for contact, row in closed
    ]
    if every and not any(events.leaves_piece(*one) for one in closed):  # one of them is enough
        yield min(every, key=lambda one: float(one.sizes[0] / one.limit(0.0)[0]))


def _curve_end(samples: MotionSamples, end: float, is_track: bool) -> Iterator[Defects]:
    """A contact is at an end of its track or support, or such an end on the plate; or else it is at one of its
    outline."""
    step, far = len(samples.start) - 1, 1.0
    for contact in samples.contacts:
        row, law = row_of(contact, step), contact.law
        curve, places = (law.track, contact.xi1) if is_track else (law.outline, contact.xi2)
        if row is not None and curve.ends is not None and law.base is None:
            far = min(far, *(abs(places[row, -1] - e) / (curve.ends[1] - curve.ends[0]) for e in curve.ends))
    plates, ends = plates_at(samples, step, -1), curve_ends(samples.case) if is_track else ()
    for one in ends:
        own = (complex(one.corner.x, one.corner.y) - plates.place[one.body]) / plates.turn[one.body]
        far = min(far, abs(depth_inside(one.plate.outline, own.real, own.imag)) / one.plate.reach)
    yield _one("track ends" if is_track else "outline ends", CONTACT, end, far, 1.0, "of its length", AT_END)


def _meeting(samples: MotionSamples, scales: MotionScales, end: float) -> Iterator[Defects]:
    """A plate meets a curve or another plate in a place where it is not in contact."""
    yield _one("plate meets a curve", "", end, _least_gap(samples), scales.extent, "m", TOUCHES)


def _least_gap(samples: MotionSamples) -> float:
    """The least gap (m) at the end of a motion away from its contacts; none where one of these comes to another piece,
    which it may meet."""
    step, end, reach = len(samples.start) - 1, float(samples.end[-1]), [p.reach for p in plates_of(samples.case)]
    closed = touches_at(samples, step, -1)
    if any(is_at_joint(one.law.track, one.xi1) or is_at_joint(one.law.outline, one.xi2) for one in closed):
        return 0.0
    gaps = [
        abs(one.gap) for one in meetings(samples, plates_at(samples, step, -1), end)
        if all(abs(one.point - other.point) > APART * reach[one.law.body] for other in closed)
    ]  # fmt: skip
    return min(gaps, default=np.inf)


def _may_be_impact(samples: MotionSamples, scales: MotionScales, rtol: float) -> bool:
    """Whether a plate may meet something at the end of a motion; of several plates that is not known."""
    return (
        bool(samples.case.others)
        or is_impact(samples, scales, rtol)
        or _least_gap(samples) < (TOUCHES + PARTS * rtol) * scales.extent
    )
