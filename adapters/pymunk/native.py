"""Scenes with pymunk's own shapes: any number of plates on segments, circles and chains of segments.

A plate is a circle, or a polygon if its outline is closed and nowhere bends inwards. Any other plate has one segment
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
from dataclasses import dataclass
from functools import partial
from itertools import count, pairwise, product
from math import inf, isfinite, sqrt

import numpy as np
import pymunk
from pymunk import Vec2d

from cases import Belt, Case, Chain, CoulombFriction, Curve, Drive, Impact, NotSupported, PerfectlyRough, Plate
from cases.contact.polygon_features import circles, is_polygon
from cases.curves.line_or_circle import Line, as_circle, as_line
from cases.effects import Effect, one
from cases.motion.mechanics import gravity
from cases.scene.contact_names import TRACK
from cases.scene.couples import Couple, couples
from cases.scene.free_plates import names_of, plates_of

from ..common.driven_tracks import PrescribedSteps
from ..common.facets import (
    MODEST,
    ends,
    facets_for,
    fixed_chain,
    in_facets,
    is_convex,
    is_round_hill,
    longest_in_facets,
    polygon,
    rim,
    round_plate,
    stretch,
    track_kind,
    whole_circle,
)
from ..common.starts import starts_of
from ..interface import Setting
from . import older_versions

# The space's knobs that differ between rungs; everything else is the engine's default.
KNOBS = ("collision_slop", "collision_bias", "iterations")


# The engine's collision type of the first plate; the others, the track and the supports have those after it.
_FIRST = 1

# A coefficient that no contact here needs: a millionth of a newton would hold a plate of a tonne on a wall.
ROUGH = 1e9


def friction_coefficient(effects: Sequence[Effect]) -> float:
    """The coefficient of both shapes together: mu, zero without friction, ROUGH for a perfectly rough contact."""
    friction = one(effects, CoulombFriction)
    return ROUGH if one(effects, PerfectlyRough) else friction.at_rest if friction else 0.0


# --- the shapes' fineness --------------------------------------------------------------------------------------------

# The finest polygon whose small overlaps the engine still detects (at 1000 corners an elliptic plate of 0.3 m sank 7 cm
# into a circle). Every moving segment is sorted again in every step, so that a rim of 800 takes ten times the time of
# one of 400.
MOST_CORNERS, MOST_SEGMENTS = 800, 400


def shape_knobs(case: Case, h: float | None) -> dict[str, float | int]:
    """Number and thickness of the shapes for the step h (s); None: those of a first-time user."""
    kind, knobs = track_kind(case), dict[str, float | int]()
    if longest_in_facets(case):
        knobs["facets"] = facets_for(case, h)
        # A facet with its neighbours set does not catch the plate with its end where they meet. The default has none.
        knobs["neighbors"] = 0 if h is None else 1
    if kind != "hill" or case.supports:
        # Thick walls stop plates that sink in; thin ones reduce the engine's search for overlapping boxes.
        thickness = case.plate.inner * (1.0 if h is None else 0.05)
        knobs["thickness"] = min(thickness, 0.5 * _tightest_hill(case))
    if any(needs_corners(plate) for plate in plates_of(case)) or (not case.others and is_polygon(case.plate)):
        # Corners lose energy as facets do; with 0.2 s over the step they lose as much as the step itself.
        most = MOST_CORNERS if all(is_convex(plate.outline) for plate in plates_of(case)) else MOST_SEGMENTS
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


def build(case: Case, setting: Setting, h: float) -> tuple[pymunk.Space, list[pymunk.Body]]:
    """A space with the track and supports as static shapes and all plates at the case's start, moved back by half a
    step of `h` (s), gravity and friction included; the plates' bodies in their order."""
    space = pymunk.Space()
    gx, gy = gravity(case)
    space.gravity = float(gx), float(gy)
    for knob in KNOBS:
        if knob in setting:
            setattr(space, knob, setting[knob])
    # The engine multiplies the two shapes' coefficients. Those of several plates act between them, too.
    of_plates = [sqrt(whole) if case.others else 1.0 for whole in _coefficients(case.effects)]
    bodies, shapes = list[pymunk.Body](), list[pymunk.Shape]()
    for collision_type, plate in enumerate(plates_of(case), start=_FIRST):
        body = pymunk.Body(plate.mass, plate.inertia)
        bodies.append(body)
        for shape in _plate_shapes(plate, body, setting, wider(case, space) if case.others else 0.0):
            shape.friction, shape.elasticity = of_plates
            shape.collision_type = collision_type
            shapes.append(shape)
    track = pymunk.Body(body_type=pymunk.Body.KINEMATIC) if case.effect(Drive) else space.static_body
    fixed = list[pymunk.Shape]()
    for number, (curve, effects) in enumerate(_surfaces(case), start=_FIRST + len(bodies)):
        some, coefficients = _fixed_shapes(case, space, track, curve, setting), _coefficients(effects)
        for shape in some:
            shape.friction, shape.elasticity = (
                whole / of_plate if of_plate else 0.0 for whole, of_plate in zip(coefficients, of_plates, strict=True)
            )
            shape.collision_type = number
        belt = one(effects, Belt)
        if belt and (belt_runs_as_shapes(case) if curve is case.track else _runs_evenly(effects)):
            _run_surface(some, belt.constant or 0.0)
        fixed += some
    if case.others or case.pairs:
        for couple in couples(case):
            if (own := _coefficients(couple.effects)) != _coefficients(case.effects):
                older_versions.on_collision(space, *types_of(couple), _Coefficients(*own))
    # Sorted insertion degenerates the engine's tree into a list; any fixed shuffle keeps it shallow.
    random.Random(0).shuffle(fixed)
    # The engine solves contacts in the order in which shapes are added, and searches them from where they are then.
    moving = [*bodies, *([track] if case.effect(Drive) else [])]
    if case.others:
        to_start(case, bodies, h)
    space.add(*moving, *((*fixed, *shapes) if case.others else (*shapes, *fixed)))
    to_start(case, bodies, h)
    return space, bodies


