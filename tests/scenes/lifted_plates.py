"""Random plates at rest on their tracks that a load or a drive lifts, with the exact time at which all contacts open.

The normal force of a plate on a straight track, and of a disc at the bottom of a valley, does not depend on how the
plate moves along it: N = m (g cos a + ÿ) − fy. Its first zero is that of a formula in one unknown.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from math import cos, exp, inf, pi, sin, tan
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from cases import (
    Belt,
    Case,
    CoulombFriction,
    Curve,
    Drive,
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
from cases.curves import cos as cos_of
from cases.library import circle, ellipse, line

G = 9.81
# Looks at a lift in which its first crossing is bracketed: it changes over a tenth of the time until then, or more.
LOOKS = 400


class LiftedPlate(NamedTuple):
    """A case with the time (s) at which its plate leaves, and how many contacts it has until then."""

    case: Case
    time: float
    contacts: int


class _Lift(NamedTuple):
    """An upward acceleration (m/s²) as a formula in t, and as a function of time, below `weight` at 0."""

    formula: str
    at: Callable[[float], float]


def lifted_plate(seed: int) -> LiftedPlate:
    """A disc, an ellipse or a box, by a load or a shaken table, with and without friction, flight and a belt that
    starts; every eighth scene is a disc in a groove."""
    chance = random.Random(f"lifted plates {seed}")
    if seed % 8 == 7:
        return _in_groove(chance)
    kind = chance.choice(["disc", "disc", "ellipse", "box", "box", "valley"])
    slope = chance.choice([0.0, 0.0, chance.uniform(-0.4, 0.4)]) if kind in ("disc", "box") else 0.0
    mass, r = chance.choice([1.0, chance.uniform(0.01, 50.0)]), chance.uniform(0.02, 0.5)
    mu = chance.choice([None, chance.uniform(0.05, 0.9)])
    plate, xi2, contacts, tips = _plate(kind, chance, mass, r)
    mu = mu and min(mu, 0.9 * tips)
    track = line(slope)
    if kind == "valley":
        depth = chance.uniform(0.1, 0.4)
        track = circle(4.0 * r) if chance.random() < 0.5 else Curve(lambda s: (s, -depth * cos_of(s)), (-3.0, 3.0))
    effects: list[Effect] = [Gravity(G), Unilateral()]
    if chance.random() < 0.7 or kind == "box":
        effects += [Flight(), Impact(0.0)]
    if mu is not None:
        effects.append(CoulombFriction(mu))
        if kind in ("disc", "box") and chance.random() < 0.5:
            effects.append(
                Belt(chance.choice([f"{chance.uniform(0.1, 3.0)!r}*t", f"{chance.uniform(0.5, 9.0)!r}*t**2"]))
            )
    lift = _lift(chance, G * cos(slope))
    return LiftedPlate(
        _case(chance, track, plate, effects, xi2, slope, lift), _first_time(lift, G * cos(slope)), contacts
    )


def _plate(kind: str, chance: random.Random, mass: float, r: float) -> tuple[Plate, float | None, int, float]:
    """The plate, the place of its contact, the number of contacts, and the coefficient of friction at which it tips."""
    if kind == "box":
        width = r * chance.uniform(0.5, 3.0)
        return Plate.rectangle(width, r, mass), chance.choice([0.5, 0.25]) * width, 2, width / r
    if kind == "ellipse":
        b = r * chance.uniform(0.4, 0.95)
        return Plate(ellipse(r, b), mass, 0.25 * mass * (r * r + b * b)), 1.5 * pi, 1, inf
    return disc(r, mass), None, 1, inf


def _lift(chance: random.Random, weight: float) -> _Lift:
    """An acceleration that grows from less than the weight to more."""
    a = weight * chance.uniform(1.05, 8.0)
    rate, part = chance.uniform(2.0, 40.0), chance.uniform(0.0, 0.9) * weight
    kind = chance.choice(["linear", "square", "cube", "sine", "offset sine", "exponential", "tanh"])
    return {
        "linear": _Lift(f"{a!r}*t", lambda t: a * t),
        "square": _Lift(f"{a!r}*t**2", lambda t: a * t * t),
        "cube": _Lift(f"{part!r} + {a!r}*t**3", lambda t: part + a * t**3),
        "sine": _Lift(f"{a!r}*sin({rate!r}*t)", lambda t: a * sin(rate * t)),
        "offset sine": _Lift(f"{part!r} - {a!r}*sin({rate!r}*t)", lambda t: part - a * sin(rate * t)),
        "exponential": _Lift(f"{part!r}*exp({rate!r}*t)", lambda t: part * exp(rate * t)),
        "tanh": _Lift(f"{a!r}*tanh({rate!r}*t)", lambda t: a * float(np.tanh(rate * t))),
    }[kind]


def _first_time(lift: _Lift, weight: float) -> float:
    """When the acceleration first reaches the weight."""
    end = 1.0
    while True:
        times = np.linspace(0.0, end, LOOKS)
        above = np.flatnonzero(np.array([lift.at(t) for t in times.tolist()]) >= weight)
        if above.size:
            break
        end *= 2.0
    low, high = float(times[above[0] - 1]), float(times[above[0]])
    return float(brentq(lambda t: lift.at(t) - weight, low, high, xtol=1e-17, rtol=8.9e-16))


def _case(
    chance: random.Random,
    track: Curve,
    plate: Plate,
    effects: list[Effect],
    xi2: float | None,
    slope: float,
    lift: _Lift,
) -> Case:
    """The case, by a load along the track's normal or, on a level track, by a table with the opposite acceleration."""
    end = 1.25 * _first_time(lift, G * cos(slope))
    level = slope == 0.0 and chance.random() < 0.5 and "sin" in lift.formula and "+" not in lift.formula
    if level and lift.formula.count("sin") == 1 and " - " not in lift.formula:
        size, _, inside = lift.formula.partition("*sin(")
        rate = float(inside.partition("*t)")[0])
        # y = A sin(w t) accelerates by −A w² sin(w t).
        effects.append(Drive(y=f"{float(size) / rate**2!r}*sin({rate!r}*t)"))
    else:
        m, s, c = plate.mass, sin(slope), cos(slope)
        effects.append(Load(fx=f"{m * s!r}*({lift.formula})" if s else "0", fy=f"{m * c!r}*({lift.formula})"))
    return Case(
        track, plate, tuple(effects), Start(0.0 if track.domain or track.period is None else -0.5 * pi, xi2), end
    )


def _in_groove(chance: random.Random) -> LiftedPlate:
    """A disc at rest in a groove: both contacts open when the load is the weight."""
    angle, r, mass = chance.uniform(0.2, 1.2), chance.uniform(0.02, 0.5), chance.uniform(0.1, 10.0)
    friction: tuple[Effect, ...] = chance.choice(
        [(), (CoulombFriction(chance.uniform(0.05, min(0.8, 0.9 / tan(angle)))),)]
    )  # not wedged
    lift = _lift(chance, G)
    time = _first_time(lift, G)
    effects = (Gravity(G), Unilateral(), Flight(), Impact(0.0), *friction, Load(fy=f"{mass!r}*({lift.formula})"))
    other = Support(line(-angle), "flank", friction)
    start = StartPose(0.0, r / cos(angle))
    return LiftedPlate(Case(line(angle), disc(r, mass), effects, start, 1.25 * time, supports=(other,)), time, 2)
