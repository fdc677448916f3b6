"""Random scenes at ties: thresholds that are met exactly in real numbers, and by roundings on either side in floating
point. Both sides of each have one limit, which is the answer.

The motions are elementary: at constant acceleration along a line, at rest, or in free fall.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from math import atan, cos, inf, pi, sin, sqrt, tan
from typing import NamedTuple

from cases import (
    Belt,
    Case,
    CoulombFriction,
    Curve,
    Effect,
    Flight,
    Gravity,
    Impact,
    Load,
    Plate,
    Start,
    StartPose,
    Support,
    Unilateral,
    disc,
)
from cases.library import circle, hill, line

G = 9.81


class Tie(NamedTuple):
    """A case, how far its centre has moved at the end of it (m), and the instants (s) at which modes change."""

    case: Case
    moved: tuple[float, float]
    changes: tuple[float, ...]


def tie(seed: int) -> Tie:
    """A scene of one of the kinds in turn."""
    kinds = tuple(KINDS.values())
    return kinds[seed % len(kinds)](random.Random(f"ties {seed}"))


def _effects(*more: Effect, mu: float | None = None) -> tuple[Effect, ...]:
    return (Gravity(G), Unilateral(), Flight(), Impact(0.0), *((CoulombFriction(mu),) if mu else ()), *more)


def _plate(chance: random.Random, mu: float) -> tuple[Plate, float | None]:
    """A plate that slides without turning, and its place: a disc of infinite inertia, or a box that does not tip."""
    mass, size = chance.uniform(0.1, 10.0), chance.uniform(0.05, 0.5)
    if chance.random() < 0.5:
        return Plate(circle(size), mass, inf), None
    width = size * max(1.0, 2.0 * mu)
    return Plate.rectangle(width, size, mass), 0.5 * width


def at_the_angle_of_friction(chance: random.Random) -> Tie:
    """On an incline with tan a = mu: at rest, or thrown up or down."""
    mu = chance.uniform(0.05, 1.2)
    a, end = atan(mu), 1.0
    plate, xi2 = _plate(chance, mu)
    slip = chance.choice([0.0, chance.uniform(0.2, 2.0), -chance.uniform(0.2, 0.9) * 2.0 * G * sin(a) * end])
    case = Case(line(a), plate, _effects(mu=mu), Start(0.0, xi2, slip=slip), end)
    stop = -slip / (2.0 * G * sin(a)) if slip < 0.0 else 0.0
    moved = slip * end if slip > 0.0 else 0.5 * slip * stop
    return Tie(case, (moved * cos(a), -moved * sin(a)), (stop,) if slip < 0.0 else ())


def disc_at_the_limit_of_rolling(chance: random.Random) -> Tie:
    """A homogeneous disc on an incline with tan a = 3 mu, or pushed with 3 mu m g: it rolls."""
    r, m, mu, end = chance.uniform(0.05, 0.5), chance.uniform(0.1, 10.0), chance.uniform(0.05, 0.6), 1.0
    if chance.random() < 0.5:
        a = atan(3.0 * mu)
        moved = G * sin(a) * end**2 / 3.0
        case = Case(line(a), disc(r, m), _effects(mu=mu), Start(0.0), end)
        return Tie(case, (moved * cos(a), -moved * sin(a)), ())
    case = Case(line(), disc(r, m), _effects(Load(fx=3.0 * mu * m * G), mu=mu), Start(0.0), end)
    return Tie(case, (mu * G * end**2, 0.0), ())


def box_at_the_limit_of_tipping(chance: random.Random) -> Tie:
    """A box whose mu is width over height, pushed at its centre or thrown: it slides flat."""
    height, mu, m, end = chance.uniform(0.05, 0.5), chance.uniform(0.2, 1.5), chance.uniform(0.1, 10.0), 1.0
    width = mu * height
    mu = chance.choice([mu, width / height])
    plate, way = Plate.rectangle(width, height, m), chance.choice([1.0, -1.0])
    if chance.random() < 0.5:
        force = chance.uniform(1.1, 3.0) * mu * m * G
        case = Case(line(), plate, _effects(Load(fx=way * force), mu=mu), Start(0.0, 0.5 * width), end)
        return Tie(case, (way * 0.5 * (force / m - mu * G) * end**2, 0.0), ())
    slip = chance.uniform(0.1, 0.9) * mu * G * end
    case = Case(line(), plate, _effects(mu=mu), Start(0.0, 0.5 * width, slip=way * slip), end)
    return Tie(case, (way * 0.5 * slip**2 / (mu * G), 0.0), (slip / (mu * G),))


def box_that_its_slope_could_tip(chance: random.Random) -> Tie:
    """A box at rest on an incline with tan a = width/height, and rougher than that."""
    height, ratio = chance.uniform(0.05, 0.5), chance.uniform(0.2, 0.9)
    width = ratio * height
    plate, way = Plate.rectangle(width, height, chance.uniform(0.1, 10.0)), chance.choice([1.0, -1.0])
    case = Case(line(way * atan(ratio)), plate, _effects(mu=1.1 * ratio), Start(0.0, 0.5 * width), 0.2)
    return Tie(case, (0.0, 0.0), ())


def pushed_to_the_bound(chance: random.Random) -> Tie:
    """Pushed by exactly mu m g, constant or as the peak of a sine: it rests."""
    mu, end = chance.uniform(0.05, 1.0), 1.0
    plate, xi2 = _plate(chance, mu)
    force = mu * plate.mass * G * chance.choice([1.0, -1.0])
    push: str | float = chance.choice([force, f"{force!r}*sin({pi!r}*t)", f"{force!r}*(1 - (2*t - 1)**2)"])
    case = Case(line(), plate, _effects(Load(fx=push), mu=mu), Start(0.0, xi2), end)
    return Tie(case, (0.0, 0.0), ())


def as_light_as_its_lift(chance: random.Random) -> Tie:
    """A load of exactly the weight, constant or as the peak of a sine: the plate floats on its track, and does not
    leave it."""
    plate, xi2 = _plate(chance, 0.2)
    weight, slip = plate.mass * G, chance.choice([0.0, chance.uniform(0.1, 1.0)])
    lift: str | float = chance.choice([weight, f"{weight!r}*sin({pi!r}*t)", f"{weight!r}*(1 - (2*t - 1)**2)"])
    case = Case(line(), plate, _effects(Load(fy=lift)), Start(0.0, xi2, slip=slip), 1.0)
    return Tie(case, (slip, 0.0), ())


def along_a_wall_without_force(chance: random.Random) -> Tie:
    """A disc that touches a wall falls along it, spinning or not, rests beside it, or slides into it from a floor."""
    r, mu, height = chance.uniform(0.05, 0.3), chance.uniform(0.05, 0.8), chance.uniform(0.1, 1.0)
    wall = Support(chance.choice([line(0.5 * pi), Curve(("0", "-s"))]), "wall", (CoulombFriction(mu),))
    plate = disc(r, chance.uniform(0.1, 10.0))
    fall = sqrt(2.0 * height / G)
    if chance.random() < 0.3:
        case = Case(line(), plate, _effects(mu=mu), StartPose(r, r), 0.5, supports=(wall,))
        return Tie(case, (0.0, 0.0), ())
    if chance.random() < 0.5:
        start = StartPose(r, r + height, omega=chance.choice([0.0, chance.uniform(-9.0, 9.0)]))
        case = Case(line(), plate, _effects(mu=mu), start, 0.9 * fall, supports=(wall,))
        return Tie(case, (0.0, -0.5 * G * (0.9 * fall) ** 2), ())
    case = Case(line(), plate, _effects(mu=mu), StartPose(r, r + height), 1.5 * fall, supports=(wall,))
    return Tie(case, (0.0, -height), (fall,))


def disc_that_rolls_by_a_rounding(chance: random.Random) -> Tie:
    """A disc thrown with omega = -v/r, on a line or on a belt."""
    r, speed, belt = (
        chance.uniform(0.05, 0.3),
        chance.uniform(0.1, 3.0),
        chance.choice([0.0, chance.uniform(-2.0, 2.0)]),
    )
    more = (Belt(belt),) if belt else ()
    start = StartPose(0.0, r, 0.0, speed, 0.0, -(speed - belt) / r)
    case = Case(line(), disc(r, 1.0), _effects(*more, mu=chance.uniform(0.05, 0.5)), start, 1.0)
    return Tie(case, (speed, 0.0), ())


def disc_that_spins_in_a_groove(chance: random.Random) -> Tie:
    """A disc that spins in a groove with mu = tan a: the force on one flank vanishes, and it stops as for less mu."""
    a, r, end = chance.uniform(0.1, 0.7), chance.uniform(0.05, 0.3), 1.0
    mu = tan(a)
    stop = chance.uniform(0.2, 0.8) * end
    omega = chance.choice([1.0, -1.0]) * stop * 2.0 * mu * G / (r * (1.0 + mu * mu) * cos(a))
    other = Support(line(-a), "flank", (CoulombFriction(mu),))
    start = StartPose(0.0, r / cos(a), omega=omega)
    case = Case(line(a), disc(r, chance.uniform(0.1, 10.0)), _effects(mu=mu), start, end, supports=(other,))
    return Tie(case, (0.0, 0.0), (stop,))


def over_the_top_without_weight(chance: random.Random) -> Tie:
    """A slider on top of a hill at the speed sqrt(g R) leaves at once, and falls freely."""
    radius, size = chance.uniform(0.3, 2.0), chance.uniform(0.05, 0.2)
    speed, end = sqrt(G * (radius + size)), 0.2
    case = Case(hill(radius), Plate(circle(size), 1.0, inf), _effects(), Start(0.0, slip=speed), end)
    return Tie(case, (speed * end, -0.5 * G * end**2), ())


def impact_that_just_sticks(chance: random.Random) -> Tie:
    """A disc that lands with the slip 3 mu v: friction just ends it, and the disc rolls on."""
    r, mu, fall = chance.uniform(0.05, 0.3), chance.uniform(0.05, 0.6), chance.uniform(0.1, 0.5)
    speed, end = 3.0 * mu * G * fall, 1.0
    start = StartPose(0.0, r + 0.5 * G * fall**2, 0.0, speed)
    case = Case(line(), disc(r, chance.uniform(0.1, 10.0)), _effects(mu=mu), start, end)
    return Tie(case, (speed * fall + 2.0 / 3.0 * speed * (end - fall), -0.5 * G * fall**2), (fall,))


KINDS: dict[str, Callable[[random.Random], Tie]] = {
    kind.__name__: kind
    for kind in (
        at_the_angle_of_friction,
        disc_at_the_limit_of_rolling,
        box_at_the_limit_of_tipping,
        box_that_its_slope_could_tip,
        pushed_to_the_bound,
        as_light_as_its_lift,
        along_a_wall_without_force,
        disc_that_rolls_by_a_rounding,
        disc_that_spins_in_a_groove,
        over_the_top_without_weight,
        impact_that_just_sticks,
    )
}
