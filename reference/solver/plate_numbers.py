"""Numbers of the plates of a case: inverse masses, sizes, and the accelerations of their loads.

The state of n plates is (x, y, θ) of each, then (vx, vy, ω) of each: 6 n numbers.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache
from itertools import product
from math import hypot
from typing import NamedTuple

import numpy as np

from cases import Case
from cases.scene.free_plates import loads_of, plates_of

from ..effect_laws.applied_forces import weight
from ..effect_laws.own_forces import own_force_values

# In place of the number of a plate: what is fixed.
FIXED = -1
# Of plates (the numbers of a contact's `sides`) whose closed contacts resist rolling: the sense in which the first one
# turns against the second one, or against what is fixed; 0 if it does not.
Sides = tuple[int, ...]
Turns = tuple[tuple[Sides, int], ...]


class Bodies(NamedTuple):
    """Of all plates: reaches (m), inverse masses and moments of inertia (3n,), these themselves, 0 for a rotation that
    is not possible, lengths (3n,) by which velocities are compared (m; 1 for translations), and the accelerations (3n,)
    per force and moment of a load: those are the inverses, but of a plate that is turned."""

    reaches: tuple[float, ...]
    inverse: np.ndarray
    masses: np.ndarray
    lengths: np.ndarray
    per_load: np.ndarray


@lru_cache(maxsize=256)
def bodies(case: Case) -> Bodies:
    """The numbers of a case's plates."""
    plates = plates_of(case)
    reaches = tuple(float(plate.reach if plate.radius is None else plate.radius) for plate in plates)
    inverse = np.array([value for p in plates for value in (1.0 / p.mass, 1.0 / p.mass, 1.0 / p.inertia)])
    masses = np.divide(1.0, inverse, out=np.zeros(len(inverse)), where=inverse > 0.0)
    per_load = inverse + [value for p in plates for value in (0.0, 0.0, float(p.spins_by_load))]
    return Bodies(reaches, inverse, masses, np.array([v for r in reaches for v in (1.0, 1.0, r)]), per_load)


def load_at(case: Case, t: float, state: Sequence[float] | np.ndarray) -> np.ndarray:
    """The accelerations (3n,) that weight and loads give all plates."""
    half = len(state) // 2
    result = np.array((*weight(case), 0.0) * (half // 3))
    for b, force in _forces(case, t, state):
        own = slice(3 * b, 3 * b + 3)
        result[own] += np.array(force) * bodies(case).per_load[own]
    return result


def _forces(case: Case, t: float, state: Sequence[float] | np.ndarray) -> Iterator[tuple[int, list[float]]]:
    """The numbers of plates with a load, and force and moment (N, N m) on them."""
    half = len(state) // 2
    for b, load in enumerate(loads_of(case)):
        if load is not None:
            own = (*state[3 * b : 3 * b + 3], *state[half + 3 * b : half + 3 * b + 3])
            yield b, load.at(t, *map(float, own))


def load_scale(case: Case, t: float, state: Sequence[float] | np.ndarray) -> float:
    """The size of accelerations (m/s²): weight, loads and forces of the user's own, each alone, as they may cancel, and
    what turns velocities."""
    some = bodies(case)
    applied = sum(
        (abs(fx) + abs(fy) + abs(moment) / some.reaches[b]) * float(some.inverse[3 * b])
        for b, (fx, fy, moment) in _forces(case, t, state)
    )
    for along, across, couple in own_force_values(case, t, 0.0, 0.0):
        own = abs(along) + abs(across) + abs(couple) / min(some.reaches)
        applied += own * float(some.inverse.reshape(-1, 3)[:, 0].max()) if np.isfinite(own) else 0.0
    return hypot(*weight(case)) + applied + speed(case, state) ** 2 / min(some.reaches)


def size(case: Case, state: Sequence[float] | np.ndarray) -> float:
    """The size of the poses' numbers, m."""
    half = len(state) // 2
    far = max(abs(x) + abs(y) for x, y in zip(state[:half:3], state[1:half:3], strict=True))
    return float(far + max(bodies(case).reaches))


def speed(case: Case, state: Sequence[float] | np.ndarray) -> float:
    """The largest of the plates' speeds, m/s; that of a spin at the reach."""
    rates = state[len(state) // 2 :]
    every = zip(rates[::3], rates[1::3], rates[2::3], bodies(case).reaches, strict=True)
    return float(max([max(abs(vx), abs(vy), abs(omega) * reach) for vx, vy, omega, reach in every]))


def rows_of(some: Iterable[int]) -> list[int]:
    """The rows (of 3n) of some plates."""
    return [3 * body + c for body in sorted(some) for c in range(3)]


def turning_row(sides: Sides, size: int) -> np.ndarray:
    """The row (3n,), of that size, of the rotation of a plate against another one, or against what is fixed."""
    row = np.zeros(size)
    row[[3 * body + 2 for body in sides]] = (1.0, -1.0)[: len(sides)]
    return row


def rigid_pairs(turns: Turns) -> list[Sides]:
    """The plates that do not turn against each other. Left out are those that others hold: two plates that do not turn
    against a third one do not turn against each other."""
    together, result = dict[int, int](), list[Sides]()

    def root(body: int) -> int:
        while body in together:
            body = together[body]
        return body

    for sides in (sides for sides, sense in turns if sense == 0):
        first, second = root(sides[0]), root(sides[1] if len(sides) > 1 else FIXED)
        if first != second:
            together[max(first, second)] = min(first, second)
            result.append(sides)
    return result


@lru_cache(maxsize=256)
def senses_of(resisting: tuple[Sides, ...]) -> list[tuple[int, ...]]:
    """The senses (1, −1; 0: none) that the rotations of these pairs of plates, or against what is fixed, may have at
    once: those of an order of the plates' spins."""
    every = list(product((0, 1, -1), repeat=len(resisting)))
    if len(resisting) < 3:  # without a round of pairs each sense goes with each other
        return every
    numbers = {body: k for k, body in enumerate(dict.fromkeys([FIXED, *(b for sides in resisting for b in sides)]))}
    pairs = [(numbers[sides[0]], numbers[sides[1] if len(sides) > 1 else FIXED]) for sides in resisting]
    return [senses for senses in every if _is_order(pairs, senses, len(numbers))]


def _is_order(pairs: Sequence[tuple[int, int]], senses: Sequence[int], count: int) -> bool:
    """Whether no number is above another one that is at least as high."""
    at_least, above = np.eye(count, dtype=bool), list[tuple[int, int]]()
    for (one, other), sense in zip(pairs, senses, strict=True):
        if sense >= 0:
            at_least[one, other] = True
        if sense <= 0:
            at_least[other, one] = True
        if sense:
            above.append((one, other) if sense > 0 else (other, one))
    for k in range(count):
        at_least |= np.outer(at_least[:, k], at_least[k])
    return not any(at_least[low, high] for high, low in above)
