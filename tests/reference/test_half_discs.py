"""Plates of arcs and edges on a flat side and on their arcs: closed forms and quadratures, and both formulations."""

from dataclasses import replace
from math import atan, cos, pi, sin, sqrt

import numpy as np
import pytest
from scipy.integrate import quad

import reference
from cases import (
    Case,
    CoulombFriction,
    Flight,
    FreePlate,
    Gravity,
    Impact,
    Outline,
    PerfectlyRough,
    Plate,
    Start,
    StartPose,
    Unilateral,
    disc,
    library,
)
from cases.contact.outline_features import arc_ranges, features
from cases.curves.corner import Edge
from cases.curves.outline import arc
from cases.scene.contact_pairs import pairs
from reference.certification.witnesses import _by_second
from tests.scenes import second as second_states

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


def test_a_plate_far_away_changes_no_motion_of_a_half_disc():
    """It rocks from its arc over a corner onto its side and bounces there: two contacts, each with a name."""
    start = Start(0.0, xi2=0.1, slip=-1.0)
    alone = on(0.0, HALF, CoulombFriction(0.5), Flight(), Impact(0.5, "newton"), start=start, duration=1.0)
    far = FreePlate(disc(0.1, 1.0), StartPose(50.0, 0.1), "far")
    one, both = reference.simulate(alone), reference.simulate(replace(alone, others=(far,)))
    own = [t for t in both.transitions if t.contact.startswith("plate/")]
    assert len(one.transitions) > 3
    assert [(t.contact, t.before, t.after) for t in own] == [(t.contact, t.before, t.after) for t in one.transitions]
    assert [t.time for t in own] == pytest.approx([t.time for t in one.transitions], rel=1e-9)
