"""Plates on curved supports: discs between circles, rods and blocks in bowls, against exact motions."""

from functools import cache
from math import acos, atan, cos, hypot, sin, sqrt

import mpmath as mp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import reference
from cases import (
    Case,
    CoulombFriction,
    Curve,
    Flight,
    Gravity,
    Impact,
    Mode,
    Outline,
    PerfectlyRough,
    Plate,
    StartPose,
    Support,
    Unilateral,
    disc,
)  # fmt: skip
from cases.library import circle, line
from cases.motion.mechanics import energy
from cases.scene.contact_limits import touches_by_features
from cases.scene.contact_pairs import pairs
from reference.certification.witnesses import _by_second
from tests.sampling import quick_every
from tests.scenes import second as second_states
from tests.scenes.agreement import agree, unlike_second
from tests.scenes.supports import INELASTIC, G, events, hill, simulated

# --- discs between circles --------------------------------------------------------------------------------------------


def between_hills(tilt: float, *effects, start: StartPose | None = None, duration: float = 2.0) -> Case:
    """A disc of 0.5 m that touches two hills of 1 m whose normals are inclined by `tilt` (rad) to the vertical."""
    far = 1.5 * sin(tilt)
    begin = start or StartPose(0.0, 1.5 * cos(tilt), omega=20.0)
    support = (Support(hill(1.0, far, 0.0), "right"),)
    return Case(hill(1.0, -far, 0.0), disc(0.5, 1.0), (*INELASTIC, *effects), begin, duration, supports=support)


@quick_every(3)
@pytest.mark.parametrize("method", [*reference.METHODS, "second"])
def test_a_disc_that_spins_between_two_hills_stops_in_time(method):
    # Friction μ N at both contacts: S (1 + μ²) cos α = m g for the sum S of the normal forces, J ω̇ = −μ r S.
    tilt, mu = 0.9, 0.3
    case = between_hills(tilt, CoulombFriction(mu))
    motion = _by_second(case, "second", 1e-13) if method == "second" else reference.simulate(case, 1e-14, method)
    stop = 0.5 * 20.0 * (1.0 + mu**2) * cos(tilt) / (2.0 * mu * G)
    assert events(motion) == [
        ("plate/right", Mode.SLIP_FORWARD, Mode.ROLL),
        ("plate/track", Mode.SLIP_FORWARD, Mode.ROLL),
    ]
    assert [t.time for t in motion.transitions] == pytest.approx([stop] * 2, abs=1e-12)


def test_a_disc_at_rest_on_two_curved_supports_touches_both_from_the_start():
    motion = reference.simulate(between_hills(0.9, CoulombFriction(1.5), start=StartPose(0.0, 1.5 * cos(0.9))))
    assert motion.contact_names == ("plate/track", "plate/right") and not motion.transitions
    ranges = motion.contacts["plate/right"].normal_range[:, 0]
    assert ranges[0] < 0.5 * G / cos(0.9) < ranges[1]  # one force too many: that without friction is one of them


def falls(angle: float, until: float, length: float, share: float) -> float:
    """The time (s) in which a pendulum of that length (m), of whose fall a share becomes speed, falls from rest at an
    angle from its lowest place to another one, on the same side or beyond."""
    with mp.workdps(30):
        rate = 2 * mp.mpf(share) * mp.mpf(G) / mp.mpf(length)
        start, end = mp.mpf(angle), mp.mpf(until)

        def slow(v):  # θ = θ₀ − v² removes the root at the start
            if not v:
                return 2 / mp.sqrt(rate * mp.sin(start))
            return 2 * v / mp.sqrt(2 * rate * mp.sin(start - v * v / 2) * mp.sin(v * v / 2))

        return float(mp.quad(slow, mp.linspace(0, mp.sqrt(start - end), 6)))


