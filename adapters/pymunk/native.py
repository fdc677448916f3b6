"""Scenes out of pymunk's own shapes: a disc or a polygon on a segment, on a circle, or on a chain of segments."""

from __future__ import annotations

import random
from collections.abc import Sequence
from functools import lru_cache
from itertools import product
from math import pi
from typing import NamedTuple

import numpy as np
import pymunk

from cases import Case, CoulombFriction, Gravity, Impact, Load, NotSupported, PerfectlyRough
from cases.contact import pose, start_motion
from cases.shapes import Circle, Line, as_circle, as_line

from ..interface import Setting

# What the track's chain is made of differs from rung to rung only in these; everything else is the engine's default.
KNOBS = ("collision_slop", "collision_bias", "iterations")


class Stretch(NamedTuple):
    """The part of a track the plate can reach: parameters, arc length (m), whether closed, top speed (m/s) on it."""

    low: float
    high: float
    length: float
    closed: bool
    top_speed: float


def track_kind(case: Case) -> str:
    """How the engine's shapes make the track: "line" (one segment), "hill" (one circle) or "chain" (segments)."""
    if as_line(case.track):
        return "line"
    circle = as_circle(case.track)
    return "hill" if circle and not circle.left and case.track.period else "chain"


def radii(case: Case) -> tuple[float, float]:
    """Smallest and largest distance of the outline from the centre of mass, in metres."""
    r = np.hypot(*case.plate.outline.point(np.linspace(*case.plate.outline.look, 721)))
    return float(r.min()), float(r.max())


def pull(case: Case) -> np.ndarray:
    """Gravity as a vector in m/s², zero without Gravity."""
    gravity = case.effect(Gravity)
    return gravity.g * np.array([np.cos(gravity.direction), np.sin(gravity.direction)]) if gravity else np.zeros(2)


# A coefficient no contact here comes near: even a millionth of a newton would hold a plate of a tonne on a wall.
ROUGH = 1e9


def friction_coefficient(case: Case) -> float:
    """Of the two shapes together: mu, zero without friction, ROUGH for a perfectly rough contact."""
    friction = case.effect(CoulombFriction)
    return ROUGH if case.effect(PerfectlyRough) else friction.mu if friction else 0.0


# --- how far the plate can come --------------------------------------------------------------------------------------


@lru_cache(maxsize=16)
def stretch(case: Case) -> Stretch:
    """Which part of the track the plate can reach, by its energy and by the time it has.

    Nothing adds energy, so the plate stays where its potential is below its first energy; and its speed cannot grow
    faster than g. A margin of the plate's own size is added at both ends.
    """
    start, (smallest, largest) = start_motion(case), radii(case)
    if case.effect(Load):
        return _everywhere(case)
    energy = 0.5 * (start.vx**2 + start.vy**2) + 0.5 * case.plate.inertia / case.plate.mass * start.omega**2
    # A start off the track is higher, or lower, than the pose of contact there.
    on_track = np.array(pose(case, start.xi1, start.xi2)[:2])
    energy += float(pull(case) @ (on_track - (start.x, start.y)))
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


# How far from its start (m) a plate with a load may come on a straight line, which has no end of its own.
FAR = 1e3


def _everywhere(case: Case) -> Stretch:
    """The whole track: a load may take the plate anywhere. Its speed is taken to be what gravity gives in that time."""
    track = case.track
    low, high = (case.start.xi1 - FAR, case.start.xi1 + FAR) if track.domain is None else track.domain
    if track.period:
        low, high = case.start.xi1 - track.period / 2, case.start.xi1 + track.period / 2
    length = float(np.mean(track.speed(np.linspace(low, high, 2001)))) * (high - low)
    start = start_motion(case)
    fast = float(np.hypot(start.vx, start.vy) + np.hypot(*pull(case)) * case.duration)
    return Stretch(low, high, length, track.period is not None, fast)


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
    barred = (kinetic < 0.0) | (run > longest)
    stop = int(np.argmax(barred)) if barred.any() else len(s) - 1
    end = min(int(np.searchsorted(run, run[stop] + margin)), len(s) - 1)
    return float(s[end]), float(run[end]), float(np.sqrt(2 * max(kinetic[: stop + 1].max(), 0.0)))


# --- the shapes' fineness --------------------------------------------------------------------------------------------

# A polygon a person would type in; and the finest whose small overlaps the engine still finds (at 1000 corners an
# elliptic plate of 0.3 m sank 7 cm into a circle).
MODEST, MOST_CORNERS = 64, 800


