"""Random scenes, and the same in other units, up to 1e9 times as large or small (lengths 1e7)."""

from __future__ import annotations

import random
from typing import NamedTuple

from cases import Case
from tests.scenes.lifted_plates import lifted_plate
from tests.scenes.motions import in_other_units
from tests.scenes.ties import tie

# The largest powers of ten by which the units are multiplied: a plate is at least 1e-9 m and at most 1e9 m long.
LARGEST = 7, 9, 9


class Rescaling(NamedTuple):
    """A case, the same case in other units, and how many of these are one old unit of length, time and mass."""

    case: Case
    other: Case
    length: float
    time: float
    mass: float


def scene_in_units(seed: int) -> Rescaling:
    """A lifted plate or a tie, with its lengths, times and masses, one of them or all, multiplied."""
    chance = random.Random(f"units {seed}")
    case = lifted_plate(seed).case if seed % 2 else tie(seed).case
    units = [10.0 ** chance.randint(-most, most) for most in LARGEST]
    only = chance.choice([None, 0, 1, 2])
    length, time, mass = (unit if only in (None, i) else 1.0 for i, unit in enumerate(units))
    other = in_other_units(case, length, time, mass, 0.0)
    return Rescaling(case, other, length, time, mass)
