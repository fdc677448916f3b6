"""Null motions: what a plate does when friction's law is ignored. They are the scale of every error in `score`.

The one rests where it starts, the next slides without friction, the last rolls from the start.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import nan
from typing import Any

import numpy as np

import reference
from cases import Belt, Case, CaseError, CoulombFriction, Mode, RollingResistance, Trajectory
from cases.contact import start_motion
from cases.motion.sampled_contacts import SampledPlates
from cases.motion.trajectory import EVEN_TIMES
from cases.scene.free_plates import names_of, start_poses


def frictionless(case: Case) -> Trajectory:
    """The motion without friction; raises CaseError if the case has none to leave out."""
    if case.effect(CoulombFriction) is None:
        raise CaseError("the case has no friction to leave out")
    return reference.simulate(
        replace(case, effects=tuple(e for e in case.effects if not isinstance(e, CoulombFriction | Belt)))
    )


def rolling(case: Case) -> Trajectory:
    """The motion with friction that never gives way, its centre as fast as at the start; CaseError but for a disc."""
    if case.plate.radius is None or not case.plate.turns or case.effect(CoulombFriction) is None:
        raise CaseError("only a disc with friction has a rolling counterpart here")
    # Rolling needs a friction force far below 1e3 times the normal force wherever that is positive.
    omega = case.start.omega - case.start.slip / case.plate.radius
    return reference.simulate(replace(with_friction(case, mu=1e3), start=replace(case.start, slip=0.0, omega=omega)))


def resting(case: Case) -> Trajectory:
    """All plates stay where they are at the start; their forces are not known."""
    start = start_motion(case)
    here = dict(x=start.x, y=start.y, theta=start.theta, xi1=start.xi1, xi2=start.xi2)
    still = dict(vx=0.0, vy=0.0, omega=0.0, slip=0.0, normal_force=nan, friction_force=nan)
    times = np.linspace(0.0, case.duration, EVEN_TIMES)
    columns: dict[str, Any] = {name: np.full(EVEN_TIMES, value) for name, value in (here | still).items()}
    rolls = case.effect(RollingResistance) is None and (case.plate.turns or case.others)
    mode = Mode.ROLL if rolls else Mode.REST
    motion = Trajectory(t=times, **columns, first_mode=mode)
    if not case.others:
        return motion
    plates = {
        name: np.repeat(np.append(pose[:3], np.zeros(3))[:, None], EVEN_TIMES, axis=1)
        for name, pose in zip(names_of(case), start_poses(case), strict=True)
    }
    return replace(motion, plate_names=names_of(case), plate_columns=SampledPlates(times, plates))


NULL_MOTIONS: dict[str, Callable[[Case], Trajectory]] = {
    "never moves": resting,
    "no friction": frictionless,
    "rolls from the start": rolling,
}


def null_motions(case: Case) -> dict[str, Trajectory]:
    """The null motions that the case has, by name."""
    motions = {}
    for name, motion in NULL_MOTIONS.items():
        try:
            motions[name] = motion(case)
        except CaseError:  # no friction to leave out, or the plate is not a disc; `resting` always exists
            continue
    return motions


def with_friction(case: Case, *, mu: float | Any) -> Case:
    """The case with another coefficient of friction, a number or a formula; the static one in proportion."""
    friction = case.effect(CoulombFriction)
    assert friction is not None, "the case has Coulomb friction"
    other = CoulombFriction(mu)
    if friction.mu_static is not None:
        other = CoulombFriction(mu, friction.mu_static * other.at_rest / friction.at_rest)
    return replace(case, effects=tuple(other if isinstance(e, CoulombFriction) else e for e in case.effects))
