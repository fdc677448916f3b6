"""Splines through points: what they pass through, how smooth they are, which input is rejected."""

import pickle

import numpy as np
import pandas as pd
import pytest

from cases import BadCurve, BadValue, Curve, Plate
from cases.curves.point_sources import as_points


def cosine(count, depth=0.3):
    x = np.linspace(-3.0, 3.0, count)
    return np.column_stack([x, -depth * np.cos(2 * x)])


def ellipse_points(count, start=0.0):
    angle = start + np.linspace(0.0, 2 * np.pi, count, endpoint=False)
    return np.column_stack([np.cos(angle), 0.6 * np.sin(angle)])


def test_a_spline_passes_through_its_points_in_order():
    points = cosine(30)
    curve = Curve.spline(points)
    lengths = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    assert np.abs(curve.point(lengths).T - points).max() <= 1e-14
    assert curve.residual <= 1e-14 and curve.domain == (0.0, pytest.approx(lengths[-1], rel=1e-15))


@pytest.mark.parametrize("curve", [Curve.spline(cosine(30)), Curve.spline(ellipse_points(30), closed=True)])
def test_position_and_three_derivatives_are_continuous_at_every_knot(curve):
    pieces, sizes = curve.parts, np.abs(curve.jets(np.array(curve.knots))).max(axis=1)
    for number in range(0 if curve.period else 1, pieces.count):
        s = curve.knots[number]
        jump = np.subtract(pieces.jet_on(s, number), pieces.jet_on(s, number - 1))
        # Coefficients of the third derivative have the rounding of a place over the cube of a piece's length.
        length = np.diff(curve.knots).min()
        rounding = 1e-14 * np.repeat(length ** -np.arange(4.0), 2)
        assert np.all(np.abs(jump) <= rounding + 1e-14 * sizes), (number, jump)


def test_a_spline_of_exact_points_converges_with_its_order():
    """A quintic spline is of order 6; its curvature, by second derivatives, of order 4."""
    off = []
    for count in (30, 60, 120):
        curve = Curve.spline(cosine(count))
        s = np.linspace(0.2, 0.8, 2000) * curve.domain[1]
        x, y = curve.point(s)
        exact = 1.2 * np.cos(2 * x) / (1 + (0.6 * np.sin(2 * x)) ** 2) ** 1.5
        off.append((np.abs(y + 0.3 * np.cos(2 * x)).max(), np.abs(curve.curvature(s) - exact).max()))
    orders = np.log2(np.array(off[:-1]) / np.array(off[1:]))
    assert np.all(orders[:, 0] > 5.5) and np.all(orders[:, 1] > 3.5), orders


@pytest.mark.parametrize("closed", [False, True])
def test_smoothing_is_a_tolerance_in_metres(closed):
    points = ellipse_points(120) if closed else cosine(120)
    noise = np.random.default_rng(7).normal(0.0, 0.002, points.shape)
    curve = Curve.spline(points + noise, smoothing=0.008, closed=closed)
    assert 0.0 < curve.residual <= 0.008 and len(curve.knots) < 60
    s = np.linspace(0.05, 0.95, 400) * curve.domain[1]
    x, y = curve.point(s)
    off = np.hypot(x, y / 0.6) - 1.0 if closed else y + 0.3 * np.cos(2 * x)
    assert np.abs(off).max() <= 0.008  # nearer to the curve that was measured than the tolerance


def test_points_from_arrays_files_and_frames_are_the_same(tmp_path):
    points = cosine(20)
    file = tmp_path / "track.csv"
    file.write_text("x,y\n" + "\n".join(f"{float(x)!r},{float(y)!r}" for x, y in points))
    frame = pd.DataFrame({"time": range(20), "y": points[:, 1], "x": points[:, 0]})
    curves = [Curve.spline(source) for source in (points, points.tolist(), file, str(file), frame)]
    assert all(curve == curves[0] and hash(curve) == hash(curves[0]) for curve in curves)
    assert curves[0] != Curve.spline(points[:-1])


def test_svg_path_data_give_points_with_y_upwards():
    pytest.importorskip("svg.path")
    curve = Curve.spline("M 0 0 C 100 100 200 100 300 0", scale=0.001)
    end = curve.point(curve.domain[1])
    assert end == pytest.approx([0.3, 0.0], abs=1e-12)
    assert curve.point(curve.domain[1] / 2) == pytest.approx([0.15, -0.075], abs=1e-8)  # an SVG's y points down
    with pytest.raises(BadValue, match="cannot be read"):
        Curve.spline("M 0 0 C 1 1")


def test_a_track_may_cross_itself_where_that_is_allowed():
    angle = np.linspace(-2.5, 2.5, 80)
    loop = np.column_stack([angle - 2 * np.sin(angle), -2 * np.cos(angle)])
    with pytest.raises(BadCurve, match=r"crosses itself near \(.*allow it with may_cross=True"):
        Curve.spline(loop)
    curve = Curve.spline(loop, may_cross=True)
    assert curve.may_cross and pickle.loads(pickle.dumps(curve)) == curve
    with pytest.raises(BadCurve, match="outline of a plate cannot cross itself"):
        Plate(curve, 1.0, 1.0)


def airfoil_files():
    x = 0.5 * (1 - np.cos(np.linspace(0, np.pi, 41)))
    half = 0.2 * np.sqrt(x) * (1 - x)  # a round nose and a sharp tail, as wings have
    upper, lower = np.column_stack([x, half]), np.column_stack([x, -half])
    lines = lambda rows: "\n".join(f"  {a:.9f}  {b:.9f}" for a, b in rows)  # noqa: E731
    selig = "20-32C AIRFOIL\n" + lines(np.vstack([upper[::-1], lower[1:]])) + "\n"
    lednicer = f"NACA 0012 AIRFOIL\n  41.  41.\n\n{lines(upper)}\n\n{lines(lower)}\n"
    return np.vstack([upper[::-1], lower[1:]]), {"selig.dat": selig, "lednicer.dat": lednicer}


def test_airfoils_are_read_in_both_orders(tmp_path):
    points, files = airfoil_files()
    for name, text in files.items():
        (tmp_path / name).write_text(text)
        assert as_points(tmp_path / name) == pytest.approx(points, abs=1e-9)  # the digits of the file


def test_a_drawing_gives_its_only_path(tmp_path):
    pytest.importorskip("svg.path")
    data = "M 0 0 L 1 0 L 1 1"
    (tmp_path / "foot.svg").write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg"><g><path id="a" d="{data}"/></g></svg>'
    )
    assert (as_points(tmp_path / "foot.svg") == as_points(data)).all()
    (tmp_path / "none.svg").write_text("<svg><rect/></svg>")
    with pytest.raises(BadValue, match="no path element"):
        as_points(tmp_path / "none.svg")
    (tmp_path / "two.svg").write_text(f'<svg><path d="{data}"/><path d="{data}"/></svg>')
    with pytest.raises(BadValue, match="has 2 paths; leave one"):
        as_points(tmp_path / "two.svg")
    (tmp_path / "moved.svg").write_text(f'<svg><g transform="scale(2)"><path d="{data}"/></g></svg>')
    with pytest.raises(BadValue, match="has a transform attribute"):
        as_points(tmp_path / "moved.svg")
