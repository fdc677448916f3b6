"""Exudyn (Gerstmayr, multibody dynamics with penalty contact; https://exudyn.readthedocs.io) on the suite's scenes.

`native` takes the engine's own smooth contacts: a disc in or on a circle is ObjectContactSphereSphere, a disc on a
straight line ObjectContactSphereTriangle. Both press with a spring and a damper and regularise Coulomb's law: below
`vreg` friction grows with the slip velocity, so what sticks creeps. (ObjectConnectorRollingDiscPenalty, made for lines,
is exact while it slips; where it should roll it chattered about zero slip in half the runs tried, at up to a hundred
times its `vreg`.)

A setting's `h` is the step (s), `k` the contact stiffness (N/m), `vreg` the regularisation (m/s). They are tightened
together: the stiffness and the regularisation are errors of the model, which a smaller step alone would keep.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import contextmanager
from dataclasses import dataclass
from math import ceil, cos, hypot, sin, sqrt
from typing import Any

import exudyn as exu
import exudyn.itemInterface as item
import numpy as np

from cases import Case, Cost, CoulombFriction, DoesNotFit, Gravity, Trajectory, Unilateral
from cases.contact import follow, start_motion
from cases.errors import unknown
from cases.shapes import Circle, Line, as_circle, as_line

from .interface import EngineFailure, Setting

NAME = "exudyn"
routes = ("native",)

# Samples of one run: enough to extrapolate a transition to the accuracy of the finest rung, few enough to keep a
# thousand trajectories in memory.
MOST_SAMPLES = 20_000

# What the coarse-to-fine rungs multiply: step / sqrt(r/g), stiffness / (m g/r), vreg / sqrt(r g). For a disc of
# 0.1 m and 1 kg under gravity that is 0.1 s, 98 N/m and 1 m/s. The engine's error is C/k + O(h²) and, in stick, a
# share of vreg; the last stiffness is the largest before rounding of the penetration disturbs Newton's method.
RUNGS = (
    (1e-1, 1e3, 1e-3),
    (3e-2, 1e4, 3e-4),
    (1e-2, 1e5, 1e-4),
    (5e-3, 1e6, 3e-5),
    (2.5e-3, 3e6, 1e-5),
    (1.25e-3, 1e7, 3e-6),
)

# The engine's own defaults: 100 steps whatever the duration, generalized-alpha, modified Newton, and a
# regularisation in m/s. Only the stiffness has no default: a penetration of a thousandth of the radius is typed.
DEFAULT_STEPS, DEFAULT_VREG = 100, 1e-3

_SOLVERS = {
    "GeneralizedAlpha": exu.DynamicSolverType.GeneralizedAlpha,
    "TrapezoidalIndex2": exu.DynamicSolverType.TrapezoidalIndex2,
    "RK44": exu.DynamicSolverType.RK44,
}


@dataclass(frozen=True)
class Contact:
    """The engine's contact along a run, arrays of one length: gap (m), slip (m/s), forces on the plate (N)."""

    gap: np.ndarray
    slip: np.ndarray
    normal_force: np.ndarray
    friction_force: np.ndarray


@dataclass
class Model:
    """An assembled system, the numbers of its sensors, and how the engine's contact is read from what they store."""

    case: Case
    setting: Setting
    system: Any
    sensors: tuple[int, ...]
    contact: Callable[[np.ndarray, np.ndarray, np.ndarray], Contact]
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
            return f"Exudyn's contact objects have nothing for {type(effect).__name__}."
    friction = case.effect(CoulombFriction)
    if friction and friction.stick != friction.mu:
        return "Exudyn's contact objects know one friction coefficient; mu_static cannot differ from mu."
    if case.effect(Unilateral) is None:
        return "Exudyn's contact objects only push; a track that also pulls (no Unilateral) is not among them."
    if case.plate.radius is None:
        return "Exudyn has smooth rolling contact for discs alone, and this outline is no circle about its centre."
    if as_line(case.track) is None and as_circle(case.track) is None:
        return "Exudyn has smooth rolling contact on straight lines and circles alone, and this track is neither."
    return None


# --- settings -------------------------------------------------------------------------------------------------------


def ladder(case: Case, route: str) -> tuple[Setting, ...]:
    """Settings from coarse to fine; the first is what the engine does unless told otherwise."""
    length, acceleration = scales(case)
    time, stiffness = sqrt(length / acceleration), case.plate.mass * acceleration / length
    defaults = Setting.of(
        rung="defaults",
        solver="GeneralizedAlpha",
        newton="modified",
        h=_rounded(case.duration / DEFAULT_STEPS),
        k=_rounded(1e3 * stiffness),
        vreg=DEFAULT_VREG,
    )
    finer = (
        Setting.of(
            rung=number,
            solver="TrapezoidalIndex2",
            newton="full",
            h=_rounded(h * time),
            k=_rounded(k * stiffness),
            vreg=_rounded(vreg * length / time),
        )
        for number, (h, k, vreg) in enumerate(RUNGS, start=1)
    )
    return (defaults, *finer)


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


