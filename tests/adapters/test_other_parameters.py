"""Another parameter of a curve changes no shape that an engine is given, and no motion that it makes of it."""

import importlib
import json
from functools import lru_cache

import numpy as np
import pytest

import cases
from adapters.by_process.engine_geometry import mjcf, sdf
from adapters.by_process.scene_file import curve_samples, scene
from adapters.common import facets
from cases import Case, CoulombFriction, Curve, Gravity, Start, Unilateral, disc
from tests.sampling import quick_every
from tests.scenes.motions import in_other_parameters, warped

from .engines import play

EFFECTS = (Gravity(9.81), CoulombFriction(0.15), Unilateral())


def endless(**changes) -> Case:
    """A disc on a wavy parabola without ends; 2 s."""
    track = Curve(("s", "0.05*s**2 + 0.03*cos(3*s)"))
    return Case(**(dict(track=track, plate=disc(0.1, 1.0), effects=EFFECTS, start=Start(-1.5), duration=2.0) | changes))


SCENES = {
    "endless": endless,
    "disc_in_circle": lambda: cases.select("disc_in_circle")[0],
    "disc_in_cosine": lambda: cases.select("disc_in_cosine")[0],
    "disc_off_ramp": lambda: cases.select("disc_off_ramp")[0],
    "ellipse_on_line": lambda: cases.select("ellipse_on_line")[0],
}
# With a unit that is no power of a thousand, too.
LINEAR = {f"parameter*{unit:g}": lambda case, unit=unit: in_other_parameters(case, unit) for unit in (1e-6, 0.3, 1e6)}


def shapes(case: Case) -> dict[str, np.ndarray]:
    """What engines are given, in metres and metres per second."""
    part = facets.stretch(case)
    given = dict(stretch=[part.length, part.top_speed, part.closed], chain=facets.chain(case, 200))
    if facets.is_convex(case.plate.outline):
        given["polygon"] = facets.polygon(case.plate.outline, 48)
    return {name: np.asarray(value, dtype=float) for name, value in given.items()}


@pytest.mark.parametrize("name", SCENES)
def test_shapes_by_a_warped_parameter_differ_by_the_error_of_their_samples_alone(name):
    case = SCENES[name]()
    here, there = shapes(case), shapes(warped(case))
    for shape, own in here.items():
        # Lengths are sums of trapezoids over 2000 samples: h²/12 of a parameter that changes by a third in a period,
        # of which the longest stretch has 13.
        assert np.abs(there[shape] - own).max() <= 2e-5 * max(1.0, float(np.abs(own).max())), shape


@quick_every(4)
@pytest.mark.parametrize("how", LINEAR)
@pytest.mark.parametrize("name", ["endless", "disc_in_circle", "disc_in_cosine"])
def test_exported_scenes_do_not_depend_on_the_unit_of_a_parameter(name, how):
    case = SCENES[name]()
    here, there = (curve_samples(scene_) for scene_ in (case, LINEAR[how](case)))
    for curve in ("track", "outline"):
        # Points, normals, curvatures; the first column is the parameter.
        assert there[curve][:, 1:] == pytest.approx(here[curve][:, 1:], rel=1e-9, abs=1e-12)


def test_an_exported_track_without_ends_is_where_the_plate_may_come():
    """y = x²/1000 is 20 km long where it is drawn: samples 20 m apart are no track for a disc of 0.1 m."""
    case = endless(track=Curve(("s", "s**2/1000")), start=Start(-1.0))
    x = curve_samples(case)["track"][:, 1]
    assert x.min() < -1.0 and 0.9 < x.max() < 10.0
    assert np.diff(x).max() < 0.1 * case.plate.radius
    for text in (mjcf(case), sdf(case)):
        assert len(text) > 1000
    json.dumps(scene(case))


@lru_cache
def motion(engine: str, route: str, name: str, how: str):
    """The motion at the coarsest setting, or None where the route does not support the case."""
    adapter = importlib.import_module(f"adapters.{engine}")
    own = SCENES[name]()
    if adapter.refuses(own, route):
        return None
    return play(engine, route, LINEAR[how](own) if how else own, setting=adapter.ladder(own, route)[0])


ROUTES = [("pymunk", "native"), ("pymunk", "assisted"), ("exudyn", "native"), ("exudyn", "integrator")]


@quick_every(3)
@pytest.mark.parametrize("how", ["parameter*1e-06", "parameter*1e+06"])
@pytest.mark.parametrize("name", ["disc_in_circle", "disc_in_cosine", "ellipse_on_line", "endless"])
@pytest.mark.parametrize(("engine", "route"), ROUTES)
def test_engines_move_alike_by_every_unit_of_a_parameter(engine, route, name, how):
    pytest.importorskip(engine)
    here, there = (motion(engine, route, name, one) for one in ("", how))
    if here is None:
        pytest.skip("the route does not support the case")
    assert there.status == here.status and len(there.t) == len(here.t)
    for quantity in ("t", "x", "y", "theta"):
        # Some hundred steps at the coarsest setting, in which a rounding of a facet grows a thousandfold.
        assert getattr(there, quantity) == pytest.approx(getattr(here, quantity), abs=1e-9), quantity
    # A sample at a facet's corner has the velocity of one side of it or of the other, as its rounding falls.
    off = np.abs(there.slip - here.slip)
    assert np.mean(off > 1e-8) <= 0.02
