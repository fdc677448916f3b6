"""Exudyn (Gerstmayr, multibody dynamics with penalty contact; https://exudyn.readthedocs.io) on the suite's scenes.

`native` uses the engine's own smooth contacts: a disc in or on a circle, or on another disc, is
ObjectContactSphereSphere, a disc on a straight line ObjectContactSphereTriangle.
(ObjectConnectorRollingDiscPenalty, made for lines, is exact while it slips; where it should roll it chattered about
zero slip in half the runs tried, at up to a hundred times its `vreg`.)
Pure rolling on a line, and a bilateral guide without friction, are constraints (`constraints`). An impact takes some
periods of the contact's spring, and its restitution is met to a thousandth.
`integrator` supports any plate and track and uses no contact of the engine: contact point and contact law are the
suite's, in Python, in the form of the engine's own; ObjectGenericODE2 integrates them. It measures the engine's solver
with such a law, not its contacts.

Corners are small spheres, running surfaces heavy bodies, and a plate that does not turn has its angle held (`contacts`,
`bodies`); Stribeck's friction is ObjectContactConvexRoll's (`rolls`). The native route has no Python function in the
engine's iterations but a case's Load.

The law consists of a spring, a damper and regularised Coulomb friction: below `vreg` friction grows with the slip
velocity, so a sticking contact creeps. A setting's `h` is the step (s), `k` the contact stiffness (N/m), `vreg` the
regularisation (m/s). They are refined together: stiffness and regularisation are errors of the model, which remain
with a smaller step alone. The solver locates no event inside a step, and a slip that crosses zero there leaves an error
O(h) in the rest of the motion. The route `integrator` requests a smaller step there, down to the share `cut` of h.

Where Newton's method does not converge, at the kinks of that law, the engine halves its step. So it takes more steps
than h gives: 1.1 times as many in a circle, 1 to 30 times as many on the route `integrator`. The report's steps are
those taken. Modified Newton on that route was measured on six scenes: 0.4 to 2.1 times the CPU time, 0.8 in the mean at
the sixth rung, with the same or up to three times smaller errors; at the fourth rung it misses a transition in
`disc_in_parabola`. The ladder has full Newton.
"""

from __future__ import annotations

from itertools import product
from math import ceil, hypot, inf, sqrt
from typing import Any, cast

import exudyn as exu
import numpy as np

from cases import (
    Belt,
    Case,
    Chain,
    Cost,
    CoulombFriction,
    Drive,
    Flight,
    Gravity,
    Impact,
    Load,
    PerfectlyRough,
    Unilateral,
)
from cases.contact import start_motion
from cases.errors import unknown_name
from cases.moving_frame import relative_case
from cases.scene.free_plates import plates_of

from ..common import driven_tracks
from ..interface import Refusal, Setting
from . import constraints, integrator, native, older_versions, rolls
from .meanings import MEANINGS
from .reader import ExudynModel, read
from .system import scales

__all__ = [
    "CAPABILITIES", "MEANINGS", "NAME", "build", "default_grid", "grid", "ladder", "read", "refuses",
    "refuses_several_contacts", "routes", "run", "version",
]  # fmt: skip

NAME = "exudyn"
routes = ("native", "integrator")
# Tested: 1.7, 1.8, 1.9, 1.10, 1.11 and 1.13.6, by `older_versions`.
KNOWN = "exudyn>=1.7"

# The effects that this adapter implements; all others are reported as unsupported, by name.
KNOWN_EFFECTS = (Gravity, Load, CoulombFriction, PerfectlyRough, Unilateral, Flight, Impact, Belt, Drive)
CAPABILITIES = {
    "native": (
        "slip laws", "corners", "several contacts", "supports", "belts and supports",
        "fixed rotation and supports", "driven contacts", "several plates",
    ),
    "integrator": ("slip laws",),
}  # fmt: skip

