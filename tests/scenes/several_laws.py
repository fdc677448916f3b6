"""Random scenes of several contacts whose friction depends on the slip speed: blocks on belts and ramps, discs in a V
and at walls, ladders."""

from __future__ import annotations

import random
from math import cos, pi, sin

import numpy as np

from cases import Belt, Case, Effect, Gravity, Load, Outline, Plate, StartPose, Support, Unilateral, disc
from cases.library import line
from tests.scenes.slip_laws import G, random_law

RADIUS = 0.2


# Narrower laws take the second formulation, which is slow, half a minute.
NARROWEST = -1.3


def _law(chance: random.Random) -> Effect:
    return random_law(np.random.default_rng(chance.randrange(2**32)), NARROWEST)


def _belt(chance: random.Random) -> tuple[Effect, ...]:
    mean, surge, rate = chance.uniform(-1.0, 1.0), chance.uniform(0.1, 0.8), chance.uniform(2.0, 8.0)
    return chance.choice([(), (Belt(mean),), (Belt(f"{mean!r} + {surge!r}*sin({rate!r}*t)"),)])


def _wave(chance: random.Random, most: float) -> str:
    return f"{chance.uniform(0.0, most)!r}*sin({chance.uniform(1.0, 8.0)!r}*t + {chance.uniform(0.0, 6.0)!r})"


def _block(chance: random.Random) -> Case:
    """A block on a ramp or a belt, pushed or held by a spring."""
    slope, high = chance.choice([0.0, chance.uniform(-0.4, 0.4)]), chance.uniform(0.05, 0.3)
    c, s = cos(slope), sin(slope)
    force = chance.choice(["0", f"-{chance.uniform(5.0, 60.0)!r}*({c!r}*x + {s!r}*y)", _wave(chance, 4.0)])
    loads = () if force == "0" else (Load(fx=f"{c!r}*({force})", fy=f"{s!r}*({force})"),)
    effects = (Gravity(G), Unilateral(), _law(chance), *_belt(chance), *loads)
    speed = chance.choice([0.0, chance.uniform(-1.5, 1.5)])
    start = StartPose(-s * high, c * high, slope, c * speed, s * speed, 0.0)
    return Case(line(-slope), Plate.rectangle(chance.uniform(0.3, 0.8), 2.0 * high, 1.0), effects, start, 1.5)


def _disc_in_v(chance: random.Random) -> Case:
    """A disc in a V of two planes that are belts, or turned by a moment."""
    left, right = chance.uniform(0.2, 1.0), chance.uniform(0.2, 1.0)
    far = RADIUS / sin(left + right)  # the centre has the distance of the radius from both planes
    x, y = far * (cos(right) - cos(left)), far * (sin(left) + sin(right))
    effects = (Gravity(G), Unilateral(), _law(chance), *_belt(chance), Load(moment=_wave(chance, 1.5)))
    own = (_law(chance), *_belt(chance))
    start = StartPose(x, y, omega=chance.choice([0.0, chance.uniform(-8.0, 8.0)]))
    wall = Support(line(-right), "right", own)
    return Case(line(left), disc(RADIUS, 1.0), effects, start, 1.2, supports=(wall,))


def _disc_at_wall(chance: random.Random) -> Case:
    """A disc on a plane, pressed by a load against a wall."""
    press = f"-{chance.uniform(0.5, 8.0)!r} + {_wave(chance, 3.0)}"
    effects = (Gravity(G), Unilateral(), _law(chance), *_belt(chance), Load(fx=press, moment=_wave(chance, 1.0)))
    start = StartPose(RADIUS, RADIUS, omega=chance.choice([0.0, chance.uniform(-8.0, 8.0)]))
    wall = Support(line(pi / 2), "wall", (_law(chance), *_belt(chance)))
    return Case(line(), disc(RADIUS, 1.0), effects, start, 1.2, supports=(wall,))


def _ladder(chance: random.Random) -> Case:
    """A ladder between floor and wall, at rest or sliding."""
    half, angle = chance.uniform(0.4, 1.0), chance.uniform(0.5, 1.4)
    rate = chance.choice([0.0, chance.uniform(-1.5, 0.5)])  # of the angle with the floor
    corners = [(-half, -0.02 * half), (half, -0.02 * half), (half, 0.0), (-half, 0.0)]
    rod = Plate(Outline.polygon(corners), 1.0, half * half / 3.0)
    x, y = half * cos(angle), half * sin(angle)
    load = chance.choice([(), (Load(fx=_wave(chance, 3.0), fy=_wave(chance, 3.0)),)])
    effects = (Gravity(G), Unilateral(), _law(chance), *_belt(chance), *load)
    wall = Support(line(pi / 2), "wall", (_law(chance), *_belt(chance)))
    return Case(line(), rod, effects, StartPose(x, y, pi - angle, -y * rate, x * rate, -rate), 1.0, supports=(wall,))


FAMILIES = _block, _disc_in_v, _disc_at_wall, _ladder


def random_scene(seed: int) -> Case:
    """A scene of several contacts, each family in turn."""
    return FAMILIES[seed % len(FAMILIES)](random.Random(f"several laws {seed}"))
