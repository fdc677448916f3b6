"""The paper's augmented system, (15)–(34): accelerations and multipliers from one matrix, assembled from blocks.

    [ M  0  −A ] [ q̈₁ ]   [ F ]
    [ B  D   0 ] [ q̈₂ ] = [ C ]                                                                                  (27)
                 [ λ  ]

with q₁ = (X₀, Y₀, θ) and q₂ = (ξ₁, ξ₂). A contact that slips has one multiplier (6×6). The paper ends there; this suite
adds columns and rows of the same kind:

    rolling                  the tangential multiplier, and R_pᵀ v = 0 differentiated (7×7)
    a fixed rotation         a couple as multiplier, and θ̈ = α̈ of the track (7×7 with slip, 8×8 at rest)
    an infinite inertia      without θ̈ and its row: 5×5 with slip, 6×6 at rest; the row then gives the couple
    rolling resistance       a couple arm·|N| against the rotation: proportional to λ, so it is in λ's column
    free flight              no multiplier: (16) and (19) alone (3×3)

Literal and slow: the fast form is tested against it, and `reference.augmented_integrator` integrates it.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import nan, sqrt
from typing import NamedTuple

import numpy as np

from cases import Case, CoulombFriction, Gravity, Load, Mode, RollingResistance
from cases.own_effects import own_effects

from .kinematics import Kinematics, U, belt_of, kinematics, slip_velocity

# (30): the friction coefficient's sign is opposite to the slip velocity's.
SIGN = {Mode.SLIP_FORWARD: -1.0, Mode.SLIP_BACKWARD: +1.0}
WITHOUT_SLIP = (Mode.ROLL, Mode.REST)
# The row of M q̈₁ = F + A λ, and the column of q̈₁, that belong to θ.
THETA_ROW = 2


class Solution(NamedTuple):
    """The solution of (27): q̈₁ shape (3,), q̈₂ shape (2,), multipliers λ (one to three, as the columns of A), the
    contact forces in N and the couple that resists the rotation in N m."""

    q1_ddot: np.ndarray
    q2_ddot: np.ndarray
    multipliers: np.ndarray
    normal_force: float
    friction_force: float
    couple: float


class AugmentedSystem(NamedTuple):
    """(27) at one instant: its matrix and right-hand side, and the values from which they were assembled.

    `ratio` is the μ of (30) with its sign, `arm` the resisting couple per normal force with its sign (m), `rolls` and
    `rotation_fixed` are true if the rows of rolling and of a fixed rotation are present. `moments`: of a plate of
    infinite inertia, the row of (27) for θ̈, without its inertia, and its right-hand side; that row and the column of θ̈
    are not in the matrix.
    """

    matrix: np.ndarray
    right: np.ndarray
    k: Kinematics
    ratio: float
    arm: float
    rolls: bool
    rotation_fixed: bool
    moments: tuple[np.ndarray, float] | None = None


# --- M and F ----------------------------------------------------------------------------------------------------------


def mass_matrix(case: Case) -> np.ndarray:
    """M of (16)."""
    return np.array(_mass_rows(case))


def _mass_rows(case: Case) -> list[list[float]]:
    mass = case.plate.mass
    return [[mass, 0.0, 0.0], [0.0, mass, 0.0], [0.0, 0.0, case.plate.inertia]]


def applied_torsor(case: Case, motion: Sequence[float]) -> np.ndarray:
    """F of (19): the external torsor (F_x, F_y, M₀) in the fixed frame, weight and loads together.

    `motion` are the arguments of a load: (t, X₀, Y₀, θ, Ẋ₀, Ẏ₀, θ̇).
    """
    gravity, load = case.effect(Gravity), case.effect(Load)
    weight = (case.plate.mass * g for g in gravity.vector) if gravity is not None else (0.0, 0.0)
    F = np.array([*weight, 0.0])
    return F if load is None else F + load.at(*(float(value) for value in motion))


def own_torsor(case: Case, k: Kinematics, time: float, slip: float) -> np.ndarray:
    """The forces of the user's own effects, which act at the contact, as a torsor at the centre of mass."""
    return own_torsor_at(case, k.Rp / sqrt(k.Rp @ k.Rp), k.turn @ k.r, time, slip, float(k.turning))


