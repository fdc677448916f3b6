"""Several bodies in their contacts' frames: the Delassus matrix of all contacts, by curvatures only.

In the frame of a contact (t along the boundary of its base, n = U t towards its body) the velocities of gap and slip
are n·(v_B − v_A) and t·(v_B − v_A), of the points that touch. Their derivatives follow the contact: the frame turns
with ψ̇ = ω_A + κ₁ ṡ₁ = ω_B + κ₂ ṡ₂, and the points move along both boundaries with ṡ₁ and ṡ₂ = ṡ₁ − slip (derived
here).
"""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, hypot, sin
from typing import NamedTuple

import numpy as np

from cases import Case
from cases.curves.corner import Corner

from .contacts import PlateDynamics, friction_of

# Pose and velocities of a support: it does not move.
FIXED = (0.0,) * 6


class ContactOfBodies(NamedTuple):
    """A closed contact: outline, track and friction of `pair`, its parameters, the number of its body, and that of the
    body whose boundary, run through clockwise, is the track (None: a support)."""

    pair: Case
    xi1: float
    xi2: float
    body: int = 0
    base: int | None = None


class BodiesSystem(NamedTuple):
    """Contacts of n bodies in their frames. First the K normals, then the K tangents:

    `rows` (2K, 3n) of the velocities of gap and slip, `velocities` (2K,) (m/s), `delassus` (2K, 2K) from forces to
    their rates, `free` (2K,) their rates without contact forces; `inverse` (3n,) and `torsor` (3n,): inverse masses
    and applied forces; `mu`, `stick` (K,): coefficients of friction with slip and without.
    """

    rows: np.ndarray
    velocities: np.ndarray
    delassus: np.ndarray
    free: np.ndarray
    inverse: np.ndarray
    torsor: np.ndarray
    mu: np.ndarray
    stick: np.ndarray

    def accelerations(self, forces: np.ndarray) -> np.ndarray:
        """Accelerations (n, 3) with those contact forces (N₁ … N_K, T₁ … T_K), N."""
        return np.asarray(self.inverse * (self.torsor + self.rows.T @ forces)).reshape(-1, 3)


def bodies_system(
    bodies: Sequence[Case],
    contacts: Sequence[ContactOfBodies],
    t: float,
    states: Sequence[Sequence[float]],
) -> BodiesSystem:
    """The system of all contacts. `bodies`: for each a case with it as plate, and with its loads; `states`: for each
    (x, y, θ, vx, vy, ω)."""
    dynamics = [PlateDynamics(body) for body in bodies]
    inverse = np.concatenate([one.inverse for one in dynamics])
    torsor = np.concatenate([one.torsor(t, state) for one, state in zip(dynamics, states, strict=True)])
    count = len(contacts)
    rows, biases = np.zeros((2 * count, 3 * len(bodies))), np.zeros(2 * count)
    for k, contact in enumerate(contacts):
        lift, slip, lift_bias, slip_bias = _frame(contact, states)
        rows[k], rows[count + k], biases[k], biases[count + k] = lift, slip, lift_bias, slip_bias
    coefficients = np.array([friction_of(one.pair) for one in contacts]).reshape(-1, 2)
    velocities = rows @ np.concatenate([np.asarray(state[3:], dtype=float) for state in states])
    delassus = rows @ (inverse[:, None] * rows.T)
    free = rows @ (inverse * torsor) + biases
    return BodiesSystem(rows, velocities, delassus, free, inverse, torsor, coefficients[:, 0], coefficients[:, 1])


def _frame(one: ContactOfBodies, states: Sequence[Sequence[float]]) -> tuple[np.ndarray, np.ndarray, float, float]:
    """Rows (3n,) of the velocities of gap and slip, and the parts of their rates that the velocities give."""
    own, other = states[one.body], FIXED if one.base is None else states[one.base]
    track, outline = (
        _rotate_jet(one.pair.track, one.xi1, other[2]),
        _rotate_jet(one.pair.plate.outline, one.xi2, own[2]),
    )
    speed = hypot(*track[1])
    t = track[1] / speed
    n = np.array([-t[1], t[0]])
    lift, slip = np.zeros(3 * len(states)), np.zeros(3 * len(states))
    for number, (x, y), sign in ((one.body, outline[0], 1.0), (one.base, track[0], -1.0)):
        if number is not None:
            place = slice(3 * number, 3 * number + 3)
            lift[place] = sign * np.array([*n, n @ (-y, x)])
            slip[place] = sign * np.array([*t, t @ (-y, x)])
    velocity = np.concatenate([np.asarray(state[3:], dtype=float) for state in states])
    spin, base_spin = float(own[5]), float(other[5])
    gap_rate, slip_rate = float(lift @ velocity), float(slip @ velocity)
    bend = _curvature(track)
    if isinstance(one.pair.plate.outline, Corner):  # a fixed point of the outline
        along = slip_rate
    else:
        own_bend = _curvature(outline)
        along = (own_bend * slip_rate - (spin - base_spin)) / (own_bend - bend)
    turning = base_spin + bend * along
    centripetal = base_spin**2 * track[0] - spin**2 * outline[0]
    lift_bias = n @ centripetal + spin * (along - slip_rate) - base_spin * along - turning * slip_rate
    return lift, slip, float(lift_bias), float(t @ centripetal + turning * gap_rate)


def _rotate_jet(curve, xi: float, angle: float) -> np.ndarray:
    """Point and first two derivatives of a curve turned by an angle, shape (3, 2)."""
    c, s = cos(angle), sin(angle)
    return np.array(curve.jet(xi)).reshape(4, 2)[:3] @ np.array([[c, s], [-s, c]])


def _curvature(jet: np.ndarray) -> float:
    _, (xp, yp), (xs, ys) = jet
    return float((xp * ys - yp * xs) / hypot(xp, yp) ** 3)
