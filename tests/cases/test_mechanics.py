"""Gravity, energy and the sizes of a plate, against what is known of them exactly."""

from __future__ import annotations

from math import pi
from types import SimpleNamespace

import numpy as np
import pytest

from cases import Case, Curve, Gravity, Plate, Start, Unilateral, disc, library
from cases.curves import cos, sin
from cases.motion.mechanics import energy, energy_growth, gravity, kinetic_energy


def on_a_line(*effects, plate: Plate | None = None) -> Case:
    return Case(library.line(), plate or disc(0.1, 2.0), (*effects, Unilateral()), Start(0.0), duration=1.0)


def test_reach_of_a_wheel_whose_mass_is_off_its_centre():
    off = Plate(Curve(lambda s: (0.03 + 0.1 * cos(s), 0.04 + 0.1 * sin(s))), 1.0, 0.01)
    # A sample is at most δ = 1/4 degree from the extreme, where the distance is off by e r δ²/2 over the distance.
    off_by = 0.05 * 0.1 * (pi / 720) ** 2 / 2
    assert off.reach == pytest.approx(0.15, abs=1.01 * off_by / 0.15)
    assert off.inner == pytest.approx(0.05, abs=1.01 * off_by / 0.05)


@pytest.mark.parametrize("direction", [-pi / 2, 0.3])
def test_energy_of_a_thrown_plate_is_constant_and_is_that_of_its_start(direction):
    case = on_a_line(Gravity(9.81, direction))
    t, (gx, gy) = np.linspace(0.0, 2.0, 101), gravity(case)
    thrown = SimpleNamespace(
        x=0.3 * t + 0.5 * gx * t**2, y=1.0 + 2.0 * t + 0.5 * gy * t**2,
        vx=0.3 + gx * t, vy=2.0 + gy * t, omega=np.full_like(t, 5.0),
    )  # fmt: skip
    begun = 0.5 * 2.0 * (0.3**2 + 2.0**2) + 0.5 * (0.5 * 2.0 * 0.1**2) * 5.0**2
    assert kinetic_energy(case, thrown)[0] == pytest.approx(begun, rel=1e-15)
    # Rounding of terms of up to 800 J.
    assert energy(case, thrown) == pytest.approx(begun - 2.0 * gy * 1.0, abs=1e-11)
    assert energy_growth(energy(case, thrown)).max() < 1e-11
