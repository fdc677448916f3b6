"""Contact forces from (27) at many instants at once: the systems that `augmented` assembles one by one, in stacks.

A trajectory has thousands of samples between its steps, and their arithmetic takes a tenth of the time of separate
NumPy calls. Products of matrices stay products of matrices, so that rounding is the same as in `augmented`. Only for
a track at rest and without the user's own effects.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, cos, sin
from typing import NamedTuple

import numpy as np

from cases import Case, CoulombFriction, Drive, Load, Mode, RollingResistance
from cases.own_effects import own_effects

from .augmented import SIGN, THETA_ROW, applied_torsor, fill
from .kinematics import I2, U, belt_of


class Contacts(NamedTuple):
    """ξ₁ and ξ₂, slip velocity (m/s), θ̇ (rad/s), normal and friction force (N), the couple that resists the rotation
    (N m), and by how much the outline is bent more than the track (1/m), each of shape (n,); the matrices of (27), and
    their column of λ without friction and resistance, shapes (n, size, size) and (n, 3)."""

    xi1: np.ndarray
    xi2: np.ndarray
    slip: np.ndarray
    theta_dot: np.ndarray
    normal_force: np.ndarray
    friction_force: np.ndarray
    couple: np.ndarray
    fit: np.ndarray
    matrix: np.ndarray
    smooth_column: np.ndarray

    def uniqueness(self) -> np.ndarray:
        """`augmented.uniqueness` of each system, for a plate that can turn."""
        smooth = self.matrix.copy()
        smooth[:, :3, 5] = -self.smooth_column
        without = np.linalg.det(smooth)
        return np.divide(np.linalg.det(self.matrix), without, out=np.full(len(smooth), np.nan), where=without != 0.0)


def fits(case: Case, turn: int | None) -> bool:
    """Whether `contacts` covers all forces on the case's plate. With rolling resistance only for a known sense of the
    rotation: without, it would be each instant's own."""
    return (
        case.effect(Drive) is None
        and not own_effects(case.effects)
        and (turn is not None or case.effect(RollingResistance) is None)
    )


def contacts(
    case: Case,
    mode: Mode,
    states: Sequence[Sequence[float]],
    side: int = 1,
    turn: int | None = None,
    times: Sequence[float] | None = None,
) -> Contacts:
    """Slip, spin and contact forces by (27) in each state (ξ₁, ξ₂, ξ̇₁, ξ̇₂), followed by θ (rad) if a load counts whole
    turns; `side` and `turn` as in `fill`, `times` (s; None: zero) are for loads and belts.

    Raises numpy.linalg.LinAlgError if (27) is singular in one of them.
    """
    times = [0.0] * len(states) if times is None else times
    xi1, xi2, *speeds = zip(*states, strict=True)
    R, Rp, Rs, Rt = np.array([case.track.jet(s) for s in xi1]).reshape(-1, 4, 2).swapaxes(0, 1)  # (1)
    r, rp, rs, rt = np.array([case.plate.outline.jet(s) for s in xi2]).reshape(-1, 4, 2).swapaxes(0, 1)  # (2)
    theta = [atan2(*p) - atan2(*q) for p, q in zip(Rp[:, ::-1].tolist(), rp[:, ::-1].tolist(), strict=True)]  # (6)
    rotation = np.array([[[cos(a), -sin(a)], [sin(a), cos(a)]] for a in theta])  # (3)
    u1, u2 = (np.array(column) for column in speeds[:2])
    along, bent = _times(rotation, rp), _times(rotation, rs)
    w = (u1 * _dot(Rs @ U, along) + u2 * _dot(Rp @ U, bent)) / _dot(Rp, along)  # (9)
    belt, belt_rate = np.array([belt_of(case, time) for time in times]).T
    slip = _dot(Rp, u1[:, None] * Rp - u2[:, None] * along) / np.hypot(*Rp.T) - belt  # (12), (13)
    # M, the arm of the resistance, the rows of a fixed rotation and the zeros are the same in all of them.
    first = fill(case, mode, states[0], side, turn, times[0])
    matrix, right = (np.repeat(part[None], len(w), axis=0) for part in _with_rotation(first.matrix, first.right, case))
    _constrain(matrix, right, rotation, (Rp, Rs, Rt), (r, rp, rs, rt), (u1, u2, w))
    if case.effect(Load) is not None:
        arm = _times(rotation, r)
        angles = speeds[2] if len(speeds) > 2 else case.track.tangent_angle(xi1) - case.plate.outline.tangent_angle(xi2)
        velocity = u1[:, None] * Rp - w[:, None] * (arm @ U.T) - u2[:, None] * along  # (8)
        motion = np.column_stack([times, R - arm, angles, velocity, w])
        right[:, :3] = [applied_torsor(case, row) for row in motion.tolist()]
    ratio, size = _ratios(case, mode, side, slip, first.ratio), np.sqrt(_dot(Rp, Rp))
    matrix[:, :3, 5] = -_sliding_columns(_times(I2 - np.multiply.outer(ratio, U), Rp), rotation, r, first.arm * size)
    if first.rolls:
        matrix[:, :2, 6], matrix[:, 2, 6] = -Rp, -_dot(_times(U @ rotation, r), Rp)
        matrix[:, 6, 3], matrix[:, 6, 4] = _dot(Rp, Rp), -_dot(Rp, along)
        S_dot = u1 * _dot(Rs, along) + _dot(Rp, w[:, None] * (along @ U.T) + u2[:, None] * bent)
        bend = _dot(Rp, Rs)
        right[:, 6] = u2 * S_dot - 2 * u1**2 * bend + (size * belt_rate + belt * u1 * bend / size)
    multipliers = _multipliers(matrix, right, case)
    normal = multipliers[:, 0] * size
    friction = multipliers[:, 1] * size if first.rolls else ratio * normal
    couple = multipliers[:, -1] if first.rotation_fixed else first.arm * normal
    theta_dot = np.zeros(len(w)) if first.rotation_fixed else w
    smooth = _sliding_columns(Rp, rotation, r, 0.0)
    fit = _bend(rp, rs) - _bend(Rp, Rs)
    return Contacts(np.array(xi1), np.array(xi2), slip, theta_dot, normal, friction, couple, fit, matrix, smooth)


