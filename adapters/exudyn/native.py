"""Exudyn's own contacts of spheres: any number of plates, each with a contact object for every pair that may touch.

A round plate on one line or circle starts in equilibrium with its contact, which is read with the engine's own lever.
All other contacts, of several plates, of supports and of corners, follow from poses and forces
(`common.contacts_from_poses`). Every contact has a law of its own.
"""

from __future__ import annotations

from dataclasses import replace
from math import hypot, pi, sqrt

import exudyn as exu
import numpy as np

from cases import Belt, Case, CoulombFriction, Curve, Gravity, Load, PerfectlyRough, Trajectory, Unilateral
from cases.contact import start_motion
from cases.curves.corner import Corner, Edge
from cases.curves.line_or_circle import as_circle, as_line
from cases.scene.contact_limits import touches_by_features
from cases.scene.contact_pairs import PairCase, pairs
from cases.scene.free_plates import gap_of, plate_contacts, plates_of
from cases.scene.supports import is_straight

from ..common import contacts_from_poses
from ..common.facets import round_plate
from ..common.one_contact import with_forces
from ..common.starts import starts_of
from ..interface import Refusal, Setting
from . import constraints, older_versions, rolls
from .bodies import add_load, add_plate, force_sensor, node_sensors
from .contacts import (
    Sphere,
    SphereContact,
    add_contact,
    corner_radius,
    distance_from,
    refuses_belt,
    refuses_curve,
    sphere_of,
)
from .system import ExudynSystem, HasEffects, clear_gap, static_start

# Samples of a curved support at which its bend is looked at.
CURVE_SAMPLES = 4_001
# An impact takes some periods of the spring.
IMPACT_PERIODS = 2.0


def has_several(case: Case) -> bool:
    """Whether the case may have several contacts, which follow from poses and forces."""
    return bool(case.others) or touches_by_features(case)


def refuses(case: Case) -> Refusal | None:
    """The reason, in one sentence, why no object of the engine models the case's shapes, or None."""
    friction = case.effect(CoulombFriction)
    if friction and friction.by_speed and not case.others:
        return rolls.refuses(case)
    if has_several(case):
        return _refuses_several(case)
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


def _refuses_pair(pair: PairCase) -> str | None:
    """Why this model has no spheres for a pair of a support and a feature of the plate, or one place of several."""
    outline, curve, name = pair.plate.outline, pair.track, pair.support
    if isinstance(outline, Edge):
        return f"A flat side may touch the hill {name!r}, and this adapter has no spheres for it."
    circle = None if isinstance(outline, Corner) else as_circle(outline)
    if not isinstance(outline, Corner) and circle is None:
        return "A plate on supports is round or has corners here, and this outline is another."
    if pair.arc_range is not None:
        return "An arc ends at a corner or bends beyond the plate's hull, and the sphere of this adapter is whole."
    if is_straight(curve):
        return None
    if not curve.period and curve.domain is None:
        return f"Curved supports have ends or are closed here, and {name!r} is neither."
    if pair.effect(Belt) is not None:
        return f"Belts run on straight supports only here, and {name!r} is none."
    bend = np.asarray(curve.curvature(np.linspace(*curve.span, CURVE_SAMPLES)))
    # A disc that fits into a hollow curve everywhere, or lies on a hill, touches it in one place (Blaschke).
    if not np.all(bend <= 0.0) and (bend.min() < 0.0 or (circle and bend.max() * circle.radius >= 1.0)):
        return f"A plate may touch the support {name!r} in several places, and this adapter has a contact for one."
    return None


def _refuses_several(case: Case) -> Refusal | None:
    if why := next(filter(None, map(_refuses_pair, () if case.others else pairs(case))), None):
        return Refusal(why)
    every: list[tuple[str, Curve | None, HasEffects]] = (
        [(one.name, one.curve, one) for one in plate_contacts(case)]
        if case.others
        else [(pair.support, pair.track, pair) for pair in pairs(case)]
    )
    for name, curve, acting in every:
        if curve is not None and (problem := refuses_curve(curve) or refuses_belt(acting)):
            return problem
        if curve is not None and as_circle(curve) and not curve.period:
            return Refusal(f"A circle is closed here, and the support {name!r} has ends.")
        friction = acting.effect(CoulombFriction)
        if acting.effect(PerfectlyRough):
            return Refusal(
                "Exudyn has no perfectly rough contact for a plate that may fly; its rolling joint never opens.",
                "ObjectJointRollingDisc is a constraint",
            )
        if friction and (friction.by_speed or friction.stick != friction.mu):
            return Refusal(
                "Exudyn's contacts have one friction coefficient, for slip and stick and all slip velocities.",
                "dynamicFriction of ObjectContactSphereSphere and ObjectContactSphereTriangle",
            )
    names = ("ObjectContactSphereSphere", "ObjectContactSphereTriangle")
    return next(filter(None, map(older_versions.contact_object, names)), None)