def own_torsor_at(
    case: Case, tangent: np.ndarray, arm: np.ndarray, time: float, slip: float, spin: float
) -> np.ndarray:
    """The same at a contact with that unit tangent and arm from the centre of mass."""
    F = np.zeros(3)
    for effect in own_effects(case.effects):
        along, across, couple = effect.at(time, slip, spin)[:3]
        force = along * tangent + across * (U @ tangent)
        F += np.array([*force, (U @ arm) @ force + couple])
    return F


# --- A ----------------------------------------------------------------------------------------------------------------


def sliding_column(k: Kinematics, mu: float, arm: float = 0.0) -> np.ndarray:
    """Ã of (33), shape (3, 1), with the corrected Ũ = I₂ − μU of (32); mu carries the sign of (30).

    `arm` is the couple per normal force of a rolling resistance; N = λ |R_p|.
    """
    return np.array(_sliding_numbers(k, mu, arm)).reshape(3, 1)


def _sliding_numbers(k: Kinematics, mu: float, arm: float) -> list[float]:
    Rp_tilde = np.array([[1.0, mu], [-mu, 1.0]]) @ k.Rp
    (x, y), (a, b), (r_x, r_y) = Rp_tilde.tolist(), (Rp_tilde @ k.turn).tolist(), k.r.tolist()
    return [-y, x, a * r_x + b * r_y + (arm * sqrt(k.Rp @ k.Rp) if arm else 0.0)]


def tangential_column(k: Kinematics) -> np.ndarray:
    """The column of the rolling plate's tangential multiplier, shape (3, 1): a force along R_p and its moment."""
    return np.array(_tangential_numbers(k)).reshape(3, 1)


def _tangential_numbers(k: Kinematics) -> list[float]:
    (Rp_x, Rp_y), (a, b) = k.Rp.tolist(), (U @ k.turn @ k.r).tolist()
    return [Rp_x, Rp_y, a * Rp_x + b * Rp_y]


# --- B, D and C -------------------------------------------------------------------------------------------------------


def constraints(k: Kinematics) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """B (3×3), D (3×2) of (23) from (8) and (9), and C (3,) of (25), where the third derivatives enter."""
    B, D, C = _constraint_rows(k)
    return np.array(B), np.array(D), np.array(C)


def _constraint_rows(k: Kinematics) -> tuple[list[list[float]], list[list[float]], list[float]]:
    # Products of the derivatives p, s, t of the track (rows) with the outline's, rotated by θ (columns), all at once:
    # directly and with U between them (U² = −I₂). This is computed at every evaluation, so it has to be fast.
    outline = k.turn @ np.concatenate((k.r, k.rp, k.rs, k.rt)).reshape(4, 2).T
    track = np.concatenate((k.Rp, k.Rs, k.Rt)).reshape(3, 2)
    (_, S, p_s, _), (_, s_p, *_), _ = (track @ outline).tolist()
    (_, p_Up, G, p_Ut), (_, E, s_Us, _), (_, t_Up, *_) = (track @ U @ outline).tolist()
    (arm_x, rp_x, rs_x, _), (arm_y, rp_y, rs_y, _) = outline.tolist()
    (Rp_x, Rp_y), (Rs_x, Rs_y), _ = track.tolist()
    (u1, u2), w, turning = k.q_dot.tolist(), float(k.theta_dot), float(k.turning)
    B = [[1.0, 0.0, -arm_y], [0.0, 1.0, arm_x], [0.0, 0.0, -S]]
    D = [[-Rp_x, rp_x], [-Rp_y, rp_y], [E, G]]
    # (25), the derivative of each coefficient by the product rule and (7).
    S_dot = u1 * s_p + turning * p_Up + u2 * p_s
    E_dot = u1 * t_Up - turning * s_p + u2 * s_Us
    G_dot = u1 * s_Us - turning * p_s + u2 * p_Ut
    along_x = u1**2 * Rs_x + w**2 * arm_x + 2.0 * w * u2 * rp_y - u2**2 * rs_x
    along_y = u1**2 * Rs_y + w**2 * arm_y - 2.0 * w * u2 * rp_x - u2**2 * rs_y
    C = [along_x, along_y, turning * S_dot - u1 * E_dot - u2 * G_dot]
    if k.track is not None:
        # With R(ξ₁, t): d/dt of ξ̇₁ R_p + W has ∂²R/∂t² and twice ξ̇₁ ∂R_p/∂t = ξ̇₁ α̇ U R_p; (9) has θ̇ − α̇.
        further = (k.W_dot + 2.0 * u1 * k.track.spin * (U @ k.Rp)).tolist()
        C = [along_x + further[0], along_y + further[1], C[2] - S * k.track.swing]
    return B, D, C


