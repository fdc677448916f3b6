"""The paper's augmented system for several contacts of one plate: (27) with a block for each contact.

    [ M    0    −A₁ … −A_K ] [q̈₁  ]   [F  ]
    [ B_k  D_k       0     ] [q̈₂,k] = [C_k]        k = 1 … K
                             [λ_k ]

Every closed contact has its own q₂ = (ξ₁, ξ₂), its rows (8)″ and (9)″ with the third derivatives of (25), and its
column of (33); one that does not slip has the tangential column and the row of rolling as well. At a corner of the
outline r_p vanishes: ξ₂ and the row (9)″ are left out, and θ̇ is part of the state. Literal and slow; the fast form is
tested against it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cases import CoulombFriction, Mode
from cases.contact_pairs import PairCase
from cases.corner import Corner

from .augmented import (
    SIGN,
    applied_torsor,
    constraints,
    mass_matrix,
    rolling_row,
    sliding_column,
    tangential_column,
)
from .kinematics import Kinematics, U, kinematics


class SeveralSolution(NamedTuple):
    """q̈₁ (3,), and for each closed contact q̈₂ (2,), of a corner (1,), normal force and friction force (N)."""

    q1_ddot: np.ndarray
    q2_ddot: list[np.ndarray]
    normal_force: list[float]
    friction_force: list[float]


def solve_several(
    pairs: Sequence[PairCase],
    modes: Sequence[Mode],
    states: Sequence[Sequence[float]],
    motion: Sequence[float],
) -> SeveralSolution:
    """Accelerations and forces of a plate with closed contacts in those modes, one for each pair of a support and a
    feature of its outline.

    `states`: (ξ₁, ξ₂, ξ̇₁, ξ̇₂) of each; `motion`: the arguments of a load, (t, X₀, Y₀, θ, Ẋ₀, Ẏ₀, θ̇). Raises
    numpy.linalg.LinAlgError where the forces are not unique.
    """
    whole = pairs[0].whole
    contacts = [_kinematics(pair, state, motion[6]) for pair, state in zip(pairs, states, strict=True)]
    sizes = [1 if isinstance(pair.plate.outline, Corner) else 2 for pair in pairs]
    rolls = [mode is Mode.ROLL for mode in modes]
    column = 3 + sum(sizes)
    matrix = np.zeros((column + len(contacts) + sum(rolls),) * 2)
    right = np.zeros(len(matrix))
    matrix[:3, :3], right[:3] = mass_matrix(whole), applied_torsor(whole, motion)
    row, first = 3, 3
    columns: list[tuple[int, float]] = []
    parameters: list[slice] = []
    for pair, k, mode, is_rolling, size in zip(pairs, contacts, modes, rolls, sizes, strict=True):
        own, friction = slice(first, first + size), pair.effect(CoulombFriction)
        ratio = SIGN.get(mode, 0.0) * friction.at_rest if friction else 0.0
        rows = slice(row, row + size + 1)
        B, D, C = constraints(k)
        matrix[rows, :3], matrix[rows, own], right[rows] = B[: size + 1], D[: size + 1, :size], C[: size + 1]
        matrix[:3, column : column + 1] = -sliding_column(k, ratio)
        columns.append((column, ratio))
        parameters.append(own)
        row, column, first = row + size + 1, column + 1, first + size
        if is_rolling:
            matrix[:3, column : column + 1] = -tangential_column(k)
            coefficients, right[row] = rolling_row(k)
            matrix[row, own] = coefficients[:size]
            row, column = row + 1, column + 1
    answer = np.linalg.solve(matrix, right)
    speeds = [float(np.hypot(*k.Rp)) for k in contacts]
    normal = [float(answer[place]) * speed for (place, _), speed in zip(columns, speeds, strict=True)]
    tangential = [
        float(answer[place + 1]) * speed if is_rolling else ratio * force
        for (place, ratio), speed, is_rolling, force in zip(columns, speeds, rolls, normal, strict=True)
    ]
    return SeveralSolution(answer[:3], [answer[own] for own in parameters], normal, tangential)


def _kinematics(pair: PairCase, state: Sequence[float], spin: float) -> Kinematics:
    """(1)-(9) of a contact; at a corner of the outline, whose derivatives vanish, with the plate's spin (rad/s)."""
    corner = pair.plate.outline
    if not isinstance(corner, Corner):
        return kinematics(pair, *state)
    xi1, xi2, xi1_dot, xi2_dot = state
    R, Rp, Rs, Rt = np.array(pair.track.jet(xi1)).reshape(4, 2)
    theta = float(np.arctan2(Rp[1], Rp[0])) - float(corner.tangent_angle(xi2))
    turn = np.array([[np.cos(theta), -np.sin(theta)], [np.sin(theta), np.cos(theta)]])
    r, none = np.array([corner.x, corner.y]), np.zeros(2)
    R0, q, q_dot = R - turn @ r, np.array([xi1, xi2]), np.array([xi1_dot, xi2_dot])
    R0_dot = xi1_dot * Rp - spin * (U @ turn @ r)
    return Kinematics(q, q_dot, R, Rp, Rs, Rt, r, none, none, none, theta, turn, R0, spin, R0_dot)
