"""Plates with corners on one straight track: closed forms and quadratures, both formulations, and what is rejected."""

from math import cos, hypot, pi, sin, sqrt

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

import cases
import reference
from cases import (
    Belt,
    Case,
    CoulombFriction,
    Flight,
    Gravity,
    Impact,
    Mode,
    PerfectlyRough,
    Plate,
    Start,
    StartPose,
    Unilateral,
    library,
)
from cases.scene.contact_limits import touches_by_features

G = 9.81
# Step errors at 1e-14 are below a few roundings of the times; quadratures are exact to 1e-14.
EXACT = 1e-12
BOX = Plate.rectangle(0.4, 0.2, 1.5)
INELASTIC = Flight(), Impact(0.0, "moreau")


def on(track, plate, *effects, start, duration=2.0):
    return Case(track, plate, (Gravity(G), Unilateral(), *effects), start, duration)


# --- exact ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", [None, "dop853"])
def test_a_box_slides_on_its_flat_side_and_stops(method):
    case = on(library.line(), BOX, CoulombFriction(0.3), start=Start(0.0, slip=1.0))
    motion = reference.simulate(case, rtol=1e-14, method=method)
    assert motion.status == "completed" and motion.contact_names == ("plate/track", "plate/track 2")
    assert [(t.before, t.after) for t in motion.transitions] == [(Mode.SLIP_FORWARD, Mode.ROLL)] * 2
    assert [t.time for t in motion.transitions] == pytest.approx([1.0 / (0.3 * G)] * 2, rel=EXACT)
    end = motion(2.0)
    assert (end.x, end.y, end.theta) == pytest.approx((1.0 / (2 * 0.3 * G), 0.1, 0.0), abs=EXACT)
    rest = [motion.contact_columns(name, np.array([1.5])) for name in motion.contact_names]
    assert [float(one.normal_force[0]) for one in rest] == pytest.approx([0.75 * G] * 2, rel=EXACT)
    assert all(np.isnan(one.friction_force[0]) for one in rest)  # only their sum is unique
    # The front corner carries more: friction has the arm of half the height.
    front, back = (float(motion.of(name)(0.1).normal_force) for name in motion.contact_names)
    assert front + back == pytest.approx(1.5 * G, rel=EXACT)
    assert (front - back) * 0.2 == pytest.approx(0.3 * 1.5 * G * 0.1, rel=EXACT)


def test_a_tilted_box_lands_on_a_corner_and_lies_down():
    """The corner sticks, the box turns about it and lies down: wide boxes come to rest there."""
    tilt, height = 0.3, 0.3
    case = on(library.line(), BOX, PerfectlyRough(), *INELASTIC, start=StartPose(0.0, height, tilt))
    motion = reference.simulate(case, rtol=1e-14)
    arm, lever = hypot(0.2, 0.1), np.arctan2(0.2, 0.1)
    high = arm * cos(lever - tilt)  # of the centre over the lowest corner
    fall = sqrt(2 * (height - high) / G)
    landing = motion.transitions[0]
    assert landing.time == pytest.approx(fall, rel=EXACT)
    # Angular momentum about the corner, which is at the left: the box turns backwards.
    side = arm * sin(lever - tilt)
    inertia = BOX.inertia / BOX.mass + arm**2
    spin = side * G * fall / inertia

    def wait(theta):
        drop = high - arm * cos(lever - theta)
        return 1.0 / sqrt(spin**2 + 2 * G * drop / inertia)

    down = fall + quad(wait, 0.0, tilt, epsabs=1e-15, epsrel=1e-14)[0]
    assert [t.time for t in motion.transitions[1:]] == pytest.approx([down], rel=EXACT)
    assert motion.status == "completed" and motion.transitions[1].contact == "plate/track 2"
    end = motion(2.0)
    assert (end.y, end.theta, end.omega) == pytest.approx((0.1, 0.0, 0.0), abs=EXACT)
    assert end.x == pytest.approx(0.2 - side, abs=EXACT)


def test_a_box_dropped_flat_bounces_as_a_point_mass():
    case = on(library.line(), BOX, CoulombFriction(0.5), Flight(), Impact(0.5, "newton"),
              start=Start(0.0, gap=0.5), duration=1.2)  # fmt: skip
    motion = reference.simulate(case, rtol=1e-14)
    fall = sqrt(2 * 0.5 / G)
    times = sorted({round(t.time, 13) for t in motion.transitions})[:3]
    assert times == pytest.approx([fall, 2 * fall, 2.5 * fall], rel=EXACT)
    # The geometric series of the bounces ends after 3 times the fall.
    assert motion.transitions[-1].time == pytest.approx(3 * fall, rel=1e-9)


