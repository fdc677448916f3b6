"""pybullet (Bullet 3, double precision): a sphere on a plane that is moved to the track's tangent before every step.

Bullet has no smooth concave shapes, but an exact contact of a sphere with a plane. So the route is `assisted`: the
suite computes the tangent; inertia, friction cone, stick and normal force are Bullet's. The step is semi-implicit Euler
on velocities with speculative contact: with erp = 1 the sphere touches the plane at the end of a step. The plane is
therefore moved, by the chord's sagitta, to where the sphere will touch the track then; its direction is that of the
step's beginning. Positions are at k·h, velocities at (k+½)·h, because the first step accelerates for half its time.

Source of the parameters: the PyBullet Quickstart Guide, `changeDynamics` and `setPhysicsEngineParameter`.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import atan2, cos, sin

import numpy as np
import pybullet

from cases import Belt, Case, CoulombFriction, Drive, Gravity, Impact, RollingResistance, Trajectory, Unilateral
from cases.contact import Contact, find, start_motion
from cases.errors import unknown_name
from cases.motion.mechanics import gravity

from .common import half_steps
from .common.flights import BEYOND
from .interface import Meaning, Refusal, Setting

NAME = "pybullet"
routes = ("assisted",)
KNOWN = "pybullet>=3.2.5"

# The effects that this adapter implements; all others are reported as unsupported, by name.
KNOWN_EFFECTS = (Gravity, CoulombFriction, RollingResistance, Unilateral)

MEANINGS = (
    Meaning(
        CoulombFriction,
        "lateralFriction of both bodies, multiplied; here mu and 1",
        "Coulomb's cone for the impulses of a step, one coefficient for slip and stick; mu(v) is not supported",
    ),
    Meaning(Impact, "restitution; this adapter does not set it", "not supported"),
    Meaning(Belt, "none", "not supported"),
    Meaning(Drive, "none", "not supported"),
    Meaning(
        RollingResistance,
        "rollingFriction of each body times lateralFriction of the other one, added; here the arm (m) and 1, and 0",
        "a couple of at most that times the normal impulse",
    ),
)

# Steps in seconds for a case of a few seconds; a longer case has as many steps.
STEPS, USUAL_DURATION = (4e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4), 2.5
# The engine's defaults: 240 steps a second, a fifth of the overlap beyond the slop (m) corrected in each, iterations up
# to a residual, both dampings in 1/s.
DEFAULTS = Setting.of(rung="defaults", h=1 / 240, erp=0.2, slop=1e-5, residual=1e-7, damping=0.04)


def version() -> str:
    """The engine's API version, a release date; the package reports no other version."""
    return str(pybullet.getAPIVersion())


def refuses(case: Case, route: str) -> str | None:
    """Why the route cannot model the case, in one sentence, or None. Raises UnknownName for an unknown route."""
    if route not in routes:
        raise unknown_name("route of pybullet", route, routes)
    missing = [type(effect).__name__ for effect in case.effects if type(effect) not in KNOWN_EFFECTS]
    if {"Flight", "Impact"} & {*missing}:
        return f"pybullet's plane is at the contact point, so this route does not support {' and '.join(missing)}."
    if missing:
        return f"This adapter does not support {' and '.join(missing)}."
    if not case.plate.turns:
        return "This adapter gives pybullet's bodies a finite inertia, and this plate does not turn."
    friction = case.effect(CoulombFriction)
    if friction and friction.by_speed:
        return Refusal(
            "pybullet's bodies have one friction coefficient for all slip velocities.",
            "lateralFriction of changeDynamics is one number",
        )
    if friction and friction.stick != friction.mu:
        return Refusal(
            "pybullet has one friction coefficient for slip and stick.",
            "lateralFriction of changeDynamics is one number",
        )
    if not case.effect(Unilateral):
        return "pybullet's contacts only push, and this case has a bilateral guide (no Unilateral)."
    if case.plate.radius is None:
        return (
            "pybullet's exact contact with a plane is for spheres; this outline is no circle about its centre of mass."
        )
    return None


def ladder(case: Case, route: str) -> tuple[Setting, ...]:
    """Settings from coarse to fine: the engine's defaults, then finer steps without damping and overlap."""
    stretch = max(1.0, case.duration / USUAL_DURATION)
    return (DEFAULTS, *(Setting.of(h=h * stretch, erp=1.0, slop=0.0, residual=0.0, damping=0.0) for h in STEPS))


def default_grid(case: Case, route: str) -> tuple[Setting, ...]:
    """The default settings with usual steps."""
    return DEFAULTS.combinations(h=(1 / 240, 1 / 120, 1 / 60))


@dataclass
class PybulletModel:
    """One run: the case, the step (s) and number of steps, the engine's object numbers, and the recorded rows."""

    case: Case
    h: float
    steps: int
    world: int
    plate: int
    plane: int
    rows: list[tuple[float, ...]] = field(default_factory=list)
    contacts: list[Contact] = field(default_factory=list)


