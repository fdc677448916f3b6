"""Driven tracks in engines, beside the rows of `test_motions`: the law of every route, and flights over them."""

from __future__ import annotations

import pytest

from adapters import engine
from adapters.laws import Route
from adapters.laws.effects import driven_track

ROUTES = [
    ("pymunk", "native"), ("pymunk", "assisted"), ("box2d", "native"), ("exudyn", "native"), ("exudyn", "integrator"),
]  # fmt: skip


# In the quick tests it is held to it in another scene, as to every law (`test_laws`).
@pytest.mark.slow
@pytest.mark.parametrize(("name", "route"), ROUTES)
def test_every_route_keeps_the_law_of_driven_tracks(name, route):
    pytest.importorskip(f"adapters.{name}")
    driven_track(Route(engine(name), route, 3))
