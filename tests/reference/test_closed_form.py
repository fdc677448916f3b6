"""Exact solutions against outside figures, and the reference against exact solutions, by both integrators."""

from functools import lru_cache
from math import acos, cos, pi

import mpmath as mp
import numpy as np
import pytest
from scipy.special import ellipk

import cases
import reference
from cases import Case, Curve, Gravity, Start, Unilateral, disc
from cases import curves as c
from reference.paper import closed_form
from tests.authorities.paper_application import FIRST_TRANSITION


@pytest.mark.slow
@pytest.mark.parametrize("mu", FIRST_TRANSITION)
def test_quadrature_reproduces_the_published_digits(mu):
    time, xi1, after = FIRST_TRANSITION[mu]
    # Decimal sizes here, binary ones in the solver: they differ by 1e-17.
    found = closed_form.sliding_disc_in_circle("1", "0.1", str(mu), "9.81")
    assert abs(found.time - mp.mpf(time)) < 1e-15
    assert abs(found.xi1 - mp.mpf(xi1)) < 1e-15
    assert found.after is after


@lru_cache
def quadrature(mu: float) -> closed_form.FirstZero:
    """Of a disc of 0.25 m in a circle of 1.5 m; once for all methods, as it takes seconds."""
    return closed_form.sliding_disc_in_circle(1.5, 0.25, mu, 9.81, digits=16)


@pytest.mark.slow
@pytest.mark.parametrize("method", reference.METHODS)
@pytest.mark.parametrize("mu", [0.03, 0.15, 0.4])
def test_first_transition_of_other_sliding_discs_is_the_quadratures(mu, method, accuracy):
    case = cases.load("disc_in_circle", R=1.5, r=0.25, mu=mu)
    exact = quadrature(mu)
    first = reference.simulate(case, rtol=1e-14, method=method).transitions[0]
    accuracy(
        case=case.label, solver="reference", route=method, quantity="first transition / s",
        error=float(mp.mpf(first.time) - exact.time),
        # Taylor: a few units in the last place of one second; DOP853: its own bound of 1e-13, accumulated.
        tolerance=1e-14 if method == "taylor" else 1e-12,
    )  # fmt: skip
    assert first.after is exact.after


def _turning_times(motion, duration):
    """Zeros of the centre's horizontal velocity, by bisection on the dense output."""
    from scipy.optimize import brentq

    t = np.linspace(1e-6, duration, 400)
    vx = motion(t).vx
    return [brentq(lambda s: motion(s).vx, t[i], t[i + 1], xtol=1e-14) for i in np.flatnonzero(vx[1:] * vx[:-1] < 0)]


def _pendulum_period(length, amplitude):
    """4 √(l/g) K(sin²(a/2)), from energy by sin(φ/2) = sin(a/2) sin u."""
    return 4 * np.sqrt(length / 9.81) * ellipk(np.sin(amplitude / 2) ** 2)


@pytest.mark.parametrize("method", reference.METHODS)
def test_frictionless_disc_in_a_circle_is_a_pendulum(method):
    circle = Curve(lambda s: (c.cos(s), c.sin(s)))
    case = Case(circle, disc(0.1, 1.0), (Gravity(9.81),), Start(-pi / 2 + 1.0), 5.0)
    period = _pendulum_period(0.9, 1.0)
    halves = _turning_times(reference.simulate(case, rtol=1e-13, method=method), 5.0)
    assert halves == pytest.approx([period / 2 * (k + 1) for k in range(len(halves))], abs=1e-10)
    assert len(halves) == 4


def test_rolling_disc_in_a_circle_is_a_longer_pendulum():
    case = cases.load("disc_in_circle", mu=2.0, xi1=pi / 2 + 0.3, duration=3.0)
    motion = reference.simulate(case, rtol=1e-13)
    assert motion.transitions == ()
    period = _pendulum_period(1.5 * 0.9, 0.3)
    halves = _turning_times(motion, 3.0)
    assert halves == pytest.approx([period / 2 * (k + 1) for k in range(len(halves))], abs=1e-10)


def _hill(mu, push=1e-2):
    """A disc near the top of a cylinder, with the speed and spin of a motion from rest at the top."""
    from cases import CoulombFriction

    hill = Curve(lambda s: (c.sin(s), c.cos(s)), domain=(-3.0, 3.0))
    drop = 9.81 * 1.1 * (1 - cos(push))
    if mu is None:
        return Case(hill, disc(0.1, 1.0), (Gravity(9.81), Unilateral()), Start(push, slip=(2 * drop) ** 0.5), 9.0)
    speed = (4 / 3 * drop) ** 0.5
    effects = (Gravity(9.81), CoulombFriction(mu), Unilateral())
    return Case(hill, disc(0.1, 1.0), effects, Start(push, omega=-speed / 0.1), 9.0)


def test_disc_leaves_a_cylinder_where_the_textbooks_say():
    frictionless = reference.simulate(_hill(None), rtol=1e-13)
    assert cos(frictionless.transitions[-1].xi1) == pytest.approx(2 / 3, abs=1e-12)
    # Friction cannot hold to the end: the plate slips before it leaves, between the two angles, nearer to 4/7 the
    # larger μ is.
    angles = [reference.simulate(_hill(mu), rtol=1e-12).transitions[-1].xi1 for mu in (0.1, 0.5, 2.0, 1e3)]
    assert acos(2 / 3) < angles[0] < angles[1] < angles[2] < angles[3] < acos(4 / 7)
    assert cos(angles[3]) == pytest.approx(4 / 7, abs=1e-3)


@pytest.mark.parametrize("amplitude", [0.3, 1.5, 2.5])
def test_disc_whose_centre_runs_on_a_cycloid_is_isochronous(amplitude):
    # The centre's path is (a(φ + sin φ), −a(1 + cos φ)); the track lies one radius outside, along the path's normal.
    a, r = 1.0, 0.1

    def track(s):
        # Half the parameter is the path's slope angle.
        return (a * (s + c.sin(s)) + r * c.sin(s / 2), -a * (1 + c.cos(s)) - r * c.cos(s / 2))

    case = Case(Curve(track, domain=(-3.0, 3.0)), disc(r, 1.0), (Gravity(9.81),), Start(-amplitude), 4.5)
    period = 4 * pi * np.sqrt(a / 9.81)  # the height is s²/(8a), s the arc
    halves = _turning_times(reference.simulate(case, rtol=1e-13), 4.5)
    assert halves[:2] == pytest.approx([period / 2, period], abs=1e-9)


def test_energy_balance_closes_with_the_work_of_friction():
    case = cases.load("disc_in_circle", mu=0.2, duration=5.0)
    motion = reference.simulate(case, rtol=1e-13)
    x, w = np.polynomial.legendre.leggauss(40)
    work, edges = 0.0, [0.0, *(t.time for t in motion.transitions), 5.0]
    for low, high in zip(edges, edges[1:], strict=False):
        state = motion(low + (high - low) * (x + 1) / 2)
        work += (high - low) / 2 * np.sum(w * state.friction_force * state.slip)
    first, last = motion(0.0), motion(5.0)

    def energy(s):
        return 0.5 * (s.vx**2 + s.vy**2) + 0.5 * case.plate.inertia * s.omega**2 - 9.81 * s.y

    assert energy(last) - energy(first) == pytest.approx(work, abs=1e-10)
    assert work < -1.0  # and friction did take something
