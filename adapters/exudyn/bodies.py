"""Bodies of the Exudyn adapter: plates with their loads, and the ground or the running surface on which they lie.

A plate that does not turn is a rigid body whose angle is held by ObjectConnectorCoordinate. A surface that runs along a
line or a circle is that of a heavy rigid body which moves along the line, or turns about the circle's centre.
"""

from __future__ import annotations

from collections.abc import Sequence

import exudyn as exu
import exudyn.itemInterface as item
import numpy as np

from cases import Belt, Curve, Gravity, Load, Plate
from cases.curves.line_or_circle import as_circle, as_line

from . import older_versions
from .system import HasEffects

# The mass of a running surface in masses of the plate: within 10 s a plate changes its speed by 1e-7 m/s.
HEAVY = 1e9


def add_plate(system, plate: Plate, start: Sequence[float], gravity: Gravity | None) -> tuple[int, int]:
    """Add a plate at its start (x, y, θ, vx, vy, ω), with gravity; returns its node and its body."""
    node = system.AddNode(item.NodeRigidBody2D(initialCoordinates=[*start[:3]], initialVelocities=[*start[3:6]]))
    # The moment of inertia of a plate whose angle is held has no effect; any number will do.
    inertia = plate.inertia if plate.turns else plate.mass * plate.reach**2
    body = system.AddObject(item.ObjectRigidBody2D(nodeNumber=node, **older_versions.rigid_body(plate.mass, inertia)))
    if not plate.turns:
        hold_angle(system, node, 2, start[2])
    if gravity:
        mass = system.AddMarker(item.MarkerBodyMass(bodyNumber=body))
        system.AddLoad(item.LoadMassProportional(markerNumber=mass, loadVector=[*gravity.vector, 0.0]))
    return node, body


def hold_angle(system, node: int, coordinate: int, angle: float) -> None:
    """Keep a coordinate of a node at an angle, rad."""
    origin = system.AddNode(item.NodePointGround())
    still = system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=origin, coordinate=0))
    turning = system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))
    system.AddObject(item.ObjectConnectorCoordinate(markerNumbers=[still, turning], offset=angle))


def add_load(system, body: int, load: Load) -> None:
    """Let a case's load act on a plate, the first body of the system."""

    def now(system, time: float) -> list[float]:
        state = system.systemData
        return load.at(time, *state.GetODE2Coordinates()[:3], *state.GetODE2Coordinates_t()[:3])

    def force(system, time, _vector) -> list[float]:
        return [*now(system, time)[:2], 0.0]

    def moment(system, time, _vector) -> list[float]:
        return [0.0, 0.0, now(system, time)[2]]

    centre = marker(system, body)
    system.AddLoad(item.LoadForceVector(markerNumber=centre, loadVectorUserFunction=force))  # type: ignore[arg-type]
    system.AddLoad(item.LoadTorqueVector(markerNumber=centre, loadVectorUserFunction=moment))  # type: ignore[arg-type]


def marker(system, body: int, u: float = 0.0, v: float = 0.0) -> int:
    """Add a marker of a body at a point of its frame."""
    return int(system.AddMarker(item.MarkerBodyRigid(bodyNumber=body, localPosition=[u, v, 0.0])))


def ground(system, point: Sequence[float] | np.ndarray) -> int:
    """Add a marker of the ground at a point of the plane."""
    return marker(system, system.AddObject(item.ObjectGround(referencePosition=[*point, 0.0])))


def surface(system, curve: Curve, acting: HasEffects, mass: float) -> int:
    """Add a marker of the body that carries a line or a circle, at the origin or at the circle's centre: the ground, or
    a body much heavier than a plate of that mass (kg), which moves as the belt that acts there."""
    line, circle, belt = as_line(curve), as_circle(curve), acting.effect(Belt)
    place = circle.centre if circle else np.zeros(2)
    if belt is None:
        return ground(system, place)
    speed = belt.constant
    assert speed is not None, "checked by `refuses`"
    mass *= HEAVY
    if line:
        velocities, inertia = [*(speed * line.direction).tolist(), 0.0], mass
    else:
        assert circle is not None, "checked by `refuses`"
        # A curve with the plate on its left runs clockwise around a hill.
        velocities = [0.0, 0.0, (speed if circle.left else -speed) / circle.radius]
        inertia = mass * circle.radius**2
    node = system.AddNode(item.NodeRigidBody2D(initialCoordinates=[*place.tolist(), 0.0], initialVelocities=velocities))
    body = system.AddObject(item.ObjectRigidBody2D(nodeNumber=node, **older_versions.rigid_body(mass, inertia)))
    return marker(system, body)


def node_sensors(system, node: int) -> tuple[int, int]:
    """Sensors that store a node's coordinates and velocities in memory."""
    pose, velocity = (
        system.AddSensor(item.SensorNode(nodeNumber=node, outputVariableType=kind, storeInternal=True))
        for kind in (exu.OutputVariableType.Coordinates, exu.OutputVariableType.Coordinates_t)
    )
    return pose, velocity


def force_sensor(system, number: int) -> int:
    """A sensor that stores the force of a contact object in memory."""
    kind = exu.OutputVariableType.Force
    return int(system.AddSensor(item.SensorObject(objectNumber=number, outputVariableType=kind, storeInternal=True)))
