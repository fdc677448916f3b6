"""Each effect against something exact, by every method of the reference."""

from math import atan, cos, radians, sin, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

import reference
from cases import (
    Case,
    CoulombFriction,
    Flight,
    Gravity,
    Impact,
    Load,
    Mode,
    PerfectlyRough,
    Plate,
    RollingResistance,
    Start,
    Unilateral,
    disc,
)
from cases.library import ellipse, line
from reference.minimal.impact import ContactVelocity, Law, collide, energy
from tests.sampling import quick_every

G, R, M = 9.81, 0.5, 2.0
METHODS = pytest.mark.parametrize("method", reference.METHODS)
# What the two integrators are good for on motions of a few seconds: their tolerance, and rounding in a few hundred
# operations.
CLOSE = {"taylor": 1e-13, "dop853": 1e-11}


def level(effects, duration=3.0, slope=0.0, plate=None, **start):
    return Case(line(slope), plate or disc(R, M), effects, Start(xi1=0.0, **start), duration)


def modes(motion):
    return [motion.first_mode, *(t.after for t in motion.transitions)]


# --- rolling resistance -----------------------------------------------------------------------------------------------


@METHODS
def test_rolling_resistance_stops_a_rolling_disc_at_its_exact_time_and_holds_it(method):
    arm, omega = 0.01, -2.0
    case = level((Gravity(G), CoulombFriction(0.3), Unilateral(), RollingResistance(arm)), 20.0, omega=omega)
    motion = reference.simulate(case, method=method, rtol=1e-12)
    # Moments about the contact: (J + m r²) ω̇ = m g·arm against ω.
    deceleration = M * G * arm / (0.5 * M * R**2 + M * R**2)
    stop = abs(omega) / deceleration
    assert modes(motion) == [Mode.ROLL, Mode.REST]
    assert motion.transitions[0].time == pytest.approx(stop, rel=CLOSE[method])
    halfway = motion(stop / 2)
    assert halfway.omega == pytest.approx(omega / 2, rel=CLOSE[method])
    assert motion(20.0).x == pytest.approx(R * 0.5 * abs(omega) * stop, rel=1e-11) and motion(20.0).omega == 0.0


def _held(slope, arm=0.02):
    case = level((Gravity(G), CoulombFriction(0.9), Unilateral(), RollingResistance(arm)), 1.0, slope)
    return reference.simulate(case).first_mode is Mode.REST


def test_disc_with_rolling_resistance_stays_on_an_incline_up_to_its_angle():
    threshold = atan(0.02 / R)
    assert _held(threshold * (1 - 1e-9)) and not _held(threshold * (1 + 1e-9))


@METHODS
def test_rolling_resistance_slows_the_spin_of_a_sliding_disc(method):
    arm, mu, slip = 0.03, 0.1, 2.0
    case = level((Gravity(G), CoulombFriction(mu), Unilateral(), RollingResistance(arm)), 2.0, slip=slip)
    motion = reference.simulate(case, method=method, rtol=1e-12)
    # Friction slows the centre and spins the disc up; the couple holds back: ω̇ = −(μ g r − g·arm)/G.
    spin_up = G * (mu * R - arm) / (0.5 * R**2)
    assert motion.transitions[0].time == pytest.approx(slip / (mu * G + spin_up * R), rel=CLOSE[method])
    assert modes(motion)[:2] == [Mode.SLIP_FORWARD, Mode.ROLL]


# --- friction ---------------------------------------------------------------------------------------------------------


def _rolls(slope, static=0.3):
    case = level((Gravity(G), CoulombFriction(0.2, static), Unilateral()), 0.5, slope)
    return reference.simulate(case).first_mode is Mode.ROLL


def test_static_friction_holds_a_rolling_disc_up_to_three_times_its_coefficient():
    # Rolling without slip takes T = m g sin α/3 of a homogeneous disc.
    threshold = atan(3 * 0.3)
    assert _rolls(threshold * (1 - 1e-9)) and not _rolls(threshold * (1 + 1e-9))


# --- loads ------------------------------------------------------------------------------------------------------------


