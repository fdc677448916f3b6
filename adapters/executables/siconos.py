#!/usr/bin/python3 -P
"""Siconos (Debian's python3-siconos): a disc on any track, by Moreau's and Jean's time stepping.

Its law is the suite's: a set-valued contact with Coulomb's cone, Newton's restitution, and no softness, so a sticking
contact does not creep. The engine has no curves: gap and slip of the contact are linear relations of the
coordinates that a user gives (LagrangianLinearTIR), here of the tangent plane. Moreau's step applies it to the velocity
at the step's end and moves the plate by the mean of the velocities at both ends (theta = 1/2); so the plane is that of
the predicted pose at the step's end, and the gap drifts with h^2. With the plane of the step's beginning it drifts with
h, by 7 mm in a circle of 1 m at 1 ms. Poses and velocities are at the same times.

Debian's package is for Debian's own Python.
"""

from __future__ import annotations

import sys
from math import hypot
from pathlib import Path

sys.path.append(str(Path(__file__).parent / "shared"))
try:
    import numpy as np
    import siconos
    import siconos.kernel as kernel
except ImportError:
    print("siconos is not installed: apt-get install python3-siconos, on Debian", file=sys.stderr)
    sys.exit(1)
import plane

if "--version" in sys.argv:
    print("siconos", siconos.version)
    sys.exit(0)

# A friction coefficient that no force exceeds.
ROUGH = 1e6
# Residual at which the engine's solver of one step stops; its default is 1e-4.
TOLERANCE = 1e-12
# Roundings of a velocity in one step.
ROUNDINGS = 10
# A gap of this part of the radius is closed: far above rounding, far below the gap that any step leaves.
CLOSED = 1e-9
# Newton's iterations for the nearest point of the track: from the last one it converges in three.
MOST_ITERATIONS = 20

scene = plane.read_scene(
    "Siconos",
    ("Gravity", "CoulombFriction", "PerfectlyRough", "Unilateral", "Flight", "Impact", "Supports"),
    rebounds=True,
)
radius, mass, inertia = (scene["plate"][name] for name in ("radius", "mass", "inertia"))
start, effects, (_, h) = scene["start"], scene["effects"], plane.steps(scene)
if radius is None:
    plane.refuse("Siconos is given discs here: this outline is no circle about the centre of mass.")


class Track:
    """The track's point nearest to the plate's centre, which moves little by little: a cubic between two samples."""

    def __init__(self, points, closed: bool, x: float, y: float):
        self.p = np.column_stack([points["x"], points["y"]])
        self.n = np.column_stack([points["normal_x"], points["normal_y"]])
        self.t = np.column_stack([self.n[:, 1], -self.n[:, 0]])
        chord = np.hypot(*np.diff(self.p, axis=0).T)
        self.length = chord * (1 + (np.array(points["curvature"])[:-1] * chord) ** 2 / 24)
        self.closed, self.last = closed, len(chord) - 1
        self.i = min(self.last, int(np.argmin(np.hypot(self.p[:, 0] - x, self.p[:, 1] - y))))

    def contact(self, x: float, y: float) -> tuple[float, tuple[float, float]]:
        """The gap (m) of the disc with its centre there, and the track's left normal."""
        for _ in range(self.last):
            if (x - self.p[self.i + 1, 0]) * self.t[self.i + 1, 0] + (y - self.p[self.i + 1, 1]) * self.t[
                self.i + 1, 1
            ] > 0:
                following = (self.i + 1) % (self.last + 1) if self.closed else min(self.i + 1, self.last)
            elif (x - self.p[self.i, 0]) * self.t[self.i, 0] + (y - self.p[self.i, 1]) * self.t[self.i, 1] < 0:
                following = (self.i - 1) % (self.last + 1) if self.closed else max(self.i - 1, 0)
            else:
                break
            if following == self.i:
                break
            self.i = following
        (ax, ay), (bx, by), length = self.p[self.i], self.p[self.i + 1], self.length[self.i]
        (sx, sy), (ex, ey) = self.t[self.i] * length, self.t[self.i + 1] * length
        u = 0.5
        for _ in range(MOST_ITERATIONS):
            px, dx, cx = _cubic(ax, bx, sx, ex, u)
            py, dy, cy = _cubic(ay, by, sy, ey, u)
            slope = (x - px) * cx + (y - py) * cy - dx * dx - dy * dy
            step = ((x - px) * dx + (y - py) * dy) / slope
            u -= step
            if abs(step) < 1e-14:
                break
        speed = hypot(dx, dy)
        normal = -dy / speed, dx / speed
        return (x - px) * normal[0] + (y - py) * normal[1] - radius, normal


def _cubic(a: float, b: float, s: float, e: float, u: float) -> tuple[float, float, float]:
    """Value and two derivatives at u of the cubic with the ends a and b and their slopes s and e."""
    w = 1 - u
    value = a * w * w * (1 + 2 * u) + b * u * u * (3 - 2 * u) + u * w * (s * w - e * u)
    slope = 6 * u * w * (b - a) + s * w * (1 - 3 * u) + e * u * (3 * u - 2)
    return value, slope, 6 * (1 - 2 * u) * (b - a) + s * (6 * u - 4) + e * (6 * u - 2)


