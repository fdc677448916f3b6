"""The paper's augmented system, (15)–(34): accelerations and multipliers from one matrix, block by block.

    [ M  0  −A ] [ q̈₁ ]   [ F ]
    [ B  D   0 ] [ q̈₂ ] = [ C ]                                                                                  (27)
                 [ λ  ]

with q₁ = (X₀, Y₀, θ) and q₂ = (ξ₁, ξ₂). While the plate slides there is one multiplier (6×6); rolling adds a column,
the tangential multiplier, and a row, R_pᵀ v = 0 differentiated (7×7). Literal and slow: what the fast form is
tested against.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cases import Case, CoulombFriction, Gravity, Mode

from .kinematics import I2, Kinematics, U, kinematics

# (30): the friction coefficient's sign is opposite to the slip velocity's.
SIGN = {Mode.SLIP_FORWARD: -1.0, Mode.SLIP_BACKWARD: +1.0}


class Solution(NamedTuple):
    """(27) solved: q̈₁ shape (3,), q̈₂ shape (2,), multipliers λ shape (1,) or (2,), and the contact forces in N."""

    q1_ddot: np.ndarray
    q2_ddot: np.ndarray
    multipliers: np.ndarray
    normal_force: float
    friction_force: float


def mass_matrix(case: Case) -> np.ndarray:
    """M of (16)."""
    return np.diag([case.plate.mass, case.plate.mass, case.plate.inertia])


def applied_torsor(case: Case) -> np.ndarray:
    """F of (19): the external torsor (F_x, F_y, M₀) in the fixed frame."""
    gravity = case.effect(Gravity)
    if gravity is None:
        return np.zeros(3)
    weight = case.plate.mass * gravity.g
    return np.array([weight * np.cos(gravity.direction), weight * np.sin(gravity.direction), 0.0])


def sliding_column(k: Kinematics, mu: float) -> np.ndarray:
    """Ã of (33), shape (3, 1), with the corrected Ũ = I₂ − μU of (32); mu carries the sign of (30)."""
    Rp_tilde = (I2 - mu * U) @ k.Rp
    return np.array([*(U @ Rp_tilde), Rp_tilde @ k.turn @ k.r]).reshape(3, 1)


def tangential_column(k: Kinematics) -> np.ndarray:
    """The column of the rolling plate's tangential multiplier, shape (3, 1): a force along R_p and its moment."""
    return np.array([*k.Rp, (U @ k.turn @ k.r) @ k.Rp]).reshape(3, 1)


def constraints(k: Kinematics) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """B (3×3), D (3×2) of (23) from (8) and (9), and C (3,) of (25), where the third derivatives enter."""
    arm, rp, rs, rt = k.turn @ k.r, k.turn @ k.rp, k.turn @ k.rs, k.turn @ k.rt
    (u1, u2), w = k.q_dot, k.theta_dot
    S, E, G = k.Rp @ rp, k.Rs @ U @ rp, k.Rp @ U @ rs
    B = np.array([[1, 0, (U @ arm)[0]], [0, 1, (U @ arm)[1]], [0, 0, -S]])
    D = np.array([[-k.Rp[0], rp[0]], [-k.Rp[1], rp[1]], [E, G]])
    # (25), the derivative of each coefficient by the product rule and (7).
    arm_dot, rp_dot = w * (U @ arm) + u2 * rp, w * (U @ rp) + u2 * rs
    rs_dot = w * (U @ rs) + u2 * rt
    S_dot = u1 * (k.Rs @ rp) + k.Rp @ rp_dot
    E_dot = u1 * (k.Rt @ U @ rp) + k.Rs @ U @ rp_dot
    G_dot = u1 * (k.Rs @ U @ rs) + k.Rp @ U @ rs_dot
    along = u1**2 * k.Rs - w * (U @ arm_dot) - u2 * rp_dot
    C = np.array([*along, w * S_dot - u1 * E_dot - u2 * G_dot])
    return B, D, C


def rolling_row(k: Kinematics) -> tuple[np.ndarray, float]:
    """R_pᵀ v = 0 with v of (12), differentiated: coefficients of q̈₂, shape (2,), and the right-hand side."""
    rp = k.turn @ k.rp
    u1, u2 = k.q_dot
    S_dot = u1 * (k.Rs @ rp) + k.Rp @ (k.theta_dot * (U @ rp) + u2 * (k.turn @ k.rs))
    return np.array([k.Rp @ k.Rp, -(k.Rp @ rp)]), u2 * S_dot - 2 * u1**2 * (k.Rp @ k.Rs)


def augmented_system(case: Case, mode: Mode, state, side: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """The matrix and right-hand side of (27): 6×6 while sliding, 7×7 in roll.

    `state` is (ξ₁, ξ₂, ξ̇₁, ξ̇₂); `side` is the sign of the normal force (−1 only in a two-sided guide), on whose
    magnitude friction depends.
    """
    k = kinematics(case, *state)
    friction = case.effect(CoulombFriction)
    mu = SIGN.get(mode, 0.0) * side * (friction.mu if friction else 0.0)
    A = sliding_column(k, mu)
    B, D, C = constraints(k)
    if mode is Mode.ROLL:
        A = np.hstack([A, tangential_column(k)])
        row, value = rolling_row(k)
        B, D, C = np.vstack([B, np.zeros(3)]), np.vstack([D, row]), np.append(C, value)
    matrix = np.block([[mass_matrix(case), np.zeros((3, 2)), -A], [B, D, np.zeros((len(C), A.shape[1]))]])
    return matrix, np.concatenate([applied_torsor(case), C])


def solve_augmented(case: Case, mode: Mode, state, side: int = 1) -> Solution:
    """Accelerations, multipliers and contact forces from (27); raises numpy.linalg.LinAlgError where it is singular."""
    matrix, right = augmented_system(case, mode, state, side)
    answer = np.linalg.solve(matrix, right)
    multipliers = answer[5:]
    P = float(case.track.speed(state[0]))
    friction = case.effect(CoulombFriction)
    ratio = SIGN.get(mode, 0.0) * side * (friction.mu if friction else 0.0)
    tangential = multipliers[1] if mode is Mode.ROLL else ratio * multipliers[0]
    return Solution(answer[:3], answer[3:5], multipliers, float(multipliers[0] * P), float(tangential * P))
