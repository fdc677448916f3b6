"""Plates of arcs and edges on a flat side and on their arcs: closed forms and quadratures, and both formulations."""

from dataclasses import replace
from math import atan, cos, hypot, pi, sin, sqrt

import numpy as np
import pytest
from scipy.integrate import quad

import reference
from cases import (
    Case,
    CoulombFriction,
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
    library,
)
from cases.contact.outline_features import arc_ranges, features
from cases.curves.corner import Edge
from cases.curves.outline import arc
from cases.scene.contact_pairs import pairs
from reference.certification.witnesses import _by_second
from tests.scenes import second as second_states
from tests.scenes.agreement import check_several_contacts

G, R = 9.81, 0.2
EXACT = 1e-12  # step errors at 1e-14 are below a few roundings of the times; quadratures are exact to 1e-14
HALF = Plate.half_disc(R, 1.5)
LOW = 4.0 * R / (3.0 * pi)  # its centre of mass over its flat side
INELASTIC = Flight(), Impact(0.0, "moreau")
CUT = pi / 6


def segment() -> Plate:
    """A disc without a small segment: its flat side is a chord of the angle 2 CUT, at the bottom."""
    end = R * sin(CUT), -R * cos(CUT)
    round_side = arc((0.0, 0.0), R, CUT - pi / 2, 1.5 * pi - CUT)
    return Plate.homogeneous(Outline((round_side, Edge.between((-end[0], end[1]), end))), 1.0)


def bullet() -> Plate:
    """A half disc on a low rectangle: its arc meets edges without corners, and its circle leaves the plate below."""
    places = [(-0.1, 0.0), (-0.1, -0.05), (0.1, -0.05), (0.1, 0.0)]
    edges = tuple(map(Edge.between, places[:-1], places[1:]))
    return Plate.homogeneous(Outline((*edges, arc((0.0, 0.0), 0.1, 0.0, pi))), 1.0)


def stadium() -> Plate:
    return Plate.homogeneous(
        Outline((
            Edge.between((-0.1, -0.05), (0.1, -0.05)), arc((0.1, 0.0), 0.05, -pi / 2, pi / 2),
            Edge.between((0.1, 0.05), (-0.1, 0.05)), arc((-0.1, 0.0), 0.05, pi / 2, 1.5 * pi),
        )), 1.0,
    )  # fmt: skip


def on(slope, plate, *effects, start, duration=1.5, supports=()):
    return Case(library.line(slope), plate, (Gravity(G), Unilateral(), *effects), start, duration, supports=supports)


# --- exact ------------------------------------------------------------------------------------------------------------


def test_a_half_disc_slides_on_its_flat_side_and_stops():
    mu, speed = 0.3, 1.0
    case = on(0.0, HALF, CoulombFriction(mu), start=StartPose(0.0, LOW, pi, vx=speed))
    motion = reference.simulate(case, rtol=1e-14)
    assert motion.status == "completed" and motion.contact_names == ("plate/track", "plate/track 2")
    assert [t.time for t in motion.transitions] == pytest.approx([speed / (mu * G)] * 2, rel=EXACT)
    end = motion(1.5)
    assert (end.x, end.y, end.theta) == pytest.approx((speed**2 / (2 * mu * G), LOW, pi), abs=EXACT)
    # Moments about the centre: friction has the arm LOW, the two forces the arm R.
    columns = [motion.contact_columns(name, np.array([0.1])) for name in motion.contact_names]
    forces = sorted(float(one.normal_force[0]) for one in columns)
    assert sum(forces) == pytest.approx(1.5 * G, rel=EXACT)
    assert (forces[1] - forces[0]) * R == pytest.approx(mu * 1.5 * G * LOW, rel=EXACT)


@pytest.mark.parametrize("side", [-1e-6, 1e-6])
def test_a_half_disc_on_a_slope_tips_where_its_weight_passes_its_edge(side):
    slope = atan(R / LOW) + side
    start = StartPose(LOW * sin(slope), LOW * cos(slope), pi - slope)
    motion = reference.simulate(on(slope, HALF, PerfectlyRough(), start=start, duration=0.5))
    assert motion.status == "completed"
    assert (motion(0.5).omega < 0.0) == (side > 0.0) and (motion(0.5).omega == 0.0) == (side < 0.0)


def test_a_tilted_half_disc_lands_on_a_corner_and_lies_down():
    tilt, height = 0.3, 0.15
    case = on(0.0, HALF, PerfectlyRough(), *INELASTIC, start=StartPose(0.0, height, pi + tilt))
    motion = reference.simulate(case, rtol=1e-14)
    arm, lever = hypot(R, LOW), atan(R / LOW)
    high, aside = arm * cos(lever - tilt), arm * sin(lever - tilt)
    fall = sqrt(2.0 * (height - high) / G)
    inertia = HALF.inertia / HALF.mass + arm**2
    spin = aside * G * fall / inertia  # angular momentum about the corner

    def wait(theta):
        return 1.0 / sqrt(spin**2 + 2.0 * G * (high - arm * cos(lever - theta)) / inertia)

    down = fall + quad(wait, 0.0, tilt, epsabs=1e-14, epsrel=1e-13)[0]
    assert [t.time for t in motion.transitions] == pytest.approx([fall, down], rel=EXACT)
    end = motion(1.5)
    assert motion.status == "completed"
    assert (end.y, end.theta, end.omega) == pytest.approx((LOW, pi, 0.0), abs=EXACT)


