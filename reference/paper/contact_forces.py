"""Contact forces from (27) at many instants at once: the systems that `augmented` assembles one by one, in stacks.

A trajectory has thousands of samples between its steps, and their arithmetic takes a tenth of the time of separate
NumPy calls. Products of matrices stay products of matrices, so that rounding is the same as in `augmented`. Only for
contacts without load, belt and rolling resistance, whose matrices have one size and whose torsor is the same, and for a
constant coefficient of friction.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, cos, sin
from typing import NamedTuple

import numpy as np

from cases import Belt, Case, CoulombFriction, Load, Mode, RollingResistance
from cases.own_effects import own_effects

from .augmented import fill
from .kinematics import I2, U


class Contacts(NamedTuple):
    """Slip velocity (m/s), θ̇ (rad/s), normal and friction force (N), each of shape (n,)."""

    slip: np.ndarray
    theta_dot: np.ndarray
    normal_force: np.ndarray
    friction_force: np.ndarray


def fits(case: Case) -> bool:
    """Whether `contacts` covers all forces on the case's plate."""
    friction = case.effect(CoulombFriction)
    constant = (friction is None or not friction.by_speed) and not own_effects(case.effects)
    return constant and case.plate.turns and all(case.effect(kind) is None for kind in (Belt, Load, RollingResistance))


def contacts(case: Case, mode: Mode, states: Sequence[Sequence[float]], side: int = 1) -> Contacts:
    """Slip, spin and contact forces by (27) in each state (ξ₁, ξ₂, ξ̇₁, ξ̇₂); `side` as in `fill`.

    Raises numpy.linalg.LinAlgError if (27) is singular in one of them.
    """
    xi1, xi2, *speeds = zip(*states, strict=True)
    R, Rp, Rs, Rt = np.array([case.track.jet(s) for s in xi1]).reshape(-1, 4, 2).swapaxes(0, 1)  # (1)
    r, rp, rs, rt = np.array([case.plate.outline.jet(s) for s in xi2]).reshape(-1, 4, 2).swapaxes(0, 1)  # (2)
    theta = [atan2(*p) - atan2(*q) for p, q in zip(Rp[:, ::-1].tolist(), rp[:, ::-1].tolist(), strict=True)]  # (6)
    turn = np.array([[[cos(a), -sin(a)], [sin(a), cos(a)]] for a in theta])  # (3)
    u1, u2 = (np.array(column) for column in speeds)
    along, bent = _times(turn, rp), _times(turn, rs)
    w = (u1 * _dot(Rs @ U, along) + u2 * _dot(Rp @ U, bent)) / _dot(Rp, along)  # (9)
    slip = _dot(Rp, u1[:, None] * Rp - u2[:, None] * along) / np.hypot(*Rp.T)  # (12), (13)
    # M, F, the ratio of the forces and the zeros are the same in all of them.
    first = fill(case, mode, states[0], side)
    ratio, rolls = first.ratio, first.rolls
    matrix, right = np.repeat(first.matrix[None], len(w), axis=0), np.repeat(first.right[None], len(w), axis=0)
    _constrain(matrix, right, turn, (Rp, Rs, Rt), (r, rp, rs, rt), (u1, u2, w))
    Rp_tilde = _times(I2 - ratio * U, Rp)  # (32), (33)
    matrix[:, :2, 5] = -(Rp_tilde @ U.T)
    matrix[:, 2, 5] = -_dot((Rp_tilde[:, None, :] @ turn)[:, 0], r)
    if rolls:
        matrix[:, :2, 6], matrix[:, 2, 6] = -Rp, -_dot(_times(U @ turn, r), Rp)
        matrix[:, 6, 3], matrix[:, 6, 4] = _dot(Rp, Rp), -_dot(Rp, along)
        S_dot = u1 * _dot(Rs, along) + _dot(Rp, w[:, None] * (along @ U.T) + u2[:, None] * bent)
        right[:, 6] = u2 * S_dot - 2 * u1**2 * _dot(Rp, Rs)
    multipliers = np.linalg.solve(matrix, right[:, :, None])[:, 5:, 0]
    size = np.sqrt(_dot(Rp, Rp))
    normal = multipliers[:, 0] * size
    return Contacts(slip, w, normal, multipliers[:, 1] * size if rolls else ratio * normal)


def _constrain(
    matrix: np.ndarray,
    right: np.ndarray,
    turn: np.ndarray,
    track: tuple[np.ndarray, ...],
    outline: tuple[np.ndarray, ...],
    rates: tuple[np.ndarray, ...],
) -> None:
    """B, D and C of (23) and (25) in their places, as `augmented.constraints` has them."""
    (Rp, Rs, _), (u1, u2, w) = track, rates
    # By Python's power, as in `augmented`: NumPy's square rounds differently.
    u1_square, u2_square, w_square = (np.array([value**2 for value in rate.tolist()]) for rate in rates)
    outline_rows = turn @ np.stack(outline, axis=1).swapaxes(1, 2)
    rows = np.stack(track, axis=1)
    (_, S, p_s, _), (_, s_p, *_), _ = np.moveaxis(rows @ outline_rows, 0, -1)
    (_, p_Up, G, p_Ut), (_, E, s_Us, _), (_, t_Up, *_) = np.moveaxis(rows @ U @ outline_rows, 0, -1)
    (arm_x, rp_x, rs_x, _), (arm_y, rp_y, rs_y, _) = np.moveaxis(outline_rows, 0, -1)
    matrix[:, 3, 2], matrix[:, 4, 2], matrix[:, 5, 2] = -arm_y, arm_x, -S
    matrix[:, 3:5, 3], matrix[:, 3, 4], matrix[:, 4, 4] = -Rp, rp_x, rp_y
    matrix[:, 5, 3], matrix[:, 5, 4] = E, G
    S_dot = u1 * s_p + w * p_Up + u2 * p_s
    E_dot = u1 * t_Up - w * s_p + u2 * s_Us
    G_dot = u1 * s_Us - w * p_s + u2 * p_Ut
    right[:, 3] = u1_square * Rs[:, 0] + w_square * arm_x + 2.0 * w * u2 * rp_y - u2_square * rs_x
    right[:, 4] = u1_square * Rs[:, 1] + w_square * arm_y - 2.0 * w * u2 * rp_x - u2_square * rs_y
    right[:, 5] = w * S_dot - u1 * E_dot - u2 * G_dot


def _times(matrices: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Each matrix times its vector."""
    return (matrices @ vectors[:, :, None])[:, :, 0]


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1]
