"""The paper's kinematics, (1)–(14), in its own letters: R, R_p, R_s, R_t on the track, r, r_p, r_s, r_t on the outline.

Lengths in metres; a dot is a time derivative. Everything here is literal: a test compares it with the eliminated form.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from cases import Belt, Case, Drive
from cases.contact import track_place
from cases.curves.corner import Corner, turning
from cases.moving_surface import TrackPlace

U = np.array([[0.0, -1.0], [1.0, 0.0]])  # (4)
I2 = np.eye(2)  # (4)

# The components of a vector: numbers; at n instants arrays (n,).
Components = Any


@dataclass
class Kinematics:
    """One instant of a plate in contact: (1)–(3) with rates that satisfy (8) and (9); or n instants.

    `q` and `q_dot` are q₂ = (ξ₁, ξ₂) and its rate. Vectors have shape (2,), `turn` (the paper's matrix θ) (2, 2), at n
    instants (2, n) and (2, 2, n). `theta` is determined up to whole turns, which (6) leaves open. On a driven track
    R(ξ₁, t) = c + Q Γ(ξ₁) with its place c(t) and rotation Q(t), which `track` has with their rates; Ṙ₀ and θ̇ are in
    the fixed frame. At a corner of one curve, whose derivatives vanish, (9) does not apply: `free` are the numbers
    (0 and 1) of the parameters in which the contact can move.
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
    free: tuple[int, ...] = (0, 1)

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

    def __post_init__(self):
        # The components of θ r, θ r_p, θ r_s and θ r_t, and of R_p, R_s and R_t, which every row needs.
        (a, b), (c, d) = self.turn.tolist() if self.turn.ndim == 2 else self.turn
        vectors = map(components, (self.r, self.rp, self.rs, self.rt))
        self.outline_vectors = [(a * x + b * y, c * x + d * y) for x, y in vectors]
        self.derivatives = [components(vector) for vector in (self.Rp, self.Rs, self.Rt)]

    @property
    def tangent(self) -> Components:
        """The components of the common tangent, not of unit length: R_p, or θ r_p at a corner of the track."""
        return self.derivatives[0] if 0 in self.free else self.outline_vectors[1]


def components(vector: np.ndarray) -> Any:
    """The components of a vector: of one instant as numbers, whose sums take a fifth of the time of NumPy's scalars."""
    return vector.tolist() if vector.ndim == 1 else vector


def dot(a: Components, b: Components) -> Any:
    """aᵀ b."""
    return a[0] * b[0] + a[1] * b[1]


def cross(a: Components, b: Components) -> Any:
    """bᵀ U a: the moment of a force b with the arm a."""
    return a[0] * b[1] - a[1] * b[0]


def at_each(function: Callable, *arguments: Any) -> Any:
    """The values of a function of numbers at one instant, or its rows (k, n) at n instants, as the first argument."""
    if not isinstance(arguments[0], np.ndarray):
        return function(*map(float, arguments))
    return np.array([function(*row) for row in np.transpose(np.broadcast_arrays(*arguments)).tolist()]).T


def _jet(curve: Any, s: Any) -> np.ndarray:
    """A curve's point and three derivatives, shape (4, 2), or (4, 2, n)."""
    jet = np.array(at_each(curve.jet, s))
    return jet.reshape(4, 2, *jet.shape[1:])


def _rotation(theta: Any) -> np.ndarray:
    """(3), shape (2, 2), or (2, 2, n)."""
    c, s = (np.cos(theta), np.sin(theta)) if isinstance(theta, np.ndarray) else (math.cos(theta), math.sin(theta))
    return np.array([[c, -s], [s, c]])


def kinematics(case: Case, xi1: float, xi2: float, xi1_dot: float, xi2_dot: float, time: float = 0.0) -> Kinematics:
    """All of (1)–(9) at one state in independent coordinates, or at n of them; `time` (s) is for driven tracks."""
    track = track_place(case, time) if case.effect(Drive) else None
    return kinematics_on(case, xi1, xi2, xi1_dot, xi2_dot, track)


def kinematics_on(
    case: Case,
    xi1: float,
    xi2: float,
    xi1_dot: float,
    xi2_dot: float,
    track: TrackPlace | None,
    spin: float | None = None,
) -> Kinematics:
    """Same as `kinematics`, with the place of the track; None if it is fixed. `spin`: at a corner of the outline θ̇
    (rad/s), if the rates of the parameters do not give it."""
    curves = case.track, case.plate.outline
    free = tuple(number for number, curve in enumerate(curves) if not isinstance(curve, Corner))
    jet, (r, rp, rs, rt) = _jet(curves[0], xi1), _jet(curves[1], xi2)  # (1), (2)
    if track is not None:
        Q = _rotation(track.angle)
        jet = np.array([Q[:, 0] * row[0] + Q[:, 1] * row[1] for row in jet])
        jet[0] += (track.x, track.y)
    R, Rp, Rs, Rt = jet
    if len(free) == 2:
        atan2 = np.arctan2 if isinstance(xi1, np.ndarray) else math.atan2
        # (6), and of its two solutions the one with parallel tangents
        theta = atan2(*components(Rp[::-1])) - atan2(*components(rp[::-1]))
    else:
        theta = curves[0].tangent_angle(xi1) - curves[1].tangent_angle(xi2) + (track.angle if track else 0.0)
    q, q_dot = np.array([xi1, xi2]), np.array([xi1_dot, xi2_dot])
    k = Kinematics(q, q_dot, R, Rp, Rs, Rt, r, rp, rs, rt, theta, _rotation(theta), R, 0.0, R, track, free)
    (arm, along, bent, _), (tangent, curving, _) = k.outline_vectors, k.derivatives
    if len(free) == 2:
        # (9); its divisor by NumPy, whose division by 0 raises nothing
        bending = xi1_dot * cross(along, curving) + xi2_dot * cross(bent, tangent)
        turns = np.divide(bending, dot(tangent, along))
        turns = turns if isinstance(turns, np.ndarray) else float(turns)
    elif spin is None:
        turns = turning(curves[0], xi1) * xi1_dot - turning(curves[1], xi2) * xi2_dot
    else:
        turns = spin - (track.spin if track else 0.0)
    # With θ̇ − α̇ in place of θ̇ in (9), and W on the right-hand side of (8).
    k.theta_dot = theta_dot = turns + track.spin if track else turns
    x, y = xi1_dot * tangent[0] + theta_dot * arm[1], xi1_dot * tangent[1] - theta_dot * arm[0]
    k.R0, k.R0_dot = R - arm, np.array([x - xi2_dot * along[0], y - xi2_dot * along[1]])  # (5), (8)
    if track is not None:
        k.R0_dot += k.W
    return k


def slip_vector(k: Kinematics) -> np.ndarray:
    """(12): the velocity of the plate's point at the contact, relative to the track, shape (2,)."""
    return k.q_dot[0] * k.Rp - k.q_dot[1] * np.array(k.outline_vectors[1])


def slip_vector_of_plate(k: Kinematics) -> np.ndarray:
    """(11): the same from the motion of the plate, relative to the track's point, shape (2,)."""
    velocity = k.R0_dot + k.theta_dot * (U @ k.outline_vectors[0])
    return velocity if k.track is None else velocity - k.W


def slip_velocity(k: Kinematics, belt: float = 0.0) -> float:
    """The slip velocity R_pᵀ v / |R_p|, whose sign is used in (13) and (14), in m/s; relative to a surface that runs
    with the speed `belt` along R_p."""
    tangent, (u1, u2), along, Rp = k.tangent, components(k.q_dot), k.outline_vectors[1], k.derivatives[0]
    v = u1 * Rp[0] - u2 * along[0], u1 * Rp[1] - u2 * along[1]  # `slip_vector`
    return dot(tangent, v) / length(tangent) - belt


def length(vector: Components) -> Any:
    """|v|."""
    return np.hypot(*vector) if isinstance(vector[0], np.ndarray) else math.hypot(*vector)


def bend(p: np.ndarray, s: np.ndarray) -> Any:
    """A curve's curvature from its first and second derivative, 1/m."""
    return cross(components(p), components(s)) / length(components(p)) ** 3


def belt_of(case: Case, time: float) -> tuple[float, float]:
    """The speed of the track's surface along R_p (m/s) at a time (s), and its rate (m/s²): 0 without Belt."""
    belt = case.effect(Belt)
    speed, rate = at_each(belt.at, time) if belt else (0.0, 0.0)
    return speed, rate
