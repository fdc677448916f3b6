"""Exudyn's contact objects of a sphere with a straight line, a circle or another sphere, and their law.

A round plate is a sphere of its radius. A corner is a small sphere about it, and the surface lies behind its curve by
the sphere's radius, so that the sphere touches the surface exactly where the corner touches the curve. Its friction
acts on the sphere's rim: at a corner that turns without slipping the sphere rolls, by its radius times the angle.
"""

from __future__ import annotations

from math import e, sqrt
from typing import Any, NamedTuple

import exudyn as exu
import exudyn.itemInterface as item
import numpy as np

from cases import Belt, Case, Curve, Impact, Load
from cases.contact import start_motion
from cases.curves.corner import Corner
from cases.curves.line_or_circle import as_circle, as_line
from cases.motion.mechanics import gravity
from cases.scene.free_plates import plates_of

from ..common import facets
from ..interface import Refusal, Setting
from . import constraints, older_versions
from .bodies import marker, surface
from .system import HasEffects, critical_damping, friction_coefficient, scales

# An impact slower than this (m/s) is damped as if it had this speed, so that lasting contact comes to rest.
SLOWEST_IMPACT = 1e-2
# The depth of an impact in periods of the spring over 2 pi, critically damped or with restitution, and a fifth more: a
# sphere whose centre passes the surface is lost.
DAMPED_DEPTH, DEPTH = 1.2 / e, 1.2
# A load or a belt may take the plate so many times farther than gravity does; positions then still have twelve digits.
FAR = 100.0


def refuses_curve(curve: Curve) -> Refusal | None:
    """The reason why the engine has no contact of a sphere with a curve, or None."""
    if as_line(curve) or as_circle(curve):
        return None
    return Refusal(
        "Exudyn has smooth rolling contact on straight lines and circles only, and this adapter has no facets for this "
        "track, which is neither."
    )


def refuses_belt(acting: HasEffects) -> Refusal | None:
    """The reason why this adapter has no body for a belt, or None."""
    belt = acting.effect(Belt)
    if belt is None or (belt.constant is not None and not constraints.suits(acting)):
        return None
    return Refusal("A running surface is a heavy body here, for a constant speed and Coulomb's friction only.")


class Sphere(NamedTuple):
    """A sphere on a plate: its centre in the plate's frame and its radius, m, and how far the surface is moved back."""

    u: float
    v: float
    radius: float
    behind: float = 0.0

    def centre(self, pose: np.ndarray) -> np.ndarray:
        """Its centre along a motion of poses (n, 3), m, relative to the centre of mass, shape (n, 2)."""
        c, s = np.cos(pose[:, 2]), np.sin(pose[:, 2])
        return np.column_stack([c * self.u - s * self.v, s * self.u + c * self.v])


class SphereContact(NamedTuple):
    """A contact of a sphere of the plate `body` with a line or a circle or, if there is none, with the round plate
    `base`: what acts there, and gap (m) and slip (m/s) of the start."""

    acting: HasEffects
    body: int
    sphere: Sphere
    curve: Curve | None
    base: int | None = None
    gap: float = 0.0
    slip: float = 0.0


def sphere_of(feature: Any, case: Case, setting: Setting) -> Sphere:
    """The sphere of a circle or a corner of the plate of a case, its scales those of the whole plate."""
    if isinstance(feature, Corner):
        radius = corner_radius(case, setting)
        return Sphere(feature.x, feature.y, radius, radius)
    circle = as_circle(feature)
    assert circle is not None, "checked by `refuses`"
    u, v = circle.centre.tolist()
    return Sphere(u, v, circle.radius)


def corner_radius(case: Case, setting: Setting) -> float:
    """The radius (m) of the spheres at a plate's corners: the depth of the impact of a fall from the start."""
    start, (length, acceleration) = start_motion(case), scales(case)
    place = np.array([[start.x, start.y]])
    height = min(abs(distance_from(curve, place)[1][0]) for curve in (case.track, *(s.curve for s in case.supports)))
    pull = max(acceleration, float(np.hypot(*gravity(case))))
    speed = sqrt(start.vx**2 + start.vy**2 + (start.omega * length) ** 2 + 2.0 * pull * (length + height))
    impact = case.effect(Impact)
    depth = DEPTH if impact and impact.restitution > 0.0 else DAMPED_DEPTH
    return depth * speed * sqrt(case.plate.mass / setting["k"])


