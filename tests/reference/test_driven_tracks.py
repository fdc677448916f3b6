"""Driven tracks: exact values, agreement of three derivations, work, frames, and wrong input."""

from dataclasses import replace
from math import asin, sin

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

import cases
import reference
from cases import (
    Case,
    CoulombFriction,
    Drive,
    Flight,
    Gravity,
    Load,
    Mode,
    RollingResistance,
    Start,
    StartPose,
    Unilateral,
    contact,
    disc,
)
from cases.library import circle, line
from cases.moving_frame import in_track_frame, relative_case
from reference.paper.kinematics import kinematics, slip_vector, slip_vector_of_plate
from tests.authorities.published_numbers.oscillating import BALL, BALL_STEP, ball
from tests.sampling import quick_every
from tests.scenes.moving import EXACT, METHODS, G, M, R, on_line


@quick_every(2)
@METHODS
def test_disc_on_a_plate_has_a_third_of_its_acceleration_where_it_rolls(method):
    """m v̇ = T, J ω̇ = T r and v̇ + r ω̇ = a with J = m r²/2: v̇ = a/3, T = m a/3 ≤ μ m g."""
    case = cases.load("disc_on_accelerated_plate", jerk=4.0, mu=0.2)
    motion = reference.simulate(case, rtol=1e-13, method=method)
    (change,) = motion.transitions
    assert change.time == pytest.approx(3 * 0.2 * G / 4.0, abs=EXACT)
    at = motion(1.2)
    assert at.vx == pytest.approx(4.0 * 1.2**2 / 6, abs=EXACT)
    assert at.friction_force == pytest.approx(M * 4.0 * 1.2 / 3, abs=10 * EXACT)
    assert motion(2.5).friction_force == pytest.approx(0.2 * M * G, abs=EXACT)


@quick_every(3)
@METHODS
def test_shaken_table_lets_go_where_a_third_of_its_acceleration_exceeds_friction(method):
    motion = reference.simulate(cases.load("disc_on_shaken_table"), rtol=1e-13, method=method)
    assert motion.transitions[0].time == pytest.approx(asin(3 * 0.2 * G / (0.05 * 144)) / 12, abs=EXACT)


@quick_every(3)
@METHODS
def test_plate_lifts_off_a_table_that_falls_faster_than_it(method):
    """N = m (g + ÿ) vanishes where amplitude rate² sin(rate t) = g."""
    motion = reference.simulate(cases.load("disc_on_bouncing_table"), rtol=1e-13, method=method)
    change = motion.transitions[0]
    assert change.after is Mode.FLIGHT
    assert change.time == pytest.approx(asin(G / (0.02 * 900)) / 30, abs=EXACT)


@METHODS
def test_resistance_keeps_a_sliding_disc_from_turning_on_a_table_that_swings(method):
    """arm N exceeds the moment μ N r, so θ̇ = α̇. In the table's frame s is the place along it, and from −m (α̈ U r − α̇² r
    + 2 α̇ U ṙ): N/m = g cos α + s α̈ − r α̇² + 2 α̇ ṡ and s̈ = −g sin α + s α̇² + r α̈ − μ N/m, here by SciPy."""
    a, w, mu = 0.2, 3.0, 0.1
    case = on_line(Drive(angle=f"{a}*sin({w}*t)"), RollingResistance(0.05), mu=mu, duration=0.4, slip=1.0, omega=a * w)

    def rates(t, y):
        s, v = y
        angle, spin, swing = a * np.sin(w * t), a * w * np.cos(w * t), -a * w * w * np.sin(w * t)
        normal = G * np.cos(angle) + s * swing - R * spin**2 + 2 * spin * v
        return v, -G * np.sin(angle) + s * spin**2 + R * swing - mu * normal

    exact = solve_ivp(rates, (0.0, 0.4), (0.0, 1.0), "DOP853", rtol=1e-13, atol=1e-14).y[1, -1]
    motion = reference.simulate(case, rtol=1e-12, method=method)
    assert not motion.transitions
    assert motion(0.4).slip == pytest.approx(exact, abs=1e-10)
    assert motion(0.4).omega == pytest.approx(a * w * np.cos(w * 0.4), abs=1e-10)


