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

from cases import Mode
from cases.scene.piece_case import PieceCase

from .augmented import Solution, solve_full_system


def solve_at_corner(
    case: PieceCase, mode: Mode, state: Sequence[float], side: int = 1, turn: int | None = None, time: float = 0.0
) -> Solution:
    """Accelerations and contact forces where a corner touches a smooth piece; `q2_ddot` is of shape (1,), the free
    parameter's.

    `state` is (ξ₁, ξ₂, ξ̇₁, ξ̇₂) in the pieces' parameters, of which a corner's is the angle of the tangent; the other
    arguments are those of `augmented.fill`. Raises numpy.linalg.LinAlgError where the matrix is singular.
    """
    return solve_full_system(case, mode, state, side, turn, time)
