#!/usr/bin/env -S python3 -P
"""Drake (wheel drake): a sphere on a half-space, a sphere or a ring of boxes, by its discrete multibody plant.

A driven track is a heavy body whose place and velocities are set in each step: locked joints stand still.

Point contact with the approximation TAMSI, whose friction is regularised: a sticking contact creeps at up to the
stiction tolerance (its documentation of MultibodyPlant, "Contact modeling"), which the setting makes small. Poses and
velocities are at the same times. Stiffness (1e6 N/m of each shape) and dissipation (50 s/m) are the engine's defaults,
which take precedence over `set_penetration_allowance`; stiffer contacts gained nothing. A landing sinks in by its speed
times the step, and comes up again at 1/50 m/s.

The engine's default approximation, Lagged, has friction of mu times the force that penetration and its rate give at the
beginning of a step. Where a plate turns about another one by an arc u h in a step, that is k (u h)^2/(2 R) too little:
at 1 ms a disc on a free disc slips with 20 to 67 % of its friction (96 % at 0.2 ms).
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
    plane.exit_not_available("drake")
plane.print_version("drake")

# A friction coefficient that no force exceeds.
ROUGH = 1e3
# The only plate's coefficient, and the mass of a driven track in those of the plate.
LARGE, HEAVY = 1e16, 1e9
# How fast (m/s) a plate may creep while it sticks; the engine's default is 1e-4. TAMSI's friction grows with the slip's
# share x of that speed as mu x (2 - x), so a contact that sticks at the cone's edge creeps with it
# (MultibodyPlant.set_stiction_tolerance, tamsi_solver.h), to a hundredth: Newton's tolerance there.
CREEP, TOLERANCE = 1e-5, 1e-2

APPROXIMATIONS = {
    "tamsi": drake.DiscreteContactApproximation.kTamsi,
    "similar": drake.DiscreteContactApproximation.kSimilar,
    "lagged": drake.DiscreteContactApproximation.kLagged,
}

scene = plane.read_scene(
    "Drake",
    (
        *("Gravity", "CoulombFriction", "PerfectlyRough", "Unilateral", "Flight", "Impact", "Drive", "Supports"),
        "FreePlates",
    ),
    {"Belt": "Drake's contacts have no surface velocity: a belt would have to be a body that moves."},
)
plates = plane.plates(scene)
radius, mass = plates[0].radius, plates[0].mass
if radius is None:
    plane.refuse(
        "Drake is given spheres: other outlines would be hulls, whose corners its point contact takes one by one."
    )
effects, (count, h) = scene["effects"], plane.steps(scene)
drive, mu = plane.drive_steps(scene, h), plane.coefficient(effects, ROUGH)
# With one plate a number so large that its inverse is rounding; that of several acts between them too.
OF_PLATES = LARGE if len(plates) == 1 else mu
fixed = plane.solids(scene)
if any(0.0 < plane.coefficient(solid.effects, ROUGH) >= 2 * OF_PLATES for solid in fixed):
    plane.refuse(
        "Drake combines the coefficients a and b of two bodies as 2 a b / (a + b), so a support has less than twice "
        "the friction between the plates."
    )

builder = DiagramBuilder()
plant, _ = drake.AddMultibodyPlantSceneGraph(builder, h)
is_tuned = scene["setting"].get("rung") != "defaults"
stiction = scene["setting"].get("stiction", CREEP) if is_tuned else drake.MultibodyPlantConfig().stiction_tolerance
if is_tuned:
    plant.set_contact_model(drake.ContactModel.kPoint)
    plant.set_discrete_contact_approximation(APPROXIMATIONS[scene["setting"].get("approximation", "tamsi")])
plant.mutable_gravity_field().set_gravity_vector(np.array(plane.gravity(scene)))


def friction(of_effects) -> drake.CoulombFriction:
    """The friction of a track or a support. The engine combines two coefficients as 2 a b / (a + b): with that of the
    plates it has to give the contact's."""
    own = plane.coefficient(of_effects, ROUGH)
    own = own / (2 - own / OF_PLATES) if own else 0.0
    return drake.CoulombFriction(own, own)


