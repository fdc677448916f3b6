"""The suite's contact geometry and law in Exudyn's ObjectGenericODE2: any plate on any track, the engine's solver.

The law has the form of the engine's own contacts: a spring k and a damper d along the normal, Coulomb friction that
grows linearly with the slip velocity up to vreg. It acts at the track's contact point. A perfectly rough contact has no
bound: friction grows further, and a rolling plate creeps with vreg where friction equals its weight.
"""

from __future__ import annotations

from collections.abc import Callable
from math import copysign, hypot, isnan
from typing import Any, NamedTuple

import exudyn as exu
import exudyn.itemInterface as item
import numpy as np

from cases import Belt, Case, CoulombFriction, Load, PerfectlyRough, Unilateral
from cases.motion.mechanics import gravity

from ..common.flights import BEYOND, Follower
from ..common.one_contact import ContactAlong
from ..interface import Setting
from .bodies import node_sensors
from .system import (
    ExudynSystem,
    SensorData,
    critical_damping,
    friction_coefficient,
    rough_friction,
    static_start,
)


class PenaltyState(NamedTuple):
    """Contact at one instant: parameters, lever of the contact point (m), unit tangent, gap, slip, N, share of mu."""

    xi1: float
    xi2: float
    ax: float
    ay: float
    tx: float
    ty: float
    gap: float
    slip: float
    normal_force: float
    share: float


class PenaltyContact:
    """The contact law for one run; it stores the last contact point as the start of the next search."""

    def __init__(self, case: Case, setting: Setting):
        self.case, self.k, self.vreg = case, setting["k"], setting["vreg"]
        self.damping, self.mu = critical_damping(case.plate.mass, setting), friction_coefficient(case)
        friction = case.effect(CoulombFriction)
        self.by_speed = friction.at if friction and friction.by_speed else None
        self.load, belt = case.effect(Load), case.effect(Belt)
        self.belt = belt.at if belt else None
        self.rough = rough_friction(case) if case.effect(PerfectlyRough) else 0.0
        self.unilateral = case.effect(Unilateral) is not None
        self.follower, self.track_jet = Follower(case), case.track.jet
        # Of the last evaluation. The engine asks for force and Jacobian of one state, two fifths of all evaluations.
        self.slip = case.start.slip
        self._last: tuple[tuple[float, ...], PenaltyState] | None = None

    def touch(self, time: float, pose, velocity) -> PenaltyState:
        """The contact of a state; raises one of BEYOND where there is none."""
        state = (time, *pose, *velocity)
        if self._last is None or self._last[0] != state:
            self._last = state, self._touch(*state)
        return self._last[1]

    def _touch(self, time: float, x: float, y: float, theta: float, vx: float, vy: float, omega: float) -> PenaltyState:
        xi1, xi2, gap = self.follower(x, y, theta)
        if isnan(xi1):
            return PenaltyState(xi1, xi2, 0.0, 0.0, 1.0, 0.0, gap, 0.0, 0.0, 0.0)
        X, Y, Xp, Yp, _, _, _, _ = self.track_jet(xi1)
        speed = hypot(Xp, Yp)
        tx, ty, ax, ay = Xp / speed, Yp / speed, X - x, Y - y
        ux, uy = vx - omega * ay, vy + omega * ax
        slip, parting = ux * tx + uy * ty, uy * tx - ux * ty
        if self.belt:
            slip -= self.belt(time)[0]
        normal_force = -self.k * gap - self.damping * parting
        if self.unilateral and (gap >= 0.0 or normal_force < 0.0):
            normal_force = 0.0
        share = slip / self.vreg if self.rough else max(-1.0, min(1.0, slip / self.vreg))
        return PenaltyState(xi1, xi2, ax, ay, tx, ty, gap, slip, normal_force, share)

    def friction_force(self, touch: PenaltyState) -> float:
        """The friction force (N) along the track's tangent, against the slip velocity."""
        if self.rough:
            return -self.grip(touch) * touch.share
        return -self.coefficient(touch) * abs(touch.normal_force) * touch.share

    def coefficient(self, touch: PenaltyState) -> float:
        """The coefficient of friction at a slip velocity."""
        return self.by_speed(abs(touch.slip)) if self.by_speed else self.mu

    def grip(self, touch: PenaltyState) -> float:
        """The friction (N) of a perfectly rough contact that creeps with vreg.

        Where the plate may leave, it decreases with the last hundredth of the weight, so that friction does not end
        with a jump.
        """
        return min(self.rough, 100.0 * abs(touch.normal_force)) if self.unilateral else self.rough

    def force(self, _system, time, _object, pose, velocity) -> list[float]:
        """The engine's call for the generalised forces (F_x, F_y, M): the contact's and the load's."""
        contact = self.contact_force(time, pose, velocity)
        if self.load is None:
            return contact
        return [a + b for a, b in zip(contact, self.load.at(time, *pose, *velocity), strict=True)]

    def contact_force(self, time: float, pose, velocity) -> list[float]:
        """The contact's part of the generalised forces; zero for a plate that has lost its track."""
        try:
            touch = self.touch(time, pose, velocity)
        except BEYOND:
            return [0.0, 0.0, 0.0]
        self.slip = touch.slip
        N, T = touch.normal_force, self.friction_force(touch)
        fx, fy = T * touch.tx - N * touch.ty, T * touch.ty + N * touch.tx
        return [fx, fy, touch.ax * fy - touch.ay * fx]

    def jacobian(self, _system, time, _object, pose, velocity, by_pose, by_velocity) -> np.ndarray:
        """The engine's call for −(by_pose ∂f/∂q + by_velocity ∂f/∂q̇), to first order in the penetration.

        It neglects the motion of the contact point and the turn of the tangent, which are smaller by penetration over
        radius, and saves the engine four fifths of the evaluations that differences need.
        """
        try:
            touch = self.touch(time, pose, velocity)
        except BEYOND:
            return np.zeros((3, 3))
        N, ax, ay, tx, ty = touch.normal_force, touch.ax, touch.ay, touch.tx, touch.ty
        if N == 0.0 and self.unilateral:
            return np.zeros((3, 3))
        turn_t, turn_n = ax * ty - ay * tx, ax * tx + ay * ty
        spring = by_pose * self.k + by_velocity * self.damping
        if self.rough:
            viscous, slope = by_velocity * self.grip(touch) / self.vreg, 0.0
        else:
            # A coefficient's own slope is neglected: friction changes faster by `vreg` than by any law it may follow.
            mu = self.coefficient(touch)
            viscous = by_velocity * mu * abs(N) / self.vreg if abs(touch.share) < 1.0 else 0.0
            slope = copysign(mu, N) * touch.share
        p, q, r = -ty - slope * tx, tx - slope * ty, turn_n - slope * turn_t
        # Two outer products, of (p, q, r) with the normal and of the tangent with itself. Written out, because loops
        # take twice as long, and NumPy four times.
        return np.array(
            [
                [
                    spring * (p * -ty) + viscous * (tx * tx),
                    spring * (p * tx) + viscous * (tx * ty),
                    spring * (p * turn_n) + viscous * (tx * turn_t),
                ],
                [
                    spring * (q * -ty) + viscous * (ty * tx),
                    spring * (q * tx) + viscous * (ty * ty),
                    spring * (q * turn_n) + viscous * (ty * turn_t),
                ],
                [
                    spring * (r * -ty) + viscous * (turn_t * tx),
                    spring * (r * tx) + viscous * (turn_t * ty),
                    spring * (r * turn_n) + viscous * (turn_t * turn_t),
                ],
            ]
        )

    def slip_at(self, system) -> Callable[[Any], float]:
        """A function for the slip velocity (m/s) where a step begins or ends; at its end, of the last evaluation."""
        state, now = system.systemData, exu.ConfigurationType.Current

        def slip(configuration) -> float:
            if configuration == now:
                return self.slip
            pose, velocity = state.GetODE2Coordinates(configuration), state.GetODE2Coordinates_t(configuration)
            return self.touch(state.GetTime(configuration), pose.tolist(), velocity.tolist()).slip

        return slip

    def follow(self, data: SensorData) -> ContactAlong:
        """The contact along a run that begins at the case's start, up to the pose where it is lost."""
        self.follower, self._last = Follower(self.case), None
        rows, failure = [], None
        try:
            for t, q, v in zip(data.t.tolist(), data.pose.tolist(), data.velocity.tolist(), strict=True):
                touch = self.touch(t, q, v)
                force = touch.normal_force, self.friction_force(touch)
                rows.append((touch.xi1, touch.xi2, touch.gap, touch.slip, *force))
        except BEYOND as problem:
            failure = str(problem)
        xi1, xi2, gap, slip, normal_force, friction_force = np.array(rows, dtype=float).reshape(-1, 6).T
        return ContactAlong(xi1, xi2, gap, slip, normal_force, friction_force, failure)