def rolling_row(k: Kinematics, belt: tuple[float, float] = (0.0, 0.0)) -> tuple[np.ndarray, float]:
    """R_pᵀ v = |R_p| b with v of (12), differentiated: coefficients of q̈₂, shape (2,), and the right-hand side.

    `belt` is the speed b of the track's surface (m/s) and its rate; (27) changes only on this row's right-hand side, by
    d(|R_p| b)/dt = |R_p| ḃ + b ξ̇₁ R_pᵀ R_s/|R_p|.
    """
    coefficients, right = _rolling_numbers(k, belt)
    return np.array(coefficients), right


def _rolling_numbers(k: Kinematics, belt: tuple[float, float]) -> tuple[list[float], float]:
    (Rp_x, Rp_y), (Rs_x, Rs_y), (u1, u2) = k.Rp.tolist(), k.Rs.tolist(), k.q_dot.tolist()
    (rp_x, rp_y), (rs_x, rs_y) = (k.turn @ k.rp).tolist(), (k.turn @ k.rs).tolist()
    turning = float(k.turning)
    rate_x, rate_y = u2 * rs_x - turning * rp_y, turning * rp_x + u2 * rs_y  # of θ r_p
    S_dot = u1 * (Rs_x * rp_x + Rs_y * rp_y) + (Rp_x * rate_x + Rp_y * rate_y)
    bend = Rp_x * Rs_x + Rp_y * Rs_y
    right = u2 * S_dot - 2 * u1**2 * bend
    if belt != (0.0, 0.0):
        P = float(np.hypot(Rp_x, Rp_y))
        right += P * belt[1] + belt[0] * u1 * bend / P
    return [Rp_x * Rp_x + Rp_y * Rp_y, -(Rp_x * rp_x + Rp_y * rp_y)], right


# --- (27) -------------------------------------------------------------------------------------------------------------


def fill(
    case: Case, mode: Mode, state: Sequence[float], side: int = 1, turn: int | None = None, time: float = 0.0
) -> AugmentedSystem:
    """Assemble (27) for a contact in a mode.

    `state` is (ξ₁, ξ₂, ξ̇₁, ξ̇₂), followed by θ (rad) if a load counts whole turns; `side` is the sign of the normal
    force (−1 only in a bilateral guide), on whose magnitude friction and rolling resistance depend; `turn` is the sense
    of a rotation with resistance, 0 if it is fixed (None: the sign of θ̇); `time` (s) is for loads.
    """
    xi1, xi2, xi1_dot, xi2_dot = state[:4]
    k = kinematics(case, xi1, xi2, xi1_dot, xi2_dot, time)
    return assemble(
        case, mode, k, (time, *k.R0.tolist(), _angle(case, state, k), *k.R0_dot.tolist(), k.theta_dot), side, turn
    )


