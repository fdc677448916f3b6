"""The impacts of a motion, by the law of the case: Routh's construction at one contact, complementarity at several."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np

from cases import Impact, Mode
from cases.motion.trajectory import CONTACT

from ..endings import CAUSES
from .broken_laws import worst
from .contact_impulse import impulse_of_one, impulses_at_once
from .laws import Defects, Joins, MotionScales
from .meetings import meetings
from .samples import CLOSE, MotionSamples, PlateSamples, contact_of, law_at
from .tolerances import AMPLIFICATION, CLOSED, PARTS, STILL, TOUCHES
from .touches import TouchNow, couple_row, largest_rate, masses, plates_at, touch, touches_at

# Parts of the speed: an impact at one contact, and at several by linear programs.
ONE, SEVERAL = 1e-11, 1e-8
# Rebounds at several contacts that are slower than this part of the largest speed have no end that is known
# (solver/impact_ends.py): contacts that would open so slowly stay closed. What changes velocities by at most a hundred
# times as much is compared to within it.
ABSORBED, OF_ABSORBED = 1e-7, 100.0
# The slips of impacts that follow each other, in parts of the way from that before them to that after them.
PARTS_OF_SLIP = np.linspace(-1.0, 2.0, 13)


def impact_defects(samples: MotionSamples, scales: MotionScales, sudden: Joins, rtol: float) -> Iterator[Defects]:
    """Velocities jump as the law of impact says, and where something touches. Impacts that are not listed of a plate
    that flies before and after have no place, and are checked by their energy alone, as are those of several contacts
    that are not listed."""
    if samples.case.effect(Impact) is None:
        return
    for time, step in zip(sudden.times.tolist(), sudden.steps.tolist(), strict=True):
        if samples.is_straight[step] or samples.is_straight[step - 1] or passes_piece(samples, time):
            continue
        plates = plates_at(samples, step - 1, -1), plates_at(samples, step, 0)
        yield from impact_at(samples, scales, plates, step, time, rtol)


def is_impact(samples: MotionSamples, scales: MotionScales, rtol: float) -> bool:
    """Whether something approaches that it touches at the end of a motion: what follows is an impact."""
    plates, last = plates_at(samples, len(samples.start) - 1, -1), float(samples.end[-1])
    places = places_of_impact(samples, scales, plates, len(samples.start), last, rtol, TOUCHES)
    limit = -(STILL + PARTS * rtol) * scales.speed
    return any(float(one.across @ plates.rates) < limit for one in places)


def passes_piece(samples: MotionSamples, time: float) -> bool:
    """Whether a contact passes to the next piece of its curve, where the direction of an impulse is not defined."""
    near = CLOSE * float(samples.end[-1])
    return any(c.cause == CAUSES["piece"] and abs(c.time - time) <= near for c in samples.transitions)


def impact_at(
    samples: MotionSamples, scales: MotionScales, plates: tuple[PlateSamples, PlateSamples], step: int, time: float,
    rtol: float,
) -> Iterator[Defects]:  # fmt: skip
    """The law of an impact at the start of a step, from the velocities before to those after it."""
    places = places_of_impact(samples, scales, plates[0], step, time, rtol)
    near = CLOSE * float(samples.end[-1])
    is_listed = time == 0.0 or any(abs(change.time - time) <= near for change in samples.transitions)
    if is_listed or len(samples.motion.contact_names) == 1:
        every = [d for some in groups_of(places) for d in _one_impact(samples, scales, some, plates, step, time, rtol)]
        if any(worst(one, rtol) for one in every) and (more := _unlisted(samples, scales, plates[0], places, time)):
            groups = groups_of([*places, *more])
            every = [d for some in groups for d in _one_impact(samples, scales, some, plates, step, time, rtol)]
        yield from every


def _unlisted(
    samples: MotionSamples, scales: MotionScales, plates: PlateSamples, places: list[TouchNow], time: float
) -> list[TouchNow]:
    """Further places at which plates touch: two that touch at one instant only, and part by the impact of others, have
    no transition."""
    results, least = list[TouchNow](), TOUCHES * scales.extent
    for at in meetings(samples, plates, time):
        if abs(at.gap) < least and all(abs(at.point - other.point) > least for other in [*places, *results]):
            results.append(at)
    return results


def groups_of(places: list[TouchNow]) -> list[list[TouchNow]]:
    """The contacts that hang together: those of the same plates."""
    groups = list[tuple[set[int], list[TouchNow]]]()
    for one in places:
        bodies, own = {one.law.body} | ({one.law.base} if one.law.base is not None else set()), [one]
        for group in [each for each in groups if each[0] & bodies]:
            groups.remove(group)
            bodies, own = bodies | group[0], group[1] + own
        groups.append((bodies, own))
    return [own for _, own in groups]


def places_of_impact(
    samples: MotionSamples, scales: MotionScales, plates: PlateSamples, step: int, time: float, rtol: float,
    touching: float = CLOSED,
) -> list[TouchNow]:  # fmt: skip
    """Where plates touch at the start of a step: contacts that are closed before or after, those that are listed, and
    those whose columns have a gap that is none."""
    near, case, motion = CLOSE * float(samples.end[-1]), samples.case, samples.motion
    places = {
        one.law.name: (one.xi1, one.xi2, one.mode) for one in touches_at(samples, max(step - 1, 0), -1 if step else 0)
    }
    if step < len(samples.start):
        places |= {one.law.name: (one.xi1, one.xi2, one.mode) for one in touches_at(samples, step, 0)}
    for change in samples.transitions:
        if abs(change.time - time) <= near and np.isfinite(change.xi1 + change.xi2):
            places.setdefault(change.contact or CONTACT, (change.xi1, change.xi2, Mode.ROLL))
    if motion.contact_columns is not None:
        for name in motion.contact_names:
            for t in (np.nextafter(time, -np.inf), time):
                now = contact_of(motion, name, np.array([min(max(t, 0.0), float(samples.end[-1]))]))
                xi1, xi2 = float(now.xi1[0]), float(now.xi2[0])
                if np.isfinite(xi1 + xi2):
                    places.setdefault(name, (xi1, xi2, Mode.FLIGHT))
    every = [touch(case, law_at(case, name), mode, plates, xi1, xi2, time) for name, (xi1, xi2, mode) in places.items()]
    closed = (TOUCHES + PARTS * rtol) * scales.extent
    return [
        one for one in every if abs(one.gap) < (closed if one.mode is not Mode.FLIGHT else touching * scales.extent)
    ]


def _one_impact(
    samples: MotionSamples, scales: MotionScales, places: list[TouchNow], plates: tuple[PlateSamples, PlateSamples],
    step: int, time: float, rtol: float,
) -> Iterator[Defects]:  # fmt: skip
    (before, after), case, law = plates, samples.case, places[0].law
    own, inverse = masses(case)
    bodies = {body for one in places for body in (one.law.body, one.law.base)}
    is_of_group = np.repeat([body in bodies for body in range(len(before.place))], 3)
    when, jump = np.array([time]), np.where(is_of_group, after.rates - before.rates, 0.0)
    if largest_rate(jump, scales.size) <= (ONE + PARTS * rtol) * scales.speed:
        return
    floor = AMPLIFICATION * float(max(scales.condition[step], scales.condition[max(step - 1, 0)]))
    if len(places) == 1 and not law.arm:
        rows = np.array([places[0].along, places[0].across])
        matrix = rows * inverse @ rows.T
        slip, closing = places[0].slip, float(places[0].across @ before.rates)
        yield Defects("curves approach", law.name, when, np.array([closing]), scales.speed, "m/s", STILL)
        velocity, (moving, stick) = np.array([slip, closing]), map(float, law.in_impact(slip))
        every = [impulse_of_one(matrix, velocity, moving, stick, law.impact)]
        if case.others:  # plates that nearly touch have one impact by complementarity
            every += impulses_at_once(matrix, velocity, moving, stick, law.impact)
        off = min(largest_rate(jump - inverse * (np.array(each) @ rows), scales.size) for each in every)
        yield Defects("law of impact", law.name, when, np.array([off]), scales.speed, "m/s", ONE + floor)
        return
    yield from _impact_of_several(scales, places, (before, after), own * is_of_group, when, floor + PARTS * rtol)


def _impact_of_several(
    scales: MotionScales, places: list[TouchNow], plates: tuple[PlateSamples, PlateSamples], own: np.ndarray,
    when: np.ndarray, floor: float,
) -> Iterator[Defects]:  # fmt: skip
    """Impulses inside the cones make the jump, of contacts that may have one: by a linear program. With Poisson's
    restitution, where slip reverses, and in impacts that follow each other at one instant, friction is anywhere in its
    cone."""
    before, after = plates
    count, limit = len(before.place), (STILL + floor) * scales.speed
    unit, columns = np.tile([1.0, 1.0, 1.0 / scales.size], count), list[np.ndarray]()
    # A contact that opens before the impact is touched by what another one does at the same instant: several follow.
    follow = any(float(one.across @ before.rates) > ONE * scales.speed for one in places)
    for one in places:
        law, impact = one.law, one.law.impact
        closing, opening = float(one.across @ before.rates), float(one.across @ after.rates)
        slip = one.slip + float(one.along @ (after.rates - before.rates))
        if one.mode is not Mode.FLIGHT:
            yield Defects("curves part", law.name, when, np.array([-opening]), scales.speed, "m/s", STILL + floor)
        e = impact.restitution
        is_exact = not follow and (impact.law == "moreau" or (e == 0.0 and len(places) > 1))
        if is_exact and opening + e * min(closing, 0.0) > limit:
            continue  # no impulse where it opens faster than by restitution
        # Of several that follow each has the friction of its own slip, near those before and after them all.
        every = one.slip + (slip - one.slip) * (PARTS_OF_SLIP if follow else np.zeros(1))
        moving, stick = (float(np.max(mu)) for mu in law.in_impact(every))
        sticks, certain = abs(slip) < limit, is_exact or moving == 0.0
        if np.isinf(moving) or (sticks and np.isinf(stick)):
            own_columns = [one.across]
            columns += [one.along, -one.along]
        elif sticks or not certain:
            ratio = stick if sticks else moving
            own_columns = [one.across + sense * ratio * one.along for sense in (1.0, -1.0)]
        else:
            own_columns = [one.across - np.sign(slip) * moving * one.along]
        if law.arm:
            couple = law.arm * couple_row(law, count)
            own_columns = [c + sense * couple for c, sense in product(own_columns, (1.0, -1.0))]
        columns += own_columns
    rest = own * (after.rates - before.rates) * unit
    largest = max(float(np.abs(rest).max()), np.finfo(float).tiny)
    change, off = largest_rate(own * (after.rates - before.rates), scales.size) / scales.speed, 1.0
    # Velocities have the error of those of an impact at one contact: of small impulses it is a larger part.
    missing = (ABSORBED if change <= OF_ABSORBED * ABSORBED else ONE + floor) / change
    if columns:
        from scipy.optimize import linprog  # takes a tenth of a second to import

        pull, m = (np.array(columns) * unit * (own > 0.0)).T, len(rest)
        cost = np.r_[np.zeros(pull.shape[1]), np.ones(2 * m)]
        off = linprog(cost, A_eq=np.c_[pull, np.eye(m), -np.eye(m)], b_eq=rest / largest).fun
    names = ", ".join(one.law.name for one in places)
    size = np.array([np.inf if off is None else off])
    yield Defects("law of impact", names, when, size, 1.0, "of the impulse", SEVERAL + missing + floor)
