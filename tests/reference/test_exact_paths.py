"""Guides, crests, ends of tracks and landings, where a closed form or dense samples of the curves have the answer."""

from dataclasses import replace
from math import cos, exp, pi, sin, sqrt

import numpy as np
import pytest
from scipy.optimize import brentq, fsolve

import reference
from cases import (
    Case,
    CoulombFriction,
    Curve,
    Flight,
    Gravity,
    Load,
    Mode,
    PerfectlyRough,
    Plate,
    Start,
    Unilateral,
    disc,
)
from cases import curves as c
from cases.contact import start_motion
from cases.library import circle, cosine, ellipse, line

G = 9.81
# Two integrations of a second or two at 1e-13, relative to values of the order of one.
TIGHT = 1e-12
GRIP = (Gravity(G), Unilateral())


def solve(case: Case):
    return reference.simulate(case, rtol=1e-13)


def test_friction_on_a_guide_uses_the_magnitude_of_a_normal_force_that_changes_sign(accuracy):
    # While it slips forward, u = ξ̇² obeys du/dξ + 2 μ σ u = (2g/L)(μ σ sin ξ − cos ξ), σ the sign of
    # N = m (L u − g sin ξ): u = a sin ξ + b cos ξ + C e^(−2μσξ), continued from one zero of N to the next.
    L, mu, speed = 0.9, 0.02, sqrt(4.8 * G * 0.9)

    def piece(sign, xi0, u0):
        a = -(2 * G / L) * (1 - 2 * mu**2) / (1 + 4 * mu**2)
        b = 2 * mu * sign * (a - G / L)
        C = u0 - a * sin(xi0) - b * cos(xi0)
        return lambda xi: a * np.sin(xi) + b * np.cos(xi) + C * np.exp(-2 * mu * sign * (xi - xi0))

    rising = piece(1, -pi / 2, (speed / L) ** 2)
    first = brentq(lambda xi: rising(xi) - G / L * sin(xi), 0.0, pi / 2, xtol=1e-15)
    pulled = piece(-1, first, rising(first))
    second = brentq(lambda xi: pulled(xi) - G / L * sin(xi), pi / 2, 3.0, xtol=1e-15)
    falling = piece(1, second, pulled(second))
    effects, start = (Gravity(G), CoulombFriction(mu)), Start(-pi / 2, slip=speed)
    answer = solve(Case(circle(1.0), disc(0.1, 1.0), effects, start, 1.5))
    now = answer(np.linspace(0, 1.5, 16))
    assert answer.status == "completed" and not answer.transitions
    xi, slip = now.xi1, now.slip
    assert slip.min() > 0.1 and xi[-1] > second + 0.5
    exact = np.where(xi < first, rising(xi), np.where(xi < second, pulled(xi), falling(xi)))
    worst = np.max(np.abs((now.vx**2 + now.vy**2) / L**2 - exact))
    accuracy(
        case="bilateral loop, mu=0.02", solver="reference", route="best",
        quantity="square of angular speed / rad²/s²", error=worst, tolerance=1e-10,
    )  # fmt: skip


def test_disc_leaving_a_crest_lands_on_the_next_slope_where_its_parabola_meets_it(accuracy):
    # It slides without friction up to the crest of y = 0.3 cos 3x: v² = v₀² − 2 g (rise of the centre), and leaves
    # where g cos φ = v² κ/(1 + κ r), κ the crest's curvature. Then the centre's parabola meets the offset curve.
    r, depth, k, begin, v0 = 0.05, 0.3, 3.0, -0.5, 3.5
    track = Curve(lambda s: (s, depth * c.cos(k * s)), domain=(-3, 4))
    case = Case(track, disc(r, 1.0), (*GRIP, Flight()), Start(begin, slip=v0), 3.0)
    answer = solve(case)
    assert [t.after for t in answer.transitions] == [Mode.FLIGHT] and answer.status == "landing"

    def centre(s):
        return track.point(s) + r * track.normal(s)

    def speed(s):
        return sqrt(v0**2 + 2 * G * (centre(begin)[1] - centre(s)[1]))

    def normal_force(s):
        bend = -float(track.curvature(s))
        return G * track.normal(s)[1] - speed(s) ** 2 * bend / (1 + bend * r)

    leaves = brentq(normal_force, begin, 0.0, xtol=1e-15)
    common = dict(case="crest to slope", solver="reference", route="best", tolerance=TIGHT)
    accuracy(**common, quantity="place of lift-off / m", error=answer.transitions[0].xi1 - leaves)
    (x, y), (vx, vy) = centre(leaves), speed(leaves) * track.tangent(leaves)

    def meets(unknown):
        t, s = unknown
        return [x + vx * t, y + vy * t - G * t * t / 2] - centre(s)

    flight = answer.t[-1] - answer.transitions[0].time
    exact, _ = fsolve(meets, [flight, x + vx * flight], xtol=1e-13)
    assert exact > 0.1
    accuracy(**common, quantity="duration of flight / s", error=flight - exact)


