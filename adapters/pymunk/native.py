"""Scenes with pymunk's own shapes on a segment, on a circle, or on a chain of segments.

The plate is a circle, or a polygon if its outline is closed and nowhere bends inwards. Any other plate has one segment
per facet of its outline: one for a straight edge.

On a hill the contact acts in single steps. A push leaves the velocity along the tangent, the gap grows in the next
step, and the plate flies until it meets the track again: the longer, the weaker the contact. A plate therefore leaves a
hill early by a term of order √h: up to 0.01 in cos φ at h = 2e-4 s, 0.008 measured. `adapters.laws.mechanics.lift_off`
derives the bound; no setting of the engine changes it.

A polygon that rolls loses energy at each corner, as the engine's impacts are inelastic: with N corners on a full turn a
chord of an arc with radius R is L = 2 π R/N long, and angular momentum about the new corner takes the share
m L²/(2 (J + m r²)) of the spin, r the distance from the centre of mass to the corner. `reuleaux_on_slope` shows it: its
first corner is a barrier that takes 85 % of the energy. 64 corners lose 20 % on the arc before it, 100 lose 13 %, and
both, with what the step loses, fall back; 200 lose 7 % and pass. No chaos, but two outcomes.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import count, pairwise, product

import numpy as np
import pymunk
from pymunk import Vec2d

from cases import Belt, Case, Chain, CoulombFriction, Curve, Drive, Impact, NotSupported, PerfectlyRough
from cases.curves.line_or_circle import Circle, Line, as_circle, as_line
from cases.effects import Effect, one
from cases.motion.mechanics import gravity

from ..common.driven_tracks import PrescribedSteps
from ..common.facets import (
    chain,
    ends,
    in_facets,
    is_convex,
    is_round_hill,
    longest_in_facets,
    polygon,
    rim,
    round_plate,
    stretch,
    support_chain,
    track_kind,
)
from ..interface import Setting
from . import older_versions

# The space's knobs that differ between rungs; everything else is the engine's default.
KNOBS = ("collision_slop", "collision_bias", "iterations")


# The engine's collision types; the further supports have those from the third on.
_TRACK, _PLATE, _SUPPORT = 1, 2, 3

# A coefficient that no contact here needs: a millionth of a newton would hold a plate of a tonne on a wall.
ROUGH = 1e9


def friction_coefficient(case: Case) -> float:
    """The coefficient of both shapes together: mu, zero without friction, ROUGH for a perfectly rough contact."""
    friction = case.effect(CoulombFriction)
    return ROUGH if case.effect(PerfectlyRough) else friction.at_rest if friction else 0.0


# --- the shapes' fineness --------------------------------------------------------------------------------------------

# A polygon that a person would type in; and the finest one whose small overlaps the engine still detects (at 1000
# corners an elliptic plate of 0.3 m sank 7 cm into a circle). Every moving segment is sorted again in every step, so
# that a rim of 800 takes ten times the time of one of 400.
MODEST, MOST_CORNERS, MOST_SEGMENTS = 64, 800, 400


def shape_knobs(case: Case, h: float | None) -> dict[str, float | int]:
    """Number and thickness of the shapes for the step h (s); None: those of a first-time user.

    A facet is as long as the plate's displacement in one step at top speed: shorter ones only cost time.
    """
    kind, knobs = track_kind(case), dict[str, float | int]()
    if length := longest_in_facets(case):
        way = stretch(case).top_speed * h if h else 0.0
        knobs["facets"] = max(MODEST, round(length / way)) if way else MODEST
        # A facet with its neighbours set does not catch the plate with its end where they meet. The default has none.
        knobs["neighbors"] = 0 if h is None else 1
    if kind != "hill" or case.supports:
        # Thick walls stop plates that sink in; thin ones reduce the engine's search for overlapping boxes.
        thickness = case.plate.inner * (1.0 if h is None else 0.05)
        knobs["thickness"] = min(thickness, 0.5 * _tightest_hill(case))
    # The free plates are discs and polygons, which the engine has exactly.
    if not round_plate(case) and not as_line(case.plate.outline) and not case.others:
        # Corners lose energy as facets do; with 0.2 s over the step they lose as much as the step itself.
        most = MOST_CORNERS if is_convex(case.plate.outline) else MOST_SEGMENTS
        knobs["vertices"] = MODEST if h is None else int(np.clip(round(0.2 / h), MODEST, most))
    return knobs


def space_knobs(case: Case) -> dict[str, float | int]:
    """The space's knobs for every rung but the first: all overlap beyond a small slop is corrected at once."""
    knobs: dict[str, float | int] = dict(collision_slop=1e-5 * case.plate.inner, collision_bias=0.0)
    if not case.plate.radius or case.others:
        knobs["iterations"] = 20
    return knobs


