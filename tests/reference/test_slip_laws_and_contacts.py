"""Friction that depends on the slip speed at several contacts: exact motions, two formulations, the paper's matrix."""

from math import cos, pi, sin

import mpmath
import numpy as np
import pytest
import sympy as sp

from cases import Belt, Case, CoulombFriction, Gravity, Load, Mode, Plate, StartPose, Support, Unilateral, disc
from cases.library import line
from tests.sampling import quick_every
from tests.scenes import second as second_states
from tests.scenes.slip_laws import HYPERBOLIC, PEAK, STRIBECK, G
from tests.scenes.supports import slow

from .test_belts_and_supports import METHODS, motion_by

# The second formulation takes a second of CPU time for it, and ten for narrower laws.
WIDE_LAW = "0.15 + 0.15*exp(-v/0.5)"
BLOCK, HIGH, WIDE = Plate.rectangle(0.6, 0.4, 1.0), 0.2, 0.3


def block(mu, *effects, mu_static=None, slope=0.0, speed=0.0, end=2.0) -> Case:
    """A block of 1 kg on its lower side, on a slope that rises along +X."""
    c, s = cos(slope), sin(slope)
    start = StartPose(-s * HIGH, c * HIGH, slope, c * speed, s * speed)
    every = (Gravity(G), CoulombFriction(mu, mu_static), Unilateral(), *effects)
    return Case(line(-slope), BLOCK, every, start, end)


def track_times(motion) -> list[float]:
    return [t.time for t in motion.transitions if t.contact == "plate/track"]


def quadrature(mu: str, speed: float, edges=()) -> float:
    """∫ dv/(μ(v) g) from 0 to a speed, by mpmath in parts."""
    law = sp.lambdify(sp.Symbol("v"), sp.sympify(mu, rational=True), "mpmath")
    with mpmath.workdps(25):
        parts = sorted({0.0, 0.02, 0.1, 0.3, *edges, speed})
        return float(mpmath.quad(lambda v: 1 / (law(v) * mpmath.mpf("9.81")), parts))


# --- a block ----------------------------------------------------------------------------------------------------------


@quick_every(2)
@METHODS
def test_a_block_on_a_ramp_under_viscous_friction_slows_down_exponentially(method):
    """Down a slope v̇ = g (sin α − (μ + c v) cos α): v = v_e + (v₀ − v_e) exp(−c g t cos α). Both corners have the
    slip's coefficient, and their normal forces the moment of friction about the centre, h (μ + c v) m g cos α."""
    mu, c, slope, v0 = 0.1, 0.2, 0.25, 1.5
    case = block(f"{mu} + {c}*v", slope=slope, speed=-v0)
    motion = motion_by(case, method)
    assert motion.status == "completed" and not motion.transitions
    rate, final = c * G * cos(slope), (G * sin(slope) / cos(slope) - mu * G) / (c * G)
    times = np.linspace(0.0, 2.0, 9)
    exact = final + (v0 - final) * np.exp(-rate * times)
    way = final * times + (v0 - final) * (1.0 - np.exp(-rate * times)) / rate
    if method == "second":
        x = second_states.poses(case, times[:-1])[0]
        assert -(x + sin(slope) * HIGH) / cos(slope) == pytest.approx(way[:-1], abs=2e-12)
        return
    allowed = 5e-12 if method == "dop853" else 1e-12  # DOP853 at its tolerance of 1e-14 makes 40 steps
    slips = [motion.contact_columns(name, times) for name in motion.contact_names]
    for one in slips:
        assert -one.slip == pytest.approx(exact, abs=allowed)
        assert one.friction_force == pytest.approx((mu + c * exact) * one.normal_force, abs=1e-10)
    lower, upper = (one.normal_force for one in slips)
    assert lower + upper == pytest.approx(G * cos(slope), rel=1e-12)
    assert WIDE * np.abs(lower - upper) == pytest.approx(HIGH * (mu + c * exact) * G * cos(slope), rel=1e-10)


@quick_every(2)
@METHODS
@pytest.mark.parametrize("mu", [WIDE_LAW, *slow(STRIBECK, HYPERBOLIC, PEAK)])
def test_a_belt_takes_a_block_along_when_the_quadrature_says(method, mu):
    """A block is laid on a belt of speed b: its slip b − v falls with μ g, the peak of `PEAK` within 2e-5 s."""
    b, peak = 1.0, [0.5 + k * 1e-4 for k in (-8, -3, -1, 0, 1, 3, 8)]
    motion = motion_by(block(mu, Belt(b)), method)
    assert [t.after for t in motion.transitions] == [Mode.ROLL, Mode.ROLL]
    assert track_times(motion) == pytest.approx([quadrature(mu, b, peak)], abs=1e-12)


# --- two supports -----------------------------------------------------------------------------------------------------

R, PRESS = 0.5, 3.0


def disc_at_wall(b: float, end: float = 2.0) -> Case:
    """A disc on a belt that runs towards a wall, against which a load presses it."""
    wall = Support(line(pi / 2), "wall", (CoulombFriction("0.1 + 0.3*v"),))
    effects = (Gravity(G), Unilateral(), CoulombFriction("0.2 + 0.2*exp(-v/0.5)"), Belt(-b), Load(fx=-PRESS))
    return Case(line(), disc(R, 1.0), effects, StartPose(R, R), end, supports=(wall,))


@quick_every(2)
@METHODS
def test_each_contact_has_the_coefficient_of_its_own_slip(method):
    """With u = r ω the slips are b − u on the belt and u at the wall: F₁ = μ₁ N₁, N₂ = P + F₁, F₂ = μ₂ N₂,
    N₁ = m g + F₂, and m u̇/2 = F₁ − F₂. The disc rolls on the belt at t = ∫ du/u̇ from 0 to b."""
    b = 0.4
    with mpmath.workdps(30):

        def rate(u):
            one = mpmath.mpf("0.2") + mpmath.mpf("0.2") * mpmath.exp(-(b - u) / mpmath.mpf("0.5"))
            two = mpmath.mpf("0.1") + mpmath.mpf("0.3") * u
            first = one * (mpmath.mpf("9.81") + two * PRESS) / (1 - one * two)
            return 2 * (first - two * (PRESS + first))

        exact = float(mpmath.quad(lambda u: 1 / rate(u), [0, 0.1, 0.2, 0.3, b]))
    motion = motion_by(disc_at_wall(b), method)
    assert [(t.contact, t.after) for t in motion.transitions] == [("plate/track", Mode.ROLL)]
    assert motion.transitions[0].time == pytest.approx(exact, abs=1e-12)
