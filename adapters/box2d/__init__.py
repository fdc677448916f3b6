"""box2d (Box2D 3.1 by pyb2d3): a game engine in single precision, with chains of segments and soft contacts.

Route `native`, the engine's own shapes. A round plate is a circle; a convex plate a fan of polygons, of which the
engine allows eight corners each; any other outline that is entirely visible from the centre of mass, closed or open, a
fan of triangles. A line, and a circle touched from outside, are exact; every other track is a chain, whose inner
corners the engine smooths by itself.

The step is semi-implicit Euler; the contact's direction is that of the step's beginning in all substeps. So a rung has
shorter steps of one substep each; only the default setting has four. A contact is a damped spring, whose velocity is
removed after each step; `hertz` is its stiffness, at most 0.25/h in the engine.

Small lengths are fixed in the engine's unit: it does not correct 0.005 of overlap, merges corners closer than twice
that to their neighbours' chord, and allows no shorter facet. `scale` is the number of units per metre.

A known error: the spring follows the plate's material contact point, which in a step of rolling rises by r (ω h)²/2.
The plate then falls towards it, and the normal force is too small by ½ m r ω ω̇ h: where friction only just suffices
to roll, the plate slips.

The first transition's time converges with h² down to single precision. Positions of 1 m are rounded to 1.2e-7 m, and
over h² this is 0.14 of the weight at h = 3e-4 s, 0.3 of it at 2e-4 s. At 2e-4 s the contact opens in a tenth of all
steps, and spurious transitions appear. The ladder ends at the last step at which rounding adds less to the scatter of
the forces than the facets, whose part is the same with every step: of the differences of consecutive normal forces of
the disc in a circle, 95 % are below 12 N from 8e-3 to 5e-4 s, 14 N at 3e-4 s, 24 N at 2e-4 s.

Sources: the Box2D manual ("Simulation") and the comments of its headers types.h and math_functions.h.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from importlib.metadata import version as package_version
from typing import Any

import numpy as np
import pyb2d3

from cases import (
    Belt,
    Case,
    CoulombFriction,
    Drive,
    Flight,
    Gravity,
    Impact,
    PerfectlyRough,
    RollingResistance,
    Trajectory,
    Unilateral,
)
from cases.errors import unknown_name
from cases.motion.mechanics import gravity
from cases.scene.contact_pairs import pairs
from cases.scene.free_plates import plates_of

from ..common import driven_tracks, facets, half_steps, several_contacts
from ..common.impacts import has_friction, not_moreaus, plates_touch
from ..common.starts import starts_of
from ..interface import Meaning, Refusal, Setting
from . import shapes

NAME = "box2d"
routes = ("native",)
# Tested: every version on the index, 0.5.3 to 0.11.1.
KNOWN = "pyb2d3>=0.5"
CAPABILITIES = {
    "native": (
        "corners", "several contacts", "supports", "belts and supports", "driven contacts",
        "several plates", "free polygons", "any shape",
    ),
}  # fmt: skip


# The engine's numbers are of single precision.
ROUNDING = float(np.finfo(np.float32).eps)
# The effects that this adapter implements; all others are reported as unsupported, by name.
KNOWN_EFFECTS = (Gravity, CoulombFriction, PerfectlyRough, RollingResistance, Unilateral, Flight, Impact, Belt, Drive)


# Steps in seconds for a case of a few seconds; a longer case has as many steps. With shorter ones rounding dominates.
STEPS, USUAL_DURATION = (8e-3, 4e-3, 2e-3, 1e-3, 5e-4, 3e-4), 2.5
# The grid's steps, and stiffnesses that the engine allows at the longest of them, its default among them.
GRID_STEPS, GRID_HERTZ = (4e-3, 2e-3, 1e-3, 5e-4), (15.0, 30.0, 62.5)
# Units per metre: slop is then 5 µm, less than a thousandth of any plate here, and facets may be as short as a step's
# displacement.
SCALE = 1000.0
# The defaults of its manual: 60 steps a second of four substeps, and metres.
DEFAULTS = dict(h=1 / 60, substeps=4, scale=1.0)
# The engine's limits, in its units: uncorrected overlap, and largest speed of correction and of motion.
SLOP, PUSH, SPEED = 0.005, 3.0, 400.0

# Of include/box2d/types.h; the function that mixes those of two shapes (b2FrictionCallback) is not given a speed.
ONE_FRICTION = "b2SurfaceMaterial.friction is one number"


def _differs(case: Case) -> bool:
    impact = case.effect(Impact)
    own = has_friction(case) or not case.plate.radius or plates_touch(case)
    return not_moreaus(case) or bool(impact and impact.restitution and own)


MEANINGS = (
    Meaning(
        CoulombFriction,
        "friction, the geometric mean of both shapes' values; here mu and mu, with supports 1 and mu^2, of free plates "
        "mu and mu_support^2/mu",
        "Coulomb's cone for the impulses of a substep, one coefficient for slip and stick; mu(v) is not supported",
    ),
    Meaning(PerfectlyRough, "friction", "Coulomb's cone with a coefficient of 1e6"),
    Meaning(
        Impact,
        "restitution, the larger of both shapes' values; none below restitution_threshold (default 1 m/s)",
        "friction bounded by the impulse of compression, then Newton's restitution without friction (measured on "
        "circles; polygons deviate more); through discs that touch contact by contact (1 m/s becomes -0.12, 0.24, "
        "0.88)",
        differs=_differs,
        duration="compression in one substep, restitution at the end of the step",
    ),
    Meaning(
        RollingResistance,
        "rolling_resistance, the larger of both shapes' values, times the circle's radius; here arm/r",
        "a couple of at most this lever arm times the normal impulse; circles only",
    ),
    Meaning(
        Belt,
        "tangent_speed of the track's shapes; where the speed changes with time, a line or circle on a kinematic body",
        "Coulomb's law for the slip on that surface; a kinematic body moves with the speed in the middle of each step",
    ),
    Meaning(
        Drive,
        "a kinematic body, its place and velocities set in each step",
        "the track is where it is at the beginning of each step",
    ),
)


def version() -> str:
    """The binding's version; it reports no other."""
    return f"pyb2d3 {package_version('pyb2d3')}"