pull = plane.gravity(scene)
plate = kernel.LagrangianLinearTIDS(
    np.array([start["x"], start["y"], start["theta"]]),
    np.array([start["vx"], start["vy"], start["omega"]]),
    np.diag([mass, mass, inertia]),
)
plate.setFExtPtr(np.array([mass * pull[0], mass * pull[1], 0.0]))
model = kernel.NonSmoothDynamicalSystem(0.0, scene["duration"] + 10 * h)
model.insertDynamicalSystem(plate)


class DiscContact:
    """The engine's contact of the disc with the track or a support, by the tangent plane of each step."""

    def __init__(self, points, closed: bool, effects):
        self.track = Track(points, closed, start["x"], start["y"])
        # Rows: the normal and the tangential direction; the gap is their first component plus the first offset.
        self.directions, self.offset = np.zeros((2, 3)), np.zeros(2)
        self.relation = kernel.LagrangianLinearTIR(self.directions, self.offset)
        e, mu = plane.restitution(effects), plane.coefficient(effects, ROUGH)
        self.law = kernel.NewtonImpactFrictionNSL(e, 0.0, mu, 2)
        self.interaction = kernel.Interaction(self.law, self.relation)
        model.link(self.interaction, plate)

    def set_plane(self, pose, velocities) -> None:
        """Set the relation to the tangent plane at the pose predicted for the step's end."""
        gap, _ = self.track.contact(float(pose[0]), float(pose[1]))
        _, self.normal = self.track.contact(float(pose[0] + h * velocities[0]), float(pose[1] + h * velocities[1]))
        nx, ny = self.normal
        self.directions[0], self.directions[1] = (nx, ny, 0.0), (ny, -nx, radius)
        self.offset[0] = gap - (nx * pose[0] + ny * pose[1])
        self.relation.setCPtr(self.directions)
        self.relation.setEPtr(self.offset)

    def touch(self, pose) -> plane.PlaneContact | None:
        """The contact in the last step, which began at that pose; None if it did not push."""
        push, rub = (float(impulse) / h for impulse in self.interaction.lambda_(1))
        if push <= 0.0:
            return None
        nx, ny = self.normal
        point = float(pose[0] - radius * nx), float(pose[1] - radius * ny)
        return plane.PlaneContact(point, self.normal, (push * nx + rub * ny, push * ny - rub * nx))

    def creep(self, after) -> float:
        """The slip (m/s), in the plane of the pose that a step reaches, of a contact that sticks in the step's."""
        nx, ny = self.normal
        _, (mx, my) = self.track.contact(float(plate.q()[0]), float(plate.q()[1]))
        return abs(float(after[0] * (ny - my) - after[1] * (nx - mx)))


contacts = [DiscContact(scene["points"]["track"], scene["closed"]["track"], effects)]
contacts += [DiscContact(each["points"], False, each["effects"]) for each in effects.get("Supports", {}).values()]
problem = kernel.FrictionContact(2)
if scene["setting"].get("rung") != "defaults":
    problem.numericsSolverOptions().dparam[0] = scene["setting"].get("tolerance", TOLERANCE)
stepper = kernel.MoreauJeanOSI(scene["setting"].get("theta", 0.5))
# By default a gap of exactly zero counts as open, and the plate would fall for the first step.
stepper.setConstraintActivationThreshold(CLOSED * radius)
simulation = kernel.TimeStepping(model, kernel.TimeDiscretisation(0.0, h), stepper, problem)

pose, touching, slowest, fastest = plate.q().copy(), list[plane.PlaneContact](), 0.0, 0.0


def states() -> list[list[float]]:
    """(x, y, theta, vx, vy, omega) of the plate."""
    return [[*plate.q().tolist(), *plate.velocity().tolist()]]


def step(number: int) -> None:
    """Set the planes, make a step, and note its contacts, the creep (m/s) and the largest velocity (m/s)."""
    global pose, touching, slowest, fastest
    pose, velocities = plate.q().copy(), plate.velocity().copy()
    for contact in contacts:
        contact.set_plane(pose, velocities)
    simulation.computeOneStep()
    touches = [contact.touch(pose) for contact in contacts]
    after = plate.velocity().copy()
    simulation.nextStep()
    slowest = max([slowest, *(one.creep(after) for one, touch in zip(contacts, touches, strict=True) if touch)])
    fastest = max(fastest, hypot(after[0], after[1]) + radius * abs(after[2]))
    touching = [touch for touch in touches if touch]


# Slip follows from pose and velocities, which are at the same time.
plane.write_motion(
    scene, states, step, lambda: touching, lambda: slowest + ROUNDINGS * np.finfo(float).eps * fastest, from_poses=True
)
