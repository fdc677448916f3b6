"""Where a second contact is impossible, for many scenarios at once: by theorems and by energy, without their motions.

A disc's place says all of its pose, so that a stretch of track either has room for it or has not; and a plate that only
gravity drives never comes to where its potential exceeds the energy it began with.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from cases import Case, Flight, Gravity, Load
from cases.contact import pose
from cases.overlap import first_overlap

from ..minimal.overlap import fits_everywhere
from .geometry import energy, places
from .scenes import Scenes

# Places along a track at which a disc is looked at: a hundredth of the usual track, as `cases.overlap` samples it.
LOOKS = 2000


def one_contact(scenes: Scenes) -> np.ndarray:
    """Which scenarios surely touch their track in one place only, (n,); of the others nothing is said."""
    base, n = scenes.base, len(scenes.rows)
    track, outline = base.track, base.plate.outline
    ends = track.domain is not None or track.period is not None or track.features is None
    if ends and not scenes.same:
        return np.array([fits_everywhere(scenes.alone(i), ()) for i in range(n)])
    if ends and scenes.same and fits_everywhere(base, ()):
        return np.ones(n, dtype=bool)
    if not scenes.same or base.plate.radius is None or base.effect(Load) or not base.effect(Gravity):
        return np.zeros(n, dtype=bool)
    return _within(scenes, _free(track, outline, float(np.median(scenes.numbers["xi1"]))))


@lru_cache(maxsize=16)
def _free(track, outline, near: float) -> tuple[float, float]:
    """The longest stretch about `near` on which a disc overlaps its track nowhere, looked at in LOOKS places."""
    low, high = track.span
    if track.domain is None and not track.period:
        low, high = min(low, near - (high - low)), max(high, near + (high - low))
    if track.period:
        low, high = near - 0.5 * track.period, near + 0.5 * track.period
    grid = np.linspace(low, high, LOOKS)
    middle = int(np.argmin(np.abs(grid - near)))
    bends = track.curvature(grid)
    fits = bends < outline.curvature(outline.span[0])
    return _until(track, outline, grid[middle::-1], fits[middle::-1]), _until(track, outline, grid[middle:], fits[middle:])


def _until(track, outline, grid: np.ndarray, fits: np.ndarray) -> float:
    """How far along `grid` there is room."""
    count = len(grid) if fits.all() else int(np.argmin(fits))
    xi2 = np.full(count, outline.span[0])
    theta = track.tangent_angle(grid[:count]) - outline.tangent_angle(xi2)
    c, s = np.cos(theta), np.sin(theta)
    (X, Y), (u, v) = track.point(grid[:count]), outline.point(xi2)
    found = first_overlap(track, outline, X - (c * u - s * v), Y - (s * u + c * v), theta, grid[:count])
    count = count if found is None else max(found[0] - 1, 0)
    return float(grid[max(count - 1, 0)])


def _within(scenes: Scenes, free: tuple[float, float]) -> np.ndarray:
    """Which scenarios have too little energy to come to either end of the stretch."""
    known, (track, outline) = scenes.numbers, (scenes.base.track, scenes.base.plate.outline)
    pull, sizes = (known["gx"], known["gy"]), (scenes.constants("track"), scenes.constants("outline"))
    f, h = places(track, sizes[0], known["xi1"]), places(outline, sizes[1], known["xi2"])
    has = energy(f, h, known["slip"], known["omega"], pull, known["mass"], known["inertia"])
    inside = (free[0] <= known["xi1"]) & (known["xi1"] <= free[1])
    for bound in free:
        there = places(track, sizes[0], np.full(len(has), bound))
        needs = energy(there, h, 0.0, 0.0, pull, known["mass"], known["inertia"])
        inside &= needs > has + 1e-9 * (np.abs(has) + np.abs(needs))  # far above rounding
    return inside
