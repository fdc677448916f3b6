"""Scenes on supports: random ones, and their motions compared in two formulations and with the paper's matrix."""

from functools import lru_cache

import pytest

import reference
from cases import (
    Case,
    Curve,
    Flight,
    Gravity,
    Impact,
    Unilateral,
)  # fmt: skip
from cases.curves import cos as cosine
from cases.curves import sin as sine

G = 9.81
FREE = Gravity(G), Unilateral(), Flight()
INELASTIC = (*FREE, Impact(0.0, "moreau"))


def hill(radius: float, x: float, y: float) -> Curve:
    """The outside of a circle."""
    return Curve(lambda s: (x + radius * sine(s), y + radius * cosine(s)))


def bowl(radius: float, x: float, y: float) -> Curve:
    """The inside of a circle."""
    return Curve(lambda s: (x + radius * cosine(s), y + radius * sine(s)))


def events(motion) -> list[tuple]:
    return [(t.contact, t.before, t.after) for t in motion.transitions]


def slow(*values):
    """Parameters of the slow tests; the quick ones run a sample."""
    return [pytest.param(value, marks=pytest.mark.slow) for value in values]


@lru_cache(maxsize=8)
def simulated(case: Case):
    """The motion at the finest tolerance, computed once for tests of the same scene."""
    return reference.simulate(case, rtol=1e-14)
