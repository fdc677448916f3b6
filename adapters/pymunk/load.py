"""A load in pymunk: a force and a moment that are set in every step, when the engine updates its velocities."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite

import pymunk

from cases import Case, Load
from cases.scene.free_plates import loads_of

from ..common.starts import starts_of

Torsor = tuple[float, float, float]


class LoadInSteps:
    """The load of a plate in one run; `rows` are (F_x, F_y, M) in N and N m of every step, `problem` an error of its
    formula.

    The engine moves its bodies first, then updates their velocities: at that point the pose belongs to the step's time
    t, while the velocities are half a step earlier and are extrapolated to t by their last change.
    """

    def __init__(self, load: Load, start: Sequence[float], body: pymunk.Body, h: float):
        self.rows: list[Torsor] = []
        self.problem: Exception | None = None
        self._at, self._body, self._h = load.at, body, h
        vx, vy, omega = (float(rate) for rate in start[3:6])
        self._before = vx, vy, omega
        body.velocity_func = self._update

    def torsor(self) -> Torsor:
        """(F_x, F_y, M) at the body's present pose, in N and N m; zero after an error of the formula."""
        (x, y), (vx, vy), omega = self._body.position, self._body.velocity, self._body.angular_velocity
        number, (before_x, before_y, before) = len(self.rows), self._before
        # The first velocities are the start's, the second half a step away from them.
        part = 0.5 if number > 1 else float(number)
        vx, vy, omega = vx + part * (vx - before_x), vy + part * (vy - before_y), omega + part * (omega - before)
        try:
            fx, fy, moment = self._at(self._h * number, x, y, self._body.angle, vx, vy, omega)
        except (ArithmeticError, ValueError) as problem:
            self.problem = self.problem or problem
            return 0.0, 0.0, 0.0
        if not (isfinite(fx) and isfinite(fy) and isfinite(moment)):
            self.problem = self.problem or ValueError(f"it is not finite at t = {self._h * number:.6g} s")
            return 0.0, 0.0, 0.0
        return fx, fy, moment

    def _update(self, body: pymunk.Body, gravity: tuple[float, float], damping: float, dt: float) -> None:
        """The engine's call for new velocities."""
        fx, fy, moment = self.torsor()
        (vx, vy), omega = body.velocity, body.angular_velocity
        self._before = vx, vy, omega
        self.rows.append((fx, fy, moment))
        body.force, body.torque = (fx, fy), moment
        pymunk.Body.update_velocity(body, gravity, damping, dt)


def loads_in_steps(case: Case, bodies: Sequence[pymunk.Body], h: float) -> list[LoadInSteps | None]:
    """The loads of all plates in one run of steps of h (s); None of a plate without one."""
    return [
        LoadInSteps(load, start, body, h) if load else None
        for load, start, body in zip(loads_of(case), starts_of(case).tolist(), bodies, strict=True)
    ]
