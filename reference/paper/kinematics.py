"""The paper's kinematics, (1)–(14), in its own letters: R, R_p, R_s, R_t on the track, r, r_p, r_s, r_t on the outline.

Lengths in metres; a dot is a time derivative. Everything here is literal: a test compares it with the eliminated form.
"""

from __future__ import annotations

from math import atan2, cos, sin
from typing import NamedTuple

import numpy as np

from cases import Belt, Case, Drive
from cases.moving_surface import TrackPlace

U = np.array([[0.0, -1.0], [1.0, 0.0]])  # (4)
I2 = np.eye(2)  # (4)


class Kinematics(NamedTuple):
    """One instant of a plate in contact: (1)–(3) with rates that satisfy (8) and (9).

    `q` and `q_dot` are q₂ = (ξ₁, ξ₂) and its rate. Vectors have shape (2,), `turn` (the paper's matrix θ) (2, 2).
    `theta` is determined up to whole turns, which (6) leaves open. On a driven track R(ξ₁, t) = c + Q Γ(ξ₁) with its
    place c(t) and rotation Q(t), which `track` has with their rates; Ṙ₀ and θ̇ are in the fixed frame.
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
    track: TrackPlace | None = None

    @property
    def turning(self) -> float:
        """θ̇ relative to the track, whose tangents turn with it."""
        return self.theta_dot - (self.track.spin if self.track else 0.0)

    @property
    def W(self) -> np.ndarray:
        """∂R/∂t, the velocity of the track's point: ċ + α̇ U (R − c), shape (2,)."""
        if self.track is None:
            return np.zeros(2)
        c, c_dot = np.array([self.track.x, self.track.y]), np.array([self.track.vx, self.track.vy])
        return c_dot + self.track.spin * (U @ (self.R - c))

    @property
    def W_dot(self) -> np.ndarray:
        """∂²R/∂t², the acceleration of the track's point: c̈ + α̈ U (R − c) − α̇² (R − c), shape (2,)."""
        if self.track is None:
            return np.zeros(2)
        c, c_ddot = np.array([self.track.x, self.track.y]), np.array([self.track.ax, self.track.ay])
        return c_ddot + self.track.swing * (U @ (self.R - c)) - self.track.spin**2 * (self.R - c)


def track_jet(case: Case, xi1: float, track: TrackPlace | None) -> np.ndarray:
    """R, R_p, R_s, R_t of (1) in the fixed frame, shape (4, 2)."""
    jet = np.array(case.track.jet(xi1)).reshape(4, 2)
    if track is None:
        return jet
    Q = np.array([[cos(track.angle), -sin(track.angle)], [sin(track.angle), cos(track.angle)]])
    return np.array([Q @ jet[0] + (track.x, track.y), *(Q @ derivative for derivative in jet[1:])])


def kinematics(case: Case, xi1: float, xi2: float, xi1_dot: float, xi2_dot: float, time: float = 0.0) -> Kinematics:
    """All of (1)–(9) at one state in independent coordinates; `time` (s) is for driven tracks."""
    drive = case.effect(Drive)
    return kinematics_on(case, xi1, xi2, xi1_dot, xi2_dot, drive.at(time) if drive else None)


def kinematics_on(
    case: Case, xi1: float, xi2: float, xi1_dot: float, xi2_dot: float, track: TrackPlace | None
) -> Kinematics:
    """Same as `kinematics`, with the place of the track; None if it is fixed."""
    # Matrices times vectors are NumPy's products; all else is written in numbers, which takes a fifth of the time of
    # NumPy's functions on two numbers and rounds as they do.
    R, Rp, Rs, Rt = track_jet(case, xi1, track)  # (1)
    r, rp, rs, rt = np.array(case.plate.outline.jet(xi2)).reshape(4, 2)  # (2)
    (Rp_x, Rp_y), (Rs_x, Rs_y), (rp_x, rp_y) = Rp.tolist(), Rs.tolist(), rp.tolist()
    theta = atan2(Rp_y, Rp_x) - atan2(rp_y, rp_x)  # (6), and of its two solutions the one with parallel tangents
    c, s = cos(theta), sin(theta)
    turn = np.array([[c, -s], [s, c]])  # (3)
    arm, along = turn @ r, turn @ rp
    (arm_x, arm_y), (along_x, along_y), (bent_x, bent_y) = arm.tolist(), along.tolist(), (turn @ rs).tolist()
    R0 = R - arm  # (5)
    # (9), R_sᵀ U θ r_p = R_s,y (θ r_p)_x − R_s,x (θ r_p)_y; its divisor by NumPy, whose division by 0 raises nothing
    theta_dot = xi1_dot * (Rs_y * along_x - Rs_x * along_y) + xi2_dot * (Rp_y * bent_x - Rp_x * bent_y)
    theta_dot = float(theta_dot / (Rp @ along))
    R0_dot_x = xi1_dot * Rp_x + theta_dot * arm_y - xi2_dot * along_x  # (8)
    R0_dot = np.array([R0_dot_x, xi1_dot * Rp_y - theta_dot * arm_x - xi2_dot * along_y])
    q, q_dot = np.array([xi1, xi2]), np.array([xi1_dot, xi2_dot])
    k = Kinematics(q, q_dot, R, Rp, Rs, Rt, r, rp, rs, rt, theta, turn, R0, theta_dot, R0_dot, track)
    if track is None:
        return k
    # (8) and (9) gain the track's velocity: W on the right-hand side of (8), and θ̇ − α̇ in place of θ̇ in (9).
    theta_dot += track.spin
    return k._replace(theta_dot=theta_dot, R0_dot=xi1_dot * Rp + k.W - theta_dot * (U @ arm) - xi2_dot * along)


def slip_vector(k: Kinematics) -> np.ndarray:
    """(12): the velocity of the plate's point at the contact, relative to the track, shape (2,)."""
    return k.q_dot[0] * k.Rp - k.q_dot[1] * (k.turn @ k.rp)


def slip_vector_of_plate(k: Kinematics) -> np.ndarray:
    """(11): the same from the motion of the plate, relative to the track's point, shape (2,)."""
    velocity = k.R0_dot + k.theta_dot * (U @ k.turn @ k.r)
    return velocity if k.track is None else velocity - k.W


def slip_velocity(k: Kinematics, belt: float = 0.0) -> float:
    """The slip velocity R_pᵀ v / |R_p|, whose sign is used in (13) and (14), in m/s; relative to a surface that runs
    with the speed `belt` along R_p."""
    (Rp_x, Rp_y), (u1, u2), (along_x, along_y) = k.Rp.tolist(), k.q_dot.tolist(), (k.turn @ k.rp).tolist()
    along = Rp_x * (u1 * Rp_x - u2 * along_x) + Rp_y * (u1 * Rp_y - u2 * along_y)  # R_pᵀ v, of `slip_vector`
    return float(along / np.hypot(Rp_x, Rp_y)) - belt


def belt_of(case: Case, time: float) -> tuple[float, float]:
    """The speed of the track's surface along R_p (m/s) at a time (s), and its rate (m/s²): 0 without Belt."""
    belt = case.effect(Belt)
    speed, rate = belt.at(time) if belt else (0.0, 0.0)
    return speed, rate