def build(case: Case, setting: Setting) -> ExudynSystem:
    """All plates at the case's start, with gravity and load, and all contact objects."""
    container = exu.SystemContainer()
    system = container.AddSystem()
    starts, contacts = starts_of(case), _contacts(case, setting)
    if not has_several(case):
        # On a line friction acts on the track; on a circle in the middle of the overlap.
        share = 1.0 if as_line(case.track) else 0.5
        starts = np.array([static_start(case, setting, depth=share)[:6]])
    pull = case.effect(Gravity)
    plates = [add_plate(system, *each, pull) for each in zip(plates_of(case), starts.tolist(), strict=True)]
    nodes, bodies = zip(*plates, strict=True)
    if load := case.effect(Load):
        add_load(system, bodies[0], load)
    forces = tuple(force_sensor(system, add_contact(contact, setting, system, [*bodies], case)) for contact in contacts)
    whole = ExudynSystem(container, system, tuple(node_sensors(system, node) for node in nodes), forces)
    system.Assemble()
    if has_several(case):
        return whole
    return replace(whole, contact=lambda data: with_forces(case, data.t, data.pose, data.velocity, data.force, share))


def _contacts(case: Case, setting: Setting) -> list[SphereContact]:
    """All contacts that the plates of a case may have."""
    if case.others:
        poses, plates = starts_of(case), plates_of(case)
        return [
            SphereContact(
                one, one.body, Sphere(one.circle.x, one.circle.y, plates[one.body].reach), one.curve, one.base,
                gap_of(one, poses),
            )
            for one in plate_contacts(case)
        ]  # fmt: skip
    if touches_by_features(case):
        return [
            SphereContact(pair, 0, sphere_of(pair.plate.outline, case, setting), pair.track) for pair in pairs(case)
        ]
    # Without an initial gap the plate would fall for a step before the contact acts; without an initial slip, friction
    # would begin on the steep branch of its law, with a thousand times its bound.
    touching, at_rest = start_motion(case), static_start(case, setting, depth=0.0)
    gap = -hypot(at_rest.x - touching.x, at_rest.y - touching.y)
    slip = hypot(at_rest.vx - touching.vx, at_rest.vy - touching.vy) or abs(touching.slip) if gap else 0.0
    sphere = sphere_of(case.plate.outline, case, setting)
    return [SphereContact(case, 0, sphere, case.track, gap=gap, slip=slip)]


def read(case: Case, setting: Setting, system: ExudynSystem) -> Trajectory:
    """The motion of all plates with several contacts. Raises EngineFailure for numbers that are not finite."""
    tables = [system.tables(motion) for motion in system.motions]
    poses, rates = (np.stack([motion[kind][:, 1:4] for motion in tables], axis=1) for kind in (0, 1))
    creep, plates = float(setting["vreg"]), plates_of(case)
    # A corner's friction acts on the rim of its sphere.
    contacts = _contacts(case, setting)
    if any(contact.sphere.behind for contact in contacts):
        creep += corner_radius(case, setting) * float(np.abs(rates[..., 2]).max())
    impact = IMPACT_PERIODS * 2.0 * pi * sqrt(max(plate.mass for plate in plates) / setting["k"])
    motion = contacts_from_poses.with_plates(
        case, tables[0][0][:, 0], poses, rates, clear_gap(case, setting), _torsor(case, contacts, system, poses),
        slip_lever=0.5, impact=impact if case.others else 0.0,
    )  # fmt: skip
    return replace(motion, slip_resolution=creep)


def _torsor(case: Case, contacts: list[SphereContact], system: ExudynSystem, poses: np.ndarray) -> np.ndarray:
    """Force (N) and moment (N m) of all contacts on each plate, like `poses`, at the spheres' rims. The sensors have
    the force on the plate that a contact names first."""
    result, plates = np.zeros_like(poses), plates_of(case)
    for contact, table in zip(contacts, system.tables(system.forces), strict=True):
        force, arm = table[:, 1:3], contact.sphere.centre(poses[:, contact.body])
        places = poses[:, contact.body, :2] + arm
        if contact.base is None:
            assert contact.curve is not None
            normal, _ = distance_from(contact.curve, places)
        else:
            away = places - poses[:, contact.base, :2]
            normal = away / np.hypot(*away.T)[:, None]
            _add(result, contact.base, plates[contact.base].reach * normal, -force)
        _add(result, contact.body, arm - contact.sphere.radius * normal, force)
    return result * [[1.0, 1.0, float(plate.turns)] for plate in plates]


def _add(torsor: np.ndarray, plate: int, lever: np.ndarray, force: np.ndarray) -> None:
    """Add forces (n, 2) at levers (n, 2) to the forces and moments of a plate."""
    torsor[:, plate, :2] += force
    torsor[:, plate, 2] += lever[:, 0] * force[:, 1] - lever[:, 1] * force[:, 0]
