"""Random scenes of a free polygon and discs on a line, in motion."""

from __future__ import annotations

from math import cos, pi, sin

import numpy as np

from cases import Case, CoulombFriction, Flight, FreePlate, Gravity, Impact, Plate, StartPose, Unilateral, disc
from cases.curves import Curve
from cases.library import line
from cases.scene.supports import Support


def random_polygon_scene(seed: int, restitution: float = 0.0) -> Case:
    """A block, a triangle or a pentagon on a floor or above it, with one or two discs on it, next to it or above it.

    The floor is the track, or a support with its own friction; the polygon is the case's plate or one of the others."""
    numbers = np.random.default_rng([seed, 36])
    kind, high = str(numbers.choice(["block", "triangle", "pentagon"])), float(numbers.choice([0.0, 5.0]))
    polygon, depth = _polygon(kind, numbers)
    speed = float(numbers.choice([0.0, numbers.uniform(-1.0, 1.0)]))
    if numbers.random() < 0.7:
        start = StartPose(0.0, high + depth, 0.0, speed)
    else:
        angle, omega = float(numbers.uniform(0.0, 2.0 * pi)), float(numbers.uniform(-3.0, 3.0))
        start = StartPose(0.0, high + polygon.reach + 0.05, angle, speed, 0.0, omega)
    discs = []
    for i in range(int(numbers.integers(1, 3))):
        r, side = float(numbers.choice([0.05, 0.1])), float(numbers.uniform(-0.8, 0.8))
        speeds = float(numbers.uniform(-1.5, 1.5)), float(numbers.uniform(-10.0, 10.0))
        above = high + 2.2 * polygon.reach + r + 0.5 * i if numbers.random() < 0.7 else high + r
        if above == high + r:
            side = (1.0 if side > 0.0 else -1.0) * (1.3 + 0.5 * i) * polygon.reach
            speeds = -abs(speeds[0]) * float(np.sign(side)), speeds[1]
        pose = StartPose(side, above, 0.0, speeds[0], 0.0, speeds[1])
        discs.append((disc(r, float(numbers.uniform(0.3, 2.0))), pose))
    mu = float(numbers.choice([0.0, numbers.uniform(0.1, 0.9)]))
    effects = (Gravity(9.81), Unilateral(), Flight(), Impact(restitution), *((CoulombFriction(mu),) if mu else ()))
    supports: tuple[Support, ...] = ()
    if high:
        own = () if numbers.random() < 0.3 else (CoulombFriction(float(numbers.uniform(0.05, 0.8))),)
        supports = (Support(Curve(lambda s: (s, high + 0 * s)), "floor", own),)
    plates = [(polygon, start), *discs]
    if numbers.random() < 0.4:
        plates.reverse()
    others = tuple(FreePlate(plate, pose, f"plate{i + 2}") for i, (plate, pose) in enumerate(plates[1:]))
    return Case(line(), plates[0][0], effects, plates[0][1], 1.0, supports=supports, others=others)


def _polygon(kind: str, numbers: np.random.Generator) -> tuple[Plate, float]:
    """A homogeneous polygon with a horizontal side below, and how deep that is below its centre of mass, m."""
    mass, size = float(numbers.uniform(0.5, 5.0)), float(numbers.uniform(0.3, 0.8))
    if kind == "block":
        corners = [
            (0.0, 0.0),
            (size, 0.0),
            (size, size * (tall := float(numbers.uniform(0.3, 2.0)))),
            (0.0, size * tall),
        ]
    elif kind == "triangle":
        corners = [(0.0, 0.0), (size, 0.0), (size * float(numbers.uniform(0.1, 0.9)), 0.6 * size)]
    else:
        angles = 2.0 * pi * np.arange(5) / 5 - 0.7 * pi
        corners = [(0.5 * size * cos(a), 0.5 * size * sin(a)) for a in angles.tolist()]
        corners[1] = (corners[1][0], corners[0][1])  # the side below is horizontal to the last bit
    polygon = Plate.polygon(corners, mass)
    return polygon, -float(polygon.outline.point(polygon.outline.span[0])[1])
