"""The paper's augmented system (27) for a contact at a corner, literally.

On a corner of the track its point R is fixed, so (8) loses ξ̇₁ R_p; on a corner of the plate r is fixed, so it loses
ξ̇₂ θ r_p. The tangents need not be parallel, so (9) is left out, and the plate turns freely about the point:

    [ M  0  −A ] [ q̈₁ ]   [ F ]      B = (I₂, U θ r),   D = −R_p, or θ r_p,   q̈₂ = ξ̈₁, or ξ̈₂,
    [ B  D   0 ] [ q̈₂ ] = [ C ]      C = ξ̇₁² R_s + θ̇² θ r,   or   θ̇² θ r − 2 θ̇ ξ̇₂ U θ r_p − ξ̇₂² θ r_s.
                 [ λ  ]

The columns of A are those of (33), along the tangent of the curve without the corner: R_p, or θ r_p. So are the further
rows and columns of `augmented`: rolling, and a fixed rotation.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, sin
from typing import NamedTuple

import numpy as np

from cases import Mode
from cases.contact import belt_speed, pose
from cases.curves.corner import Corner, turning
from cases.scene.piece_case import PieceCase

from .augmented import (
    WITHOUT_SLIP,
    applied_torsor,
    friction_ratio,
    mass_matrix,
    own_torsor_at,
    resistance,
)
from .kinematics import I2, U, belt_of


class CornerSolution(NamedTuple):
    """The solution at a corner: q̈₁ shape (3,), the acceleration of the free parameter (that of the curve without the
    corner), the contact forces in N and the couple that resists the rotation in N m."""

    q1_ddot: np.ndarray
    free_ddot: float
    normal_force: float
    friction_force: float
    couple: float


class _CornerContact(NamedTuple):
    """The contact at one instant: the common tangent, not of unit length, the arm θ r, D and the parts of C that are
    not θ̇² θ r; the slip along the tangent, and its rate without the free parameter's acceleration, with that factor."""

    tangent: np.ndarray
    arm: np.ndarray
    D: np.ndarray
    C: np.ndarray
    slip: float
    slip_factor: float
    slip_rest: float


def solve_at_corner(
    case: PieceCase, mode: Mode, state: Sequence[float], side: int = 1, turn: int | None = None, time: float = 0.0
) -> CornerSolution:
    """Accelerations and contact forces where a corner touches a smooth piece.

    `state` is (ξ₁, ξ₂, ξ̇₁, ξ̇₂) in the pieces' parameters, of which a corner's is the angle of the tangent; the other
    arguments are those of `augmented.fill`. Raises numpy.linalg.LinAlgError where the matrix is singular.
    """
    xi1, xi2, u1, u2 = state[:4]
    spin = turning(case.pieces[0], xi1) * u1 - turning(case.pieces[1], xi2) * u2
    x, y, theta = (float(value) for value in pose(case, xi1, xi2))
    here = _place(case, xi1, xi2, u1, u2, theta, spin)
    length = float(np.hypot(*here.tangent))
    belt, belt_rate = belt_of(case, time)
    velocity = (here.slip * here.tangent / length) - spin * (U @ here.arm)  # (11)
    rolls = mode in WITHOUT_SLIP
    ratio = friction_ratio(case, mode, side, here.slip - belt_speed(case, time))
    arm, is_fixed = resistance(case, mode, side, turn, spin)
    size = 5 + rolls + is_fixed
    matrix, right = np.zeros((size, size)), np.zeros(size)
    angle = float(state[4]) if len(state) > 4 else theta + case.turn
    matrix[:3, :3] = mass_matrix(case)
    right[:3] = applied_torsor(case, (time, x, y, angle, *velocity, spin))
    right[:3] += own_torsor_at(case, here.tangent / length, here.arm, time, 0.0 if rolls else here.slip - belt, spin)
    leaning = (I2 - ratio * U) @ here.tangent  # (32), (33)
    matrix[:3, 4] = -np.array([*(U @ leaning), leaning @ here.arm + arm * length])
    matrix[3:5, :2], matrix[3:5, 2], matrix[3:5, 3] = I2, U @ here.arm, here.D
    right[3:5] = here.C + spin**2 * here.arm
    if rolls:
        matrix[:3, 5] = -np.array([*here.tangent, (U @ here.arm) @ here.tangent])
        matrix[5, 3], right[5] = here.slip_factor, belt_rate - here.slip_rest
    if is_fixed:
        matrix[2, -1], matrix[-1, 2] = -1.0, 1.0
    answer = np.linalg.solve(matrix, right)
    normal = float(answer[4]) * length
    friction = float(answer[5]) * length if rolls else ratio * normal
    couple = float(answer[-1]) if is_fixed else arm * normal
    return CornerSolution(answer[:3], float(answer[3]), normal, friction, couple)


def _place(case: PieceCase, xi1: float, xi2: float, u1: float, u2: float, theta: float, spin: float) -> _CornerContact:
    track, outline = case.pieces
    c, s = cos(theta), sin(theta)
    turn = np.array([[c, -s], [s, c]])  # (3)
    if isinstance(outline, Corner):
        _, Rp, Rs, _ = np.array(case.track.jet(xi1)).reshape(4, 2)
        P = float(np.hypot(*Rp))
        arm = turn @ np.array([outline.x, outline.y])
        return _CornerContact(Rp, arm, -Rp, u1**2 * Rs, u1 * P, P, u1**2 * float(Rp @ Rs) / P)
    assert isinstance(track, Corner)
    r, rp, rs, _ = np.array(case.plate.outline.jet(xi2)).reshape(4, 2)
    along, p = turn @ rp, float(np.hypot(*rp))
    C = -2.0 * spin * u2 * (U @ along) - u2**2 * (turn @ rs)
    return _CornerContact(along, turn @ r, along, C, -u2 * p, -p, -(u2**2) * float(rp @ rs) / p)
