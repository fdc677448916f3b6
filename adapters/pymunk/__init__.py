"""pymunk (Chipmunk/Munk2D): a game engine's semi-implicit Euler step with Coulomb friction as clamped impulses.

Positions are at k·h and velocities at (k+½)·h, if the first step is a half one (start moved back by v₀·h/2, then
`step(h/2)`): `common.half_steps` reads them.

Routes: `native` (the engine's circles, segments and polygons; order 1), `assisted` (the adapter sets the exact contact
point, normal and the normal velocity that follows the curve; inertia, cone, stick and normal force are the engine's;
order 2).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np
import pymunk
from pymunk._chipmunk_cffi import lib

from cases import (
    Belt,
    Case,
    CoulombFriction,
    Curve,
    Drive,
    Flight,
    Gravity,
    Impact,
    Load,
    PerfectlyRough,
    RollingResistance,
    Trajectory,
    Unilateral,
)
from cases.curves.line_or_circle import as_line
from cases.moving_frame import relative_case
from cases.scene.couples import couples
from cases.scene.free_plates import plates_of
from cases.scene.supports import has_rolling_resistance

from ..common import driven_tracks, facets, half_steps, several_contacts
from ..common.impacts import MOREAU, not_moreaus
from ..interface import EngineFailure, Meaning, Refusal, Setting
from . import assisted, native, older_versions
from .load import LoadInSteps, loads_in_steps

NAME = "pymunk"
routes = ("native", "assisted")
# Tested: every version that has a wheel for CPython 3.11, from 6.3.0, by `older_versions`.
KNOWN = "pymunk>=6.0"
CAPABILITIES = {
    "native": ("every scene",),
    "assisted": ("slip laws",),
}

# The effects that this adapter implements; all others are reported as unsupported, by name.
KNOWN_EFFECTS = (Gravity, Load, CoulombFriction, PerfectlyRough, Unilateral, Flight, Impact, Belt, Drive)


# How the engine interprets its parameters; the laws are as measured in `tests/adapters/test_impact_laws.py`.
MEANINGS = (
    Meaning(
        CoulombFriction,
        "friction of both shapes, multiplied; here mu and 1, with supports 1 and mu, of free plates the root of mu "
        "each; that of a support or a pair, and mu(v), are friction of the contact, set in each step",
        "Coulomb's cone for the impulses of a step, one coefficient for slip and stick; mu(v) at the slip velocity "
        "predicted for its middle",
        routes=("native",),
    ),
    Meaning(
        CoulombFriction,
        "friction of both shapes, multiplied; here mu and 1; mu(v) is friction of the contact, set in each step",
        "Coulomb's cone for the impulses of a step, with mu at the slip velocity predicted for its middle",
        routes=("assisted",),
    ),
    Meaning(PerfectlyRough, "friction", "Coulomb's cone with a coefficient of 1e9"),
    Meaning(
        Impact,
        "elasticity of both shapes, multiplied; here e and 1, of free plates the root of e each",
        MOREAU,
        routes=("native",),
        differs=not_moreaus,
        duration="one step",
    ),
    Meaning(
        Impact,
        "none: a contact that the adapter sets closes without restitution",
        f"{MOREAU}, e = 0",
        routes=("assisted",),
        differs=not_moreaus,
        duration="one step",
    ),
    Meaning(RollingResistance, "none", "not supported"),
    Meaning(
        Belt,
        "surface_velocity of the segments; of each contact where the speed changes with time, on a hill, or on a "
        "track that turns",
        "Coulomb's law for the slip on that surface, its speed in the middle of each step",
        routes=("native",),
    ),
    Meaning(
        Belt,
        "surface_velocity of the contact",
        "Coulomb's law for the slip on that surface, its speed in the middle of each step",
        routes=("assisted",),
    ),
    Meaning(
        Drive,
        "a kinematic body, its velocities set in each step by velocity_func",
        "the track is where it is at the beginning of each step",
        routes=("native",),
    ),
    Meaning(
        Drive,
        "none: the engine computes in the frame of the track",
        "the loads of the track's motion on the plate",
        routes=("assisted",),
    ),
)


def version() -> str:
    """pymunk's version and that of the Chipmunk library in it."""
    return f"{older_versions.version()} (Chipmunk {pymunk.chipmunk_version.partition('-')[0]})"


def refuses(case: Case, route: str) -> str | None:
    """The reason, in one sentence, why the route does not support the case, or None."""
    missing = [type(effect).__name__ for effect in case.effects if type(effect) not in KNOWN_EFFECTS]
    if missing:
        return Refusal(f"pymunk does not support {' and '.join(missing)}.", "no such attribute of pymunk.Shape")
    if has_rolling_resistance(case):
        return Refusal("pymunk does not support RollingResistance.", "no such attribute of pymunk.Shape")
    frictions = [couple.effect(CoulombFriction) for couple in couples(case)]
    if any(friction and friction.stick != friction.at_rest for friction in frictions):
        return Refusal("pymunk has one friction coefficient for slip and stick.", "Shape.friction is one number")
    impact = case.effect(Impact)
    if impact and impact.restitution > 0.0 and route == "assisted":
        return "A contact set by this route closes without restitution; it supports only Impact(0)."
    return driven_tracks.refuses(case) or (_refuses_natively(case) if route == "native" else None)


