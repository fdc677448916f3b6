"""The paper's kinematics, (1)–(12), in its own letters: R, R_p, R_s, R_t on the track, r, r_p, r_s, r_t on the outline.

Lengths in metres; a dot is a time derivative. Everything here is literal; the fast, eliminated form is in
`eliminated.py`, and a test holds the two together.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cases import Case

U = np.array([[0.0, -1.0], [1.0, 0.0]])  # (4)
I2 = np.eye(2)  # (4)


@dataclass(frozen=True)
class Kinematics:
    """One instant of a plate in contact: (1)–(3) with the rates that (8) and (9) leave free.

    `q` and `q_dot` are q₂ = (ξ₁, ξ₂) and its rate. Vectors have shape (2,), `turn` (the paper's matrix θ) (2, 2).
    """

    q: np.ndarray
    q_dot: np.ndarray
    R: np.ndarray
    Rp: np.ndarray
    Rs: np.ndarray
    Rt: np.ndarray
    r: np.ndarray
    rp: np.ndarray
    rs: np.ndarray
    rt: np.ndarray
    theta: float
    turn: np.ndarray
    R0: np.ndarray
    theta_dot: float
    R0_dot: np.ndarray


def kinematics(case: Case, xi1: float, xi2: float, xi1_dot: float, xi2_dot: float) -> Kinematics:
    """All of (1)–(9) at one state in independent coordinates."""
    R, Rp, Rs, Rt = np.array(case.track.jet(xi1)).reshape(4, 2)
    r, rp, rs, rt = np.array(case.plate.outline.jet(xi2)).reshape(4, 2)
    theta = case.track.tangent_angle(xi1) - case.plate.outline.tangent_angle(xi2)  # (6)
    turn = np.array([[np.cos(theta), -np.sin(theta)], [np.sin(theta), np.cos(theta)]])  # (3)
    R0 = R - turn @ r  # (5)
    theta_dot = (xi1_dot * (Rs @ U @ turn @ rp) + xi2_dot * (Rp @ U @ turn @ rs)) / (Rp @ turn @ rp)  # (9)
    R0_dot = xi1_dot * Rp - theta_dot * (U @ turn @ r) - xi2_dot * (turn @ rp)  # (8)
    q, q_dot = np.array([xi1, xi2]), np.array([xi1_dot, xi2_dot])
    return Kinematics(q, q_dot, R, Rp, Rs, Rt, r, rp, rs, rt, theta, turn, R0, theta_dot, R0_dot)


def slip_vector(k: Kinematics) -> np.ndarray:
    """(12): the velocity of the plate's point at the contact, shape (2,)."""
    return k.q_dot[0] * k.Rp - k.q_dot[1] * (k.turn @ k.rp)


def slip_vector_of_plate(k: Kinematics) -> np.ndarray:
    """(11): the same from the motion of the plate, shape (2,)."""
    return k.R0_dot + k.theta_dot * (U @ k.turn @ k.r)
