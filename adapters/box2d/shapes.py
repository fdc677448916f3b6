"""Scenes with Box2D's own shapes: a circle or a fan of polygons on a circle or on a chain of segments."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from math import atan2, cos, sin

import numpy as np
import pyb2d3

from cases import Belt, Case, Chain, CoulombFriction, Curve, Drive, Impact, PerfectlyRough, Plate, RollingResistance
from cases.curves.corner import Edge
from cases.curves.line_or_circle import Circle, as_circle, as_line

from ..common import facets
from ..common.driven_tracks import PrescribedSteps

# A coefficient of friction that no case's forces exceed.
ROUGH = 1e6
# Corners that a polygon may have; and rim edges of a polygon in a fan: its eighth corner is the plate's centre.
MOST_CORNERS, RIM = 8, 6
# With more corners than this the engine merges some, on plates of the usual bends.
FINEST_RIM = 390


def corners(case: Case, h: float | None) -> dict[str, int]:
    """Numbers of facets and corners for the step h (s), or by default (None)."""
    counts: dict[str, int] = {}
    if facets.longest_in_facets(case):
        counts["facets"] = facets.facets_for(case, h)
    outline = case.plate.outline
    # The free plates are discs and polygons, whose corners are their own.
    if not facets.round_plate(case) and not as_line(outline) and not case.others:
        # With 0.2 s over the step corners lose as much energy as the step itself; whole polygons of a fan.
        coarsest = MOST_CORNERS if facets.is_convex(outline) else facets.MODEST
        counts["vertices"] = RIM * round(max(0.2 / h, facets.MODEST) / RIM) if h else coarsest
        counts["vertices"] = min(counts["vertices"], FINEST_RIM)
    return counts


def is_one_polygon(outline: Curve) -> bool:
    """Whether the outline is a convex polygon that the engine has as one shape."""
    return (
        isinstance(outline, Chain)
        and all(isinstance(piece, Edge) for piece in outline.pieces)
        and facets.is_convex(outline)
        and len(outline.pieces) <= MOST_CORNERS
    )


def material(case: Case) -> pyb2d3.SurfaceMaterial:
    """The surface material of both shapes."""
    friction, rolling, impact = case.effect(CoulombFriction), case.effect(RollingResistance), case.effect(Impact)
    # The engine takes the geometric mean of the two shapes' friction, and the larger of the other parameters.
    mu = ROUGH if case.effect(PerfectlyRough) else friction.mu if friction else 0.0
    round_plate = facets.round_plate(case)
    return pyb2d3.surface_material(
        friction=mu,
        restitution=impact.restitution if impact else 0.0,
        # The engine's couple is this times the circle's radius times the normal force.
        rolling_resistance=rolling.arm / round_plate.radius if rolling and round_plate else 0.0,
    )


def belt_material(case: Case, scale: float) -> pyb2d3.SurfaceMaterial:
    """The surface material of the track or a support: that of both shapes, running with the speed of its belt."""
    surface, belt = material(case), case.effect(Belt)
    if belt and belt.constant is not None:
        surface.tangent_speed = scale * belt.constant
    return surface


def moves_itself(case: Case) -> bool:
    """Whether the track's shape does not change when the track moves along itself."""
    return as_line(case.track) is not None or as_circle(case.track) is not None


def plate_material(case: Case) -> pyb2d3.SurfaceMaterial:
    """The surface material of the plates. With supports its friction is 1, and that of each support is mu², so that
    their geometric mean is mu; of several plates it is the case's, and that of each support mu_support²/mu."""
    surface = material(case)
    if case.supports and not case.others:
        surface.friction = 1.0
    return surface


def refuses_plates(case: Case) -> str | None:
    """Why the engine's mean of two shapes' friction does not give that of all contacts of several plates, or None."""
    frictions = [material(own).friction for own in _own_cases(case)]
    if material(case).friction == 0.0 and any(frictions):
        return "box2d takes the geometric mean of two shapes' friction: it is zero at a support if plates have none."
    return None


def _own_cases(case: Case) -> list[Case]:
    """For each further support the case with its effects."""
    return [replace(case, effects=support.acting(case.effects), supports=()) for support in case.supports]


def restitutions(case: Case) -> list[tuple[float, float]]:
    """The restitution of each further support, and that of the case."""
    return [(material(own).restitution, material(case).restitution) for own in _own_cases(case)]


def add_fixed(case: Case, body: pyb2d3.Body, scale: float, count: int) -> None:
    """Add the track and each further support: a circle, a segment of a chain, or a chain whose corners the engine
    smooths; the longest one has `count` segments."""
    has_more = bool(case.supports or case.others)
    curves = [(case.track, case), *zip((s.curve for s in case.supports), _own_cases(case), strict=True)]
    for curve, own in curves:
        line, circle, surface = as_line(curve), as_circle(curve), belt_material(own, scale)
        if has_more:
            surface = _against_plate(case, surface)
        if line and has_more:
            _add_line(body, facets.ends(case, line), surface, scale)
        elif circle and facets.is_round_hill(curve):
            _add_circle(body, circle, surface, scale)
        else:
            _add_chain(body, *facets.fixed_chain(case, curve, count), surface, scale)


def _against_plate(case: Case, surface: pyb2d3.SurfaceMaterial) -> pyb2d3.SurfaceMaterial:
    """The material of a line such that the geometric mean of its friction and the plates' is the given one."""
    if surface.friction > 0.0:
        surface.friction = surface.friction**2 / plate_material(case).friction
    return surface


