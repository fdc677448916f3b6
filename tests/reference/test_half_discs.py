"""Plates of arcs and edges on a flat side and on their arcs: closed forms and quadratures, and both formulations."""

from math import atan, cos, pi, sin, sqrt

import pytest
from scipy.integrate import quad

import reference
from cases import (
    Case,
    Flight,
    Gravity,
    Impact,
    Outline,
    PerfectlyRough,
    Plate,
    StartPose,
    Unilateral,
    library,
)
from cases.contact.outline_features import arc_ranges, features
from cases.curves.corner import Edge
from cases.curves.outline import arc
from reference.certification.witnesses import _by_second
from tests.scenes import second as second_states

G, R = 9.81, 0.2
HALF = Plate.half_disc(R, 1.5)
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
