"""Driven tracks in engines: each route converges to the reference where it supports the scene, else it says why not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import cases
import reference
from adapters import engine
from adapters.interface import refusal
from adapters.laws import Route
from adapters.laws.effects import driven_track
from cases import Belt, Case, CoulombFriction, Drive, Gravity, Load, Start, Unilateral, disc
from cases.library import circle, line
from tests.adapters.test_engine_effects import off, play

# Distance (m) allowed at the fourth rung: twice to five times what was measured.
ROUTES = {
    ("pymunk", "native"): 3e-2,
    ("pymunk", "assisted"): 2e-5,
    ("box2d", "native"): 5e-2,
    ("exudyn", "native"): 1e-4,
    ("exudyn", "integrator"): 1e-4,
}
EACH = pytest.mark.parametrize(("name", "route"), ROUTES)


@pytest.mark.sampled(4, first=1)
@EACH
def test_disc_in_a_bowl_that_swings_and_shakes_converges_to_the_reference(name, route):
    """A track that turns about a point off its centre, shaken along both axes."""
    pytest.importorskip(f"adapters.{name}")
    drive = Drive(x="0.05*sin(7*t)", y="0.02*cos(5*t)", angle="0.3*sin(3*t)")
    bowl = cases.Curve(lambda s: (cases.curves.cos(s), 0.3 + cases.curves.sin(s)))
    effects = (Gravity(9.81), CoulombFriction(0.3), Unilateral(), drive)
    case = Case(bowl, disc(0.1, 2.0), effects, Start(-2.0, omega=1.0), 1.2)
    coarse, fine = (off(case, play(name, route, case, rung)) for rung in (1, 3))
    assert fine[0] < ROUTES[name, route] and fine[1] < 10 * ROUTES[name, route]
    assert fine[0] < 0.7 * coarse[0]
    # Without the drive it would be elsewhere: the test can fail.
    still = replace(case, effects=tuple(e for e in case.effects if e is not drive))
    assert off(case, reference.simulate(still))[0] > 2 * ROUTES[name, route]


# In the quick tests it is held to it in another scene, as to every law (`test_laws`).
@pytest.mark.slow
@EACH
def test_every_route_keeps_the_law_of_driven_tracks(name, route):
    pytest.importorskip(f"adapters.{name}")
    driven_track(Route(engine(name), route, 3))


# Box2D's disc hops 2.3 cm by default, less than gravity moves it within two steps.
@pytest.mark.parametrize(("name", "rung"), [("pymunk", 0), ("pymunk", 2), ("box2d", 2)])
def test_nothing_touches_a_disc_in_flight_over_a_driven_track(name, rung):
    """The change of the track's acceleration within a step counted as a contact force, which ended no flight."""
    pytest.importorskip(f"adapters.{name}")
    case = cases.load("disc_on_bouncing_table")
    first, second = (transition.time for transition in reference.simulate(case).transitions[:2])
    motion = play(name, "native", case, rung)
    flies = (motion.t > first + 0.02) & (motion.t < second - 0.02)  # longer than a step
    assert np.sum(flies) > 3
    assert np.all(motion.normal_force[flies] == 0.0) and np.all(np.isnan(motion.slip[flies]))


def test_load_in_the_fixed_frame_acts_on_a_driven_track():
    """pymunk's load is evaluated in the fixed frame, that of its body."""
    drive, load = Drive(x="0.05*sin(7*t)"), Load(fx="-4*x - 0.5*vx")
    effects = (Gravity(9.81), CoulombFriction(0.3), Unilateral(), drive, load)
    case = Case(line(), disc(0.1, 2.0), effects, Start(0.3), 1.0)
    for route in ("native", "assisted"):
        assert off(case, play("pymunk", route, case, 4))[0] < 1e-5


def test_belt_on_a_driven_table_in_box2d_and_pymunk():
    effects = (Gravity(9.81), CoulombFriction(0.3), Unilateral(), Drive(x="0.05*sin(7*t)"), Belt(0.5))
    case = Case(line(), disc(0.1, 2.0), effects, Start(0.0), 1.0)
    assert off(case, play("pymunk", "native", case, 4))[0] < 1e-5
    pytest.importorskip("adapters.box2d")
    assert off(case, play("box2d", "native", case, 4))[0] < 5e-3


@pytest.mark.slow
def test_belt_in_a_drum_that_turns():
    """The surface velocity is that of the contact, along its own tangent, in addition to the turning track's."""
    turning = (Gravity(9.81), CoulombFriction(0.3), Unilateral(), Drive(angle="0.3*sin(3*t)"), Belt(0.5))
    case = Case(circle(1.0), disc(0.1, 2.0), turning, Start(-1.5), 1.0)
    assert refusal(engine("pymunk"), case, "assisted") is None
    coarse, fine = (off(case, play("pymunk", "native", case, rung))[0] for rung in (1, 4))
    assert fine < 3e-3 and fine < 0.5 * coarse
    # Without the belt it would be elsewhere: the test can fail.
    still = replace(case, effects=turning[:-1])
    assert off(case, reference.simulate(still))[0] > 2e-2


def test_assisted_motion_is_in_the_fixed_frame():
    case = cases.load("disc_on_accelerated_plate")
    moved = play("pymunk", "assisted", case, 4)
    assert moved.x[-1] - moved.x[0] == pytest.approx(reference.simulate(case)(moved.t[-1]).x, abs=1e-5)
    assert np.all(np.isfinite(moved.normal_force))
