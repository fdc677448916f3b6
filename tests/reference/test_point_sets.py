"""Data as users have them become curves, and plates move on them: all 48 sets."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

import reference
from cases import Case, CoulombFriction, Curve, Gravity, Plate, Start, Unilateral, disc
from cases.library import line
from tests.sampling import quick_every
from tests.scenes.point_set_figure import figure
from tests.scenes.point_sets import point_sets

SETS = list(point_sets())
GRIP = (Gravity(9.81), CoulombFriction(0.2), Unilateral())


def curve_of(data) -> Curve:
    return Curve.spline(data.points, smoothing=data.tolerance, closed=data.closed)


def scene(data) -> Case:
    """A disc on a measured track, or a measured plate on an incline."""
    curve = curve_of(data)
    low, high = curve.span
    if data.closed:
        plate = Plate.homogeneous(curve, mass=1.0)
        parameters = np.linspace(*plate.outline.span, 721)  # it begins on its most curved place, as one is hollow
        xi2 = float(parameters[np.argmax(plate.outline.curvature(parameters))])
        return Case(line(0.3), plate, GRIP, Start(xi1=0.0, xi2=xi2), 1.0)
    # The disc fits everywhere; it moves for about the time of a fall along the track.
    bend = float(np.abs(curve.curvature(np.linspace(low, high, 2001))).max())
    duration = 2.0 * float(np.sqrt(data.extent / 9.81))
    return Case(curve, disc(0.5 / bend, 1.0), GRIP, Start(xi1=low + 0.2 * (high - low)), duration)


def test_there_are_48_sets():
    assert len(SETS) == 48 and len({data.name for data in SETS}) == 48


@quick_every(10)
@pytest.mark.parametrize(
    "data",
    [data if i % 3 == 0 else pytest.param(data, marks=pytest.mark.slow) for i, data in enumerate(SETS)],
    ids=lambda data: data.name,
)
def test_every_set_becomes_a_curve_with_its_deviation_and_a_picture(data):
    curve = curve_of(data)
    # Exact points are met to rounding of their place; others within the tolerance that was given.
    assert curve.residual <= (data.tolerance or 1e-14 * data.extent)
    distances, _ = cKDTree(curve.point(np.linspace(*curve.span, 40_001)).T).query(data.points)
    assert distances.max() <= curve.residual + 1e-4 * data.extent  # the samples' own distance
    true = cKDTree(data.shape(np.linspace(0.0, 1.0, 20_001)).T)
    off, _ = true.query(curve.point(np.linspace(*curve.span, 2001)).T)
    # 24 points do not resolve the coaster's hills better than that.
    assert off.max() <= max(data.tolerance, 0.007 * data.extent if "coarse" in data.name else 1e-4 * data.extent)
    assert len(curve.plot(data.points)._repr_png_()) > 5000


@quick_every(4)
@pytest.mark.parametrize(
    "data",
    [data if i % 6 == 0 else pytest.param(data, marks=pytest.mark.slow) for i, data in enumerate(SETS)],
    ids=lambda data: data.name,
)
def test_a_plate_moves_on_every_set(data):
    motion = reference.simulate(scene(data), rtol=1e-9)
    # The hollow of the bean may come to lie on two points.
    ends = ("completed", "lift_off", "track_end", *(("second_contact", "no_fit") if "bean" in data.name else ()))
    assert motion.status in ends, motion.reason
    assert motion.t[-1] > 0.0


@pytest.mark.slow
def test_the_figure_has_all_48_sets_with_their_deviations():
    titles = [ax.get_title() for ax in figure().axes]
    assert [title.splitlines()[0] for title in titles] == [data.name for data in SETS]
    for data, title in zip(SETS, titles, strict=True):
        points, shape = (float(part.split()[-1]) for part in title.splitlines()[1].split(","))
        assert points <= (data.tolerance / data.extent * 1.05 or 1e-14) and shape < 0.01
