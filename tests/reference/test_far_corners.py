"""Corners that stay apart are not searched for meetings, and no meeting is missed for it."""

from math import cos, pi, sin

import pytest

import reference
from cases import Case, CoulombFriction, Flight, Gravity, Impact, Plate, StartPose, Unilateral
from cases.library import line
from reference.solver import meet
from tests.scenes.walled_plates import random_walled_plates


def polygon(sides: int, spin: float) -> Case:
    """A regular polygon that falls on a line and rolls, or tumbles, over its corners."""
    corners = [(0.1 * cos(2 * pi * k / sides), 0.1 * sin(2 * pi * k / sides)) for k in range(sides)]
    effects = (Gravity(9.81), CoulombFriction(0.5), Unilateral(), Flight(), Impact(0.0))
    return Case(line(), Plate.polygon(corners, 1.0), effects, StartPose(0.0, 0.13, 0.1, 1.0, 0.0, spin), 0.15)


CASES = [
    *(polygon(sides, spin) for sides, spin in ((40, -10.0), (12, 30.0), (5, -25.0))),
    *(random_walled_plates(seed, duration=0.3) for seed in (2474928891, 2474928900, 17)),
]


@pytest.mark.parametrize("case", CASES, ids=range(len(CASES)))
def test_no_meeting_is_missed(case, monkeypatch):
    motions = []
    for few in (0, 10**9):  # all couples are looked at first, and none
        monkeypatch.setattr(meet, "FEW", few)
        motions.append(reference.simulate(case, method="dop853"))
    assert motions[0].status == motions[1].status == "completed" and motions[0].transitions
    assert motions[0].transitions == motions[1].transitions