@METHODS
def test_load_in_time_gives_its_integral(method):
    amplitude, w = 3.0, 4.0
    case = level((Gravity(G), Load(fx=f"{amplitude}*sin({w}*t)"), Unilateral()), 2.0)
    motion = reference.simulate(case, method=method, rtol=1e-12)
    t = np.linspace(0.1, 2.0, 7)
    assert motion(t).vx == pytest.approx(amplitude / (M * w) * (1 - np.cos(w * t)), rel=CLOSE[method])
    # The first place is a tenth of the last: its error may be that of the last one.
    exact = amplitude / (M * w) * (t - np.sin(w * t) / w)
    assert motion(t).x == pytest.approx(exact, abs=CLOSE[method] * exact[-1])


@METHODS
def test_load_in_position_velocity_and_angle_is_an_oscillator(method):
    # A rough disc rolls on a line; spring, damper and torsion spring act on one degree of freedom.
    k, d, torsion = 30.0, 1.5, 2.0
    load = Load(fx=f"-{k}*x - {d}*vx", moment=f"-{torsion}*theta")
    case = level((Gravity(G), load, PerfectlyRough(), Unilateral()), 3.0, omega=-2.0)
    motion = reference.simulate(case, method=method, rtol=1e-12)
    inertia = 1.5 * M
    rate, stiffness = d / (2 * inertia), (k + torsion / R**2) / inertia
    w = sqrt(stiffness - rate**2)
    t = np.linspace(0.2, 3.0, 9)
    exact = 2.0 * R / w * np.exp(-rate * t) * np.sin(w * t)
    assert motion(t).x == pytest.approx(exact, abs=10 * CLOSE[method])
    assert motion(t).theta == pytest.approx(-exact / R, abs=10 * CLOSE[method])


# --- flight -----------------------------------------------------------------------------------------------------------


@METHODS
def test_flight_from_a_hill_lands_where_the_parabola_meets_the_slope(method):
    # y = 1/cosh-like hill is no use here: a smooth ramp that ends in a slope known exactly far below.
    case = level((Gravity(G), Unilateral(), Flight()), 5.0, radians(30), gap=0.7, slip=2.0, gap_rate=1.0)
    motion = reference.simulate(case, method=method, rtol=1e-12)
    # In the slope's own axes: gap + lift t − ½ g cos α t² = 0.
    normal = G * cos(radians(30))
    time = (1.0 + sqrt(1.0 + 2 * normal * 0.7)) / normal
    assert motion.status == "landing"
    assert motion.t[-1] == pytest.approx(time, rel=1e-14)


@METHODS
def test_tumbling_ellipse_lands_where_its_support_function_meets_the_line(method):
    a, b, omega, drop = 0.6, 0.2, 3.0, 1.5
    plate = Plate(ellipse(a, b), M, 0.25 * M * (a**2 + b**2))
    case = level((Gravity(G), Unilateral(), Flight()), 3.0, plate=plate, gap=drop, omega=omega)
    motion = reference.simulate(case, method=method, rtol=1e-12)
    vy = motion.vy[0]

    def clearance(t):
        return b + drop + vy * t - 0.5 * G * t**2 - sqrt((a * sin(omega * t)) ** 2 + (b * cos(omega * t)) ** 2)

    first = next(t for t in np.linspace(0, 3, 3001) if clearance(t) < 0)
    assert motion.t[-1] == pytest.approx(brentq(clearance, first - 2e-3, first, xtol=1e-15), rel=1e-13)


# --- impact -----------------------------------------------------------------------------------------------------------


@quick_every(5)
@METHODS
@pytest.mark.parametrize("e", [0.1, 0.5, 0.9])
def test_bouncing_disc_has_a_geometric_series_of_flights_and_its_limit(method, e):
    case = level((Gravity(G), CoulombFriction(0.2), Unilateral(), Flight(), Impact(e)), 10.0, gap=1.0)
    motion = reference.simulate(case, method=method, rtol=1e-12)
    fall = sqrt(2 / G)
    bounces = [t.time for t in motion.transitions if t.after is Mode.FLIGHT]
    exact = fall + 2 * fall * np.array([e * (1 - e**k) / (1 - e) for k in range(len(bounces))])
    assert bounces == pytest.approx(exact, rel=1e-12)
    last = motion.transitions[-1]
    # The instants of the last bounces are known to the rounding of positions over their speeds, some 1e-13 s.
    assert (last.before, last.after) == (Mode.FLIGHT, Mode.ROLL)
    assert last.time == pytest.approx(fall + 2 * fall * e / (1 - e), rel=1e-12)
    assert np.all(motion(np.linspace(last.time, 10.0, 5)).y == R)


