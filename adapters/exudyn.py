"""Exudyn (Gerstmayr, multibody dynamics with penalty contact; https://exudyn.readthedocs.io) on the suite's scenes.

`native` takes the engine's own smooth contacts: a disc in or on a circle is ObjectContactSphereSphere, a disc on a
straight line ObjectContactSphereTriangle. (ObjectConnectorRollingDiscPenalty, made for lines, is exact while it slips;
where it should roll it chattered about zero slip in half the runs tried, at up to a hundred times its `vreg`.)
`assisted` hands the same law, at the suite's contact point, to ObjectGenericODE2, for any plate and track.

The law presses with a spring and a damper and regularises Coulomb's friction: below `vreg` it grows with the slip
velocity, so what sticks creeps. A setting's `h` is the step (s), `k` the contact stiffness (N/m), `vreg` the
regularisation (m/s). They are tightened together: stiffness and regularisation are errors of the model, which a
smaller step alone would keep. The engine's contacts find no event inside a step, so a slip that reverses leaves an
error O(h) in what follows; the assisted law asks for a smaller step there, down to the share `cut` of h.
"""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import dataclass
from itertools import product
from math import ceil, sqrt
from typing import NamedTuple

import exudyn as exu
import numpy as np

from cases import Case, Cost, CoulombFriction, Curve, Gravity, Trajectory, Unilateral
from cases.contact import start_motion
from cases.errors import unknown

from . import _exudyn_assisted, _exudyn_native
from ._exudyn_system import Contact, System
from .interface import EngineFailure, Setting

NAME = "exudyn"
routes = ("native", "assisted")

# Samples of one run: enough to extrapolate a transition to the accuracy of the finest rung, few enough to keep a
# thousand trajectories in memory.
MOST_SAMPLES = 20_000

# What the rungs multiply, from coarse to fine: step / sqrt(r/a), stiffness / (m a/r), vreg / sqrt(r a) with gravity a.
# For a disc of 0.1 m and 1 kg on Earth that is 0.1 s, 98 N/m and 1 m/s. The error is C/k + O(h²) and, in stick, a
# share of vreg; the last stiffness is the largest before rounding of the penetration disturbs Newton's method.
RUNGS = (
    (1e-1, 1e3, 1e-3),
    (3e-2, 1e4, 3e-4),
    (1e-2, 1e5, 1e-4),
    (5e-3, 1e6, 3e-5),
    (2.5e-3, 3e6, 1e-5),
    (1.25e-3, 1e7, 3e-6),
)
# The route whose contact is Python meets that rounding one rung earlier: its Newton iterations cannot change branch
# of the friction law between two iterations, as the engine's own contacts do.
FINEST = {"native": len(RUNGS), "assisted": len(RUNGS) - 1}

# The smallest share of a step that the assisted law asks for where its slip crosses zero: at h/100 the overshoot, some
# h/200 of the acceleration, is below every rung's vreg.
CUT: dict[str, dict[str, float]] = {"native": {}, "assisted": {"cut": 0.01}}

# The engine's own defaults: 100 steps whatever the duration, generalized-alpha, modified Newton, and a
# regularisation in m/s. Only the stiffness has no default: a penetration of a thousandth of the radius is typed.
DEFAULT_STEPS, DEFAULT_VREG = 100, 1e-3

_SOLVERS = {
    "GeneralizedAlpha": exu.DynamicSolverType.GeneralizedAlpha,
    "TrapezoidalIndex2": exu.DynamicSolverType.TrapezoidalIndex2,
    "RK44": exu.DynamicSolverType.RK44,
}

# Where the normal and the friction force stand in a row of a trajectory.
_FORCES = slice(8, 10)


@dataclass
class Model:
    """A case in the engine; after the run also what it cost and, if the engine gave up, what it said."""

    case: Case
    setting: Setting
    system: System
    cost: Cost = Cost()
    failure: str | None = None


def version() -> str:
    """The engine's version."""
    return str(exu.__version__)


def refuses(case: Case, route: str) -> str | None:
    """Why the route cannot model the case, in one sentence, or None. Raises UnknownName for an unknown route."""
    if route not in routes:
        raise unknown("route of exudyn", route, routes)
    for effect in case.effects:
        if not isinstance(effect, Gravity | CoulombFriction | Unilateral):
            return f"Exudyn's contacts have nothing for {type(effect).__name__}."
    friction = case.effect(CoulombFriction)
    if friction and friction.stick != friction.mu:
        return "Exudyn's contacts know one friction coefficient; mu_static cannot differ from mu."
    if route == "assisted":
        return None
    if case.effect(Unilateral) is None:
        return "Exudyn's contacts only push; a track that also pulls (no Unilateral) is not among them."
    return _exudyn_native.refuses(case)