# Samples of one run: enough to extrapolate a transition to the accuracy of the finest rung, and few enough for a
# thousand trajectories in memory.
MOST_SAMPLES = 20_000

# The rungs' settings from coarse to fine, as multiples of the case's scales: step / sqrt(r/a), stiffness / (m a/r),
# vreg / sqrt(r a) with gravity a. For a disc of 0.1 m and 1 kg on Earth the scales are 0.1 s, 98 N/m and 1 m/s. The
# error is C/k + O(h²) and, in stick, a share of vreg; the last stiffness is the largest before rounding of the
# penetration disturbs Newton's method.
#
# They lie on the lower envelope of a grid over all three, by the error of the first and of all transitions, in the mean
# of eight scenes: for the disc in the circle the first transition is off by 60 s N/m over k and 0.87/s h², so that the
# two are balanced at k h² = 70 N/m s²; with vreg below a thousandth of the step, in these units, friction oscillates in
# stick and spurious transitions appear.
RUNGS = (
    (1e-1, 1e4, 1e-3),
    (6e-2, 1e5, 3e-4),
    (3e-2, 3e5, 6e-5),
    (1.7e-2, 1e6, 3e-5),
    (9e-3, 3e6, 1.2e-5),
    (4e-3, 5e6, 8e-6),
    (2.4e-3, 1e7, 3e-6),
    (1.25e-3, 1.2e7, 2e-6),
)
# The route with the contact in Python reaches that rounding earlier: its Newton iterations cannot change the branch of
# the friction law between two iterations, as the engine's own contacts do.
LADDERS = {"native": RUNGS, "integrator": (*RUNGS[:4], (9e-3, 1.5e6, 2e-5), (5e-3, 2e6, 1.5e-5), (2.5e-3, 3e6, 1e-5))}

# The smallest share of a step that is requested where the slip crosses zero: at h/100 the overshoot, about h/200 of
# the acceleration, is below every rung's vreg.
CUTOFF = 0.01

# The longest step in periods of a contact's spring over 2 pi where it has to give a restitution (19 steps a period) and
# where discs meet at a constant velocity. There the step that the contact requests ends at a gap of exactly zero, and
# the contact acts only from the next step on: CObjectContactSphereSphere has a force where the gap is negative, and
# repeats a step if the gap was positive. The energy m v²/4 of two equal discs grows by k (v h)² then, so e is too large
# by 2 h² k/m at most: 0.2 with the longer step (0.11 was seen), 0.001 with this one.
RESTITUTION_STEP, MEETING_STEP = 1 / 3, 1 / 45

# The engine's own defaults: 100 steps whatever the duration, generalized-alpha, modified Newton, and a
# regularisation in m/s. Only the stiffness has no default: it is set for a penetration of a thousandth of the radius.
DEFAULT_STEPS, DEFAULT_VREG = 100, 1e-3

# Where a contact closes, its object requests steps down to the instant of contact; the engine's smallest step (1e-8 s)
# is then too large, and it gives up.
TOUCH = 1e-13

# By default Newton's method stops at a residual force of 1e-10 N. The spring force of the suite's contact law is a
# difference of coordinates, so it is rounded by eps k times their size; where that is more, the engine halves its steps
# and gives up (a disc that rolls on a line, k = 1e8 N/m). Plate's point, track's point, lever and gap each round once.
# The engine's own contacts keep its 1e-10 N, which they reach; with a larger tolerance they chatter.
ROUNDINGS = 4
NEWTON = 1e-10

_SOLVERS = {
    "GeneralizedAlpha": exu.DynamicSolverType.GeneralizedAlpha,
    "TrapezoidalIndex2": exu.DynamicSolverType.TrapezoidalIndex2,
    "RK44": exu.DynamicSolverType.RK44,
}


def version() -> str:
    """The engine's version."""
    return str(exu.__version__)


