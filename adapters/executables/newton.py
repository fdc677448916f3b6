#!/usr/bin/env -S python3 -P
"""Newton (wheel newton, on Warp) on the processor: a sphere on a plane, a sphere or boxes.

Single precision. Contacts are planes that are found at a step's beginning. Its solver XPBD, which the ladder has,
corrects positions and bounds friction by the cone of a step's correction; SemiImplicit has springs and regularised
friction; VBD has springs and Coulomb's cone, with multipliers that it keeps from step to step. The step of all is
semi-implicit Euler. A graphics processor is not used.

Warp compiles its kernels at their first use and keeps them in the user's cache (WARP_CACHE_PATH). The option --compile
does this for all that a run needs, so that no run compiles; before it, and after a change of this file, the program
ends with a message that says so.
"""

from __future__ import annotations

import sys
from contextlib import redirect_stdout
from hashlib import sha256
from math import atan2, cos, pi, sin
from pathlib import Path

sys.path.append(str(Path(__file__).parent / "shared"))
import plane

try:
    from importlib.metadata import version

    import numpy as np
    import warp

    VERSION = version("newton")
except ImportError:
    plane.exit_not_available("newton")

# A friction coefficient that no force exceeds.
ROUGH = 1e3
# Relative precision of the engine's numbers. XPBD's velocities follow from the distance of two places, each with two
# coordinates: four roundings.
SINGLE, OF_PLACES = 2.0**-23, 4 * 2.0**-24
# Of SemiImplicit, whose springs are integrated explicitly: (angular frequency of a contact times the step)², and the
# viscous friction's share of the mass over the step. Three times the latter is the share of a disc's slip that a step
# takes away; the limit of stability is 4 and 2.
SPRING, VISCOSITY = 0.1, 0.5
# The former for VBD, whose springs are implicit: at 1 ms off in disc_in_circle[mu=0.2] is 8.0 % with 0.1 and 3.7 % with
# 10.
IMPLICIT_SPRING = 10.0
# The ladder's solver first.
SOLVERS = ("xpbd", "semi_implicit", "vbd")

scene = None
if not {"--version", "--compile"} & set(sys.argv):
    # Before Warp starts, which always prints a warning where there is no driver: a reason is the first line there.
    scene = plane.read_scene("Newton", ("Gravity", "CoulombFriction", "PerfectlyRough", "Unilateral", "Flight"))
    if scene["plate"]["radius"] is None:
        plane.refuse("Newton is given spheres: this outline is no circle about the centre of mass.")
    warp.config.log_level = warp.LOG_ERROR
with redirect_stdout(sys.stderr):
    # Nothing is differentiated here: less to compile.
    warp.config.enable_backward = False
    warp.init()
    warp.set_device("cpu")
# Written when all kernels that this file needs are in Warp's cache; what clears the cache deletes it, too.
digest = sha256(Path(__file__).read_bytes()).hexdigest()[:12]
mark = Path(warp.config.kernel_cache_dir) / f"wp_slip_to_roll_newton_{VERSION}_{digest}"
if "--compile" not in sys.argv and not mark.is_dir():
    print(f"newton is not compiled: python3 {sys.argv[0]} --compile, once; it takes a minute", file=sys.stderr)
    sys.exit(1)
plane.print_version("newton")
with redirect_stdout(sys.stderr):
    import newton


def placed(x: float, y: float, angle: float = 0.0):
    """A place in the plane, turned about the engine's z axis."""
    return warp.transform((x, y, 0.0), (0.0, 0.0, sin(angle / 2), cos(angle / 2)))


