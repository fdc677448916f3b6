"""Code that the routes of the Exudyn adapter share: an assembled system, and its contact read from a run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import copysign, hypot, isnan, sqrt
from typing import Any, NamedTuple

import exudyn as exu
import exudyn.itemInterface as item
import numpy as np

from cases import Case, CoulombFriction, Flight, Gravity, Load, PerfectlyRough, Unilateral
from cases.contact import MotionPoint, belt_speed, start_motion
from cases.line_or_circle import Circle
from cases.mechanics import gravity as gravity_of

from ..common.facets import round_plate
from ..interface import Setting
from . import older_versions


@dataclass(frozen=True)
class ExudynContact:
    """The contact along a run, arrays of one length: parameters, gap (m), slip (m/s), forces on the plate (N).

    Shorter than the run if the plate lost its track, for the reason `failure`.
    """

    xi1: np.ndarray
    xi2: np.ndarray
    gap: np.ndarray
    slip: np.ndarray
    normal_force: np.ndarray
    friction_force: np.ndarray
    failure: str | None = None


class SensorData(NamedTuple):
    """Sensor data: times (n,), pose and velocity (n, 3), force or acceleration (n, 3), or (n, 0) without a sensor."""

    t: np.ndarray
    pose: np.ndarray
    velocity: np.ndarray
    force: np.ndarray


@dataclass(frozen=True)
class ExudynSystem:
    """An assembled system in the container that owns it.

    `motion`: the sensors of pose and velocity; `force`: the sensor of the contact's forces, if there is one; `contact`:
    a function that computes the contact from their data; `others`: the sensors of the forces of further supports.
    """

    container: Any
    system: Any
    motion: tuple[int, int]
    force: int | None
    contact: Callable[[SensorData], ExudynContact]
    others: tuple[int, ...] = ()


def node_sensors(system, node: int) -> tuple[int, int]:
    """Sensors that store a node's coordinates and velocities in memory."""
    pose, velocity = (
        system.AddSensor(item.SensorNode(nodeNumber=node, outputVariableType=kind, storeInternal=True))
        for kind in (exu.OutputVariableType.Coordinates, exu.OutputVariableType.Coordinates_t)
    )
    return pose, velocity


def disc_circle(case: Case) -> Circle:
    """The circle of a round plate."""
    circle = round_plate(case)
    assert circle is not None, "refuses() accepts only discs"
    return circle


def static_start(case: Case, setting: Setting, depth: float = 1.0) -> MotionPoint:
    """The start in equilibrium with the contact law.

    It has the deflection under the initial normal force, and the creep of the initial friction.

    A plate that starts without them falls onto the contact's spring; for some steps the force is many times the weight
    or zero, and friction oscillates. Friction acts at the fraction `depth` of the deflection, on a lever that is
    shorter by as much. The centre's velocity is corrected for that, so that a rolling plate does not begin with slip.
    """
    start, k = start_motion(case), setting.get("k")
    # With default settings the plate starts at the case's own pose.
    if not k or setting.is_default or isnan(start.xi1_dot) or case.supports:
        return start
    force, creep = first_force(case, start, setting["vreg"])
    penetration = force / k
    (tx, ty), (nx, ny) = case.track.tangent(start.xi1).tolist(), case.track.normal(start.xi1).tolist()
    along = start.omega * depth * penetration + creep
    return start._replace(
        x=start.x - nx * penetration, y=start.y - ny * penetration, vx=start.vx + tx * along, vy=start.vy + ty * along
    )


