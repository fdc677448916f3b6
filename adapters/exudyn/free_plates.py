"""Scenes with several free plates: Exudyn's discs on triangles and on each other (ObjectContactSphereSphere).

Both contacts are of spheres whose centres stay in the plane; the bodies have the plates' own inertia about Z. A plate
that does not turn is a body whose angle is held by ObjectConnectorCoordinate. Every contact has a law of its own.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import pi, sqrt
from typing import Any

import exudyn as exu
import exudyn.itemInterface as item
import numpy as np

from cases import Case, Cost, CoulombFriction, Gravity, PerfectlyRough, Plate, Trajectory
from cases.free_plates import PlateContact, gap_of, plate_contacts, plates_of, start_poses
from cases.mechanics import gravity

from ..common import facets
from ..common.plate_contacts import with_plates
from ..interface import EngineFailure, Setting
from . import older_versions
from .native import contact_law, triangle_between
from .system import critical_damping, ground, node_sensors

# The longest step within an impact, in periods of the contact's spring over 2 pi: restitution is met to a thousandth.
IMPACT = 0.05
# An impact takes some periods of the spring.
IMPACT_PERIODS = 2.0
# A closed contact whose gap changes faster than gravity changes it in so many of these periods is in an impact.
SETTLED = 10.0


def refuses(case: Case) -> str | None:
    """The reason, in one sentence, why the engine has no contact for a case with several plates, or None."""
    for contact in plate_contacts(case):
        friction = contact.effect(CoulombFriction)
        if contact.effect(PerfectlyRough):
            return "Exudyn has no perfectly rough contact for a plate that may fly; its rolling joint never opens."
        if friction and (friction.by_speed or friction.stick != friction.mu):
            return "Exudyn's contacts have one friction coefficient, for slip and stick and all slip velocities."
    for name in ("ObjectContactSphereSphere", "ObjectContactSphereTriangle"):
        if problem := older_versions.contact_object(name):
            return problem
    return None


@dataclass(frozen=True)
class PlatesSystem:
    """An assembled system in the container that owns it; the sensors of pose and velocity of every plate, and of the
    force of every contact."""

    container: Any
    system: Any
    motions: tuple[tuple[int, int], ...]
    forces: tuple[int, ...]


def build(case: Case, setting: Setting) -> PlatesSystem:
    """All plates at the case's start, and a contact object for every pair that may touch."""
    container = exu.SystemContainer()
    system = container.AddSystem()
    starts = start_poses(case)
    bodies = [_body(case, system, *each) for each in zip(plates_of(case), starts.tolist(), strict=True)]
    discs = [disc for _, disc in bodies]
    numbers = [_contact(case, setting, system, discs, contact, starts) for contact in plate_contacts(case)]
    kind = exu.OutputVariableType.Force
    forces = [
        system.AddSensor(item.SensorObject(objectNumber=number, outputVariableType=kind, storeInternal=True))
        for number in numbers
    ]
    motions = tuple(node_sensors(system, node) for node, _ in bodies)
    _resolve_impacts(case, setting, system)
    system.Assemble()
    return PlatesSystem(container, system, motions, tuple(forces))


def _body(case: Case, system, plate: Plate, start: list[float]) -> tuple[int, int]:
    """Add a plate at its start (x, y, θ, vx, vy, ω); returns its node and a marker at its centre."""
    node = system.AddNode(item.NodeRigidBody2D(initialCoordinates=start[:3], initialVelocities=start[3:]))
    inertia = plate.inertia if plate.turns else plate.mass * plate.reach**2
    body = system.AddObject(item.ObjectRigidBody2D(nodeNumber=node, **older_versions.rigid_body(plate.mass, inertia)))
    if not plate.turns:
        origin = system.AddNode(item.NodePointGround())
        still = system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=origin, coordinate=0))
        angle = system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=node, coordinate=2))
        system.AddObject(item.ObjectConnectorCoordinate(markerNumbers=[still, angle]))
    pull = case.effect(Gravity)
    if pull:
        mass = system.AddMarker(item.MarkerBodyMass(bodyNumber=body))
        system.AddLoad(item.LoadMassProportional(markerNumber=mass, loadVector=[*pull.vector, 0.0]))
    return node, system.AddMarker(item.MarkerBodyRigid(bodyNumber=body))


def _contact(case: Case, setting: Setting, system, discs: list[int], contact: PlateContact, starts: np.ndarray) -> int:
    """Add the contact object of two plates, or of a plate and a straight line, which begins with the gap of the start;
    returns its number."""
    own = plates_of(case)[contact.body]
    acting = replace(case, effects=contact.effects)
    gap = gap_of(contact, starts)
    law = contact_law(acting, setting, system, critical_damping(_moved_mass(case, contact), setting), gap)
    if contact.base is None:
        assert contact.line is not None, "checked by the case"
        contact_object: Any = item.ObjectContactSphereTriangle(
            markerNumbers=[discs[contact.body], ground(system, np.zeros(2))],
            **older_versions.sphere_radius(own.reach),
            trianglePoints=exu.Vector3DList(  # type: ignore[call-arg]
                triangle_between(*facets.ends(case, contact.line))
            ),
            includeEdges=0,
            **law,
        )
    else:
        contact_object = item.ObjectContactSphereSphere(
            markerNumbers=[discs[contact.body], discs[contact.base]],
            spheresRadii=[own.reach, plates_of(case)[contact.base].reach],
            **law,
        )
    return int(system.AddObject(contact_object))


