"""Engines with a known error, made of the reference's motions: what a physicist would say of them is known. And a
semi-implicit Euler engine of our own, with an error that its step alone decides."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

import reference
from cases import Case, CoulombFriction, Load, Mode, Trajectory, Transition
from cases.effects import MOTION
from reports.judging import friction_sensitivity, null_motions
from reports.judging.friction_factor import friction_factor
from reports.judging.score import Scale, Score, scale_of, score
from tests.scenes.motions import sampled

SAMPLES = 2000
FRICTION = 60.0
LESS_FRICTION = 0.95
CREEP = 2e-5  # m/s
DAMPING = 1e-3  # 1/s
EXTRA_SLIP = 6e-6  # s


@dataclass(frozen=True)
class Judged:
    """A case with its truth, null motions, scale and sensitivity to friction."""

    case: Case
    truth: Trajectory
    nulls: dict[str, Trajectory]
    scale: Scale
    sensitivity: float

    def score(self, motion: Trajectory) -> Score:
        """The score of a motion."""
        return score(self.case, motion, self.truth, self.scale)

    def friction(self, motion: Trajectory) -> float:
        """Friction × of a motion."""
        return friction_factor(self.case, motion, self.scale.losses, self.scale.end)


@lru_cache(maxsize=4)
def judged(case: Case) -> Judged:
    """What the motions of a case are judged by."""
    truth = reference.simulate(case, rtol=1e-13)
    nulls = null_motions.null_motions(case)
    scale = scale_of(case, truth, truth.transitions, nulls)
    return Judged(case, truth, nulls, scale, friction_sensitivity.friction_sensitivity(case, truth, {"": scale}))


def _simulated(case: Case) -> Trajectory:
    return sampled(reference.simulate(case, rtol=1e-12), SAMPLES)


def with_friction(case: Case, factor: float) -> Trajectory:
    """The motion with so many times the friction."""
    friction = case.effect(CoulombFriction)
    assert friction is not None
    return _simulated(null_motions.with_friction(case, mu=factor * friction.mu))


def too_much_friction(truth: Judged) -> Trajectory:
    """Friction × 60."""
    return with_friction(truth.case, FRICTION)


def less_friction(truth: Judged) -> Trajectory:
    """Friction 5 % too small."""
    return with_friction(truth.case, LESS_FRICTION)


def creeping(truth: Judged) -> Trajectory:
    """Where the truth rolls it slips by 2e-5 m/s, and does not declare it."""
    motion = sampled(truth.truth, SAMPLES)
    slip = motion.slip.copy()
    for phase in truth.scale.phases:
        if phase.mode in (Mode.ROLL, Mode.REST):
            slip[(motion.t >= phase.begin) & (motion.t <= phase.end)] += CREEP
    return replace(motion, slip=slip)


def half_a_step_late(truth: Judged) -> Trajectory:
    """Velocities are those of half a step later than the poses."""
    motion = sampled(truth.truth, SAMPLES)
    later = truth.truth(np.minimum(motion.t + 0.5 * motion.t[1], truth.truth.t[-1]))
    slip = np.where(np.isfinite(motion.slip) & np.isfinite(later.slip), later.slip, motion.slip)
    return replace(motion, vx=later.vx, vy=later.vy, omega=later.omega, slip=slip)


def damped(truth: Judged) -> Trajectory:
    """All velocities lose 0.1 % a second."""
    case, plate = truth.case, truth.case.plate
    _, _, _, _, vx, vy, omega = MOTION
    load = case.effect(Load)
    fx, fy, moment = load.expression if load else (0, 0, 0)
    turning = DAMPING * plate.inertia * omega if plate.turns else 0.0
    damping = Load(fx - DAMPING * plate.mass * vx, fy - DAMPING * plate.mass * vy, moment - turning)
    return _simulated(replace(case, effects=(*(e for e in case.effects if not isinstance(e, Load)), damping)))


def slipping_in_an_impact(truth: Judged) -> Trajectory:
    """Exact, but at each landing and each end of slip it slips for 6 µs more, in the other direction."""
    events: list[Transition] = []
    for event in truth.truth.transitions:
        if event.after in (Mode.ROLL, Mode.REST):
            slips = Mode.SLIP_FORWARD if event.before is not Mode.SLIP_FORWARD else Mode.SLIP_BACKWARD
            events += [replace(event, after=slips), Transition(event.time + EXTRA_SLIP, slips, event.after)]
        else:
            events.append(event)
    exact = sampled(truth.truth, SAMPLES)
    return replace(exact, transitions=tuple(events), first_mode=truth.truth.first_mode or Mode.ROLL)


ENGINES: dict[str, Callable[[Judged], Trajectory]] = {
    "friction × 60": too_much_friction,
    "friction - 5 %": less_friction,
    "creep": creeping,
    "half a step late": half_a_step_late,
    "damping": damped,
    "6 µs of slip": slipping_in_an_impact,
}


def noisy(truth: Judged, samples: int, noise: float) -> Trajectory:
    """The exact motion with so many samples, and normal noise of its velocities: `noise` times the fastest speed."""
    exact = sampled(truth.truth, samples)
    size = noise * float(np.hypot(truth.truth.vx, truth.truth.vy).max())
    random = np.random.default_rng(0)
    moved = {name: getattr(exact, name) + size * random.standard_normal(samples) for name in ("vx", "vy", "slip")}
    return replace(exact, **moved, omega=exact.omega + size / truth.case.plate.reach * random.standard_normal(samples))
