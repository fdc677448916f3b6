"""Whether the modes and forces that a solver states are those of its own samples. Pure functions; SI units."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cases import Case, Drive, Mode, Trajectory
from cases.contact import track_place
from cases.motion import mechanics
from cases.own_effects import own_effects

from . import doubts
from .phases import phases_of
from .slip_phases import RESOLVABLE_GAPS, ROUNDING, SURELY

# Stated forces may differ from the change of momentum by this part: facets turn them by up to a tenth of a radian, and
# an engine's damping takes as much.
_FORCE_SHARE = 0.2
# Fewest steps that decide: at an impact or a kink one or two differ.
_FEWEST_STEPS = 3


def forces_hold(case: Case, motion: Trajectory) -> bool:
    """Whether the forces that a motion of one contact states make its own change of momentum, in half of the steps in
    contact: else its lift-offs and its onsets of slip would be read from another motion.

    A force that changes within a step is known to half of that change, and velocities are to their noise. True for a
    motion without forces, with several contacts, or known at every time."""
    driven = case.effect(Drive) is not None
    several = case.others or len(motion.contact_names) > 1 or (driven and own_effects(case.effects))
    if several or motion.dense is not None or len(motion.t) <= _FEWEST_STEPS:
        return True
    has_force = np.isfinite(motion.xi1) & np.isfinite(motion.normal_force) & np.isfinite(motion.friction_force)
    dt = np.diff(motion.t)
    steps = has_force[1:] & has_force[:-1] & (dt > 0.0)
    if not steps.any():
        return True
    place, angle = np.where(has_force, motion.xi1, case.start.xi1), track_place(case, motion.t).angle
    along, across = case.track.tangent(place), case.track.normal(place)
    x, y = np.nan_to_num(motion.normal_force) * across + np.nan_to_num(motion.friction_force) * along
    c, s = np.cos(angle), np.sin(angle)
    contact, mass = np.array([c * x - s * y, s * x + c * y]), case.plate.mass
    force = contact + mass * mechanics.gravity(case)[:, None] + mechanics.applied_forces(case, motion)[:2]
    velocity = np.array([motion.vx, motion.vy])
    dt = np.where(steps, dt, 1.0)
    off = np.hypot(*(mass * np.diff(velocity, axis=1) / dt - 0.5 * (force[:, 1:] + force[:, :-1])))
    noise = float(np.linalg.norm([doubts.roughness(motion.t, rate) for rate in velocity]))
    size = 0.5 * (np.hypot(*contact[:, 1:]) + np.hypot(*contact[:, :-1]))
    rounding = ROUNDING * float(np.hypot(*velocity).max())
    bound = _FORCE_SHARE * size + 0.5 * np.hypot(*np.diff(force, axis=1)) + mass * (SURELY * noise + rounding) / dt
    wrong = int(np.sum((off > bound) & steps))
    return wrong < _FEWEST_STEPS or 2 * wrong <= int(steps.sum())


def without_forces(motion: Trajectory) -> Trajectory:
    """The motion with unknown forces in contact, and none in flight."""
    unknown = np.where(np.isnan(motion.xi1), 0.0, np.nan)
    return replace(motion, normal_force=unknown, friction_force=unknown)


def claims_hold(motion: Trajectory) -> bool:
    """Whether the modes that a motion's solver names are those of its own samples: it slips nowhere by more than twice
    its creep where it is said to roll, and nowhere the other way where it is said to slip, except next to a change.

    True for a motion that names none, and for one that is known at every time."""
    if motion.first_mode is None or motion.dense is not None:
        return True
    least, end = RESOLVABLE_GAPS * doubts.gap(motion), float(motion.t[-1])
    signs = {Mode.ROLL: 0.0, Mode.REST: 0.0, Mode.SLIP_FORWARD: 1.0, Mode.SLIP_BACKWARD: -1.0}
    phases = [p for p in phases_of(motion.first_mode, motion.transitions, end) if p.mode in signs]
    inside = [(motion.t > p.begin + least) & (motion.t < p.end - least) & np.isfinite(motion.slip) for p in phases]
    still = [i for p, i in zip(phases, inside, strict=True) if not signs[p.mode]]
    rolls = np.abs(motion.slip[np.any(still, axis=0)]) if still else np.zeros(0)
    creep = float(np.quantile(rolls, 0.5)) if len(rolls) else 0.0
    largest = SURELY * max(creep, motion.slip_resolution, ROUNDING * float(np.hypot(motion.vx, motion.vy).max()))
    wrong = [
        (np.abs(motion.slip[i]) > largest) & (np.sign(motion.slip[i]) != signs[phase.mode])
        for phase, i in zip(phases, inside, strict=True)
    ]
    return sum(int(samples.sum()) for samples in wrong) <= RESOLVABLE_GAPS
