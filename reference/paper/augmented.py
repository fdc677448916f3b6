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
    a corner of one curve    without the parameter of that curve, and without (9): 5×5 with slip, 6×6 at rest
    several bodies           M and F have a block for each, and B, D, C and A one for each contact
    free flight              no multiplier: (16) and (19) alone (3×3)

A contact of two bodies is that of a plate on a driven track: the track is the boundary of the other body, its base,
whose accelerations, which a drive adds to C, are unknowns; the base has the opposite forces.

All of it is written for one instant in numbers, and for n instants in arrays (n,). Literal and slow: the fast form is
tested against it, and `reference.augmented_integrator` integrates it.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import nan
from typing import Any, NamedTuple

import numpy as np

from cases import Case, CoulombFriction, Gravity, Load, Mode, RollingResistance
from cases.own_effects import own_effects
from cases.scene.piece_case import PieceCase

from .kinematics import Kinematics, U, at_each, belt_of, components, cross, dot, kinematics, length, slip_velocity

# (30): the friction coefficient's sign is opposite to the slip velocity's.
SIGN = {Mode.SLIP_FORWARD: -1.0, Mode.SLIP_BACKWARD: +1.0}
WITHOUT_SLIP = (Mode.ROLL, Mode.REST)
# The row of M q̈₁ = F + A λ, and the column of q̈₁, that belong to θ.
THETA_ROW = 2


class Solution(NamedTuple):
    """The solution of (27): q̈₁ shape (3,), q̈₂ shape (2,), at a corner (1,), the contact forces in N and the couple
    that resists the rotation in N m; at n instants with a last axis (n,)."""

    q1_ddot: np.ndarray
    q2_ddot: np.ndarray
    normal_force: float
    friction_force: float
    couple: float


class ClosedContact(NamedTuple):
    """A closed contact in a mode: a case with its curves and effects, its kinematics, the sign `side` of the normal
    force and the sense `turn` of a rotation with resistance (None: the sign of θ̇), its body and its base, if it has
    one, by number."""

    case: Case
    mode: Mode
    k: Kinematics
    side: int = 1
    turn: int | None = None
    body: int = 0
    base: int | None = None


class ContactBlock(NamedTuple):
    """A contact's place in (27): its first row, the columns of q̈₂ and of its first multiplier. `belt` is the speed of
    the surface and its rate, `ratio` the μ of (30) with its sign, `arm` the resisting couple per normal force with its
    sign (m); `rolls` and `rotation_fixed` are true if the rows of rolling and of a fixed rotation are present."""

    contact: ClosedContact
    row: int
    parameters: slice
    column: int
    belt: tuple[float, float]
    ratio: float
    arm: float
    rolls: bool
    rotation_fixed: bool


class AugmentedSystem(NamedTuple):
    """(27) at one instant, or at n: matrix (size, size) and right-hand side (size,), or (n, size, size) and (n, size).

    `moments`: of bodies of infinite inertia, the row of (27) for θ̈, without its inertia, and its right-hand side, by
    the number of that row; these rows and the columns of their θ̈ are not in the matrix.
    """

    matrix: np.ndarray
    right: np.ndarray
    contacts: tuple[ContactBlock, ...]
    moments: dict[int, tuple[np.ndarray, Any]]

    @property
    def k(self) -> Kinematics:
        """The kinematics of the first contact."""
        return self.contacts[0].contact.k

    @property
    def rolls(self) -> bool:
        """Whether the first contact does not slip."""
        return self.contacts[0].rolls

    @property
    def rotation_fixed(self) -> bool:
        """Whether the first contact's body does not turn."""
        return self.contacts[0].rotation_fixed


# --- M and F ----------------------------------------------------------------------------------------------------------


def mass_matrix(case: Case) -> np.ndarray:
    """M of (16)."""
    return np.diag([case.plate.mass, case.plate.mass, case.plate.inertia])


def applied_torsor(case: Case, motion: Sequence[float]) -> np.ndarray:
    """F of (19): the external torsor (F_x, F_y, M₀) in the fixed frame, weight and loads together.

    `motion` are the arguments of a load: (t, X₀, Y₀, θ, Ẋ₀, Ẏ₀, θ̇).
    """
    gravity, load = case.effect(Gravity), case.effect(Load)
    weight = (case.plate.mass * g for g in gravity.vector) if gravity is not None else (0.0, 0.0)
    F = np.array([*weight, 0.0])
    return F if load is None else (F + np.array(at_each(load.at, *motion)).T).T


