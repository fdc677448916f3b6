"""The law that adapters with the effect Magnet have to keep."""

from math import sqrt

import numpy as np
from magnetic_wheel import Magnet

from adapters.laws import Route, hold
from adapters.laws.scenes import LEVEL
from cases import Case, CoulombFriction, Gravity, Start, Unilateral


def magnet_braking(route: Route) -> None:
    """A wheel that slides on a level line: v̇ = −μ (g + pull/m), so the pull brakes it."""
    d = route.draw("magnet braking")
    g, radius, mu = d.g(), d.between(0.08, 0.15), d.mu(0.06, 0.15)
    plate = d.disc(radius)
    pull = d.between(0.5, 1.5) * plate.mass * g
    slip = d.signed(2.0, 4.0) * sqrt(g * radius)
    rate = mu * (g + pull / plate.mass)
    # It would roll after v₀/(rate (1 + m r²/J)).
    duration = 0.8 * abs(slip) / (rate * (1 + plate.mass * radius**2 / plate.inertia))
    effects = (Gravity(g), CoulombFriction(mu), Magnet(pull), Unilateral())
    run = route.simulate(Case(LEVEL, plate, effects, Start(0.0, slip=slip), duration))
    exact = slip - np.sign(slip) * rate * run.motion.t
    hold("magnet braking", "vx", run.motion.vx - exact, rate * run.step + 1e-9, "pull of Magnet")