@pytest.mark.parametrize("method", [pytest.param(None, marks=pytest.mark.slow), "dop853"])
def test_a_plate_tips_over_its_corner_and_rolls_on_its_arc(method):
    """From its flat side it turns about a corner until its arc touches, then rolls: energy gives both times."""
    slope, plate = 0.62, segment()
    low = -float(plate.outline.bounds[2])
    off, own = low - R * cos(CUT), plate.inertia / plate.mass  # of the centre of mass from the arc's centre

    def place(phi):  # along the slope and off it, after a turn by phi
        if phi <= CUT:
            return R * sin(CUT) * (1.0 - cos(phi)) + low * sin(phi), R * sin(CUT) * sin(phi) + low * cos(phi)
        return R * sin(CUT) + R * (phi - CUT) + off * sin(phi), R + off * cos(phi)

    def wait(phi):
        along, high = place(phi)
        contact = R * sin(CUT) + max(phi - CUT, 0.0) * R
        fall = along * sin(slope) + (low - high) * cos(slope)
        return sqrt((own + (along - contact) ** 2 + high**2) / (2.0 * G * fall))

    accuracy = {"epsabs": 1e-14, "epsrel": 1e-13}
    corner = quad(lambda u: 2.0 * u * wait(u * u) if u > 1e-6 else 2.0 * u * wait(1e-12), 0.0, sqrt(CUT), **accuracy)[0]
    rolling = quad(wait, CUT, 2.0, **accuracy)[0]
    start = StartPose(sin(slope) * low, cos(slope) * low, -slope)
    case = on(slope, plate, PerfectlyRough(), *INELASTIC, start=start, duration=0.8)
    motion = reference.simulate(case, rtol=1e-14, method=method)
    assert motion.status == "completed" and motion.transitions == ()
    # The start from rest on an edge is unstable: roundings of the first pose grow to a few 1e-13 s.
    for turn, time in ((CUT, corner), (2.0, corner + rolling)):
        assert -slope - motion(time).theta == pytest.approx(turn, abs=1e-11)
        along, high = place(turn)
        x, y = low * sin(slope), low * cos(slope)
        u, v = along, high - low
        expected = (x + u * cos(slope) + v * sin(slope), y - u * sin(slope) + v * cos(slope))
        assert (motion(time).x, motion(time).y) == pytest.approx(expected, abs=1e-11)
    second = _by_second(case, "second", 1e-13)
    assert second.status == "completed" and second.transitions == ()
    assert second_states.poses(case, [0.75])[2, 0] == pytest.approx(float(motion(0.75).theta), abs=1e-10)


# --- the ranges of arcs -----------------------------------------------------------------------------------------------


def test_the_range_of_an_arc_ends_at_corners_and_beyond_smooth_joints():
    half = arc_ranges(HALF.outline)[0]
    assert half is not None and (half.low, half.high) == pytest.approx((-pi, 0.0)) and half.neighbours == {1, 2}
    assert arc_ranges(stadium().outline) == (None, None) and len(features(stadium().outline)) == 2
    (bulge,) = [one for one in arc_ranges(bullet().outline) if one is not None]
    # Its circle leaves the plate at the lower corners, 2 atan(0.05/0.1) beyond its ends; half of that is used.
    beyond = atan(0.5)
    assert not bulge.neighbours
    assert (bulge.low, bulge.high) == pytest.approx((-beyond, pi + beyond), rel=0.02)  # angles 3 % apart
    assert bulge.low > -2.0 * beyond


def test_the_same_circle_in_two_arcs_is_compared_once():
    quarters = arc((0.0, 0.0), R, -pi, -pi / 2), arc((0.0, 0.0), R, -pi / 2, 0.0)
    plate = Plate.homogeneous(Outline((*quarters, Edge.between((R, 0.0), (-R, 0.0)))), 1.0)
    case = on(0.0, plate, *INELASTIC, start=StartPose(0.0, 0.5, 0.3))
    facing = [pair for pair in pairs(case) if pair.arc_range and not pair.is_away(pair.guess(0.0, 0.5, 0.3)[1])]
    assert len(facing) == 1


# --- both formulations ------------------------------------------------------------------------------------------------

PLATES = (HALF, segment(), bullet(), stadium(), Plate.rectangle(0.4, 0.2, 1.0, radius=0.03))