def assemble(
    case: Case, mode: Mode, k: Kinematics, motion: Sequence[float], side: int = 1, turn: int | None = None
) -> AugmentedSystem:
    """Assemble (27) from given kinematics, whether or not they fit the contact; `motion` as in `applied_torsor`."""
    belt, friction, own = belt_of(case, motion[0]), case.effect(CoulombFriction), own_effects(case.effects)
    slip = slip_velocity(k, belt[0]) if own or (friction is not None and friction.by_speed) else 0.0
    ratio = friction_ratio(case, mode, side, slip)
    arm, rotation_fixed = resistance(case, mode, side, turn, float(k.turning))
    rolls = mode in WITHOUT_SLIP
    torsor = applied_torsor(case, motion)
    if own:
        torsor += own_torsor(case, k, motion[0], 0.0 if rolls else slip)
    # In lists of numbers: NumPy's assignments to parts of a matrix take as long as its solution.
    B, D, C = _constraint_rows(k)
    M, right = _mass_rows(case), [*torsor.tolist(), *C]
    M[THETA_ROW][THETA_ROW] = M[THETA_ROW][THETA_ROW] if case.plate.turns else 0.0
    rows = [[*row, 0.0, 0.0, -value] for row, value in zip(M, _sliding_numbers(k, ratio, arm), strict=True)]
    rows += [[*of_q1, *of_q2, 0.0] for of_q1, of_q2 in zip(B, D, strict=True)]
    if rolls:
        column = [*(-value for value in _tangential_numbers(k)), 0.0, 0.0, 0.0]
        coefficients, rate = _rolling_numbers(k, belt)
        rows = [[*row, value] for row, value in zip(rows, column, strict=True)]
        rows.append([0.0, 0.0, 0.0, *coefficients, 0.0, 0.0])
        right.append(rate)
    if rotation_fixed:
        rows = [[*row, -1.0 if number == THETA_ROW else 0.0] for number, row in enumerate(rows)]
        rows.append([1.0 if number == THETA_ROW else 0.0 for number in range(len(rows) + 1)])
        right.append(k.track.swing if k.track is not None else 0.0)
    matrix, right_side = np.array(rows), np.array(right)
    if case.plate.turns:
        return AugmentedSystem(matrix, right_side, k, ratio, arm, rolls, rotation_fixed)
    moments = np.delete(matrix[THETA_ROW], THETA_ROW), float(right_side[THETA_ROW])
    matrix = np.delete(np.delete(matrix, THETA_ROW, axis=0), THETA_ROW, axis=1)
    return AugmentedSystem(matrix, np.delete(right_side, THETA_ROW), k, ratio, arm, rolls, True, moments)


def friction_ratio(case: Case, mode: Mode, side: int, slip: float) -> float:
    """μ of (30): against the slip, by the magnitude of the normal force; 0 without slip or friction.

    A coefficient that depends on the slip speed is μ(|v|) with v of (12), relative to a belt; it is smooth where an
    integrator's stage passes v = 0.
    """
    friction = case.effect(CoulombFriction)
    if friction is None or mode not in SIGN:
        return 0.0
    mu = friction.at(-SIGN[mode] * slip) if friction.by_speed else friction.mu
    return SIGN[mode] * side * mu


def resistance(case: Case, mode: Mode, side: int, turn: int | None, spin: float) -> tuple[float, bool]:
    """The resisting couple per normal force (m) at a spin (rad/s), and whether the rotation is fixed."""
    effect = case.effect(RollingResistance)
    if effect is None:
        return 0.0, False
    turn = int(np.sign(spin)) if turn is None else turn
    if turn == 0 or mode is Mode.REST:
        return 0.0, True
    return -turn * side * effect.arm, False


def _angle(case: Case, state: Sequence[float], k: Kinematics) -> float:
    """θ including whole turns, if a load may depend on them."""
    if len(state) > 4 or case.effect(Load) is None:
        return float(state[4]) if len(state) > 4 else k.theta
    angle = float(case.track.tangent_angle(state[0]) - case.plate.outline.tangent_angle(state[1]))
    return angle + (k.track.angle if k.track else 0.0)


