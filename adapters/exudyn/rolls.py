"""Exudyn's ObjectContactConvexRoll: a round plate on a straight line, with Stribeck's friction.

The object is a body of revolution on the plane z = 0, which turns about its own x axis. The line's direction is y and
its normal z, so that the plate's angle is the first rotation of NodeRigidBodyRxyz. The generatrix is a parabola, whose
vertex has the plate's radius; the roll touches there, as long as it does not tilt, and nothing tilts it.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import exudyn as exu
import exudyn.itemInterface as item
import numpy as np
import sympy as sp

from cases import Belt, Case, CoulombFriction, Flight, Gravity, Load, Unilateral
from cases.curves.line_or_circle import Line, as_line
from cases.derivation import in_one_thread
from cases.scene.contact_limits import touches_by_features
from cases.slip_laws import SLIP_SPEED

from ..common.one_contact import with_forces
from ..interface import Refusal, Setting
from . import older_versions
from .bodies import force_sensor, ground, hold_angle, node_sensors
from .system import ExudynSystem, SensorData, critical_damping, static_start


class StribeckLaw(NamedTuple):
    """mu(v) = dynamic + offset exp(−v/decay) + viscous v, with v and decay in m/s and viscous in s/m."""

    dynamic: float
    offset: float
    decay: float
    viscous: float


def stribeck_law(friction: CoulombFriction) -> StribeckLaw | None:
    """A coefficient as Stribeck's law with positive numbers, or None if it is another function."""
    return _stribeck_law(friction.mu) if friction.by_speed else None


@lru_cache(maxsize=64)
@in_one_thread
def _stribeck_law(mu: sp.Expr) -> StribeckLaw | None:
    numbers = {"dynamic": 0.0, "offset": 0.0, "decay": 1.0, "viscous": 0.0}
    for term in sp.Add.make_args(sp.expand(mu)):
        factor, rest = term.as_independent(SLIP_SPEED, as_Add=False)
        rate = -rest.exp / SLIP_SPEED if isinstance(rest, sp.exp) else sp.Integer(0)
        if rest == 1:
            numbers["dynamic"] += float(factor)
        elif rest == SLIP_SPEED:
            numbers["viscous"] += float(factor)
        elif rate.is_number and rate.is_positive and not numbers["offset"]:
            numbers |= {"offset": float(factor), "decay": 1.0 / float(rate)}
        else:
            return None
    return StribeckLaw(**numbers) if min(numbers.values()) >= 0.0 else None


def refuses(case: Case) -> Refusal | None:
    """The reason, in one sentence, why the engine's roll does not model a case with friction by a formula, or None."""
    friction = case.effect(CoulombFriction)
    if friction is None or stribeck_law(friction) is None:
        return Refusal(
            "Exudyn's friction depends on the slip velocity by Stribeck's law only, and this coefficient is another.",
            "ObjectContactConvexRoll has StribeckFunction; its other contacts have one coefficient",
        )
    if case.plate.radius is None or as_line(case.track) is None or touches_by_features(case):
        return Refusal(
            "Exudyn has Stribeck's friction for a roll on a plane only.",
            "ObjectContactConvexRoll is its only contact with that law, on a flat surface",
        )
    if case.effect(Belt) or case.effect(Flight) or case.effect(Load) or case.effect(Unilateral) is None:
        return Refusal("Stribeck's friction is supported here for a plate on a track at rest, without Load and Flight.")
    return older_versions.contact_object("ObjectContactConvexRoll")


def build(case: Case, setting: Setting) -> ExudynSystem:
    """The plate as a roll on the plane z = 0, and the law of its contact."""
    container = exu.SystemContainer()
    system = container.AddSystem()
    line, friction, plate, gravity = as_line(case.track), case.effect(CoulombFriction), case.plate, case.effect(Gravity)
    assert line is not None and friction is not None and plate.radius is not None, "checked by `refuses`"
    law, start = stribeck_law(friction), static_start(case, setting)
    assert law is not None, "checked by `refuses`"
    along, across = _axes(line)
    place, speed = np.array([start.x, start.y]) - line.point, np.array([start.vx, start.vy])
    node = system.AddNode(
        item.NodeRigidBodyRxyz(
            initialCoordinates=[0.0, place @ along, place @ across, start.theta, 0.0, 0.0],
            initialVelocities=[0.0, speed @ along, speed @ across, start.omega, 0.0, 0.0],
        )
    )
    inertia = plate.inertia if plate.turns else plate.mass * plate.radius**2
    body = system.AddObject(
        item.ObjectRigidBody(nodeNumber=node, **older_versions.rigid_body(plate.mass, [inertia] * 3 + [0.0] * 3))
    )
    if not plate.turns:
        hold_angle(system, node, 3, start.theta)
    if gravity:
        pull = np.array(gravity.vector)
        mass = system.AddMarker(item.MarkerBodyMass(bodyNumber=body))
        system.AddLoad(item.LoadMassProportional(markerNumber=mass, loadVector=[0.0, pull @ along, pull @ across]))
    gap = float(place @ across) - plate.radius
    data = item.NodeGenericData(initialCoordinates=[start.slip, 0.0, gap], numberOfDataCoordinates=3)
    number = system.AddObject(
        item.ObjectContactConvexRoll(
            markerNumbers=[ground(system, np.zeros(2)), system.AddMarker(item.MarkerBodyRigid(bodyNumber=body))],
            nodeNumber=system.AddNode(data),
            contactStiffness=setting["k"],
            contactDamping=critical_damping(plate.mass, setting),
            dynamicFriction=law.dynamic,
            staticFrictionOffset=law.offset,
            exponentialDecayStatic=law.decay,
            viscousFriction=law.viscous,
            frictionProportionalZone=setting["vreg"],
            rollLength=plate.radius,
            coefficientsHull=[-1.0 / plate.radius, 0.0, plate.radius],
        )
    )
    force, motion = force_sensor(system, number), node_sensors(system, node)
    system.Assemble()
    # The engine's friction acts at the lowest point of the roll.
    return ExudynSystem(
        container, system, (motion,), (force,),
        lambda data: with_forces(case, data.t, data.pose, data.velocity, data.force, lever=0.0),
        lambda data: _in_plane(data, line),
    )  # fmt: skip


def _axes(line: Line) -> tuple[np.ndarray, np.ndarray]:
    """The directions of the plane of motion that are y and z here."""
    return line.direction, np.array([-line.direction[1], line.direction[0]])


def _in_plane(data: SensorData, line: Line) -> SensorData:
    """Sensor data of the roll, (n, 6) and (n, 3), in the plane of motion; the force is that on the plate."""
    axes = np.array(_axes(line))
    pose, velocity = (np.column_stack([table[:, 1:3] @ axes, table[:, 3]]) for table in (data.pose, data.velocity))
    pose[:, :2] += line.point
    return SensorData(data.t, pose, velocity, -data.force[:, 1:3] @ axes)
