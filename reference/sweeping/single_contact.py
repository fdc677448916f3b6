"""Proof that a second contact is impossible, for many scenarios at once: by curvatures and energy, without motions.

The pose of a disc follows from its place, so each stretch of track either has room for it or has not. A plate driven by
gravity alone never reaches a place where its potential exceeds its initial energy.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from cases import Case, Curve, Gravity, Load
from cases.contact.geometry import pose
from cases.contact.overlap_search import first_overlap

from ..curvature_proof import fits
from .geometry import energy, places
from .scenario_values import ScenarioGroup

# Places along a track at which a disc is tested: a hundredth of the usual track, as `cases.contact.overlap_search`
# samples it.
TRACK_SAMPLES = 2000


def one_contact(scenes: ScenarioGroup) -> np.ndarray:
    """Which scenarios certainly touch their track in one place only, (n,); false means unknown."""
    certain = np.zeros(len(scenes.rows), dtype=bool)
    for some in _of_one_shape(scenes):
        base, number = scenes.only(some), int(some[0])
        certain[some] = _one_contact(base, scenes.base if scenes.same else scenes.alone(number))
    return certain


def _of_one_shape(scenes: ScenarioGroup) -> list[np.ndarray]:
    """The indices of scenarios, grouped by their curves."""
    n = len(scenes.rows)
    if scenes.same:
        return [np.arange(n)]
    shapes = [c for name, c in sorted(scenes.numbers.items()) if name.startswith(("track_", "outline_"))]
    _, which = np.unique(np.array(shapes), axis=1, return_inverse=True)
    order = np.argsort(which.reshape(-1), kind="stable")
    return np.split(order, np.flatnonzero(np.diff(which.reshape(-1)[order])) + 1)


def _one_contact(scenes: ScenarioGroup, base: Case) -> np.ndarray:
    """Same as `one_contact`, for scenarios with the curves of `base`."""
    track, outline, n = base.track, base.plate.outline, len(scenes.rows)
    is_alike = track.features is None  # a straight line is the same wherever the plate goes
    if (is_alike or track.domain is not None or track.period) and fits(track, outline, *track.span):
        return np.ones(n, dtype=bool)
    if base.plate.radius is None or base.effect(Load) is not None or base.effect(Gravity) is None:
        return np.zeros(n, dtype=bool)
    return _within(scenes, base, _free(track, outline, float(np.median(scenes.numbers["xi1"]))))


@lru_cache(maxsize=16)
def _free(track: Curve, outline: Curve, near: float) -> np.ndarray:
    """Places, at most TRACK_SAMPLES, on the longest stretch around `near` on which a disc overlaps its track
    nowhere."""
    low, high = track.span
    if track.domain is None and not track.period:
        low, high = min(low, near - (high - low)), max(high, near + (high - low))
    if track.period:
        low, high = near - 0.5 * track.period, near + 0.5 * track.period
    grid = np.linspace(low, high, TRACK_SAMPLES)
    middle = int(np.clip(np.searchsorted(grid, near), 1, TRACK_SAMPLES - 1))
    fits = track.curvature(grid) < outline.curvature(outline.span[0])
    back = _count(track, outline, grid[middle - 1 :: -1], fits[middle - 1 :: -1])
    return grid[middle - back : middle + _count(track, outline, grid[middle:], fits[middle:])]


def _count(track: Curve, outline: Curve, grid: np.ndarray, fits: np.ndarray) -> int:
    """The number of consecutive places along `grid`, from its first, at which there is room."""
    count = len(grid) if fits.all() else int(np.argmin(fits))
    if not count:
        return 0
    xi2 = np.full(count, outline.span[0])
    x, y, theta = pose(track, outline, grid[:count], xi2)
    overlap = first_overlap(track, outline, x, y, theta, grid[:count])
    return count if overlap is None else overlap[0]


def _within(scenes: ScenarioGroup, base: Case, free: np.ndarray) -> np.ndarray:
    """Which scenarios stay on the free stretch: all if it is the whole track, else those with too little energy to
    leave it on either side."""
    inputs, track, outline, n = scenes.numbers, base.track, base.plate.outline, len(scenes.rows)
    if len(free) == TRACK_SAMPLES and (track.domain is not None or track.period):
        return np.ones(n, dtype=bool)
    if not len(free):
        return np.zeros(n, dtype=bool)
    pull = inputs["gx"], inputs["gy"]
    f, h = (
        places(track, scenes.constants("track"), inputs["xi1"]),
        places(outline, scenes.constants("outline"), inputs["xi2"]),
    )
    has = energy(f, h, inputs["slip"], inputs["omega"], pull, inputs["mass"], inputs["inertia"])
    x, y, _ = pose(track, outline, free, np.full(len(free), outline.span[0]))
    needs = -(np.multiply.outer(pull[0], x) + np.multiply.outer(pull[1], y))  # per mass, wherever it goes
    beyond = needs > ((has + 1e-9 * np.abs(has)) / inputs["mass"])[:, None] + 1e-9 * np.abs(needs)
    before = free[None, :] < inputs["xi1"][:, None]
    inside = (free[0] <= inputs["xi1"]) & (inputs["xi1"] <= free[-1])
    return inside & (beyond & before).any(axis=1) & (beyond & ~before).any(axis=1)