def refuses_several_contacts(case: Case, route: str) -> str | None:
    """Why the route does not report several contacts of this case, in one sentence, or None."""
    return several_contacts.refuses(case)


def _refuses_natively(case: Case) -> str | None:
    if any(facets.has_hollow_corners(plate.outline) for plate in plates_of(case)):
        return "pymunk's polygons are convex, and an outline here has corners that point inwards."
    if not case.effect(Unilateral):
        return "pymunk's contacts only push, and this case has a bilateral guide (no Unilateral)."
    movers = [kind.__name__ for kind in (Belt, Load, Drive) if case.effect(kind)]
    movers += ["further plate" for _ in case.others[:1]]
    if movers and is_endless(case.track):
        return (
            f"pymunk's chain of segments must have ends, and a {movers[0]} may move the plate anywhere on this endless "
            "track."
        )
    if name := next((support.name for support in case.supports if is_endless(support.curve)), ""):
        return f"pymunk's chain of segments must have ends, and the support {name!r} has none."
    return None


def is_endless(curve: Curve) -> bool:
    """Whether a curve that the engine has as a chain of segments has no ends and no period."""
    return not curve.period and not curve.domain and as_line(curve) is None


# --- settings --------------------------------------------------------------------------------------------------------

# Steps in seconds; the first is typical of games, 60 a second. A case longer than the usual duration has longer steps,
# at most three times as long: this limits a ladder's cost and keeps every step below the first.
STEPS = {
    "chain": (1 / 60, 4e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4, 5e-5),
    "line": (1 / 60, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4),
    "hill": (1 / 60, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4),
    "polygon": (1 / 60, 5e-3, 2e-3, 1e-3, 5e-4, 2.5e-4),
    # A polygon overlaps hundreds of facets in every step, and all of its corners are tested each time.
    "polygon on chain": (1 / 60, 5e-3, 4e-3, 2e-3, 1e-3, 5e-4),
    "assisted": (1 / 60, 4e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4),
}
USUAL_DURATION, MOST_STRETCH = 2.5, 3.0


def ladder(case: Case, route: str) -> tuple[Setting, ...]:
    """Settings from coarse to fine.

    The first has the engine's defaults, 60 steps a second. Native: default slop, bias and iterations, 64 thick facets
    without information on their neighbours; the others correct all overlap beyond a hundred-thousandth of the plate at
    once, and refine step and facets together. Assisted: the step, and the solver's iterations where they matter.
    """
    first, *others = STEPS["assisted" if route == "assisted" else native.scene_kind(case)]
    stretch = min(MOST_STRETCH, max(1.0, case.duration / USUAL_DURATION))
    steps = [h * stretch for h in others]
    if route == "assisted":
        defaults = Setting.of(rung="defaults", h=first)
        return (defaults, *(Setting.of(h=h, iterations=assisted.iterations(case)) for h in steps))
    defaults = Setting.of(rung="defaults", h=first, **native.shape_knobs(case, None))
    return (defaults, *(Setting.of(h=h, **native.shape_knobs(case, h), **native.space_knobs(case)) for h in steps))


# Usual steps of games, and usual numbers of facets of a first-time user.
USUAL_STEPS, USUAL_FACETS = (1 / 60, 1 / 120), (32, 64, 128)


def default_grid(case: Case, route: str) -> tuple[Setting, ...]:
    """The default settings with usual steps and numbers of facets."""
    return ladder(case, route)[0].combinations(h=USUAL_STEPS, facets=USUAL_FACETS)


# The grid's steps, coarse to fine: a typical one of games, and those at which facets, corners and iterations matter.
GRID_STEPS = (1e-2, 3e-3, 1e-3, 3e-4)


def grid(case: Case, route: str) -> tuple[Setting, ...]:
    """Combinations of step and model: facets with or without neighbours, corners, slop, or solver iterations."""
    if route == "assisted":
        return tuple(Setting.of(h=h, iterations=n) for h in GRID_STEPS for n in (1, 2, 5, 10))
    return tuple(Setting.of(h=h, **knobs) for h in GRID_STEPS for knobs in native.model_grid(case, GRID_STEPS))


# --- build, run, read -------------------------------------------------------------------------------------------------