def to_start(case: Case, bodies: Sequence[pymunk.Body], h: float) -> None:
    """Put the plates' bodies at the case's start, moved back by half a step of `h` (s)."""
    for body, (x, y, theta, vx, vy, omega) in zip(bodies, starts_of(case).tolist(), strict=True):
        body.position, body.angle = (x - 0.5 * h * vx, y - 0.5 * h * vy), theta - 0.5 * h * omega
        body.velocity, body.angular_velocity = (vx, vy), omega


def _surfaces(case: Case) -> list[tuple[Curve, Sequence[Effect]]]:
    """The track and the further supports with the effects there; their order gives the collision types."""
    return [(case.track, case.effects), *((s.curve, s.acting(case.effects)) for s in case.supports)]


def _coefficients(effects: Sequence[Effect]) -> tuple[float, float]:
    """Friction and restitution of a contact where these effects act."""
    impact = one(effects, Impact)
    return friction_coefficient(effects), impact.restitution if impact else 0.0


def types_of(couple: Couple) -> tuple[int, int]:
    """The engine's collision types of a couple's boundary and of its plate."""
    whole, boundary = couple.whole, couple.pair_name.split("/")[1]
    names = (*names_of(whole), TRACK, *(support.name for support in whole.supports))
    return _FIRST + names.index(boundary), _FIRST + couple.body


class _Coefficients:
    """Sets friction and restitution of the contacts of two bodies that have effects of their own."""

    def __init__(self, mu: float, restitution: float):
        self._mu, self._restitution = mu, restitution

    def __call__(self, arbiter: pymunk.Arbiter, space: pymunk.Space, data: object) -> None:
        arbiter.friction, arbiter.restitution = self._mu, self._restitution


def _fixed_shapes(
    case: Case, space: pymunk.Space, body: pymunk.Body, curve: Curve, setting: Setting
) -> Sequence[pymunk.Shape]:
    """The track or a support as one segment, a circle, or a chain of segments."""
    line, circle = as_line(curve), as_circle(curve)
    if line:
        part = None if case.supports or case.others else stretch(case)
        low, high = (part.low, part.high) if part else curve.domain or (-inf, inf)
        reach = np.array([curve.point(s) for s in (low, high)]) if isfinite(low) else ends(case, line)
        return [_line_segment(case, space, body, line, setting["thickness"], reach)]
    if circle and is_round_hill(curve):
        x, y = circle.centre
        return [pymunk.Circle(body, circle.radius, (float(x), float(y)))]
    facets, thickness = setting["facets"], setting["thickness"]
    if facets > _MOST_FACETS:
        raise NotSupported(
            f"At this step the track needs {facets:,} facets, and a million take more than a gigabyte of memory; "
            "give a coarser setting."
        )
    return _segments(body, *fixed_chain(case, curve, facets, thickness), setting)


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
    """Whether the belt is a surface velocity of the track's shapes: a constant one, along segments that do not turn,
    without the corners of a chain, where a contact has not the direction of its segment."""
    drive = case.effect(Drive)
    is_turning = drive is not None and drive.is_turning
    is_smooth = track_kind(case) != "hill" and not isinstance(case.track, Chain)
    return _runs_evenly(case.effects) and is_smooth and not is_turning