def _add_line(body: pyb2d3.Body, ends: np.ndarray, surface: pyb2d3.SurfaceMaterial, scale: float) -> None:
    """Add a segment that pushes to its left: the inner one of a chain in reverse order."""
    along = ends[1] - ends[0]
    corners = np.array([ends[0] - along, *ends, ends[1] + along])
    body.create_chain(pyb2d3.chain_def(points=scale * corners[::-1], material=surface, is_loop=False))


def rotation(angle: float) -> pyb2d3.Rot:
    """The rotation by an angle; the engine's make_rot is fast but has an error of up to 1.6e-3 rad."""
    rot = pyb2d3.Rot()
    rot.c, rot.s = cos(angle), sin(angle)
    return rot


def angle(body: pyb2d3.Body) -> float:
    """A body's angle; the engine's own function is fast but has an error of up to 2.7e-5 rad."""
    rot = body.rotation
    return atan2(rot.s, rot.c)


def track_body(case: Case, world: pyb2d3.World, scale: float) -> pyb2d3.Body:
    """The track's body: static, or for a driven track kinematic, at its place at t = 0."""
    drive, belt = case.effect(Drive), case.effect(Belt)
    if drive is None and belt and belt.constant is None:
        return world.create_kinematic_body()
    if drive is None:
        return world.create_static_body()
    at = drive.at(0.0)
    return world.create_kinematic_body(position=(scale * at.x, scale * at.y), rotation=rotation(at.angle))


def track_follower(case: Case, body: pyb2d3.Body, h: float, scale: float) -> Callable[[int], None]:
    """A function that puts a driven track where it is at the beginning of a step of h (s), with the velocities that
    move it to its place at the next one; for a track at rest it does nothing."""
    drive, belt = case.effect(Drive), case.effect(Belt)
    if belt and belt.constant is None:
        return _belt_follower(case, belt, body, h, scale)
    if drive is None:
        return lambda step: None
    motion = PrescribedSteps(drive, h)

    def follow(step: int) -> None:
        x, y, turn = motion.place(step)
        vx, vy, spin = motion.velocities(step)
        # The first step is shorter than h, and the engine's numbers are rounded: the place would drift.
        body.set_transform((scale * x, scale * y), rotation(turn))
        body.linear_velocity, body.angular_velocity = (scale * vx, scale * vy), spin

    return follow


def _belt_follower(case: Case, belt: Belt, body: pyb2d3.Body, h: float, scale: float) -> Callable[[int], None]:
    """A function that lets the track move along itself during each step, as its belt does in the middle of the step,
    and puts it back before the next one: the engine's shapes keep the tangent speed that they are made with."""
    line, circle = as_line(case.track), as_circle(case.track)

    def follow(step: int) -> None:
        speed = float(belt.at((step + 0.5) * h)[0])
        body.set_transform((0.0, 0.0), rotation(0.0))
        if line:
            body.linear_velocity = _pair(scale * speed * line.direction)
            return
        assert circle is not None, "refuses() accepts lines and circles only"
        spin = speed / circle.radius * (1.0 if circle.left else -1.0)
        x, y = circle.centre
        body.linear_velocity, body.angular_velocity = _pair(scale * spin * np.array([y, -x])), spin

    return follow


def _add_circle(body: pyb2d3.Body, circle: Circle, material: pyb2d3.SurfaceMaterial, scale: float) -> None:
    shape = pyb2d3.circle(_pair(scale * circle.centre), scale * circle.radius)
    body.create_shape(pyb2d3.shape_def(material=material), shape)


def _add_chain(
    body: pyb2d3.Body, corners: np.ndarray, closed: bool, material: pyb2d3.SurfaceMaterial, scale: float
) -> None:
    """Add segments between corners (2, n), which the engine smooths."""
    if closed:
        corners = corners[:, :-1]
    else:
        # The first and last edges of an open chain only smooth their neighbours' corners.
        corners = np.column_stack([2 * corners[:, 0] - corners[:, 1], corners, 2 * corners[:, -1] - corners[:, -2]])
    # The engine's chains push to their right; here the plate is on the left.
    body.create_chain(pyb2d3.chain_def(points=scale * corners.T[::-1], material=material, is_loop=closed))


def add_plate(
    case: Case, plate: Plate, body: pyb2d3.Body, material: pyb2d3.SurfaceMaterial, scale: float, count: int
) -> None:
    """Add a circle, a polygon, or a fan of polygons with `count` corners on its rim; triangles if the outline is not
    convex."""
    define = pyb2d3.shape_def(material=material)
    circle = facets.whole_circle(plate.outline)
    if circle:
        body.create_shape(define, pyb2d3.circle(_pair(scale * circle.centre), scale * circle.radius))
        return
    if not facets.is_convex(plate.outline):
        for edge in pairwise(scale * facets.rim(plate.outline, count).T):
            body.create_shape(define, pyb2d3.polygon(points=np.vstack([np.zeros(2), *edge])))
        return
    rim = scale * facets.polygon(plate.outline, count).T
    if len(rim) <= MOST_CORNERS:
        body.create_shape(define, pyb2d3.polygon(points=rim))
        return
    for first in range(0, len(rim), RIM):
        part = rim[np.arange(first, min(first + RIM, len(rim)) + 1) % len(rim)]
        body.create_shape(define, pyb2d3.polygon(points=np.vstack([np.zeros(2), part])))


def _pair(values) -> tuple[float, float]:
    return float(values[0]), float(values[1])
