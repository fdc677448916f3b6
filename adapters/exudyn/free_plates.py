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

from cases import Case, Cost, CoulombFriction, Gravity, PerfectlyRough, Trajectory
from cases.motion.mechanics import gravity
from cases.scene.free_plates import PlateContact, gap_of, plate_contacts, plates_of, start_poses

from ..common import facets
from ..common.feature_contacts import with_plates
from ..interface import EngineFailure, Refusal, Setting
from . import older_versions
from .bodies import add_plate, force_sensor, ground, node_sensors
from .contacts import contact_law, triangle_between

# An impact takes some periods of the spring.
IMPACT_PERIODS = 2.0


def refuses(case: Case) -> Refusal | None:
    """The reason, in one sentence, why the engine has no contact for a case with several plates, or None."""
    for contact in plate_contacts(case):
        friction = contact.effect(CoulombFriction)
        if contact.effect(PerfectlyRough):
            return Refusal(
                "Exudyn has no perfectly rough contact for a plate that may fly; its rolling joint never opens.",
                "ObjectJointRollingDisc is a constraint",
            )
        if friction and (friction.by_speed or friction.stick != friction.mu):
            return Refusal(
                "Exudyn's contacts have one friction coefficient, for slip and stick and all slip velocities.",
                "dynamicFriction of ObjectContactSphereSphere and ObjectContactSphereTriangle",
            )
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
    pull = case.effect(Gravity)
    bodies = [add_plate(system, *each, pull) for each in zip(plates_of(case), starts.tolist(), strict=True)]
    discs = [system.AddMarker(item.MarkerBodyRigid(bodyNumber=body)) for _, body in bodies]
    numbers = [_contact(case, setting, system, discs, contact, starts) for contact in plate_contacts(case)]
    forces = [force_sensor(system, number) for number in numbers]
    motions = tuple(node_sensors(system, node) for node, _ in bodies)
    system.Assemble()
    return PlatesSystem(container, system, motions, tuple(forces))


def _contact(case: Case, setting: Setting, system, discs: list[int], contact: PlateContact, starts: np.ndarray) -> int:
    """Add the contact object of two plates, or of a plate and a straight line, which begins with the gap of the start;
    returns its number."""
    own = plates_of(case)[contact.body]
    acting = replace(case, effects=contact.effects)
    gap = gap_of(contact, starts)
    law = contact_law(acting, setting, system, _moved_mass(case, contact), gap)
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