def _runs_evenly(effects: Sequence[Effect]) -> bool:
    """Whether there is a belt of constant speed, and no friction by the slip speed, which needs the belt's speed."""
    belt = one(effects, Belt)
    return belt is not None and belt.constant is not None and _coefficient(effects) is None


@dataclass(frozen=True)
class StepSurface:
    """What of the contacts of two bodies is set in each step: a belt that is no surface velocity of shapes, mu by the
    slip speed, and the restitution."""

    belt: Belt | None
    coefficient: Callable[[float], float] | None
    restitution: float


def surfaces_in_steps(case: Case) -> dict[tuple[int, int], StepSurface]:
    """The contacts whose belt or friction is set in each step, by the collision types of the bodies."""
    surfaces = {}
    for couple in couples(case):
        effects = couple.effects
        is_track = couple.pair_name.endswith(f"/{TRACK}")
        is_shapes = belt_runs_as_shapes(case) if is_track else _runs_evenly(effects)
        belt = None if is_shapes else one(effects, Belt)
        surfaces[types_of(couple)] = StepSurface(belt, _coefficient(effects), _coefficients(effects)[1])
    return {types: each for types, each in surfaces.items() if each.belt or each.coefficient}


def _coefficient(effects: Sequence[Effect]) -> Callable[[float], float] | None:
    friction = one(effects, CoulombFriction)
    return friction.at if friction and friction.by_speed else None


class SurfacesInSteps:
    """Belts as the surface velocity of each contact, along its own tangent, with the belt's speed in each step; and
    friction by the slip speed as the friction of each contact, by its slip in the middle of the step's change of
    velocity, as predicted from the step before."""

    def __init__(self, surfaces: dict[tuple[int, int], StepSurface], space: pymunk.Space, h: float):
        self._h, self._step = h, 0
        self._velocities = {body: _velocities(body) for body in space.bodies}
        self._changes = {body: (Vec2d(0.0, 0.0), 0.0) for body in space.bodies}
        for types, surface in surfaces.items():
            older_versions.on_collision(space, *types, partial(self._pre_solve, surface))

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
        arbiter.restitution = surface.restitution
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


def needs_corners(plate: Plate) -> bool:
    """Whether the engine has a plate by corners that are not its own: it is no disc, no segment and no polygon."""
    return not whole_circle(plate.outline) and not as_line(plate.outline) and not is_polygon(plate)


def _plate_shapes(plate: Plate, body: pymunk.Body, setting: Setting, more: float) -> list[pymunk.Shape]:
    """A plate's shapes; the radius of a disc is larger by `more` (m)."""
    outline = plate.outline
    circle = whole_circle(outline)
    if circle:
        x, y = circle.centre
        return [pymunk.Circle(body, circle.radius + more, (float(x), float(y)))]
    if "vertices" not in setting and is_polygon(plate):
        return [pymunk.Poly(body, [(corner.x, corner.y) for corner in circles(plate)])]
    if is_convex(outline):
        corners = polygon(outline, setting["vertices"])
        return [pymunk.Poly(body, [(float(x), float(y)) for x, y in corners.T])]
    thickness = _rim_thickness(outline, plate.width)
    points = [(float(x), float(y)) for x, y in rim(outline, setting.get("vertices", 1), inside=thickness).T]
    return [pymunk.Segment(body, one, next, thickness) for one, next in pairwise(points)]


def _rim_thickness(outline: Curve, width: float) -> float:
    """The thickness of an outline's segments, m: thin compared with the plate and its smallest outward radius."""
    sharpest = float(outline.curvature(np.linspace(*outline.span, 721)).max())
    return min(0.02 * width, 0.5 / sharpest) if sharpest > 0.0 else 0.02 * width


def wider(case: Case, space: pymunk.Space) -> float:
    """By how much (m) discs of several plates are larger than the case's. Plates that touch are detected only if they
    overlap, as a plate and its segment."""
    return 0.25 * _lift(case, space)


def _lift(case: Case, space: pymunk.Space) -> float:
    """How far (m) a surface is above its curve."""
    return 0.5 * min(space.collision_slop, 1e-6 * case.plate.inner)


def _line_segment(
    case: Case, space: pymunk.Space, body: pymunk.Body, line: Line, thickness: float, ends: np.ndarray
) -> pymunk.Shape:
    """One segment between its ends, its surface above the line by half the slop that the engine allows.

    The engine detects a contact only where shapes overlap: without that overlap the plate would fall for one step.
    """
    normal = np.array([-line.direction[1], line.direction[0]])
    (ax, ay), (bx, by) = (end + normal * (_lift(case, space) - thickness) for end in ends)
    return pymunk.Segment(body, (float(ax), float(ay)), (float(bx), float(by)), thickness)


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
