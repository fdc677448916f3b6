"""Friction by the slip speed in pymunk's own contacts: the reference on lines, in circles, on belts, driven tracks and
several contacts."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import pytest

import cases
from adapters import engine
from cases import Case, CoulombFriction, Drive, Gravity, Start, Unilateral, disc
from cases.library import circle, line
from cases.moving_surface import TIME
from tests.adapters.test_engine_effects import off, play

LAW = CoulombFriction("0.1 + 0.3*exp(-v/0.2) + 0.05*v")
EFFECTS = (Gravity(9.81), LAW, Unilateral())
SCENES = {
    "stribeck_disc": cases.load("stribeck_disc"),
    "block_on_viscous_ramp": cases.load("block_on_viscous_ramp"),
    "slider_on_belt_falling_law": cases.load("slider_on_belt_falling_law"),
    "block_on_stribeck_belt": cases.load("block_on_stribeck_belt"),
    "circle": Case(circle(1.0), disc(0.1, 1.0), EFFECTS, Start(-pi / 2, slip=2.0), 0.8),
    # The plate's acceleration of 6 m/s^2 needs a friction of 0.2 to roll on, and has 0.1 + 0.1 v.
    "driven line": Case(
        line(),
        disc(0.1, 1.0),
        (Gravity(9.81), CoulombFriction("0.1 + 0.1*v"), Unilateral(), Drive(x=3.0 * TIME**2)),
        Start(0.0),
        1.0,
    ),
}
# The finer rung, and the distance (m) allowed there: two to five times what was measured. The coarser one is the first
# after the defaults.
FAR = {
    "stribeck_disc": (4, 1e-7),
    # It stops inside a step, at any part of it, before it slides back: the error is of order h and scatters.
    "block_on_viscous_ramp": (5, 1e-4),
    "slider_on_belt_falling_law": (4, 3e-5),
    "block_on_stribeck_belt": (4, 1e-5),
    "circle": (5, 3e-4),
    "driven line": (4, 1e-4),
}


def without_law(case: Case) -> Case:
    """The case with the coefficient at rest for all slip velocities."""
    return replace(
        case, effects=tuple(CoulombFriction(e.at_rest) if isinstance(e, CoulombFriction) else e for e in case.effects)
    )


@pytest.mark.sampled(6)
@pytest.mark.parametrize("scene", SCENES)
def test_pymunks_own_contacts_have_friction_by_the_slip_speed(scene):
    pytest.importorskip("adapters.pymunk")
    case, (finer, least) = SCENES[scene], FAR[scene]
    coarse, fine = (off(case, play("pymunk", "native", case, rung))[0] for rung in (1, finer))
    assert fine < least and fine < 0.3 * coarse
    # With the coefficient at rest alone it would be elsewhere: the test can fail.
    adapter, other = engine("pymunk"), without_law(case)
    model = adapter.build(other, "native", adapter.ladder(case, "native")[finer])
    adapter.run(model)
    assert off(case, adapter.read(model))[0] > 10 * least
