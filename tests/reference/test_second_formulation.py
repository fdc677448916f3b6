"""The second formulation on its own, against exact values: loads, rolling resistance, guides, rough contact, flight.

Impacts and bounces have a file of their own, `test_second_impacts.py`. Closed forms are derived where they stand.
"""

from math import atan, cos, exp, pi, sin, sqrt

import numpy as np
import pytest
from scipy.optimize import brentq, fsolve

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
    RollingResistance,
    Start,
    Unilateral,
    disc,
)
from cases import curves as c
from cases.contact import start_motion
from cases.library import circle, cosine, ellipse, line
from tests.scenes import second as second_states

G = 9.81
# Two integrations of a second or two at 1e-13, relative to values of the order of one.
TIGHT = 1e-12


def solve(case: Case, times=()):
    return second_states.solve(case, rtol=1e-13, times=times)


def modes(answer) -> list[tuple[Mode, Mode]]:
    return [(t.before, t.after) for t in answer.transitions]


def on_line(*effects, slope=0.0, duration=1.0, plate=None, **start) -> Case:
    return Case(line(slope), plate or disc(0.1, 2.0), effects, Start(0.0, **start), duration)


GRIP = (Gravity(G), Unilateral())


# --- rolling resistance and static friction ---------------------------------------------------------------------------


def test_rolling_resistance_stops_a_disc_on_a_level_line_for_good(accuracy):
    # About the contact, (J + m r²) ω̇ = arm m g: for a homogeneous disc |ω̇| = arm g/(3 r²/2), so it stops after t_s.
    r, arm, omega = 0.1, 0.01, 5.0
    stop = 1.5 * r**2 * omega / (arm * G)
    case = on_line(*GRIP, CoulombFriction(0.3), RollingResistance(arm), omega=-omega, duration=3.0)
    times = np.array([0.5, stop + 0.1, 3.0])
    answer = solve(case, times)
    assert modes(answer) == [(Mode.ROLL, Mode.REST)]
    common = dict(case="rolling resistance on a line", solver="reference", route="contact_frame")
    accuracy(**common, quantity="stopping time / s", error=answer.transitions[0].time - stop, tolerance=TIGHT)
    x, omega_now = answer.motions[0], answer.motions[5]
    assert omega_now[0] == pytest.approx(-omega * (1 - 0.5 / stop), abs=TIGHT)
    assert x[1:] == pytest.approx(0.5 * r * omega * stop, abs=TIGHT)
    assert not omega_now[1:].any()


@pytest.mark.parametrize("r, arm", [(0.1, 0.01), (0.3, 0.05)])
def test_resisted_disc_sticks_on_an_incline_up_to_tan_equal_arm_over_radius_and_rolls_beyond(r, arm):
    # At rest the couple about the contact is m g r sin α against at most arm m g cos α.
    for slope, mode in ((atan(arm / r) - 1e-9, Mode.REST), (atan(arm / r) + 1e-9, Mode.ROLL)):
        case = on_line(*GRIP, CoulombFriction(0.5), RollingResistance(arm), slope=slope, plate=disc(r, 2.0))
        answer = solve(case, [1.0])
        assert not answer.transitions
        moved = abs(answer.motions[5, 0]) > 0
        assert moved == (mode is Mode.ROLL)
    steep = atan(arm / r) + 0.1
    answer = solve(on_line(*GRIP, CoulombFriction(0.5), RollingResistance(arm), slope=steep, plate=disc(r, 2.0)), [1.0])
    assert answer.motions[5, 0] == pytest.approx(-G * (sin(steep) - arm / r * cos(steep)) / (1.5 * r), rel=TIGHT)


def test_growing_push_turns_a_resisted_disc_when_its_moment_exceeds_the_couple():
    # fx = p t at the height r of the centre: turning begins at p t r = arm m g, if the cone is wide enough.
    r, arm, p = 0.1, 0.01, 4.0
    case = on_line(*GRIP, CoulombFriction(0.5), RollingResistance(arm), Load(fx=f"{p}*t"), duration=2.0)
    answer = solve(case, [2.0])
    begins = arm * 2.0 * G / (p * r)
    assert modes(answer) == [(Mode.REST, Mode.ROLL)]
    assert answer.transitions[0].time == pytest.approx(begins, abs=TIGHT)
    # From then on 3/2 m a = p (t − t₀), which is the push less the couple's share.
    assert answer.motions[3, 0] == pytest.approx(p * (2.0 - begins) ** 2 / 2 / (1.5 * 2.0), rel=1e-11)


