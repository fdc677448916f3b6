"""The paper, line by line: each numbered equation, what it says, and where it stands in the code.

`docs/paper.md` shows the same table; a test holds the two together and finds every place.
"""

from __future__ import annotations

from typing import NamedTuple


class Line(NamedTuple):
    """One numbered equation and the places of the code that have it, as "module:name"."""

    number: int
    says: str
    places: tuple[str, ...]


_KINEMATICS = "reference.paper.kinematics:"
_AUGMENTED = "reference.paper.augmented:"
_FILL = _AUGMENTED + "assemble"
_CONSTRAINTS = _AUGMENTED + "constraints"
_COLUMN = _AUGMENTED + "sliding_column"

LINES = (
    Line(1, "the track and its first three derivatives", ("cases.curves:Curve.jet", _KINEMATICS + "kinematics")),
    Line(2, "the outline and its first three derivatives", ("cases.curves:Curve.jet", _KINEMATICS + "kinematics")),
    Line(3, "the rotation θ and the centre of mass R₀", (_KINEMATICS + "kinematics",)),
    Line(4, "the constants I₂, 0₂ and U", (_KINEMATICS + "I2", _KINEMATICS + "U")),
    Line(5, "contact: R = R₀ + θ r", (_KINEMATICS + "kinematics", "cases.contact:pose")),
    Line(6, "tangency: R_pᵀ U θ r_p = 0", (_KINEMATICS + "kinematics", "cases.contact:find")),
    Line(7, "the derivative of θ, and U² = −I₂", (_CONSTRAINTS,)),
    Line(8, "(5) differentiated", (_KINEMATICS + "kinematics", _CONSTRAINTS)),
    Line(9, "(6) differentiated", (_KINEMATICS + "kinematics", _CONSTRAINTS, "reference.minimal.eliminated:spin")),
    Line(10, "the components of the slip velocity v", (_KINEMATICS + "slip_vector",)),
    Line(11, "v by the motion of the plate", (_KINEMATICS + "slip_vector_of_plate", "cases.contact:slip_velocity")),
    Line(12, "v by the motion of the contact point", (_KINEMATICS + "slip_vector",)),
    Line(13, "v along R_p: R_pᵀ v > 0", (_KINEMATICS + "slip_velocity",)),
    Line(14, "v against R_p", (_KINEMATICS + "slip_velocity", "reference.errata:_14")),
    Line(15, "Newton and Euler, with N and T at the contact", (_FILL, "reference.errata:_torsor")),
    Line(16, "the mass matrix M and q₁", (_AUGMENTED + "mass_matrix",)),
    Line(17, "the torsors of N and T", (_COLUMN, _AUGMENTED + "tangential_column", "reference.errata:_20")),
    Line(18, "F_L = N + T", (_FILL, "reference.errata:_20")),
    Line(19, "M q̈₁ = F + F_L", (_FILL, _AUGMENTED + "applied_torsor", _AUGMENTED + "flight_acceleration")),
    Line(20, "F_L written out again", ("reference.errata:_20",)),
    Line(21, "F_L = A λ", (_COLUMN, _AUGMENTED + "tangential_column")),
    Line(22, "M q̈₁ = F + A λ", (_FILL,)),
    Line(23, "B q̇₁ + D q̇₂ = 0", (_CONSTRAINTS,)),
    Line(24, "q₂ = (ξ₁, ξ₂)", (_KINEMATICS + "Kinematics",)),
    Line(25, "C, where the third derivatives enter", (_CONSTRAINTS,)),
    Line(26, "B q̈₁ + D q̈₂ = C", (_CONSTRAINTS, _AUGMENTED + "rolling_row")),
    Line(27, "the augmented system", (_FILL, _AUGMENTED + "solution", "reference.minimal.eliminated:sliding")),
    Line(28, "Coulomb: T is μ₀ N in size", (_AUGMENTED + "_friction_ratio",)),
    Line(29, "T along R_p", (_COLUMN,)),
    Line(30, "the sign of μ, against the slip", (_AUGMENTED + "SIGN", _AUGMENTED + "_friction_ratio")),
    Line(31, "N and T together", (_COLUMN, "reference.errata:_32")),
    Line(32, "Ũ and R̃_p", (_COLUMN, "reference.errata:_32")),
    Line(33, "the column Ã", (_COLUMN,)),
    Line(34, "F_L = Ã λ", (_FILL,)),
    Line(
        35,
        "the disc in the circle",
        (
            "reference.paper.application:slip_end",
            "reference.paper.closed_form:sliding_disc_in_circle",
            "cases.catalogue.paper:disc_in_circle",
        ),
    ),
)