# --- build ----------------------------------------------------------------------------------------------------------


def build(case: Case, route: str, setting: Setting) -> Model:
    """The engine's system for the case, assembled."""
    start, plate = start_motion(case), case.plate
    system = exu.SystemContainer().AddSystem()
    node = system.AddNode(
        item.NodeRigidBody2D(
            initialCoordinates=[start.x, start.y, start.theta], initialVelocities=[start.vx, start.vy, start.omega]
        )
    )
    body = system.AddObject(item.ObjectRigidBody2D(nodeNumber=node, mass=plate.mass, inertia=plate.inertia))
    disc = system.AddMarker(item.MarkerBodyRigid(bodyNumber=body))
    gravity = case.effect(Gravity)
    if gravity:
        pull = [gravity.g * cos(gravity.direction), gravity.g * sin(gravity.direction), 0.0]
        mass = system.AddMarker(item.MarkerBodyMass(bodyNumber=body))
        system.AddLoad(item.LoadMassProportional(markerNumber=mass, loadVector=pull))
    line, circle = as_line(case.track), as_circle(case.track)
    if line:
        number, contact = _on_line(case, setting, system, disc, line)
    else:
        assert circle is not None, "refuses() lets lines and circles alone pass"
        number, contact = _on_circle(case, setting, system, disc, circle)
    sensors = (
        system.AddSensor(_sensor(item.SensorNode, exu.OutputVariableType.Coordinates, nodeNumber=node)),
        system.AddSensor(_sensor(item.SensorNode, exu.OutputVariableType.Coordinates_t, nodeNumber=node)),
        system.AddSensor(_sensor(item.SensorObject, exu.OutputVariableType.Force, objectNumber=number)),
    )
    system.Assemble()
    return Model(case, setting, system, sensors, contact)


def _sensor(kind, output, **where):
    return kind(outputVariableType=output, storeInternal=True, writeToFile=False, **where)


def _friction(case: Case) -> float:
    friction = case.effect(CoulombFriction)
    return friction.mu if friction else 0.0


def _radius(case: Case) -> float:
    assert case.plate.radius is not None, "refuses() lets discs alone pass"
    return case.plate.radius


def _critical_damping(case: Case, setting: Setting) -> float:
    """So that the plate settles on the contact's spring without bouncing, in the spring's own time."""
    return 2.0 * sqrt(setting["k"] * case.plate.mass)


def _on_circle(case: Case, setting: Setting, system, disc: int, circle: Circle):
    ground = system.AddObject(item.ObjectGround(referencePosition=[*circle.centre, 0.0]))
    centre = system.AddMarker(item.MarkerBodyRigid(bodyNumber=ground))
    radius = _radius(case)
    number = system.AddObject(
        item.ObjectContactSphereSphere(
            markerNumbers=[disc, centre],
            nodeNumber=system.AddNode(item.NodeGenericData(initialCoordinates=[0.0] * 4, numberOfDataCoordinates=4)),
            spheresRadii=[radius, circle.radius],
            isHollowSphere1=circle.left,
            dynamicFriction=_friction(case),
            frictionProportionalZone=setting["vreg"],
            contactStiffness=setting["k"],
            contactDamping=_critical_damping(case, setting),
        )
    )

    def contact(pose, velocity, force) -> Contact:
        away = pose[:, :2] - circle.centre
        distance = np.hypot(away[:, 0], away[:, 1])
        inward = -1.0 if circle.left else 1.0
        normal = inward * away / distance[:, None]
        gap = inward * (distance - circle.radius) - radius
        # The engine's friction acts in the middle of the overlap.
        return _read_contact(normal, gap, radius + 0.5 * gap, velocity, force[:, 0:2])

    return number, contact


def _on_line(case: Case, setting: Setting, system, disc: int, line: Line):
    normal = np.array([-line.direction[1], line.direction[0]])
    radius = _radius(case)
    number = system.AddObject(
        item.ObjectContactSphereTriangle(
            markerNumbers=[
                disc,
                system.AddMarker(item.MarkerBodyRigid(bodyNumber=system.AddObject(item.ObjectGround()))),
            ],
            nodeNumber=system.AddNode(item.NodeGenericData(initialCoordinates=[0.0] * 4, numberOfDataCoordinates=4)),
            sphereRadius=radius,
            trianglePoints=exu.Vector3DList(_ground_triangle(case, line)),  # type: ignore[call-arg]
            includeEdges=0,
            dynamicFriction=_friction(case),
            frictionProportionalZone=setting["vreg"],
            contactStiffness=setting["k"],
            contactDamping=_critical_damping(case, setting),
        )
    )

    def contact(pose, velocity, force) -> Contact:
        gap = (pose[:, :2] - line.point) @ normal - radius
        # The engine's friction acts on the triangle's plane.
        return _read_contact(np.broadcast_to(normal, (len(gap), 2)), gap, radius + gap, velocity, force[:, :2])

    return number, contact