def build(case: Case, route: str, setting: Setting) -> PybulletModel:
    """A world with the sphere at the case's start. The step divides the duration evenly."""
    assert case.plate.radius is not None, "refuses() accepts only discs"
    steps = max(2, round(case.duration / setting["h"]))
    h, start, friction = case.duration / steps, start_motion(case), case.effect(CoulombFriction)
    world = pybullet.connect(pybullet.DIRECT)
    where = dict(physicsClientId=world)
    pybullet.setGravity(*gravity(case), 0.0, **where)
    knobs = dict(contactERP=setting["erp"], contactSlop=setting["slop"], solverResidualThreshold=setting["residual"])
    pybullet.setPhysicsEngineParameter(**knobs, **where)
    sphere = pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=case.plate.radius, **where)
    ground = pybullet.createCollisionShape(pybullet.GEOM_PLANE, planeNormal=[0.0, 1.0, 0.0], **where)
    plane = pybullet.createMultiBody(0.0, ground, **where)
    # Not with useMaximalCoordinates: a user-defined inertia then gives NaN from the first step on.
    plate = pybullet.createMultiBody(case.plate.mass, sphere, basePosition=[start.x, start.y, 0.0], **where)
    # The engine multiplies the two bodies' coefficients.
    pybullet.changeDynamics(plane, -1, lateralFriction=1.0, **where)
    damping = dict(linearDamping=setting["damping"], angularDamping=setting["damping"])
    inertia, mu = [case.plate.inertia] * 3, friction.mu if friction else 0.0
    resistance = case.effect(RollingResistance)
    rubbing = dict(lateralFriction=mu, rollingFriction=resistance.arm if resistance else 0.0)
    pybullet.changeDynamics(plate, -1, localInertiaDiagonal=inertia, **rubbing, **damping, **where)
    pybullet.resetBaseVelocity(plate, [start.vx, start.vy, 0.0], [0.0, 0.0, start.omega], **where)
    return PybulletModel(case, h, steps, world, plate, plane)


def run(model: PybulletModel) -> None:
    """Step through the duration, with the plane moved before each step; stop where no track is near."""
    where = dict(physicsClientId=model.world)
    try:
        _step(model, where)
    finally:
        pybullet.disconnect(**where)


def _step(model: PybulletModel, where: dict[str, int]) -> None:
    case, h, start = model.case, model.h, start_motion(model.case)
    # The engine's quaternion has no whole turns; the angle is the sum of its steps. A sphere needs nothing else.
    centre, theta, near = np.array([start.x, start.y]), start.theta, (start.xi1, start.xi2)
    now, change = np.array([start.vx, start.vy]), 0.5 * h * gravity(case)
    for k in range(model.steps + 1):
        try:
            near = _add_plane(model, centre, theta, now + change, 1.0 if k else 0.5, near, where)
        except BEYOND:
            return
        pybullet.setTimeStep(h if k else 0.5 * h, **where)
        pybullet.stepSimulation(**where)
        (vx, vy, _), (_, _, omega) = pybullet.getBaseVelocity(model.plate, **where)
        model.rows.append((*centre.tolist(), theta, vx, vy, omega))
        before, now = now, np.array([vx, vy])
        # The forces of a step are nearly those of the previous one; the first lasts half a step.
        change = (1.0 if k else 2.0) * (now - before)
        theta += h * omega
        if k == 0:
            # The acceleration of half a step, the displacement of a whole step.
            position = [*(centre + h * now).tolist(), 0.0]
            pybullet.resetBasePositionAndOrientation(model.plate, position, [0.0, 0.0, 0.0, 1.0], **where)
            pybullet.resetBaseVelocity(model.plate, [vx, vy, 0.0], [0.0, 0.0, omega], **where)
        centre = np.array(pybullet.getBasePositionAndOrientation(model.plate, **where)[0][:2])


def _add_plane(model: PybulletModel, centre, theta: float, velocity, share: float, near, where) -> tuple[float, float]:
    """Place the plane so that a step with about that velocity ends on the track; `share`: the part that is stepped."""
    case, (x, y), (way_x, way_y) = model.case, centre.tolist(), (model.h * velocity).tolist()
    here = find(case, x, y, theta, near)
    ahead = find(case, x + way_x, y + way_y, theta, here[:2])
    model.contacts.append(here)
    normal = case.track.normal(here.xi1)
    rise = share * (way_x * normal[0] + way_y * normal[1] - ahead.gap)
    touch = centre + normal * (rise - (case.plate.radius or 0.0))
    half = 0.5 * atan2(-normal[0], normal[1])
    turn = [0.0, 0.0, sin(half), cos(half)]
    pybullet.resetBasePositionAndOrientation(model.plane, [*touch.tolist(), 0.0], turn, **where)
    return here[:2]


def read(model: PybulletModel) -> Trajectory:
    """The motion at the poses' times, cut where the plate left its track. Raises EngineFailure if it is no motion."""
    return half_steps.read(
        half_steps.StepRecord(model.case, model.h, model.steps, np.array(model.rows), model.contacts)
    )