def own_torsor(case: Case, k: Kinematics, time: float, slip: float) -> list[Any]:
    """The forces of the user's own effects, which act at the contact, as a torsor at the centre of mass."""
    (x, y), arm, size = k.tangent, k.outline_vectors[0], length(k.tangent)
    total: list[Any] = [0.0, 0.0, 0.0]
    for effect in own_effects(case.effects):
        along, across, couple = at_each(effect.at, time, slip, k.turning)[:3]
        force = (along * x - across * y) / size, (along * y + across * x) / size
        total = [a + b for a, b in zip(total, (*force, cross(arm, force) + couple), strict=True)]
    return total


# --- A ----------------------------------------------------------------------------------------------------------------


def sliding_column(k: Kinematics, mu: Any, arm: float = 0.0) -> list[Any]:
    """Ã of (33), three entries, with the corrected Ũ = I₂ − μU of (32); mu carries the sign of (30).

    `arm` is the couple per normal force of a rolling resistance; N = λ |R_p|.
    """
    Rp_x, Rp_y = k.tangent
    x, y = Rp_x + mu * Rp_y, Rp_y - mu * Rp_x
    return [-y, x, dot((x, y), k.outline_vectors[0]) + (arm * length(k.tangent) if arm else 0.0)]


def tangential_column(k: Kinematics) -> list[Any]:
    """The column of the rolling plate's tangential multiplier, three entries: a force along R_p and its moment."""
    return [*k.tangent, cross(k.outline_vectors[0], k.tangent)]


# --- B, D and C -------------------------------------------------------------------------------------------------------


def constraints(k: Kinematics) -> tuple[list[list[Any]], list[list[Any]], list[Any]]:
    """B (3×3), D (3×2) of (23) from (8) and (9), and C (3,) of (25), where the third derivatives enter."""
    # Products of the derivatives p, s, t of the track with the outline's, rotated by θ: directly and with U between
    # them (U² = −I₂).
    (Rp, Rs, Rt), (arm, rp, rs, rt) = k.derivatives, k.outline_vectors
    (u1, u2), w, turning = components(k.q_dot), k.theta_dot, k.turning
    S, E, G = dot(Rp, rp), cross(rp, Rs), cross(rs, Rp)
    B = [[1.0, 0.0, -arm[1]], [0.0, 1.0, arm[0]], [0.0, 0.0, -S]]
    D = [[-Rp[0], rp[0]], [-Rp[1], rp[1]], [E, G]]
    # (25), the derivative of each coefficient by the product rule and (7).
    S_dot = u1 * dot(Rs, rp) + turning * cross(rp, Rp) + u2 * dot(Rp, rs)
    E_dot = u1 * cross(rp, Rt) - turning * dot(Rs, rp) + u2 * cross(rs, Rs)
    G_dot = u1 * cross(rs, Rs) - turning * dot(Rp, rs) + u2 * cross(rt, Rp)
    along_x = u1**2 * Rs[0] + w**2 * arm[0] + 2.0 * w * u2 * rp[1] - u2**2 * rs[0]
    along_y = u1**2 * Rs[1] + w**2 * arm[1] - 2.0 * w * u2 * rp[0] - u2**2 * rs[1]
    C = [along_x, along_y, turning * S_dot - u1 * E_dot - u2 * G_dot]
    if k.track is not None:
        # With R(ξ₁, t): d/dt of ξ̇₁ R_p + W has ∂²R/∂t² and twice ξ̇₁ ∂R_p/∂t = ξ̇₁ α̇ U R_p; (9) has θ̇ − α̇.
        x, y = components(k.W_dot + 2.0 * u1 * k.track.spin * (U @ k.Rp))
        C = [along_x + x, along_y + y, C[2] - S * k.track.swing]
    return B, D, C


def rolling_row(k: Kinematics, belt: tuple[Any, Any]) -> tuple[list[Any], Any]:
    """R_pᵀ v = |R_p| b with v of (12), differentiated: two coefficients of q̈₂, and the right-hand side.

    `belt` is the speed b of the track's surface (m/s) and its rate; (27) changes only on this row's right-hand side, by
    d(|R_p| b)/dt = |R_p| ḃ + b ξ̇₁ R_pᵀ R_s/|R_p|.
    """
    (u1, u2), turning, tangent = components(k.q_dot), k.turning, k.tangent
    (Rp, Rs, _), (_, rp, rs, _) = k.derivatives, k.outline_vectors
    rate = u2 * rs[0] - turning * rp[1], u2 * rs[1] + turning * rp[0]  # of θ r_p
    turns = (u1 * Rs[0], u1 * Rs[1]) if 0 in k.free else rate  # of the tangent
    right = u2 * (dot(turns, rp) + dot(tangent, rate)) - u1 * (dot(turns, Rp) + u1 * dot(tangent, Rs))
    size = length(tangent)
    right = right + size * belt[1] + belt[0] * dot(tangent, turns) / size
    return [dot(tangent, Rp), -dot(tangent, rp)], right


