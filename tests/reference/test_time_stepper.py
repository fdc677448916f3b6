"""Motions with several contacts are the limits of an independent time stepper: Moreau's midpoint rule.

The stepper has no events and no modes. In each step it takes the contacts whose gap at mid-step is not positive, and
finds velocities at the step's end that obey Coulomb's law and Moreau's law of impact with e = 0, by projected
Gauss-Seidel on impulses. It shares only the cases' shapes with the reference. (J. J. Moreau, Unilateral contact and dry
friction in finite freedom dynamics, 1988; known to us, not looked up.)
"""

from __future__ import annotations

from math import cos, pi, sin, tan
from typing import NamedTuple

import numpy as np
import pytest

import cases
import reference
from cases import Case, CoulombFriction, Flight, Gravity, Impact, StartPose, Support, Unilateral, disc
from cases.contact.outline_features import features
from cases.curves.corner import Corner
from cases.curves.line_or_circle import as_circle, as_line
from cases.library import line
from cases.motion.mechanics import gravity
from cases.scene.free_plates import names_of, plates_of, start_poses

# Sweeps of Gauss-Seidel, and the change of an impulse over the largest one at which they end.
SWEEPS, SETTLED = 20_000, 1e-10
# Rounding of a gap of numbers of size 1.
TOUCHES = 1e-13


class Touch(NamedTuple):
    """A contact: coefficient of friction, gap (m), and its rows of normal and slip velocity, (3 plates,)."""

    mu: float
    gap: float
    lift: np.ndarray
    slip: np.ndarray


def touches(case: Case, q: np.ndarray) -> dict[tuple, Touch]:
    """All contacts in a pose (plates, 3), by the numbers of their plate and of what it touches."""
    plates, found = plates_of(case), dict[tuple, Touch]()
    sides = [(case.track, case.effects), *((one.curve, one.acting(case.effects)) for one in case.supports)]
    for body, plate in enumerate(plates):
        x, y, theta = q[body]
        for number, (curve, effects) in enumerate(sides):
            straight, t = as_line(curve), np.asarray(as_line(curve).direction)
            n = np.array([-t[1], t[0]])
            for index, feature in enumerate(features(plate.outline)):
                circle = None if isinstance(feature, Corner) else as_circle(feature)
                u, v = circle.centre if circle else (feature.x, feature.y)
                arm = np.array([cos(theta) * u - sin(theta) * v, sin(theta) * u + cos(theta) * v])
                arm = arm - (circle.radius if circle else 0.0) * n
                gap = float(n @ (np.array([x, y]) + arm - straight.point))
                found[body, "side", number, index] = _touch(_mu(effects), gap, n, t, [(body, arm, 1.0)], len(plates))
        for base in range(body):
            off = q[body, :2] - q[base, :2]
            n = off / np.hypot(*off)
            parts = [(body, -plate.radius * n, 1.0), (base, plates[base].radius * n, -1.0)]
            gap = float(np.hypot(*off)) - plate.radius - plates[base].radius
            found[body, "plate", base, 0] = _touch(
                _mu(case.effects), gap, n, np.array([n[1], -n[0]]), parts, len(plates)
            )
    return found


def _mu(effects) -> float:
    return next((effect.mu for effect in effects if isinstance(effect, CoulombFriction)), 0.0)


def _touch(mu: float, gap: float, n: np.ndarray, t: np.ndarray, parts: list, count: int) -> Touch:
    rows = np.zeros((2, 3 * count))
    for body, arm, sign in parts:
        for row, d in zip(rows, (n, t), strict=True):
            row[3 * body : 3 * body + 3] = sign * d[0], sign * d[1], sign * (arm[0] * d[1] - arm[1] * d[0])
    return Touch(mu, gap, *rows)


def step_through(case: Case, h: float) -> np.ndarray:
    """The poses of all plates at the end of the case, (plates, 3), by steps of about h (s)."""
    steps = round(case.duration / h)
    h, start = case.duration / steps, start_poses(case)
    q, u = start[:, :3].copy(), start[:, 3:].ravel().copy()
    inverse = np.array([1.0 / v for plate in plates_of(case) for v in (plate.mass, plate.mass, plate.inertia)])
    pull = np.tile([*gravity(case), 0.0], len(q))
    last = dict[tuple, tuple[float, float]]()
    for _ in range(steps):
        middle = q + 0.5 * h * u.reshape(-1, 3)
        u = u + h * pull
        closed = {key: one for key, one in touches(case, middle).items() if one.gap <= TOUCHES}
        if closed:
            last = {key: last.get(key, (0.0, 0.0)) for key in closed}
            u, last = _project(u, inverse, closed, last)
        q = middle + 0.5 * h * u.reshape(-1, 3)
    return q


