"""Random flights over ripples, much finer than the plate."""

from __future__ import annotations

import numpy as np

from cases import (
    Case,
    CaseError,
    CoulombFriction,
    Curve,
    Flight,
    Gravity,
    Impact,
    Plate,
    Start,
    Unilateral,
    disc,
)
from cases.contact import start_motion
from cases.library import ellipse

G, SIZE = 9.81, 0.1
FLYING = (Unilateral(), Flight(), Impact(0.0))
BASES, SHAPES = ("line", "slope", "valley", "ring", "endless"), ("disc", "ellipse", "lobes")


def over_ripples(height: float, length: float, gap: float, g: float = 0.0) -> Case:
    """A disc at 5 m/s that sinks at 2 mm/s over y = height cos(2 pi x/length), from a gap over a crest."""
    track = Curve(("s", f"{height!r}*cos({2 * np.pi / length!r}*s)"), (-1, 1))
    effects = (*FLYING, Gravity(g)) if g else FLYING
    return Case(track, disc(0.1, 1.0), effects, Start(0.0, gap=gap, slip=5.0, gap_rate=-0.002), 0.05)


def rippled(seed: int) -> Case:
    """A plate thrown at a track with ripples, whose wavelength is 10 to 1e-3 of the plate's size."""
    random = np.random.default_rng(seed)
    while True:
        try:
            case = _drawn(random)
        except CaseError:  # ripples that cross each other, or a start inside the track
            continue
        # A case's own check of its start looks at a polygon, a micrometre inside the plate.
        if case.plate.radius is None or _is_apart(case, case.plate.radius):
            return case


def _is_apart(case: Case, radius: float) -> bool:
    """Whether a disc begins off its track, by points of it at most some micrometres apart."""
    begin, (low, high) = start_motion(case), case.track.span
    near = case.start.xi1 - 0.5, case.start.xi1 + 0.5
    ends = (low, high) if case.track.domain or case.track.period else near
    x, y = case.track.point(np.linspace(*ends, 400_001))
    return bool(np.hypot(x - begin.x, y - begin.y).min() > radius)


def _drawn(random: np.random.Generator) -> Case:
    wavelength = SIZE * 10.0 ** random.uniform(-3, 1)
    number = 2 * np.pi / wavelength
    # Their curvature is a thousandth of the plate's to thirty times it.
    height = min(10.0 ** random.uniform(-3, 1.5) / SIZE / number**2, 0.3 * wavelength)
    track = _track(str(random.choice(BASES)), height, number, random.uniform(0, 2 * np.pi))
    shape = str(random.choice(SHAPES, p=[0.6, 0.2, 0.2]))
    start = Start(
        xi1=float(random.uniform(-0.2, 0.2)),
        xi2=float(random.uniform(-np.pi, np.pi)),
        gap=float(min(SIZE * 10.0 ** random.uniform(-6, 0.5), 0.2)),
        slip=float(random.choice([-1, 1]) * 10.0 ** random.uniform(-1.5, 0.9)),
        gap_rate=float(-(10.0 ** random.uniform(-3, 0.3))),
        omega=float(random.normal() * 10),
    )
    # Most end where they land; some go on, and bounce from ripple to ripple.
    further = (CoulombFriction(0.3), Impact(float(random.choice([0.0, 0.5]))))
    effects = (Gravity(G), Unilateral(), Flight(), *(further if random.random() < 0.2 else ()))
    return Case(track, _plate(shape, random), effects, start, 0.12)


def _track(base: str, height: float, number: float, phase: float) -> Curve:
    wave = f"({height!r}*sin({number!r}*s+{phase!r}))"
    ends = None if base == "endless" and number < 2e3 else (-1.0, 1.0)
    if base == "slope":
        return Curve((f"0.8*s-0.6*{wave}", f"0.6*s+0.8*{wave}"), ends)
    if base == "valley":
        return Curve(("s", f"-0.3*cos(2*s)+{wave}"), ends)
    if base == "ring":
        around = float(max(2, round(0.5 * number)))
        low = min(height, 0.2 * np.pi / around)
        return Curve((f"(0.5+{low!r}*cos({around!r}*s))*cos(s)", f"(0.5+{low!r}*cos({around!r}*s))*sin(s)"))
    return Curve(("s", wave), ends)


def _plate(shape: str, random: np.random.Generator) -> Plate:
    if shape == "disc":
        return disc(SIZE, 1.0)
    if shape == "ellipse":
        return Plate(ellipse(SIZE, SIZE * float(random.uniform(0.3, 0.95))), 1.0, 0.004)
    lobes = float(random.integers(3, 120))
    height = float(10.0 ** random.uniform(-2.5, -0.3) / lobes**2 * random.choice([1, 3]))
    radius = f"{SIZE}*(1+{height!r}*cos({lobes!r}*s))"
    return Plate(Curve((f"{radius}*cos(s)", f"{radius}*sin(s)")), 1.0, 0.005)
