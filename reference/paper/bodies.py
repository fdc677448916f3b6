"""The paper's augmented system for several bodies and contacts: (27) with a block for each of them.

    [ M    0   −A₁ … −A_K ] [q̈₁  ]   [F  ]
    [ B_k  D_k      0     ] [q̈₂,k] = [C_k]        k = 1 … K
                            [λ_k ]

M and F have a block for each body, q₁ its (X₀, Y₀, θ). Every closed contact has its own q₂ = (ξ₁, ξ₂), its rows (8)″
and (9)″ with the third derivatives of (25), and its column of (33); one that does not slip has the tangential column
and the row of rolling as well; a belt changes the right-hand side of that row alone. Rolling resistance adds its couple
to the column of each contact that resists, and, where it prevents the rotation, one couple and the row θ̈ = 0 to its
body. A contact of two bodies is that of
a plate on a driven track: the track is the boundary of the other body, and its accelerations, which a drive adds to C,
are unknowns with the columns of `_base_block`; the other body has the opposite forces. At a corner of the outline r_p
vanishes: ξ₂ and the row (9)″ are left out, and θ̇ is part of the state. Literal and slow; the fast form of one body is
tested against it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cases import Case, Mode
from cases.curves.corner import Corner
from cases.moving_surface import TrackPlace

from .augmented import (
    WITHOUT_SLIP,
    applied_torsor,
    constraints,
    friction_ratio,
    mass_matrix,
    resistance,
    rolling_row,
    sliding_column,
    tangential_column,
)
from .kinematics import Kinematics, U, belt_of, kinematics_on, slip_velocity, track_jet


class BodyContact(NamedTuple):
    """A closed contact of the body number `body`, with its mode and (ξ₁, ξ₂, ξ̇₁, ξ̇₂).

    Outline, track and friction are those of `pair`. The track is fixed, or with `base` the boundary of that body, in
    its own frame and run through clockwise, so that the outside is on its left (`library.hill` for a disc).
    """

    pair: Case
    mode: Mode
    state: Sequence[float]
    body: int = 0
    base: int | None = None


class BodiesSolution(NamedTuple):
    """q̈₁ of each body, shape (bodies, 3), and for each contact q̈₂ (2,), of a corner (1,), normal force and friction
    force (N) on its body."""

    q1_ddot: np.ndarray
    q2_ddot: list[np.ndarray]
    normal_force: list[float]
    friction_force: list[float]


def solve_bodies(
    bodies: Sequence[Case], contacts: Sequence[BodyContact], motions: Sequence[Sequence[float]]
) -> BodiesSolution:
    """Accelerations and forces of bodies with closed contacts in those modes.

    `bodies`: for each a case with it as plate, and with its loads; one of infinite inertia does not turn. `motions`:
    for each the arguments of a load, (t, X₀, Y₀, θ, Ẋ₀, Ẏ₀, θ̇). Raises numpy.linalg.LinAlgError where the forces are
    not unique.
    """
    places = [_kinematics(one, motions) for one in contacts]
    sizes = [1 if isinstance(one.pair.plate.outline, Corner) else 2 for one in contacts]
    rolls = [one.mode in WITHOUT_SLIP for one in contacts]
    resistances = [
        resistance(one.pair, one.mode, 1, None, motions[one.body][6]) if one.base is None else (0.0, False)
        for one in contacts
    ]
    held = sorted({one.body for one, (_, is_fixed) in zip(contacts, resistances, strict=True) if is_fixed})
    row = first = 3 * len(bodies)
    column = row + sum(sizes)
    matrix = np.zeros((column + len(contacts) + sum(rolls) + len(held),) * 2)
    right = np.zeros(len(matrix))
    for i, (body, motion) in enumerate(zip(bodies, motions, strict=True)):
        matrix[_own(i), _own(i)], right[_own(i)] = mass_matrix(body), applied_torsor(body, motion)
        if not body.plate.turns:  # its row for θ̈ is θ̈ = 0, without forces
            matrix[3 * i + 2, 3 * i + 2], right[3 * i + 2] = 1.0, 0.0
    columns: list[tuple[int, float]] = []
    parameters: list[slice] = []
    for one, k, is_rolling, size, (arm, _) in zip(contacts, places, rolls, sizes, resistances, strict=True):
        own = slice(first, first + size)
        ratio = friction_ratio(one.pair, one.mode, 1, _slip(one, k, motions))
        rows = slice(row, row + size + 1)
        B, D, C = constraints(k)
        matrix[rows, _own(one.body)], matrix[rows, own], right[rows] = (
            B[: size + 1],
            D[: size + 1, :size],
            C[: size + 1],
        )
        if one.base is not None:
            matrix[rows, _own(one.base)] = _base_block(k, B)[: size + 1]
        _add_force(matrix, one, k, column, sliding_column(k, ratio, arm))
        columns.append((column, ratio))
        parameters.append(own)
        row, column, first = row + size + 1, column + 1, first + size
        if is_rolling:
            _add_force(matrix, one, k, column, tangential_column(k))
            coefficients, right[row] = rolling_row(k, belt_of(one.pair, motions[one.body][0]))
            matrix[row, own] = coefficients[:size]
            row, column = row + 1, column + 1
    for i, place in zip(held, range(-len(held), 0), strict=True):
        matrix[3 * i + 2, place], matrix[place, 3 * i + 2] = -1.0, 1.0
    for i, body in enumerate(bodies):
        if not body.plate.turns:
            matrix[3 * i + 2, 3 * len(bodies) + sum(sizes) :] = 0.0
    answer = np.linalg.solve(matrix, right)
    speeds = [float(np.hypot(*k.Rp)) for k in places]
    normal = [float(answer[place]) * speed for (place, _), speed in zip(columns, speeds, strict=True)]
    tangential = [
        float(answer[place + 1]) * speed if is_rolling else ratio * force
        for (place, ratio), speed, is_rolling, force in zip(columns, speeds, rolls, normal, strict=True)
    ]
    accelerations = answer[: 3 * len(bodies)].reshape(-1, 3)
    return BodiesSolution(accelerations, [answer[own] for own in parameters], normal, tangential)


def _slip(one: BodyContact, k: Kinematics, motions: Sequence[Sequence[float]]) -> float:
    """The slip velocity (12) of a contact relative to its belt, m/s."""
    return slip_velocity(k, belt_of(one.pair, motions[one.body][0])[0])


def _own(body: int) -> slice:
    """The rows and columns of a body."""
    return slice(3 * body, 3 * body + 3)


def _base_arm(k: Kinematics) -> np.ndarray:
    """The arm of the contact from the centre of mass of the body whose boundary is the track."""
    assert k.track is not None
    return k.R - (k.track.x, k.track.y)


def _base_block(k: Kinematics, B: np.ndarray) -> np.ndarray:
    """The columns of (8)″ and (9)″ for c̈ and α̈ of the track, which C has for a drive, on the left-hand side (3×3)."""
    x, y = _base_arm(k)
    return np.array([[-1.0, 0.0, y], [0.0, -1.0, -x], [0.0, 0.0, -B[2, 2]]])


def _add_force(matrix: np.ndarray, one: BodyContact, k: Kinematics, column: int, force: np.ndarray) -> None:
    """Enter a multiplier's force (3, 1) on the body, and the opposite one on its base."""
    matrix[_own(one.body), column : column + 1] = -force
    if one.base is not None:
        matrix[_own(one.base), column] = *force[:2, 0], (U @ _base_arm(k)) @ force[:2, 0]


