"""Exudyn's own smooth contacts between a disc and a circle or a straight line."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import cos, hypot, sin
from typing import Any

import exudyn as exu
import exudyn.itemInterface as item
import numpy as np

from cases import Case, Gravity, Impact, Load, Support, Unilateral
from cases.contact import start_motion
from cases.line_or_circle import Circle, Line, as_circle, as_line

from ..common import facets, support_contacts
from ..common.facets import round_plate
from ..common.flights import BEYOND, Follower
from ..interface import Setting
from . import constraints, older_versions
from .system import (
    ExudynContact,
    ExudynSystem,
    SensorData,
    critical_damping,
    disc_body,
    disc_circle,
    friction_coefficient,
    ground,
    node_sensors,
    static_start,
    steps_until,
)

# An impact slower than this (m/s) is damped as if it had this speed, so that lasting contact comes to rest.
SLOWEST_IMPACT = 1e-2


def refuses(case: Case) -> str | None:
    """The reason, in one sentence, why no object of the engine models the case's shapes, or None."""
    if round_plate(case) is None:
        return "Exudyn has smooth rolling contact for discs only, and this outline is no circle."
    if as_line(case.track) is None and as_circle(case.track) is None:
        return "Exudyn has smooth rolling contact on straight lines and circles only, and this track is neither."
    if case.supports:
        problem = _refuses_supports(case)
        if problem:
            return problem
    if constraints.suits(case):
        return constraints.refuses(case)
    if case.effect(Unilateral) is None:
        return "Exudyn's contacts with friction only push; it has none for a track that also pulls (no Unilateral)."
    return older_versions.contact_object("ObjectContactSphere" + ("Triangle" if as_line(case.track) else "Sphere"))


def _refuses_supports(case: Case) -> str | None:
    """The reason why the contacts of a case with supports are not the engine's, or None."""
    if any(support.effects is not None for support in case.supports) or case.plate.radius is None:
        return "Exudyn is given supports with the case's own effects, and discs about their centre of mass."
    return support_contacts.refuses(case)


def build(case: Case, setting: Setting) -> ExudynSystem:
    """A disc in the plane, its gravity, and the contact object that fits the track."""
    container = exu.SystemContainer()
    system = container.AddSystem()
    line, circle = as_line(case.track), as_circle(case.track)
    # On a line friction acts on the track; on a circle in the middle of the overlap.
    start = static_start(case, setting, depth=1.0 if line else 0.5)
    node, disc = disc_body(case, start, system)
    if line:
        number, contact = _on_line(case, setting, system, disc, line)
        slip = _slip_on_line(case, system, line)
    else:
        assert circle is not None, "refuses() accepts only lines and circles"
        number, contact = _on_circle(case, setting, system, disc, circle)
        slip = _slip_on_circle(case, system, circle)
    force = system.AddSensor(
        item.SensorObject(objectNumber=number, outputVariableType=exu.OutputVariableType.Force, storeInternal=True)
    )
    motion = node_sensors(system, node)
    others = tuple(_add_support(case, setting, system, disc, support) for support in case.supports)
    state = system.systemData.GetDataCoordinates
    if not others:  # a step that ends where one of several contacts sticks is no better for the others
        steps_until(case, setting, system, slip, speed=lambda: state()[1])
    system.Assemble()
    return ExudynSystem(container, system, motion, force, contact, others)


def _add_support(case: Case, setting: Setting, system, disc: int, support: Support) -> int:
    """Add the contact with a further straight support; returns the sensor of its force."""
    line, own = as_line(support.curve), replace(case, effects=support.acting(case.effects), supports=())
    assert line is not None, "refuses() accepts straight supports only"
    number = _add_triangle(own, setting, system, disc, triangle_between(*facets.ends(case, line)), at_start=False)
    kind = exu.OutputVariableType.Force
    return int(system.AddSensor(item.SensorObject(objectNumber=number, outputVariableType=kind, storeInternal=True)))


def triangle_between(one: np.ndarray, other: np.ndarray) -> list[list[float]]:
    """A triangle across the plane of motion with a side along the line between two points."""
    reach, (x, y) = 0.5 * float(np.hypot(*(other - one))), 0.5 * (one + other)
    return [[*one.tolist(), -reach], [*other.tolist(), -reach], [float(x), float(y), 2.0 * reach]]