@quick_every(8)
@pytest.mark.parametrize("method", [*reference.METHODS, "second"])
@pytest.mark.parametrize(("rolls", "share"), [(False, 1.0), (True, 2.0 / 3.0)])
def test_a_disc_in_a_bowl_meets_a_hill_at_the_time_of_a_quadrature(method, rolls, share):
    # It slides, or rolls (2/3 of the fall becomes speed), as a pendulum of length R − r.
    r, far, size, x, y = 0.3, 1.7, 0.4, -0.6, -1.7
    centre, away = hypot(x, y), size + r
    # The angle between the centres of hill and disc, seen from the bowl's centre, where they touch.
    between = acos((far**2 + centre**2 - away**2) / (2.0 * far * centre))
    touch = between - atan(x / y)  # of the disc from straight below, to the right
    start, friction = 1.2, (PerfectlyRough(),) if rolls else ()
    pose = StartPose(far * sin(start), -far * cos(start))
    support = (Support(hill(size, x, y), "hill", ()),)  # two rough contacts would hit in several ways
    case = Case(circle(2.0), disc(r, 1.0), (*INELASTIC, *friction), pose, 1.2, supports=support)
    motion = _by_second(case, "second", 1e-13) if method == "second" else reference.simulate(case, 1e-14, method)
    first = motion.transitions[0]
    assert first.contact == "plate/hill" and first.before is Mode.FLIGHT
    assert first.time == pytest.approx(falls(start, touch, far, share), abs=1e-12)


def test_a_disc_that_rolls_over_the_end_of_a_shelf_ends_the_motion_there():
    shelf = Curve(lambda s: (s, 0.6 + 0.05 * s**2), domain=(-1.0, 0.2))
    supports = (Support(shelf, "shelf", (CoulombFriction(0.3),)),)
    case = Case(line(0.0), disc(0.1, 1.0), INELASTIC, StartPose(-0.5, 0.73, vx=1.0), 1.5, supports=supports)
    motion = simulated(case)
    assert unlike_second(case, motion) == ""
    assert motion.status == "track_end" and len(motion.transitions) == 2
    assert motion.contact_columns("plate/shelf", motion.t[-1:]).xi1 == pytest.approx(0.2, abs=1e-12)


# --- rods and blocks in bowls -----------------------------------------------------------------------------------------

RADIUS, HALF, LOW = 2.0, 1.0, 0.02
# The distance of the rod's centre of mass from the bowl's centre.
DEPTH = sqrt(RADIUS**2 - HALF**2) - LOW
ROD = Plate(Outline.polygon([(-HALF, -LOW), (HALF, -LOW), (HALF, LOW), (-HALF, LOW)]), 1.0, HALF**2 / 3.0)


def rod_in_bowl(angle: float, *effects, duration: float = 3.0) -> Case:
    """A rod whose two ends stand in a circular bowl, turned by an angle from level (rad)."""
    pose = StartPose(DEPTH * sin(angle), -DEPTH * cos(angle), angle)
    return Case(circle(RADIUS), ROD, (*INELASTIC, *effects), pose, duration)


@quick_every(6)
@pytest.mark.parametrize("method", [*reference.METHODS, "second"])
@pytest.mark.parametrize("angle", [0.5, 1.2])
def test_a_rod_without_friction_in_a_bowl_is_a_physical_pendulum(angle, method):
    # About the bowl's centre: (J + m d²) θ̈ = −m g d sin θ. The period is 4 K(sin θ₀/2)/ω₀ with ω₀² = g d/(J/m + d²).
    case = rod_in_bowl(angle, duration=3.5)
    period = 4.0 * float(mp.ellipk(mp.sin(mp.mpf(angle) / 2) ** 2)) / sqrt(G * DEPTH / (HALF**2 / 3.0 + DEPTH**2))
    times = np.array([0.25, 0.5, 1.0]) * period
    if method == "second":
        theta = second_states.poses(case, times)[2]
    else:
        motion = reference.simulate(case, 1e-14, method)
        theta = motion(times).theta
        assert motion.contact_names == ("plate/track", "plate/track 2") and not motion.transitions
        assert np.ptp(energy(case, motion)) < 1e-12 * G
    assert theta == pytest.approx([0.0, -angle, angle], abs=1e-11)


