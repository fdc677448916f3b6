"""Random flights over ripples, and where a disc's ends: by its centre's closest approach to each point of the track.

That is another way than the reference's: no tangents, no gap, no search in time. The centre's path is a parabola, so
the distance to a point of the track is least where a cubic vanishes; what is left is a function of the track's
parameter, sampled finely in each wavelength and refined where it is least.
"""

from __future__ import annotations

from typing import NamedTuple

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
# Samples of the track to a wavelength, and times to a flight from which Newton's method goes on.
SAMPLES, TIMES = 32, 24


def over_ripples(height: float, length: float, gap: float, g: float = 0.0) -> Case:
    """A disc at 5 m/s that sinks at 2 mm/s over y = height cos(2 pi x/length), from a gap over a crest."""
    track = Curve(("s", f"{height!r}*cos({2 * np.pi / length!r}*s)"), (-1, 1))
    effects = (*FLYING, Gravity(g)) if g else FLYING
    return Case(track, disc(0.1, 1.0), effects, Start(0.0, gap=gap, slip=5.0, gap_rate=-0.002), 0.05)


class Rippled(NamedTuple):
    """A flight over ripples of that wavelength (m)."""

    case: Case
    shape: str
    wavelength: float


def rippled(seed: int) -> Rippled:
    """A plate thrown at a track with ripples, whose wavelength is 10 to 1e-3 of the plate's size."""
    random = np.random.default_rng(seed)
    while True:
        try:
            scene = _drawn(random)
        except CaseError:  # ripples that cross each other, or a start inside the track
            continue
        # A case's own check of its start looks at a polygon, a micrometre inside the plate.
        if scene.shape != "disc" or closest(scene, 0.0).apart > 0.0:
            return scene


def _drawn(random: np.random.Generator) -> Rippled:
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
    return Rippled(Case(track, _plate(shape, random), effects, start, 0.12), shape, wavelength)


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


# --- the closest approach ---------------------------------------------------------------------------------------------


class Approach(NamedTuple):
    """How near a disc comes to a track (m, negative: it overlaps), where on the track, and when (s)."""

    apart: float
    xi1: float
    time: float


class _Path:
    """The parabola of a plate's centre until a time (s)."""

    def __init__(self, case: Case, until: float):
        start = start_motion(case)
        self.x, self.y, self.vx, self.vy, self.until = start.x, start.y, start.vx, start.vy, until

    def at(self, t):
        return self.x + self.vx * t, self.y + self.vy * t - 0.5 * G * t * t

    def closest(self, points: np.ndarray, near: np.ndarray, wide: float) -> tuple[np.ndarray, np.ndarray]:
        """The least distances to points (2, n) at times no farther than `wide` from `near`, and when."""
        low, high, t = np.maximum(near - wide, 0.0), np.minimum(near + wide, self.until), near
        for _ in range(6):
            x, y = self.at(t)
            dx, dy, vy = x - points[0], y - points[1], self.vy - G * t
            slope, bend = dx * self.vx + dy * vy, self.vx**2 + vy**2 - G * dy
            t = np.clip(t - np.where(bend > 0.0, slope / np.where(bend > 0.0, bend, 1.0), 0.0), low, high)
        x, y = self.at(t)
        return np.hypot(x - points[0], y - points[1]), t

    def nearest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The same over the whole path."""
        times = np.linspace(0.0, self.until, TIMES)
        x, y = self.at(times[:, None])
        best = np.hypot(x - points[0], y - points[1]).argmin(axis=0)
        return self.closest(points, times[best], times[1])


def closest(scene: Rippled, until: float) -> Approach:
    """The closest approach of a thrown disc to its track before a time, as if nothing stopped it."""
    path, track, radius = _Path(scene.case, until), scene.case.track, scene.case.plate.radius
    assert radius is not None
    s = _beside(path, track, radius, scene.wavelength)
    if not len(s):
        return Approach(np.inf, np.nan, np.nan)
    lots = [path.nearest(track.point(some)) for some in np.array_split(s, 1 + len(s) // 20_000)]
    away, when = (np.concatenate(column) for column in zip(*lots, strict=True))
    lowest = np.flatnonzero((away <= np.append(away[1:], np.inf)) & (away <= np.append(np.inf, away[:-1])))
    lowest = lowest[np.argsort(away[lowest])][:40]
    at, near, wide, around = s[lowest], when[lowest], s[1] - s[0], np.linspace(-1.0, 1.0, 33)
    for _ in range(14):
        grid = at[:, None] + wide * around
        away, when = path.closest(track.point(grid.ravel()), np.repeat(near, len(around)), until / (TIMES - 1))
        away, when = away.reshape(grid.shape), when.reshape(grid.shape)
        best = np.arange(len(at)), away.argmin(axis=1)
        at, near, wide = grid[best], when[best], wide / 8.0
    first = int(away[best].argmin())
    return Approach(float(away[best][first]) - radius, float(at[first]), float(near[first]))


def _beside(path: _Path, track: Curve, radius: float, wavelength: float) -> np.ndarray:
    """Parameters of the track, many to a wavelength, wherever the disc comes near."""
    x, y = path.at(np.linspace(0.0, path.until, 100)[:, None])
    low, high = track.span
    if track.domain is None and not track.period:
        low, high = float(x.min()) - 2.0 * radius, float(x.max()) + 2.0 * radius
    coarse = np.linspace(low, high, 4001)
    points = track.point(coarse)
    apart = float(np.hypot(np.diff(x[:, 0]), np.diff(y[:, 0])).max() + np.hypot(*np.diff(points)).max())
    near = coarse[np.hypot(x - points[0], y - points[1]).min(axis=0) < radius + apart]
    if not len(near):
        return near
    low, high = max(near[0] - coarse[1] + coarse[0], low), min(near[-1] + coarse[1] - coarse[0], high)
    length = float(np.mean(track.speed(coarse))) * (high - low)
    return np.linspace(low, high, max(2000, int(SAMPLES * length / wavelength)))