def distance_from(curve: Curve, place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The normal of a line or a circle towards the plate next to places (n, 2), of that shape, and their distance in
    its direction (n,), m."""
    if line := as_line(curve):
        normal = np.array([-line.direction[1], line.direction[0]])
        return np.broadcast_to(normal, place.shape), (place - line.point) @ normal
    circle = as_circle(curve)
    assert circle is not None, "checked by `refuses`"
    side, away = -1.0 if circle.left else 1.0, place - circle.centre
    distance = np.hypot(away[:, 0], away[:, 1])
    return side * away / distance[:, None], side * (distance - circle.radius)


def add_contact(contact: SphereContact, setting: Setting, system, bodies: list[int], whole: Case) -> int:
    """Add a contact between bodies of the plates of the whole case, with its law; returns its number."""
    acting, curve, sphere, masses = contact.acting, contact.curve, contact.sphere, [p.mass for p in plates_of(whole)]
    mass, own = masses[contact.body], marker(system, bodies[contact.body], sphere.u, sphere.v)
    if curve is None:
        assert contact.base is not None
        mass = mass * masses[contact.base] / (mass + masses[contact.base])
        radii = [sphere.radius, plates_of(whole)[contact.base].reach]
        kind: Any = item.ObjectContactSphereSphere
        parts: dict = dict(markerNumbers=[own, marker(system, bodies[contact.base])], spheresRadii=radii)
        return int(system.AddObject(kind(**parts, **_law(contact, setting, system, mass))))
    markers = [own, surface(system, curve, acting, masses[0])]
    law = _law(contact, setting, system, mass)
    if line := as_line(curve):
        ends = facets.ends(whole, line)
        middle = 0.5 * (ends[0] + ends[1])
        if acting.effect(Load) or acting.effect(Belt):
            ends = middle + FAR * (ends - middle)
        down = sphere.behind * np.array([-line.direction[1], line.direction[0]])
        kind = item.ObjectContactSphereTriangle(
            markerNumbers=markers,
            **older_versions.sphere_radius(sphere.radius),
            trianglePoints=exu.Vector3DList(_triangle_between(*(ends - down))),  # type: ignore[call-arg]
            includeEdges=0,
            **law,
        )
    else:
        circle = as_circle(curve)
        assert circle is not None, "checked by `refuses`"
        radius = circle.radius + (sphere.behind if circle.left else -sphere.behind)
        kind = item.ObjectContactSphereSphere(
            markerNumbers=markers, spheresRadii=[sphere.radius, radius], isHollowSphere1=circle.left, **law
        )
    return int(system.AddObject(kind))


def _triangle_between(one: np.ndarray, other: np.ndarray) -> list[list[float]]:
    """A triangle across the plane of motion with a side along the line between two points."""
    reach, (x, y) = 0.5 * float(np.hypot(*(other - one))), 0.5 * (one + other)
    return [[*one.tolist(), -reach], [*other.tolist(), -reach], [float(x), float(y), 2.0 * reach]]


def _law(contact: SphereContact, setting: Setting, system, mass: float) -> dict:
    """Parameters that both contact objects share. Their data node holds gap (m) and slip (m/s) of the last iteration;
    `mass` (kg) is what moves on the contact's spring."""
    data = item.NodeGenericData(initialCoordinates=[contact.gap, contact.slip, 0.0, 0.0], numberOfDataCoordinates=4)
    impact = contact.acting.effect(Impact)
    law: dict = dict(contactDamping=critical_damping(mass, setting))
    if impact and impact.restitution > 0.0:
        # Gonthier's and Carvalho's damping, which the engine mixes so that any restitution is met to a thousandth.
        law = dict(impactModel=2, restitutionCoefficient=impact.restitution, minimumImpactVelocity=SLOWEST_IMPACT)
    return dict(
        nodeNumber=system.AddNode(data),
        dynamicFriction=friction_coefficient(contact.acting),
        frictionProportionalZone=setting["vreg"],
        contactStiffness=setting["k"],
        **law,
    )
