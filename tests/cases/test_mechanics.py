"""Gravity, energy and the sizes of a plate, against what is known of them exactly."""

from __future__ import annotations

from dataclasses import replace
from math import pi, sqrt
from types import SimpleNamespace

import numpy as np
import pytest

import cases
from cases import Case, Curve, Gravity, Plate, Start, Unilateral, disc, library
from cases.curves import cos, sin
from cases.motion.mechanics import energy, energy_growth, gravity, kinetic_energy


def ellipse(a: float, b: float) -> Plate:
    return Plate(library.ellipse(a, b), 2.0, 2.0 * (a * a + b * b) / 4)


def on_a_line(*effects, plate: Plate | None = None) -> Case:
    return Case(library.line(), plate or disc(0.1, 2.0), (*effects, Unilateral()), Start(0.0), duration=1.0)


def test_reach_and_inner_distance_of_an_ellipse_are_its_half_axes():
    plate = ellipse(0.3, 0.2)
    assert plate.reach == pytest.approx(0.3, rel=1e-15)
    assert plate.inner == pytest.approx(0.2, rel=1e-15)


def test_reach_of_a_wheel_whose_mass_is_off_its_centre():
    off = Plate(Curve(lambda s: (0.03 + 0.1 * cos(s), 0.04 + 0.1 * sin(s))), 1.0, 0.01)
    # A sample is at most δ = 1/4 degree from the extreme, where the distance is off by e r δ²/2 over the distance.
    off_by = 0.05 * 0.1 * (pi / 720) ** 2 / 2
    assert off.reach == pytest.approx(0.15, abs=1.01 * off_by / 0.15)
    assert off.inner == pytest.approx(0.05, abs=1.01 * off_by / 0.05)


def test_gyration_of_a_homogeneous_disc_and_of_an_elliptic_plate():
    assert disc(0.1, 3.0).gyration == pytest.approx(0.1 / sqrt(2), rel=1e-15)
    assert ellipse(0.3, 0.2).gyration == pytest.approx(sqrt(0.3**2 + 0.2**2) / 2, rel=1e-15)


def test_gravity_pulls_down_unless_it_is_directed():
    assert gravity(on_a_line(Gravity(9.81))) == pytest.approx([0.0, -9.81])
    assert gravity(on_a_line(Gravity(9.81, direction=0.0))) == pytest.approx([9.81, 0.0])
    assert np.all(gravity(on_a_line()) == 0.0)


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


def test_energy_without_gravity_is_kinetic():
    case = on_a_line()
    moving = replace_with(case, vx=3.0, vy=4.0, omega=0.0)
    assert energy(case, moving) == kinetic_energy(case, moving) == pytest.approx(25.0)


def replace_with(case: Case, **rates) -> SimpleNamespace:
    return SimpleNamespace(**(cases.contact.start_motion(case)._asdict() | rates))


def test_growth_is_counted_from_the_least_so_far():
    assert energy_growth(np.array([5.0, 3.0, 4.0, 1.0, 3.5, 3.0])).tolist() == [0.0, 0.0, 1.0, 0.0, 2.5, 2.0]


def test_a_plate_replaced_has_its_own_sizes():
    plate = ellipse(0.3, 0.2)
    assert plate.reach and replace(plate, outline=library.circle(0.1)).reach == pytest.approx(0.1)
