"""The nearest points of curves with pieces or corners, compared with samples of both outlines."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from cases import Chain, Curve, Plate, disc, library
from cases.contact.nearest import contacts, nearest_pair
from tests.sampling import quick_every

BASIN = [(-6.0, 2.0), (-2.0, -0.3), (-1.0, -0.9), (0.0, -1.1), (0.8, -0.7), (2.0, -0.2), (6.0, 2.0)]
TRACKS = {
    "line": library.line(0.3),
    "bowl": library.circle(1.0),
    "hill": library.hill(0.5),
    "waves": library.cosine(0.3, 2.0),
    "valley of edges": Chain.polyline(BASIN),
    "roof": Chain.polyline([(-6.0, -1.0), (-0.2, 0.0), (0.3, 0.1), (6.0, -2.0)]),
    "spline": Curve.spline(BASIN),
}
PLATES = {
    "box": Plate.rectangle(0.3, 0.2, 1.0),
    "box with round corners": Plate.rectangle(0.3, 0.2, 1.0, radius=0.02),
    "half disc": Plate.half_disc(0.15, 1.0),
    "gear": Plate.gear(0.15, 6, 0.03, 1.0),
    "disc": disc(0.15, 1.0),
}
# Samples of the track and of the outline: next to the nearest pair at most 0.8 mm and 2 mm apart.
TRACK_SAMPLES, OUTLINE_SAMPLES = 20_001, 1_001


def sampled_gap(track, outline, x, y, theta):
    """The smallest distance (m, negative inside) of samples of an outline from samples of a track, and by how much it
    may be too large."""
    u, v = outline.point(np.linspace(*outline.span, OUTLINE_SAMPLES))
    places = np.array([x + np.cos(theta) * u - np.sin(theta) * v, y + np.sin(theta) * u + np.cos(theta) * v])
    low, high = track.span if track.domain or track.period else (-4.0, 4.0)
    s = np.linspace(low, high, TRACK_SAMPLES)
    points, normals = track.point(s), track.normal(s)
    away, foot = cKDTree(points.T).query(places.T)
    gaps = np.copysign(away, ((places - points[:, foot]) * normals[:, foot]).sum(axis=0))
    return gaps.min(), np.hypot(*np.diff(points)).max() + np.hypot(*np.diff(places)).max()


@quick_every(3)
@pytest.mark.parametrize("plate", PLATES)
@pytest.mark.parametrize("track", TRACKS)
@settings(max_examples=6, deadline=None)
@example(0.0, 0.5, 0.0)
@example(0.1, 0.4, np.arctan(0.3))  # flat over the line
@given(st.floats(-0.4, 0.4), st.floats(0.35, 1.0), st.floats(-7.0, 7.0))
def test_no_sample_of_an_outline_is_nearer_to_a_track_than_its_nearest_pair(track, plate, x, height, theta):
    curve, outline = TRACKS[track], PLATES[plate].outline
    pose = x, {"bowl": 0.7 * (height - 0.6), "hill": height + 0.2}.get(track, height), theta
    pair = nearest_pair(curve, outline, *pose)
    gap, error = sampled_gap(curve, outline, *pose)
    # Distances of samples are too large: of an outline's point over the track, and below it the other way.
    assert gap - error <= pair.gap <= gap + (1e-12 if gap > 0.0 else error)
    # The pair is one of points with that gap, along the track's normal.
    (u, v), normal = outline.point(pair.xi2), curve.normal(pair.xi1)
    there = (pose[0] + np.cos(theta) * u - np.sin(theta) * v, pose[1] + np.sin(theta) * u + np.cos(theta) * v)
    np.testing.assert_allclose(there - curve.point(pair.xi1), pair.gap * normal, rtol=0.0, atol=1e-11)


@pytest.mark.parametrize("depth", [1e-6, 0.01])
@pytest.mark.parametrize("turn", [0.0, 0.3, -0.4])
@pytest.mark.parametrize("track", ["line", "roof"])
def test_the_gap_of_an_overlap_is_that_of_the_deepest_corner(track, turn, depth):
    """Above a straight edge, in whose frame a corner of the box is that deep and no other is deeper."""
    curve, outline = TRACKS[track], PLATES["box"].outline
    s = 0.0 if track == "line" else 2.0
    theta = float(curve.tangent_angle(s)) + turn
    reach = 0.15 * abs(np.sin(turn)) + 0.1 * np.cos(turn)
    x, y = curve.point(s) + (reach - depth) * curve.normal(s)
    assert nearest_pair(curve, outline, x, y, theta).gap == pytest.approx(-depth, abs=1e-14)


def test_there_is_no_nearest_pair_beyond_the_ends_of_a_track():
    table = Chain.polyline([(-1.0, 0.0), (0.0, 0.0)])
    assert nearest_pair(table, PLATES["box"].outline, 0.5, 0.1, 0.3) is None


def test_each_place_of_a_box_in_a_groove_is_a_contact():
    """A box with one corner on each side of a groove, both at the same height."""
    groove, box = Chain.polyline([(-2.0, 2.0), (0.0, 0.0), (2.0, 2.0)]), Plate.rectangle(0.4, 0.2, 1.0).outline
    some = contacts(groove, box, 0.0, 0.3, 0.0)[:2]
    assert [one.gap for one in some] == pytest.approx([0.0, 0.0], abs=1e-15)
    assert sorted(groove.point(one.xi1)[0] for one in some) == pytest.approx([-0.2, 0.2], abs=1e-15)
