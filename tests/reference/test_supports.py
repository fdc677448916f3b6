"""Supports: ladders, blocks and discs on several fixed curves, against exact motions."""

from functools import lru_cache
from math import cos, hypot, pi, sin, sqrt, tan

import mpmath as mp
import numpy as np
import pytest

import cases
import reference
from cases import Case, CoulombFriction, Impact, Mode, PerfectlyRough, StartPose, Support, disc
from cases.library import line
from cases.motion.mechanics import energy
from tests.sampling import quick_every
from tests.scenes.supports import FREE, INELASTIC, G, events

# --- the ladder -------------------------------------------------------------------------------------------------------


@lru_cache
def ladder_times(angle: float, half: float = 1.0) -> tuple[float, float]:
    """When a frictionless ladder leaves the wall, and when it lies on the floor.

    With its centre at half·(cos θ, sin θ): θ̇² = (3 g/2 half)(sin θ₀ − sin θ) by its energy. The wall's force
    m half d²cos θ/dt² vanishes where sin θ = (2/3) sin θ₀. Then the velocity along the floor stays.
    """
    with mp.workdps(30):
        g, a, start = mp.mpf(G), mp.mpf(half), mp.mpf(angle)
        high, rate = mp.sin(start), 3 * g / (2 * a)
        end = mp.asin(2 * high / 3)

        def slow(v):  # θ = θ₀ − v² removes the root at the start
            return 2 * v / mp.sqrt(rate * (high - mp.sin(start - v * v))) if v else 2 / mp.sqrt(rate * mp.cos(start))

        leave = mp.quad(slow, mp.linspace(0, mp.sqrt(start - end), 4))
        along = a * mp.sin(end) * mp.sqrt(rate * (high - mp.sin(end)))
        total = g * a * high - along**2 / 2

        def rest(theta):
            return 1 / mp.sqrt((total - g * a * mp.sin(theta)) / (a * a * (mp.cos(theta) ** 2 / 2 + mp.mpf(1) / 6)))

        return float(leave), float(leave + mp.quad(rest, mp.linspace(0, end, 4)))


@quick_every(3)
@pytest.mark.parametrize("method", reference.METHODS)
@pytest.mark.parametrize("name", ["ladder_at_wall", "round_ladder_at_wall"])
def test_a_ladder_without_friction_leaves_the_wall_at_two_thirds_of_its_height(name, method):
    motion = reference.simulate(cases.load(name, angle=1.2), rtol=1e-14, method=method)
    leave, floor = ladder_times(1.2)
    assert events(motion) == [
        ("plate/wall", Mode.SLIDE, Mode.FLIGHT), ("plate/track 2", Mode.FLIGHT, Mode.SLIDE),
    ]  # fmt: skip
    assert [t.time for t in motion.transitions] == pytest.approx([leave, floor], abs=1e-12)
    theta = pi - motion(motion.transitions[0].time).theta
    assert sin(theta) == pytest.approx(2.0 / 3.0 * sin(1.2), abs=1e-12)


def test_a_ladder_whose_ends_slide_with_friction_leaves_the_wall_in_time():
    # N₁ on the floor, N₂ on the wall, friction μ₁ N₁ and μ₂ N₂ against the motion; moments about the centre:
    # J θ̈ = a (μ₁ N₁ s − N₁ c) + a (N₂ s + μ₂ N₂ c) with the ladder's angle θ, s = sin θ, c = cos θ; the centre is at
    # a (c, s). Three linear equations give θ̈ as a function of θ and W = θ̇², and dW/dθ = 2 θ̈ is linear in W.
    mu, mu_wall, angle = 0.1, 0.2, 1.2
    motion = reference.simulate(cases.load("ladder_at_wall", angle=angle, mu=mu, mu_wall=mu_wall), rtol=1e-14)
    first = motion.transitions[0]
    assert (first.contact, first.before, first.after) == ("plate/wall", Mode.SLIP_FORWARD, Mode.FLIGHT)

    def forces(theta: float, W: float) -> np.ndarray:
        """θ̈, N₁, N₂."""
        s, c = sin(theta), cos(theta)
        matrix = [[-s, mu, -1.0], [c, -1.0, -mu_wall], [1.0 / 3.0, c - mu * s, -s - mu_wall * c]]
        return np.linalg.solve(matrix, [c * W, s * W - G, 0.0])

    from scipy.integrate import quad, solve_ivp
    from scipy.optimize import brentq

    law = solve_ivp(
        lambda u, W: [-2.0 * forces(angle - u, W[0])[0]], (0.0, 1.0), [0.0], method="DOP853", rtol=1e-13, atol=1e-15,
        dense_output=True,
    )  # fmt: skip
    end = brentq(lambda u: forces(angle - u, law.sol(u)[0])[2], 0.1, 1.0, xtol=1e-15)

    def slow(v: float) -> float:
        start = 2.0 / sqrt(-2.0 * forces(angle, 0.0)[0])
        return 2.0 * v / sqrt(law.sol(v * v)[0]) if v > 1e-4 else start

    leave = quad(slow, 1e-4, sqrt(end), epsabs=1e-13, epsrel=1e-13)[0] + 1e-4 * slow(0.0)
    assert first.time == pytest.approx(leave, abs=1e-9)  # the quadrature's start: slow varies by 1e-5 there
    assert pi - motion(first.time).theta == pytest.approx(angle - end, abs=1e-11)