# --- settings -------------------------------------------------------------------------------------------------------


def ladder(case: Case, route: str) -> tuple[Setting, ...]:
    """Settings from coarse to fine; the first is what the engine does unless told otherwise."""
    length, acceleration = scales(case)
    stiffness = case.plate.mass * acceleration / length
    defaults = Setting.of(
        rung="defaults",
        solver="GeneralizedAlpha",
        newton="modified",
        h=case.duration / DEFAULT_STEPS,
        k=_rounded(1e3 * stiffness),
        vreg=DEFAULT_VREG,
    )
    finer = enumerate(RUNGS[: FINEST[route]], start=1)
    return (defaults, *(_setting(case, route, *knobs, rung=number) for number, knobs in finer))


def grid(case: Case, route: str) -> tuple[Setting, ...]:
    """Step times stiffness times regularisation, those of three rungs, from the coarsest to the finest of each."""
    chosen = (RUNGS[0], RUNGS[1], RUNGS[3])
    return tuple(_setting(case, route, h, k, vreg) for h, k, vreg in product(*zip(*chosen, strict=True)))


def _setting(case: Case, route: str, h: float, k: float, vreg: float, **rung: int) -> Setting:
    """A setting from multiples of the case's scales, as in RUNGS."""
    length, acceleration = scales(case)
    time, stiffness = sqrt(length / acceleration), case.plate.mass * acceleration / length
    return Setting.of(
        **rung,
        solver="TrapezoidalIndex2",
        newton="full",
        h=_rounded(h * time),
        k=_rounded(k * stiffness),
        vreg=_rounded(vreg * length / time),
        **CUT[route],
    )


def scales(case: Case) -> tuple[float, float]:
    """A length (m; centre of mass to contact) and an acceleration (m/s²) that the rungs are multiples of."""
    start = start_motion(case)
    length = float(np.hypot(*case.plate.outline.point(start.xi2)))
    gravity = case.effect(Gravity)
    speed = max(abs(start.slip), abs(start.omega) * length)
    # Without gravity the motion itself sets the scale; a plate at rest then stays there, at any scale.
    acceleration = gravity.g if gravity and gravity.g > 0.0 else speed**2 / length
    return length, acceleration or 1.0


def _rounded(value: float) -> float:
    return float(f"{value:.2g}")


# --- build, run -----------------------------------------------------------------------------------------------------


def build(case: Case, route: str, setting: Setting) -> Model:
    """The engine's system for a case the route does not refuse."""
    maker = _exudyn_native if route == "native" else _exudyn_assisted
    return Model(case, setting, maker.build(case, setting))


def run(model: Model) -> None:
    """Solve. What the engine says if it gives up is kept for `read`, since the plate may have left long before."""
    system, settings = model.system.system, _simulation_settings(model)
    with _quiet():
        try:
            system.SolveDynamic(settings, solverType=_SOLVERS[model.setting["solver"]])
        except exu.ExudynError as problem:
            model.failure = " ".join(str(problem).split())[:200]
    iteration = system.sys["dynamicSolver"].it
    model.cost = Cost(steps=int(iteration.currentStepIndex), evaluations=int(iteration.newtonStepsCount))


def _simulation_settings(model: Model):
    case, setting = model.case, model.setting
    settings = exu.SimulationSettings()
    # A step that fits the duration to a millionth of a step is not made smaller for its rounding.
    steps = max(1, ceil(case.duration / setting["h"] - 1e-6))
    settings.timeIntegration.endTime = case.duration
    settings.timeIntegration.numberOfSteps = steps
    settings.timeIntegration.newton.useModifiedNewton = setting["newton"] == "modified"
    settings.solution.file.write = False
    # A period below every step stores every step.
    settings.solution.sensors.writePeriod = 1e-12 if steps <= MOST_SAMPLES else case.duration / MOST_SAMPLES
    return settings


@contextmanager
def _quiet():
    """The engine's console is one switch for the whole process: off for the run, then as it was."""
    before = exu.config.printToConsole
    exu.config.printToConsole = False
    try:
        yield
    finally:
        exu.config.printToConsole = before


# --- read -----------------------------------------------------------------------------------------------------------


