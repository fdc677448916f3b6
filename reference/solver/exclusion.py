"""Stacks of linear systems, and the combinations of modes of an impact that they exclude, of many at once.

What is violated by little, and systems that are nearly singular, are left to `impact_modes`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

# Conditions are violated by this many times their rounding.
CLEARLY = 2.0
# Impulses are compared with roundings of 1e-10: systems this far from singular have fewer.
REGULAR = 1e-4
# Singular values of matrices of size one that are zero but for roundings.
SINGULAR = 1e-11
# As many systems are solved together: a few megabytes.
TOGETHER = 2048


def solve_stack(
    delassus: np.ndarray, mix: np.ndarray, used: np.ndarray, goals: np.ndarray, least: float
) -> tuple[np.ndarray, np.ndarray]:
    """Which systems are regular: no singular value, with rows and columns of size one, is below `least`; and of these
    the unknown forces, (systems, m), zero where they are not used.

    `delassus`: from forces to rates, (m, m); `mix`: the forces that each unknown is, (systems, m, m); `used`: the rows
    that hold; `goals`: the rates that forces have to make, (systems, m) both.
    """
    sizes = np.sqrt(np.diag(delassus))
    matrix = delassus @ mix / np.outer(sizes, sizes)
    matrix = np.where(used[:, :, None] & used[:, None, :], matrix, np.eye(len(sizes)))
    regular = np.linalg.svd(matrix, compute_uv=False)[:, -1] > least
    right = np.where(used, goals / sizes, 0.0)[regular]
    return regular, np.where(used[regular], np.linalg.solve(matrix[regular], right[..., None])[..., 0] / sizes, 0.0)


class ImpactModes(NamedTuple):
    """Combinations of modes of an impact, (combinations, n) each: which contacts have impulses above their least ones,
    which end the slip, and the senses of slip of the others; and the senses of the resisted rotations, (combinations,
    m): NaN where no contact with an impulse resists."""

    closed: np.ndarray
    sticking: np.ndarray
    signs: np.ndarray
    senses: np.ndarray


def impact_exclusions(
    modes: ImpactModes, inverse: np.ndarray, rows: np.ndarray, before: np.ndarray, restitution: np.ndarray,
    least: np.ndarray, mu: np.ndarray, arms: np.ndarray, gyration: float, small: float,
) -> np.ndarray:  # fmt: skip
    """Whether impulses or velocities after an impact violate its law clearly, (combinations,).

    `rows`: of lift and slip velocities and resisted rotations, (2n + m, 3N); `before`: these velocities, (2n + m,),
    m/s; `least`: the least normal impulses, (n,); `arms`: of the resistance of each contact to each rotation, (n, m),
    m; `gyration`: the length that makes rotations velocities, m; `small`: the velocities' rounding.
    """
    closed, sticking, signs, senses = modes
    n, finite = len(mu), np.where(np.isfinite(mu), mu, 0.0)
    delassus = rows * inverse @ rows.T
    goals = -before * np.concatenate([1.0 + restitution, np.ones(len(before) - n)])
    used, result = np.hstack([closed, sticking, senses == 0.0]), np.zeros(len(closed), dtype=bool)
    senses = np.nan_to_num(senses)
    for first in range(0, len(closed), TOGETHER):
        some = slice(first, first + TOGETHER)
        mix = np.tile(np.eye(len(before)), (len(used[some]), 1, 1))
        mix[:, range(n, 2 * n), range(n)] -= signs[some] * finite
        mix[:, 2 * n :, :n] -= senses[some][:, :, None] * arms.T / gyration
        floor = np.zeros((len(mix), len(before)))  # of contacts that open, the least impulses
        floor[:, :n] = np.where(closed[some], 0.0, least)
        offset = (mix @ floor[..., None])[..., 0] @ delassus
        regular, values = solve_stack(delassus, mix, used[some], goals - offset, REGULAR)
        after = before + offset[regular] + (mix[regular] @ values[..., None])[..., 0] @ delassus
        values[:, :n] += floor[regular, :n]
        normal, friction, limit = values[:, :n], values[:, n : 2 * n], CLEARLY * small
        violations = closed[some][regular] & (normal < least - limit)
        violations |= np.isfinite(mu) & (np.abs(friction) > finite * normal + limit)
        turning = gyration * np.abs(values[:, 2 * n :]) > np.maximum(normal, 0.0) @ arms + limit
        result[some][regular] = violations.any(axis=1) | turning.any(axis=1)
        single, rates_of_single, result[some][~regular] = _without_unique_impulses(
            delassus, mix[~regular], used[some][~regular], (goals - offset)[~regular], limit
        )
        every = np.append(np.flatnonzero(regular), np.flatnonzero(~regular)[single])
        after = np.append(after, before + offset[~regular][single] + rates_of_single, axis=0)
        shut, slips, turns = closed[some][every], signs[some][every], senses[some][every]
        violations = ~shut & (after[:, :n] + restitution * before[:n] < -limit)
        violations |= slips * after[:, n : 2 * n] < -limit
        result[some][every] |= violations.any(axis=1) | (turns * after[:, 2 * n :] < -limit).any(axis=1)
    return result


def _without_unique_impulses(
    delassus: np.ndarray, mix: np.ndarray, used: np.ndarray, goals: np.ndarray, limit: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of systems without unique solutions: those whose solutions all make the same velocities, these velocities'
    changes, and which systems have no solution. Arguments as of `solve_stack`; `limit`: of velocities, m/s."""
    sizes = np.sqrt(np.diag(delassus))
    both = used[:, :, None] & used[:, None, :]
    matrix = np.where(both, delassus @ mix / np.outer(sizes, sizes), 0.0)
    right = np.where(used, goals / sizes, 0.0)
    left, values, basis = np.linalg.svd(matrix)
    is_clear = ~((values > SINGULAR) & (values < REGULAR)).any(axis=1)
    inverse = np.where(values > REGULAR, 1.0 / np.maximum(values, REGULAR), 0.0)
    parts = (np.swapaxes(left, 1, 2) @ right[..., None])[..., 0] * inverse
    forces = (np.swapaxes(basis, 1, 2) @ parts[..., None])[..., 0]
    missing = np.abs((matrix @ forces[..., None])[..., 0] - right) * sizes
    # What the columns of the null space change of all velocities.
    idle = np.where((values <= SINGULAR)[:, :, None], basis, 0.0) * used[:, None, :] / sizes
    changes = idle @ np.swapaxes(delassus @ mix, 1, 2)
    single = is_clear & (np.abs(changes / sizes).max(axis=(1, 2), initial=0.0) <= SINGULAR)
    rates = (mix @ (forces / sizes)[..., None])[..., 0] @ delassus
    return single, rates[single], is_clear & (missing.max(axis=1, initial=0.0) > limit)
