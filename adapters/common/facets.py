"""Curves as corners, for engines whose shapes are straight: how far a plate can come, and the polygon that fits best.

Nothing here knows an engine. Lengths in metres.
"""

from __future__ import annotations

from functools import lru_cache
from math import pi
from typing import NamedTuple

import numpy as np

from cases import Case, Flight, Gravity
from cases.contact import start_motion
from cases.shapes import Circle, as_circle, as_line


class Stretch(NamedTuple):
    """The part of a track the plate can reach: parameters, arc length (m), whether closed, top speed (m/s) on it."""

    low: float
    high: float
    length: float
    closed: bool
    top_speed: float


def track_kind(case: Case) -> str:
    """What the track is to an engine with few shapes: "line", "hill" (a whole circle from outside) or "chain"."""
    if as_line(case.track):
        return "line"
    circle = as_circle(case.track)
    return "hill" if circle and not circle.left and case.track.period else "chain"


def round_plate(case: Case) -> Circle | None:
    """The circle that the outline is, about the centre of mass or not, or None."""
    return as_circle(case.plate.outline) if case.plate.outline.period else None


def radii(case: Case) -> tuple[float, float]:
    """Smallest and largest distance of the outline from the centre of mass, in metres."""
    r = np.hypot(*case.plate.outline.point(np.linspace(*case.plate.outline.look, 721)))
    return float(r.min()), float(r.max())


def pull(case: Case) -> np.ndarray:
    """Gravity as a vector in m/s², zero without Gravity."""
    gravity = case.effect(Gravity)
    return gravity.g * np.array([np.cos(gravity.direction), np.sin(gravity.direction)]) if gravity else np.zeros(2)


@lru_cache(maxsize=16)
def stretch(case: Case) -> Stretch:
    """Which part of the track the plate can reach, by its energy and by the time it has.

    Nothing adds energy, so the plate stays where its potential is below its first energy, unless it flies over what is
    above; and its speed cannot grow faster than g. A margin of the plate's own size is added at both ends.
    """
    start, (smallest, largest) = start_motion(case), radii(case)
    energy = 0.5 * (start.vx**2 + start.vy**2) + 0.5 * case.plate.inertia / case.plate.mass * start.omega**2
    energy += float(np.hypot(*pull(case))) * case.start.gap
    # The centre of a plate that is no disc may be lower than the walk below takes it to be, by this much of g.
    energy += float(np.hypot(*pull(case))) * (largest - smallest)
    longest = (np.sqrt(2 * energy) + np.hypot(*pull(case)) * case.duration) * case.duration
    ways = [_walk(case, start.xi1, way, energy, longest, largest) for way in (-1, 1)]
    (low, back, fast), (high, ahead, faster) = ways
    period = case.track.period
    if period and high - low >= period:
        low, high = start.xi1 - period / 2, start.xi1 + period / 2
        length = float(np.mean(case.track.speed(np.linspace(low, high, 721)[:-1]))) * period
        return Stretch(low, high, length, True, max(fast, faster))
    return Stretch(low, high, back + ahead, False, max(fast, faster))


def _walk(case: Case, xi1: float, way: int, energy: float, longest: float, margin: float) -> tuple[float, float, float]:
    """Farthest parameter reached in one direction, the arc length to it, and the top speed on the way."""
    track, far = case.track, 1.0
    bounded = track.period is not None or track.domain is not None
    if track.period:
        far = track.period
    elif track.domain:
        far = track.domain[1] - xi1 if way > 0 else xi1 - track.domain[0]
    while True:
        # 2000 steps to a walk follow every curve whose features its author could draw.
        s = xi1 + way * np.linspace(0.0, far, 2001)
        point, speed = track.point(s), track.speed(s)
        run = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]))]) * far / 2000
        if bounded or run[-1] > longest + margin:
            break
        far *= 2.0
    centre = point + case.plate.radius * track.normal(s) if case.plate.radius else point
    kinetic = energy + pull(case) @ (centre - centre[:, :1])
    barred = run > longest if case.effect(Flight) else (kinetic < 0.0) | (run > longest)
    stop = int(np.argmax(barred)) if barred.any() else len(s) - 1
    end = min(int(np.searchsorted(run, run[stop] + margin)), len(s) - 1)
    return float(s[end]), float(run[end]), float(np.sqrt(2 * max(kinetic[: stop + 1].max(), 0.0)))


def chain(case: Case, count: int) -> np.ndarray:
    """Corners, shape (2, count + 1), of `count` equally long facets along the stretch; closed: the last is the first.

    They lie outside a bend by κ L²/12, the mean of the sagitta, so that the chain's mean distance is right.
    """
    part, track = stretch(case), case.track
    fine = np.linspace(part.low, part.high, max(4 * count, 4000) + 1)
    speed = track.speed(fine)
    run = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]))])
    s = np.interp(np.linspace(0.0, run[-1], count + 1), run, fine)
    return track.point(s) - track.curvature(s) * (part.length / count) ** 2 / 12 * track.normal(s)


def polygon(case: Case, count: int) -> np.ndarray:
    """Corners, shape (2, count), at equal turns of the outline's tangent, blown up to the area of the outline.

    Equal turns put the corners where the outline bends most, so that every corner costs the same.
    """
    outline = case.plate.outline
    s = np.linspace(*outline.look, 64 * 721)
    angle = outline.tangent_angle(s)
    corners = outline.point(np.interp(angle[0] + 2 * pi * np.arange(count) / count, angle, s))
    return np.sqrt(_area(*outline.point(s[:-1])) / _area(*corners)) * corners


def _area(x: np.ndarray, y: np.ndarray) -> float:
    return float(0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


def sagitta(case: Case, facets: int | None, vertices: int | None) -> float:
    """How far (m) facets of the track and vertices of the outline stand off the curves; None: the shape is exact."""
    off = 0.0
    if facets:
        part = stretch(case)
        bend = np.abs(case.track.curvature(np.linspace(part.low, part.high, 721))).max()
        off += float(bend) * (part.length / facets) ** 2 / 8
    if vertices:
        bend = case.plate.outline.curvature(np.linspace(*case.plate.outline.look, 721)).min()
        # Corners at equal turns: the longest facet is where the outline bends least.
        off += (2 * pi / vertices) ** 2 / (8 * float(bend))
    return off