class NewtonStepper:
    """The plate, for `plane.run_half_steps`."""

    def __init__(self, scene):
        setting, (_, self.h) = scene["setting"], plane.steps(scene)
        self.is_tuned = setting.get("rung") != "defaults"
        kind = setting.get("solver", SOLVERS[0])
        builder = newton.ModelBuilder(gravity=plane.gravity(scene))
        self._add_shapes(builder, scene, kind)
        if kind == "vbd":
            builder.color()  # the order in which this solver takes bodies
        model = builder.finalize()
        self.now, self.after, self.control = model.state(), model.state(), model.control()
        self.pipeline = newton.CollisionPipeline(model)
        self.contacts = self.pipeline.contacts()
        if kind == "xpbd":
            tuned = {"iterations": setting.get("iterations", 4), "rigid_contact_relaxation": 1.0}
            self.solver = newton.solvers.SolverXPBD(model, **(tuned if self.is_tuned else {}))
        elif kind == "vbd":
            self.solver = newton.solvers.SolverVBD(model, iterations=setting.get("iterations", 10))
        else:
            self.solver = newton.solvers.SolverSemiImplicit(model, angular_damping=0.0)

    def _add_shapes(self, builder, scene, kind: str) -> None:
        """Add the track and the plate."""
        setting = scene["setting"]
        radius, mass, inertia = (scene["plate"][name] for name in ("radius", "mass", "inertia"))
        material = newton.ModelBuilder.ShapeConfig(mu=plane.coefficient(scene["effects"], ROUGH), density=0.0)
        if self.is_tuned:
            material.mu_torsional = material.mu_rolling = 0.0
            material.ke = (IMPLICIT_SPRING if kind == "vbd" else SPRING) * mass / self.h**2
            # Critical damping; VBD counts a damper's force in the normal force, but not in the cone of friction.
            material.kd = 0.0 if kind == "vbd" else 2.0 * (material.ke * mass) ** 0.5
            material.kf = VISCOSITY * mass / self.h
            if scene["solids"][0]["kind"] == "chain":
                # Contacts begin 10 cm ahead by default, with planes across the way to boxes that the plate only
                # approaches: it would be braked.
                material.gap = setting.get("gap", 0.0)
        for solid in plane.solids(scene):
            if solid.kind == "line":
                across = -sin(solid.angle), cos(solid.angle)
                offset = -(across[0] * solid.x + across[1] * solid.y)
                builder.add_shape_plane((*across, 0.0, offset), width=0.0, length=0.0, cfg=material)
            elif solid.kind == "disc":
                builder.add_shape_sphere(-1, xform=placed(solid.x, solid.y), radius=solid.size, cfg=material)
            else:
                x, y = solid.middle(radius)
                place = placed(x, y, solid.angle)
                builder.add_shape_box(-1, xform=place, hx=solid.size, hy=radius, hz=2 * radius, cfg=material)
        body = builder.add_body(
            xform=placed(*(scene["start"][name] for name in ("x", "y", "theta"))),
            mass=mass, inertia=warp.mat33(*(inertia * np.eye(3)).ravel()), lock_inertia=True,
        )  # fmt: skip
        builder.add_shape_sphere(body, radius=radius, cfg=material)

    def state(self) -> tuple[list[float], list[float]]:
        """The engine keeps a quaternion; its velocities are linear, then angular."""
        place, speed = self.now.body_q.numpy()[0].tolist(), self.now.body_qd.numpy()[0].tolist()
        return [place[0], place[1], 2 * atan2(place[5], place[6])], [speed[0], speed[1], speed[5]]

    def set_state(self, pose, velocities) -> None:
        """Set pose and velocities."""
        x, y, theta = pose
        self.now.body_q.assign(np.array([[x, y, 0.0, 0.0, 0.0, sin(theta / 2), cos(theta / 2)]], dtype=np.float32))
        rates = [[velocities[0], velocities[1], 0.0, 0.0, 0.0, velocities[2]]]
        self.now.body_qd.assign(np.array(rates, dtype=np.float32))
        self.solver.reset(self.now, flags=0)  # a solver may keep the last pose and forces, and VBD does

    def step(self) -> None:
        """Contacts are found at the step's beginning."""
        self.now.clear_forces()
        self.pipeline.collide(self.now, self.contacts)
        self.solver.step(self.now, self.after, self.control, self.contacts, self.h)
        self.now, self.after = self.after, self.now


def compile_kernels() -> None:
    """Take a step on each kind of track, which compiles what a run needs."""
    flat = dict(name="track", x=0.0, y=0.0, angle=0.0, radius=1.0)
    angles = np.linspace(0.0, 2 * np.pi, 65)
    bowl = dict(name="track", kind="chain", x=np.cos(angles).tolist(), y=np.sin(angles).tolist())
    start = dict(x=0.0, y=0.1, theta=0.0, vx=0.0, vy=0.0, omega=0.0)
    plate, gravity = dict(radius=0.1, mass=1.0, inertia=0.005), dict(g=9.81, direction=-pi / 2)
    for solid in (flat | dict(kind="line"), flat | dict(kind="disc"), bowl):
        for solver in SOLVERS:
            scene = {
                "duration": 1.0, "plate": plate, "start": start, "effects": {"Gravity": gravity},
                "solids": [solid], "setting": {"h": 1e-3, "solver": solver},
            }  # fmt: skip
            print(f"solver {solver}", file=sys.stderr)
            with redirect_stdout(sys.stderr):
                stepper = NewtonStepper(scene)
                stepper.step()
                stepper.set_state(*stepper.state())
                stepper.step()


if "--compile" in sys.argv:
    compile_kernels()
    mark.mkdir(exist_ok=True)
    sys.exit(0)
with redirect_stdout(sys.stderr):
    plate = NewtonStepper(scene)
    plate.step()  # Warp loads its kernels, which is no part of the cost
plane.run_half_steps(scene, plate, SINGLE, OF_PLACES)