def model_grid(case: Case, steps: Sequence[float]) -> list[dict[str, float | int]]:
    """The model's knobs for the steps (s), in every combination, from the coarsest to the finest.

    Corners, or facets with and without neighbours, as fine as for each of the steps; a disc on one segment or circle
    has only its slop.
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


def scene_kind(case: Case) -> str:
    """The kind of scene, which decides its cost: the track's for a disc, else "polygon" or "polygon on chain"."""
    kind = "chain" if longest_in_facets(case) else track_kind(case)
    if round_plate(case):
        return kind
    return "polygon on chain" if kind == "chain" else "polygon"


def _tightest_hill(case: Case) -> float:
    """The smallest radius of curvature (m) where the track bends away from the plate, infinite if it never does; zero
    if it has corners."""
    if isinstance(case.track, Chain):
        return 0.0
    part = stretch(case)
    bends = [case.track.curvature(np.linspace(part.low, part.high, 721))]
    bend = float(np.min([*bends, *(curve.curvature(np.linspace(*curve.span, 721)) for curve in in_facets(case))]))
    return -1 / bend if bend < 0.0 else float("inf")


# --- the space -------------------------------------------------------------------------------------------------------


# A segment takes 1.2 kilobytes, including its part of the engine's tree and of the arrays it is made from.
_MOST_FACETS = 1_000_000


def build(case: Case, setting: Setting) -> tuple[pymunk.Space, pymunk.Body]:
    """A space with the track as static shapes and the plate at the case's start, gravity and friction included."""
    space = pymunk.Space()
    gx, gy = gravity(case)
    space.gravity = float(gx), float(gy)
    for knob in KNOBS:
        if knob in setting:
            setattr(space, knob, setting[knob])
    body = pymunk.Body(case.plate.mass, case.plate.inertia)
    plate = _plate_shapes(case, body, setting)
    track = pymunk.Body(body_type=pymunk.Body.KINEMATIC) if case.effect(Drive) else space.static_body
    shapes = _track_shapes(case, space, track, setting)
    impact = case.effect(Impact)
    for shape in plate:
        shape.friction = 1.0 if case.supports else friction_coefficient(case)
        shape.elasticity = impact.restitution if impact else 0.0
    for shape in shapes:
        # The engine multiplies the two shapes' coefficients.
        shape.friction = friction_coefficient(case) if case.supports else 1.0
        shape.elasticity = 1.0
    belt = case.effect(Belt)
    if belt and belt_runs_as_shapes(case):
        _run_surface(shapes, belt.constant or 0.0)
    shapes += _supports(case, space, track, setting)
    # Sorted insertion degenerates the engine's tree into a list; any fixed shuffle keeps it shallow.
    random.Random(0).shuffle(shapes)
    space.add(body, *plate, *([track] if case.effect(Drive) else []), *shapes)
    return space, body


def _supports(case: Case, space: pymunk.Space, track: pymunk.Body, setting: Setting) -> list[pymunk.Shape]:
    """The shapes of the further supports on the body of the track, each with its friction and its restitution as a
    multiple of the case's."""
    every, whole = list[pymunk.Shape](), case.effect(Impact)
    for number, support in enumerate(case.supports, start=_SUPPORT):
        own = replace(case, effects=support.acting(case.effects), supports=())
        shapes = _support_shapes(case, space, track, support.curve, setting)
        impact, belt = own.effect(Impact), own.effect(Belt)
        for shape in shapes:
            shape.friction, shape.elasticity = friction_coefficient(own), 1.0
            if impact and whole and whole.restitution > 0.0:
                shape.elasticity = impact.restitution / whole.restitution
            shape.collision_type = number
        if belt and _runs_evenly(own.effects):
            _run_surface(shapes, belt.constant or 0.0)
        every += shapes
    return every


def _support_shapes(
    case: Case, space: pymunk.Space, track: pymunk.Body, curve: Curve, setting: Setting
) -> Sequence[pymunk.Shape]:
    """A support as one segment, a circle, or a chain of segments."""
    line, circle = as_line(curve), as_circle(curve)
    if line:
        return [line_segment(case, space, track, line, setting["thickness"], ends(case, line))]
    if circle and is_round_hill(curve):
        return [_track_circle(track, circle)]
    corners = support_chain(case, curve, int(setting["facets"]), behind=setting["thickness"])
    return _segments(track, corners, curve.period is not None, setting)


