"""Exudyn's own smooth contacts between a round plate and a circle or a straight line."""

from __future__ import annotations

from math import hypot

import exudyn as exu
import numpy as np

from cases import Case, CoulombFriction, Gravity, Load, Unilateral
from cases.contact import start_motion
from cases.curves.line_or_circle import Circle, Line, as_circle, as_line
from cases.scene.contact_limits import touches_by_features

from ..common.facets import round_plate
from ..interface import Refusal, Setting
from . import constraints, older_versions, rolls, supports
from .bodies import add_load, add_plate, force_sensor, node_sensors
from .contacts import Sphere, add_contact, contact_law, read_contact, refuses_belt, refuses_curve, sphere_of
from .system import ExudynContact, ExudynSystem, SensorData, disc_circle, static_start


def refuses(case: Case) -> Refusal | None:
    """The reason, in one sentence, why no object of the engine models the case's shapes, or None."""
    friction = case.effect(CoulombFriction)
    if friction and friction.by_speed:
        return rolls.refuses(case)
    if touches_by_features(case):
        return supports.refuses(case)
    if round_plate(case) is None:
        return Refusal(
            "Exudyn has smooth rolling contact for discs only, and this adapter has no spheres for another outline."
        )
    if problem := refuses_curve(case.track) or refuses_belt(case):
        return problem
    if constraints.suits(case):
        return constraints.refuses(case)
    if case.effect(Unilateral) is None:
        return Refusal(
            "A guide with friction (no Unilateral) would be two of Exudyn's contacts, and this adapter has one."
        )
    return older_versions.contact_object("ObjectContactSphere" + ("Triangle" if as_line(case.track) else "Sphere"))


def build(case: Case, setting: Setting) -> ExudynSystem:
    """A round plate in the plane, its gravity and load, and the contact object that fits the track."""
    container = exu.SystemContainer()
    system = container.AddSystem()
    line, circle = as_line(case.track), as_circle(case.track)
    # On a line friction acts on the track; on a circle in the middle of the overlap.
    start = static_start(case, setting, depth=1.0 if line else 0.5)
    node, body = add_plate(system, case.plate, start, case.effect(Gravity))
    if load := case.effect(Load):
        add_load(system, body, load)
    sphere = sphere_of(case.plate.outline, case, setting)
    law = _law_at_start(case, setting, system)
    force = force_sensor(system, add_contact(case, setting, system, body, sphere, case.track, law, case))
    motion = node_sensors(system, node)
    system.Assemble()
    if line:
        return ExudynSystem(container, system, motion, force, lambda data: _on_line(case, data, line))
    assert circle is not None, "refuses() accepts only lines and circles"
    return ExudynSystem(container, system, motion, force, lambda data: _on_circle(case, data, circle))


def _on_circle(case: Case, data: SensorData, circle: Circle) -> ExudynContact:
    centre, velocity = _of_disc(case, data)
    away = centre - circle.centre
    distance = np.hypot(away[:, 0], away[:, 1])
    side, radius = -1.0 if circle.left else 1.0, disc_circle(case).radius
    gap = side * (distance - circle.radius) - radius
    # The engine's friction acts in the middle of the overlap; with the nominal radius the slip would be biased.
    normal, arm = side * away / distance[:, None], radius + 0.5 * gap
    return read_contact(case, data, velocity, normal, gap, arm)


def _on_line(case: Case, data: SensorData, line: Line) -> ExudynContact:
    centre, velocity = _of_disc(case, data)
    radius, normal = disc_circle(case).radius, np.array([-line.direction[1], line.direction[0]])
    gap = (centre - line.point) @ normal - radius
    # The engine's friction acts on the triangle's plane.
    return read_contact(case, data, velocity, np.broadcast_to(normal, (len(gap), 2)), gap, radius + gap)


def _law_at_start(case: Case, setting: Setting, system) -> dict:
    """The law of the plate's contact; its data node begins with the start's gap and slip.

    Without an initial gap the plate would fall for a step before the contact acts; without an initial slip, friction
    would begin on the steep branch of its law, with a thousand times its bound.
    """
    touching, at_rest = start_motion(case), static_start(case, setting, depth=0.0)
    gap = -hypot(at_rest.x - touching.x, at_rest.y - touching.y)
    slip = hypot(at_rest.vx - touching.vx, at_rest.vy - touching.vy) or abs(touching.slip) if gap else 0.0
    return contact_law(case, setting, system, case.plate.mass, gap, slip)


def _of_disc(case: Case, data: SensorData) -> tuple[np.ndarray, np.ndarray]:
    """Position (m) and velocity (m/s) of the circle's centre along a run, each of shape (n, 2)."""
    (u, v), omega = disc_circle(case).centre.tolist(), data.velocity[:, 2]
    ax, ay = Sphere(u, v, 0.0).centre(data.pose).T
    spin_velocity = np.column_stack([-omega * ay, omega * ax])
    return data.pose[:, :2] + np.column_stack([ax, ay]), data.velocity[:, :2] + spin_velocity
