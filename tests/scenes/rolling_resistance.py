"""Random scenes of several contacts with rolling resistance: discs in a V, at walls and on belts, ellipses, driven
tracks."""

from __future__ import annotations

import random
from math import cos, pi, sin, tan

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
    PerfectlyRough,
    Plate,
    RollingResistance,
    Start,
    StartPose,
    Support,
    Unilateral,
    disc,
)
from cases import curves as c
from cases.library import ellipse, line

G, RADIUS = 9.81, 0.2


def _friction(chance: random.Random) -> Effect:
    mu = chance.uniform(0.05, 0.6)
    return chance.choice([CoulombFriction(mu), CoulombFriction(mu), CoulombFriction(mu, 1.3 * mu)])


def _surface(chance: random.Random, rough: bool = False) -> tuple[Effect, ...]:
    """Friction and, mostly, rolling resistance of one support."""
    arm = chance.uniform(0.001, 0.05) * RADIUS * chance.choice([1.0, 5.0])
    friction = PerfectlyRough() if rough else _friction(chance)
    return friction, *chance.choice([(), (RollingResistance(arm),), (RollingResistance(arm),)])


def _wave(chance: random.Random, most: float) -> str:
    return f"{chance.uniform(0.0, most)!r}*sin({chance.uniform(1.0, 8.0)!r}*t + {chance.uniform(0.0, 6.0)!r})"


def _falls(chance: random.Random) -> tuple[Effect, ...]:
    """Gravity and impacts, mostly without restitution."""
    law = Impact(chance.choice([0.0, 0.0, 0.4]), chance.choice(["moreau", "moreau", "poisson"]))
    return Gravity(G), Unilateral(), Flight(), law


def _spin(chance: random.Random) -> float:
    return chance.choice([0.0, chance.uniform(-15.0, 15.0)])


def _disc_in_v(chance: random.Random) -> Case:
    """A disc that turns, or is turned by a moment, in a V of two planes."""
    left, right = chance.uniform(0.2, 1.0), chance.uniform(0.2, 1.0)
    far = RADIUS / sin(left + right)  # the centre has the distance of the radius from both planes
    x, y = far * (cos(right) - cos(left)), far * (sin(left) + sin(right))
    rough = chance.random() < 0.1
    effects = (*_falls(chance), *_surface(chance, rough), Load(moment=_wave(chance, chance.choice([0.2, 1.5]))))
    wall = Support(line(-right), "right", _surface(chance))
    spin = 0.0 if rough else _spin(chance)
    return Case(line(left), disc(RADIUS, 1.0), effects, StartPose(x, y, omega=spin), 1.2, supports=(wall,))


def _disc_at_wall(chance: random.Random) -> Case:
    """A disc that is pressed by a load against a wall, or rolls there; a belt resists no rolling."""
    press = f"-{chance.uniform(0.5, 8.0)!r} + {_wave(chance, 3.0)}"
    floor: tuple[Effect, ...] = _surface(chance)
    if chance.random() < 0.4:
        floor = CoulombFriction(chance.uniform(0.1, 0.6)), Belt(chance.choice([chance.uniform(-1.0, 1.0), "sin(3*t)"]))
    effects = (*_falls(chance), *floor, Load(fx=press, moment=_wave(chance, 0.3)))
    away, speed = chance.choice([(0.0, 0.0), (0.3, chance.uniform(-2.0, 0.0))])
    start = StartPose(RADIUS + away, RADIUS, vx=speed, omega=_spin(chance))
    wall = Support(line(pi / 2), "wall", _surface(chance))
    return Case(line(), disc(RADIUS, 1.0), effects, start, 1.2, supports=(wall,))


def _on_driven_track(chance: random.Random) -> Case:
    """A disc in a corner of floor and wall that are shaken together, and may turn."""
    shake = dict(x=_wave(chance, 0.2))
    if chance.random() < 0.4:
        shake["angle"] = _wave(chance, 0.1)
    effects = (*_falls(chance), *_surface(chance), Drive(**shake))
    wall = Support(line(pi / 2), "wall", chance.choice([None, _surface(chance)]))
    start = StartPose(RADIUS + chance.choice([0.0, 0.2]), RADIUS)
    return Case(line(), disc(RADIUS, 1.0), effects, start, 1.0, supports=(wall,))


def _groove(chance: random.Random) -> Case:
    """A disc that rolls into a valley that is too narrow for it: two contacts with one track."""
    alpha = chance.uniform(0.3, 0.9)
    track = Curve(lambda s: (s, tan(alpha) * c.sqrt(s * s + 1e-3)), domain=(-3.0, 3.0))
    resistance = RollingResistance(chance.uniform(0.001, 0.02))
    effects = (*_falls(chance)[:3], Impact(0.0, "moreau"), _friction(chance), resistance)
    start = Start(chance.choice([-1.0, 1.0]) * chance.uniform(0.3, 0.8))
    return Case(track, disc(RADIUS, 1.0), effects, start, 1.5)


def _ellipse(chance: random.Random) -> Case:
    """An ellipse that lies, rocks or is turned between floor and wall."""
    plate = Plate.homogeneous(ellipse(RADIUS, RADIUS * chance.uniform(0.5, 0.9)), 1.0)
    effects = (*_falls(chance)[:3], Impact(0.0, "moreau"), *_surface(chance), Load(fx=f"-{chance.uniform(0.5, 8.0)!r}"))
    wall = Support(line(pi / 2), "wall", _surface(chance))
    start = Start(chance.uniform(0.25, 0.6), chance.uniform(0.0, 6.2), omega=_spin(chance))
    return Case(line(), plate, effects, start, 1.0, supports=(wall,))


FAMILIES = _disc_in_v, _disc_at_wall, _on_driven_track, _groove, _ellipse


def random_scene(seed: int) -> Case:
    """A scene of several contacts with rolling resistance, each family in turn."""
    return FAMILIES[seed % len(FAMILIES)](random.Random(f"rolling resistance {seed}"))