# --- (27) -------------------------------------------------------------------------------------------------------------


def fill(
    case: Case, mode: Mode, state: Sequence[float], side: int = 1, turn: int | None = None, time: float = 0.0
) -> AugmentedSystem:
    """Assemble (27) for a contact in a mode.

    `state` is (ξ₁, ξ₂, ξ̇₁, ξ̇₂), followed by θ (rad) if a load counts whole turns; `side` is the sign of the normal
    force (−1 only in a bilateral guide), on whose magnitude friction and rolling resistance depend; `turn` is the sense
    of a rotation with resistance, 0 if it is fixed (None: the sign of θ̇); `time` (s) is for loads. States and times may
    be arrays (n,), with a known `turn` of a rotation with resistance.
    """
    xi1, xi2, xi1_dot, xi2_dot = state[:4]
    k = kinematics(case, xi1, xi2, xi1_dot, xi2_dot, time)
    motion = (time, *components(k.R0), _angle(case, state, k), *components(k.R0_dot), k.theta_dot)
    return assemble(case, mode, k, motion, side, turn)


def assemble(
    case: Case, mode: Mode, k: Kinematics, motion: Sequence[float], side: int = 1, turn: int | None = None
) -> AugmentedSystem:
    """Assemble (27) from given kinematics, whether or not they fit the contact; `motion` as in `applied_torsor`."""
    return assemble_bodies([case], [ClosedContact(case, mode, k, side, turn)], [motion])


def assemble_bodies(
    bodies: Sequence[Case], contacts: Sequence[ClosedContact], motions: Sequence[Sequence[float]]
) -> AugmentedSystem:
    """Assemble (27) of several bodies: for each a case with it as plate, and with its loads, and its motion as in
    `applied_torsor`."""
    blocks, held = _layout(bodies, contacts, motions)
    size = 3 * len(bodies) + sum(1 + len(block.contact.k.free) + block.rolls for block in blocks) + len(held)
    # Lists of numbers: NumPy's assignments to parts of a matrix take as long as its solution.
    rows, right = [[0.0] * size for _ in range(size)], list[Any]([0.0] * size)
    for i, (body, motion) in enumerate(zip(bodies, motions, strict=True)):
        right[_own(i)] = components(applied_torsor(body, motion))
        for j, mass in enumerate((body.plate.mass, body.plate.mass, body.plate.inertia), 3 * i):
            rows[j][j] = mass
    for block in blocks:
        one = block.contact
        _enter(rows, right, block)
        if one.base is None and own_effects(bodies[one.body].effects):
            time, slip = motions[one.body][0], 0.0 if block.rolls else slip_velocity(one.k, block.belt[0])
            own = own_torsor(bodies[one.body], one.k, time, slip)
            right[_own(one.body)] = [a + b for a, b in zip(right[_own(one.body)], own, strict=True)]
    for last, number in enumerate(reversed(held), 1):
        j, track = 3 * number + THETA_ROW, contacts[0].k.track
        rows[j][-last], rows[-last][j], right[-last] = -1.0, 1.0, track.swing if track else 0.0
    return _system(rows, right, blocks, [3 * i + THETA_ROW for i, body in enumerate(bodies) if not body.plate.turns])


def _layout(
    bodies: Sequence[Case], contacts: Sequence[ClosedContact], motions: Sequence[Sequence[float]]
) -> tuple[list[ContactBlock], list[int]]:
    """The contacts' places in (27), and the bodies of which rolling resistance prevents the rotation."""
    row = parameter = 3 * len(bodies)
    column, blocks, held = row + sum(len(one.k.free) for one in contacts), list[ContactBlock](), set[int]()
    for one in contacts:
        arm, is_held = 0.0, False
        if one.base is None:  # nothing resists the rotation of two bodies on each other
            arm, is_held = resistance(one.case, one.mode, one.side, one.turn, one.k.turning)
        held |= {one.body} if is_held else set()
        belt, rolls = belt_of(one.case, motions[one.body][0]), one.mode in WITHOUT_SLIP
        ratio = friction_ratio(one.case, one.mode, one.side, one.k, belt[0])
        parameters, is_fixed = slice(parameter, parameter + len(one.k.free)), not bodies[one.body].plate.turns
        blocks.append(ContactBlock(one, row, parameters, column, belt, ratio, arm, rolls, is_held or is_fixed))
        row, parameter, column = row + 1 + len(one.k.free) + rolls, parameters.stop, column + 1 + rolls
    return blocks, sorted(held)