def drive_track(case: Case, space: pymunk.Space, h: float) -> None:
    """Let the track's body follow its driven motion in steps of h (s), the first of which is a half one."""
    drive = case.effect(Drive)
    if drive is None:
        return
    (body,) = (each for each in space.bodies if each.body_type == pymunk.Body.KINEMATIC)
    motion, step = PrescribedSteps(drive, h), count()

    def follow(body: pymunk.Body, gravity: tuple[float, float], damping: float, dt: float) -> None:
        # The engine moves its bodies first: here they are at the beginning of the next step.
        vx, vy, spin = motion.velocities(next(step))
        body.velocity, body.angular_velocity = (vx, vy), spin

    (x, y, angle), (vx, vy, spin) = motion.start
    body.position, body.angle = (x - 0.5 * h * vx, y - 0.5 * h * vy), angle - 0.5 * h * spin
    body.velocity, body.angular_velocity = (vx, vy), spin
    body.velocity_func = follow


def belt_runs_as_shapes(case: Case) -> bool:
    """Whether the belt is a surface velocity of the track's shapes: a constant one, along segments that do not turn."""
    drive = case.effect(Drive)
    is_turning = drive is not None and drive.is_turning
    return _runs_evenly(case.effects) and track_kind(case) != "hill" and not is_turning


def _runs_evenly(effects: Sequence[Effect]) -> bool:
    """Whether there is a belt of constant speed, and no friction by the slip speed, which needs the belt's speed."""
    belt = one(effects, Belt)
    return belt is not None and belt.constant is not None and _coefficient(effects) is None


@dataclass(frozen=True)
class StepSurface:
    """What of a curve is set in each step: a belt that is no surface velocity of shapes, and mu by the slip speed."""

    belt: Belt | None
    coefficient: Callable[[float], float] | None


def surfaces_in_steps(case: Case) -> dict[int, StepSurface]:
    """The curves whose belt or friction is set in each step, by the collision type of their shapes."""
    whole = None if belt_runs_as_shapes(case) else case.effect(Belt)
    surfaces = {_TRACK: StepSurface(whole, _coefficient(case.effects))}
    for number, support in enumerate(case.supports, start=_SUPPORT):
        effects = support.acting(case.effects)
        surfaces[number] = StepSurface(None if _runs_evenly(effects) else one(effects, Belt), _coefficient(effects))
    return {number: each for number, each in surfaces.items() if each.belt or each.coefficient}


def _coefficient(effects: Sequence[Effect]) -> Callable[[float], float] | None:
    friction = one(effects, CoulombFriction)
    return friction.at if friction and friction.by_speed else None


class SurfacesInSteps:
    """Belts as the surface velocity of each contact, along its own tangent, with the belt's speed in each step; and
    friction by the slip speed as the friction of each contact, by its slip in the middle of the step's change of
    velocity, as predicted from the step before."""

    def __init__(self, surfaces: dict[int, StepSurface], space: pymunk.Space, plate: pymunk.Body, h: float):
        self._h, self._step = h, 0
        self._velocities = {body: _velocities(body) for body in space.bodies}
        self._changes = {body: (Vec2d(0.0, 0.0), 0.0) for body in space.bodies}
        for shape in space.shapes:
            shape.collision_type = shape.collision_type or (_PLATE if shape.body is plate else _TRACK)
        for number, surface in surfaces.items():
            older_versions.on_collision(space, number, _PLATE, partial(self._pre_solve, surface))

    def counting(self, note: Callable[[], None]) -> Callable[[], None]:
        """The function that records a step, which also counts it and notes the changes of the velocities."""

        def count_and_note() -> None:
            self._step += 1
            # The first step is a half one, so that the next changes twice as much.
            share = 2.0 if self._step == 1 else 1.0
            for body, (before, spin) in self._velocities.items():
                self._velocities[body] = velocity, turn = _velocities(body)
                self._changes[body] = share * (velocity - before), share * (turn - spin)
            note()

        return count_and_note

    def _pre_solve(self, surface: StepSurface, arbiter: pymunk.Arbiter, space: pymunk.Space, data: object) -> None:
        # The velocities after a step are those of its middle; the normal points to the plate.
        contacts = arbiter.contact_point_set
        tangent = Vec2d(contacts.normal.y, -contacts.normal.x)
        belt = surface.belt.at((self._step + 0.5) * self._h)[0] if surface.belt else 0.0
        if surface.belt:
            arbiter.surface_velocity = -belt * tangent
        if surface.coefficient:
            points = [0.5 * (point.point_a + point.point_b) for point in contacts.points]
            track, plate = (shape.body for shape in arbiter.shapes)
            assert track and plate, "every shape here has a body"
            place = sum(points, Vec2d(0.0, 0.0)) / len(points)
            slip = (self._velocity_within(plate, place) - self._velocity_within(track, place)).dot(tangent)
            arbiter.friction = surface.coefficient(abs(slip - belt))

    def _velocity_within(self, body: pymunk.Body, place: Vec2d) -> Vec2d:
        """The velocity of the body's point there in the middle of this step's change, as predicted."""
        change, turn = self._changes.get(body, (Vec2d(0.0, 0.0), 0.0))
        arm, spin = place - body.position, body.angular_velocity + 0.5 * turn
        return body.velocity + 0.5 * change + spin * Vec2d(-arm.y, arm.x)