def refuses(case: Case, route: str) -> str | None:
    """Why the route cannot model the case, in one sentence, or None. Raises UnknownName for an unknown route."""
    if route not in routes:
        raise unknown_name("route of box2d", route, routes)
    missing = [type(effect).__name__ for effect in case.effects if type(effect) not in KNOWN_EFFECTS]
    if missing:
        return f"This adapter does not support {' and '.join(missing)}."
    friction, outline = case.effect(CoulombFriction), case.plate.outline
    if friction and friction.by_speed:
        return Refusal(
            "Box2D's shapes have one friction coefficient for all slip velocities.",
            ONE_FRICTION,
        )
    if friction and friction.stick != friction.mu:
        return Refusal("box2d has one friction coefficient for slip and stick.", ONE_FRICTION)
    if not case.effect(Unilateral):
        return "box2d's contacts only push, and this case has a bilateral guide (no Unilateral)."
    if facets.has_hollow_corners(outline):
        return "box2d's shapes are convex, and this outline has corners that point inwards."
    if not shapes.is_one_polygon(outline) and not facets.sees_all(outline):
        return "box2d's shapes are convex, and no fan of them gives this outline: its centre does not see all of it."
    belt, belts = case.effect(Belt), [pair.effect(Belt) for pair in pairs(case)] if case.supports else []
    if any(one and one.constant is None for one in belts):
        return "box2d's shapes keep the tangent speed that they are made with, and a belt here has another speed later."
    if belt and belt.constant is None and case.effect(Drive):
        return "box2d's kinematic bodies carry a belt whose speed changes with time, or a driven track, not both."
    if belt and belt.constant is None and not shapes.moves_itself(case):
        return (
            "box2d's shapes keep the tangent speed that they are made with, and this belt's speed changes with time; "
            "only lines and circles can move along themselves instead."
        )
    if case.effect(RollingResistance) and not facets.round_plate(case):
        return Refusal(
            "box2d has RollingResistance for circles only, and this outline is none.",
            "rollingResistance is a multiple of the shape's radius, and that of a polygon with sharp corners is 0",
        )
    if case.others and (problem := shapes.refuses_plates(case)):
        return problem
    if any(own != whole for own, whole in shapes.restitutions(case)):
        return "box2d takes the larger restitution of both shapes, and a support here has its own."
    return driven_tracks.refuses(case)


def refuses_several_contacts(case: Case, route: str) -> str | None:
    """Why the route does not report several contacts of this case, in one sentence, or None."""
    return several_contacts.refuses(case)


def ladder(case: Case, route: str) -> tuple[Setting, ...]:
    """Settings from coarse to fine: the engine's defaults, then step, stiffness and facets refined together."""
    stretch = max(1.0, case.duration / USUAL_DURATION)
    steps = [h * stretch for h in STEPS]
    knobs = dict(substeps=1, scale=SCALE)
    return (
        Setting.of(rung="defaults", **DEFAULTS, **shapes.corners(case, None)),
        *(Setting.of(h=h, **knobs, hertz=0.25 / h, **shapes.corners(case, h)) for h in steps),
    )


def default_grid(case: Case, route: str) -> tuple[Setting, ...]:
    """The default settings with usual steps and numbers of facets."""
    return ladder(case, route)[0].combinations(h=(1 / 60, 1 / 120), facets=(32, 64, 128))


