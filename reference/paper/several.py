"""The paper's augmented system for several contacts of one plate: (27) with a block for each contact.

    [ M    0    −A₁ … −A_K ] [q̈₁  ]   [F  ]
    [ B_k  D_k       0     ] [q̈₂,k] = [C_k]        k = 1 … K
                             [λ_k ]

Every closed contact has its own q₂ = (ξ₁, ξ₂), its rows (8)″ and (9)″ with the third derivatives of (25), and its
column of (33); one that does not slip has the tangential column and the row of rolling as well. Literal and slow; the
fast form is tested against it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cases import Case, CoulombFriction, Mode

from .augmented import (
    SIGN,
    applied_torsor,
    constraints,
    mass_matrix,
    rolling_row,
    sliding_column,
    tangential_column,
)
from .kinematics import kinematics


class SeveralSolution(NamedTuple):
    """q̈₁ (3,), and for each closed contact q̈₂ (2,), normal force and friction force (N)."""

    q1_ddot: np.ndarray
    q2_ddot: list[np.ndarray]
    normal_force: list[float]
    friction_force: list[float]


def solve_several(
    case: Case,
    modes: Sequence[Mode],
    states: Sequence[Sequence[float]],
    motion: Sequence[float],
) -> SeveralSolution:
    """Accelerations and forces of a plate with closed contacts in those modes.

    `states`: (ξ₁, ξ₂, ξ̇₁, ξ̇₂) of each; `motion`: the arguments of a load, (t, X₀, Y₀, θ, Ẋ₀, Ẏ₀, θ̇). Raises
    numpy.linalg.LinAlgError where the forces are not unique.
    """
    contacts = [kinematics(case, *state) for state in states]
    friction = case.effect(CoulombFriction)
    rolls = [mode is Mode.ROLL for mode in modes]
    count, multipliers = len(contacts), len(contacts) + sum(rolls)
    matrix = np.zeros((3 + 2 * count + multipliers,) * 2)
    right = np.zeros(len(matrix))
    matrix[:3, :3], right[:3] = mass_matrix(case), applied_torsor(case, motion)
    row, column = 3, 3 + 2 * count
    columns: list[tuple[int, float]] = []
    for i, (k, mode, is_rolling) in enumerate(zip(contacts, modes, rolls, strict=True)):
        own = slice(3 + 2 * i, 5 + 2 * i)
        ratio = SIGN.get(mode, 0.0) * friction.at_rest if friction else 0.0
        matrix[row : row + 3, :3], matrix[row : row + 3, own], right[row : row + 3] = constraints(k)
        matrix[:3, column : column + 1] = -sliding_column(k, ratio)
        columns.append((column, ratio))
        row, column = row + 3, column + 1
        if is_rolling:
            matrix[:3, column : column + 1] = -tangential_column(k)
            matrix[row, own], right[row] = rolling_row(k)
            row, column = row + 1, column + 1
    answer = np.linalg.solve(matrix, right)
    speeds = [float(np.hypot(*k.Rp)) for k in contacts]
    normal = [float(answer[place]) * speed for (place, _), speed in zip(columns, speeds, strict=True)]
    tangential = [
        float(answer[place + 1]) * speed if is_rolling else ratio * force
        for (place, ratio), speed, is_rolling, force in zip(columns, speeds, rolls, normal, strict=True)
    ]
    return SeveralSolution(answer[:3], list(answer[3 : 3 + 2 * count].reshape(-1, 2)), normal, tangential)
