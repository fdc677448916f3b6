"""Friction coefficients that depend on the slip speed, and scenes with them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cases import Case, CoulombFriction, Gravity, RollingResistance, Start, Unilateral, disc
from cases.library import line
from tests.scenes.elliptic import ellipse_in_ellipse

G, RADIUS = 9.81, 0.1

STRIBECK = "0.1 + 0.1*exp(-v/0.05) + 0.02*v"
HYPERBOLIC = "0.1 + 0.2/(1 + v/0.1)"  # the form of Dieci & Lopez, as this project writes it
PEAK = "0.2 + 0.5*exp(-((v - 0.5)/1e-4)**2)"  # twice as narrow as any step is long
GAUSSIAN = "0.1 + 0.15*exp(-(v/0.1)**2)"


def sliding_disc(mu, slip=1.0, duration=4.0, mu_static=None) -> Case:
    """A disc that slides on a level line: dv/dt = −3 μ(v) g until it rolls, and from then on."""
    effects = (Gravity(G), CoulombFriction(mu, mu_static), Unilateral())
    return Case(line(), disc(RADIUS, 1.0), effects, Start(0.0, slip=slip), duration)


def random_law(rng: np.random.Generator, narrowest: float = -2.5) -> CoulombFriction:
    """Stribeck, hyperbolic, viscous, with a bump, at least 10**narrowest m/s wide; with a static coefficient or
    without."""
    low, more = rng.uniform(0.02, 0.5), rng.uniform(0.02, 0.5)
    width, slope = 10.0 ** rng.uniform(narrowest, 0.0), rng.uniform(0.0, 0.3)
    mu = str(
        rng.choice(
            [
                f"{low!r} + {more!r}*exp(-v/{width!r}) + {slope!r}*v",
                f"{low!r} + {more!r}*exp(-(v/{width!r})**2)",
                f"{low!r} + {more!r}/(1 + v/{width!r})",
                f"{low!r} + {slope!r}*v",
                f"{low!r} + {more!r}*exp(-((v - {rng.uniform(0.1, 1.0)!r})/{width!r})**2)",
                f"{low!r} + {more!r}*tanh(v/{width!r})",
            ]
        )
    )
    law = CoulombFriction(mu)
    return law if rng.random() < 0.6 else CoulombFriction(mu, law.at_rest * rng.uniform(1.0, 1.5))


def random_scene(rng: np.random.Generator) -> Case:
    """An ellipse in an ellipse with such friction, on a track that pushes or in a guide, some with resistance."""
    shape = dict(A=(1.0, 1.2), B=(0.8, 1.0), a=(0.18, 0.3), b=(0.18, 0.3), shift=(-0.05, 0.05))
    motion = dict(xi1=(-3, 3), xi2=(-3, 3), omega=(-5, 5), direction=(-3, 3))
    values = {name: rng.uniform(*span) for name, span in (shape | motion).items()}
    slip = float(rng.choice([0.0, rng.uniform(-2.0, 2.0)]))
    base = ellipse_in_ellipse(**values, mu=0.0, slip=slip)
    effects = [base.effects[0], random_law(rng)]
    effects += [Unilateral()] if rng.random() < 0.8 else []
    effects += [RollingResistance(rng.uniform(1e-3, 0.02))] if rng.random() < 0.2 else []
    return replace(base, effects=tuple(effects), duration=0.8)