def _add_triangle(case: Case, setting: Setting, system, disc: int, points: list[list[float]], at_start: bool) -> int:
    """Add the contact of the disc with a triangle; `at_start`: whether they touch at the start."""
    return int(
        system.AddObject(
            item.ObjectContactSphereTriangle(
                markerNumbers=[disc, ground(system, np.zeros(2))],
                **older_versions.sphere_radius(disc_circle(case).radius),
                trianglePoints=exu.Vector3DList(points),  # type: ignore[call-arg]
                includeEdges=0,
                **_contact_law(case, setting, system, at_start),
            )
        )
    )


def _slip_on_line(case: Case, system, line: Line) -> Callable[[Any], float]:
    """A function for the slip velocity (m/s) where a step begins or ends; in floats, since each iteration calls it."""
    (tx, ty), (px, py) = line.direction.tolist(), line.point.tolist()
    centre_of = _centre_of(case, system)

    def slip(configuration) -> float:
        x, y, vx, vy, omega = centre_of(configuration)
        return vx * tx + vy * ty + omega * ((y - py) * tx - (x - px) * ty)

    return slip


def _slip_on_circle(case: Case, system, circle: Circle) -> Callable[[Any], float]:
    """The same on a circle; friction acts in the middle of the overlap, between the two radii."""
    (cx, cy), side = circle.centre.tolist(), -1.0 if circle.left else 1.0
    radius, centre_of = disc_circle(case).radius, _centre_of(case, system)

    def slip(configuration) -> float:
        x, y, vx, vy, omega = centre_of(configuration)
        away = hypot(x - cx, y - cy)
        nx, ny = side * (x - cx) / away, side * (y - cy) / away
        return vx * ny - vy * nx + omega * 0.5 * (radius + side * (away - circle.radius))

    return slip


def _centre_of(case: Case, system) -> Callable[[Any], tuple[float, float, float, float, float]]:
    """A function for position and velocity of the circle's centre, and the spin, in a configuration of the step."""
    poses, velocities = system.systemData.GetODE2Coordinates, system.systemData.GetODE2Coordinates_t
    dx, dy = disc_circle(case).centre.tolist()

    def at_centre(configuration) -> tuple[float, float, float, float, float]:
        (x, y, _), (vx, vy, omega) = poses(configuration).tolist(), velocities(configuration).tolist()
        return x, y, vx, vy, omega

    def off_centre(configuration) -> tuple[float, float, float, float, float]:
        (x, y, theta), (vx, vy, omega) = poses(configuration).tolist(), velocities(configuration).tolist()
        ax, ay = dx * cos(theta) - dy * sin(theta), dx * sin(theta) + dy * cos(theta)
        return x + ax, y + ay, vx - omega * ay, vy + omega * ax, omega

    return at_centre if case.plate.radius is not None else off_centre


def _on_circle(case: Case, setting: Setting, system, disc: int, circle: Circle):
    radius = disc_circle(case).radius
    number = system.AddObject(
        item.ObjectContactSphereSphere(
            markerNumbers=[disc, ground(system, circle.centre)],
            spheresRadii=[radius, circle.radius],
            isHollowSphere1=circle.left,
            **_contact_law(case, setting, system),
        )
    )

    def contact(data: SensorData) -> ExudynContact:
        centre, velocity = _of_disc(case, data)
        away = centre - circle.centre
        distance = np.hypot(away[:, 0], away[:, 1])
        side = -1.0 if circle.left else 1.0
        gap = side * (distance - circle.radius) - radius
        # The engine's friction acts in the middle of the overlap; with the nominal radius the slip would be biased.
        normal, arm = side * away / distance[:, None], radius + 0.5 * gap
        return _read(case, data, velocity, normal, gap, arm)

    return number, contact


def _on_line(case: Case, setting: Setting, system, disc: int, line: Line):
    radius = disc_circle(case).radius
    normal = np.array([-line.direction[1], line.direction[0]])
    number = _add_triangle(case, setting, system, disc, _ground_triangle(case, line), at_start=True)

    def contact(data: SensorData) -> ExudynContact:
        centre, velocity = _of_disc(case, data)
        gap = (centre - line.point) @ normal - radius
        # The engine's friction acts on the triangle's plane.
        return _read(case, data, velocity, np.broadcast_to(normal, (len(gap), 2)), gap, radius + gap)

    return number, contact