def _enter(rows: list[list[Any]], right: list[Any], block: ContactBlock) -> None:
    """Enter a contact's rows (8), (9), which is left out at a corner, and that of rolling, and its columns of A."""
    one, row, k = block.contact, block.row, block.contact.k
    x, y = _base_arm(one) if one.base is not None else (0.0, 0.0)
    for i, (of_q1, of_q2, rate) in enumerate(zip(*constraints(k), strict=True)):
        if i > len(k.free):
            break
        rows[row][_own(one.body)], rows[row][block.parameters], right[row] = of_q1, [of_q2[j] for j in k.free], rate
        if one.base is not None:  # c̈ and α̈ of the track, which C has for a drive
            rows[row][_own(one.base)] = ([-1.0, 0.0, y], [0.0, -1.0, -x], [0.0, 0.0, -of_q1[2]])[i]
        row += 1
    columns = [sliding_column(k, block.ratio, block.arm)]
    if block.rolls:
        columns.append(tangential_column(k))
        of_q2, right[row] = rolling_row(k, block.belt)
        rows[row][block.parameters] = [of_q2[j] for j in k.free]
    for column, (fx, fy, moment) in enumerate(columns, block.column):
        for j, value in enumerate((fx, fy, moment), 3 * one.body):
            rows[j][column] = -value
        if one.base is not None:  # the opposite force
            for j, value in enumerate((fx, fy, cross((x, y), (fx, fy))), 3 * one.base):
                rows[j][column] = value


def _own(body: int) -> slice:
    """The rows and columns of a body."""
    return slice(3 * body, 3 * body + 3)


def _base_arm(one: ClosedContact) -> Any:
    """The arm of the contact from the centre of mass of the body whose boundary is the track."""
    assert one.k.track is not None
    return components(one.k.R - (one.k.track.x, one.k.track.y))


def _system(rows: list[list[Any]], right: list[Any], blocks: list[ContactBlock], fixed: list[int]) -> AugmentedSystem:
    """(27) from its rows, without those of the numbers `fixed`, of rotations that infinite inertia prevents."""
    count = blocks[0].contact.k.q.shape[1:] if blocks else ()
    for j in fixed:
        rows[j][j] = 0.0
    matrix, right_side = _array(rows, count), _array([right], count)[..., 0, :]
    moments = {j: (matrix[..., j, :], right_side[..., j]) for j in fixed}
    if fixed:
        matrix = np.delete(np.delete(matrix, fixed, axis=-1), fixed, axis=-2)
        right_side = np.delete(right_side, fixed, axis=-1)
    return AugmentedSystem(matrix, right_side, tuple(blocks), moments)


def _array(rows: Sequence[Sequence[Any]], count: tuple[int, ...]) -> np.ndarray:
    """Rows of numbers as an array; of numbers and arrays of shape `count` (n,) with a first axis of that length."""
    if not count:
        return np.array(rows)
    array = np.empty((len(rows), len(rows[0]), *count))
    for i, row in enumerate(rows):
        for j, value in enumerate(row):
            array[i, j] = value
    return np.moveaxis(array, -1, 0)


def friction_ratio(case: Case, mode: Mode, side: int, k: Kinematics, belt: float) -> float:
    """μ of (30): against the slip, by the magnitude of the normal force; 0 without slip or friction.

    A coefficient that depends on the slip speed is μ(|v|) with v of (12), relative to a belt with that speed; it is
    smooth where an integrator's stage passes v = 0.
    """
    friction = case.effect(CoulombFriction)
    if friction is None or mode not in SIGN:
        return 0.0
    mu = friction.at(-SIGN[mode] * slip_velocity(k, belt)) if friction.by_speed else friction.mu
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
        return state[4] if len(state) > 4 else k.theta
    angle = case.track.tangent_angle(state[0]) - case.plate.outline.tangent_angle(state[1])
    return angle + (k.track.angle if k.track else 0.0) + (case.turn if isinstance(case, PieceCase) else 0.0)


