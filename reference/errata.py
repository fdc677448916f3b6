"""The paper's misprints, shown by residuals: each printed formula and the corrected one, both evaluated.

A residual is the difference between a formula and the value it must equal, relative to the size of that value, at one
generic state (an ellipse in an ellipse, all rates different from zero). A corrected formula's residual is rounding. If
a formula is not wrong but cannot be read as printed, the row's verdict states the fact that shows it.
"""

from __future__ import annotations

from math import cos, sin
from typing import NamedTuple

import numpy as np

import cases
from cases import Case, CoulombFriction, Curve, Gravity, Mode, Plate, Start, Unilateral
from cases import curves as c
from cases.contact import velocity

from .paper.application import rolls_beyond
from .paper.augmented import applied_torsor, mass_matrix, solve_full_system
from .paper.kinematics import I2, Kinematics, U, kinematics
from .solve import simulate

MU = 0.2


class Erratum(NamedTuple):
    """One row of errata.csv; residuals are relative, NaN if a formula cannot be evaluated.

    `claim` is the paper's μ₀ if the row is about its claim that rolling follows, else NaN.
    """

    where: str
    printed: str
    corrected: str
    printed_residual: float
    corrected_residual: float
    verdict: str
    claim: float = float("nan")


def errata() -> list[Erratum]:
    """Evaluate every erratum."""
    misprints = (_reference_5, _after_6, _9, _14, _19, _20, _32, _35_slip, _35_axes)
    return [*(row() for row in misprints), *(_claim_of_rolling(mu) for mu in (0.01, 0.1, 0.2))]


def _generic() -> tuple[Case, Kinematics]:
    track = Curve(lambda s: (1.3 * c.cos(s), 0.9 * c.sin(s)))
    plate = Plate(Curve(lambda s: (0.2 * c.cos(s) + 0.03, 0.15 * c.sin(s))), 1.2, 0.02)
    effects = (Gravity(9.81), CoulombFriction(MU), Unilateral())
    case = Case(track, plate, effects, Start(xi1=-1.1, xi2=0.4, slip=0.7, omega=2.0), 1.0)
    return case, kinematics(case, -1.1, 0.4, 0.8, 1.9)


def _relative(value, reference) -> float:
    return float(np.linalg.norm(np.subtract(value, reference)) / np.linalg.norm(reference))


# Citations in the paper's text, in their order, and the numbers in its list of references.
_CITATIONS, _REFERENCES = (5, 2, 1, 3, 1, 3), (1, 2, 3, 4)


def _reference_5() -> Erratum:
    missing, extra = sorted(set(_CITATIONS) - set(_REFERENCES)), sorted(set(_REFERENCES) - set(_CITATIONS))
    by_4 = {4 if number == 5 else number for number in _CITATIONS}
    return Erratum(
        "section 1", "multibody systems [5]", "[4], perhaps: the paper does not say",
        len(missing) / len(set(_CITATIONS)), len(by_4 - set(_REFERENCES)) / len(by_4),
        f"cited and not listed: {missing}; listed and not cited: {extra} (residual: the part of the numbers cited that "
        "the list lacks)",
    )  # fmt: skip


def _after_6() -> Erratum:
    _, k = _generic()
    h = 1e-6
    # (8) must be the derivative of (5), computed by differences; (4) defines constants, whose derivative is zero.
    case = _generic()[0]
    ahead, behind = (kinematics(case, *(k.q + s * h * k.q_dot), *k.q_dot) for s in (1, -1))
    rate_of_5 = ((ahead.R0 + ahead.turn @ ahead.r) - (behind.R0 + behind.turn @ behind.r)) / (2 * h)
    along_8 = k.R0_dot + k.theta_dot * (U @ k.turn @ k.r) + k.q_dot[1] * (k.turn @ k.rp)
    return Erratum(
        "after (6)", "differentiating (4), (5)", "differentiating (5), (6)",
        _relative(np.zeros(2), along_8), _relative(rate_of_5, along_8),
        "(4) only defines constants; (8) is the derivative of (5) (by central differences, 1e-9 is their own error)",
    )  # fmt: skip


