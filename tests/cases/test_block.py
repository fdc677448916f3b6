"""A block that slides and does not turn: its motion is a particle's, its picture a rectangle along the track."""

from math import cos, radians, sin

import numpy as np
import pytest

import reference
from cases import Case, CoulombFriction, Gravity, Start, Unilateral, block, library
from cases.pictures.layout import Instant, place_outline

G, MU, SLOPE = 9.81, 0.2, radians(30)
WIDTH, HEIGHT = 0.2, 0.1


def on_incline(plate):
    effects = (Gravity(G), CoulombFriction(MU), Unilateral())
    return Case(library.line(SLOPE), plate, effects, Start(0.0), 1.0)


def test_a_block_slides_down_an_incline_as_a_particle():
    motion = reference.simulate(on_incline(block(WIDTH, HEIGHT, 1.5)))
    assert motion(0.8).slip == pytest.approx(G * (sin(SLOPE) - MU * cos(SLOPE)) * 0.8, rel=1e-13)  # roundings
    assert motion(0.8).omega == 0.0


def test_a_block_is_drawn_along_its_track():
    case = on_incline(block(WIDTH, HEIGHT, 1.0))
    state = reference.simulate(case)(0.5)
    for contact in (state.xi1, np.nan):  # in contact; in flight, above the nearest point
        corners, _ = place_outline(case.scene, Instant(state.x, state.y, state.theta, contact, 1.0))
        across = corners[0] * sin(SLOPE) + corners[1] * cos(SLOPE)  # distances of its corners from the incline
        # The nearest point in flight is one of 1,001 along the track, which is straight: only roundings remain.
        assert sorted(across) == pytest.approx([0, 0, 0, HEIGHT, HEIGHT], abs=1e-12)
        assert np.ptp(corners[0] * cos(SLOPE) - corners[1] * sin(SLOPE)) == pytest.approx(WIDTH)
