"""Scenes with several free plates: circles and polygons on segments and on each other, all of them exact."""

from __future__ import annotations

from dataclasses import replace
from math import sqrt

import pymunk

from cases import Case, Impact, Plate
from cases.contact.polygon_features import circles
from cases.curves.line_or_circle import as_line
from cases.motion.mechanics import gravity
from cases.scene.free_plates import plates_of, start_poses

from ..common import facets
from ..interface import Setting
from . import native, older_versions

# The engine's collision types: of all plates and the track, and of the first further support.
_CASE, _SUPPORT = 1, 2


def build(case: Case, setting: Setting, h: float) -> tuple[pymunk.Space, list[pymunk.Body]]:
    """A space with the track and supports as segments and all plates at the case's start, moved back by half a step of
    `h` (s); its bodies in the order of the plates."""
    space = pymunk.Space()
    gx, gy = gravity(case)
    space.gravity = float(gx), float(gy)
    for knob in native.KNOBS:
        if knob in setting:
            setattr(space, knob, setting[knob])
    mu, restitution = _coefficients(case)
    shapes = [_segment(case, space, case, setting)]
    for number, support in enumerate(case.supports, start=_SUPPORT):
        own = replace(case, track=support.curve, effects=support.acting(case.effects), supports=(), others=())
        shapes.append(_segment(case, space, own, setting))
        if support.effects is not None:
            shapes[-1].collision_type = number
            older_versions.on_collision(space, number, _CASE, _Coefficients(*_coefficients(own)))
    bodies = []
    for plate, (x, y, theta, vx, vy, omega) in zip(plates_of(case), start_poses(case).tolist(), strict=True):
        body = pymunk.Body(plate.mass, plate.inertia)
        body.position, body.angle = (x - 0.5 * h * vx, y - 0.5 * h * vy), theta - 0.5 * h * omega
        body.velocity, body.angular_velocity = (vx, vy), omega
        bodies.append(body)
        shapes.append(_shape(plate, body, wider(case, space)))
    for shape in shapes:
        # The engine multiplies the two shapes' coefficients.
        shape.friction, shape.elasticity = sqrt(mu), sqrt(restitution)
        shape.collision_type = shape.collision_type or _CASE
    space.add(*bodies, *shapes)
    return space, bodies


def wider(case: Case, space: pymunk.Space) -> float:
    """By how much (m) discs are larger than the case's. Plates that touch are detected only if they overlap, as a plate
    and its segment."""
    return 0.25 * native.lift(case, space)


def _shape(plate: Plate, body: pymunk.Body, more: float) -> pymunk.Shape:
    """The plate's own shape; a disc's radius is larger by `more` (m)."""
    if plate.radius is not None:
        return pymunk.Circle(body, plate.reach + more)
    return pymunk.Poly(body, [(corner.x, corner.y) for corner in circles(plate)])


def _coefficients(case: Case) -> tuple[float, float]:
    """Friction and restitution of a contact with the case's effects."""
    impact = case.effect(Impact)
    return native.friction_coefficient(case), impact.restitution if impact else 0.0


class _Coefficients:
    """Sets friction and restitution of the contacts with a support of its own effects."""

    def __init__(self, mu: float, restitution: float):
        self._mu, self._restitution = mu, restitution

    def __call__(self, arbiter: pymunk.Arbiter, space: pymunk.Space, data: object) -> None:
        arbiter.friction, arbiter.restitution = self._mu, self._restitution


def _segment(whole: Case, space: pymunk.Space, own: Case, setting: Setting) -> pymunk.Shape:
    line = as_line(own.track)
    assert line is not None, "the case has straight tracks and supports only"
    ends = facets.ends(whole, line)
    return native.line_segment(whole, space, space.static_body, line, setting["thickness"], ends)