def test_push_that_exceeds_the_cone_first_makes_a_resisted_disc_slide_without_turning():
    # The couple can hold: arm N > r T for T = mu N, as arm/r = 0.5 > mu_static = 0.3. The plate slides like a block.
    mu, static, p = 0.2, 0.3, 10.0
    case = on_line(*GRIP, CoulombFriction(mu, static), RollingResistance(0.05), Load(fx=f"{p}*t"), duration=1.0)
    answer = solve(case, [1.0])
    begins = static * 2.0 * G / p
    assert modes(answer) == [(Mode.REST, Mode.SLIP_FORWARD)]
    assert answer.transitions[0].time == pytest.approx(begins, abs=TIGHT)
    speed = p * (1.0 - begins**2) / 4.0 - mu * G * (1.0 - begins)
    assert answer.motions[[3, 5], 0] == pytest.approx([speed, 0.0], abs=TIGHT)


@pytest.mark.parametrize("mu, static", [(0.1, 0.25), (0.3, 0.3), (0.2, 0.6)])
def test_disc_at_rest_rolls_down_up_to_tan_equal_three_mu_static_and_slips_with_mu_beyond(mu, static):
    # Rolling takes T = m g sin α/3; the cone is mu_static m g cos α.
    limit = atan(3 * static)
    for slope, rolls in ((limit - 1e-9, True), (limit + 1e-9, False)):
        case = on_line(*GRIP, CoulombFriction(mu, static), slope=slope)
        slip = solve(case, [1.0]).motions[6, 0]
        if rolls:
            assert slip == 0.0
        else:
            # v̇ = g sin α − mu g cos α (1 + m r²/J); for mu = mu_static it vanishes with the distance from the limit.
            assert slip == pytest.approx(G * (sin(slope) - 3 * mu * cos(slope)), abs=TIGHT)
            assert slip > 0


@pytest.mark.parametrize("static", [0.3, 0.5])
def test_block_held_by_its_flat_foot_slides_beyond_tan_equal_mu_static(static):
    # A large arm keeps the disc from turning: Coulomb's block on an incline, with its threshold to 1e-9.
    for slope, rests in ((atan(static) - 1e-9, True), (atan(static) + 1e-9, False)):
        case = on_line(*GRIP, CoulombFriction(0.2, static), RollingResistance(0.2), slope=slope)
        answer = solve(case, [1.0])
        exact = 0.0 if rests else G * (sin(slope) - 0.2 * cos(slope))
        assert answer.motions[[5, 6], 0] == pytest.approx([0.0, exact], abs=TIGHT)


# --- perfectly rough --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("slope", [0.3, 1.2, 1.5])
def test_perfectly_rough_disc_rolls_down_any_incline(slope):
    answer = solve(on_line(*GRIP, PerfectlyRough(), slope=slope), [1.0])
    assert not answer.transitions
    assert np.hypot(*answer.motions[3:5, 0]) == pytest.approx(G * sin(slope) / 1.5, rel=TIGHT)
    assert answer.motions[6, 0] == 0.0


# --- loads ------------------------------------------------------------------------------------------------------------


def test_time_dependent_load_moves_a_plate_by_its_double_integral():
    # m ẍ = 3 sin 4t from rest: x = 3/(4 m) (t − sin(4t)/4).
    case = on_line(*GRIP, Load(fx="3*sin(4*t)"), duration=2.0)
    t = np.linspace(0, 2, 9)
    x = solve(case, t).motions[0]
    assert x == pytest.approx(3 / (4 * 2.0) * (t - np.sin(4 * t) / 4), abs=TIGHT)