def _sliding_columns(
    Rp_tilde: np.ndarray, rotation: np.ndarray, r: np.ndarray, couple: np.ndarray | float
) -> np.ndarray:
    """Ã of (33) of each system, shape (n, 3); `couple`: that of a rolling resistance, per λ."""
    moment = _dot((Rp_tilde[:, None, :] @ rotation)[:, 0], r) + couple
    return np.column_stack([-Rp_tilde[:, 1], Rp_tilde[:, 0], moment])


def _bend(p: np.ndarray, s: np.ndarray) -> np.ndarray:
    """A curve's curvature from its first and second derivative, 1/m."""
    # By Python's power, as in the integrator's guards: NumPy's of arrays rounds differently.
    cubes = np.array([size**3 for size in np.hypot(p[:, 0], p[:, 1]).tolist()])
    return (p[:, 0] * s[:, 1] - p[:, 1] * s[:, 0]) / cubes


def _ratios(case: Case, mode: Mode, side: int, slip: np.ndarray, first: float) -> np.ndarray | float:
    """μ of (30) with its sign, as of `augmented.friction_ratio`; `first`: that of the first state."""
    friction = case.effect(CoulombFriction)
    if friction is None or mode not in SIGN or not friction.by_speed:
        return first
    return SIGN[mode] * side * np.asarray(friction.at(-SIGN[mode] * slip))


def _with_rotation(matrix: np.ndarray, right: np.ndarray, case: Case) -> tuple[np.ndarray, np.ndarray]:
    """(27) with a row and a column of θ̈, which it lacks for a plate of infinite inertia: zeros there."""
    if case.plate.turns:
        return matrix, right
    wide = np.insert(np.insert(matrix, THETA_ROW, 0.0, axis=0), THETA_ROW, 0.0, axis=1)
    return wide, np.insert(right, THETA_ROW, 0.0)


def _multipliers(matrix: np.ndarray, right: np.ndarray, case: Case) -> np.ndarray:
    """The multipliers of each system, without the row and the column of θ̈ for a plate of infinite inertia."""
    if not case.plate.turns:
        matrix = np.delete(np.delete(matrix, THETA_ROW, axis=1), THETA_ROW, axis=2)
        right = np.delete(right, THETA_ROW, axis=1)
    return np.linalg.solve(matrix, right[:, :, None])[:, 5 if case.plate.turns else 4 :, 0]


def _constrain(
    matrix: np.ndarray,
    right: np.ndarray,
    rotation: np.ndarray,
    track: tuple[np.ndarray, ...],
    outline: tuple[np.ndarray, ...],
    rates: tuple[np.ndarray, ...],
) -> None:
    """B, D and C of (23) and (25) in their places, as `augmented.constraints` has them."""
    (Rp, Rs, _), (u1, u2, w) = track, rates
    # By Python's power, as in `augmented`: NumPy's square rounds differently.
    u1_square, u2_square, w_square = (np.array([value**2 for value in rate.tolist()]) for rate in rates)
    outline_rows = rotation @ np.stack(outline, axis=1).swapaxes(1, 2)
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
