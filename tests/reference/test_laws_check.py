"""The check of laws: it finds planted faults of right motions, and none in the motions of the catalogue."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from math import cos, sin

import numpy as np
import pytest

import cases
import reference
from cases import (
    BadValue,
    Case,
    CoulombFriction,
    Curve,
    Flight,
    FreePlate,
    Gravity,
    Impact,
    Plate,
    StartPose,
    Support,
    Trajectory,
    Unilateral,
    disc,
)
from cases.library import line
from reference.laws_check.penetration import depths
from reference.laws_check.samples import PlateSamples


@cache
def right(label: str) -> Trajectory:
    """The motion of a case, which breaks no law."""
    motion = reference.simulate(cases.load(label))
    assert reference.check(cases.load(label), motion) == ()
    return motion


def friction(mu: float, stick: float | None = None) -> Callable[[Case], Case]:
    """The scene with another friction."""
    return lambda case: with_effect(case, CoulombFriction(mu, stick))


def with_effect(case: Case, effect) -> Case:
    """The scene with an effect in the place of that of its kind."""
    return replace(case, effects=(*(e for e in case.effects if type(e) is not type(effect)), effect))


CIRCLE = "disc_in_circle[mu=0.2]"


# A wedge of two discs on a floor, at a wall: (mass of the upper disc, friction, angle of the line of centres).
WEDGES = [
    (0.5, 0.3, 0.6),
    (0.2, 0.3, 0.9),
    (1.0, 0.3, 0.9),
    (0.2, 0.6, 0.6),
    (0.5, 0.6, 0.6),
    (1.0, 0.6, 0.6),
    (0.2, 0.6, 0.9),
]


@pytest.mark.parametrize("method", reference.METHODS)
@pytest.mark.parametrize("mass, mu, phi", WEDGES)
def test_a_disc_that_falls_through_the_floor_is_never_completed(mass, mu, phi, method):
    motion = reference.simulate(wedge(mass, mu, phi), method=method)
    lowest = float(motion.plate("b").y.min())
    assert lowest > 0.1 - 1e-9 or motion.status == "broken_law"
    if motion.status == "broken_law":
        assert "no overlap at b/track" in motion.reason and "completed" in motion.reason


def wedge(mass: float, mu: float, phi: float) -> Case:
    """A disc on another one, at a wall."""
    effects = Gravity(9.81), CoulombFriction(mu), Unilateral(), Flight(), Impact(0.0, "moreau")
    wall = Support(Curve(("0", "-s")), "wall")
    upper = FreePlate(disc(0.1, mass), StartPose(0.1, 0.2 + 0.3 * cos(phi)), "b")
    return Case(
        line(), disc(0.2, 1.0), effects, StartPose(0.1 + 0.3 * sin(phi), 0.2), 1.5, supports=(wall,), others=(upper,)
    )


@pytest.mark.parametrize("name", cases.names()[::9])
@pytest.mark.parametrize("rtol", [1e-10, 1e-6])
def test_motions_of_the_catalogue_break_no_law(name, rtol):
    for case in cases.select(name):
        motion = reference.simulate(case, rtol=rtol)
        assert motion.status != "broken_law", motion.reason
        if motion.dense is not None:
            assert reference.check(case, motion, rtol) == ()


def test_check_needs_a_dense_motion():
    with pytest.raises(BadValue, match="dense"):
        reference.check(cases.load(CIRCLE), replace(right(CIRCLE), dense=None))


@pytest.mark.parametrize("radius", [0.0, 0.02])
def test_a_box_in_a_wave_is_found_to_overlap(radius):
    """Turned to the tangent of the wave's inflection, its side lies on the line through it, and enters the hollow on
    one side: by 0.05 (sin u − u) cos(angle) at u = 4 x, where the side ends, and less than at the box's corner."""
    wave, angle = Curve(("s", "0.05*sin(4*s)"), (-3.0, 3.0)), np.arctan(0.2)
    case = Case(
        wave, Plate.rectangle(0.2, 0.1, 1.0, radius), (Gravity(9.81), Unilateral(), Flight()), StartPose(0.0, 0.5), 1.0
    )
    place = 0.05 * complex(-np.sin(angle), np.cos(angle)) + np.zeros((1, 25))
    nothing = np.zeros((1, 25))
    plate = PlateSamples(place, np.exp(1j * angle) + nothing, nothing + 0j, nothing, angle + nothing)
    every = list(depths(case, nothing, [plate], {"track": np.array([0.0])}))
    least, most = (0.05 * (u - np.sin(u)) * np.cos(angle) for u in (0.39 - 4.0 * radius, 0.4))
    assert [one.pair for one in every] == ["plate/track"] * 3
    assert 0.9 * least < every[0].depths[0] < most