def test_a_rod_in_a_bowl_rests_within_the_friction_angle():
    # Both ends slip together: moments about the bowl's centre give μ R S = m g d sin θ for the sum S of the normal
    # forces, and the balance of forces S (1 + μ²) cos β = m g (cos θ + μ sin θ), with the ends at angles ±β.
    mu = 0.3
    limit = atan(mu * RADIUS / ((1.0 + mu**2) * sqrt(RADIUS**2 - HALF**2) / RADIUS * DEPTH - mu**2 * RADIUS))
    below = reference.simulate(rod_in_bowl(limit - 1e-9, CoulombFriction(mu)))
    assert below.status == "completed" and not below.transitions and below(3.0).theta == below(0.0).theta
    above = reference.simulate(rod_in_bowl(limit + 1e-9, CoulombFriction(mu)))
    assert above(3.0).theta < above(0.0).theta and above.first_mode is Mode.SLIP_BACKWARD


def test_a_rod_slides_in_a_bowl_with_friction_until_it_stops():
    # With S (1 + μ²) cos β = m (g cos θ + d θ̇² + μ (d θ̈ + g sin θ)) by the balance along and across the rod's axis:
    # (J + m d²) θ̈ = μ R S − m g d sin θ is linear in θ̈.
    mu, angle = 0.2, 0.7
    case = rod_in_bowl(angle, CoulombFriction(mu))
    share = mu * RADIUS / ((1.0 + mu**2) * sqrt(RADIUS**2 - HALF**2) / RADIUS)

    def rates(t: float, y: np.ndarray) -> list[float]:
        theta, omega = y
        push = share * (G * cos(theta) + DEPTH * omega**2 + mu * G * sin(theta))
        return [omega, (push - G * DEPTH * sin(theta)) / (HALF**2 / 3.0 + DEPTH**2 - share * mu * DEPTH)]

    stops = lambda t, y: y[1] + (t == 0.0) * -1.0  # noqa: E731
    stops.terminal, stops.direction = True, 1.0
    law = solve_ivp(rates, (0.0, 3.0), [angle, 0.0], method="DOP853", rtol=1e-13, atol=1e-15, events=stops)
    motion = simulated(case)
    assert events(motion) == [
        ("plate/track", Mode.SLIP_BACKWARD, Mode.ROLL),
        ("plate/track 2", Mode.SLIP_BACKWARD, Mode.ROLL),
    ]
    # The integration of the law has errors of 1e-13, and the time those divided by the deceleration, 1 to 10 1/s².
    assert motion.transitions[0].time == pytest.approx(float(law.t_events[0][0]), abs=1e-11)
    assert motion(3.0).theta == pytest.approx(float(law.y_events[0][0][0]), abs=1e-11)
    agree(case)


def test_a_rod_that_begins_on_one_end_meets_the_bowl_with_the_other_one():
    # Without Flight the motion has one contact until then, and needs an Impact there.
    pose, end = StartPose(0.0, 0.0, 0.9), np.array([-HALF, -LOW])
    corner = np.array([cos(0.9) * end[0] - sin(0.9) * end[1], sin(0.9) * end[0] + cos(0.9) * end[1]])
    pose = StartPose(0.3 - corner[0], -sqrt(RADIUS**2 - 0.09) - corner[1], 0.9)
    effects = Gravity(G), Unilateral(), CoulombFriction(0.3)
    alone = Case(circle(RADIUS), ROD, effects, pose, 2.0)
    assert not touches_by_features(alone)
    met = reference.simulate(alone)
    assert met.status == "second_contact" and "add Flight() and Impact(0.0)" in met.reason
    whole = reference.simulate(Case(circle(RADIUS), ROD, (*effects, Flight(), Impact(0.0, "moreau")), pose, 2.0))
    assert met.t[-1] == pytest.approx(
        next(t.time for t in whole.transitions if t.contact == "plate/track 2"), abs=1e-11
    )


