"""Random scenes that are hard on purpose: each has one or more of the atlas's difficulties, in any strength."""

from __future__ import annotations

from math import atan2, pi

import numpy as np

from cases import Case, CoulombFriction, Curve, Gravity, Mode, Plate, Start, Unilateral
from cases.curves import cos, sin
from reference.minimal.modes import start_state
from reference.paper.augmented import solve_full_system

# What makes a scene hard; each is drawn with equal chance.
KINDS = ("cone", "conforming", "release", "friction", "slip", "sliver")


def shifted_ellipse(a: float, b: float, shift: float = 0.0) -> Curve:
    """x = a cos s + shift, y = b sin s."""
    return Curve(lambda s: (a * cos(s) + shift, b * sin(s)))


def hard_scene(rng: np.random.Generator) -> tuple[str, Case]:
    """A kind and an admissible scene of it: an elliptic plate inside an elliptic track, a second or so long."""
    kind = str(rng.choice(KINDS))
    a, b = rng.uniform(0.18, 0.3, 2)
    A, B, shift = rng.uniform(1.0, 1.2), rng.uniform(0.8, 1.0), rng.uniform(-0.05, 0.05)
    xi1, xi2, direction = rng.uniform(-pi, pi, 3)
    mu, slip, omega = rng.uniform(0.02, 1.0), 0.0, rng.uniform(-3.0, 3.0)
    duration = 1.0
    if kind == "conforming":
        # A disc, nearly as large as its circle: in the ellipse a plate so large would touch twice.
        gap = 10 ** rng.uniform(-5, -1)
        A = B = 1.0
        a = b = 1.0 - gap
        shift, omega, duration = 0.0, 0.0, 3 * gap**0.5
    if kind == "sliver":
        # Up to 25 times as long as wide, short enough for the track's tightest bend everywhere.
        b = 10 ** rng.uniform(-2.2, -1.0)
        a = min(0.3, (0.5 * b) ** 0.5, 25 * b)
        a, b = max(a, b), min(a, b)
        shift = 0.0
    if kind == "friction":
        mu = 10 ** rng.uniform(-6, 1)
    if kind == "slip":
        slip = float(rng.choice([-1, 1])) * 10 ** rng.uniform(-11, -3)
    outline = shifted_ellipse(a, b, shift)
    plate = Plate(outline, 1.0, (a * a + b * b) / 4 + shift**2)
    track = shifted_ellipse(A, B)
    if kind in ("release", "conforming"):
        # Gravity along the track's tangent and no motion: v = 0 and N = 0 at once.
        along = track.tangent(xi1)
        direction = atan2(along[1], along[0]) + pi * int(rng.integers(2))
        omega = 0.0

    def scene(mu: float) -> Case:
        effects = (Gravity(9.81, direction), CoulombFriction(mu), Unilateral())
        return Case(track, plate, effects, Start(xi1, xi2, slip, omega), duration)

    if kind == "cone":
        # Friction is what rolling asks for at the start, or that but for up to a billionth.
        first = scene(1.0)
        rolling = solve_full_system(first, Mode.ROLL, start_state(first))
        need = abs(rolling.friction_force / rolling.normal_force) if rolling.normal_force else 1.0
        off = float(rng.choice([-1, 1])) * 10 ** rng.uniform(-9, -2)
        return kind, scene(float(np.clip(need, 1e-3, 1.5)) * (1 + off))
    return kind, scene(mu)
