"""Exudyn (Gerstmayr, multibody dynamics with penalty contact; https://exudyn.readthedocs.io) on the suite's scenes.

`native` takes the engine's own smooth contacts: a disc in or on a circle is ObjectContactSphereSphere, a disc on a
straight line ObjectContactSphereTriangle. (ObjectConnectorRollingDiscPenalty, made for lines, is exact while it slips;
where it should roll it chattered about zero slip in half the runs tried, at up to a hundred times its `vreg`.)
Pure rolling on a line, and a frictionless guide from both sides, are constraints (`constrained`). An impact
takes some periods of the contact's spring, and its restitution comes out to a thousandth.
`integrator` is for any plate and track, and no contact of the engine's: contact point and contact law are ours, in
Python, after the form of the engine's own; ObjectGenericODE2 integrates them. It says how good the engine's solver is
with such a law, not its contacts.

The law presses with a spring and a damper and regularises Coulomb's friction: below `vreg` it grows with the slip
velocity, so what sticks creeps. A setting's `h` is the step (s), `k` the contact stiffness (N/m), `vreg` the
regularisation (m/s). They are tightened together: stiffness and regularisation are errors of the model, which a
smaller step alone would keep. The solver finds no event inside a step, and a slip that crosses zero there would leave
an error O(h) in what follows: a smaller step is asked for, down to the share `cut` of h.
"""

from __future__ import annotations

from contextlib import contextmanager
from itertools import product
from math import ceil, hypot, sqrt

import exudyn as exu
import numpy as np

from cases import Case, Cost, CoulombFriction, Flight, Gravity, Impact, Load, PerfectlyRough, Unilateral
from cases.contact import start_motion
from cases.errors import unknown_name

from ..interface import Setting
from . import constraints, integrator, native
from .reader import ExudynModel, read
from .system import scales

__all__ = ["NAME", "build", "grid", "ladder", "read", "refuses", "routes", "run", "version", "wide_grid"]

NAME = "exudyn"
routes = ("native", "integrator")
KNOWN = "exudyn>=1.13"

# What this adapter has told the engine how to do; an effect that is not here is refused by its name.
KNOWN_EFFECTS = (Gravity, Load, CoulombFriction, PerfectlyRough, Unilateral, Flight, Impact)

# Samples of one run: enough to extrapolate a transition to the accuracy of the finest rung, few enough to keep a
# thousand trajectories in memory.
MOST_SAMPLES = 20_000

# What the rungs multiply, from coarse to fine: step / sqrt(r/a), stiffness / (m a/r), vreg / sqrt(r a) with gravity a.
# For a disc of 0.1 m and 1 kg on Earth that is 0.1 s, 98 N/m and 1 m/s. The error is C/k + O(h²) and, in stick, a
# share of vreg; the last stiffness is the largest before rounding of the penetration disturbs Newton's method.
#
# They lie on the lower envelope of a grid over all three, by the error of the first and of all transitions, in the mean
# of eight scenes (`reports.study settings` makes it again): of the disc in the circle the first transition is off by
# 60 s N/m over k and 0.87/s h², so that the two are balanced at k h² = 70 N/m s²; with vreg below a thousandth of the
# step, in these units, friction rings through the stick and transitions are invented.
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
# The route whose contact is Python meets that rounding at less: its Newton iterations cannot change branch of the
# friction law between two iterations, as the engine's own contacts do.
LADDERS = {"native": RUNGS, "integrator": (*RUNGS[:4], (9e-3, 1.5e6, 2e-5), (5e-3, 2e6, 1.5e-5), (2.5e-3, 3e6, 1e-5))}

# The smallest share of a step that is asked for where the slip crosses zero: at h/100 the overshoot, some h/200 of the
# acceleration, is below every rung's vreg.
CUTOFF = 0.01

# The engine's own defaults: 100 steps whatever the duration, generalized-alpha, modified Newton, and a
# regularisation in m/s. Only the stiffness has no default: a penetration of a thousandth of the radius is typed.
DEFAULT_STEPS, DEFAULT_VREG = 100, 1e-3

# Where a contact closes its object asks for steps down to the very touch; the engine's smallest step (1e-8 s) is then
# too large, and it gives up.
TOUCH = 1e-13

# Newton's method stops at a residual force of 1e-10 N unless told otherwise. The spring of our contact law presses by a
# difference of coordinates, so its force is rounded by eps k times their size; where that is more, the engine halves
# its steps and gives up (a disc that rolls on a line, k = 1e8 N/m). Plate's point, track's point, lever and gap each
# round once. The engine's own contacts are left at its 1e-10 N, which they meet; with more they chatter.
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
        return f"Exudyn's contacts have nothing for {' and '.join(missing)}."
    friction = case.effect(CoulombFriction)
    if friction and friction.stick != friction.mu:
        return "Exudyn's contacts know one friction coefficient; mu_static cannot differ from mu."
    if route == "native":
        return native.refuses(case)
    if case.effect(Impact):
        return (
            "The law handed to Exudyn has a damper and no restitution, and its steps are longer than an impact: "
            "a disc leaves faster than it came."
        )
    return None


# --- settings -------------------------------------------------------------------------------------------------------