# --- flat sides on hills ----------------------------------------------------------------------------------------------


def plank_on_hill(angle: float, *effects, supports: tuple = (), flies: bool = True, duration: float = 3.0) -> Case:
    """A plank of 2 m that touches a hill of 1 m with its lower side, rolled to an angle (rad) from level."""
    low = 0.05
    x = sin(angle) - angle * cos(angle) + low * sin(angle)
    y = cos(angle) + angle * sin(angle) + low * cos(angle)
    always = INELASTIC if flies else (Gravity(G), Unilateral())
    plank = Plate.rectangle(2.0, 2.0 * low, 1.0)
    return Case(hill(1.0, 0.0, 0.0), plank, (*always, *effects), StartPose(x, y, -angle), duration, supports=supports)


# Far below the plank; with a support all contacts are pairs of a support and a feature.
GROUND = Support(Curve(lambda s: (s, -5.0 + 0.0 * s)), "ground")


@cache
def period_on_hill(angle: float) -> float:
    """The period of a plank that rolls on a hill of 1 m, by its energy: (k² + b² + φ²) φ̇² = 2 g (h(φ₀) − h(φ)) with the
    height h = (1 + b) cos φ + φ sin φ of its centre, and b = 0.05 m, k² = (1 + b²)/3."""
    with mp.workdps(50):
        low, start = mp.mpf("0.05"), mp.mpf(angle)
        square = (1 + low**2) / 3 + low**2

        def height(phi):
            return (1 + low) * mp.cos(phi) + phi * mp.sin(phi)

        def slow(v):  # φ = φ₀ − v² removes the root at the start
            if v < mp.mpf(10) ** -14:
                return 2 * mp.sqrt((square + start**2) / (2 * G * (start * mp.cos(start) - low * mp.sin(start))))
            phi = start - v * v
            return 2 * v * mp.sqrt((square + phi**2) / (2 * G * (height(start) - height(phi))))

        return 4.0 * float(mp.quad(slow, mp.linspace(0, mp.sqrt(start), 4)))


@quick_every(3, first=1)
@pytest.mark.parametrize("method", [*reference.METHODS, "second"])
def test_a_plank_rocks_on_a_hill_with_the_period_of_a_quadrature(method):
    period = period_on_hill(0.4)
    case, times = (
        plank_on_hill(0.4, CoulombFriction(2.0), supports=(GROUND,)),
        np.array([0.25, 0.5, 1.0, 1.25]) * period,
    )
    if method == "second":
        theta = second_states.poses(case, times)[2]
    else:
        theta = reference.simulate(case, 1e-14, method)(times).theta
    assert theta == pytest.approx([0.0, 0.4, -0.4, 0.0], abs=1e-11)


@pytest.mark.parametrize("method", ["first", "second"])
def test_a_block_that_falls_flat_on_a_hill_goes_on(method):
    # It ended there as second_contact. Without friction and spin the impact at its lower side takes all of the speed.
    case = Case(hill(1.0, 0.0, 0.0), Plate.rectangle(0.6, 0.4, 1.0), INELASTIC, StartPose(0.0, 1.7), 1.0)
    motion = reference.simulate(case, 1e-12) if method == "first" else _by_second(case, "second", 1e-13)
    assert motion.status == "completed" and motion.transitions[0].time == pytest.approx(sqrt(1.0 / G), abs=1e-12)
    assert motion.transitions[0].after is Mode.SLIDE


# --- checks -----------------------------------------------------------------------------------------------------------


def test_corners_and_arcs_on_curves_are_searched_for_and_keep_their_names():
    case = rod_in_bowl(0.3)
    assert [pair.has_unique_points for pair in pairs(case)] == [False] * 4
    assert all(pair.is_point_on_curve for pair in pairs(case))
    begin = case.start.motion(case.track, case.plate.outline)
    touching = [len(pair.touching_points(begin.x, begin.y, begin.theta)) for pair in pairs(case)]
    assert touching == [1, 0, 0, 1]
