"""Curves with corners and homogeneous plates: closed forms of areas, centres of mass and inertias; rejected input."""

from math import pi, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cases import Curve, Outline, Plate, arc, library
from cases.curves import cos, sin
from cases.curves.area import area_inside
from cases.curves.chain import translate
from cases.curves.corner import Edge
from tests.scenes.elliptic import examples

# The integrals are sums of tens to hundreds of terms, summed exactly; each term has a few roundings.
EXACT = 1e-15


def gear_moment(radius, teeth, depth):
    """Second polar moment and area of the gear's triangles from its middle, ∫ r² = (|a|² + a·b + |b|²)·area/6."""
    steps = 2 * pi / teeth * np.array([0.25, 0.25, 0.25, 0.25])
    ends = [(radius, radius), (radius, radius - depth), (radius - depth, radius - depth), (radius - depth, radius)]
    areas = [a * b * np.sin(step) / 2 for (a, b), step in zip(ends, steps, strict=True)]
    moments = [
        area * (a * a + a * b * np.cos(step) + b * b) / 6 for area, (a, b), step in zip(areas, ends, steps, strict=True)
    ]
    return teeth * sum(moments), teeth * sum(areas)


# Half disc: centroid at 4r/(3π), J = m r²(1/2 − 16/(9π²)). Reuleaux: each of three sectors of radius d and angle π/3
# counted once, less two triangles of side d. A triangle of sides a, b, c: m (a² + b² + c²)/36.
@pytest.mark.parametrize(
    ("plate", "inertia"),
    [
        (lambda: Plate.half_disc(0.3, 2.0), 2.0 * 0.3**2 * (0.5 - 16 / (9 * pi**2))),
        (lambda: Plate.rectangle(0.4, 0.3, 3.0), 3.0 * (0.4**2 + 0.3**2) / 12),
        (lambda: Plate.polygon([(1, 1), (5, 1), (1, 4)], 2.0), 2.0 * (9 + 16 + 25) / 36),
        (lambda: Plate.homogeneous(translate(library.ellipse(2.0, 0.5), 7.0, -3.0), 1.5), 1.5 * (4 + 0.25) / 4),
        (lambda: Plate.homogeneous(library.circle(1.0), 1.0, holes=[library.circle(0.5)]), (1 + 0.25) / 2),
        (lambda: Plate.homogeneous(library.circle(1.0), 3.0, inlays=[(library.circle(0.5), 5.0)]), 3 * (1 + 0.25) / 4),
        (lambda: Plate.gear(0.1, 12, 0.02, 1.0), np.divide(*gear_moment(0.1, 12, 0.02))),
    ],
)  # fmt: skip
def test_inertias_are_the_published_ones(plate, inertia):
    assert plate().inertia == pytest.approx(inertia, rel=EXACT)


def test_reuleaux_triangle_has_constant_width_and_its_area():
    plate = Plate.reuleaux(0.2, 1.0)
    assert area_inside(plate.outline).area == pytest.approx(0.5 * (pi - sqrt(3)) * 0.04, rel=4 * EXACT)
    low, high = plate.outline.span
    x, y = plate.outline.point(np.linspace(low, high, 3001))
    widths = [np.ptp(x * np.cos(a) + y * np.sin(a)) for a in np.linspace(0, pi, 40)]
    np.testing.assert_allclose(widths, 0.2, rtol=1e-6)  # 3,000 samples
    assert plate.outline.point(0.5 * (plate.outline.pieces[0].span[1] + low))[1] < 0


@examples(12, 40)
@given(st.lists(st.tuples(st.floats(0.5, 2.0), st.floats(0.0, 1.0)), min_size=3, max_size=8), st.floats(-50, 50))
def test_polygon_is_the_sum_of_its_triangles(rays, shift):
    """Star-shaped polygons about a shifted point; the shoelace formulas about that point."""
    angles = 2 * pi * (np.arange(len(rays)) + 0.4 * np.array([part for _, part in rays])) / len(rays)
    points = np.array([r for r, _ in rays]) * np.array([np.cos(angles), np.sin(angles)])
    x, y = points
    u, v = np.roll(points, -1, axis=1)
    cross = x * v - y * u
    area, polar = cross.sum() / 2, (cross * (x * x + x * u + u * u + y * y + y * v + v * v)).sum() / 12
    centre = np.array([((x + u) * cross).sum(), ((y + v) * cross).sum()]) / (6 * area)
    plate = Plate.polygon((points.T + shift).tolist(), 1.0)
    # The points themselves are rounded at the distance of the shift.
    rounding = 1e-13 * (1 + abs(shift))
    assert plate.inertia == pytest.approx(polar / area - centre @ centre, rel=rounding)
    first = plate.outline.point(plate.outline.span[0])
    np.testing.assert_allclose(first, points[:, 0] - centre, atol=rounding)


def test_chain_is_continuous_in_place_and_direction_over_two_rounds():
    outline = Plate.gear(0.1, 5, 0.03, 1.0).outline
    low, high = outline.span
    s = np.linspace(low - (high - low), high, 20001)
    step = s[1] - s[0]
    assert np.abs(np.diff(outline.tangent_angle(s))).max() <= 1.001 * step  # corners turn by their parameter, edges not
    assert np.hypot(*np.diff(outline.point(s), axis=1)).max() <= 1.001 * step  # edges have unit speed
    assert outline.tangent_angle(high) - outline.tangent_angle(low) == pytest.approx(2 * pi)
    assert len(outline.corners) == 20 and sum(corner.turn < 0 for corner in outline.corners) == 10
    x0, x1, y0, y1 = outline.bounds
    assert max(x1 - x0, y1 - y0) < 0.2


@pytest.mark.parametrize(
    ("clockwise", "as_it_is_taken"),
    [
        (
            lambda: Plate.polygon([(0, 0), (0, 1), (2, 1), (2, 0)], 1.0),
            Plate.polygon([(0, 0), (2, 0), (2, 1), (0, 1)], 1.0),
        ),
        (
            lambda: Plate.homogeneous(Outline((arc((0, 0), 1, 0, -pi), Edge.between((-1, 0), (1, 0)))), 1.0),
            Plate.half_disc(1.0, 1.0),
        ),
        (
            lambda: Plate.homogeneous(Curve(lambda s: (2 * cos(s), -sin(s))), 1.0),
            Plate.homogeneous(library.ellipse(2.0, 1.0), 1.0),
        ),
    ],
    ids=["points", "pieces", "smooth curve"],
)
def test_a_clockwise_outline_is_turned_round_and_says_so(clockwise, as_it_is_taken):
    with pytest.warns(UserWarning, match="runs clockwise"):
        plate = clockwise()
    assert plate.inertia == pytest.approx(as_it_is_taken.inertia, rel=1e-12)  # the rounding of its integrals
    assert plate.outline.tangent_angle(plate.outline.span[1]) > plate.outline.tangent_angle(plate.outline.span[0])