def first_force(case: Case, start: MotionPoint, vreg: float) -> tuple[float, float]:
    """The normal force (N) at the start, and the slip velocity (m/s) at which the law gives the friction there.

    They follow from the motion: the plate's contact point stays on the track and, if it sticks, does not slip. With the
    contact's position c, its arc length s along the track, and the lever ρ from the centre of mass to c, the
    derivatives of its velocity v + ω × ρ along normal and tangent give

        n·(a + α × ρ + ω × (ċ − v)) = κ ṡ v_t    and, in stick,    t·(a + α × ρ + ω × (ċ − v)) = 0

    Zero for a contact that would have to pull, and where rigid friction has no unique solution (Painlevé).
    """
    plate, load = case.plate, case.effect(Load)
    (tx, ty), (nx, ny) = case.track.tangent(start.xi1).tolist(), case.track.normal(start.xi1).tolist()
    along = float(case.track.speed(start.xi1)) * start.xi1_dot
    px, py = (case.track.point(start.xi1) - (start.x, start.y)).tolist()
    fx, fy = (plate.mass * gravity_of(case)).tolist()
    moment = 0.0
    if load:
        lx, ly, moment = load.at(0.0, start.x, start.y, start.theta, start.vx, start.vy, start.omega)
        fx, fy = fx + lx, fy + ly
    lever_n, lever_t = px * ny - py * nx, px * ty - py * tx
    turned_x, turned_y = -start.omega * (along * ty - start.vy), start.omega * (along * tx - start.vx)
    bend = float(case.track.curvature(start.xi1)) * along * (start.slip + belt_speed(case, 0.0))
    normal_free = (nx * fx + ny * fy) / plate.mass + lever_n * moment / plate.inertia
    normal_free += nx * turned_x + ny * turned_y - bend
    tangent_free = (tx * fx + ty * fy) / plate.mass + lever_t * moment / plate.inertia
    tangent_free += tx * turned_x + ty * turned_y
    normal_ease, tangent_ease = (1.0 / plate.mass + lever**2 / plate.inertia for lever in (lever_n, lever_t))
    coupling = lever_n * lever_t / plate.inertia

    def normal_at(friction: float) -> float:
        """The normal force if friction is `friction` times as large."""
        ease = normal_ease + friction * coupling
        return -normal_free / ease if ease > 0.0 else 0.0

    rough, mu = case.effect(PerfectlyRough) is not None, friction_coefficient(case)
    if not rough and (mu == 0.0 or abs(start.slip) > vreg):
        force, share = normal_at(-mu * copysign(1.0, start.slip)), 0.0
    else:
        force = (coupling * tangent_free - tangent_ease * normal_free) / (normal_ease * tangent_ease - coupling**2)
        friction = -(tangent_free + coupling * force) / tangent_ease
        bound = rough_friction(case) if rough else mu * abs(force)
        share = -friction / bound if bound > 0.0 else 0.0
        if not rough and abs(share) > 1.0:
            share = copysign(1.0, share)
            force = normal_at(-mu * share)
    if case.effect(Unilateral) and force <= NOTHING * plate.mass * scales(case)[1]:
        return 0.0, 0.0
    return force, share * vreg


def disc_body(case: Case, start: MotionPoint, system) -> tuple[int, int]:
    """Add the plate as a rigid body in the plane at a start, with gravity and load.

    Returns its node, and a marker at the centre of its circle, which need not be the centre of mass.
    """
    plate, gravity, load, circle = case.plate, case.effect(Gravity), case.effect(Load), disc_circle(case)
    node = system.AddNode(
        item.NodeRigidBody2D(
            initialCoordinates=[start.x, start.y, start.theta], initialVelocities=[start.vx, start.vy, start.omega]
        )
    )
    body = system.AddObject(
        item.ObjectRigidBody2D(nodeNumber=node, **older_versions.rigid_body(plate.mass, plate.inertia))
    )
    disc = system.AddMarker(item.MarkerBodyRigid(bodyNumber=body, localPosition=[*circle.centre.tolist(), 0.0]))
    if gravity:
        pull = [*gravity.vector, 0.0]
        mass = system.AddMarker(item.MarkerBodyMass(bodyNumber=body))
        system.AddLoad(item.LoadMassProportional(markerNumber=mass, loadVector=pull))
    if load:

        def now(system, time: float) -> list[float]:
            state = system.systemData
            return load.at(time, *state.GetODE2Coordinates(), *state.GetODE2Coordinates_t())

        def force(system, time, _vector) -> list[float]:
            return [*now(system, time)[:2], 0.0]

        def moment(system, time, _vector) -> list[float]:
            return [0.0, 0.0, now(system, time)[2]]

        mass_marker = system.AddMarker(item.MarkerBodyRigid(bodyNumber=body))
        system.AddLoad(item.LoadForceVector(markerNumber=mass_marker, loadVectorUserFunction=force))  # type: ignore[arg-type]
        system.AddLoad(item.LoadTorqueVector(markerNumber=mass_marker, loadVectorUserFunction=moment))  # type: ignore[arg-type]
    return node, disc


def ground(system, point: np.ndarray) -> int:
    """Add a marker of the ground at a point of the plane."""
    body = system.AddObject(item.ObjectGround(referencePosition=[*point, 0.0]))
    return system.AddMarker(item.MarkerBodyRigid(bodyNumber=body))