def build(case: Case, setting: Setting) -> ExudynSystem:
    """Build three coordinates (x, y, θ), the plate's mass matrix, gravity, and the contact as a user function."""
    start, plate, law = static_start(case, setting), case.plate, PenaltyContact(case, setting)
    container = exu.SystemContainer()
    system = container.AddSystem()
    node = system.AddNode(
        item.NodeGenericODE2(
            numberOfODE2Coordinates=3,
            referenceCoordinates=[0.0] * 3,
            initialCoordinates=[start.x, start.y, start.theta],
            initialCoordinates_t=[start.vx, start.vy, start.omega],
        )
    )
    system.AddObject(
        item.ObjectGenericODE2(
            nodeNumbers=[node],
            massMatrix=np.diag([plate.mass, plate.mass, plate.inertia]),
            forceVector=[*(plate.mass * gravity(case)), 0.0],
            forceUserFunction=law.force,  # type: ignore[arg-type]
            jacobianUserFunction=law.jacobian,  # type: ignore[arg-type]
        )
    )
    steps_until(case, setting, system, law.slip_at(system))
    motion = node_sensors(system, node)
    system.Assemble()
    return ExudynSystem(container, system, (motion,), contact=law.follow)


def steps_until(case: Case, setting: Setting, system, slip: Callable[[Any], float]) -> None:
    """With `cut` in the setting, repeat a step in which the slip changes its sign with a smaller step.

    Friction changes sign within such a step, and the trapezoidal rule gives each side half of the step wherever the
    crossing is: a contact that should stick then slips backward, by up to h/2 of the acceleration, and where friction
    is near its bound it takes many steps to come to rest. The engine lets a user function request another step size, as
    its contacts do where they close (`SetPostNewtonUserFunction`). This function requests the step to the zero of the
    slip, interpolated from `slip` (m/s) at the step's beginning and end, but at least the share `cut` of h; a slip
    below vreg sticks anyway.
    """
    if "cut" not in setting:
        return
    smallest, vreg = setting["cut"] * setting["h"], setting["vreg"]
    time_of, begin, end = system.systemData.GetTime, exu.ConfigurationType.StartOfStep, exu.ConfigurationType.Current
    sign, accept = copysign(1.0, case.start.slip), [0.0, -1.0]

    def ask(_system, time: float) -> list[float]:
        """[error, step to repeat with], or [0, −1] to accept the step."""
        nonlocal sign
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
