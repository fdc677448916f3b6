#!/usr/bin/env -S python3 -P
"""DART (wheel dartpy): a sphere on a box, a sphere or a ring of boxes, by its boxed LCP after Dantzig.

Its contacts are rigid, its friction is a pyramid, which in the plane is Coulomb's cone; its step is semi-implicit
Euler. Poses and velocities are at the same times here, as after `World.step`.
"""

from __future__ import annotations

import sys
from math import cos, sin
from pathlib import Path

sys.path.append(str(Path(__file__).parent / "shared"))
import plane

try:
    import dartpy as dart
    import numpy as np
except ImportError:
    plane.exit_not_available("dartpy")
plane.print_version("dartpy")

# A friction coefficient that no force exceeds.
ROUGH = 1e3
# Its constraint force mixing, DART_CFM of ContactConstraint.cpp: the share of slip velocity that friction leaves.
MIXING = 1e-5

scene = plane.read_scene(
    "DART",
    ("Gravity", "CoulombFriction", "PerfectlyRough", "Unilateral", "Flight", "Impact"),
    {"Belt": "DART's surface velocity (ContactSurfaceParams) is not among the bindings of dartpy, so no belt can run."},
    rebounds=True,
)
radius, mass, start = scene["plate"]["radius"], scene["plate"]["mass"], scene["start"]
if radius is None:
    plane.refuse("DART is given spheres: other outlines would be hulls, whose corners its contact takes one by one.")
effects, (_, h) = scene["effects"], plane.steps(scene)
is_tuned = scene["setting"].get("rung") != "defaults"
mu = plane.coefficient(effects, ROUGH)


def add_shape(body, shape, x: float = 0.0, y: float = 0.0, angle: float = 0.0) -> None:
    """Give a body a shape that collides, with friction and restitution, somewhere in the body's frame."""
    node = body.createShapeNode(shape)
    place = dart.math.Isometry3()
    place.set_translation([x, y, 0.0])
    place.set_rotation(np.array([[cos(angle), -sin(angle), 0.0], [sin(angle), cos(angle), 0.0], [0.0, 0.0, 1.0]]))
    node.setRelativeTransform(place)
    node.createCollisionAspect()
    node.createDynamicsAspect()
    # The engine takes the smaller of the two bodies' coefficients.
    node.getDynamicsAspect().setFrictionCoeff(mu)
    # It multiplies their restitutions.
    node.getDynamicsAspect().setRestitutionCoeff(plane.restitution(effects) if body.getSkeleton().isMobile() else 1.0)


world = dart.simulation.World()
world.setGravity(list(plane.gravity(scene)))
world.setTimeStep(h)
if is_tuned:
    # The default detector turns shapes into meshes; DART's own detector has spheres and boxes.
    solver = world.getConstraintSolver()
    solver.setCollisionDetector(dart.collision.DARTCollisionDetector())
    solver.setSplitImpulseEnabled(scene["setting"].get("split_impulse", "off") == "on")
    kind = scene["setting"].get("solver", "dantzig")  # which is the engine's own
    if kind == "pgs":
        # Gauss-Seidel on the same pyramid; it has no constructor, but the engine keeps one for where Dantzig fails.
        solver.setBoxedLcpSolver(solver.getSecondaryBoxedLcpSolver())
    elif kind == "nsgs":
        # Gauss-Seidel on Coulomb's cone.
        solver.setBoxedLcpSolver(dart.constraint.NsgsFrictionSolver())
ground = dart.dynamics.Skeleton("track")
fixed = ground.createWeldJointAndBodyNodePair()[1]
ground.setMobile(False)
thick = 0.5 * radius
for solid in plane.solids(scene):
    if solid.kind == "line":
        # Wider than the plate can get in its time, by gravity or on its way.
        way = scene["duration"] * (abs(start["vx"]) + abs(start["vy"]) + radius * abs(start["omega"]))
        way += 0.5 * np.hypot(*plane.gravity(scene)[:2]) * scene["duration"] ** 2 + 10 * radius
        # Its middle is below the start.
        c, s = cos(solid.angle), sin(solid.angle)
        along = (start["x"] - solid.x) * c + (start["y"] - solid.y) * s
        solid = solid._replace(x=solid.x + along * c, y=solid.y + along * s, size=2 * way)
    if solid.kind == "disc":
        add_shape(fixed, dart.dynamics.SphereShape(solid.size), solid.x, solid.y)
    else:
        box = dart.dynamics.BoxShape([2 * solid.size, 2 * thick, 4 * radius])
        x, y = solid.middle(thick)
        add_shape(fixed, box, x, y, solid.angle)
world.addSkeleton(ground)
plate = dart.dynamics.Skeleton("plate")
joint, body = plate.createPlanarJointAndBodyNodePair()
inertia = scene["plate"]["inertia"]
body.setInertia(dart.dynamics.Inertia(mass, [0.0, 0.0, 0.0], np.diag([inertia] * 3)))
add_shape(body, dart.dynamics.SphereShape(radius))
plate.setPositions([start["x"], start["y"], start["theta"]])
plate.setVelocities([start["vx"], start["vy"], start["omega"]])
world.addSkeleton(plate)


def states() -> list[list[float]]:
    """(x, y, theta, vx, vy, omega) of the plate."""
    return [[*plate.getPositions().tolist(), *plate.getVelocities().tolist()]]


pose = plate.getPositions()


def step(number: int) -> None:
    """A step; the pose where it begins is kept."""
    global pose
    pose = plate.getPositions()
    world.step()


def touches() -> list[plane.PlaneContact]:
    """The contacts that pushed in the last step; the result keeps those of the step's beginning."""
    contacts = []
    for contact in world.getLastCollisionResult().getContacts():
        point, normal, force = (np.asarray(each)[:2] for each in (contact.point, contact.normal, contact.force))
        # The order of the bodies decides the normal's sign; here it points from the track to the plate.
        side = 1.0 if normal @ (pose[:2] - point) > 0.0 else -1.0
        push = side * force if side * force @ (side * normal) >= 0.0 else -side * force
        contacts.append(plane.PlaneContact(point.tolist(), (side * normal).tolist(), push.tolist()))
    return contacts


def creep() -> float:
    """The slip velocity (m/s) that the constraint force mixing leaves of the last step's friction."""
    return MIXING * h * abs(sum(touch.friction_force for touch in touches())) * (1 / mass + radius**2 / inertia)


plane.write_motion(scene, states, step, touches, creep)
