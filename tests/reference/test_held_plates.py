"""A disc in the corner of floor and wall, held at rest by both, while another one rolls over it: exact motions.

Forces of a disc that sticks to floor and wall are not unique, as it has three equations and four forces. The other one
rolls as on a fixed disc: with φ from the vertical and R + r = a its energy is ¾ a φ'² + g cos φ per mass and length a.
"""

from math import cos, sin, sqrt, tan

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

import reference
from cases import (
    Case,
    CoulombFriction,
    Curve,
    Flight,
    FreePlate,
    Gravity,
    Impact,
    Mode,
    StartPose,
    Support,
    Unilateral,
    disc,
)
from cases.library import line

G, R, r = 9.81, 0.2, 0.1
A = R + r
WALL = Support(Curve(("0", "-s")), "wall")


def scene(phi: float, rate: float, mu: float = 0.6, duration: float = 1.0) -> Case:
    """A disc of radius 0.2 m at a wall on its left, and on it one of radius 0.1 m and half the mass that rolls at φ
    (rad) from the vertical with the rate φ' (rad/s)."""
    upper = StartPose(R + A * sin(phi), R + A * cos(phi), 0.0, A * rate * cos(phi), -A * rate * sin(phi), -A * rate / r)
    effects = Gravity(G), CoulombFriction(mu), Unilateral(), Flight(), Impact(0.0, "moreau")
    others = (FreePlate(disc(r, 0.5), upper, "b"),)
    return Case(line(), disc(R, 1.0), effects, StartPose(R, R), duration, supports=(WALL,), others=others)


def rolling_time(phi: float, rate: float, end: float) -> float:
    """When a disc that rolls on a fixed one comes from φ to `end`, s. φ is that at the start and a square: the rate
    there may be zero."""
    energy = 0.75 * A * rate**2 + G * cos(phi)
    sign = 1.0 if end > phi else -1.0
    return quad(
        lambda u: 2.0 * u * sqrt(0.75 * A / (energy - G * cos(phi + sign * u * u))) if u else 0.0,
        0.0, sqrt(abs(end - phi)), epsabs=1e-12, epsrel=1e-11,
    )[0]  # fmt: skip


def released_at(phi: float) -> float:
    """Where the wall's force vanishes as a disc rolls down from rest at φ: the force between the discs, with T/N of
    sin φ/3 over cos φ − a φ'²/g, then passes through the lower disc's point on the floor, T/N = tan(φ/2)."""
    return brentq(lambda x: sin(x) / 3.0 - tan(0.5 * x) * (cos(x) - 4.0 / 3.0 * (cos(phi) - cos(x))), phi, 1.0)


@pytest.mark.parametrize("phi,rate", [(0.2, 0.0), (0.3, 0.0), (0.2, -2.5), (0.4, -2.0), (0.05, -1.0)])
def test_a_disc_that_floor_and_wall_hold_is_released(phi, rate):
    """It was the status `breakdown` at 0 s. Of a disc that rolls up the force changes its side at the top."""
    case = scene(phi, rate)
    motion = reference.simulate(case, rtol=1e-12, method="dop853")
    opens = next(change for change in motion.transitions if change.contact == "plate/wall")
    assert opens.after is Mode.FLIGHT and opens == motion.transitions[0]
    time = rolling_time(phi, rate, 0.0 if rate else released_at(phi))
    assert opens.time == pytest.approx(time, abs=1e-11)
    assert not np.any(motion.plate("plate")(np.linspace(0.0, 0.999 * time, 50)).vx)
    assert motion.plate("plate")(time + 0.02).vx > 0.0
    assert motion.status == "completed" and not reference.check(case, motion)
