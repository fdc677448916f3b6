"""Driven tracks in engines, beside the rows of `test_motions`: the law of every route, and flights over them."""

from __future__ import annotations

import numpy as np
import pytest

import cases
import reference
from adapters import engine
from adapters.laws import Route
from adapters.laws.effects import driven_track

from .engines import play

ROUTES = [
    ("pymunk", "native"), ("pymunk", "assisted"), ("box2d", "native"), ("exudyn", "native"), ("exudyn", "integrator"),
]  # fmt: skip


# In the quick tests it is held to it in another scene, as to every law (`test_laws`).
@pytest.mark.slow
@pytest.mark.parametrize(("name", "route"), ROUTES)
def test_every_route_keeps_the_law_of_driven_tracks(name, route):
    pytest.importorskip(f"adapters.{name}")
    driven_track(Route(engine(name), route, 3))


# Box2D's disc hops 2.3 cm by default, less than gravity moves it within two steps.
@pytest.mark.parametrize(("name", "rung"), [("pymunk", 0), ("pymunk", 2), ("box2d", 2)])
def test_nothing_touches_a_disc_in_flight_over_a_driven_track(name, rung):
    """The change of the track's acceleration within a step counted as a contact force, which ended no flight."""
    case = cases.load("disc_on_bouncing_table")
    first, second = (transition.time for transition in reference.simulate(case).transitions[:2])
    motion = play(name, "native", case, rung)
    flies = (motion.t > first + 0.02) & (motion.t < second - 0.02)  # longer than a step
    assert np.sum(flies) > 3
    assert np.all(motion.normal_force[flies] == 0.0) and np.all(np.isnan(motion.slip[flies]))


def test_assisted_motion_is_in_the_fixed_frame_with_forces():
    case = cases.load("disc_on_accelerated_plate")
    moved = play("pymunk", "assisted", case, 4)
    assert moved.x[-1] - moved.x[0] == pytest.approx(reference.simulate(case)(moved.t[-1]).x, abs=1e-5)
    assert np.all(np.isfinite(moved.normal_force))
