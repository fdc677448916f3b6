"""pymunk (Chipmunk/Munk2D): a game engine's semi-implicit Euler step with Coulomb friction as clamped impulses.

Positions stand at k·h and velocities at (k+½)·h, if the first step is a half one (start backed up by v₀·h/2, then
`step(h/2)`). Velocities at the poses' times are means of their neighbours; forces are what the contact added to the
momentum in the step, over h. On facets the force of a single step is noise about the true one: only its mean counts.

Routes: `native` (the engine's circles, segments and polygons; order 1), `assisted` (the engine is told the exact
contact point, normal and the normal velocity that follows the curve; inertia, cone, stick and push are its own;
order 2).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import pymunk

from cases import Case, CoulombFriction, Gravity, Trajectory, Unilateral
from cases.contact import Contact, Motion, find, slip_velocity, start_motion
from cases.trajectory import Cost

from . import _pymunk_assisted as assisted
from . import _pymunk_native as native
from .interface import EngineFailure, Setting

NAME = "pymunk"
routes = ("native", "assisted")

# What this adapter has told the engine how to do; an effect that is not here is refused by its name.
KNOWN_EFFECTS = (Gravity, CoulombFriction, Unilateral)


def version() -> str:
    """pymunk's version with that of the library inside it."""
    return f"{pymunk.version} (Chipmunk {pymunk.chipmunk_version.partition('-')[0]})"


def refuses(case: Case, route: str) -> str | None:
    """Why pymunk cannot model the case by that route, in one sentence, or None."""
    strange = [type(effect).__name__ for effect in case.effects if type(effect) not in KNOWN_EFFECTS]
    if strange:
        return f"pymunk has nothing for {' and '.join(strange)}."
    friction = case.effect(CoulombFriction)
    if friction and friction.stick != friction.mu:
        return "pymunk has one friction coefficient for slip and stick."
    return _refuses_natively(case) if route == "native" else None


def _refuses_natively(case: Case) -> str | None:
    if not case.effect(Unilateral):
        return "pymunk's contacts only push, and this plate is guided from both sides (the case has no Unilateral)."
    outline = case.plate.outline
    if not outline.period or np.any(outline.curvature(np.linspace(*outline.look, 721)) <= 0.0):
        return "pymunk's own shapes are circles and convex polygons, and this outline is neither closed nor convex."
    return None


# --- settings --------------------------------------------------------------------------------------------------------

# Steps in seconds, the first a game's: 60 a second. A case longer than the usual one has longer steps, at most three
# times as long: that bounds a ladder's cost and keeps every step below the game's.
STEPS = {
    "chain": (1 / 60, 4e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4, 5e-5),
    "line": (1 / 60, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4),
    "hill": (1 / 60, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4),
    "polygon": (1 / 60, 5e-3, 2e-3, 1e-3, 5e-4, 2.5e-4),
    # A polygon meets hundreds of facets in every step, and every corner of it is looked at each time.
    "polygon on chain": (1 / 60, 5e-3, 4e-3, 2e-3, 1e-3, 5e-4),
    "assisted": (1 / 60, 4e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4),
}
USUAL_DURATION, MOST_STRETCHED = 2.5, 3.0


def ladder(case: Case, route: str) -> tuple[Setting, ...]:
    """Settings from coarse to fine.

    The first is the engine as it comes, 60 steps a second. Native: its slop, bias and iterations, 64 thick facets that
    do not know their neighbours; the others correct all overlap beyond a hundred-thousandth of the plate at once, and
    tighten step and facets together. Assisted: the step, and the sweeps of the solver where they matter.
    """
    first, *others = STEPS["assisted" if route == "assisted" else native.scene_kind(case)]
    stretched = min(MOST_STRETCHED, max(1.0, case.duration / USUAL_DURATION))
    steps = [h * stretched for h in others]
    if route == "assisted":
        defaults = Setting.of(rung="defaults", h=first)
        return (defaults, *(Setting.of(h=h, iterations=assisted.iterations(case)) for h in steps))
    defaults = Setting.of(rung="defaults", h=first, **native.shape_knobs(case, None))
    return (defaults, *(Setting.of(h=h, **native.shape_knobs(case, h), **native.space_knobs(case)) for h in steps))


# The grid's steps, coarse to fine: a game's beside those at which a facet's, a corner's and a sweep's part show.
GRID_STEPS = (1e-2, 3e-3, 1e-3, 3e-4)


def grid(case: Case, route: str) -> tuple[Setting, ...]:
    """Step times model: facets and whether they know their neighbours, corners, slop, or sweeps of the solver."""
    if route == "assisted":
        return tuple(Setting.of(h=h, iterations=n) for h in GRID_STEPS for n in (1, 2, 5, 10))
    return tuple(Setting.of(h=h, **knobs) for h in GRID_STEPS for knobs in native.model_grid(case, GRID_STEPS))


