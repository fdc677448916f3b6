"""List of the paper's numbered equations: what each states, and where it is in the code.

`docs/paper.md` shows the same table; a test compares the two and checks every place.
"""

from __future__ import annotations

from typing import NamedTuple


class Equation(NamedTuple):
    """One numbered equation and the places of the code that have it, as "module:name"."""

    number: int
    says: str
    places: tuple[str, ...]


_KINEMATICS = "reference.paper.kinematics:"
_SYSTEM = "reference.paper.augmented:"
_FILL = _SYSTEM + "assemble"
_CONSTRAINTS = _SYSTEM + "constraints"
_COLUMN = _SYSTEM + "sliding_column"

LINES = (
    Equation(1, "the track and its first three derivatives", ("cases.curves:Curve.jet", _KINEMATICS + "kinematics")),
    Equation(2, "the outline and its first three derivatives", ("cases.curves:Curve.jet", _KINEMATICS + "kinematics")),
    Equation(3, "the rotation θ and the centre of mass R₀", (_KINEMATICS + "kinematics",)),
    Equation(4, "the constants I₂, 0₂ and U", (_KINEMATICS + "I2", _KINEMATICS + "U")),
    Equation(5, "contact: R = R₀ + θ r", (_KINEMATICS + "kinematics", "cases.contact:pose")),
    Equation(6, "tangency: R_pᵀ U θ r_p = 0", (_KINEMATICS + "kinematics", "cases.contact:find")),
    Equation(7, "the derivative of θ, and U² = −I₂", (_CONSTRAINTS,)),
    Equation(8, "(5) differentiated", (_KINEMATICS + "kinematics", _CONSTRAINTS)),
    Equation(9, "(6) differentiated", (_KINEMATICS + "kinematics", _CONSTRAINTS, "reference.minimal.elimination:spin")),
    Equation(10, "the components of the slip velocity v", (_KINEMATICS + "slip_vector",)),
    Equation(11, "v by the motion of the plate", (_KINEMATICS + "slip_vector_of_plate", "cases.contact:slip_velocity")),
    Equation(12, "v by the motion of the contact point", (_KINEMATICS + "slip_vector",)),
    Equation(13, "v along R_p: R_pᵀ v > 0", (_KINEMATICS + "slip_velocity",)),
    Equation(14, "v against R_p", (_KINEMATICS + "slip_velocity", "reference.errata:_14")),
    Equation(15, "Newton and Euler, with N and T at the contact", (_FILL, "reference.errata:_torsor")),
    Equation(16, "the mass matrix M and q₁", (_SYSTEM + "mass_matrix",)),
    Equation(17, "the torsors of N and T", (_COLUMN, _SYSTEM + "tangential_column", "reference.errata:_20")),
    Equation(18, "F_L = N + T", (_FILL, "reference.errata:_20")),
    Equation(19, "M q̈₁ = F + F_L", (_FILL, _SYSTEM + "applied_torsor", _SYSTEM + "flight_acceleration")),
    Equation(20, "F_L written out again", ("reference.errata:_20",)),
    Equation(21, "F_L = A λ", (_COLUMN, _SYSTEM + "tangential_column")),
    Equation(22, "M q̈₁ = F + A λ", (_FILL,)),
    Equation(23, "B q̇₁ + D q̇₂ = 0", (_CONSTRAINTS,)),
    Equation(24, "q₂ = (ξ₁, ξ₂)", (_KINEMATICS + "Kinematics",)),
    Equation(25, "C, where the third derivatives enter", (_CONSTRAINTS,)),
    Equation(26, "B q̈₁ + D q̈₂ = C", (_CONSTRAINTS, _SYSTEM + "rolling_row")),
    Equation(27, "the augmented system", (_FILL, _SYSTEM + "solution", "reference.minimal.elimination:eliminate")),
    Equation(28, "Coulomb: T is μ₀ N in size", (_SYSTEM + "friction_ratio",)),
    Equation(29, "T along R_p", (_COLUMN,)),
    Equation(30, "the sign of μ, against the slip", (_SYSTEM + "SIGN", _SYSTEM + "friction_ratio")),
    Equation(31, "N and T together", (_COLUMN, "reference.errata:_32")),
    Equation(32, "Ũ and R̃_p", (_COLUMN, "reference.errata:_32")),
    Equation(33, "the column Ã", (_COLUMN,)),
    Equation(34, "F_L = Ã λ", (_FILL,)),
    Equation(
        35,
        "the disc in the circle",
        (
            "reference.paper.application:slip_end",
            "reference.paper.closed_form:sliding_disc_in_circle",
            "cases.catalogue.paper:disc_in_circle",
        ),
    ),
)
