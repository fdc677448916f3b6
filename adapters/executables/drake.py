#!/usr/bin/env -S python3 -P
"""Drake (wheel drake): a sphere on a half-space, a sphere or a ring of boxes, by its discrete multibody plant.

Point contact with the approximation TAMSI, whose friction is regularised: what sticks creeps at up to the stiction
tolerance (its documentation of MultibodyPlant, "Contact modeling"), which the setting makes small. Poses and
velocities stand at the same times.
"""

from __future__ import annotations

import sys
from math import cos, sin
from pathlib import Path

sys.path.append(str(Path(__file__).parent / "shared"))
import plane

try:
    import numpy as np
    from pydrake.geometry import Box, HalfSpace, Sphere
    from pydrake.math import RigidTransform, RollPitchYaw
    from pydrake.multibody import plant as drake
    from pydrake.multibody.tree import PlanarJoint, SpatialInertia, UnitInertia
    from pydrake.systems.analysis import Simulator
    from pydrake.systems.framework import DiagramBuilder
except ImportError:
    plane.not_installed("drake")
plane.tell_version("drake")

# Of a curved track; friction that no forces exhaust.
CHORDS, ROUGH = 3200, 1e3
# How far (m) a plate at rest may sink in, and how fast (m/s) it may creep while it sticks.
SUNK, CREEP = 1e-6, 1e-5
# What is declared: ten times what a disc that rolls on a line has at its nominal radius (6.5e-5 m/s).
DECLARED = 1e-3

scene = plane.read_scene("Drake", ("Gravity", "CoulombFriction", "PerfectlyRough", "Unilateral", "Flight"))
radius, mass, start = scene["plate"]["radius"], scene["plate"]["mass"], scene["start"]
if radius is None:
    plane.refuse(
        "Drake is given spheres: other outlines would be hulls, whose corners its point contact takes one by one."
    )
effects, (count, h) = scene["effects"], plane.steps(scene)
mu = ROUGH if "PerfectlyRough" in effects else effects.get("CoulombFriction", {}).get("mu", 0.0)

builder = DiagramBuilder()
plant, _ = drake.AddMultibodyPlantSceneGraph(builder, h)
plant.set_contact_model(drake.ContactModel.kPoint)
plant.set_discrete_contact_approximation(drake.DiscreteContactApproximation.kTamsi)
plant.mutable_gravity_field().set_gravity_vector(np.array(plane.gravity(scene)))
# Of two bodies' coefficients the engine takes 2 μ₁ μ₂ / (μ₁ + μ₂): the same where both are.
friction = drake.CoulombFriction(mu, mu)
track = plane.shape(scene)
if track.kind == "line":
    # A half-space is below the XY plane of its own frame.
    across = np.array([-sin(track.angle), cos(track.angle), 0.0])
    pose = RigidTransform(HalfSpace.MakePose(across, np.array([track.x, track.y, 0.0])))
    plant.RegisterCollisionGeometry(plant.world_body(), pose, HalfSpace(), "track", friction)
elif track.kind == "hill":
    pose = RigidTransform(np.array([track.x, track.y, 0.0]))
    plant.RegisterCollisionGeometry(plant.world_body(), pose, Sphere(track.radius), "track", friction)
else:
    thick = 0.5 * radius
    for number, box in enumerate(plane.chords(scene, CHORDS)):
        middle = np.array([box.x + thick * sin(box.angle), box.y - thick * cos(box.angle), 0.0])
        pose = RigidTransform(RollPitchYaw(0.0, 0.0, box.angle), middle)
        shape = Box(2 * box.half, 2 * thick, 4 * radius)
        plant.RegisterCollisionGeometry(plant.world_body(), pose, shape, f"chord {number}", friction)
inertia = scene["plate"]["inertia"] / mass
# In the plane only the moment about Z tells.
unit = UnitInertia(inertia, inertia, inertia)
body = plant.AddRigidBody("plate", SpatialInertia(mass, np.zeros(3), unit))
plant.RegisterCollisionGeometry(body, RigidTransform(), Sphere(radius), "plate", friction)
joint = plant.AddJoint(PlanarJoint("plane", plant.world_frame(), body.body_frame(), np.zeros(3)))
plant.Finalize()
if scene["setting"].get("rung") != "defaults":
    plant.set_penetration_allowance(SUNK)
    plant.set_stiction_tolerance(CREEP)
diagram = builder.Build()
simulator = Simulator(diagram)
root = simulator.get_mutable_context()
context = plant.GetMyMutableContextFromRoot(root)
plant.SetPositions(context, [start["x"], start["y"], start["theta"]])
plant.SetVelocities(context, [start["vx"], start["vy"], start["omega"]])
simulator.Initialize()
motion = plane.Motion()
for k in range(count + 1):
    motion.rows.append((k * h, *plant.GetPositions(context), *plant.GetVelocities(context)))
    if k < count:
        simulator.AdvanceTo((k + 1) * h)
motion.write(count, DECLARED)