def test_shaken_track_is_an_inertial_load():
    driven = on_line(Drive(x="0.05*sin(12*t)"))
    loaded = replace(driven, effects=(*driven.effects[:3], Load(fx="1.0*0.05*144*sin(12*t)")))
    there, here = (reference.simulate(case, rtol=1e-13) for case in (driven, loaded))
    assert [t.time for t in there.transitions] == pytest.approx([t.time for t in here.transitions], abs=EXACT)
    assert there(1.9).x - 0.05 * sin(12 * 1.9) == pytest.approx(here(1.9).x, abs=EXACT)


def test_ball_on_the_moving_plane_of_siconos():
    """A ball falls on a plane that rises with 2 + cos(π t/2) m/s, restitution 0.9.

    siconos-tutorials, examples/mechanics/BallOnMovingPlane (looked up): rows of BallOnMovingPlane.ref, the plane's
    velocity in BallOnMovingPlanePlugin.cpp; Moreau's time stepping with h = 5 ms and theta = 1/2. The plane's first row
    has no velocity, so that it lies h·3/2 lower from the first step on. An impact may come one step late, which moves
    what follows by at most h times the jump of the velocity. (All 2,001 rows were compared so.)
    """
    h, low = BALL_STEP, 7.5e-3
    motion = reference.simulate(ball(), rtol=1e-14)
    impacts = np.array([t.time for t in motion.transitions if t.after is Mode.FLIGHT])
    # A microsecond before and after.
    jumps = np.abs(motion(np.minimum(impacts + 1e-6, 10.0)).vy - motion(impacts - 1e-6).vy)
    for time, height, place, velocity in BALL:
        # Sums of the scheme, h/2 (v + v'), have its error of h²/12 times the change of the plane's acceleration.
        assert 2 * time + 2 / np.pi * np.sin(np.pi * time / 2) - low == pytest.approx(place, abs=5e-6)
        assert 2 + np.cos(np.pi * time / 2) == pytest.approx(velocity, abs=1e-14)
        before = impacts < time
        allowed = h * float(jumps[before].sum()) + 1e-12
        assert abs(motion(time).y - R - height) <= allowed
    assert motion(0.2).y - R == pytest.approx(BALL[0][1], abs=1e-13)
    assert max(abs(motion(t).y - R - height) for t, height, *_ in BALL) < 0.07


def test_paper_kinematics_with_a_moving_track():
    """(11) and (12) are the same velocity, and (8), (9) the rates of (5), (6), with R(ξ₁, t)."""
    drive = Drive(x="0.1*sin(3*t)", y="0.2*t**2", angle="0.5*t + 0.3*sin(2*t)")
    case = Case(circle(1.0), disc(R, M), (Gravity(G), CoulombFriction(0.2), drive), Start(-1.0), 2.0)
    state, t, d = (-1.0, 0.3, 0.7, -2.0), 0.4, 1e-6
    k = kinematics(case, *state, t)
    assert slip_vector(k) == pytest.approx(slip_vector_of_plate(k), abs=1e-12)
    before, after = (
        kinematics(case, state[0] + s * state[2], state[1] + s * state[3], *state[2:], t + s) for s in (-d, d)
    )
    assert (after.R0 - before.R0) / (2 * d) == pytest.approx(k.R0_dot, abs=1e-8)
    assert (after.theta - before.theta) / (2 * d) == pytest.approx(k.theta_dot, abs=1e-8)