def solve_full_system(
    case: Case, mode: Mode, state: Sequence[float], side: int = 1, turn: int | None = None, time: float = 0.0
) -> Solution:
    """Accelerations, multipliers and contact forces from (27); raises numpy.linalg.LinAlgError where it is singular."""
    return solution(fill(case, mode, state, side, turn, time))


def parameter_accelerations(system: AugmentedSystem) -> list[float]:
    """q̈₂ alone; raises numpy.linalg.LinAlgError if the system is singular."""
    return unknowns(system)[system.contacts[0].parameters].tolist()


def unknowns(system: AugmentedSystem) -> np.ndarray:
    """All accelerations and multipliers, shape (size,) or (size, n), with θ̈ = 0 of bodies that do not turn; raises
    numpy.linalg.LinAlgError if the system is singular."""
    answer = np.linalg.solve(system.matrix, system.right[..., None])[..., 0].T
    for row in system.moments:
        answer = np.insert(answer, row, 0.0, axis=0)
    return answer


def forces(block: ContactBlock, answer: np.ndarray) -> tuple[Any, Any]:
    """Normal and friction force (N) of a contact from all `unknowns`."""
    size = length(block.contact.k.tangent)
    normal = answer[block.column] * size
    return normal, answer[block.column + 1] * size if block.rolls else block.ratio * normal


def solution(system: AugmentedSystem) -> Solution:
    """Solve the system of one contact; raises numpy.linalg.LinAlgError if it is singular."""
    answer, (block,) = unknowns(system), system.contacts
    normal, friction = forces(block, answer)
    couple = answer[-1] if block.rotation_fixed else block.arm * normal
    for row, moment in system.moments.values():  # the row for θ̈ gives the couple that keeps θ fixed
        couple = (row * answer.T).sum(axis=-1) - moment
    return Solution(answer[:3], answer[block.parameters], normal, friction, couple)


def flight_acceleration(case: Case, time: float, y: Sequence[float]) -> np.ndarray:
    """q̈₁ of a plate in free flight, (16) and (19) without F_L, shape (3,); y is (X₀, Y₀, θ, Ẋ₀, Ẏ₀, θ̇)."""
    if not case.plate.turns:
        return np.append(applied_torsor(case, (time, *y))[:2] / case.plate.mass, 0.0)
    return np.linalg.solve(mass_matrix(case), applied_torsor(case, (time, *y)))


# --- distance from singularity ----------------------------------------------------------------------------------------


def uniqueness(system: AugmentedSystem) -> Any:
    """The determinant of (27) over its value without friction and resistance: 1 there, 0 at Painlevé's paradox.

    Where it vanishes, the normal force is no longer a unique answer of (27). NaN where the curvatures are equal, which
    makes (27) singular in any case. Of n instants shape (n,).
    """
    smooth, (block,) = system.matrix.copy(), system.contacts
    smooth[..., :3, block.column] = -_array([sliding_column(system.k, 0.0, 0.0)], system.k.q.shape[1:])[..., 0, :]
    without = np.linalg.det(smooth)
    value = np.full(np.shape(without), nan)
    np.divide(np.linalg.det(system.matrix), without, out=value, where=without != 0.0)
    return value if np.ndim(value) else float(value)


def condition(case: Case, system: AugmentedSystem) -> float:
    """The 2-norm condition number of (27) in the plate's own units, in which mass, radius of gyration and arc length
    are one; infinite where the matrix is singular."""
    m, rho, (block,) = case.plate.mass, case.plate.gyration, system.contacts
    P, p = float(np.hypot(*system.k.Rp)), float(np.hypot(*system.k.rp))
    is_held = block.rotation_fixed and case.plate.turns
    # Units of the unknowns Ẍ₀, Ÿ₀, θ̈, ξ̈₁, ξ̈₂, the multipliers N/P and T/P, a couple; then of the rows: two forces, a
    # moment, (8) twice, (9), R_pᵀ v, θ̈.
    force, couple, turns = m * rho / P, m * rho**2, case.plate.turns
    columns = [rho, rho, *[1.0] * turns, rho / P, rho / p, force, *[force] * block.rolls, *[couple] * is_held]
    rows = [m * rho, m * rho, *[couple] * turns, rho, rho, P * p, *[P * rho] * block.rolls, *[1.0] * is_held]
    return float(np.linalg.cond(system.matrix * np.array(columns) / np.array(rows)[:, None]))