def refuses(case: Case, route: str) -> str | None:
    """Why the route cannot model the case, in one sentence, or None. Raises UnknownName for an unknown route."""
    if route not in routes:
        raise unknown_name("route of exudyn", route, routes)
    missing = [type(effect).__name__ for effect in case.effects if type(effect) not in KNOWN_EFFECTS]
    if missing:
        return Refusal(
            f"Exudyn's contacts do not support {' and '.join(missing)}.", "no such parameter in its contact objects"
        )
    if case.others:
        return native.refuses(case)
    if not case.plate.turns and route != "native":
        return Refusal("The inertia in this route's mass matrix is finite, and this plate does not turn.")
    friction = case.effect(CoulombFriction)
    if friction and friction.stick != friction.at_rest:
        return Refusal(
            "Exudyn's contacts have one friction coefficient; mu_static cannot differ from mu.",
            "dynamicFriction of its contacts; staticFrictionOffset of its roll fades with the slip velocity",
        )
    if problem := driven_tracks.refuses(case):
        return Refusal(problem)
    if route == "native":
        return native.refuses(relative_case(case))
    if case.effect(Impact):
        return (
            "The contact law given to Exudyn has a damper and no restitution, and its steps are longer than an impact: "
            "a disc would leave faster than it arrived."
        )
    return None


def refuses_several_contacts(case: Case, route: str) -> str | None:
    """Why the route does not report several contacts of this case, in one sentence, or None."""
    if native.has_several(case):
        return None
    return Refusal("Exudyn's contact of a disc with a curve has one place; give the places as supports.")


# --- settings -------------------------------------------------------------------------------------------------------


def ladder(case: Case, route: str) -> tuple[Setting, ...]:
    """Settings from coarse to fine; the first has the engine's defaults."""
    case = relative_case(case)
    length, acceleration = scales(case)
    stiffness, step = case.plate.mass * acceleration / length, case.duration / DEFAULT_STEPS
    defaults = Setting.of(rung="defaults", solver="GeneralizedAlpha", newton="modified", h=step)
    if not _uses_constraint(case, route):
        defaults = Setting((*defaults.values, ("k", _round(1e3 * stiffness)), ("vreg", DEFAULT_VREG)))
    return (defaults, *(_setting(case, route, *knobs, rung=n) for n, knobs in enumerate(LADDERS[route], start=1)))


def _uses_constraint(case: Case, route: str) -> bool:
    return route == "native" and constraints.suits(case)


# The engine leaves stiffness and regularisation (m/s) to its user, and its hundred steps are few for a long motion.
USUAL_STIFFNESSES, USUAL_VREGS, USUAL_STEPS = (1.0, 10.0), (1e-3, 1e-2), (1.0, 0.5)


def default_grid(case: Case, route: str) -> tuple[Setting, ...]:
    """The default settings with usual steps, stiffnesses and regularisations; of a constraint the steps only."""
    defaults = ladder(case, route)[0]
    return defaults.combinations(
        h=[defaults["h"] * share for share in USUAL_STEPS],
        k=[_round(defaults.get("k", 1.0) * factor) for factor in USUAL_STIFFNESSES],
        vreg=USUAL_VREGS,
    )


def grid(case: Case, route: str) -> tuple[Setting, ...]:
    """All combinations of three rungs' steps, stiffnesses and regularisations; none for a constraint."""
    if _uses_constraint(case, route):
        return ()
    rungs = (RUNGS[0], RUNGS[2], RUNGS[4])
    return tuple(_setting(case, route, h, k, vreg) for h, k, vreg in product(*zip(*rungs, strict=True)))


