"""What engines with straight shapes are given: the part of a track that a plate can reach, corners, how far they stand
off, and how far a plate's rolling sways its centre."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

from adapters.common.facets import chain, is_convex, polygon, rim, sagitta, stretch, sway
from cases import Case, Curve, Gravity, Plate, Start, Unilateral, disc, library
from cases.contact import start_motion
from cases.curves import cos, sin

G = 9.81


def scene(track, start, *effects, plate=None, duration=2.0) -> Case:
    return Case(track, plate or disc(0.1, 1.0), (Gravity(G), Unilateral(), *effects), start, duration)


def test_plate_at_rest_reaches_as_high_as_it_starts_and_its_own_size_farther():
    case = scene(library.parabola(0.5, reach=4.0), Start(-1.0))
    part, track = stretch(case), case.track
    # By symmetry; the margin is one radius along the track at both ends, and the walk has 2000 steps.
    assert part.low == pytest.approx(-part.high, abs=0.01)
    assert np.hypot(*(track.point(part.low) - track.point(-1.0))) == pytest.approx(0.1, abs=0.01)
    # ½ v² = g (fall of the centre).
    fall = start_motion(case).y - (track.point(0.0)[1] + 0.1)
    assert part.top_speed == pytest.approx((2 * G * fall) ** 0.5, rel=1e-3)


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