def external_forces(case: Case, data: SensorData) -> np.ndarray:
    """Gravity and load, the forces other than the contact's: (F_x, F_y) in N at the stored times, shape (n, 2)."""
    force, gravity, load = np.zeros((len(data.t), 2)), case.effect(Gravity), case.effect(Load)
    if gravity:
        force += case.plate.mass * np.array(gravity.vector)
    if load:
        rows = zip(data.t.tolist(), data.pose.tolist(), data.velocity.tolist(), strict=True)
        force += [load.at(t, *pose, *velocity)[:2] for t, pose, velocity in rows]
    return force


# Forces below this share of the weight are rounding, such as the force at a release on a vertical wall.
NOTHING = 1e-9
# Friction and gravity change the slip at some multiples of g (1 + mu); this multiple is above that of every plate.
MOST_GRAVITIES = 20.0


def steps_until(
    case: Case, setting: Setting, system, slip: Callable[[Any], float], speed: Callable[[], float] | None = None
) -> None:
    """With `cut` in the setting, repeat a step in which the slip changes its sign with a smaller step.

    Friction changes sign within such a step, and the trapezoidal rule gives each side half of the step wherever the
    crossing is: a contact that should stick then slips backward, by up to h/2 of the acceleration, and where friction
    is near its bound it takes many steps to come to rest. The engine lets a user function request another step size, as
    its contacts do where they close (`SetPostNewtonUserFunction`). This function requests the step to the zero of the
    slip, interpolated from `slip` (m/s) at the step's beginning and end, but at least the share `cut` of h; a slip
    below vreg sticks anyway. `speed` gives the size of the slip at less cost, if the engine has it: a slip too fast to
    be stopped within a step needs no check. (An impact may stop any slip, so a case with Flight does not use `speed`.)
    """
    if "cut" not in setting:
        return
    smallest, vreg = setting["cut"] * setting["h"], setting["vreg"]
    time_of, begin, end = system.systemData.GetTime, exu.ConfigurationType.StartOfStep, exu.ConfigurationType.Current
    sign, accept = copysign(1.0, case.start.slip), [0.0, -1.0]
    fast = MOST_GRAVITIES * (1.0 + friction_coefficient(case)) * scales(case)[1] * setting["h"]
    speed = None if case.effect(Flight) else speed

    def ask(_system, time: float) -> list[float]:
        """[error, step to repeat with], or [0, −1] to accept the step."""
        nonlocal sign
        # Called in every iteration; nearly always it ends here.
        if speed and speed() > fast:
            return accept
        slip_after = slip(end)
        if slip_after * sign >= 0.0 or abs(slip_after) <= vreg:
            return accept
        slip_before, step = slip(begin), time - time_of(begin)
        sign = copysign(1.0, slip_after)
        if slip_before * slip_after >= 0.0 or step <= smallest:
            return accept
        sign = copysign(1.0, slip_before)
        # Any error above the solver's tolerance of 1 makes it repeat the step.
        return [10.0, max(step * abs(slip_before) / (abs(slip_before) + abs(slip_after)), smallest)]

    system.SetPostNewtonUserFunction(ask)


def friction_coefficient(case: Case) -> float:
    """The friction coefficient mu, at rest if it depends on the slip velocity; zero without friction."""
    friction = case.effect(CoulombFriction)
    return friction.at_rest if friction else 0.0


def critical_damping(mass: float, setting: Setting) -> float:
    """The damping in N s/m with which a mass (kg) settles on the contact's spring without bouncing."""
    return 2.0 * sqrt(setting["k"] * mass)


def scales(case: Case) -> tuple[float, float]:
    """The length (m; centre of mass to contact) and acceleration (m/s²) that scale the rungs."""
    start = start_motion(case)
    length = float(np.hypot(*case.plate.outline.point(start.xi2)))
    gravity = case.effect(Gravity)
    speed, load = max(abs(start.slip), abs(start.omega) * length), case.effect(Load)
    # Without gravity the load at the start (on a track that turns gravity is one) and the motion set the scale; a plate
    # at rest without either stays at rest at any scale.
    pull = hypot(*load.at(0.0, *start[:6])[:2]) / case.plate.mass if load else 0.0
    acceleration = gravity.g if gravity and gravity.g > 0.0 else max(speed**2 / length, pull)
    return length, acceleration or 1.0


def rough_friction(case: Case) -> float:
    """The friction (N) at which a perfectly rough contact creeps with vreg: mass times the scale of acceleration."""
    return case.plate.mass * scales(case)[1]