def _velocities(body: pymunk.Body) -> tuple[Vec2d, float]:
    return body.velocity, body.angular_velocity


def _run_surface(shapes: Sequence[pymunk.Shape], speed: float) -> None:
    """Let the segments' surfaces run from their first end to the second with that speed, m/s."""
    for shape in shapes:
        assert isinstance(shape, pymunk.Segment), "refuses() accepts belts on segments only"
        shape.surface_velocity = (shape.b - shape.a).normalized() * speed


def _plate_shapes(case: Case, body: pymunk.Body, setting: Setting) -> list[pymunk.Shape]:
    circle, outline = round_plate(case), case.plate.outline
    if circle:
        x, y = circle.centre
        return [pymunk.Circle(body, circle.radius, (float(x), float(y)))]
    if is_convex(outline):
        corners = polygon(outline, setting["vertices"])
        return [pymunk.Poly(body, [(float(x), float(y)) for x, y in corners.T])]
    thickness = _rim_thickness(outline, case.plate.width)
    points = [(float(x), float(y)) for x, y in rim(outline, setting.get("vertices", 1), inside=thickness).T]
    return [pymunk.Segment(body, one, next, thickness) for one, next in pairwise(points)]


def _rim_thickness(outline: Curve, width: float) -> float:
    """The thickness of an outline's segments, m: thin compared with the plate and its smallest outward radius."""
    sharpest = float(outline.curvature(np.linspace(*outline.span, 721)).max())
    return min(0.02 * width, 0.5 / sharpest) if sharpest > 0.0 else 0.02 * width


def _track_shapes(case: Case, space: pymunk.Space, body: pymunk.Body, setting: Setting) -> list[pymunk.Shape]:
    kind, line, circle = track_kind(case), as_line(case.track), as_circle(case.track)
    if kind == "hill" and circle:
        return [_track_circle(body, circle)]
    if line:
        part = stretch(case)
        own = np.array([case.track.point(s) for s in (part.low, part.high)])
        return [line_segment(case, space, body, line, setting["thickness"], ends(case, line) if case.supports else own)]
    return _chain(case, body, setting)


def _track_circle(body: pymunk.Body, circle: Circle) -> pymunk.Shape:
    x, y = circle.centre
    return pymunk.Circle(body, circle.radius, (float(x), float(y)))


def lift(case: Case, space: pymunk.Space) -> float:
    """How far (m) a surface is above its curve."""
    return 0.5 * min(space.collision_slop, 1e-6 * case.plate.inner)


def line_segment(
    case: Case, space: pymunk.Space, body: pymunk.Body, line: Line, thickness: float, ends: np.ndarray
) -> pymunk.Shape:
    """One segment between its ends, its surface above the line by half the slop that the engine allows.

    The engine detects a contact only where shapes overlap: without that overlap the plate would fall for one step.
    """
    normal = np.array([-line.direction[1], line.direction[0]])
    (ax, ay), (bx, by) = (end + normal * (lift(case, space) - thickness) for end in ends)
    return pymunk.Segment(body, (float(ax), float(ay)), (float(bx), float(by)), thickness)


def _chain(case: Case, body: pymunk.Body, setting: Setting) -> list[pymunk.Shape]:
    """Segments of equal length along the stretch, behind the track by their radius."""
    facets, thickness = setting["facets"], setting["thickness"]
    if facets > _MOST_FACETS:
        raise NotSupported(
            f"At this step the track needs {facets:,} facets, and a million take more than a gigabyte of memory; "
            "give a coarser setting."
        )
    return _segments(body, chain(case, facets, behind=thickness), stretch(case).closed, setting)


def _segments(body: pymunk.Body, corners: np.ndarray, is_closed: bool, setting: Setting) -> list[pymunk.Shape]:
    """Segments between corners (2, n)."""
    points, thickness = [(float(x), float(y)) for x, y in corners.T], setting["thickness"]
    if is_closed:
        points[-1] = points[0]
        before, after = points[-2], points[1]
    else:
        before, after = points[0], points[-1]
    with_neighbours = [before, *points, after]
    segments: list[pymunk.Shape] = []
    for i in range(len(points) - 1):
        segment = pymunk.Segment(body, points[i], points[i + 1], thickness)
        if setting["neighbors"]:
            segment.set_neighbors(with_neighbours[i], with_neighbours[i + 3])
        segments.append(segment)
    return segments
