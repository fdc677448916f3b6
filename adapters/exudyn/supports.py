"""A plate on several supports, or with corners: a contact object for each pair of a support and a corner or circle."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import exudyn as exu
import numpy as np

from cases import Case, Gravity, Load, PerfectlyRough, Trajectory
from cases.contact import start_motion
from cases.curves.corner import Corner
from cases.curves.line_or_circle import as_circle, as_line
from cases.scene.contact_pairs import PairCase, pairs

from ..common import feature_contacts
from ..interface import Refusal, Setting
from . import older_versions
from .bodies import add_load, add_plate, force_sensor, node_sensors
from .contacts import Sphere, add_contact, contact_law, corner_radius, refuses_belt, refuses_curve, sphere_of
from .system import SensorData


def refuses(case: Case) -> Refusal | None:
    """The reason, in one sentence, why the contacts of a case are not the engine's, or None."""
    if problem := feature_contacts.refuses(case, with_curves=True):
        return Refusal(problem)
    for pair in pairs(case):
        if problem := refuses_curve(pair.track) or refuses_belt(pair):
            return problem
        if as_circle(pair.track) and not pair.track.period:
            return Refusal(f"A circle is closed here, and the support {pair.support!r} has ends.")
        if pair.effect(PerfectlyRough):
            return Refusal(
                "Exudyn has no perfectly rough contact for a plate that may leave its track.",
                "its joints for rolling are constraints that never open",
            )
    for name in ("ObjectContactSphereSphere", "ObjectContactSphereTriangle"):
        if problem := older_versions.contact_object(name):
            return problem
    return None


class SupportContact(NamedTuple):
    """A contact of a plate with a support: the pair, the sphere of its feature, and the sensor of its force."""

    pair: PairCase
    sphere: Sphere
    force: int


@dataclass(frozen=True)
class SupportsSystem:
    """An assembled system in the container that owns it; the sensors of pose and velocity, and all contacts."""

    container: Any
    system: Any
    motion: tuple[int, int]
    contacts: tuple[SupportContact, ...]


def build(case: Case, setting: Setting) -> SupportsSystem:
    """The plate at the case's start, with gravity and load, and a contact object for every pair."""
    container = exu.SystemContainer()
    system = container.AddSystem()
    node, body = add_plate(system, case.plate, start_motion(case), case.effect(Gravity))
    if load := case.effect(Load):
        add_load(system, body, load)
    contacts = []
    for pair in pairs(case):
        sphere = sphere_of(pair.plate.outline, case, setting)
        law = contact_law(pair, setting, system, case.plate.mass)
        number = add_contact(pair, setting, system, body, sphere, pair.track, law, case)
        contacts.append(SupportContact(pair, sphere, force_sensor(system, number)))
    motion = node_sensors(system, node)
    system.Assemble()
    return SupportsSystem(container, system, motion, tuple(contacts))


def read(case: Case, setting: Setting, system: SupportsSystem, data: SensorData, clear: float) -> Trajectory:
    """The motion with all contacts, whose forces act at the spheres' rims; `clear`: the gap of an open contact, m."""
    force, moment = np.zeros((len(data.t), 2)), np.zeros(len(data.t))
    for contact in system.contacts:
        own = system.system.GetSensorStoredData(contact.force)[:, 1:3]
        lever = contact.sphere.centre(data.pose)
        lever = lever - contact.sphere.radius * _normal(contact, data.pose[:, :2] + lever)
        force += own
        moment += lever[:, 0] * own[:, 1] - lever[:, 1] * own[:, 0]
    creep = float(setting["vreg"])
    if any(isinstance(contact.pair.plate.outline, Corner) for contact in system.contacts):
        creep += corner_radius(case, setting) * float(np.abs(data.velocity[:, 2]).max())
    poses, rates, torsor = data.pose[:, None], data.velocity[:, None], np.column_stack([force, moment])
    motion = feature_contacts.with_plates(case, data.t, poses, rates, clear, torsor, slip_lever=0.5)
    return replace(motion, slip_resolution=creep)


def _normal(contact: SupportContact, centre: np.ndarray) -> np.ndarray:
    """The normal of a support, towards the plate, next to the centres of a sphere (n, 2), of that shape."""
    if line := as_line(contact.pair.track):
        return np.broadcast_to([-line.direction[1], line.direction[0]], centre.shape)
    circle = as_circle(contact.pair.track)
    assert circle is not None, "checked by `refuses`"
    away = centre - circle.centre
    return (-1.0 if circle.left else 1.0) * away / np.hypot(*away.T)[:, None]
