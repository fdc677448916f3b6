"""Numbers of the plates of a case: inverse masses, sizes, and the accelerations of their loads.

The state of n plates is (x, y, θ) of each, then (vx, vy, ω) of each: 6 n numbers.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from cases import Case, Gravity, Load
from cases.free_plates import plates_of


class Bodies(NamedTuple):
    """Of all plates: reaches (m), inverse masses and moments of inertia (3n,), and lengths (3n,) by which velocities
    are compared (m; 1 for translations)."""

    reaches: tuple[float, ...]
    inverse: np.ndarray
    lengths: np.ndarray

    @property
    def masses(self) -> np.ndarray:
        """Masses and moments of inertia (3n,); 0 for a rotation that is not possible."""
        return np.divide(1.0, self.inverse, out=np.zeros(len(self.inverse)), where=self.inverse > 0.0)


@lru_cache(maxsize=256)
def bodies(case: Case) -> Bodies:
    """The numbers of a case's plates."""
    plates = plates_of(case)
    reaches = tuple(float(plate.reach if plate.radius is None else plate.radius) for plate in plates)
    inverse = np.array([value for p in plates for value in (1.0 / p.mass, 1.0 / p.mass, 1.0 / p.inertia)])
    return Bodies(reaches, inverse, np.array([v for r in reaches for v in (1.0, 1.0, r)]))


def load_at(case: Case, t: float, state: Sequence[float] | np.ndarray) -> np.ndarray:
    """The accelerations (3n,) that weight gives all plates, and a load the first one."""
    gravity, load, half = case.effect(Gravity), case.effect(Load), len(state) // 2
    result = np.tile((*gravity.vector, 0.0) if gravity is not None else (0.0, 0.0, 0.0), half // 3)
    if load is not None:
        force = load.at(t, *map(float, state[:3]), *map(float, state[half : half + 3]))
        result[:3] += np.array(force) * bodies(case).inverse[:3]
    return result


def load_scale(case: Case, t: float, state: Sequence[float] | np.ndarray) -> float:
    """The size of accelerations (m/s²): weight and load, each alone, as they may cancel, and what turns velocities."""
    gravity, load, half, some = case.effect(Gravity), case.effect(Load), len(state) // 2, bodies(case)
    fx, fy, moment = (
        load.at(t, *map(float, state[:3]), *map(float, state[half : half + 3])) if load is not None else (0.0, 0.0, 0.0)
    )
    applied = (abs(fx) + abs(fy) + abs(moment) / some.reaches[0]) * some.inverse[0]
    speeds = np.abs(np.asarray(state[half:], dtype=float) * some.lengths)
    return (gravity.g if gravity else 0.0) + applied + float(speeds.max()) ** 2 / min(some.reaches)


def size(case: Case, state: Sequence[float] | np.ndarray) -> float:
    """The size of the poses' numbers, m."""
    poses = np.asarray(state[: len(state) // 2], dtype=float).reshape(-1, 3)
    return float(np.abs(poses[:, :2]).sum(axis=1).max() + max(bodies(case).reaches))


def speed(case: Case, state: Sequence[float] | np.ndarray) -> float:
    """The largest of the plates' speeds, m/s; that of a spin at the reach."""
    return float(np.abs(np.asarray(state[len(state) // 2 :]) * bodies(case).lengths).max())


def rows_of(some: Iterable[int]) -> list[int]:
    """The rows (of 3n) of some plates."""
    return [3 * body + c for body in sorted(some) for c in range(3)]