def test_loads_in_the_tracks_frame_are_those_of_a_motion_that_is_turned_into_it():
    """For any motion r(t), θ(t) of a free plate, ρ = e^(-iα) (r − c): its second derivative, by SymPy, is the load per
    mass if r'' is that in the fixed frame. Both formulations and the check of laws use these loads."""
    t = sp.Symbol("t", real=True)
    c, alpha = sp.sin(3 * t) / 5 + sp.I * t**3 / 7, sp.cos(2 * t) / 3 + t**2 / 9
    r, theta = sp.exp(t / 2) + sp.I * sp.cos(t), 1 + sp.sin(t) / 2
    own = Load("0.3*x + vy - sin(t)", "theta*y - 0.2*omega", "0.1*t + 0.05*vx*x")
    drive = Drive(*(str(sp.expand(part)) for part in (sp.re(c), sp.im(c), alpha)))
    effects = Gravity(G), drive, own, Unilateral(), Flight()
    case = relative_case(Case(line(), disc(R, M), effects, Start(0.0, gap=1.0), 1.0))
    load = case.effect(Load)
    assert load is not None
    seen, angle = sp.exp(-sp.I * alpha) * (r - c), theta - alpha
    for when in (0.0, 0.4, 1.1):
        at = [complex(sp.N(e.diff(t, n).subs(t, when), 30)) for e in (r, theta) for n in (0, 1, 2)]
        place, rate, second, turn, spin, swing = at
        force = own.at(when, place.real, place.imag, turn.real, rate.real, rate.imag, spin.real)
        miss = second - complex(force[0], force[1] - M * G) / M
        there = [complex(sp.N(e.diff(t, n).subs(t, when), 30)) for e in (seen, angle) for n in (0, 1, 2)]
        state = (there[0].real, there[0].imag, there[3].real, there[1].real, there[1].imag, there[4].real)
        found = load.at(when, *state)
        there_miss = miss * np.exp(-1j * complex(sp.N(alpha.subs(t, when))))
        assert there[2] - there_miss == pytest.approx(complex(found[0], found[1]) / M, abs=1e-12)
        inertia = case.plate.inertia
        assert there[5] - (swing - force[2] / inertia) == pytest.approx(found[2] / inertia, abs=1e-12)


def test_frames_are_inverse_to_each_other():
    case = cases.load("disc_in_swinging_bowl")
    motion = reference.simulate(case)
    seen = in_track_frame(motion)
    own = reference.simulate(relative_case(case))
    times = np.linspace(0.0, 3.0, 20)
    for name in ("x", "y", "theta", "vx", "vy", "omega", "slip"):
        assert getattr(seen(times), name) == pytest.approx(getattr(own(times), name), abs=1e-9)
    begin, first = contact.start_motion(case), motion(0.0)
    assert (begin.x, begin.y, begin.vx, begin.vy) == pytest.approx((first.x, first.y, first.vx, first.vy), abs=EXACT)
    state = motion(times)
    slip = contact.slip_velocity(case, state.x, state.y, state.vx, state.vy, state.omega, state.xi1, times)
    assert slip == pytest.approx(state.slip, abs=1e-11)


@METHODS
def test_a_pose_on_a_track_that_moves_has_the_velocities_of_the_fixed_frame(method):
    """A disc at rest on a track that runs at v: μ g on it and 2 μ g/r until r ω + v̇ t = v, after v/(3 μ g), then v/3.
    The velocities were taken as relative to the track, so that the disc began with v."""
    v, mu = 3.0, 0.2
    effects = (Gravity(G), CoulombFriction(mu), Unilateral(), Drive(x=f"0.4 + {v}*t", y=0.7))
    case = Case(line(), disc(R, M), effects, StartPose(1.0, 0.7 + R), 1.0)
    assert case.start.slip == pytest.approx(-v, abs=1e-15)
    motion = reference.simulate(case, rtol=1e-13, method=method)
    (change,) = motion.transitions
    assert change.time == pytest.approx(v / (3.0 * mu * G), abs=EXACT)
    first, last = motion(0.0), motion(1.0)
    assert (first.x, first.y, first.vx, first.vy, first.omega) == pytest.approx(
        (1.0, 0.7 + R, 0.0, 0.0, 0.0), abs=1e-15
    )
    assert (last.vx, last.omega * R) == pytest.approx((v / 3.0, 2.0 * v / 3.0), abs=EXACT)
