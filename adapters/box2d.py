"""box2d (Box2D 3.1 by pyb2d3): a game engine in single precision, with chains of segments and soft contacts.

Route `native`, the engine's own shapes. A round plate is a circle; any other convex plate a fan of polygons, of which
the engine allows eight corners each. A line, and a circle met from outside, are exact; every other track is a chain,
whose inner corners the engine smooths out by itself.

The step is semi-implicit Euler with the contact's direction held from the step's beginning, through all its substeps:
so a rung shortens its steps and takes one substep each; only the engine as it comes has four. A contact is a damped
spring, whose velocity is taken out again after each step; `hertz` is its stiffness, 0.25/h the most the engine takes.

What is small is told in the engine's unit of length: it leaves 0.005 of overlap alone, merges corners that stand off
their neighbours' chord by twice that, lets no facet be shorter. `scale` is how many units a metre is given.

Its fault: the spring looks at the plate's own point of contact, which in a step of rolling rises by r (ω h)²/2. The
plate is let fall towards it, and presses by ½ m r ω ω̇ h too little: where friction just suffices to roll, it slips.

The first transition's time converges with h² until single precision tells: with h = 1e-4 s the rounding of the
positions, over h, lets go of the plate every other step, and transitions are invented. The ladder ends before.

Sources: the Box2D manual ("Simulation") and the comments of its headers types.h and math_functions.h.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from importlib.metadata import version as installed
from math import atan2, cos, sin
from typing import Any

import numpy as np
import pyb2d3

from cases import Case, CoulombFriction, Gravity, Trajectory, Unilateral
from cases.contact import start_motion
from cases.errors import unknown
from cases.shapes import as_circle

from . import _facets as facets
from . import _half_steps as half_steps
from .interface import Setting

NAME = "box2d"
routes = ("native",)

# The engine's numbers are of single precision.
ROUNDING = float(np.finfo(np.float32).eps)
# What this adapter has told the engine how to do; an effect that is not here is refused by its name.
KNOWN_EFFECTS = (Gravity, CoulombFriction, Unilateral)

# Steps in seconds for a case of a few seconds; a longer case has as many steps.
STEPS, USUAL_DURATION = (8e-3, 4e-3, 2e-3, 1e-3, 5e-4, 2e-4), 2.5
# Units to a metre: slop is then 5 µm, less than a thousandth of any plate here, and facets may be a step's way long.
SCALE = 1000.0
# As its manual begins: 60 steps a second of four substeps, metres, and a curve of as many facets as one types in.
DEFAULTS, MODEST = dict(h=1 / 60, substeps=4, scale=1.0), 64
# Of the engine, in its units: what it leaves alone, and how fast it pushes and moves at most.
SLOP, PUSH, SPEED = 0.005, 3.0, 400.0
# Corners a polygon may have; and edges on the rim of one in a fan: its eighth corner is the plate's centre.
MOST_CORNERS, RIM = 8, 6
# With more corners than this the engine merges some, on plates of the usual bends.
FINEST_RIM = 390


def version() -> str:
    """The binding's version; it tells no other."""
    return f"pyb2d3 {installed('pyb2d3')}"


def refuses(case: Case, route: str) -> str | None:
    """Why the route cannot model the case, in one sentence, or None. Raises UnknownName for an unknown route."""
    if route not in routes:
        raise unknown("route of box2d", route, routes)
    strange = [type(effect).__name__ for effect in case.effects if type(effect) not in KNOWN_EFFECTS]
    if strange:
        return f"box2d has nothing for {' and '.join(strange)}."
    friction, outline = case.effect(CoulombFriction), case.plate.outline
    if friction and friction.stick != friction.mu:
        return "box2d has one friction coefficient for slip and stick."
    if not case.effect(Unilateral):
        return "box2d's contacts only push, and this plate is guided from both sides (the case has no Unilateral)."
    if not outline.period or np.any(outline.curvature(np.linspace(*outline.look, 721)) <= 0.0):
        return "box2d's own shapes are circles and convex polygons, and this outline is neither closed nor convex."
    return None


def ladder(case: Case, route: str) -> tuple[Setting, ...]:
    """Settings from coarse to fine: the engine as it comes, then step, stiffness and facets together."""
    stretched = max(1.0, case.duration / USUAL_DURATION)
    steps = [h * stretched for h in STEPS]
    knobs = dict(substeps=1, scale=SCALE)
    return (
        Setting.of(rung="defaults", **DEFAULTS, **_corners(case, None)),
        *(Setting.of(h=h, **knobs, hertz=0.25 / h, **_corners(case, h)) for h in steps),
    )


def _corners(case: Case, h: float | None) -> dict[str, int]:
    """How many facets and corners go with the step h (s): a facet is a step's way at top speed. None: a beginner's."""
    counts: dict[str, int] = {}
    if facets.track_kind(case) == "chain":
        part = facets.stretch(case)
        way = part.top_speed * h if h else 0.0
        counts["facets"] = max(MODEST, round(part.length / way)) if way else MODEST
    if not facets.round_plate(case):
        # 0.2 s over the step is where corners cost as much energy as the step itself; whole polygons of a fan.
        counts["vertices"] = RIM * round(max(0.2 / h, MODEST) / RIM) if h else MOST_CORNERS
        counts["vertices"] = min(counts["vertices"], FINEST_RIM)
    return counts


@dataclass
class Model:
    """One run: the case, its setting, the step (s) and how many; the engine's world and plate, and what was noted."""

    case: Case
    knobs: dict[str, Any]
    h: float
    steps: int
    world: pyb2d3.World
    plate: pyb2d3.Body
    rows: list[tuple[float, ...]] = field(default_factory=list)