# --- build, run ------------------------------------------------------------------------------------------------------


@dataclass
class Model:
    """One run: the space, its moving body, the step in seconds and how many, the recorded rows.

    `roughness`: sagitta in metres of the facets that stand for the curves; `guide`: what the assisted route tells.
    """

    case: Case
    route: str
    space: pymunk.Space
    body: pymunk.Body
    h: float
    steps: int
    roughness: float = 0.0
    guide: assisted.Guide | None = None
    rows: list[tuple[float, ...]] = field(default_factory=list)


def build(case: Case, route: str, setting: Setting) -> Model:
    """The space at the start of the case, backed up by half a step. The step divides the duration evenly."""
    steps = max(2, round(case.duration / setting["h"]))
    h = case.duration / steps
    if route == "native":
        space, body = native.build(case, setting)
        model = Model(case, route, space, body, h, steps, native.roughness(case, setting))
    else:
        space, body, guide = assisted.build(case, setting, h)
        model = Model(case, route, space, body, h, steps, guide=guide)
    start = start_motion(case)
    body.position = start.x - 0.5 * h * start.vx, start.y - 0.5 * h * start.vy
    body.angle = start.theta - 0.5 * h * start.omega
    body.velocity, body.angular_velocity = (start.vx, start.vy), start.omega
    return model


def run(model: Model) -> None:
    """Step through the duration, noting pose and velocities after every step."""
    step, body, note = model.space.step, model.body, model.rows.append
    # The half step moves the plate to its start and gives the velocities half a step's forces.
    step(0.5 * model.h)
    note((*body.position, body.angle, *body.velocity, body.angular_velocity))
    for _ in range(model.steps):
        step(model.h)
        note((*body.position, body.angle, *body.velocity, body.angular_velocity))


# --- read ------------------------------------------------------------------------------------------------------------


class _Contacts(NamedTuple):
    """Contact parameters and gap (m) of the leading poses that have a contact point, arrays of one length."""

    xi1: np.ndarray
    xi2: np.ndarray
    gap: np.ndarray


class _Ending(NamedTuple):
    """How many samples belong to the motion, and what ended it."""

    kept: int
    status: str = Trajectory.status
    reason: str = Trajectory.reason


def read(model: Model) -> Trajectory:
    """The motion at the poses' times, cut where the plate left its track. Raises EngineFailure if it is no motion."""
    case, rows = model.case, np.array(model.rows)
    if not np.isfinite(rows).all():
        when = model.h * int(np.argmin(np.isfinite(rows).all(axis=1)))
        raise EngineFailure(f"pymunk's numbers are not finite from {when:.4g} s on.")
    start = start_motion(case)
    pose, after = rows[:, :3], rows[:, 3:]
    before = np.vstack([[start.vx, start.vy, start.omega], after[:-1]])
    rates = 0.5 * (before + after)
    rates[0] = before[0]
    kick = np.full((len(rows), 1), model.h)
    kick[0] *= 0.5
    force = case.plate.mass * ((after - before)[:, :2] / kick - native.pull(case))
    contacts = _told(model.guide) if model.guide else _follow(case, start, pose)
    # A force is a difference of velocities over h: ten roundings of the velocity bound what it is off by.
    rounding = 10 * np.finfo(float).eps * case.plate.mass * float(np.abs(rates[:, :2]).max()) / model.h
    ending = _ending(case, contacts, pose, force, rounding, _hop(case, force, model.h, model.roughness))
    pose, rates, force = pose[: ending.kept], rates[: ending.kept], force[: ending.kept]
    xi1, xi2, gap = (part[: ending.kept] for part in contacts)
    x, y, theta = pose.T
    vx, vy, omega = rates.T
    # The engine sticks at the plate's own point, a gap away from the track's: with the centre moved by the gap the
    # lever arm is the engine's.
    nx, ny = case.track.normal(xi1)
    normal_force = force[:, 0] * nx + force[:, 1] * ny
    return Trajectory(
        t=np.linspace(0.0, case.duration, model.steps + 1)[: ending.kept],
        x=x,
        y=y,
        theta=theta,
        vx=vx,
        vy=vy,
        omega=omega,
        slip=slip_velocity(case, x - gap * nx, y - gap * ny, vx, vy, omega, xi1),
        normal_force=normal_force,
        friction_force=np.sum(force.T * case.track.tangent(xi1), axis=0),
        xi1=xi1,
        xi2=xi2,
        status=ending.status,
        reason=ending.reason,
        cost=Cost(steps=model.steps + 1),
        slip_resolution=_creep(case, xi1, rates, normal_force, model.h),
    )