def _setting(case: Case, route: str, h: float, k: float, vreg: float, **rung: int) -> Setting:
    """A setting from multiples of the case's scales, as in RUNGS."""
    length, acceleration = scales(case)
    time, stiffness = sqrt(length / acceleration), case.plate.mass * acceleration / length
    step = _round(h * time)
    if _uses_constraint(case, route):
        return Setting.of(**rung, solver="GeneralizedAlpha", newton="full", h=step)
    # Without a bound friction is very stiff, and the trapezoidal rule would let it oscillate.
    solver = "GeneralizedAlpha" if case.effect(PerfectlyRough) else "TrapezoidalIndex2"
    most = inf
    if route == "native" and _needs_resolved_spring(case):
        impact = case.effect(Impact)
        has_restitution = impact is not None and impact.restitution > 0.0
        part = RESTITUTION_STEP if has_restitution else 1.0
        most = min(plate.mass for plate in plates_of(case)) * (part / step) ** 2
        if has_restitution and case.others:
            step = _round(step * MEETING_STEP / RESTITUTION_STEP)
    knobs = dict(k=_round(min(k * stiffness, most)), vreg=_round(vreg * length / time))
    if case.effect(CoulombFriction) and route == "integrator":
        knobs["cut"] = CUTOFF
    return Setting.of(**rung, solver=solver, newton="full", h=step, **knobs)


def _needs_resolved_spring(case: Case) -> bool:
    """Whether a step must not be longer than the period of the contact's spring over 2 pi.

    A corner that lands, or one disc on another, is thrown back by a longer step: restitution was 2.2 instead of 0.8.
    The engine's roll loses the plane then.
    """
    friction = case.effect(CoulombFriction)
    is_roll = friction is not None and friction.by_speed
    return bool(case.others or is_roll or isinstance(case.plate.outline, Chain))


def _round(value: float) -> float:
    return float(f"{value:.2g}")


# --- build, run -----------------------------------------------------------------------------------------------------


def build(case: Case, route: str, setting: Setting) -> ExudynModel:
    """The engine's system for a case that the route supports; a driven track's in the frame of the track."""
    outside, case = case, relative_case(case)
    friction, maker = case.effect(CoulombFriction), cast(Any, native)
    if route != "native":
        maker = integrator
    elif _uses_constraint(case, route):
        maker = constraints
    elif friction and friction.by_speed:
        maker = rolls
    return ExudynModel(case, route, setting, maker.build(case, setting), outside)


def run(model: ExudynModel) -> None:
    """Solve. If the engine gives up, `read` gets its message, since the plate may have left its track long before."""
    system, settings = model.system.system, _simulation_settings(model)
    with older_versions.quiet():
        try:
            system.SolveDynamic(settings, solverType=_SOLVERS[model.setting["solver"]])
        except older_versions.ERRORS as problem:
            model.failure = " ".join(str(problem).split())[:200]
    iteration = system.sys["dynamicSolver"].it
    model.cost = Cost(steps=int(iteration.currentStepIndex), evaluations=int(iteration.newtonStepsCount))


def _simulation_settings(model: ExudynModel):
    case, setting = model.case, model.setting
    settings = exu.SimulationSettings()
    # A step that divides the duration to a millionth of a step is not reduced because of rounding.
    steps = max(1, ceil(case.duration / setting["h"] - 1e-6))
    settings.timeIntegration.endTime = case.duration
    settings.timeIntegration.numberOfSteps = steps
    if case.effect(Flight):
        settings.timeIntegration.minimumStepSize = TOUCH
    settings.timeIntegration.newton.useModifiedNewton = setting["newton"] == "modified"
    if model.route == "integrator" and not setting.is_default:
        settings.timeIntegration.newton.absoluteTolerance = max(NEWTON, _rounding(case, setting["k"]))
    # A period below every step makes the sensors store every step.
    older_versions.set_output(settings, 1e-12 if steps <= MOST_SAMPLES else case.duration / MOST_SAMPLES)
    return settings


def _rounding(case: Case, k: float) -> float:
    """The rounding (N) of the force of a spring k (N/m) where the motion starts."""
    start = start_motion(case)
    return ROUNDINGS * np.finfo(float).eps * k * (hypot(start.x, start.y) + case.plate.reach)
