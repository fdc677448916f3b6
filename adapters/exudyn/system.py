"""Code that the routes of the Exudyn adapter share: an assembled system, and its contact read from a run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import copysign, hypot, isnan, sqrt
from typing import Any, NamedTuple, Protocol

import numpy as np

from cases import Case, CoulombFriction, Gravity, Load, PerfectlyRough, Unilateral
from cases.contact import MotionPoint, belt_speed, start_motion
from cases.curves.line_or_circle import Circle
from cases.effects import E
from cases.motion.mechanics import gravity as gravity_of
from cases.scene.free_plates import plates_of

from ..common.facets import round_plate
from ..common.one_contact import ContactAlong
from ..interface import EngineFailure, Setting


class HasEffects(Protocol):
    """A case, a pair of features, or a contact: the effects that act there."""

    def effect(self, kind: type[E], /) -> E | None:
        """The effect of that kind, or None."""


class SensorData(NamedTuple):
    """Sensor data: times (n,), pose and velocity (n, 3), force or acceleration (n, 3), or (n, 0) without a sensor."""

    t: np.ndarray
    pose: np.ndarray
    velocity: np.ndarray
    force: np.ndarray


def planar_data(data: SensorData) -> SensorData:
    """The data of sensors of a body in the plane: its three coordinates."""
    return data._replace(pose=data.pose[:, :3], velocity=data.velocity[:, :3])


@dataclass(frozen=True)
class ExudynSystem:
    """An assembled system in the container that owns it.

    `motions`: the sensors of pose and velocity of each plate; `forces`: the sensor of each contact's force, of a
    constraint that of the acceleration; `contact`: a function that computes the only contact from their data, None
    where there may be several; `in_plane`: a function that gives data in the plane of motion.
    """

    container: Any
    system: Any
    motions: tuple[tuple[int, int], ...]
    forces: tuple[int, ...] = ()
    contact: Callable[[SensorData], ContactAlong] | None = None
    in_plane: Callable[[SensorData], SensorData] = planar_data

    def tables(self, sensors: Sequence[int]) -> list[np.ndarray]:
        """What sensors have stored: rows of the time and the values. Raises EngineFailure for what is not finite."""
        tables = [self.system.GetSensorStoredData(sensor) for sensor in sensors]
        # An unstable explicit run ends without an error.
        if not all(np.isfinite(table).all() for table in tables):
            raise EngineFailure("Exudyn's run diverged: its coordinates are not finite numbers.")
        return tables

    def data(self) -> SensorData:
        """The sensor data of the only plate."""
        pose, velocity, *force = self.tables((*self.motions[0], *self.forces))
        return self.in_plane(SensorData(pose[:, 0], pose[:, 1:], velocity[:, 1:], (force or [pose[:, :1]])[0][:, 1:]))


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
    if not k or setting.is_default or isnan(start.xi1_dot):
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


def friction_coefficient(acting: HasEffects) -> float:
    """The friction coefficient mu, at rest if it depends on the slip velocity; zero without friction."""
    friction = acting.effect(CoulombFriction)
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


def clear_gap(case: Case, setting: Setting) -> float:
    """A gap (m) that only a plate that has left its track reaches.

    A penalty contact opens for an instant if it starts without its deflection, and by rounding at a release with N = 0.
    It then rises by about the deflection m a/k, with the acceleration a of gravity and of the track's curvature at the
    start, or by a h²/2 within a step. A plate with ten times that gap has left its track, at its last contact force.
    """
    _, acceleration = scales(case)
    start = start_motion(case)
    acceleration += (start.vx**2 + start.vy**2) * abs(float(case.track.curvature(start.xi1)))
    mass = sum(plate.mass for plate in plates_of(case))
    return 10.0 * acceleration * (mass / setting["k"] + 0.5 * setting["h"] ** 2)
