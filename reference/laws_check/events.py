"""The transitions of a motion: what the modes before and after name vanishes there.

A quantity that should be zero, over its slope, is an error of the transition's time.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from cases import Mode, Transition, Unilateral
from cases.motion.trajectory import CONTACT

from ..endings import CAUSES
from . import chebyshev
from .laws import SENSE, STICKING, Defects, MotionScales, force_scale_at, relative_spin
from .samples import CLOSE, MIDDLE, ContactInstants, MotionSamples, law_at
from .tolerances import AMPLIFICATION, CLOSED, EPS, STILL
from .touches import JOINT, bend_at, is_at_joint, plates_at, row_of, to_joint, touch

# A quantity that falls by less than this part of its scale in a step grazes zero: its slope is no measure of time.
GRAZES, GRAZING = 1e-6, 1e-10
# Roundings of a quantity that is a difference of larger ones, in parts of its scale.
ROUNDING = 40 * EPS
# Part of the duration that is an error of a time; of landings, whose places are searched.
INSTANT, LANDING = 1e-12, 1e-11
# A parameter that changes by less than this in half a step rests.
MOVES_ON = 1e-6
# Impacts whose intervals have a ratio below one that changes by less than the other have a known limit.
MOST_RATIO, RATIO_CHANGE = 0.95, 0.02
# Causes after which another condition than that of the modes vanishes.
_GUARDS = {
    CAUSES["slip"]: "slip", CAUSES["cone_forward"]: "cone", CAUSES["normal_force"]: "normal", CAUSES["turn"]: "turn",
}  # fmt: skip
_OTHER_GUARDS = (CAUSES["couple_forward"],)
_OTHER_CAUSES = (CAUSES["track_start"], CAUSES["rest"])


class Guard(NamedTuple):
    """A quantity that vanishes at a transition: its name, values at the nodes of the step before, scale and unit."""

    name: str
    values: np.ndarray
    scale: float
    unit: str


def event_defects(samples: MotionSamples, scales: MotionScales, impacts: np.ndarray) -> Iterator[Defects]:
    """What should vanish at the transitions; `impacts`: times at which velocities jump."""
    last = float(samples.end[-1])
    near = CLOSE * last
    for change in samples.transitions:
        step = int(np.argmin(np.abs(samples.end - change.time)))
        if change.cause == CAUSES["rest"] and len(samples.motion.contact_names) == 1:
            yield from limit_of_impacts(change.time, change.contact or CONTACT, impacts, last)
        if change.time <= 0.0 or abs(samples.end[step] - change.time) > near or change.cause in _OTHER_CAUSES:
            continue
        if samples.is_straight[step]:
            continue
        with_others = sum(abs(other.time - change.time) <= near for other in samples.transitions) > 1
        if change.before is Mode.FLIGHT:
            if change.cause != CAUSES["piece"]:
                yield from _landing(samples, scales, change, step, with_others)
            continue
        contact = next((c for c in samples.contacts if c.law.name == (change.contact or CONTACT)), None)
        if contact is None:
            continue
        row, when = row_of(contact, step), np.array([change.time])
        if row is None:  # it opened before
            yield Defects("contact is closed", contact.law.name, when, samples.length[[step]], last, "s", INSTANT)
            continue
        if leaves_piece(contact, row):
            continue
        if change.cause == CAUSES["piece"]:
            law, points = contact.law, (contact.xi2[row, -1], contact.xi1[row, -1])
            off = min(to_joint(curve, s) for curve, s in zip((law.outline, law.track), points, strict=True))
            yield Defects("a piece ends", law.name, when, np.array([off]), 1.0, "m", JOINT)
            continue
        is_impact = bool(len(impacts)) and np.abs(impacts - change.time).min() <= near
        if is_impact or "another contact" in change.cause:
            continue  # the law of impact, or the condition of the other contact, which may pass to another piece
        for guard in _guards(samples, scales, contact, row, change):
            yield vanishing(samples, scales, guard, contact.law.name, step)
        yield from _sense(samples, scales, contact, row, change)


def leaves_piece(contact: ContactInstants, row: int) -> bool:
    """Whether a contact moves in a step to the end of a piece of its outline, or with a corner of its plate to that of
    a piece of its track: it passes to the next piece there, or a corner slides off a corner."""
    law, ends = contact.law, list[bool]()
    for curve, place in ((law.outline, contact.xi2[row]), (law.track, contact.xi1[row])):
        ends.append(is_at_joint(curve, place[-1]) and abs(place[-1] - place[MIDDLE]) > MOVES_ON)
    return ends[0] or ends[1] and np.isinf(bend_at(law.outline, contact.xi2[row, -1]))


def _guards(
    samples: MotionSamples, scales: MotionScales, contact: ContactInstants, row: int, change: Transition
) -> Iterator[Guard]:
    law, force = contact.law, force_scale_at(samples, contact.law, scales)
    which = _GUARDS.get(change.cause) or _by_modes(change)
    if which == "slip" and change.before in SENSE:
        yield Guard("slip velocity vanishes", SENSE[change.before] * contact.slip[row], scales.speed, "m/s")
    elif which == "cone" and change.before in STICKING:
        cone = law.stick * np.abs(contact.normal[row]) - np.abs(contact.friction[row])
        if np.isfinite(cone).all():
            yield Guard("friction reaches its cone", cone, force, "N")
    elif which == "normal" and samples.case.effect(Unilateral) is not None:
        yield normal_guard(samples, scales, contact, row)
    elif which == "turn":
        spin = relative_spin(samples, law, contact.steps[row])
        yield Guard("rotation vanishes", np.abs(spin), scales.speed / scales.size, "rad/s")


def _by_modes(change: Transition) -> str:
    """What vanishes between two modes, for motions without these causes."""
    if change.cause in _OTHER_GUARDS:
        return ""
    if change.after is Mode.FLIGHT:
        return "normal"
    return "slip" if change.before in SENSE else "cone" if change.after in SENSE else ""


def normal_guard(samples: MotionSamples, scales: MotionScales, contact: ContactInstants, row: int) -> Guard:
    """The normal force of a contact in the step of a row."""
    return Guard("normal force vanishes", contact.normal[row], force_scale_at(samples, contact.law, scales), "N")


def vanishing(samples: MotionSamples, scales: MotionScales, guard: Guard, place: str, step: int) -> Defects:
    """How late a time is at which a quantity should vanish, s; where it grazes zero, how large it is."""
    length, t = float(samples.length[step]), float(samples.end[step])
    slope = float(chebyshev.RATES[-1] @ guard.values) / length
    size = abs(float(guard.values[-1]))
    when = np.array([t])
    if -slope * length < GRAZES * guard.scale:
        return Defects(guard.name, place, when, np.array([size]), guard.scale, guard.unit, GRAZING)
    noise = ROUNDING * max(1.0, 0.1 * float(scales.condition[step]))
    scale = guard.scale / -slope
    floor = noise + INSTANT * float(samples.end[-1]) / scale
    return Defects(guard.name, place, when, np.array([size / -slope]), scale, "s", floor)


def _sense(
    samples: MotionSamples, scales: MotionScales, contact: ContactInstants, row: int, change: Transition
) -> Iterator[Defects]:
    """Friction that reached its cone was against the slip that begins."""
    friction = float(contact.friction[row, -1])
    if change.before in STICKING and change.after in SENSE and np.isfinite(friction):
        size, scale = np.array([SENSE[change.after] * friction]), force_scale_at(samples, contact.law, scales)
        yield Defects(
            "friction is against the slip", contact.law.name, np.array([change.time]), size, scale, "N", GRAZES
        )


def _landing(
    samples: MotionSamples, scales: MotionScales, change: Transition, step: int, with_others: bool
) -> Iterator[Defects]:
    """The curves meet where the transition says, and approach each other; at once with others an impact there may
    press them together."""
    if not np.isfinite(change.xi1 + change.xi2):
        return
    law, when = law_at(samples.case, change.contact or CONTACT), np.array([change.time])
    plates = plates_at(samples, step, -1)
    met = touch(samples.case, law, change.before, plates, change.xi1, change.xi2, change.time)
    rate, gap = float(met.across @ plates.rates), float((met.gap * met.tangent.conjugate()).imag)
    floor = LANDING + AMPLIFICATION * float(scales.condition[step])
    yield Defects("curves meet", law.name, when, np.array([abs(met.gap)]), scales.extent, "m", floor)
    if not with_others:
        yield Defects("curves approach", law.name, when, np.array([rate]), scales.speed, "m/s", STILL)
    if rate < -STILL * scales.speed:
        # Also what roundings of the gap, and the motion's error, make of it.
        last, late = float(samples.end[-1]), scales.extent / -rate
        part = (floor * last + CLOSED * late) / (last + late)
        yield Defects("curves meet in time", law.name, when, np.array([abs(gap / rate)]), last + late, "s", part)


def limit_of_impacts(end: float, where: str, impacts: np.ndarray, last: float) -> Iterator[Defects]:
    """Impacts that follow each other at a fixed ratio end at the limit of their times (Aitken's extrapolation). Its
    error is that of the ratio, which changes from one to the next; where it is not nearly fixed the limit is
    open, as it is for two corners that bounce alternately."""
    times = impacts[impacts < end - CLOSE * last][-4:]
    if len(times) < 4:
        return
    one, two, three = np.diff(times)
    ratio, before = three / two, two / one
    if not (0.0 < ratio < MOST_RATIO and abs(ratio - before) < RATIO_CHANGE):
        return
    limit = times[-1] + three * ratio / (1.0 - ratio)
    error = 5.0 * three * abs(ratio - before) / (1.0 - ratio) ** 3
    late, when = np.array([abs(end - limit)]), np.array([end])
    yield Defects("impacts end at their limit", where, when, late, last, "s", LANDING + error / last)