def ladder(case: Case, route: str) -> tuple[Setting, ...]:
    """Settings from coarse to fine; the first is what the engine does unless told otherwise."""
    length, acceleration = scales(case)
    stiffness, step = case.plate.mass * acceleration / length, case.duration / DEFAULT_STEPS
    defaults = Setting.of(rung="defaults", solver="GeneralizedAlpha", newton="modified", h=step)
    if not _uses_constraint(case, route):
        defaults = Setting((*defaults.values, ("k", _round(1e3 * stiffness)), ("vreg", DEFAULT_VREG)))
    return (defaults, *(_setting(case, route, *knobs, rung=n) for n, knobs in enumerate(LADDERS[route], start=1)))


def _uses_constraint(case: Case, route: str) -> bool:
    return route == "native" and constraints.suits(case)


def grid(case: Case, route: str) -> tuple[Setting, ...]:
    """Step times stiffness times regularisation, those of three rungs; none for a constraint, which has but a step."""
    if _uses_constraint(case, route):
        return ()
    rungs = (RUNGS[0], RUNGS[2], RUNGS[4])
    return tuple(_setting(case, route, h, k, vreg) for h, k, vreg in product(*zip(*rungs, strict=True)))


# What the rungs were chosen among, for each route in a time that a study may take; in multiples as RUNGS.
_WIDE = {
    "native": ((6e-2, 3e-2, 1.7e-2, 9e-3, 4e-3), (1e5, 1e6, 3e6, 1e7), (3e-4, 3e-5, 1e-5, 3e-6)),
    "integrator": ((6e-2, 3e-2, 1.7e-2), (1e5, 1e6, 3e6), (3e-4, 3e-5)),
}


def wide_grid(case: Case, route: str) -> tuple[Setting, ...]:
    """Step times stiffness times regularisation as wide as a ladder is long; none for a constraint."""
    return (
        ()
        if _uses_constraint(case, route)
        else tuple(_setting(case, route, *knobs) for knobs in product(*_WIDE[route]))
    )


def _setting(case: Case, route: str, h: float, k: float, vreg: float, **rung: int) -> Setting:
    """A setting from multiples of the case's scales, as in RUNGS."""
    length, acceleration = scales(case)
    time, stiffness = sqrt(length / acceleration), case.plate.mass * acceleration / length
    step = _round(h * time)
    if _uses_constraint(case, route):
        return Setting.of(**rung, solver="GeneralizedAlpha", newton="full", h=step)
    # Without a bound friction is all stiffness, and the trapezoidal rule would let it ring.
    solver = "GeneralizedAlpha" if case.effect(PerfectlyRough) else "TrapezoidalIndex2"
    knobs = dict(k=_round(k * stiffness), vreg=_round(vreg * length / time))
    if case.effect(CoulombFriction):
        knobs["cut"] = CUTOFF
    return Setting.of(**rung, solver=solver, newton="full", h=step, **knobs)


def _round(value: float) -> float:
    return float(f"{value:.2g}")


# --- build, run -----------------------------------------------------------------------------------------------------


def build(case: Case, route: str, setting: Setting) -> ExudynModel:
    """The engine's system for a case the route does not refuse."""
    if _uses_constraint(case, route):
        return ExudynModel(case, route, setting, constraints.build(case, setting))
    maker = native if route == "native" else integrator
    return ExudynModel(case, route, setting, maker.build(case, setting))


def run(model: ExudynModel) -> None:
    """Solve. What the engine says if it gives up is kept for `read`, since the plate may have left long before."""
    system, settings = model.system.system, _simulation_settings(model)
    with _quiet():
        try:
            system.SolveDynamic(settings, solverType=_SOLVERS[model.setting["solver"]])
        except exu.ExudynError as problem:
            model.failure = " ".join(str(problem).split())[:200]
    iteration = system.sys["dynamicSolver"].it
    model.cost = Cost(steps=int(iteration.currentStepIndex), evaluations=int(iteration.newtonStepsCount))


def _simulation_settings(model: ExudynModel):
    case, setting = model.case, model.setting
    settings = exu.SimulationSettings()
    # A step that fits the duration to a millionth of a step is not made smaller for its rounding.
    steps = max(1, ceil(case.duration / setting["h"] - 1e-6))
    settings.timeIntegration.endTime = case.duration
    settings.timeIntegration.numberOfSteps = steps
    if case.effect(Flight):
        settings.timeIntegration.minimumStepSize = TOUCH
    settings.timeIntegration.newton.useModifiedNewton = setting["newton"] == "modified"
    if model.route == "integrator" and not setting.is_default:
        settings.timeIntegration.newton.absoluteTolerance = max(NEWTON, _rounding(case, setting["k"]))
    settings.solution.file.write = False
    # A period below every step stores every step.
    settings.solution.sensors.writePeriod = 1e-12 if steps <= MOST_SAMPLES else case.duration / MOST_SAMPLES
    return settings


def _rounding(case: Case, k: float) -> float:
    """The force (N) that roundings of a spring k (N/m) make where the motion starts."""
    start = start_motion(case)
    return ROUNDINGS * np.finfo(float).eps * k * (hypot(start.x, start.y) + case.plate.reach)


@contextmanager
def _quiet():
    """The engine's console is one switch for the whole process: off for the run, then as it was."""
    before = exu.config.printToConsole
    exu.config.printToConsole = False
    try:
        yield
    finally:
        exu.config.printToConsole = before
