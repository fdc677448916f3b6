"""Random scenes of several contacts with a plate that does not turn: plane and wall, belts, loads, impacts."""

from __future__ import annotations

import random
from math import cos, inf, pi, sin

from cases import (
    Belt,
    Case,
    CoulombFriction,
    Effect,
    Flight,
    Gravity,
    Impact,
    Load,
    Plate,
    StartPose,
    Support,
    Unilateral,
)
from cases.library import ellipse, line

G, LONG, SHORT = 9.81, 0.3, 0.2


def random_scene(seed: int) -> Case:
    """An ellipse that does not turn, let go or thrown between a plane and a wall."""
    chance = random.Random(f"still plates {seed}")
    slope, lean = chance.uniform(-0.5, 0.5), chance.uniform(-0.4, 0.4)

    def surface() -> tuple[Effect, ...]:
        mean, surge, rate = chance.uniform(-1.5, 1.5), chance.uniform(0.1, 1.0), chance.uniform(2.0, 8.0)
        belts = chance.choice([(), (), (Belt(mean),), (Belt(f"{mean!r} + {surge!r}*sin({rate!r}*t)"),)])
        return (CoulombFriction(chance.uniform(0.1, 1.0)), *belts)

    law = Impact(chance.choice([0.0, 0.0, 0.3, 0.7]), chance.choice(["moreau", "poisson"]))
    push = f"{chance.uniform(-6.0, 6.0)!r}*sin({chance.uniform(1.0, 6.0)!r}*t)"
    loads = chance.choice([(), (Load(fx=f"-{chance.uniform(0.0, 6.0)!r} + {push}"),)])
    effects = (Gravity(G), Unilateral(), Flight(), law, *surface(), *loads)
    track, wall = line(slope), Support(line(pi / 2 + lean), "wall", surface())
    plate, theta = Plate(ellipse(LONG, SHORT), 1.0, inf), chance.uniform(-3.0, 3.0)
    if chance.random() < 0.5:
        start = StartPose(1.0, 1.0, theta, chance.uniform(-3.0, 1.0), chance.uniform(-3.0, 1.0))
        return Case(track, plate, effects, start, 1.2, supports=(wall,))
    # At rest on both: the distances of the centre from the lines are the outline's supports in their normals.
    high, wide = (_reach(theta, angle) for angle in (pi / 2 - slope, -lean))
    # (sin slope, cos slope) . p = high and (cos lean, -sin lean) . p = wide
    part = -sin(lean) * sin(slope) - cos(lean) * cos(slope)
    x, y = (-sin(lean) * high - cos(slope) * wide) / part, (sin(slope) * wide - cos(lean) * high) / part
    return Case(track, plate, effects, StartPose(x, y, theta), 1.2, supports=(wall,))


def _reach(theta: float, angle: float) -> float:
    """How far the ellipse extends from its centre against a direction."""
    return ((LONG * cos(angle - theta)) ** 2 + (SHORT * sin(angle - theta)) ** 2) ** 0.5
