"""A complete adapter in one file: a disc with Coulomb friction on a straight line. Replace `run` by your engine.

Put it into a package of yours, with this in its pyproject.toml, and every command knows the engine by that name:

    [project.entry-points."slip_to_roll.adapters"]
    my_engine = "my_package.adapter"

It steps as many engines do: velocities first, impulses clamped by Coulomb's law, then the pose. `adapters.interface`
lists what else an adapter may define.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np

from adapters import Refusal, Setting
from adapters.common import half_steps
from cases import Case, CoulombFriction, Gravity, Trajectory, Unilateral
from cases.contact import start_motion
from cases.curves.line_or_circle import as_line

NAME = "my_engine"
routes = ("native",)
EFFECTS = (Gravity, CoulombFriction, Unilateral)


def version() -> str:
    """Results are stored under it: raise it when the engine changes."""
    return "1.0"


def refuses(case: Case, route: str) -> str | None:
    """What is not refused here is claimed to be right."""
    missing = [type(effect).__name__ for effect in case.effects if type(effect) not in EFFECTS]
    if missing:
        return f"{NAME} does not support {' and '.join(missing)}."
    if case.plate.radius is None or as_line(case.track) is None:
        return Refusal(f"{NAME} has discs on straight lines only.", "it has no other shapes")
    friction = case.effect(CoulombFriction)
    if friction and friction.stick != friction.at_rest:
        return f"{NAME} has one coefficient of friction for slip and stick."
    return None


def ladder(case: Case, route: str) -> tuple[Setting, ...]:
    """The default setting, then from coarse to fine; a case longer than 2.5 s has longer steps."""
    stretch = max(1.0, case.duration / 2.5)
    finer = (Setting.of(h=h * stretch) for h in (5e-3, 2e-3, 1e-3, 5e-4, 2e-4))
    return (Setting.of(rung="defaults", h=1 / 60), *finer)


@dataclass
class Model:
    """One run: the case, step (s) and number of steps, and the recorded rows (x, y, theta, vx, vy, omega)."""

    case: Case
    h: float
    steps: int
    rows: np.ndarray


def build(case: Case, route: str, setting: Setting) -> Model:
    """The scene at its start; not timed."""
    steps = max(60, round(case.duration / setting["h"]))
    return Model(case, case.duration / steps, steps, np.empty((steps + 1, 6)))


def run(model: Model) -> None:
    """All steps; only this is timed. The first one is half a step, so that poses are between velocities."""
    case, h, start = model.case, model.h, start_motion(model.case)
    line, friction, pull = as_line(case.track), case.effect(CoulombFriction), case.effect(Gravity)
    assert line is not None, "checked by `refuses`"
    tx, ty = map(float, line.direction)
    m, r, inertia = case.plate.mass, case.plate.radius, case.plate.inertia if case.plate.turns else inf
    gx, gy = pull.vector if pull else (0.0, 0.0)
    along, across, mu = gx * tx + gy * ty, gy * tx - gx * ty, friction.mu if friction else 0.0
    x, y, theta = start.x, start.y, start.theta
    u, omega, span = start.vx * tx + start.vy * ty, start.omega, 0.5 * h
    for k in range(model.steps + 1):
        u += span * along
        most = mu * m * max(0.0, -across) * span
        push = max(-most, min(most, -(u + r * omega) / (1.0 / m + r * r / inertia)))
        u, omega, span = u + push / m, omega + push * r / inertia, h
        model.rows[k] = x, y, theta, u * tx, u * ty, omega
        x, y, theta = x + h * u * tx, y + h * u * ty, theta + h * omega


def read(model: Model) -> Trajectory:
    """The motion at the poses' times; half_steps computes slip, forces, contacts and the end."""
    return half_steps.read(half_steps.StepRecord(model.case, model.h, model.steps, model.rows))