def augmented_system(
    case: Case, mode: Mode, state: Sequence[float], side: int = 1, turn: int | None = None, time: float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """The matrix and right-hand side of (27); arguments as in `fill`."""
    system = fill(case, mode, state, side, turn, time)
    return system.matrix, system.right


def solve_full_system(
    case: Case, mode: Mode, state: Sequence[float], side: int = 1, turn: int | None = None, time: float = 0.0
) -> Solution:
    """Accelerations, multipliers and contact forces from (27); raises numpy.linalg.LinAlgError where it is singular."""
    return solution(fill(case, mode, state, side, turn, time))


def parameter_accelerations(system: AugmentedSystem) -> list[float]:
    """q̈₂ alone; raises numpy.linalg.LinAlgError if the system is singular."""
    first = 3 if system.moments is None else 2  # without θ̈ it follows the first two
    return np.linalg.solve(system.matrix, system.right)[first : first + 2].tolist()


def solution(system: AugmentedSystem) -> Solution:
    """Solve an assembled system; raises numpy.linalg.LinAlgError if it is singular."""
    answer = np.linalg.solve(system.matrix, system.right)
    if system.moments is not None:
        row, moment = system.moments
        return _translating(system, np.insert(answer, THETA_ROW, 0.0), float(row @ answer) - moment)
    multipliers = answer[5:]
    P = sqrt(system.k.Rp @ system.k.Rp)
    normal = float(multipliers[0] * P)
    friction = float(multipliers[1] * P) if system.rolls else system.ratio * normal
    couple = float(multipliers[-1]) if system.rotation_fixed else system.arm * normal
    return Solution(answer[:3], answer[3:5], multipliers, normal, friction, couple)


def _translating(system: AugmentedSystem, answer: np.ndarray, couple: float) -> Solution:
    """The solution for a plate of infinite inertia, whose row for θ̈ gives the couple that keeps θ fixed."""
    P = sqrt(system.k.Rp @ system.k.Rp)
    normal = float(answer[5] * P)
    friction = float(answer[6] * P) if system.rolls else system.ratio * normal
    return Solution(answer[:3], answer[3:5], answer[5:], normal, friction, couple)


def flight_acceleration(case: Case, time: float, y: Sequence[float]) -> np.ndarray:
    """q̈₁ of a plate in free flight, (16) and (19) without F_L, shape (3,); y is (X₀, Y₀, θ, Ẋ₀, Ẏ₀, θ̇)."""
    if not case.plate.turns:
        return np.append(applied_torsor(case, (time, *y))[:2] / case.plate.mass, 0.0)
    return np.linalg.solve(mass_matrix(case), applied_torsor(case, (time, *y)))


# --- distance from singularity ----------------------------------------------------------------------------------------


def uniqueness(system: AugmentedSystem) -> float:
    """The determinant of (27) over its value without friction and resistance: 1 there, 0 at Painlevé's paradox.

    Where it vanishes, the normal force is no longer a unique answer of (27). NaN where the curvatures are equal, which
    makes (27) singular in any case.
    """
    smooth = system.matrix.copy()
    smooth[:3, 5:6] = -sliding_column(system.k, 0.0)
    without = float(np.linalg.det(smooth))
    return float(np.linalg.det(system.matrix)) / without if without else nan


def condition(case: Case, system: AugmentedSystem) -> float:
    """The 2-norm condition number of (27) in the plate's own units, in which mass, radius of gyration and arc length
    are one; infinite where the matrix is singular."""
    m, rho = case.plate.mass, case.plate.gyration
    P, p = float(np.hypot(*system.k.Rp)), float(np.hypot(*system.k.rp))
    # Units of the unknowns Ẍ₀, Ÿ₀, θ̈, ξ̈₁, ξ̈₂, the multipliers N/P and T/P, a couple; then of the rows: two forces, a
    # moment, (8) twice, (9), R_pᵀ v, θ̈.
    force, couple = m * rho / P, m * rho**2
    if system.moments is not None:
        unknowns = [rho, rho, rho / P, rho / p, force, *[force] * system.rolls]
        rows = [m * rho, m * rho, rho, rho, P * p, *[P * rho] * system.rolls]
        return float(np.linalg.cond(system.matrix * np.array(unknowns) / np.array(rows)[:, None]))
    unknowns = [rho, rho, 1.0, rho / P, rho / p, force, *[force] * system.rolls, *[couple] * system.rotation_fixed]
    rows = [m * rho, m * rho, m * rho**2, rho, rho, P * p, *[P * rho] * system.rolls, *[1.0] * system.rotation_fixed]
    return float(np.linalg.cond(system.matrix * np.array(unknowns) / np.array(rows)[:, None]))