ground = plant.world_body()
if drive:
    # Its velocities are set in each step, and it has so much mass that no contact force changes them.
    heavy = HEAVY * max(mass, plates[0].inertia)
    instance = plant.AddModelInstance("track")
    ground = plant.AddRigidBody("track", instance, SpatialInertia(heavy, np.zeros(3), UnitInertia(1.0, 1.0, 1.0)))
    rail = plant.AddJoint(PlanarJoint("rail", plant.world_frame(), ground.body_frame(), np.zeros(3)))
    plant.set_gravity_enabled(instance, False)
thick = 0.5 * radius
for solid in fixed:
    if solid.kind == "line":
        # A half-space is below the XY plane of its own frame.
        across = np.array([-sin(solid.angle), cos(solid.angle), 0.0])
        pose, shape = RigidTransform(HalfSpace.MakePose(across, np.array([solid.x, solid.y, 0.0]))), HalfSpace()
    elif solid.kind == "disc":
        pose, shape = RigidTransform(np.array([solid.x, solid.y, 0.0])), Sphere(solid.size)
    else:
        middle = np.array([*solid.middle(thick), 0.0])
        pose = RigidTransform(RollPitchYaw(0.0, 0.0, solid.angle), middle)
        shape = Box(2 * solid.size, 2 * thick, 4 * radius)
    plant.RegisterCollisionGeometry(ground, pose, shape, solid.name, friction(solid.effects))
bodies, joints = [], []
for own in plates:
    inertia = own.inertia / own.mass
    # In the plane only the moment of inertia about Z matters.
    inertias = SpatialInertia(own.mass, np.zeros(3), UnitInertia(inertia, inertia, inertia))
    body = plant.AddRigidBody(own.name, plant.AddModelInstance(own.name), inertias)
    rubs = drake.CoulombFriction(OF_PLATES, OF_PLATES)
    plant.RegisterCollisionGeometry(body, RigidTransform(), Sphere(own.radius), own.name, rubs)
    bodies.append(body)
    joints.append(
        plant.AddJoint(PlanarJoint(f"plane of {own.name}", plant.world_frame(), body.body_frame(), np.zeros(3)))
    )
plant.Finalize()
if is_tuned:
    plant.set_stiction_tolerance(stiction)
diagram = builder.Build()
simulator = Simulator(diagram)
root = simulator.get_mutable_context()
context = plant.GetMyMutableContextFromRoot(root)
for own, joint in zip(plates, joints, strict=True):
    joint.set_translation(context, own.pose[:2])
    joint.set_rotation(context, own.pose[2])
    joint.set_translational_velocity(context, own.velocities[:2])
    joint.set_angular_velocity(context, own.velocities[2])
simulator.Initialize()
results = plant.get_contact_results_output_port()


def touches() -> list[plane.PlaneContact]:
    """The contacts that pushed in the last step: those of the step's beginning, with the forces of its end."""
    now, contacts = results.Eval(context), []
    for number in range(now.num_point_pair_contacts()):
        info = now.point_pair_contact_info(number)
        # The force is on body B, the normal points to body A.
        side = -1.0 if info.bodyB_index() == bodies[0].index() else 1.0
        force, normal = -side * info.contact_force(), side * info.point_pair().nhat_BA_W
        contacts.append(plane.PlaneContact(info.contact_point()[:2].tolist(), normal[:2].tolist(), force[:2].tolist()))
    return contacts


def states() -> list[list[float]]:
    """(x, y, theta, vx, vy, omega) of every plate."""
    rows = []
    for joint in joints:
        pose = [*joint.get_translation(context).tolist(), joint.get_rotation(context)]
        rows.append([*pose, *joint.get_translational_velocity(context).tolist(), joint.get_angular_velocity(context)])
    return rows


def step(number: int) -> None:
    """Move a driven track, then make a step of all."""
    if drive:
        (x, y, angle), (vx, vy, spin) = drive(number)
        rail.set_translation(context, [x, y])
        rail.set_rotation(context, angle)
        rail.set_translational_velocity(context, [vx, vy])
        rail.set_angular_velocity(context, spin)
    simulator.AdvanceTo((number + 1) * h)


from_poses = bool(drive) or "Supports" in effects  # relative to the track
plane.write_motion(scene, states, step, touches, lambda: (1 + TOLERANCE) * stiction, plane.MIDDLE, from_poses)