def _contact_law(case: Case, setting: Setting, system, at_start: bool = True) -> dict:
    """The law of the plate's contact; with `at_start` its data node begins with the start's gap and slip."""
    # Without an initial gap the plate would fall for a step before the contact acts; without an initial slip, friction
    # would begin on the steep branch of its law, with a thousand times its bound.
    touching, at_rest = start_motion(case), static_start(case, setting, depth=0.0)
    gap = -hypot(at_rest.x - touching.x, at_rest.y - touching.y) if at_start else 0.0
    slip = hypot(at_rest.vx - touching.vx, at_rest.vy - touching.vy) or abs(touching.slip) if gap else 0.0
    return contact_law(case, setting, system, critical_damping(case.plate.mass, setting), gap, slip)


def contact_law(case: Case, setting: Setting, system, damping: float, gap: float = 0.0, slip: float = 0.0) -> dict:
    """Parameters that both contact objects share. Their data node holds gap (m) and slip (m/s) of the last iteration;
    `damping` (N s/m) is for impacts without restitution."""
    data = item.NodeGenericData(initialCoordinates=[gap, slip, 0.0, 0.0], numberOfDataCoordinates=4)
    impact = case.effect(Impact)
    law: dict = dict(contactDamping=damping)
    if impact and impact.restitution > 0.0:
        # Gonthier's and Carvalho's damping, which the engine mixes so that any restitution is met to a thousandth.
        law = dict(impactModel=2, restitutionCoefficient=impact.restitution, minimumImpactVelocity=SLOWEST_IMPACT)
    return dict(
        nodeNumber=system.AddNode(data),
        dynamicFriction=friction_coefficient(case),
        frictionProportionalZone=setting["vreg"],
        contactStiffness=setting["k"],
        **law,
    )


def _of_disc(case: Case, data: SensorData) -> tuple[np.ndarray, np.ndarray]:
    """Position (m) and velocity (m/s) of the circle's centre along a run, each of shape (n, 2)."""
    (dx, dy), theta, omega = disc_circle(case).centre, data.pose[:, 2], data.velocity[:, 2]
    ax, ay = dx * np.cos(theta) - dy * np.sin(theta), dx * np.sin(theta) + dy * np.cos(theta)
    spin_velocity = np.column_stack([-omega * ay, omega * ax])
    return data.pose[:, :2] + np.column_stack([ax, ay]), data.velocity[:, :2] + spin_velocity


def _read(case: Case, data: SensorData, velocity, normal, gap, arm) -> ExudynContact:
    """Slip and forces along the track's tangent and normal, from the velocity of the disc's centre.

    `arm`: the distance from the centre to the point where friction acts, m.
    """
    pose, force = data.pose, data.force
    tangent = np.column_stack([normal[:, 1], -normal[:, 0]])
    slip = np.sum(velocity * tangent, axis=1) + data.velocity[:, 2] * arm
    normal_force, friction_force = (np.sum(force[:, :2] * along, axis=1) for along in (normal, tangent))
    follower, parameters, failure = Follower(case), [], None
    try:
        for row in pose.tolist():
            parameters.append(follower(*row)[:2])
    except BEYOND as problem:
        failure = str(problem)
    xi1, xi2 = np.array(parameters, dtype=float).reshape(-1, 2).T
    n = len(parameters)
    return ExudynContact(xi1, xi2, gap[:n], slip[:n], normal_force[:n], friction_force[:n], failure)


def _ground_triangle(case: Case, line: Line) -> list[list[float]]:
    """A triangle across the plane of motion, around the start and wider than the plate can move within the duration."""
    start, gravity = start_motion(case), case.effect(Gravity)
    fall = 0.5 * gravity.g * case.duration**2 if gravity else 0.0
    # The range under a load is unknown; at a hundred times the distance positions still have twelve digits.
    reach_alone = 2.0 * (case.plate.reach + hypot(start.vx, start.vy) * case.duration + fall)
    reach = 100.0 * reach_alone if case.effect(Load) else reach_alone
    (x, y), (along_x, along_y) = case.track.point(start.xi1), reach * line.direction
    return [[x - along_x, y - along_y, -reach], [x + along_x, y + along_y, -reach], [x, y, 2.0 * reach]]
