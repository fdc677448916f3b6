"""Flights, and what follows them by the law of impact: a rebound, contact, or the end of the motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import hypot

import numpy as np

from cases import Case, Impact
from cases.contact import pose
from cases.curves.curve_pieces import TooMuch

from ..effect_laws.restitution import creates_energy
from ..endings import (
    COMPLETION,
    ENERGY,
    LANDING_END,
    search_limit_ending,
    work_limit_ending,
)
from ..scales import MOST_STEPS, frequency
from .bouncing import Bounces, is_unresolved
from .contact_end import Step, breakdown, contact_step, free_quantities, own_lift
from .impact import collide, energy, law_of
from .integrators.segment import LOST_SIGHT, OUT_OF_STEPS, Segment
from .landing import Landing, Landings
from .modes import FLIGHT, Phase, in_contact, in_flight


def simulate_flight(
    case: Case, now: Phase, t: float, y, place: tuple[float, float], rtol: float, integrate, landings: Landings
) -> tuple[list[Segment], Landing | None]:
    """Simulate a flight: its segments up to the landing, and the landing; `place` is the pair of points of last
    contact.

    It is integrated over the duration estimated from its own scales, then repeatedly over twice the time.
    """
    segments: list[Segment] = []
    lasts = _may_last(now, t, y)
    while True:
        until = max(t + lasts, t + 1e3 * np.spacing(t))
        segment = integrate(now, t, y, min(until, case.duration), rtol)
        try:
            landing = landings.first(segment, place, under_way=bool(segments))
        except TooMuch:
            segments.append(segment.cut(landings.flies_until, LOST_SIGHT))
            return segments, None
        segments.append(segment.cut(landing.time, None) if landing else segment)
        if landing or segment.event.guard or segment.event.time >= case.duration:
            return segments, landing
        if sum(segment.steps for segment in segments) >= MOST_STEPS:
            return [*segments[:-1], segment.ended_by(OUT_OF_STEPS)], None
        t, y, lasts = segment.event.time, segment.event.state, 2.0 * lasts


def closes(case: Case) -> bool:
    """Whether a case begins with an impact."""
    return case.start.gap == 0.0 and case.start.gap_rate < 0.0


def start_flight(
    case: Case, now: Phase, t: float, y, place: tuple[float, float], rtol: float, integrate, landings: Landings
) -> tuple[list[Segment], Landing]:
    """The flight of zero length before the impact that a case begins with, and that impact."""
    segment = integrate(now, t, y, 1e3 * np.spacing(t), rtol)
    return [replace(segment.cut(t, None), evaluations=0)], landings.start_impact(segment)


def _may_last(now: Phase, t: float, y: Sequence[float]) -> float:
    """Estimated duration of a flight, s: until its force has brought it back, or it has moved or fallen by its size."""
    rates = now.system.rates_of_numbers(t, tuple(y), now.parameters)
    speed, force = hypot(*y[3:5]), hypot(*rates[3:5])
    often = frequency(now, t, y)
    back = 4.0 * speed / force if force else 0.0
    return max(back, 4.0 / often if often else np.inf)


def after_flight(case: Case, segments: list[Segment], landing: Landing | None, bounces: Bounces) -> Step:
    """The step after a landing, by the impact law."""
    path, last = tuple(segments), segments[-1]
    if landing is None:
        t, guard, steps = last.event.time, last.event.guard, sum(segment.steps for segment in segments)
        limits = {OUT_OF_STEPS: work_limit_ending(t, steps), LOST_SIGHT: search_limit_ending(t)}
        ending = COMPLETION if guard is None else limits.get(guard) or breakdown(last.phase, last)
        return Step(path, t, ending=ending)
    place = landing.xi1, landing.xi2
    if case.effect(Impact) is None:
        return Step(path, landing.time, place, "landing", ending=LANDING_END)
    law, since = law_of(case, landing.arm_t, landing.arm_n, landing.touch.slip), path[0].start
    # A gap that opens without a flight does not grow: the plate comes down as fast as it rose, and stays.
    none = landing.time == since and landing.touch.lift >= 0.0
    is_listed = not none and bounces.strike(since, landing)
    touch = landing.touch._replace(lift=-landing.touch.lift) if none else landing.touch
    after = collide(law, touch)
    if creates_energy(law.name, energy(law, touch), energy(law, after)):
        return Step(path, landing.time, place, "landing", ending=ENERGY)
    y = in_contact(case, landing.time, *place, after.slip, after.omega, landing.theta)
    pull = np.inf
    if after.lift > 0.0:
        pull = free_quantities(case, landing.time, y).free_approach + own_lift(case, landing.time, y)
    if none or after.lift <= 0.0:
        bounces.no_rebound()
        cause = "rest" if after.lift > 0.0 else "landing"
        return contact_step(case, path, landing.time, place, landing.theta, after._replace(lift=0.0), cause, is_listed)
    is_last = is_unresolved(after.lift, pull, _far(case, place))
    bounces.rebound(landing, after, pull)
    # Listed impacts are simulated one by one.
    limit = None if is_listed and not is_last else bounces.limit(is_last)
    if limit and landing.time < limit.time < case.duration:
        with_rest, at = (*path, bounces.settling(path[-1].phase, limit)), (limit.xi1, limit.xi2)
        return contact_step(case, with_rest, limit.time, at, limit.theta, limit.touch, "rest", False)
    if is_last:
        return contact_step(case, path, landing.time, place, landing.theta, after._replace(lift=0.0), "rest", is_listed)
    aloft = in_flight(case, landing.time, y, after.slip, after.omega, after.lift)
    return Step(path, landing.time, place, "landing", aloft, FLIGHT, is_listed=is_listed)


def _far(case: Case, place: tuple[float, float]) -> float:
    """How far the plate and its contact are from the origin and from each other, m."""
    x, y, _ = pose(case, *place)
    return abs(x) + abs(y) + float(np.hypot(*case.plate.outline.point(place[1])))