def shape_knobs(case: Case, h: float | None) -> dict[str, float | int]:
    """How fine and how thick the shapes are that go with the step h (s); None: a first-time user's.

    A facet is as long as the plate's way in one step at its top speed: shorter ones cost time and gain nothing.
    """
    kind, knobs = track_kind(case), dict[str, float | int]()
    if kind == "chain":
        part = stretch(case)
        way = part.top_speed * h if h else 0.0
        knobs["facets"] = max(MODEST, round(part.length / way)) if way else MODEST
        # A facet told of its neighbours does not catch the plate with its end where they meet. Nobody tells it unasked.
        knobs["neighbors"] = 0 if h is None else 1
    if kind != "hill":
        # Thick walls catch what sinks into them; thin ones spare the engine's search for overlapping boxes.
        thickness = radii(case)[0] * (1.0 if h is None else 0.05)
        knobs["thickness"] = min(thickness, 0.5 * _tightest_hill(case))
    if plate_kind(case) == "polygon":
        # Corners cost energy as facets do; 0.2 s over the step is where they cost as much as the step itself.
        knobs["vertices"] = MODEST if h is None else int(np.clip(round(0.2 / h), MODEST, MOST_CORNERS))
    return knobs


def space_knobs(case: Case) -> dict[str, float | int]:
    """The space's knobs of every rung but the first: all overlap beyond a small slop is corrected at once."""
    knobs: dict[str, float | int] = dict(collision_slop=1e-5 * radii(case)[0], collision_bias=0.0)
    if not case.plate.radius:
        knobs["iterations"] = 20
    return knobs


def model_grid(case: Case, steps: Sequence[float]) -> list[dict[str, float | int]]:
    """The model's knobs that belong to the steps (s), in every combination, from the coarsest to the finest.

    Corners, or facets and whether they know their neighbours, as fine as each of the steps asks for; a disc on one
    segment or circle has its slop alone.
    """
    finest = shape_knobs(case, min(steps)) | space_knobs(case)
    choices: dict[str, Sequence[float | int]] = {}
    fineness = next((name for name in ("vertices", "facets") if name in finest), None)
    if fineness:
        choices[fineness] = sorted({shape_knobs(case, h)[fineness] for h in steps})
    if fineness == "facets":
        choices["neighbors"] = (0, 1)
    if not choices:
        choices["collision_slop"] = [finest["collision_slop"] * factor for factor in (1000, 100, 10, 1)]
    return [finest | dict(zip(choices, values, strict=True)) for values in product(*choices.values())]


def plate_kind(case: Case) -> str:
    """How the engine's shapes make the plate: "circle" or "polygon"."""
    return "circle" if as_circle(case.plate.outline) and case.plate.outline.period else "polygon"


def scene_kind(case: Case) -> str:
    """What decides the cost of a scene: the track's kind for a disc; "polygon" or "polygon on chain" for others."""
    kind = track_kind(case)
    if plate_kind(case) == "circle":
        return kind
    return "polygon on chain" if kind == "chain" else "polygon"


def roughness(case: Case, setting: Setting) -> float:
    """The largest sagitta (m) of the facets that stand for track and outline; zero where the shapes are exact."""
    knobs, sagitta = dict(setting.values), 0.0
    if "facets" in knobs:
        part = stretch(case)
        bend = np.abs(case.track.curvature(np.linspace(part.low, part.high, 721))).max()
        sagitta += float(bend) * (part.length / setting["facets"]) ** 2 / 8
    if "vertices" in knobs:
        bend = case.plate.outline.curvature(np.linspace(*case.plate.outline.look, 721)).min()
        # Corners at equal turns: the longest facet is where the outline bends least.
        sagitta += (2 * pi / setting["vertices"]) ** 2 / (8 * float(bend))
    return sagitta


def _tightest_hill(case: Case) -> float:
    """Smallest radius of curvature (m) of the track's bends away from the plate, infinite if there are none."""
    part = stretch(case)
    bend = float(case.track.curvature(np.linspace(part.low, part.high, 721)).min())
    return -1 / bend if bend < 0.0 else float("inf")


# --- the space -------------------------------------------------------------------------------------------------------


# A segment takes 1.2 kilobytes, its share of the engine's tree and the arrays it is made from included.
_MOST_FACETS = 1_000_000


