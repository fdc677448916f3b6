"""box2d (Box2D 3.1 by pyb2d3, single precision): a game engine with chains of segments and soft contacts.

The engine has circles, polygons of up to eight corners and chains of segments without inner edges. So the route is
`native`: a line and a circle met from outside are exact, every other track is a chain; a disc is a circle.
Its step is semi-implicit Euler with contact directions that stay those of the step's beginning, also for its
substeps: a rung's steps are therefore not divided, except for the engine as it comes.

What it takes for small is in its own length unit: 5 mm of overlap left alone (its slop) where a unit is a metre, and no
facet shorter than that. `scale` is how many of its units the scene's metre is given.

Source of the parameters: the Box2D manual, "Simulation", and the comments of its header types.h.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from importlib.metadata import version as installed

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

KNOWN_EFFECTS = (Gravity, CoulombFriction, Unilateral)

# Steps in seconds for a case of a few seconds; a longer case has as many steps.
STEPS, USUAL_DURATION = (8e-3,4e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4), 2.5


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
    friction = case.effect(CoulombFriction)
    if friction and friction.stick != friction.mu:
        return "box2d has one friction coefficient for slip and stick."
    if not case.effect(Unilateral):
        return "box2d's contacts only push, and this plate is guided from both sides (the case has no Unilateral)."
    if case.plate.radius is None:
        return "box2d's only smooth plate is a circle about its centre, and this outline is none."
    return None
import os
DAMP=float(os.environ.get('DAMP','10')); SCALE=float(os.environ.get('SCALE','100')); SUB=int(os.environ.get('SUB','1')); HZ=float(os.environ.get('HZ','.25')); FAC=float(os.environ.get('FAC','1'))

def ladder(case: Case, route: str) -> tuple[Setting, ...]:
    stretched = max(1.0, case.duration / USUAL_DURATION)
    fine = [h * stretched for h in STEPS]
    return (
        Setting.of(rung="defaults", h=1 / 60, substeps=4, scale=1.0, **_facets(case, None)),
        *(Setting.of(h=h, substeps=SUB, scale=SCALE, hertz=HZ / h, damping=DAMP, **_facets(case, h)) for h in fine),
    )


def _facets(case: Case, h: float | None) -> dict[str, int]:
    if facets.track_kind(case) != "chain":
        return {}
    part = facets.stretch(case)
    way = part.top_speed * h*FAC if h else 0.0
    return {"facets": max(64, round(part.length / way)) if way else 64}


@dataclass
class Model:
    case: Case
    h: float
    steps: int
    setting: Setting
    world: pyb2d3.World
    body: pyb2d3.Body
    rows: list[tuple[float, ...]] = field(default_factory=list)


def build(case: Case, route: str, setting: Setting) -> Model:
    steps = max(2, round(case.duration / setting["h"]))
    h, scale, start, knobs = case.duration / steps, setting["scale"], start_motion(case), dict(setting.values)
    gx, gy = scale * facets.pull(case)
    world = pyb2d3.World(gravity=(gx, gy), maximum_linear_speed=400*scale)
    if "hertz" in knobs:
        world.set_contact_tuning(knobs["hertz"], knobs["damping"], 3.0 * scale)
        world.sleeping_enabled = False
    friction = case.effect(CoulombFriction)
    material = pyb2d3.surface_material(friction=friction.mu if friction else 0.0)
    shape_def = pyb2d3.shape_def(material=material)
    track = world.create_static_body()
    if facets.track_kind(case) == "hill":
        circle = as_circle(case.track)
        track.create_shape(shape_def, pyb2d3.circle(tuple(map(float, scale*circle.centre)), scale * circle.radius))
    else:
        corners = facets.chain(case, knobs.get("facets", 1))
        closed = facets.track_kind(case) == "chain" and facets.stretch(case).closed
        if closed:
            corners = corners[:, :-1]
        else:
            corners = np.column_stack([2*corners[:,0]-corners[:,1], corners, 2*corners[:,-1]-corners[:,-2]])
        # right
        track.create_chain(pyb2d3.chain_def(points=scale*corners.T[::-1], material=material, is_loop=closed))
    back = 0.5*h
    body = world.create_dynamic_body(position=(scale * (start.x-back*start.vx), scale * (start.y-back*start.vy)), rotation=pyb2d3.make_rot(start.theta-back*start.omega))
    body.create_shape(shape_def, pyb2d3.circle(radius=scale * case.plate.radius))
    mass = pyb2d3.MassData()
    mass.mass, mass.center, mass.rotational_inertia = case.plate.mass, (0.0, 0.0), case.plate.inertia * scale**2
    body.mass_data = mass
    body.linear_velocity = scale * start.vx, scale * start.vy
    body.angular_velocity = start.omega
    return Model(case, h, steps, setting, world, body)


def run(model: Model) -> None:
    step, note, body, substeps, scale = model.world.step, model.rows.append, model.body, model.setting["substeps"], model.setting["scale"]
    for k in range(model.steps+1):
        step(model.h if k else 0.5 * model.h, substeps)
        (x, y), (vx, vy) = body.position, body.linear_velocity
        note((x/scale, y/scale, body.angle, vx/scale, vy/scale, body.angular_velocity))


def read(model: Model) -> Trajectory:
    rows = np.array(model.rows)
    rows[:,2] = np.unwrap(rows[:,2])
    start = start_motion(model.case)
    rows[:,2] += 2*np.pi*np.round((start.theta-rows[0,2])/(2*np.pi))
    knobs = dict(model.setting.values)
    return half_steps.read(half_steps.Noted(model.case, model.h, model.steps, rows, rough=facets.sagitta(model.case, knobs.get("facets"), None)+0.005/model.setting["scale"], lever=0.5, rounding=float(np.finfo(np.float32).eps)))