def _told(guide: assisted.Guide) -> _Contacts:
    """The contacts the engine was told. Raises EngineFailure if telling it failed."""
    if guide.problem:
        raise EngineFailure(f"The contact could not be told to pymunk: {guide.problem}") from guide.problem
    return _table(guide.contacts)


def _table(contacts: list[Contact]) -> _Contacts:
    xi1, xi2, gap = np.array(contacts, dtype=float).reshape(-1, 3).T
    return _Contacts(xi1, xi2, gap)


def _follow(case: Case, start: Motion, pose: np.ndarray) -> _Contacts:
    """The contacts of the poses, up to the first pose that has none near the one before."""
    near, rows = (start.xi1, start.xi2), []
    for x, y, theta in pose.tolist():
        try:
            contact = find(case, x, y, theta, near)
        except assisted.BEYOND:
            break
        near = (contact.xi1, contact.xi2)
        rows.append(contact)
    return _table(rows)


def _ending(
    case: Case, contacts: _Contacts, pose: np.ndarray, force: np.ndarray, rounding: float, hop: float
) -> _Ending:
    """The first of the things that end a motion, or the end of its time.

    A contact pushes with more than the `rounding` (N) of the forces; a gap (m) above `hop` is a flight.
    """
    found = len(contacts.gap)
    endings = [_Ending(len(pose))]
    smallest, _ = native.radii(case)
    through = contacts.gap < -smallest
    if through.any():
        endings.append(_Ending(int(np.argmax(through)), "fell_through", "The plate passed through its track."))
    for name, curve, xi in (("track", case.track, contacts.xi1), ("outline", case.plate.outline, contacts.xi2)):
        if curve.domain and not curve.period:
            # Where there was no contact any more, the next one would have been about as far ahead as the last.
            xi = np.append(xi, 2 * xi[-1] - xi[-2]) if 1 < found < len(pose) else xi
            outside = (xi < curve.domain[0]) | (xi > curve.domain[1])
            if outside.any():
                reason = f"The contact reached the end of the {name}'s domain."
                endings.append(_Ending(int(np.argmax(outside)), f"{name}_end", reason))
    if found < len(pose):
        endings.append(_Ending(found, "lost_track", "No point of the track is near the plate any more."))
    flown = contacts.gap > hop
    if flown.any():
        strength = np.hypot(*force[: int(np.argmax(flown)) + 1].T)
        pushed = np.flatnonzero(strength > 1e-9 * strength.max() + rounding)
        kept = int(pushed[-1]) + 1 if pushed.size else 1
        endings.append(_Ending(kept, "lift_off", "The contact stopped pushing and the plate left its track."))
    return min(endings, key=lambda ending: ending.kept)


def _hop(case: Case, force: np.ndarray, h: float, roughness: float) -> float:
    """A gap in metres that only a plate in flight reaches.

    An engine lets a plate go for a step and catches it in the next: such hops are about ½ a h² with the acceleration a
    of gravity or contact; and facets stand off the curve by their sagitta (`roughness`). Four times that, and a
    millionth of the plate for rounding, is a flight; the cut goes back to the flight's beginning.
    """
    strongest = float(np.hypot(*native.pull(case))) + float(np.hypot(*force.T).max()) / case.plate.mass
    return 1e-6 * native.radii(case)[0] + 2.0 * strongest * h**2 + 4.0 * roughness


def _creep(case: Case, xi1: np.ndarray, rates: np.ndarray, normal_force: np.ndarray, h: float) -> float:
    """The slip velocity (m/s) that remains where the engine sticks, in all but one step in a hundred.

    It sticks with the velocities of a half step, along a tangent that turns by some angle a in a step: the mean of
    two such velocities misses by v a²/8 at the centre, and by as much at the contact, whose lever turns too; doubled
    for plates whose outline bends more than the track. And on facets the normal force scatters from step to step:
    where it falls short, so does friction, for one step.
    """
    turn = float(np.abs(np.diff(case.track.tangent_angle(xi1))).max(initial=0.0))
    # Half the difference of two neighbours is their distance from what they scatter about; the rarest are jumps.
    jumps = np.abs(np.diff(normal_force))
    scatter = 0.5 * float(np.percentile(jumps, 99)) if jumps.size else 0.0
    friction, plate = case.effect(CoulombFriction), case.plate
    ease = 1 / plate.mass + native.radii(case)[1] ** 2 / plate.inertia
    missing = h * (friction.mu if friction else 0.0) * scatter * ease
    return float(0.5 * np.hypot(rates[:, 0], rates[:, 1]).max() * turn**2) + missing
