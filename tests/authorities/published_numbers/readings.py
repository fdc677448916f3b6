"""Readings of published numbers from our motion, and scenes that several publishers share."""

from __future__ import annotations

from cases import Case, CoulombFriction, Flight, Gravity, Impact, Plate, Start, Trajectory, Unilateral, disc
from cases.library import line

from .publications import Reading

# Unit inertia of a solid sphere. On a line, a disc with a sphere's inertia moves as the sphere does.
SPHERE = 0.4


def sphere(radius: float, mass: float = 1.0) -> Plate:
    """A disc with a sphere's inertia."""
    return disc(radius, mass, SPHERE * mass * radius**2)


def bouncing(gap: float, e: float, g: float, duration: float, radius: float = 0.1, lift: float = 0.0) -> Case:
    """A ball without friction above a level floor."""
    effects = (Gravity(g), Unilateral(), Flight(), Impact(e))
    return Case(line(), sphere(radius), effects, Start(xi1=0.0, gap=gap, gap_rate=lift), duration)


def sliding(radius: float, mu: float, v0: float, duration: float, g: float = 9.81) -> Case:
    """A sphere pushed along a level floor without spin."""
    effects = (Gravity(g), CoulombFriction(mu), Unilateral())
    return Case(line(), sphere(radius), effects, Start(xi1=0.0, slip=v0), duration)


def at(time: float, quantity: str) -> Reading:
    """A quantity of our motion at a time."""
    return lambda motion: float(getattr(motion(time), quantity))


def travel(time: float) -> Reading:
    """The displacement of the centre along X at a time."""
    return lambda motion: float(motion(time).x - motion(0.0).x)


def impact_times(motion: Trajectory) -> list[float]:
    """The instants of our motion's impacts."""
    return [t.time for t in motion.transitions if t.cause == "impact"]


def impact(number: int) -> Reading:
    """The instant of an impact, counted from 1."""
    return lambda motion: impact_times(motion)[number - 1]


def apex(number: int) -> Reading:
    """The centre's height half-way between an impact (counted from 1) and the next, its largest over a level floor."""

    def read(motion: Trajectory) -> float:
        before, after = impact_times(motion)[number - 1 : number + 1]
        return float(motion(0.5 * (before + after)).y)

    return read


def height(time: float, radius: float) -> Reading:
    """The height of the lowest point of a disc over a level floor."""
    return lambda motion: float(motion(time).y) - radius
