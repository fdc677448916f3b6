"""Short flights close to the track: the contact's frame with a gap.

A bounce of a microsecond rises a picometre: in a pose in metres its height has ten digits fewer than a double. So a hop
is integrated in (ξ₁, ξ₂, ω, v, u, γ): contact parameters of the closest pair, spin, slip velocity, and the gap γ with
its rate u, which keep their full relative precision. With the outline's point straight above the track's and the
tangents parallel,

    (ρ₁ − k₁ γ) ξ̇₁ − ρ₂ ξ̇₂ = v,     k₁ ξ̇₁ − k₂ ξ̇₂ = ω,     γ̇ = u,

with the speeds ρ of both curves and the rates k at which their tangents turn (κ ρ; ±1 at a corner, where ρ = 0), and
v̇, u̇ are the components of the acceleration of the outline's point in a frame that turns with the track's tangent.
"""

from __future__ import annotations

from collections.abc import Callable
from math import copysign
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from .equations import ContactScene, Place

# A hop is integrated for at most this many times its estimated duration.
LONGEST = 4.0


class Hop(NamedTuple):
    """A finished hop: its duration (s), (ξ₁, ξ₂, ω, v) and the gap's rate (< 0) at its end, and its poses.

    `bodies` maps an array of times since its beginning to (x, y, θ, vx, vy, ω), shape (6, n).
    """

    duration: float
    z: list[float]
    lift: float
    bodies: Callable[[np.ndarray], np.ndarray]


def body(scene: ContactScene, state, turns: int) -> list[float]:
    """(x, y, θ, vx, vy, ω) of a plate whose closest point is straight above the track."""
    *z, lift, gap = state
    x, y, theta, vx, vy, w = scene.body_with(z, turns)
    q = scene.place(z[0], z[1])
    return [x - gap * q.ty, y + gap * q.tx, theta, vx - lift * q.ty, vy + lift * q.tx, w]


def turn_rates(q: Place) -> tuple[float, float]:
    """The rates at which the tangents of track and outline turn, rad per unit of the parameter."""
    return (
        q.bend_track * q.P if q.P else copysign(1.0, q.bend_track),
        q.bend_outline * q.p if q.p else copysign(1.0, q.bend_outline),
    )


def rates(scene: ContactScene, t: float, state, turns: int) -> list[float]:
    """Time derivatives of (ξ₁, ξ₂, ω, v, u, γ) in free flight."""
    xi1, xi2, w, slip, lift, gap = state
    q = scene.place(xi1, xi2)
    ax, ay, spin_pull = scene.pull(t, body(scene, state, turns) if scene.load else None)
    spin_rate = spin_pull * scene.m / scene.J
    k1, k2 = turn_rates(q)
    near = q.P - k1 * gap
    determinant = k1 * q.p - k2 * near
    first, second = (q.p * w - k2 * slip) / determinant, (near * w - k1 * slip) / determinant
    along_outline, turning = q.p * second, k1 * first
    # Acceleration of the outline's material point, and of the contact point's motion along the outline.
    forward = ax * q.tx + ay * q.ty - spin_rate * q.arm_n - w * w * q.arm_t
    upward = ay * q.tx - ax * q.ty + spin_rate * q.arm_t - w * w * q.arm_n + w * along_outline
    return [
        first, second, spin_rate,
        forward + turning * lift, upward - turning * slip, lift,
    ]  # fmt: skip


def hop(scene: ContactScene, t: float, z, turns: int, lift: float, estimate: float, rtol: float) -> Hop | None:
    """Integrate the hop that begins at t from (ξ₁, ξ₂, ω, v) with normal velocity `lift` and lasts about `estimate` s.

    None if it has not landed after `LONGEST` times that.
    """

    def scaled_rates(s, state):
        return [estimate * rate for rate in rates(scene, t + estimate * s, state.tolist(), turns)]

    def landing(s, state):
        return state[5] if s > 0.0 else 1.0

    landing.terminal, landing.direction = True, -1  # type: ignore[attr-defined]
    # Absolute tolerances by the size of each variable in this hop; time in units of the estimated duration.
    sizes = np.array([1.0, 1.0, 1.0, 1.0, lift, lift * estimate])
    solution = solve_ivp(
        scaled_rates, (0.0, LONGEST), [*scene.absolute(t, z), lift, 0.0],
        method="DOP853", rtol=rtol, atol=1e-2 * rtol * sizes, events=landing, max_step=0.5, dense_output=True,
    )  # fmt: skip
    if not len(solution.t_events[0]):
        return None

    def bodies(since: np.ndarray) -> np.ndarray:
        return np.array([body(scene, state, turns) for state in solution.sol(since / estimate).T]).T

    duration, last = estimate * float(solution.t[-1]), solution.y[:, -1]
    xi1, xi2, w, v = last[:4].tolist()
    return Hop(duration, [xi1, xi2, w, v - scene.surface(t + duration)[0]], float(last[4]), bodies)
