"""What engines with straight shapes are given: the part of a track that a plate can reach, corners, how far they stand
off, and how far a plate's rolling sways its centre."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

from adapters.common.facets import chain, is_convex, polygon, rim, sagitta, sees_all, stretch, sway
from cases import Case, Curve, Flight, Gravity, Load, Plate, Start, Unilateral, disc, library
from cases.contact import start_motion
from cases.curves import cos, sin

G = 9.81


def scene(track, start, *effects, plate=None, duration=2.0) -> Case:
    return Case(track, plate or disc(0.1, 1.0), (Gravity(G), Unilateral(), *effects), start, duration)


def two_valleys() -> Curve:
    """Valleys at x = −1 and 1 with a hill of 0.3 m between them; walls outside."""
    return Curve(lambda s: (s, 0.3 * (s**2 - 1) ** 2), domain=(-2.0, 2.0))


def height(part, track) -> np.ndarray:
    return track.point(np.linspace(part.low, part.high, 501))[1]


def test_plate_at_rest_reaches_as_high_as_it_starts_and_its_own_size_farther():
    case = scene(library.parabola(0.5, reach=4.0), Start(-1.0))
    part, track = stretch(case), case.track
    # By symmetry; the margin is one radius along the track at both ends, and the walk has 2000 steps.
    assert part.low == pytest.approx(-part.high, abs=0.01)
    assert np.hypot(*(track.point(part.low) - track.point(-1.0))) == pytest.approx(0.1, abs=0.01)
    # ½ v² = g (fall of the centre).
    fall = start_motion(case).y - (track.point(0.0)[1] + 0.1)
    assert part.top_speed == pytest.approx((2 * G * fall) ** 0.5, rel=1e-3)


def test_plate_in_the_air_may_cross_a_hill_that_one_on_the_track_may_not():
    start = Start(-1.5, slip=0.2)
    held, flying = (stretch(scene(two_valleys(), start, *effects)) for effects in ((), (Flight(),)))
    # 0.3·1.25² = 0.47 m is above the hill: both cross.
    assert held.high == pytest.approx(flying.high, abs=0.01) and held.high > 1.4
    # From 0.3·0.9² = 0.25 m it does not get over a hill of 0.3 m on the track.
    low = Start(-1.38)
    held, flying = (stretch(scene(two_valleys(), low, *effects)) for effects in ((), (Flight(),)))
    assert held.high < 0.0
    # The far valley is low enough, so a plate that flies may be found there.
    assert flying.high > 1.2


def test_start_off_the_track_has_the_energy_of_where_it_is():
    """Let go half a metre above the bottom of a valley it climbs half a metre, whatever its gap is along."""
    case = scene(library.parabola(0.5, reach=6.0), Start(0.0, gap=0.5), Flight())
    assert height(stretch(case), case.track).max() == pytest.approx(0.5, abs=0.12)  # the margin, on a slope of 45°


def test_start_below_a_ceiling_has_less_energy_than_contact_there_would():
    case = scene(library.circle(1.0), Start(pi / 2, gap=1.2), Flight())
    part = stretch(case)
    # It starts 0.3 m below the middle, and falls: of the circle it meets what is lower.
    assert np.isfinite([part.low, part.high, part.length, part.top_speed]).all()
    # The centre can fall by 1.8 m in all, and 1.2 m of them are above its start.
    assert part.top_speed == pytest.approx((2 * G * (1.8 - 1.2)) ** 0.5, rel=0.01)


def test_load_may_take_a_plate_anywhere():
    case = scene(library.parabola(0.5, reach=4.0), Start(-1.0), Load(fx="sin(t)"))
    assert (stretch(case).low, stretch(case).high) == (-4.0, 4.0)


def test_chain_encloses_as_much_as_the_circle_it_stands_for():
    case = scene(library.circle(1.0), Start(-3.0, slip=20.0))
    corners = chain(case, 64)
    assert np.allclose(corners[:, 0], corners[:, -1])
    # Corners outside by R a²/12 with a = 2π/64: the mean distance of the facets is R, to fourth order in a.
    middle = np.hypot(*(0.5 * (corners[:, 1:] + corners[:, :-1])))
    ends = np.hypot(*corners)
    assert (2 * middle.mean() + ends.mean()) / 3 == pytest.approx(1.0, abs=2e-6)
    # A facet of radius 0.05 that lies as far behind touches the track.
    behind = np.hypot(*chain(case, 64, behind=0.05))
    assert behind == pytest.approx(ends + 0.05)


def test_polygon_has_the_outline_s_area_and_stands_off_by_its_sagitta():
    plate = Plate(library.ellipse(0.2, 0.12), 1.0, 0.01)
    case = scene(library.line(), Start(0.0), plate=plate)
    x, y = polygon(case.plate.outline, 48)
    assert 0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) == pytest.approx(pi * 0.2 * 0.12, rel=1e-6)
    off = np.abs((x / 0.2) ** 2 + (y / 0.12) ** 2 - 1).max() * 0.12 / 2
    assert 0.0 < off < sagitta(case, None, 48)


def test_sway_of_discs_is_none_of_a_wheel_its_eccentricity_and_of_an_ellipse_what_its_bends_say():
    assert sway(library.circle(0.1)) == pytest.approx(0.0, abs=1e-15)
    assert sway(Curve(lambda s: (0.02 + 0.1 * cos(s), 0.1 * sin(s)))) == pytest.approx(0.02, rel=1e-6)
    # At the flat side: a²/b − b.
    assert sway(library.ellipse(0.3, 0.2)) == pytest.approx(0.09 / 0.2 - 0.2, rel=1e-6)


def test_outlines_that_polygons_of_an_engine_can_be():
    assert is_convex(library.ellipse(0.3, 0.2))
    assert not is_convex(Curve(lambda s: ((0.2 + 0.05 * cos(3 * s)) * cos(s), (0.2 + 0.05 * cos(3 * s)) * sin(s))))
    assert not is_convex(library.catenary(0.3))
    # Its curvature touches zero four times.
    assert is_convex(library.superellipse(0.2, 0.15))


def test_rim_of_facets_stands_inside_any_outline_by_their_radius():
    outline = Curve(lambda s: ((0.2 + 0.05 * cos(3 * s)) * cos(s), (0.2 + 0.05 * cos(3 * s)) * sin(s)))
    s = np.linspace(0.0, 2 * pi, 4001)
    x, y = rim(outline, 400, inside=0.004)
    away = [float(np.hypot(outline.point(s)[0] - a, outline.point(s)[1] - b).min()) for a, b in zip(x, y, strict=True)]
    assert away == pytest.approx([0.004] * 401, abs=2e-5)
    edge = rim(Curve(lambda s: (s, -0.2), domain=(-0.2, 0.2)), 1, inside=0.01)
    assert edge == pytest.approx(np.array([[-0.2, 0.2], [-0.19, -0.19]]))


def test_outlines_that_a_fan_can_be():
    assert sees_all(library.ellipse(0.3, 0.2)) and sees_all(Curve(lambda s: (s, -0.2), domain=(-0.2, 0.2)))
    assert not sees_all(Curve(lambda s: (0.3 + 0.1 * cos(s), 0.1 * sin(s))))