def _9() -> Erratum:
    case, k = _generic()
    rp, rs = k.turn @ k.rp, k.turn @ k.rs
    # θ̇ from the curvatures of both curves, not from (9): otherwise the test would be circular.
    bends = case.track.curvature(k.q[0]), case.plate.outline.curvature(k.q[1])
    theta_dot = bends[0] * np.hypot(*k.Rp) * k.q_dot[0] - bends[1] * np.hypot(*k.rp) * k.q_dot[1]
    terms = np.array([-theta_dot * (k.Rp @ rp), k.q_dot[0] * (k.Rs @ U @ rp), k.q_dot[1] * (k.Rp @ U @ rs)])
    return Erratum(
        "(9)", "… = {0}, as (8)", "… = 0",
        float("nan"), float(abs(terms.sum()) / np.abs(terms).max()),
        f"its three terms are numbers, {terms[0]:.3f}, {terms[1]:.3f}, {terms[2]:.3f}; {{0}} in (8) is a column of two",
    )  # fmt: skip


def _14() -> Erratum:
    case, k = _generic()
    printed = k.Rp @ k.turn  # a row of two numbers: it has no sign
    slip = case.track.tangent(k.q[0]) @ (k.q_dot[0] * k.Rp - k.q_dot[1] * (k.turn @ k.rp))
    v = k.R0_dot + k.theta_dot * (U @ k.turn @ k.r)
    corrected = k.Rp @ v / np.linalg.norm(k.Rp)
    return Erratum(
        "(14)", "R_pᵀ·θ < 0", "R_pᵀ·v < 0", float("nan"), _relative(corrected, slip),
        f"R_pᵀ·θ has shape {printed.shape} and no sign; R_pᵀ·v is the slip velocity times |R_p|",
    )  # fmt: skip


def _19() -> Erratum:
    case, k = _generic()
    state = (*k.q, *k.q_dot)
    solution, M = solve_full_system(case, Mode.SLIP_FORWARD, state), mass_matrix(case)
    q_ddot = np.array([*solution.q1_ddot, *solution.q2_ddot])
    tangent = k.Rp / np.linalg.norm(k.Rp)
    F_L = _torsor(k, solution.normal_force * (U @ tangent) + solution.friction_force * tangent)
    F = applied_torsor(case, (0.0, *k.R0, k.theta, *k.R0_dot, k.theta_dot))
    return Erratum(
        "(19)", "M q̈ = F + F_L", "M q̈₁ = F + F_L",
        float("nan"), _relative(M @ q_ddot[:3], F + F_L),
        f"M has shape {M.shape}; q without an index is not defined, and q₁ and q₂ together have {len(q_ddot)} rows",
    )  # fmt: skip


def _20() -> Erratum:
    _, k = _generic()
    (Nx, Ny), (Tx, Ty), (X, Y), (X0, Y0) = (1.3, -0.4), (0.2, 0.65), k.R, k.R0
    N, T = np.array([Nx, Ny, Ny * (X - X0) - Nx * (Y - Y0)]), np.array([Tx, Ty, Ty * (X - X0) - Tx * (Y - Y0)])  # (17)
    by_20 = np.array([Nx + Tx, Ny + Ty, Ny * (X - X0) - Nx * (Y - Y0) + Ty * (X - X0) - Tx * (Y - Y0)])
    return Erratum(
        "(20)", "another form of F_L, by (5)", "(18) with (17) put in; by (5) the arms are the components of θ r",
        _relative(by_20, N + T), _relative(_torsor(k, np.array([Nx + Tx, Ny + Ty])), N + T),
        "not false, but printed twice: it is (17) in (18) to the letter, and θ r, which (33) needs, does not occur",
    )  # fmt: skip


def _torsor(k: Kinematics, force: np.ndarray) -> np.ndarray:
    """A force at the contact and its moment about the centre of mass, with the arm θ r of (5)."""
    arm = k.turn @ k.r
    return np.array([*force, arm[0] * force[1] - arm[1] * force[0]])


