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

# Chords of a curved track; a friction coefficient that no force exceeds.
CHORDS, ROUGH = 800, 1e3
# Its constraint force mixing, DART_CFM of ContactConstraint.cpp: the share of slip velocity that friction leaves.
MIXING = 1e-5

scene = plane.read_scene(
    "DART",
    ("Gravity", "CoulombFriction", "PerfectlyRough", "Unilateral", "Flight"),
    {"Belt": "DART's surface velocity (ContactSurfaceParams) is not among the bindings of dartpy, so no belt can run."},
)
radius, mass, start = scene["plate"]["radius"], scene["plate"]["mass"], scene["start"]
if radius is None:
    plane.refuse("DART is given spheres: other outlines would be hulls, whose corners its contact takes one by one.")
effects, (count, h) = scene["effects"], plane.steps(scene)
is_tuned = scene["setting"].get("rung") != "defaults"
mu = ROUGH if "PerfectlyRough" in effects else effects.get("CoulombFriction", {}).get("mu", 0.0)


def add_shape(body, shape, x: float = 0.0, y: float = 0.0, angle: float = 0.0) -> None:
    """Give a body a shape that collides, with friction and without restitution, somewhere in the body's frame."""
    node = body.createShapeNode(shape)
    place = dart.math.Isometry3()
    place.set_translation([x, y, 0.0])
    place.set_rotation(np.array([[cos(angle), -sin(angle), 0.0], [sin(angle), cos(angle), 0.0], [0.0, 0.0, 1.0]]))
    node.setRelativeTransform(place)
    node.createCollisionAspect()
    node.createDynamicsAspect()
    # The engine takes the smaller of the two bodies' coefficients.
    node.getDynamicsAspect().setFrictionCoeff(mu)
    node.getDynamicsAspect().setRestitutionCoeff(0.0)


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
track = plane.shape(scene)
thick = 0.5 * radius
if track.kind == "line":
    # Wider than the plate can get in its time, by gravity or on its way.
    way = scene["duration"] * (abs(start["vx"]) + abs(start["vy"]) + radius * abs(start["omega"]))
    way += 0.5 * np.hypot(*plane.gravity(scene)[:2]) * scene["duration"] ** 2 + 10 * radius
    # Its middle is below the start.
    along = (start["x"] - track.x) * cos(track.angle) + (start["y"] - track.y) * sin(track.angle)
    x, y = track.x + along * cos(track.angle), track.y + along * sin(track.angle)
    x, y = x + thick * sin(track.angle), y - thick * cos(track.angle)
    add_shape(fixed, dart.dynamics.BoxShape([4 * way, 2 * thick, 4 * radius]), x, y, track.angle)
elif track.kind == "hill":
    add_shape(fixed, dart.dynamics.SphereShape(track.radius), track.x, track.y)
else:
    for box in plane.chords(scene, scene["setting"].get("facets", CHORDS)):
        x, y = box.x + thick * sin(box.angle), box.y - thick * cos(box.angle)
        add_shape(fixed, dart.dynamics.BoxShape([2 * box.half, 2 * thick, 4 * radius]), x, y, box.angle)
world.addSkeleton(ground)
plate = dart.dynamics.Skeleton("plate")
joint, body = plate.createPlanarJointAndBodyNodePair()
inertia = scene["plate"]["inertia"]
body.setInertia(dart.dynamics.Inertia(mass, [0.0, 0.0, 0.0], np.diag([inertia] * 3)))
add_shape(body, dart.dynamics.SphereShape(radius))
plate.setPositions([start["x"], start["y"], start["theta"]])
plate.setVelocities([start["vx"], start["vy"], start["omega"]])
world.addSkeleton(plate)


def touches(pose) -> list[plane.PlaneContact]:
    """The contacts that pushed in the last step; the result keeps those of the step's beginning."""
    contacts = []
    for contact in world.getLastCollisionResult().getContacts():
        point, normal, force = (np.asarray(each)[:2] for each in (contact.point, contact.normal, contact.force))
        # The order of the bodies decides the normal's sign; here it points from the track to the plate.
        side = 1.0 if normal @ (pose[:2] - point) > 0.0 else -1.0
        push = side * force if side * force @ (side * normal) >= 0.0 else -side * force
        contacts.append(plane.PlaneContact(point.tolist(), (side * normal).tolist(), push.tolist()))
    return contacts


motion, friction_force = plane.MotionRows(scene), 0.0
for k in range(count + 1):
    pose, velocities = plate.getPositions(), plate.getVelocities()
    world.step()
    contacts = touches(pose)
    friction_force = max(friction_force, abs(sum(touch.friction_force for touch in contacts)))
    motion.note(k * h, pose.tolist(), velocities.tolist(), contacts, plate.getVelocities().tolist())
motion.write(MIXING * h * friction_force * (1 / mass + radius**2 / inertia))
