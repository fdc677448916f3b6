"""Belts whose speed changes with time in engines: a closed form on a line, and the reference on circles and a curve."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

import cases
from adapters import engine
from adapters.interface import refusal
from cases import Belt, Case, CoulombFriction, Drive, Gravity, Start, Unilateral, disc
from cases.library import circle, hill, line
from tests.adapters.test_engine_effects import off, play

GRIP = (Gravity(9.81), CoulombFriction(0.3), Unilateral())
SPEED = "0.6*t + 0.1*sin(6*t)"
# The finer rung, and the error of the velocity (m/s) allowed on a line there: twice to five times what was measured.
ROUTES = {
    ("pymunk", "native"): (4, 2e-10),
    ("pymunk", "assisted"): (4, 2e-10),
    ("box2d", "native"): (4, 2e-4),
    ("exudyn", "integrator"): (2, 5e-5),
}
EACH = pytest.mark.parametrize(("name", "route"), ROUTES)


@pytest.mark.sampled(3)
@EACH
def test_a_disc_that_rolls_has_a_third_of_its_belts_speed(name, route):
    """m v̇ = T, J ω̇ = r T and v + r ω = u(t) with J = m r²/2 give v = u/3, while |u̇|/3 ≤ μ g."""
    pytest.importorskip(f"adapters.{name}")
    case = Case(line(), disc(0.1, 2.0), (*GRIP, Belt(SPEED)), Start(0.0), 1.5)
    errors, (finer, least) = [], ROUTES[name, route]
    for rung in (1, finer):
        motion = play(name, route, case, rung)
        exact = (0.6 * motion.t + 0.1 * np.sin(6.0 * motion.t)) / 3.0
        errors.append(float(np.abs(motion.vx - exact).max()))
        assert np.abs(motion.slip).max() <= max(2.0 * motion.slip_resolution, 3.0 * errors[-1], 1e-12)
    assert errors[1] < least and errors[1] < 0.5 * errors[0]


CURVED = {
    "drum": Case(circle(1.0), disc(0.1, 2.0), (*GRIP, Belt(SPEED)), Start(-pi / 2), 1.2),
    "hill": Case(hill(1.0), disc(0.1, 2.0), (*GRIP, Belt("0.5*sin(3*t)")), Start(0.05), 0.6),
    "parabola": Case(
        cases.Curve(lambda s: (s, s**2), domain=(-2, 2)), disc(0.1, 2.0), (*GRIP, Belt(SPEED)), Start(0.2), 1.2
    ),
}
# Distance (m) allowed at the fourth rung: twice to five times what was measured.
FAR = {
    ("pymunk", "native", "drum"): 2e-3,
    ("pymunk", "native", "hill"): 1e-5,
    ("pymunk", "native", "parabola"): 2e-3,
    ("box2d", "native", "drum"): 1e-3,
    ("box2d", "native", "hill"): 5e-5,
    ("exudyn", "integrator", "drum"): 1e-6,
    ("exudyn", "integrator", "parabola"): 2e-5,
}


# Exudyn's contact law is evaluated in Python, 7 s for each.
EACH_TRACK = [pytest.param(*key, marks=[pytest.mark.slow] if key[0] == "exudyn" else []) for key in FAR]


@pytest.mark.sampled(3)
@pytest.mark.parametrize(("name", "route", "track"), EACH_TRACK)
def test_belts_of_varying_speed_along_curves_converge_to_the_reference(name, route, track):
    pytest.importorskip(f"adapters.{name}")
    case = CURVED[track]
    coarse, fine = (off(case, play(name, route, case, rung))[0] for rung in (1, 4))
    assert fine < FAR[name, route, track] and fine < 0.6 * coarse


def test_what_cannot_be_carried_is_rejected_in_one_sentence():
    pytest.importorskip("adapters.box2d")
    why = refusal(engine("box2d"), CURVED["parabola"], "native")
    assert why and "only lines and circles" in why
    both = Case(line(), disc(0.1, 2.0), (*GRIP, Belt(SPEED), Drive(x="0.1*sin(t)")), Start(0.0), 1.0)
    assert "not both" in (refusal(engine("box2d"), both, "native") or "")
    assert "constant speed" in (refusal(engine("exudyn"), CURVED["drum"], "native") or "")
