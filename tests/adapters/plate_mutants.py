"""Adapters with one mistake about several free plates."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cases import Case, CoulombFriction, FreePlate, Impact, Plate, Trajectory
from cases.motion.sampled_contacts import SampledPlates
from cases.scene.free_plates import names_of

from .mutants import Mutant, case_mutant, effect, of_case


def _others(change):
    """A change of a case: of each of its free plates."""
    return lambda case: replace(case, others=tuple(map(change, case.others)))


def _with_plate(change):
    """A change of a free plate: of its mass and inertia."""

    def changed(other: FreePlate) -> FreePlate:
        return replace(other, plate=change(other.plate))

    return _others(changed)


def _alone(friction: bool):
    """A change of a motion: free plates move as at the start, without the force of the contact (or its friction)."""

    def spoil(case: Case, motion: Trajectory) -> Trajectory:
        own = {name: _columns(motion, name) for name in names_of(case)}
        for name in names_of(case)[1:]:
            rows = [2, 5] if friction else [0, 2, 3, 5]
            own[name][rows] = own[name][rows, :1]
        return replace(motion, plate_columns=SampledPlates(motion.t, own))

    return spoil


def _columns(motion: Trajectory, name: str) -> np.ndarray:
    own = motion.plate(name)
    return np.array([getattr(own, column) for column in ("x", "y", "theta", "vx", "vy", "omega")])


def _swapped(case: Case, motion: Trajectory) -> Trajectory:
    """The motion with the last two plates taken for each other."""
    names = names_of(case)
    own = {name: _columns(motion, name) for name in names}
    own[names[-1]], own[names[-2]] = own[names[-2]], own[names[-1]]
    return replace(motion, plate_columns=SampledPlates(motion.t, own))


def _heavy(plate: Plate) -> Plate:
    return replace(plate, mass=1.05 * plate.mass)


FREE_PLATES = [
    Mutant("free plates swapped", "row_of_free_plates", "vx of", lambda: of_case(spoil=_swapped)),
    Mutant(
        "no friction on the other plate",
        "friction_of_free_plates",
        "the reaction on the other plate",
        lambda: of_case(spoil=_alone(friction=True)),
    ),
    Mutant(
        "no force on the other plate",
        "collision_of_free_plates",
        "the reaction on the other plate",
        lambda: of_case(spoil=_alone(friction=False)),
    ),
    case_mutant("mass of free plates 5 % too large", "collision_of_free_plates", "mass of each", _with_plate(_heavy)),
    case_mutant(
        "inertia of free plates that of the first",
        "friction_of_free_plates",
        "inertia of each",
        lambda case: _with_plate(lambda p: replace(p, inertia=case.plate.inertia))(case),
    ),
    case_mutant(
        "mu of two discs multiplied",
        "friction_of_free_plates",
        "mu of CoulombFriction",
        effect(CoulombFriction, lambda e: CoulombFriction(e.mu**2)),
    ),
    case_mutant(
        "restitution of two discs multiplied",
        "collision_of_free_plates",
        "restitution of Impact",
        effect(Impact, lambda e: replace(e, restitution=e.restitution**2)),
    ),
    case_mutant("mass of a free polygon 5 % too large", "wedge_of_free_plates", "mass of the", _with_plate(_heavy)),
    case_mutant(
        "a pile without friction between plates",
        "pile_of_free_plates",
        "the way of",
        effect(CoulombFriction, lambda e: None),
    ),
]
