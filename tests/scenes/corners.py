"""Random scenes with corners: polygons, half discs, Reuleaux triangles, discs; slopes, hills, bowls, steps."""

from math import pi

import numpy as np

from cases import (
    Belt,
    Case,
    Chain,
    CoulombFriction,
    Flight,
    Gravity,
    Impact,
    PerfectlyRough,
    Plate,
    Start,
    Unilateral,
    disc,
    library,
)


def random_polygon_plate(chance: np.random.Generator) -> Plate:
    """A convex polygon with three to seven corners near a circle of 0.15 m."""
    n = int(chance.integers(3, 8))
    angles = 2 * pi * (np.arange(n) + chance.uniform(-0.3, 0.3, n)) / n
    return Plate.polygon((0.15 * np.array([np.cos(angles), np.sin(angles)])).T.tolist(), 1.0)


def _steps(chance: np.random.Generator) -> Chain:
    """A track of straight pieces that goes down in steps and ramps."""
    points, x, y = [(-2.0, 0.0)], -0.6, 0.0
    while x < 3:
        points.append((x, y))
        x, y = x + chance.uniform(0.2, 0.7), y - chance.uniform(-0.05, 0.3)
        if chance.random() < 0.5:
            points.append((x, y))
    return Chain.polyline([point for i, point in enumerate(points) if i == 0 or point != points[i - 1]])


def random_throw(seed: int, belt: bool = False) -> Case:
    """A plate thrown onto a track, either of them or both with corners, with any law of impact."""
    chance = np.random.default_rng(seed)
    kind = seed % 5
    plate = (
        lambda: disc(0.1, 1.0),
        lambda: random_polygon_plate(chance),
        lambda: Plate.reuleaux(0.25, 1.0),
        lambda: Plate.half_disc(0.15, 1.0),
    )[int(chance.integers(4))]()
    track, xi1 = (
        lambda: (_steps(chance), 1.0),
        lambda: (library.line(0.2), 0.0),
        lambda: (library.hill(1.0), 0.1),
        lambda: (library.circle(1.5), 0.2 - pi / 2),
        lambda: (Chain.polyline([(-2, 0), (0, 0), (0, -0.6), (3, -0.6)]), 1.5),
    )[kind]()
    if plate.radius is not None and kind in (1, 2, 3):
        plate = Plate.reuleaux(0.25, 1.0)
    friction = PerfectlyRough() if chance.integers(6) == 0 else CoulombFriction(chance.uniform(0.05, 0.8))
    impact = Impact(float(chance.choice([0.0, 0.3, 0.6])), law=str(chance.choice(["newton", "poisson", "moreau"])))
    effects = (Gravity(9.81), friction, Unilateral(), Flight(), impact)
    start = Start(
        xi1=xi1,
        xi2=chance.uniform(*plate.outline.span),
        gap=chance.uniform(0.2, 0.4),
        slip=chance.uniform(-0.5, 1.5),
        omega=chance.uniform(-8, 3),
        gap_rate=chance.uniform(-0.5, 0.5),
    )
    return Case(track, plate, (*effects, Belt(chance.uniform(-1, 1))) if belt else effects, start, 0.8)
