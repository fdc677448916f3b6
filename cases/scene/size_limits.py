"""Sizes beyond which doubles have too few digits for an answer: rejected when a case is made.

Only quantities independent of the choice of coordinates are bounded: extents, ratios, and the distance of the contact
from the origin in sizes of the plate.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple
from functools import lru_cache
from math import hypot, isfinite
from typing import Any

from ..curves import Curve
from ..effects import Belt, CoulombFriction, Drive, Gravity, Load, RollingResistance, one
from ..errors import BadValue
from .plate import Plate
from .start import Start

# On a curve the normal force of a slip grows with a power of the coefficient. At 1e4 both integrators agree on the
# motion on a circle, at 1e5 they do not. Rubber on dry concrete has about 1.
STRONGEST_FRICTION = 1e4
# m. Mechanics has no length scale, but root finders and searches have: on the paper's disc both integrators agree from
# 1e-16 to 1e10 m, and do not at 1e12 m.
SMALLEST, LARGEST = 1e-9, 1e9
# Ratios enter the equations with their squares: 1e12 leaves four digits of sixteen.
RATIO = 1e6
# Positions are relative to the origin: so many sizes away from it, half of their digits remain for the contact.
FURTHEST = 1e8
# Speeds and accelerations enter as squares, multiplied by times and lengths; doubles end at 1e308. In m, s, kg.
TINY, ENORMOUS = 1e-60, 1e60


def check_sizes(case: Any) -> None:
    """Raise BadValue, with one sentence, for a number of a case at which solvers lose their digits."""
    extent, gravity = _extent(case.track, case.plate, case.start), case.effect(Gravity)
    for effects in (case.effects, *(part.effects or () for part in (*case.supports, *case.pairs))):
        friction, resistance = one(effects, CoulombFriction), one(effects, RollingResistance)
        if friction and friction.stick > STRONGEST_FRICTION:
            name = "mu" if friction.at_rest > STRONGEST_FRICTION else "mu_static"
            raise BadValue(
                f"{name} of CoulombFriction is {friction.stick:g}; give at most {STRONGEST_FRICTION:g}, or "
                "PerfectlyRough()"
            )
        if resistance and resistance.arm > RATIO * extent:
            raise BadValue(
                f"arm of RollingResistance is {resistance.arm / extent:.3g} times the plate's length; give at most "
                f"{RATIO:g} times"
            )
        check_belt(one(effects, Belt))
    check_drive(case.effect(Drive))
    _check_load(case.plate, case.effect(Load), case.start.motion(case.track, case.plate.outline)[:6])
    for other in case.others:
        _check_load(other.plate, other.load, astuple(other.start))
    _check_numbers({"g of Gravity": gravity.g if gravity else 0.0, "duration of the case": case.duration})
    if case.duration < TINY:
        raise BadValue(f"duration of the case is {case.duration:g}; give at least {TINY:g}")


def _check_load(plate: Plate, load: Load | None, state: Sequence[float]) -> None:
    """Raise BadValue for a load that is not finite or too large at the start: x, y, θ, vx, vy, ω."""
    values = [float(v) for v in load.at(0.0, *state)] if load else [0.0]
    if not all(isfinite(value) for value in values):
        raise BadValue("the Load has no finite value where the motion begins; give one that is finite at t = 0")
    largest = max(map(abs, values))
    if largest > ENORMOUS * plate.mass:
        raise BadValue(
            f"the Load is {largest:g} where the motion begins, {largest / plate.mass:.3g} times the plate's mass; give "
            f"one up to {ENORMOUS:g} times"
        )


def _check_numbers(numbers: dict[str, float]) -> None:
    """Raise BadValue for one that is too large."""
    for what, number in numbers.items():
        if abs(number) > ENORMOUS:
            raise BadValue(f"{what} is {number:g}; give a number up to {ENORMOUS:g}")


# Cached by arguments that do not include friction: scenes are often made again with another one.
@lru_cache(maxsize=1024)
def _extent(track: Curve, plate: Plate, start: Start) -> float:
    """The plate's length, m; raises BadValue for sizes of plate and start at which solvers lose their digits
    (exceptions are not cached)."""
    # An open outline may be a small part of its plate: the tip of a rod, whose centre of mass is far from it.
    extent = max(plate.width, plate.reach)
    if not SMALLEST <= extent <= LARGEST:
        raise BadValue(
            f"the plate is {extent:g} m long; give one between {SMALLEST:g} and {LARGEST:g} m, where solvers "
            "keep their digits"
        )
    gyration = plate.gyration / extent
    if not 1 / RATIO <= gyration <= RATIO:
        raise BadValue(
            f"the plate's radius of gyration, the root of inertia/mass, is {gyration:.3g} times its length; give an "
            f"inertia that brings it between {1 / RATIO:g} and {RATIO:g} times"
        )
    away = hypot(*track.point(start.xi1))
    if not away <= FURTHEST * extent:
        raise BadValue(
            f"the plate begins {away / extent:.3g} times its own length from the origin; give a place, or a track, "
            f"within {FURTHEST:g} times"
        )
    numbers = {
        "mass of the plate": plate.mass,
        "slip of Start": start.slip,
        "omega of Start": start.omega,
        "gap_rate of Start": start.gap_rate,
        "gap of Start": start.gap,
    }
    _check_numbers(numbers)
    if plate.mass < TINY:
        raise BadValue(f"mass of the plate is {plate.mass:g}; give at least {TINY:g}")
    return extent


def check_belt(belt: Belt | None) -> None:
    """Raise BadValue unless a belt has a speed of ordinary size where the motion begins."""
    if belt is not None and not all(isfinite(value) and abs(value) <= ENORMOUS for value in belt.at(0.0)):
        raise BadValue(
            f"speed of Belt or its rate has no value up to {ENORMOUS:g} where the motion begins; give one at t = 0"
        )


def check_drive(drive: Drive | None) -> None:
    """Raise BadValue unless a drive has values of ordinary size where the motion begins."""
    if drive is not None and not all(isfinite(value) and abs(value) <= ENORMOUS for value in drive.at(0.0)):
        raise BadValue(
            f"Drive or its rates have no value up to {ENORMOUS:g} where the motion begins; give formulas that have "
            "values at t = 0"
        )