def _ground_triangle(case: Case, line: Line) -> list[list[float]]:
    """A triangle across the plane of motion, around the start and wider than the plate can get in its time."""
    start, gravity = start_motion(case), case.effect(Gravity)
    fall = 0.5 * gravity.g * case.duration**2 if gravity else 0.0
    reach = 2.0 * (_radius(case) + hypot(start.vx, start.vy) * case.duration + fall)
    (x, y), (along_x, along_y) = case.track.point(start.xi1), reach * line.direction
    return [[x - along_x, y - along_y, -reach], [x + along_x, y + along_y, -reach], [x, y, 2.0 * reach]]


def _read_contact(normal, gap, arm, velocity, force) -> Contact:
    tangent = np.column_stack([normal[:, 1], -normal[:, 0]])
    slip = np.sum(velocity[:, :2] * tangent, axis=1) + velocity[:, 2] * arm
    return Contact(gap, slip, np.sum(force * normal, axis=1), np.sum(force * tangent, axis=1))


# --- run ------------------------------------------------------------------------------------------------------------


def run(model: Model) -> None:
    """Solve. What the engine says if it gives up is kept for read()."""
    settings = _simulation_settings(model)
    with _quiet():
        try:
            model.system.SolveDynamic(settings, solverType=_SOLVERS[model.setting["solver"]])
        except exu.ExudynError as problem:
            model.failure = " ".join(str(problem).split())[:200]
    iteration = model.system.sys["dynamicSolver"].it
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
    stored = [model.system.GetSensorStoredData(sensor) for sensor in model.sensors]
    # An unstable explicit run ends without an error, in numbers that are not finite or far from any scene.
    if not all(np.isfinite(table).all() for table in stored):
        raise EngineFailure("Exudyn's run blew up: its coordinates are not finite numbers.")
    t, (pose, velocity, force) = stored[0][:, 0], (table[:, 1:] for table in stored)
    contact = model.contact(pose, velocity, force)
    columns = np.column_stack(
        [t, pose[:, :3], velocity[:, :3], contact.slip, contact.normal_force, contact.friction_force]
    )
    left = departure(model.case, model.setting, contact)
    if left is None and model.failure:
        raise EngineFailure(f"Exudyn stopped at {t[-1]:.4g} s: {model.failure}.")
    if left is not None:
        columns = _cut(columns, left)
    t, x, y, theta, vx, vy, omega, slip, normal, friction = columns.T
    try:
        xi1, xi2, _ = follow(model.case, x, y, theta)
    except DoesNotFit as problem:
        raise EngineFailure(f"Exudyn's plate is not at its track: {problem}.") from problem
    reason = "The motion ran to its end." if left is None else f"The plate leaves its track at {t[-1]:.6g} s."
    return Trajectory(
        *(t, x, y, theta, vx, vy, omega, slip, normal, friction, xi1, xi2),
        status="completed" if left is None else "lift_off",
        reason=reason,
        cost=model.cost,
        slip_resolution=model.setting["vreg"],
    )


def departure(case: Case, setting: Setting, contact: Contact) -> int | None:
    """The first sample at which the plate, on its way off the track, is no longer pressed; None if it stays.

    A penalty contact loses touch for an instant when it is set down without its deflection, and by rounding at a
    release with N = 0. It then rises by about the static deflection m g/k or by what gravity does in a step, g h²/2;
    a plate clear of its track by ten times as much has left, and it left where it was last pressed.
    """
    _, acceleration = scales(case)
    rise = acceleration * (case.plate.mass / setting["k"] + 0.5 * setting["h"] ** 2)
    clear = np.flatnonzero(contact.gap > 10.0 * rise)
    if not clear.size:
        return None
    pressed = np.flatnonzero(contact.normal_force[: clear[0]] > 0.0)
    return int(pressed[-1]) + 1 if pressed.size else 0


def _cut(columns: np.ndarray, left: int) -> np.ndarray:
    """Rows up to sample `left`, the last one moved to where the normal force, extrapolated, is zero."""
    if left < 2:
        return columns[: left + 1]
    (t0, N0), (t1, N1), t2 = columns[left - 2, [0, 8]], columns[left - 1, [0, 8]], columns[left, 0]
    # A force that does not fall there (a bounce) has no zero to extrapolate to; the last press is the end.
    end = min(t1 + N1 * (t1 - t0) / (N0 - N1), t2) if N0 > N1 else t1
    last = columns[left - 1] + (end - t1) / (t2 - t1) * (columns[left] - columns[left - 1])
    last[8:] = 0.0
    return np.vstack([columns[:left], last])
