"""The beginning of a flight from the track, and flights that are over before they have begun: hops.

Where a flight begins on the track its gap is the small difference of two places, and its rate is known much better. So
a first look is so close that the curves are polynomials until then: there the gap grows, or its rate falls evenly, or
as a polynomial says, and its integral vanishes where the plate lands.
"""

from __future__ import annotations

from math import hypot, inf, isnan, nan

import numpy as np
from numpy.polynomial import Chebyshev

from cases import Case

from .gap import Look, Looks, state
from .integrators.segment import Segment

# Until the first look the plate moves by this part of its size, at most, and the pair by this part of a piece in which
# the curves are polynomials of some degree (`cases.features`).
CLOSE, PIECE = 1 / 16, 1 / 4
# Where a flight begins on the track, a first look one step later, or a quarter of it and so on, finds the gap growing.
# Sooner than this part of the step, positions do not resolve it: there is no flight.
SOONEST = 1e-9
# A gap's rate falls evenly, or as a polynomial says, where they differ by a few roundings of the plate's speeds.
EVEN = 1e-14
# Where a polynomial through the rate is to be known: up to a little beyond where an even fall would land.
HOP = 1.0625
# How often that is looked for again with the rate there: a pull that grows makes it longer than the first look says.
REFINEMENTS = 5
_LOOKS = 0.5 - 0.5 * np.cos(np.pi * np.arange(9) / 8)


def first_look(looks: Looks, segment: Segment, start: Look) -> Look | None:
    """A look soon after the start at which the gap is positive and grows, or a hop's landing (whose `beyond` is a
    number); None if the gap closes."""
    part = _time_for(segment, start, looks.case.plate.reach)
    soonest = SOONEST * part
    while part > soonest:
        look = looks.at(segment, start.time + part, start.pair)
        if look is None or not _is_resolved(looks.case, start, look):
            part *= 0.25
            continue
        if start.rate > 0.0 > look.rate:
            hop = _hop(looks, segment, start, look)
            if hop is not None:
                return hop
        if look.rate > 0.0 and look.gap > 0.0:
            return look
        # Half the time in which the rate falls to zero, as it has fallen until now (it may begin at a mere rounding).
        falls = start.rate > 0.0 > look.rate
        part *= min(max(0.5 * start.rate / (start.rate - look.rate), 1e-3), 0.5) if falls else 0.25
    return None


def _hop(looks: Looks, segment: Segment, start: Look, ahead: Look) -> Look | None:
    """The landing of a flight that begins at `start` on the track, if it is a hop over before `ahead`.

    A rate that falls evenly vanishes half-way; where a polynomial through a few looks is as good as the rates
    themselves, its integral's zero is the landing.
    """
    most, lasts, whole = ahead.time - start.time, inf, ahead
    for _ in range(REFINEMENTS):
        if not whole.rate < start.rate:
            return None
        before, lasts = lasts, 2.0 * start.rate * (whole.time - start.time) / (start.rate - whole.rate)
        if not lasts <= most:
            return None
        if abs(lasts - before) <= 0.5 * (HOP - 1.0) * lasts:
            break
        look = looks.at(segment, start.time + lasts, start.pair)
        if look is None:
            return None
        whole = look
    half = looks.at(segment, start.time + 0.5 * lasts, start.pair)
    if half is None:
        return None
    # Times are rounded, what is between them is not.
    fall = (start.rate - whole.rate) / (whole.time - start.time)
    if abs(start.rate - fall * (half.time - start.time) - half.rate) <= EVEN * start.speed:
        lasts = 2.0 * start.rate / fall
    else:
        lasts = _uneven(looks, segment, start, lasts)
    landing = None if isnan(lasts) else looks.at(segment, start.time + lasts, start.pair)
    if landing is None or not landing.rate < 0.0:
        return None
    return landing._replace(beyond=lasts - (landing.time - start.time))


def _uneven(looks: Looks, segment: Segment, start: Look, lasts: float) -> float:
    """How long a hop lasts whose rate falls unevenly, about `lasts`; NaN where a polynomial does not tell."""
    samples = [start]
    for x in _LOOKS[1:]:
        look = looks.at(segment, start.time + x * HOP * lasts, start.pair)
        if look is None:
            return nan
        samples.append(look)
    parts = [(look.time - start.time) / (HOP * lasts) for look in samples]
    rate = Chebyshev.fit(parts, [look.rate for look in samples], len(samples) - 1, domain=(0.0, 1.0))
    if not np.max(np.abs(rate.coef[-2:])) <= 10.0 * EVEN * start.speed:
        return nan
    gap, x = rate.integ(lbnd=0.0), 1.0 / HOP
    for _ in range(5):  # Newton's method, from the landing of an even fall, a few parts in a hundred away
        x -= float(gap(x) / rate(x))
    return x * HOP * lasts if 0.0 < x <= 1.0 else nan


def _time_for(segment: Segment, look: Look, size: float) -> float:
    """How long the plate's points take for a small part of its size, from the speeds before and after."""
    step = min(CLOSE * size / max(look.speed, 1e-300), float(segment.times[-1]) - look.time)
    while step * _speed(state(segment, look.time + step), size) > 2.0 * CLOSE * size:
        step *= 0.5  # a plate that is let go has no speed yet, and gains it
    return step


def _speed(now: list[float], size: float) -> float:
    """A bound on the speed of the points of a plate of that size, m/s."""
    _, _, _, vx, vy, omega = now
    return hypot(vx, vy) + abs(omega) * size


def _is_resolved(case: Case, start: Look, look: Look) -> bool:
    """Whether between two looks the pair stays within a part of what the curves are polynomials on."""
    curves = (case.track, case.plate.outline)
    return all(
        curve.features is None or abs(after - before) <= PIECE * curve.features.resolved(before)
        for curve, before, after in zip(curves, start.pair, look.pair, strict=True)
    )