def test_spring_and_damper_make_a_rolling_disc_a_damped_oscillator():
    # 3/2 m ẍ = −k x − d ẋ while it rolls.
    m, k, d, v0 = 2.0, 30.0, 1.5, 0.5
    case = on_line(*GRIP, CoulombFriction(0.9), Load(fx=f"-{k}*x - {d}*vx"), omega=-v0 / 0.1, duration=3.0)
    t = np.linspace(0, 3, 7)
    decay, omega = d / (3 * m), sqrt(k / (1.5 * m) - (d / (3 * m)) ** 2)
    answer = solve(case, t)
    assert not answer.transitions
    assert answer.motions[0] == pytest.approx(v0 / omega * np.exp(-decay * t) * np.sin(omega * t), abs=TIGHT)


@pytest.mark.slow
def test_torsion_spring_swings_a_frictionless_disc_through_several_turns():
    # J θ̈ = −κ θ: a swing of some ten radians, so that θ has to be the continuous angle.
    case = on_line(*GRIP, Load(moment="-0.04*theta"), omega=20.0, duration=4.0)
    t = np.linspace(0, 4, 9)
    start = start_motion(case).theta
    omega = sqrt(0.04 / 0.01)
    theta = solve(case, t).motions[2]
    assert theta == pytest.approx(start * np.cos(omega * t) + 20 / omega * np.sin(omega * t), abs=1e-11)
    assert np.ptp(theta) > 2 * pi


def test_load_acts_in_flight_and_brings_the_plate_down_at_its_own_time():
    # Wind from above: m ÿ = −m g − 5, a moment that turns it, and drag along x that leaves vx₀ e^(−t/2).
    case = on_line(
        *GRIP, Flight(), Load(fx="-vx", fy=-5, moment=0.03), gap=0.4, slip=1.0, gap_rate=1.0, omega=-2.0, duration=3.0
    )
    answer = solve(case, [0.3])
    a = G + 2.5
    assert answer.status == "landing"
    assert answer.end == pytest.approx((1 + sqrt(1 + 2 * a * 0.4)) / a, abs=TIGHT)
    begin = start_motion(case)
    x = begin.x + 2 * begin.vx * (1 - exp(-0.15))
    assert answer.motions[[0, 3, 5, 2], 0] == pytest.approx(
        [x, begin.vx * exp(-0.15), -2 + 3 * 0.3, begin.theta - 0.6 + 1.5 * 0.09], abs=TIGHT
    )


# --- bilateral guides -------------------------------------------------------------------------------------------------


def loop(*effects, speed: float, mu: float = 0.0) -> Case:
    """A disc thrown along the bottom of a circle, without spin."""
    friction = (CoulombFriction(mu),) if mu else ()
    return Case(circle(1.0), disc(0.1, 1.0), (Gravity(G), *friction, *effects), Start(-pi / 2, slip=speed), 1.5)


def test_bilateral_guide_carries_a_bead_over_the_top_where_the_unilateral_one_lets_go():
    # Without friction v² = v₀² − 2 g L (1 + sin ξ₁). It goes over the top from 4 g L on; N ≥ 0 there asks for 5 g L.
    L = 0.9
    speed = sqrt(4.5 * G * L)
    released = solve(loop(Unilateral(), speed=speed))
    assert modes(released) == [(Mode.SLIDE, Mode.FLIGHT)]
    # N = m (v²/L − g sin ξ₁) vanishes at sin ξ₁ = 2.5/3.
    assert sin(released.transitions[0].xi1) == pytest.approx(2.5 / 3, abs=TIGHT)
    t = np.linspace(0, 1.5, 7)
    guided = solve(loop(speed=speed), t)
    assert guided.status == "completed" and not guided.transitions
    assert guided.states[0, -1] > pi / 2 + 0.1
    assert np.sum(guided.motions[3:5] ** 2, axis=0) == pytest.approx(
        speed**2 - 2 * G * L * (1 + np.sin(guided.states[0])), abs=1e-11
    )


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
    answer = solve(loop(speed=speed, mu=mu), np.linspace(0, 1.5, 16))
    assert answer.status == "completed" and not answer.transitions
    xi, slip = answer.states[0], answer.states[3]
    assert slip.min() > 0.1 and xi[-1] > second + 0.5
    exact = np.where(xi < first, rising(xi), np.where(xi < second, pulled(xi), falling(xi)))
    worst = np.max(np.abs(np.sum(answer.motions[3:5] ** 2, axis=0) / L**2 - exact))
    accuracy(
        case="bilateral loop, mu=0.02", solver="reference", route="contact_frame",
        quantity="square of angular speed / rad²/s²", error=worst, tolerance=1e-10,
    )  # fmt: skip