def grid(case: Case, route: str) -> tuple[Setting, ...]:
    """Combinations of step and model: facets and corners, or without any the contact's stiffness."""
    models = [shapes.corners(case, h) for h in GRID_STEPS]
    if any(models):
        knobs: list[dict[str, Any]] = [dict(hertz=GRID_HERTZ[-1], **model) for model in models]
    else:
        knobs = [dict(hertz=hertz) for hertz in GRID_HERTZ]
    return tuple(Setting.of(h=h, substeps=1, scale=SCALE, **knob) for h in GRID_STEPS for knob in knobs)


@dataclass
class Box2dModel:
    """One run: the case, its setting, the step (s), the number of steps, the engine's world and plates, and the rows of
    each plate."""

    case: Case
    knobs: dict[str, Any]
    h: float
    steps: int
    world: pyb2d3.World
    plates: list[pyb2d3.Body]
    track: pyb2d3.Body
    rows: list[tuple[float, ...]] = field(default_factory=list)


def build(case: Case, route: str, setting: Setting) -> Box2dModel:
    """A world with the plate at the case's start. The step divides the duration evenly."""
    steps, knobs = max(2, round(case.duration / setting["h"])), dict[str, Any](setting)
    h, scale = case.duration / steps, setting["scale"]
    pull = scale * gravity(case)
    world = pyb2d3.World(gravity=(float(pull[0]), float(pull[1])), maximum_linear_speed=SPEED * scale)
    if "hertz" in knobs:
        world.set_contact_tuning(knobs["hertz"], 10.0, PUSH * scale)
        world.sleeping_enabled = False
    impact = case.effect(Impact)
    if impact and "hertz" in knobs:
        # The steps cannot resolve a rebound slower than the velocity that gravity gives in a step.
        world.restitution_threshold = float(np.hypot(*pull)) * h
    material = shapes.plate_material(case)
    track = shapes.track_body(case, world, scale)
    shapes.add_fixed(case, track, scale, knobs.get("facets", 1))
    plates = []
    for plate, (x, y, theta, vx, vy, omega) in zip(plates_of(case), starts_of(case).tolist(), strict=True):
        body = world.create_dynamic_body(position=(scale * x, scale * y), rotation=shapes.rotation(theta))
        shapes.add_plate(case, plate, body, material, scale, knobs.get("vertices", 1))
        mass = pyb2d3.MassData()
        mass.mass, mass.center, mass.rotational_inertia = plate.mass, (0.0, 0.0), 0.0
        if plate.turns:  # for the engine no inertia is an infinite one
            mass.rotational_inertia = plate.inertia * scale**2
        body.mass_data = mass
        body.linear_velocity, body.angular_velocity = (scale * vx, scale * vy), omega
        plates.append(body)
    return Box2dModel(case, knobs, h, steps, world, plates, track)


def run(model: Box2dModel) -> None:
    """Step through the duration and record poses and the velocities after the next step, in the engine's units."""
    h, step, plates, note, substeps = (
        model.h,
        model.world.step,
        model.plates,
        model.rows.append,
        model.knobs["substeps"],
    )
    rest = half_steps.rest(substeps) * h
    follow = shapes.track_follower(model.case, model.track, h, model.knobs["scale"])
    for k in range(model.steps + 1):
        poses = [(*plate.position, shapes.angle(plate)) for plate in plates]
        follow(k)
        step(h if k else h - rest, substeps)
        for pose, plate in zip(poses, plates, strict=True):
            (vx, vy), omega = plate.linear_velocity, plate.angular_velocity
            note((*pose, vx, vy, omega))
            if k == 0:
                # The engine accelerates first, then moves: half a substep of acceleration is missing, no displacement.
                (x, y), angle = plate.position, shapes.angle(plate)
                plate.set_transform((x + rest * vx, y + rest * vy), shapes.rotation(angle + rest * omega))


def read(model: Box2dModel) -> Trajectory:
    """The motion at the poses' times, cut where the plate left its track. Raises EngineFailure if it is no motion."""
    case, knobs, scale = model.case, model.knobs, model.knobs["scale"]
    rows = np.array(model.rows).reshape(-1, len(model.plates), 6) / np.array([scale, scale, 1.0, scale, scale, 1.0])
    # The engine's angle has no whole turns.
    theta = np.unwrap(rows[..., 2], axis=0)
    rows[..., 2] = theta + 2 * np.pi * np.round((starts_of(case)[:, 2] - theta[0]) / (2 * np.pi))
    rough = facets.sagitta(case, knobs.get("facets"), knobs.get("vertices")) + SLOP / scale
    engine: dict[str, Any] = dict(rough=rough, lever=0.5, rounding=ROUNDING, rest=half_steps.rest(knobs["substeps"]))
    rows = rows if case.others else rows[:, 0]
    return half_steps.read(half_steps.StepRecord(case, model.h, model.steps, rows, **engine))