def _32() -> Erratum:
    _, k = _generic()
    mu = -MU
    force = np.array([-k.Rp[1] + mu * k.Rp[0], k.Rp[0] + mu * k.Rp[1]])  # (31) per λ
    arm, torsor = k.turn @ k.r, _torsor(k, force)

    def column(U_tilde):
        Rp_tilde = U_tilde @ k.Rp
        return np.array([*(U @ Rp_tilde), Rp_tilde @ arm])  # (33)

    return Erratum(
        "(32)", "Ũ = U − μ I₂", "Ũ = I₂ − μ U",
        _relative(column(U - mu * I2), torsor), _relative(column(I2 - mu * U), torsor),
        "only the corrected one makes (33) the force (31) and its moment",
    )  # fmt: skip


def _35_slip() -> Erratum:
    R, r, xi1_dot, theta_dot = 1.0, 0.1, 1.7, -4.0
    case = cases.load("disc_in_circle", mu=MU)
    k = kinematics(case, 0.6, 0.2, xi1_dot, xi1_dot - theta_dot)  # ξ₂ = ξ₁ − θ
    v = case.track.tangent(0.6) @ (k.R0_dot + k.theta_dot * (U @ k.turn @ k.r))  # (11)
    return Erratum(
        "(35), v", "(R − r) ξ̇₁² + r θ̇", "(R − r) ξ̇₁ + r θ̇",
        _relative((R - r) * xi1_dot**2 + r * theta_dot, v), _relative((R - r) * xi1_dot + r * theta_dot, v),
        "the printed one mixes units; (11) gives the corrected one",
    )  # fmt: skip


def _35_axes() -> Erratum:
    xi1, xi1_dot, L, g = 0.6, 1.7, 0.9, 9.81
    printed = [g / L * (cos(xi1) - MU * sin(xi1)) - MU * xi1_dot**2, g * sin(xi1) + L * xi1_dot**2]

    def actual(direction):
        case = cases.load("disc_in_circle", mu=MU)
        gravity = (Gravity(g, direction), *case.effects[1:])
        variant = Case(case.track, case.plate, gravity, case.start, case.duration)
        solution = solve_full_system(variant, Mode.SLIP_FORWARD, (xi1, 0.0, xi1_dot, 0.0))
        return [solution.q2_ddot[0], solution.normal_force]

    return Erratum(
        "(35), axes", "(no word on the axes: Y up)", "Y points down (gravity along +Y), and v > 0",
        _relative(printed, actual(-np.pi / 2)), _relative(printed, actual(np.pi / 2)),
        "ξ̈₁ and N of (35) are those of (27) with gravity along +Y",
    )  # fmt: skip


def _claim_of_rolling(mu: float) -> Erratum:
    """The paper's claim for one μ₀; its residual is the amount by which rolling would exceed the cone."""
    case = cases.load("disc_in_circle", mu=mu)
    motion = simulate(case, rtol=1e-12)
    first = motion.transitions[0]
    rates = velocity(case, first.xi1, first.xi2, 0.0, float(motion(first.time).omega))
    roll = solve_full_system(case, Mode.ROLL, (first.xi1, first.xi2, rates.xi1_dot, rates.xi2_dot))
    demand = abs(roll.friction_force) / (mu * roll.normal_force)
    follows = "it rolls, the claim holds" if first.after is Mode.ROLL else "the slip reverses, the claim fails"
    bound = rolls_beyond(mu)
    start = f"released beyond ξ₁ = {bound:.5f} rad it would roll" if bound else "released lower it rolls, too"
    return Erratum(
        f"end of 4.2, μ₀ = {mu:g}",
        "when v vanishes the disc rolls",
        "it rolls only if |T| ≤ μ₀ N, else the slip reverses",
        max(0.0, demand - 1.0),
        0.0 if (demand <= 1.0) == (first.after is Mode.ROLL) else float("nan"),
        f"let go at rest at ξ₁ = 0 (the paper does not say where), rolling would take |T| = {demand:.3f} μ₀ N: "
        f"{follows}; {start}. Neither depends on R, r, m or g",
        mu,
    )