# --- the catalogue ----------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_sliding_box_tips_about_its_front_corner_and_overturns():
    """While it slides N (1 + (d²/k²) sin ψ (sin ψ − μ cos ψ)) = m (g − d cos ψ ψ̇²), ψ from the vertical over the
    corner, d the distance and k the radius of gyration; once the corner sticks, energy is constant."""
    mu, arm, first = 0.9, hypot(0.1, 0.2), np.arctan2(0.1, 0.2)
    gyration = (0.2**2 + 0.4**2) / 12.0

    def law(t, state):
        psi, rate, speed = state
        turning = arm * (sin(psi) - mu * cos(psi)) / gyration
        force = (G - arm * cos(psi) * rate**2) / (1.0 + arm * sin(psi) * turning)
        return rate, force * turning, -mu * force

    def slip(t, state):
        return state[2] + arm * cos(state[0]) * state[1]

    slip.terminal = True
    path = solve_ivp(law, (0.0, 0.2), (first, 0.0, 1.5), "DOP853", events=slip, rtol=1e-13, atol=1e-15)
    motion = reference.simulate(cases.load("sliding_box", mu=mu, width=0.2, height=0.4, v=1.5), rtol=1e-14)
    stop = motion.transitions[0]
    assert (stop.before, stop.after) == (Mode.SLIP_FORWARD, Mode.ROLL)
    assert stop.time == pytest.approx(path.t_events[0][0], rel=1e-11)  # SciPy's step errors
    psi, rate, _ = path.y_events[0][0]
    assert (motion(stop.time).theta, motion(stop.time).omega) == pytest.approx((psi - first, rate), rel=1e-11)

    def wait(angle):
        return 1.0 / sqrt(rate**2 + 2.0 * G * arm * (cos(psi) - cos(angle)) / (gyration + arm**2))

    upright = quad(wait, 0.0, psi, epsabs=1e-14, epsrel=1e-13)[0]
    assert motion(stop.time + upright).theta == pytest.approx(-first, abs=1e-11)
    assert motion(1.0).theta == pytest.approx(-pi / 2, abs=EXACT) and motion(1.0).omega == 0.0


@pytest.mark.slow
def test_a_half_disc_rocks_with_constant_energy_while_it_rolls():
    case = cases.load("half_disc_rocking", mu=0.5)
    motion, r, off = reference.simulate(case, rtol=1e-14), 0.2, 0.8 / (3.0 * pi)
    assert case.plate.inertia == pytest.approx(r**2 * (0.5 - (4.0 / (3.0 * pi)) ** 2), rel=EXACT)

    def inertia(angle):  # about the contact
        return case.plate.inertia + r**2 + off**2 - 2.0 * r * off * cos(angle)

    def wait(part):  # angle = 1.2 cos part removes the singularities of the turning points
        angle = 1.2 * cos(part)
        fall = 2.0 * G * off * 2.0 * sin(0.6 + 0.5 * angle) * sin(0.6 - 0.5 * angle)
        return 1.2 * sin(part) * sqrt(inertia(angle) / fall)

    half = quad(wait, 0.0, pi, epsabs=1e-14, epsrel=1e-13)[0]
    assert motion.status == "completed" and motion.transitions == ()
    assert abs(motion(half).theta) == pytest.approx(1.2, abs=1e-11) and motion(half).omega == pytest.approx(
        0, abs=1e-10
    )
    assert motion(half).theta == pytest.approx(-float(motion(0.0).theta), abs=1e-11)


# --- starts -----------------------------------------------------------------------------------------------------------


def test_a_start_on_a_flat_side_is_the_pose_that_it_looks_like():
    slope = 0.3
    by_side = on(library.line(slope), BOX, start=Start(0.0, 0.2))
    by_pose = on(library.line(slope), BOX, start=StartPose(0.1 * sin(slope), 0.1 * cos(slope), -slope))
    one, other = (c.start.motion(c.track, c.plate.outline) for c in (by_side, by_pose))
    assert (one.x, one.y, one.theta) == pytest.approx((other.x, other.y, other.theta), abs=1e-15)
    assert touches_by_features(by_side) and touches_by_features(by_pose)
    level = on(library.line(), BOX, start=Start(0.5))
    assert level.start.motion(level.track, level.plate.outline)[:2] == pytest.approx((0.5, 0.1), abs=1e-15)
    falling = on(library.line(), BOX, Flight(), start=Start(0.0, gap=0.3, gap_rate=-1.0, omega=2.0))
    begin = falling.start.motion(falling.track, falling.plate.outline)
    assert (begin.x, begin.y, begin.vy) == pytest.approx((0.0, 0.4, -1.0), abs=1e-15)


# --- what is not supported --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("case", "words"),
    [
        (on(library.line(), BOX, CoulombFriction(0.5), Belt(1.0), start=Start(0.0, 0.6)),
         "add Flight() and Impact(0.0) to go on"),
        (on(library.line(), BOX, PerfectlyRough(), start=Start(0.0, 0.6)), "add Flight() and Impact(0.0) to go on"),
    ],
)  # fmt: skip
def test_where_a_flat_side_ends_the_motion_the_reason_says_what_to_give(case, words):
    motion = reference.simulate(case)
    assert motion.status == "second_contact" and words in motion.reason