@dataclass
class PymunkModel:
    """One run: the space, the plates' bodies, the step (s), the number of steps, the recorded rows.

    `engine_case` is the case that the engine has: on the assisted route, a driven track's as the track sees it.
    `drives`: the plates' loads; `rough`: sagitta (m) of the facets that approximate the curves; `guide`: the source of
    the assisted route's contacts.
    """

    case: Case
    engine_case: Case
    space: pymunk.Space
    bodies: list[pymunk.Body]
    h: float
    steps: int
    drives: Sequence[LoadInSteps | None] = ()
    rough: float = 0.0
    guide: assisted.ContactGuide | None = None
    # Functions that record the plates after a step, and that return the rows.
    note: Callable[[], None] = field(init=False)
    rows: Callable[[], np.ndarray] = field(init=False)

    def __post_init__(self) -> None:
        self.note, self.rows = older_versions.recorder(self.space, self.bodies)


def build(case: Case, route: str, setting: Setting) -> PymunkModel:
    """The space at the start of the case, moved back by half a step. The step divides the duration evenly."""
    return _model(case, route, setting, with_load=True)


def _model(case: Case, route: str, setting: Setting, with_load: bool) -> PymunkModel:
    steps = max(2, round(case.duration / setting["h"]))
    h = case.duration / steps
    if route != "native":
        engine_case = relative_case(case)
        space, body, drive, guide = assisted.build(engine_case, setting, h)
        return PymunkModel(case, engine_case, space, [body], h, steps, [drive], guide=guide)
    space, bodies = native.build(case, setting, h)
    native.drive_track(case, space, h)
    drives = loads_in_steps(case, bodies, h) if with_load else []
    rough = facets.sagitta(case, setting.get("facets"), setting.get("vertices"))
    model = PymunkModel(case, case, space, bodies, h, steps, drives, rough)
    if surfaces := native.surfaces_in_steps(case):
        model.note = native.SurfacesInSteps(surfaces, space, h).counting(model.note)
    return model


def run(model: PymunkModel) -> None:
    """Step through the duration and record pose and velocities after every step."""
    step, note = model.space.step, model.note
    # The half step moves the plate to its start and applies half a step's forces to the velocities.
    step(0.5 * model.h)
    note()
    for _ in range(model.steps):
        step(model.h)
        note()


def bare_run(case: Case, route: str, setting: Setting, without: str) -> Callable[[], None]:
    """A function that makes the steps of `run` without parts of its work, to measure their times.

    `without`: "notes": no recording; "callback": also an empty callback; "binding": also without the binding, by the C
    function alone. With an empty callback the engine has its own contact of two circles that overlap everywhere; it
    must not be corrected, or they would separate at once.
    """
    has_load = case.effect(Load) is not None
    model = _model(case, route, setting, with_load=has_load and without == "notes")
    space, body, h, steps = model.space, model.bodies[0], model.h, model.steps
    if route == "assisted" and without != "notes":
        space, body = assisted.overlapping(case, setting)
        body.position, space.collision_bias = model.bodies[0].position, 1.0
    if without == "callback":
        if route == "assisted":
            assisted.listen(space, lambda arbiter, space, data: None)
        if has_load:
            body.velocity_func = lambda *now: pymunk.Body.update_velocity(*now)

    step, what = (lib.cpSpaceStep, (space._space, h)) if without == "binding" else (space.step, (h,))
    space.step(h)  # the engine processes the new shapes and detects the contact

    return partial(_step_on, space, step, what, steps)


def _step_on(space: pymunk.Space, step: Callable[..., None], what: tuple, steps: int) -> None:
    """Make steps only; the argument keeps the space alive."""
    for _ in range(steps):
        step(*what)


def _load_rows(model: PymunkModel, steps: int) -> np.ndarray:
    """The loads in each step, as `StepRecord.load` has them."""
    every = np.array([drive.rows if drive else np.zeros((steps, 3)) for drive in model.drives])
    return every.transpose(1, 0, 2) if model.case.others else every[0]


def read(model: PymunkModel) -> Trajectory:
    """The motion at the poses' times, cut where the plate left its track. Raises EngineFailure if it is no motion."""
    guide, rows, loads = model.guide, model.rows(), [drive for drive in model.drives if drive]
    for drive in loads:
        if drive.problem:
            raise EngineFailure(f"The load has no value somewhere: {drive.problem}") from drive.problem
    if guide and guide.problem:
        raise EngineFailure(f"The contact for pymunk could not be computed: {guide.problem}") from guide.problem
    record = half_steps.StepRecord(
        model.engine_case, model.h, model.steps,
        rows=rows if model.case.others else rows[:, 0],
        contacts=guide.contacts if guide else None,
        load=_load_rows(model, len(rows)) if loads else None,
        rough=model.rough,
        wider=native.wider(model.case, model.space) if model.case.others else 0.0,
    )  # fmt: skip
    motion = half_steps.read(record)
    return motion if model.engine_case is model.case else driven_tracks.to_fixed_frame(model.case, motion)