# --- flight and landing -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("slope", [0.0, 0.4])
def test_ski_jump_lands_after_twice_the_normal_velocity_over_the_normal_gravity(slope):
    case = on_line(*GRIP, Flight(), slope=slope, slip=3.0, gap_rate=2.0, omega=-15.0, duration=3.0)
    answer = solve(case)
    assert (answer.status, answer.transitions) == ("landing", ())
    assert answer.end == pytest.approx(4.0 / (G * cos(slope)), abs=TIGHT)


def test_disc_leaving_a_crest_lands_on_the_next_slope_where_its_parabola_meets_it(accuracy):
    # It slides without friction up to the crest of y = 0.3 cos 3x: v² = v₀² − 2 g (rise of the centre), and leaves
    # where g cos φ = v² κ/(1 + κ r), κ the crest's curvature. Then the centre's parabola meets the offset curve.
    r, depth, k, begin, v0 = 0.05, 0.3, 3.0, -0.5, 3.5
    track = Curve(lambda s: (s, depth * c.cos(k * s)), domain=(-3, 4))
    case = Case(track, disc(r, 1.0), (*GRIP, Flight()), Start(begin, slip=v0), 3.0)
    answer = solve(case)
    assert modes(answer) == [(Mode.SLIDE, Mode.FLIGHT)] and answer.status == "landing"

    def centre(s):
        return track.point(s) + r * track.normal(s)

    def speed(s):
        return sqrt(v0**2 + 2 * G * (centre(begin)[1] - centre(s)[1]))

    def normal_force(s):
        bend = -float(track.curvature(s))
        return G * track.normal(s)[1] - speed(s) ** 2 * bend / (1 + bend * r)

    leaves = brentq(normal_force, begin, 0.0, xtol=1e-15)
    common = dict(case="crest to slope", solver="reference", route="contact_frame", tolerance=TIGHT)
    accuracy(**common, quantity="place of lift-off / m", error=answer.transitions[0].xi1 - leaves)
    (x, y), (vx, vy) = centre(leaves), speed(leaves) * track.tangent(leaves)

    def meets(unknown):
        t, s = unknown
        return [x + vx * t, y + vy * t - G * t * t / 2] - centre(s)

    flight = answer.end - answer.transitions[0].time
    exact, _ = fsolve(meets, [flight, x + vx * flight], xtol=1e-13)
    assert exact > 0.1
    accuracy(**common, quantity="duration of flight / s", error=flight - exact)


def tumbling(omega: float) -> Case:
    plate = Plate(ellipse(0.3, 0.1), 1.0, 0.025)
    return on_line(
        *GRIP, Flight(), plate=plate, xi2=-pi / 2 + 0.3, gap=1.0, gap_rate=1.0, slip=0.5, omega=omega, duration=3.0
    )


@pytest.mark.parametrize("omega", [-11.0, 0.5, 7.0, 40.0])
def test_tumbling_ellipse_lands_where_its_support_function_meets_the_line(omega, accuracy):
    # Half its height at the angle θ is √(a² sin²θ + b² cos²θ).
    case = tumbling(omega)
    begin = start_motion(case)

    def height(t):
        theta = begin.theta + omega * t
        return begin.y + begin.vy * t - G * t**2 / 2 - np.sqrt((0.3 * np.sin(theta)) ** 2 + (0.1 * np.cos(theta)) ** 2)

    grid = np.linspace(0, 2, 20001)
    after = grid[np.argmax(height(grid) < 0)]
    exact = brentq(height, after - 1e-4, after, xtol=1e-15)
    answer = solve(case)
    assert answer.status == "landing"
    accuracy(
        case=f"tumbling ellipse, {omega:g} rad/s", solver="reference", route="contact_frame",
        quantity="landing / s", error=answer.end - exact, tolerance=TIGHT,
    )  # fmt: skip


