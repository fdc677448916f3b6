#!/usr/bin/env -S python3 -P
"""PhysX 5 on the processor, by SAPIEN (wheel sapien): a sphere on a plane, a sphere or a mesh, moved in one plane.

Single precision; contacts are rigid, solved by the temporal Gauss-Seidel method (TGS) or by the projected one (PGS);
friction is that of patches, whose anchors stick. Its step is semi-implicit Euler. A graphics processor is not used.
"""

from __future__ import annotations

import sys
import warnings
from math import atan2, cos, pi, sin
from pathlib import Path

sys.path.append(str(Path(__file__).parent / "shared"))
import plane

# Without a driver for a display it warns that it takes its own.
warnings.simplefilter("ignore")
try:
    import numpy as np
    import sapien
    from sapien import physx
except ImportError:
    plane.exit_not_available("physx", "sapien")
if "--version" in sys.argv:
    print("physx", physx.version(), "sapien", sapien.__version__)
    sys.exit(0)

# Half the width of a curved track (m); a friction coefficient that no force exceeds.
WIDTH, ROUGH = 1.0, 1e6
# Relative, of the engine's numbers.
SINGLE = 2.0**-23

scene = plane.read_scene("PhysX", ("Gravity", "CoulombFriction", "PerfectlyRough", "Unilateral", "Flight"))
radius, mass, inertia = (scene["plate"][name] for name in ("radius", "mass", "inertia"))
if radius is None:
    plane.refuse("PhysX is given spheres: this outline is no circle about the centre of mass.")
effects, setting, (_, h) = scene["effects"], scene["setting"], plane.steps(scene)
is_tuned = setting.get("rung") != "defaults"
mu = plane.coefficient(effects, ROUGH)

config: dict[str, object] = {"gravity": np.array(plane.gravity(scene), dtype=np.float32)}
if is_tuned:
    # TGS is the default; in disc_rolling_off_hill it is off by 9.6 % at 1 ms, PGS by 0.5 %.
    config |= {"enable_tgs": setting.get("solver", "pgs") == "tgs", "bounce_threshold": 1e3}
    # With one iteration for velocities, the default, a disc that rolls at 1 m/s slips by 6.6e-5 m/s; with 32 by 6e-6.
    # The engine's contacts begin 1 cm ahead, a tenth of a plate of 0.1 m: it would meet the next facets, too.
    physx.set_shape_config(contact_offset=1e-3 * radius, rest_offset=0.0)
    physx.set_body_config(setting.get("iterations", 10), setting.get("velocity_iterations", 32), 0.0)
physx.set_scene_config(**config)
system = physx.PhysxCpuSystem()
system.set_timestep(h)
world = sapien.Scene([system])
material = physx.PhysxMaterial(mu, mu, 0.0)


def mesh() -> physx.PhysxCollisionShapeTriangleMesh:
    """The track as a strip of triangles, with their front towards the plate."""
    corners = plane.corners(scene["solids"][0])
    vertices = np.array([(x, y, z) for x, y in corners for z in (-WIDTH, WIDTH)], dtype=np.float32)
    first = 2 * np.arange(len(corners) - 1, dtype=np.uint32)[:, None]
    triangles = np.vstack([first + np.array(each, dtype=np.uint32) for each in ((0, 1, 3), (0, 3, 2))])
    return physx.PhysxCollisionShapeTriangleMesh(vertices, triangles, np.ones(3, dtype=np.float32), material)


def add(component, shape, x: float, y: float, angle: float = 0.0) -> None:
    """Put a body with one shape into the world."""
    component.attach(shape)
    entity = sapien.Entity()
    entity.add_component(component)
    entity.set_pose(sapien.Pose([x, y, 0.0], [cos(angle / 2), 0.0, 0.0, sin(angle / 2)]))
    world.add_entity(entity)


track, ground = scene["solids"][0], physx.PhysxRigidStaticComponent()
if track["kind"] == "line":
    # The engine's plane faces its own x axis.
    add(ground, physx.PhysxCollisionShapePlane(material), track["x"], track["y"], track["angle"] + pi / 2)
elif track["kind"] == "disc":
    add(ground, physx.PhysxCollisionShapeSphere(track["radius"], material), track["x"], track["y"])
else:
    add(ground, mesh(), 0.0, 0.0)
body = physx.PhysxRigidDynamicComponent()
add(body, physx.PhysxCollisionShapeSphere(radius, material), scene["start"]["x"], scene["start"]["y"])
body.set_mass(mass)
body.set_inertia([inertia] * 3)
body.set_locked_motion_axes([False, False, True, True, True, False])
if is_tuned:
    body.set_linear_damping(0.0)
    body.set_angular_damping(0.0)
    body.set_max_angular_velocity(1e4)


class PhysxStepper:
    """The plate, for `plane.run_half_steps`."""

    def state(self) -> tuple[list[float], list[float]]:
        """The engine keeps a quaternion."""
        place, velocity = body.get_pose(), body.get_linear_velocity()
        pose = [float(place.p[0]), float(place.p[1]), 2 * atan2(place.q[3], place.q[0])]
        return pose, [float(velocity[0]), float(velocity[1]), float(body.get_angular_velocity()[2])]

    def set_state(self, pose, velocities) -> None:
        """Set pose and velocities."""
        x, y, theta = pose
        body.set_pose(sapien.Pose([x, y, 0.0], [cos(theta / 2), 0.0, 0.0, sin(theta / 2)]))
        body.set_linear_velocity([velocities[0], velocities[1], 0.0])
        body.set_angular_velocity([0.0, 0.0, velocities[2]])

    def step(self) -> None:
        """One step of the whole world."""
        system.step()


# Its contacts report normal impulses alone, so forces follow from the momentum.
plane.run_half_steps(scene, PhysxStepper(), SINGLE)