def random_case(seed: int) -> Case:
    """A plate of arcs and edges thrown onto a slope, every second one with a wall; perfectly rough without one only."""
    chance = np.random.default_rng(seed)
    plate, wall = PLATES[int(chance.integers(5))], bool(chance.integers(2))
    friction = CoulombFriction(float(chance.uniform(0.05, 0.9))) if wall or chance.integers(6) else PerfectlyRough()
    effects = friction, Flight(), Impact(0.0, str(chance.choice(["newton", "poisson", "moreau"])))
    x, vx = (0.4, -1.0) if wall else (0.0, 1.0)
    theta, omega, high = (float(chance.uniform(*limits)) for limits in ((-pi, pi), (-4, 4), (0.3, 0.5)))
    start = StartPose(x, high + 0.2 * wall, theta, vx * float(chance.uniform(0, 1)), 0.0, omega)
    slope = float(chance.uniform(0, 0.4)) * (-1 if wall else 1)
    supports = (Support(library.line(pi / 2 + 0.1), "wall"),) if wall else ()
    return on(slope, plate, *effects, start=start, duration=1.0, supports=supports)


def test_an_open_contact_leaves_an_arc_where_that_ends():
    """It opens at the joint of an arc and the side that lay flat: the rest of the arc's circle is no part of the plate,
    and stopped it 0.107 m above the slope."""
    case = random_case(19)
    assert not reference.check(case, reference.simulate(case, method="dop853"))


# In seed 25 the plate lands next to a smooth joint of an arc and an edge.
@pytest.mark.slow
@pytest.mark.parametrize("seed", range(40))
def test_both_formulations_agree_on_plates_of_arcs_and_edges(seed):
    check_several_contacts(random_case(seed))


@pytest.mark.slow
def test_both_formulations_end_impacts_at_the_limit_where_two_motions_may_follow():
    # The first one went on into hops of rounding, as it looks for the motion that follows before it goes to the limit.
    motion, second = reference.simulate(random_case(183), rtol=1e-13), _by_second(random_case(183), "second", 1e-12)
    assert motion.status == second.status == "not_unique"
    assert [(t.contact, t.before, t.after) for t in motion.transitions] == [
        (t.contact, t.before, t.after) for t in second.transitions
    ]
    assert motion.t[-1] == pytest.approx(second.end, abs=1e-10)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [79, 123])
def test_impacts_in_turn_of_which_three_are_resolved_end_at_their_limit(seed):
    # Every other one is 0.0025 and 0.0045 as fast. The second formulation ended as `accumulation`, the first came to
    # rest where a slip vanished next to the wall, 2.4e-7 and 8.8e-8 s too early.
    motion, second = reference.simulate(random_case(seed), rtol=1e-13), _by_second(random_case(seed), "second", 1e-12)
    assert motion.status == second.status == "completed"
    assert [(t.contact, t.before, t.after) for t in motion.transitions] == [
        (t.contact, t.before, t.after) for t in second.transitions
    ]
    assert [t.time for t in motion.transitions] == pytest.approx([t.time for t in second.transitions], abs=1e-10)


def rough_case(seed: int) -> Case:
    """The same without slip."""
    case = random_case(seed)
    rough = (PerfectlyRough() if isinstance(effect, CoulombFriction) else effect for effect in case.effects)
    return replace(case, effects=tuple(rough))


# At 50, 52 and 59 a rough contact would have to pull, and cannot open.
TWO_MOTIONS = pytest.param(16, marks=pytest.mark.xfail(reason="not_unique in the second formulation only", strict=True))


@pytest.mark.slow
@pytest.mark.parametrize("seed", [TWO_MOTIONS, 50, 52, 59])
def test_both_formulations_agree_on_rough_plates_at_a_wall(seed):
    assert check_several_contacts(rough_case(seed)).status == "paradox"


@pytest.mark.slow
def test_a_rough_contact_that_could_stay_or_open_after_an_impact_has_two_motions():
    """Of roll and flight the first formulation chooses none; the second one goes on with roll."""
    case = rough_case(37)
    motion, second = reference.simulate(case, rtol=1e-13), _by_second(case, "second", 1e-12)
    assert motion.status == "not_unique" and "plate/wall roll; plate/wall flight" in motion.reason
    first = second.transitions[0]
    assert (first.contact, first.before, first.after) == ("plate/wall", Mode.FLIGHT, Mode.ROLL)
    assert first.time == pytest.approx(motion.t[-1], abs=1e-12)


@pytest.mark.slow
def test_a_dropped_half_disc_is_certified():
    case = on(0.0, HALF, CoulombFriction(0.5), *INELASTIC, start=StartPose(0.0, 0.5, 3.3))
    certificate = reference.certify(case)
    last = {t.contact: t.after for t in reference.simulate(case).transitions}
    assert not certificate.missing and last == {"plate/track": Mode.ROLL, "plate/track 2": Mode.ROLL}
    assert all(time.bar <= EXACT for _, _, time, _ in certificate.transitions)


@pytest.mark.slow
def test_a_slip_that_vanishes_next_to_a_wall_without_a_gap_is_no_paradox():
    """The plate rocks into the corner of track and wall, each time 0.0025 of the last, and stops 1e-14 m from the
    wall."""
    motion = reference.simulate(random_case(79), rtol=1e-13)
    assert motion.status == "completed" and motion.vx[-1] == motion.vy[-1] == motion.omega[-1] == 0.0
    last = {t.contact: t.after for t in motion.transitions}
    assert set(last.values()) == {Mode.ROLL} and motion.transitions[-1].time == pytest.approx(0.398556, abs=1e-6)