def _project(u, inverse, closed, impulses) -> tuple[np.ndarray, dict]:
    """Velocities at a step's end, and the impulses: normal velocities not negative, friction in its cone."""
    impulses = dict(impulses)
    for key, one in closed.items():
        u = u + inverse * (impulses[key][0] * one.lift + impulses[key][1] * one.slip)
    weights = {
        key: (1.0 / float(one.lift @ (inverse * one.lift)), 1.0 / float(one.slip @ (inverse * one.slip)))
        for key, one in closed.items()
    }
    for _ in range(SWEEPS):
        change = 0.0
        for key, one in closed.items():
            push, hold = impulses[key]
            new = max(0.0, push - weights[key][0] * float(one.lift @ u))
            u = u + inverse * ((new - push) * one.lift)
            bound = one.mu * new
            other = min(max(hold - weights[key][1] * float(one.slip @ u), -bound), bound)
            u = u + inverse * ((other - hold) * one.slip)
            impulses[key] = new, other
            change = max(change, abs(new - push), abs(other - hold))
        if change <= SETTLED * max(max(push for push, _ in impulses.values()), 1e-300):
            return u, impulses
    raise AssertionError("Gauss-Seidel does not converge")


def rocking_in_a_v() -> Case:
    """A disc that rolls to and fro in a V of two planes; four hand-overs, each an impact."""
    alpha, r, way = pi / 9, 0.5, 0.3
    flank = r * tan(alpha) + way
    start = StartPose(-flank * cos(alpha) + r * sin(alpha), flank * sin(alpha) + r * cos(alpha))
    effects = Gravity(9.81), Unilateral(), Flight(), Impact(0.0, "moreau"), CoulombFriction(1.0)
    return Case(line(alpha), disc(r, 1.0), effects, start, 2.6, supports=(Support(line(-alpha), "right"),))


def ladder(**values) -> Case:
    return cases.load("ladder_at_wall", mu=0.1, **values)


# Without a change of a contact the order is 2 where all contacts stay closed, and 1 where a curved one opens for single
# steps.
SMOOTH = {
    "ladder at wall and floor": ladder(mu_wall=0.2, duration=0.8),
    "block that rocks to its first impact": cases.load("rocking_block", duration=0.3),
    "disc that rolls on a free disc": cases.load("disc_on_free_disc", mu=0.5, duration=0.5),
    "pile that slides apart": cases.load("pile_of_discs", mu=0.08, duration=0.35),
}
# An impact or a lift-off is up to a step late, by a part that changes from step to step.
WITH_EVENTS = {
    "ladder that leaves its wall": ladder(mu_wall=0.2, duration=1.0),
    "disc in a V, six changes": rocking_in_a_v(),
    "block, ten changes": cases.load("rocking_block"),
    "disc on a free disc, three changes": cases.load("disc_on_free_disc", mu=0.5),
    "pile, seven changes": cases.load("pile_of_discs", mu=0.08),
}
STEPS = 8e-3, 4e-3, 2e-3, 1e-3, 5e-4


def errors(case: Case, other: Case | None = None) -> tuple[list[float], int]:
    """The largest error of a pose at the end (m, rad) by each step, and the number of changes of mode; `other`: the
    case that the stepper runs."""
    motion = reference.simulate(case, rtol=1e-10)
    plates = [motion.plate(name) for name in names_of(case)]
    exact = np.array([[float(getattr(one, column)[-1]) for column in ("x", "y", "theta")] for one in plates])
    off = [float(np.abs(step_through(other or case, h) - exact).max()) for h in STEPS]
    return off, len(motion.transitions)


def order(off: list[float]) -> float:
    """The order of convergence, by the best line through the logarithms."""
    return float(np.polyfit(np.log(STEPS), np.log(off), 1)[0])


@pytest.mark.slow
@pytest.mark.parametrize("name", SMOOTH)
def test_a_time_stepper_converges_to_motions_without_changes(name):
    off, changes = errors(SMOOTH[name])
    assert changes == 0
    assert order(off) > 0.9 and off[-1] < 1e-3


@pytest.mark.slow
@pytest.mark.parametrize("name", WITH_EVENTS)
def test_a_time_stepper_converges_to_motions_with_impacts_and_lift_offs(name):
    off, changes = errors(WITH_EVENTS[name])
    assert changes > 0
    # Events late by a step, with up to 3 m/s, in a motion with ten of them: 8 h.
    assert order(off) > 0.7 and off[-1] < 8.0 * STEPS[-1]


@pytest.mark.slow
def test_a_time_stepper_with_another_friction_does_not_converge_to_the_motion():
    case = WITH_EVENTS["disc on a free disc, three changes"]
    off, _ = errors(case, cases.load("disc_on_free_disc", mu=0.4))
    assert off[-1] > 8.0 * STEPS[-1] and order(off) < 0.5