# --- blocks -----------------------------------------------------------------------------------------------------------


def test_a_block_on_an_incline_slides_by_its_friction():
    motion = reference.simulate(cases.load("block_on_incline", slope=0.3, mu=0.2))
    way = 0.5 * G * (sin(0.3) - 0.2 * cos(0.3))
    start, end = motion(0.0), motion(1.0)
    assert hypot(end.x - start.x, end.y - start.y) == pytest.approx(way, rel=1e-13)
    assert abs(end.omega) < 1e-14 and not motion.transitions
    # Which corner is which depends on the order of the outline's corners: the front one has more load.
    sign = 1.0 if motion.contacts["plate/track"].xi1[0] < motion.contacts["plate/track 2"].xi1[0] else -1.0
    rear, front = (motion.contacts[name].normal_force[0] for name in ("plate/track", "plate/track 2"))
    assert rear + front == pytest.approx(G * cos(0.3), rel=1e-12)
    assert front - rear == pytest.approx(
        2.0 * sign * 0.2 * G * cos(0.3), rel=1e-12
    )  # moments: μ N h = (N₂ − N₁) width/2


@pytest.mark.parametrize(("slope", "mu"), [(0.3, 0.35), (0.44, 0.9)])
def test_a_block_on_an_incline_rests_below_both_limits(slope, mu):
    motion = reference.simulate(cases.load("block_on_incline", slope=slope, mu=mu))
    assert motion.status == "completed" and not motion.transitions and motion(1.0).x == motion(0.0).x
    ranges = motion.contacts["plate/track"]
    assert ranges.normal_range[0, 0] == pytest.approx(ranges.normal_range[1, 0])  # of the normal forces both are unique
    assert ranges.friction_range[0, 0] < ranges.friction_range[1, 0]


def test_a_block_on_an_incline_tips_as_a_pendulum_about_its_corner():
    # The corner at (b, −h) from the centre sticks: (4/3)(b² + h²) φ̈ = g (h sin β − b cos β), β = slope + φ.
    slope, b, h = 0.6, 0.5, 1.0
    motion = reference.simulate(cases.load("block_on_incline", slope=slope, mu=0.9), rtol=1e-14)
    inertia = 4.0 / 3.0 * (b * b + h * h)
    for t in (0.3, 0.6, 0.9):
        now = motion(t)
        beta = -now.theta
        fall = b * (sin(slope) - sin(beta)) + h * (cos(slope) - cos(beta))
        assert now.omega**2 * inertia == pytest.approx(2.0 * G * fall, rel=1e-12)
    assert motion.transitions[0].time > 0.9 and motion.transitions[0].before is Mode.ROLL


def test_a_block_on_an_incline_slides_and_tips():
    # On the front corner with friction μ N: J ω̇ = N (μ h − b) with J = (b² + h²)/3, and N = g cos α + b ω̇.
    slope, mu, b, h = 0.6, 0.52, 0.5, 1.0
    motion = reference.simulate(cases.load("block_on_incline", slope=slope, mu=mu))
    own = (b * b + h * h) / 3.0
    normal = G * cos(slope) / (1.0 - b * (mu * h - b) / own)
    now = motion.contact_columns("plate/track", np.array([0.0]))
    assert now.normal_force[0] == pytest.approx(normal, rel=1e-12)
    assert now.friction_force[0] == pytest.approx(-mu * normal, rel=1e-12)
    assert motion.first_mode is Mode.SLIP_FORWARD and motion(0.1).omega < 0.0