def test_disc_thrown_across_a_valley_lands_on_its_far_side():
    track = cosine(0.5, 2.0, reach=2.0)
    case = Case(track, disc(0.1, 1.0), (*GRIP, Flight()), Start(-1.2, slip=0.3, gap_rate=4.5), 3.0)
    answer = solve(case)
    begin = start_motion(case)

    def meets(unknown):
        t, s = unknown
        flown = [begin.x + begin.vx * t, begin.y + begin.vy * t - G * t * t / 2]
        return flown - (track.point(s) + 0.1 * track.normal(s))

    exact, place = fsolve(meets, [answer.end, begin.x + begin.vx * answer.end], xtol=1e-13)
    assert answer.status == "landing"
    assert answer.end == pytest.approx(exact, abs=TIGHT)
    assert place > 0.3


def test_disc_that_falls_off_the_top_of_a_circle_lands_where_its_parabola_crosses_it():
    case = Case(circle(1.0), disc(0.1, 1.0), (*GRIP, Flight()), Start(-pi / 2, slip=sqrt(4.5 * G * 0.9)), 3.0)
    answer = solve(case)
    start = answer.transitions[0].time
    x, y, _, vx, vy, *_ = solve(case, [start]).motions[:, 0]
    # The parabola osculates the circle of radius 0.9 where it leaves: |r + v t + g t²/2|² − 0.81 = t³ (…) exactly.
    quartic = np.polynomial.Polynomial([x, vx]) ** 2 + np.polynomial.Polynomial([y, vy, -G / 2]) ** 2
    exact = -quartic.coef[3] / quartic.coef[4]
    assert answer.end - start == pytest.approx(exact, abs=TIGHT)


def test_plate_held_off_its_track_flies_on_to_the_end():
    case = on_line(*GRIP, Flight(), Load(fy=3 * G * 2.0), gap=0.01, duration=1.0)
    answer = solve(case, [1.0])
    assert (answer.status, answer.transitions) == ("completed", ())
    assert answer.motions[1, 0] == pytest.approx(0.11 + G, abs=TIGHT)
    assert np.isnan(answer.states[[0, 1, 3], 0]).all() and np.isnan(answer.motions[6, 0])


def test_a_plate_that_flies_past_the_end_of_an_open_track_falls():
    track = Curve(lambda s: (s, 0), domain=(-0.5, 0.5))
    case = Case(track, disc(0.1, 1.0), (*GRIP, Flight()), Start(0.0, slip=4.0, gap_rate=1.5), 1.0)
    answer = solve(case, [1.0])
    assert answer.status == "completed"
    assert answer.motions[1, 0] < -1


@pytest.mark.slow
def test_every_landing_is_a_touch_and_no_pose_before_it_overlaps():
    rng = np.random.default_rng(7)
    plate = Plate(ellipse(0.12, 0.05), 1.0, 0.003)
    track = cosine(0.3, 3.0, reach=3.0)
    for _ in range(6):
        there = dict(xi1=rng.uniform(-1, 1), xi2=-pi / 2 + rng.uniform(-1, 1), gap=0.02)
        start = Start(**there, slip=rng.uniform(-2, 2), omega=rng.uniform(-9, 9), gap_rate=2.0)
        case = Case(track, plate, (*GRIP, Flight()), start, 2.0)
        end = solve(case).end
        times = np.linspace(0, end, 12)
        answer = solve(case, times)
        assert answer.status == "landing"
        # The oracle: distances of a dense sample of the outline from the nearest of a dense sample of the track.
        s, u = np.linspace(-3, 3, 3001), np.linspace(0, 2 * pi, 241)
        (X, Y), (nx, ny), (a, b) = track.point(s), track.normal(s), plate.outline.point(u)
        for i, (x, y, theta) in enumerate(answer.motions[:3].T):
            px, py = x + np.cos(theta) * a - np.sin(theta) * b, y + np.sin(theta) * a + np.cos(theta) * b
            near = np.argmin((px[:, None] - X) ** 2 + (py[:, None] - Y) ** 2, axis=1)
            lowest = np.min((px - X[near]) * nx[near] + (py - Y[near]) * ny[near])
            # Samples at most 2 mm apart miss the closest pair by their sagitta, κ (1 mm)²/2 = 0.03 mm at κ = 48 1/m.
            assert lowest > -5e-5
            assert lowest < 5e-5 or i < len(times) - 1
