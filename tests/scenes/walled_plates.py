"""Random scenes of discs, and at most one polygon, on a floor between walls; and two laws that their motions obey."""

from __future__ import annotations

from math import cos, sin, sqrt

import numpy as np

from cases import (
    Case,
    CoulombFriction,
    DoesNotFit,
    Flight,
    FreePlate,
    Gravity,
    Impact,
    Plate,
    StartPose,
    Support,
    Unilateral,
    disc,
)
from cases.curves import Curve
from cases.library import line

G = 9.81
# Scenes are drawn until one has no overlap.
TRIES = 1000
# x, y and radius of a disc.
Circle = tuple[float, float, float]


def random_walled_plates(seed: int, duration: float = 1.0) -> Case:
    """Two to four plates, many of which touch where they begin: each other, the floor, one of up to two walls."""
    numbers = np.random.default_rng([seed, 55])
    for _ in range(TRIES):
        case = _draw(numbers, duration)
        if case is not None:
            return case
    raise DoesNotFit(f"no scene without an overlap in {TRIES} tries with seed {seed}")


def _draw(numbers: np.random.Generator, duration: float) -> Case | None:
    walls = [(-0.4, -1.0), (0.5, 1.0)][: int(numbers.integers(0, 3))]
    mu, e = float(numbers.choice([0.0, 0.3, numbers.uniform(0.05, 1.0)])), float(numbers.choice([0.0, 0.0, 0.5]))
    placed, plates = list[Circle](), list[tuple[Plate, StartPose]]()
    if numbers.random() < 0.3:
        plate, low = _polygon(numbers)
        x, moves = float(numbers.uniform(-0.1, 0.1)), numbers.random() < 0.5
        plates.append((plate, StartPose(x, low, 0.0, float(numbers.uniform(-1.0, 1.0)) if moves else 0.0)))
        placed.append((x, low, plate.reach))
    for _ in range(int(numbers.integers(2, 5)) - len(plates)):
        circle = _place(numbers, placed, walls)
        if circle is None:
            return None
        placed.append(circle)
        x, y, r = circle
        vx, spin = (float(numbers.choice([0.0, numbers.uniform(-1.5, 1.5)])), float(numbers.uniform(-8.0, 8.0)))
        spin = float(numbers.choice([0.0, spin, -vx / r]))
        plates.append((disc(r, float(numbers.choice([0.2, 1.0, 3.0]))), StartPose(x, y, 0.0, vx, 0.0, spin)))
    effects = (Gravity(G), Unilateral(), Flight(), Impact(e, "moreau"), *((CoulombFriction(mu),) if mu else ()))
    supports = tuple(
        Support(Curve((f"{x!r}", "s" if side > 0.0 else "-s")), f"wall{k + 1}") for k, (x, side) in enumerate(walls)
    )
    others = tuple(FreePlate(plate, pose, f"plate{i + 2}") for i, (plate, pose) in enumerate(plates[1:]))
    try:
        return Case(line(), plates[0][0], effects, plates[0][1], duration, supports=supports, others=others)
    except DoesNotFit:
        return None


def _polygon(numbers: np.random.Generator) -> tuple[Plate, float]:
    """A block or a triangle with a level side below, and the height of its centre of mass on it, m."""
    width, high = float(numbers.choice([0.1, 0.2])), float(numbers.choice([0.1, 0.2]))
    corners = [(0.0, 0.0), (width, 0.0), (width, high), (0.0, high)]
    plate = Plate.polygon(corners if numbers.random() < 0.6 else corners[:3], float(numbers.uniform(0.5, 2.0)))
    return plate, -float(plate.outline.point(plate.outline.span[0])[1])


def _place(numbers: np.random.Generator, placed: list[Circle], walls: list[tuple[float, float]]) -> Circle | None:
    """A disc on the floor, at a wall, on one or two others, next to one, between a wall and another one, or in the
    air; None if there is no such place."""
    r = float(numbers.choice([0.05, 0.1, 0.1, 0.15]))
    kind = str(numbers.choice(["floor", "wall", "on", "on_two", "next", "wedge", "air"]))
    wall = walls[int(numbers.integers(len(walls)))] if walls else None
    other = placed[int(numbers.integers(len(placed)))] if placed else None
    if kind == "air":
        return float(numbers.uniform(-0.3, 0.4)), float(numbers.uniform(r, 0.8)), r
    if kind == "wall" and wall:
        return wall[0] - wall[1] * r, float(numbers.choice([r, r + numbers.uniform(0.0, 0.3)])), r
    if kind == "next" and other:
        return other[0] + float(numbers.choice([-1.0, 1.0])) * 2.0 * sqrt(other[2] * r), r, r
    if kind == "on" and other:
        angle = float(numbers.uniform(-1.2, 1.2))
        return other[0] + (r + other[2]) * sin(angle), other[1] + (r + other[2]) * cos(angle), r
    if kind == "wedge" and wall and other:
        x = wall[0] - wall[1] * r
        below = (r + other[2]) ** 2 - (x - other[0]) ** 2
        return (x, other[1] + sqrt(below), r) if below > 0.0 else None
    if kind == "on_two" and len(placed) > 1:
        (ax, ay, ar), (bx, by, br) = placed[-2:]
        far, first, second = float(np.hypot(bx - ax, by - ay)), ar + r, br + r
        along = (far**2 + first**2 - second**2) / (2.0 * far)
        if first <= abs(along):
            return None
        aside, (ux, uy) = sqrt(first**2 - along**2), ((bx - ax) / far, (by - ay) / far)
        aside *= 1.0 if ux > 0.0 else -1.0
        return ax + along * ux - aside * uy, ay + along * uy + aside * ux, r
    return float(numbers.uniform(-0.3, 0.4)), r, r