def test_a_rocking_block_loses_spin_as_housner_found():
    motion = reference.simulate(cases.load("rocking_block", duration=4.0), rtol=1e-14)
    jumps = np.flatnonzero((np.diff(motion.t) == 0.0) & (np.abs(np.diff(motion.omega)) > 1e-9))[:6]
    factor = 1.0 - 1.5 * (0.25**2 / (1.0 + 0.25**2))
    assert len(jumps) == 6
    assert motion.omega[jumps + 1] / motion.omega[jumps] == pytest.approx([factor] * 6, rel=1e-11)
    total = energy(motion.case, motion)
    for first, last in zip(jumps[:-1] + 1, jumps[1:], strict=True):
        assert np.ptp(total[first : last + 1]) < 1e-12 * total[0]


# --- discs ------------------------------------------------------------------------------------------------------------


def test_a_disc_that_spins_in_a_v_stops_in_time():
    motion = reference.simulate(cases.load("disc_spinning_in_v"), rtol=1e-14)
    stop = 0.5 * 20.0 * (1.0 + 0.3**2) * cos(pi / 6) / (2.0 * 0.3 * G)
    assert {t.contact for t in motion.transitions} == {"plate/track", "plate/right"}
    assert [t.time for t in motion.transitions] == pytest.approx([stop] * 2, abs=1e-12)


def test_a_disc_rocks_in_a_v_by_the_exact_factor_and_times():
    # Every hand-over multiplies the spin by (1 + 2 cos 2α)/3; between two the disc rolls with 2 g sin α/3.
    alpha, r, way = pi / 9, 0.5, 0.3
    flank = r * tan(alpha) + way  # the contact's way from the bottom of the V
    start = StartPose(-flank * cos(alpha) + r * sin(alpha), flank * sin(alpha) + r * cos(alpha))
    effects = (*INELASTIC, CoulombFriction(1.0))
    case = Case(line(alpha), disc(r, 1.0), effects, start, 6.0, supports=(Support(line(-alpha), "right"),))
    motion = reference.simulate(case, rtol=1e-14)
    slope = 2.0 * G * sin(alpha) / 3.0
    factor, speed, time, times = (1 + 2 * cos(2 * alpha)) / 3, sqrt(2 * slope * way), sqrt(2 * way / slope), []
    for _ in range(20):
        times.append(time)
        speed *= factor
        time += 2.0 * speed / slope
    impacts = sorted({t.time for t in motion.transitions})[:20]
    jumps = np.flatnonzero((np.diff(motion.t) == 0.0) & (np.abs(np.diff(motion.omega)) > 1e-9))[:20]
    assert len(jumps) == 20
    assert motion.t[jumps] == pytest.approx(times, abs=1e-12)
    assert motion.omega[jumps + 1] / motion.omega[jumps] == pytest.approx([factor] * 20, rel=1e-12)
    assert impacts == pytest.approx(times, abs=1e-12)


def test_each_support_has_its_own_restitution_and_friction():
    # A disc thrown against a wall, then onto the floor: without friction each impact turns one velocity around.
    wall = Support(line(pi / 2), "wall", effects=(Impact(0.8),))
    case = Case(line(), disc(0.1, 1.0), (*FREE, Impact(0.5)), StartPose(0.6, 0.3, vx=-4.0), 0.4, supports=(wall,))
    motion = reference.simulate(case, rtol=1e-14)
    assert [t.contact for t in motion.transitions] == ["plate/wall", "plate/track"]
    assert motion.transitions[0].time == pytest.approx(0.125, abs=1e-14)
    assert motion.transitions[1].time == pytest.approx(sqrt(0.4 / G), abs=1e-14)
    assert motion(0.4).vx == pytest.approx(3.2, rel=1e-13)
    assert motion(0.4).vy == pytest.approx(0.5 * sqrt(0.4 * G) - G * (0.4 - sqrt(0.4 / G)), rel=1e-12)
    rough = Support(line(pi / 2), "wall", effects=(PerfectlyRough(), Impact(0.8, "poisson")))
    case = Case(
        line(), disc(0.1, 1.0), (*FREE, Impact(0.5)), StartPose(0.6, 0.5, vx=-4.0, vy=1.0), 0.2, supports=(rough,)
    )
    spun = reference.simulate(case)
    after = spun(0.2)  # a rough impact makes a disc roll: a third of its speed along the wall goes into the spin
    before = 1.0 - G * 0.125
    assert after.vy + G * 0.075 == pytest.approx(2.0 / 3.0 * before, rel=1e-12)
    assert 0.1 * after.omega == pytest.approx(after.vy + G * 0.075, rel=1e-12)