def build(case: Case, route: str, setting: Setting) -> Model:
    """A world with the plate at the case's start. The step divides the duration evenly."""
    steps, knobs = max(2, round(case.duration / setting["h"])), dict[str, Any](setting.values)
    h, scale, start = case.duration / steps, setting["scale"], start_motion(case)
    gravity = scale * facets.pull(case)
    world = pyb2d3.World(gravity=_pair(gravity), maximum_linear_speed=SPEED * scale)
    if "hertz" in knobs:
        world.set_contact_tuning(knobs["hertz"], 10.0, PUSH * scale)
        world.sleeping_enabled = False
    friction = case.effect(CoulombFriction)
    # The engine takes the root of the product of both shapes' coefficients.
    material = pyb2d3.surface_material(friction=friction.mu if friction else 0.0)
    _add_track(case, world.create_static_body(), material, scale, knobs.get("facets", 1))
    place = scale * start.x, scale * start.y
    plate = world.create_dynamic_body(position=place, rotation=_rotation(start.theta))
    _add_plate(case, plate, material, scale, knobs.get("vertices", 0))
    mass = pyb2d3.MassData()
    mass.mass, mass.center, mass.rotational_inertia = case.plate.mass, (0.0, 0.0), case.plate.inertia * scale**2
    plate.mass_data = mass
    plate.linear_velocity, plate.angular_velocity = (scale * start.vx, scale * start.vy), start.omega
    return Model(case, knobs, h, steps, world, plate)


def _pair(values) -> tuple[float, float]:
    return float(values[0]), float(values[1])


def _rotation(angle: float) -> pyb2d3.Rot:
    """The engine's own make_rot is fast and off by up to 1.6e-3 rad."""
    turned = pyb2d3.Rot()
    turned.c, turned.s = cos(angle), sin(angle)
    return turned


def _angle(body: pyb2d3.Body) -> float:
    """The engine's own angle is fast and off by up to 2.7e-5 rad."""
    turned = body.rotation
    return atan2(turned.s, turned.c)


def _add_track(case: Case, body: pyb2d3.Body, material: pyb2d3.SurfaceMaterial, scale: float, count: int) -> None:
    circle, kind = as_circle(case.track), facets.track_kind(case)
    if kind == "hill" and circle:
        shape = pyb2d3.circle(_pair(scale * circle.centre), scale * circle.radius)
        body.create_shape(pyb2d3.shape_def(material=material), shape)
        return
    corners = facets.chain(case, count)
    closed = kind == "chain" and facets.stretch(case).closed
    if closed:
        corners = corners[:, :-1]
    else:
        # The first and last edges of an open chain only guide their neighbours.
        corners = np.column_stack([2 * corners[:, 0] - corners[:, 1], corners, 2 * corners[:, -1] - corners[:, -2]])
    # The engine's chains push to their right, ours has the plate on its left.
    body.create_chain(pyb2d3.chain_def(points=scale * corners.T[::-1], material=material, is_loop=closed))


def _add_plate(case: Case, body: pyb2d3.Body, material: pyb2d3.SurfaceMaterial, scale: float, count: int) -> None:
    define = pyb2d3.shape_def(material=material)
    circle = facets.round_plate(case)
    if circle:
        body.create_shape(define, pyb2d3.circle(_pair(scale * circle.centre), scale * circle.radius))
        return
    rim = scale * facets.polygon(case, count).T
    if count == MOST_CORNERS:
        body.create_shape(define, pyb2d3.polygon(points=rim))
        return
    for first in range(0, count, RIM):
        part = rim[np.arange(first, first + RIM + 1) % count]
        body.create_shape(define, pyb2d3.polygon(points=np.vstack([np.zeros(2), part])))


def run(model: Model) -> None:
    """Step through the duration, noting poses and the velocities after the next step, in the engine's units."""
    h, step, plate, note, substeps = model.h, model.world.step, model.plate, model.rows.append, model.knobs["substeps"]
    rest = half_steps.rest(substeps) * h
    for k in range(model.steps + 1):
        (x, y), angle = plate.position, _angle(plate)
        step(h if k else h - rest, substeps)
        (vx, vy), omega = plate.linear_velocity, plate.angular_velocity
        note((x, y, angle, vx, vy, omega))
        if k == 0:
            # The engine accelerates first, then moves: the acceleration is half a substep short, the way is whole.
            (x, y), angle = plate.position, _angle(plate)
            plate.set_transform((x + rest * vx, y + rest * vy), _rotation(angle + rest * omega))


def read(model: Model) -> Trajectory:
    """The motion at the poses' times, cut where the plate left its track. Raises EngineFailure if it is no motion."""
    case, knobs, scale = model.case, model.knobs, model.knobs["scale"]
    rows = np.array(model.rows) / np.array([scale, scale, 1.0, scale, scale, 1.0])
    # The engine's angle forgets whole turns.
    theta = np.unwrap(rows[:, 2])
    rows[:, 2] = theta + 2 * np.pi * np.round((start_motion(case).theta - theta[0]) / (2 * np.pi))
    rough = facets.sagitta(case, knobs.get("facets"), knobs.get("vertices")) + SLOP / scale
    engine: dict[str, Any] = dict(rough=rough, lever=0.5, rounding=ROUNDING, rest=half_steps.rest(knobs["substeps"]))
    return half_steps.read(half_steps.Noted(case, model.h, model.steps, rows, **engine))