def test_disc_that_falls_off_the_top_of_a_circle_lands_where_its_parabola_crosses_it():
    case = Case(circle(1.0), disc(0.1, 1.0), (*GRIP, Flight()), Start(-pi / 2, slip=sqrt(4.5 * G * 0.9)), 3.0)
    answer = solve(case)
    start = answer.transitions[0].time
    x, y, _, vx, vy, *_ = answer(start)
    # The parabola osculates the circle of radius 0.9 where it leaves: |r + v t + g t²/2|² − 0.81 = t³ (…) exactly.
    quartic = np.polynomial.Polynomial([x, vx]) ** 2 + np.polynomial.Polynomial([y, vy, -G / 2]) ** 2
    exact = -quartic.coef[3] / quartic.coef[4]
    assert answer.t[-1] - start == pytest.approx(exact, abs=TIGHT)


def test_a_plate_that_flies_past_the_end_of_an_open_track_falls():
    track = Curve(lambda s: (s, 0), domain=(-0.5, 0.5))
    case = Case(track, disc(0.1, 1.0), (*GRIP, Flight()), Start(0.0, slip=4.0, gap_rate=1.5), 1.0)
    answer = solve(case)
    assert answer.status == "completed"
    assert answer(1.0).y < -1


@pytest.mark.slow
def test_every_landing_is_a_touch_and_no_pose_before_it_overlaps():
    rng = np.random.default_rng(7)
    plate = Plate(ellipse(0.12, 0.05), 1.0, 0.003)
    track = cosine(0.3, 3.0, reach=3.0)
    for _ in range(6):
        there = dict(xi1=rng.uniform(-1, 1), xi2=-pi / 2 + rng.uniform(-1, 1), gap=0.02)
        start = Start(**there, slip=rng.uniform(-2, 2), omega=rng.uniform(-9, 9), gap_rate=2.0)
        case = Case(track, plate, (*GRIP, Flight()), start, 2.0)
        answer = solve(case)
        times = np.linspace(0, answer.t[-1], 12)
        now = answer(times)
        assert answer.status == "landing"
        # The oracle: distances of a dense sample of the outline from the nearest of a dense sample of the track.
        s, u = np.linspace(-3, 3, 3001), np.linspace(0, 2 * pi, 241)
        (X, Y), (nx, ny), (a, b) = track.point(s), track.normal(s), plate.outline.point(u)
        for i, (x, y, theta) in enumerate(zip(now.x, now.y, now.theta, strict=True)):
            px, py = x + np.cos(theta) * a - np.sin(theta) * b, y + np.sin(theta) * a + np.cos(theta) * b
            near = np.argmin((px[:, None] - X) ** 2 + (py[:, None] - Y) ** 2, axis=1)
            lowest = np.min((px - X[near]) * nx[near] + (py - Y[near]) * ny[near])
            # Samples at most 2 mm apart miss the closest pair by their sagitta, κ (1 mm)²/2 = 0.03 mm at κ = 48 1/m.
            assert lowest > -5e-5
            assert lowest < 5e-5 or i < len(times) - 1


@pytest.mark.parametrize("slope", [0.3, 1.2, 1.5])
def test_perfectly_rough_disc_rolls_down_any_incline(slope):
    answer = solve(Case(line(slope), disc(0.1, 2.0), (*GRIP, PerfectlyRough()), Start(0.0), 1.0))
    assert not answer.transitions
    assert np.hypot(answer(1.0).vx, answer(1.0).vy) == pytest.approx(G * sin(slope) / 1.5, rel=TIGHT)


def test_load_acts_in_flight_and_brings_the_plate_down_at_its_own_time():
    # Wind from above: m ÿ = −m g − 5, a moment that turns it, and drag along x that leaves vx₀ e^(−t/2).
    effects, start = (*GRIP, Flight(), Load(fx="-vx", fy=-5, moment=0.03)), Start(0.0, gap=0.4, slip=1.0, gap_rate=1.0)
    case = Case(line(), disc(0.1, 2.0), effects, replace(start, omega=-2.0), 3.0)
    answer, begin, a = solve(case), start_motion(case), G + 2.5
    assert answer.status == "landing"
    assert answer.t[-1] == pytest.approx((1 + sqrt(1 + 2 * a * 0.4)) / a, abs=TIGHT)
    now, x = answer(0.3), begin.x + 2 * begin.vx * (1 - exp(-0.15))
    exact = x, begin.vx * exp(-0.15), -2 + 3 * 0.3, begin.theta - 0.6 + 1.5 * 0.09
    assert (now.x, now.vx, now.omega, now.theta) == pytest.approx(exact, abs=TIGHT)


def test_bilateral_guide_carries_a_bead_over_the_top_where_the_unilateral_one_lets_go():
    # Without friction v² = v₀² − 2 g L (1 + sin ξ₁). It goes over the top from 4 g L on; N ≥ 0 there asks for 5 g L.
    L, start = 0.9, Start(-pi / 2, slip=sqrt(4.5 * G * 0.9))
    free, guide = (solve(Case(circle(1.0), disc(0.1, 1.0), e, start, 1.5)) for e in (GRIP, GRIP[:1]))
    # N = m (v²/L − g sin ξ₁) vanishes at sin ξ₁ = 2.5/3.
    assert [t.after for t in free.transitions] == [Mode.FLIGHT]
    assert sin(free.transitions[0].xi1) == pytest.approx(2.5 / 3, abs=TIGHT)
    now = guide(np.linspace(0, 1.5, 7))
    assert guide.status == "completed" and not guide.transitions and now.xi1[-1] > pi / 2 + 0.1
    assert now.vx**2 + now.vy**2 == pytest.approx(4.5 * G * L - 2 * G * L * (1 + np.sin(now.xi1)), abs=1e-11)