def build(case: Case, setting: Setting) -> tuple[pymunk.Space, pymunk.Body]:
    """A space with the track as static shapes and the plate at the case's start, gravity and friction included."""
    space = pymunk.Space()
    gx, gy = pull(case)
    space.gravity = float(gx), float(gy)
    for knob in KNOBS:
        if knob in setting:
            setattr(space, knob, setting[knob])
    body = pymunk.Body(case.plate.mass, case.plate.inertia)
    plate = _plate_shape(case, body, setting)
    plate.friction = friction_coefficient(case)
    shapes = _track_shapes(case, space, setting)
    impact = case.effect(Impact)
    plate.elasticity = impact.restitution if impact else 0.0
    for shape in shapes:
        # The engine multiplies the two shapes' coefficients.
        shape.friction = shape.elasticity = 1.0
    # Sorted insertion degenerates the engine's tree into a list; any fixed shuffle keeps it shallow.
    random.Random(0).shuffle(shapes)
    space.add(body, plate, *shapes)
    return space, body


def _plate_shape(case: Case, body: pymunk.Body, setting: Setting) -> pymunk.Shape:
    circle = as_circle(case.plate.outline)
    if plate_kind(case) == "circle" and circle:
        x, y = circle.centre
        return pymunk.Circle(body, circle.radius, (float(x), float(y)))
    return pymunk.Poly(body, _matched_polygon(case, setting["vertices"]))


def _matched_polygon(case: Case, count: int) -> list[tuple[float, float]]:
    """Corners at equal steps of the tangent's angle, blown up so that the polygon has the outline's area.

    Equal turns put the corners where the outline bends most, so that every corner costs the same.
    """
    outline = case.plate.outline
    s = np.linspace(*outline.look, 64 * 721)
    angle = outline.tangent_angle(s)
    corners = outline.point(np.interp(angle[0] + 2 * pi * np.arange(count) / count, angle, s))
    x, y = outline.point(s[:-1])
    grow = np.sqrt(_area(x, y) / _area(*corners))
    return [(float(grow * u), float(grow * v)) for u, v in corners.T]


def _area(x: np.ndarray, y: np.ndarray) -> float:
    return float(0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


def _track_shapes(case: Case, space: pymunk.Space, setting: Setting) -> list[pymunk.Shape]:
    kind, line, circle = track_kind(case), as_line(case.track), as_circle(case.track)
    if kind == "hill" and circle:
        return [_static_circle(space, circle)]
    if line:
        return [_line_segment(case, space, line, setting["thickness"])]
    return _chain(case, space, setting)


def _static_circle(space: pymunk.Space, circle: Circle) -> pymunk.Shape:
    x, y = circle.centre
    return pymunk.Circle(space.static_body, circle.radius, (float(x), float(y)))


def _line_segment(case: Case, space: pymunk.Space, line: Line, thickness: float) -> pymunk.Shape:
    """One segment along the stretch, its surface above the line by half the slop the engine allows anyway.

    The engine finds a contact only where shapes overlap: without that overlap the plate would fall once more.
    """
    part = stretch(case)
    normal = np.array([-line.direction[1], line.direction[0]])
    lift = normal * (0.5 * min(space.collision_slop, 1e-6 * radii(case)[0]) - thickness)
    (ax, ay), (bx, by) = (case.track.point(s) + lift for s in (part.low, part.high))
    return pymunk.Segment(space.static_body, (float(ax), float(ay)), (float(bx), float(by)), thickness)


def _chain(case: Case, space: pymunk.Space, setting: Setting) -> list[pymunk.Shape]:
    """Segments of equal length along the stretch, behind the track by their radius.

    The corners lie outside a bend by κ L²/12, the mean of the sagitta, so that the chain's mean distance is right.
    """
    part, track, count, thickness = stretch(case), case.track, setting["facets"], setting["thickness"]
    if count > _MOST_FACETS:
        raise NotSupported(
            f"At this step so near a fit needs {count:,} facets, and a million take more than a gigabyte of memory; "
            "give a coarser setting."
        )
    s = _equal_arcs(case, part, count)
    bend = track.curvature(s) * (part.length / count) ** 2 / 12
    corners = track.point(s) - (thickness + bend) * track.normal(s)
    points = [(float(x), float(y)) for x, y in corners.T]
    if part.closed:
        points[-1] = points[0]
        before, after = points[-2], points[1]
    else:
        before, after = points[0], points[-1]
    padded = [before, *points, after]
    segments: list[pymunk.Shape] = []
    for i in range(count):
        segment = pymunk.Segment(space.static_body, points[i], points[i + 1], thickness)
        if setting["neighbors"]:
            segment.set_neighbors(padded[i], padded[i + 3])
        segments.append(segment)
    return segments


def _equal_arcs(case: Case, part: Stretch, count: int) -> np.ndarray:
    """Parameters of count + 1 points a constant arc length apart."""
    fine = np.linspace(part.low, part.high, max(4 * count, 4000) + 1)
    speed = case.track.speed(fine)
    run = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]))])
    return np.interp(np.linspace(0.0, run[-1], count + 1), run, fine)