def test_inelastic_landing_goes_on_in_contact():
    case = level((Gravity(G), CoulombFriction(0.1), Unilateral(), Flight(), Impact(0.0)), 3.0, gap=1.0, slip=5.0)
    motion = reference.simulate(case, rtol=1e-12)
    fall = sqrt(2 / G)
    assert modes(motion) == [Mode.FLIGHT, Mode.SLIP_FORWARD, Mode.ROLL]
    # The impact takes μ m g t off the centre and spins the disc up, as so much friction would in that time.
    slipped = 5.0 - 3 * 0.1 * G * fall
    assert motion.transitions[1].time == pytest.approx(fall + slipped / (3 * 0.1 * G), rel=1e-13)


def test_bouncing_on_a_slope_comes_to_rest_in_a_slide_with_its_exact_speed():
    slope, e, mu = 0.5, 0.6, 0.05
    case = level((Gravity(G), CoulombFriction(mu), Unilateral(), Flight(), Impact(e)), 3.0, slope, gap=0.4)
    motion = reference.simulate(case, rtol=1e-12)
    fall = sqrt(2 * 0.4 / (G * cos(slope)))
    rest = fall * (1 + 2 * e / (1 - e))
    # Instants of the last bounces: rounding of a position of some metres over a speed of 1e-4 m/s.
    assert motion.transitions[-1].time == pytest.approx(rest, abs=1e-11)
    assert modes(motion)[-1] is Mode.SLIP_FORWARD
    # Slip throughout: the mean normal force is the weight's component, in bounces as at rest; the impulse before the
    # last contact is complete only at the limit.
    end = motion(3.0)
    along = end.vx * cos(slope) - end.vy * sin(slope)
    assert along == pytest.approx(G * (sin(slope) - mu * cos(slope)) * 3.0, rel=1e-11)


def _law(arm_t, arm_n, gyration, mu, e, name="poisson"):
    return Law(arm_t, arm_n, gyration, mu, mu, 0.0, e, name)


def test_newtons_law_would_create_energy_where_friction_reverses_the_slip_and_is_told():
    # An observation ascribed to Kane & Levinson (known to us, not looked up): e as a ratio of velocities, with
    # friction.
    law = _law(-1.0, -0.8, 0.12, 1.0, 0.9, "newton")
    worst = max(
        energy(law, collide(law, ContactVelocity(slip, -1.0, omega))) / energy(law, ContactVelocity(slip, -1.0, omega))
        for slip in np.linspace(-3, 3, 61)
        for omega in np.linspace(-4, 4, 41)
    )
    assert worst > 1.0 + 1e-3


numbers = st.floats(-2.0, 2.0, allow_subnormal=False)


@settings(deadline=None, max_examples=100)
@given(
    arm_t=numbers, arm_n=numbers, gyration=st.floats(0.01, 2.0), mu=st.floats(0.0, 3.0), more=st.floats(1.0, 2.0),
    arm=st.floats(0.0, 1.0), e=st.floats(0.0, 1.0), slip=numbers, lift=st.floats(-3.0, -1e-3), omega=numbers,
)  # fmt: skip
def test_energy_never_grows_through_an_impact_and_the_contact_opens(
    arm_t, arm_n, gyration, mu, more, arm, e, slip, lift, omega
):
    law = Law(arm_t, arm_n, gyration, mu, more * mu, arm, e, "poisson")
    before = ContactVelocity(slip, lift, omega)
    after = collide(law, before)
    assert energy(law, after) <= energy(law, before) * (1 + 1e-12)
    assert after.lift >= 0.0
    assert (
        after.slip * slip >= 0.0 or abs(after.slip) < abs(slip) + abs(after.lift - lift) * (abs(arm_n) + 1) / gyration
    )