def _kinematics(one: BodyContact, motions: Sequence[Sequence[float]]) -> Kinematics:
    """(1)-(9) of a contact; at a corner of the outline, whose derivatives vanish, with the body's spin (rad/s)."""
    corner, spin = one.pair.plate.outline, motions[one.body][6]
    xi1, xi2, xi1_dot, xi2_dot = one.state
    track = None
    if one.base is not None:
        _, x, y, angle, vx, vy, base_spin = map(float, motions[one.base])
        track = TrackPlace(x, y, angle, vx, vy, base_spin, 0.0, 0.0, 0.0)
    if not isinstance(corner, Corner):
        return kinematics_on(one.pair, xi1, xi2, xi1_dot, xi2_dot, track)
    R, Rp, Rs, Rt = track_jet(one.pair, xi1, track)
    theta = float(np.arctan2(Rp[1], Rp[0])) - float(corner.tangent_angle(xi2))
    turn = np.array([[np.cos(theta), -np.sin(theta)], [np.sin(theta), np.cos(theta)]])
    r, none = np.array([corner.x, corner.y]), np.zeros(2)
    R0, q, q_dot = R - turn @ r, np.array([xi1, xi2]), np.array([xi1_dot, xi2_dot])
    R0_dot = xi1_dot * Rp - spin * (U @ turn @ r)
    k = Kinematics(q, q_dot, R, Rp, Rs, Rt, r, none, none, none, theta, turn, R0, spin, R0_dot, track)
    return k if track is None else k._replace(R0_dot=R0_dot + k.W)
