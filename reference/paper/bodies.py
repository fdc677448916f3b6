"""The paper's augmented system for several bodies and contacts: (27) with a block for each of them.

    [ M    0   −A₁ … −A_K ] [q̈₁  ]   [F  ]
    [ B_k  D_k      0     ] [q̈₂,k] = [C_k]        k = 1 … K
                            [λ_k ]

M and F have a block for each body, q₁ its (X₀, Y₀, θ). Every closed contact has its own q₂ = (ξ₁, ξ₂), rows and
columns, those of `augmented.assemble_bodies`. Literal and slow; the fast form of one body is tested against it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cases import Case, Mode
from cases.moving_surface import TrackPlace

from .augmented import ClosedContact, assemble_bodies, forces, unknowns
from .kinematics import kinematics_on


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
    system = assemble_bodies(bodies, [_closed(one, motions) for one in contacts], motions)
    answer = unknowns(system)
    every = [forces(block, answer) for block in system.contacts]
    return BodiesSolution(
        answer[: 3 * len(bodies)].reshape(-1, 3),
        [answer[block.parameters] for block in system.contacts],
        [normal for normal, _ in every],
        [friction for _, friction in every],
    )


def _closed(one: BodyContact, motions: Sequence[Sequence[float]]) -> ClosedContact:
    """The contact with its kinematics; rolling resistance acts by the spin of the body itself."""
    spin, track = motions[one.body][6], None
    if one.base is not None:
        _, x, y, angle, vx, vy, base_spin = map(float, motions[one.base])
        track = TrackPlace(x, y, angle, vx, vy, base_spin, 0.0, 0.0, 0.0)
    xi1, xi2, xi1_dot, xi2_dot = one.state
    k = kinematics_on(one.pair, xi1, xi2, xi1_dot, xi2_dot, track, spin)
    return ClosedContact(one.pair, one.mode, k, 1, int(np.sign(spin)), one.body, one.base)