def _resolve_impacts(case: Case, setting: Setting, system) -> None:
    """Repeat a step that is too long for an impact within it with a shorter one.

    The engine ends a step where a contact closes, but passes through the contact with its ordinary step: with h over
    the period of the contact's spring, restitution was 2.2 instead of 0.8. A closed contact is in an impact while it
    moves faster than gravity alone moves the plates on it.
    """
    poses, time_of = system.systemData.GetODE2Coordinates, system.systemData.GetTime
    begin, current, accept = exu.ConfigurationType.StartOfStep, exu.ConfigurationType.Current, [0.0, -1.0]
    pull = float(np.hypot(*gravity(case)))
    contacts = [(one, 1.0 / sqrt(setting["k"] / _moved_mass(case, one))) for one in plate_contacts(case)]

    def ask(_system, time: float) -> list[float]:
        """[error, step to repeat with], or [0, -1] to accept the step."""
        after = poses(current).reshape(-1, 3).tolist()
        closed = [(one, period, gap) for one, period in contacts if (gap := gap_of(one, after)) < 0.0]
        if not closed:
            return accept
        before, step = poses(begin).reshape(-1, 3).tolist(), time - time_of(begin)
        shortest = step
        for one, period, gap in closed:
            if abs(gap - gap_of(one, before)) > SETTLED * pull * period * step and step > IMPACT * period:
                shortest = min(shortest, 0.9 * IMPACT * period)
        # Any error above the solver's tolerance of 1 makes it repeat the step.
        return [10.0, shortest] if shortest < step else accept

    system.SetPostNewtonUserFunction(ask)


def _moved_mass(case: Case, contact: PlateContact) -> float:
    """The mass (kg) that moves on a contact's spring."""
    plates = plates_of(case)
    own = plates[contact.body].mass
    return own if contact.base is None else own * plates[contact.base].mass / (own + plates[contact.base].mass)


def read(case: Case, setting: Setting, system: PlatesSystem, cost: Cost, failure: str | None) -> Trajectory:
    """The motion of all plates. Raises EngineFailure if it is no motion."""
    tables = [[system.system.GetSensorStoredData(sensor) for sensor in motion] for motion in system.motions]
    if not all(np.isfinite(table).all() for motion in tables for table in motion):
        raise EngineFailure("Exudyn's run diverged: its coordinates are not finite numbers.")
    t = tables[0][0][:, 0]
    if failure:
        raise EngineFailure(f"Exudyn stopped at {t[-1]:.4g} s: {failure}.")
    poses, rates = (np.stack([motion[kind][:, 1:4] for motion in tables], axis=1) for kind in (0, 1))
    heaviest = max(plate.mass for plate in plates_of(case))
    motion = with_plates(
        case, t, poses, rates, _clear(case, setting), _torsor(case, system, poses), slip_lever=0.5,
        impact=IMPACT_PERIODS * 2.0 * pi * sqrt(heaviest / setting["k"]),
    )  # fmt: skip
    return replace(motion, cost=cost, slip_resolution=float(setting["vreg"]))


def _torsor(case: Case, system: PlatesSystem, poses: np.ndarray) -> np.ndarray:
    """Force (N) and moment (N m) of all contacts on each plate, like `poses`. The sensors have the force on the plate
    that a contact names first."""
    result, plates = np.zeros_like(poses), plates_of(case)
    for contact, sensor in zip(plate_contacts(case), system.forces, strict=True):
        force = system.system.GetSensorStoredData(sensor)[:, 1:3]
        if contact.base is None:
            assert contact.line is not None, "checked by the case"
            tangent = np.broadcast_to(contact.line.direction, force.shape)
        else:
            away = poses[:, contact.body, :2] - poses[:, contact.base, :2]
            tangent = np.column_stack([away[:, 1], -away[:, 0]]) / np.hypot(*away.T)[:, None]
            result[:, contact.base, :2] -= force
        friction = np.sum(force * tangent, axis=1)
        result[:, contact.body, :2] += force
        for body in (contact.body, contact.base):  # the opposite force acts on the opposite lever
            if body is not None and plates[body].turns:
                result[:, body, 2] += plates[body].reach * friction
    return result


def _clear(case: Case, setting: Setting) -> float:
    """The gap (m) below which a contact is closed: ten times the deflection under the weight of all plates, or the fall
    in a step."""
    mass = sum(plate.mass for plate in plates_of(case))
    return 10.0 * float(np.hypot(*gravity(case))) * (mass / setting["k"] + 0.5 * setting["h"] ** 2)
