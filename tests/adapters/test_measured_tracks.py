"""Engines get a spline as they get any curve: as facets, or with our contact point."""

import numpy as np
import pytest

import reference
from adapters import lookup
from cases import Case, CoulombFriction, Curve, Gravity, Start, Unilateral, disc


def measured() -> Case:
    """A disc on forty points of a valley with a bump."""
    x = np.linspace(-1.5, 1.5, 40)
    track = Curve.spline(np.column_stack([x, 0.4 * x**2 + 0.05 * np.sin(4 * x)]))
    return Case(track, disc(0.1, 1.0), (Gravity(9.81), CoulombFriction(0.2), Unilateral()), Start(0.5), 0.5)


@pytest.mark.sampled(2)
@pytest.mark.parametrize("name, route", [("pymunk", "native"), ("pymunk", "assisted"), ("exudyn", "integrator")])
def test_an_engine_on_a_spline_converges_to_the_reference(name, route):
    engine = pytest.importorskip(name) and lookup.engine(name)
    case = measured()
    assert engine.refuses(case, route) is None
    truth, off = reference.simulate(case)(case.duration), []
    ladder = engine.ladder(case, route)
    for setting in (ladder[0], ladder[len(ladder) // 2]):
        model = engine.build(case, route, setting)
        engine.run(model)
        motion = engine.read(model)
        off.append(np.hypot(motion.x[-1] - truth.x, motion.y[-1] - truth.y))
    # In half a second the disc moves by 0.5 m; half-way up its ladder an engine is within a hundredth of that.
    assert off[1] < 5e-3 and (off[1] < off[0] or off[1] < 1e-6), off


def test_a_route_without_curves_says_so():
    assert "lines and circles" in (lookup.engine("exudyn").refuses(measured(), "native") or "")