def read(model: Model) -> Trajectory:
    """The run as a Trajectory, cut where the plate leaves its track. Raises EngineFailure if it is no motion."""
    t, pose, velocity, force = _stored(model.system)
    contact = model.system.contact(pose, velocity, force)
    known = len(contact.gap)
    rows = np.column_stack(
        [t[:known], pose[:known], velocity[:known]]
        + [contact.slip, contact.normal_force, contact.friction_force, contact.xi1, contact.xi2]
    )
    end = first_ending(model.case, model.setting, rows[:, 0], contact)
    if end is None and model.failure:
        raise EngineFailure(f"Exudyn stopped at {t[-1]:.4g} s: {model.failure}.")
    if end is None and contact.lost:
        raise EngineFailure(f"Exudyn's plate lost its track: {contact.lost}.")
    if end is not None:
        rows = _cut(rows, end)
    t, x, y, theta, vx, vy, omega, slip, normal_force, friction_force, xi1, xi2 = rows.T
    return Trajectory(
        *(t, x, y, theta, vx, vy, omega, slip, normal_force, friction_force, xi1, xi2),
        status=Trajectory.status if end is None else end.status,
        reason=Trajectory.reason if end is None else end.reason,
        cost=model.cost,
        slip_resolution=model.setting["vreg"],
    )


def _stored(system: System) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Times, pose (n, 3), velocity (n, 3) and contact force (n, 3 or 0) of the run."""
    pose, velocity = (system.system.GetSensorStoredData(sensor) for sensor in system.motion)
    force = pose[:, :1] if system.force is None else system.system.GetSensorStoredData(system.force)
    # An unstable explicit run ends without an error.
    if not all(np.isfinite(table).all() for table in (pose, velocity, force)):
        raise EngineFailure("Exudyn's run blew up: its coordinates are not finite numbers.")
    return pose[:, 0], pose[:, 1:4], velocity[:, 1:4], force[:, 1:]


class Ending(NamedTuple):
    """The motion ends between the samples `sample` − 1 and `sample`, after `share` of that step, and why."""

    sample: int
    share: float
    status: str
    reason: str


def first_ending(case: Case, setting: Setting, t: np.ndarray, contact: Contact) -> Ending | None:
    """What ends the motion before its time, or None."""
    endings = [lift_off(case, setting, t, contact)]
    endings += [_domain_end("track", case.track, contact.xi1), _domain_end("outline", case.plate.outline, contact.xi2)]
    return min((end for end in endings if end), key=lambda end: end[:2], default=None)


def lift_off(case: Case, setting: Setting, t: np.ndarray, contact: Contact) -> Ending | None:
    """Where the plate, on its way off the track, stops being pressed; None if it stays, or if the track also pulls.

    A penalty contact loses touch for an instant when it is set down without its deflection, and by rounding at a
    release with N = 0. It then rises by about the static deflection m g/k or by what gravity does in a step, g h²/2;
    a plate clear of its track by ten times as much has left, and it left where it was last pressed.
    """
    if case.effect(Unilateral) is None:
        return None
    _, acceleration = scales(case)
    rise = acceleration * (case.plate.mass / setting["k"] + 0.5 * setting["h"] ** 2)
    clear = np.flatnonzero(contact.gap > 10.0 * rise)
    if not clear.size:
        return None
    pressed = np.flatnonzero(contact.normal_force[: clear[0]] > 0.0)
    index = int(pressed[-1]) + 1 if pressed.size else 0
    share = 0.0
    if index >= 2:
        (t0, t1, t2), (N0, N1) = t[index - 2 : index + 1], contact.normal_force[index - 2 : index]
        # A force that does not fall there (a bounce) has no zero to extrapolate to; the last press is the end.
        share = min(N1 / (N0 - N1) * (t1 - t0) / (t2 - t1), 1.0) if N0 > N1 else 0.0
    return Ending(index, share, "lift_off", "The contact stopped pushing and the plate left its track.")


def _domain_end(name: str, curve: Curve, xi: np.ndarray) -> Ending | None:
    if curve.domain is None or curve.period:
        return None
    low, high = curve.domain
    outside = np.flatnonzero((xi < low) | (xi > high))
    # Rounding may put the start itself outside; it is on the curve.
    if not outside.size or not outside[0]:
        return None
    before, after = xi[outside[0] - 1 : outside[0] + 1]
    share = ((high if after > high else low) - before) / (after - before)
    return Ending(int(outside[0]), float(share), f"{name}_end", f"The contact reached the end of the {name}'s domain.")


def _cut(rows: np.ndarray, end: Ending) -> np.ndarray:
    """The rows of the motion up to its end, whose own row lies between two of the run's."""
    kept = rows[: max(end.sample, 1)]
    if end.share <= 0.0:
        return kept
    last = rows[end.sample - 1] + end.share * (rows[end.sample] - rows[end.sample - 1])
    if end.status == "lift_off":
        last[_FORCES] = 0.0
    return np.vstack([kept, last])
