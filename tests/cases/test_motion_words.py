"""A motion in words has the modes of each contact, and says which plates rest or do not turn."""

import pytest

import reference
from cases import (
    Belt,
    Case,
    CoulombFriction,
    Curve,
    Drive,
    Flight,
    Gravity,
    Impact,
    Plate,
    Start,
    Support,
    Unilateral,
    disc,
)
from cases.library import line

BOUNCE = Gravity(9.81), Unilateral(), Flight(), Impact(0.0)
BOX, MU = Plate.rectangle(0.1, 0.1, 1.0), CoulombFriction(0.5)
WALL = Support(Curve(lambda s: (0.8, s)), "wall")
# Scenes, and what is said of them.
SCENES = {
    "disc at rest": (
        Case(line(), disc(0.1, 1.0), (*BOUNCE, MU), Start(0.0), 0.5),
        "rests to the end of 0.5 s",
    ),
    "disc on a shaken table": (
        Case(line(), disc(0.1, 1.0), (*BOUNCE, Drive(y="0.02*sin(30*t)")), Start(0.0), 0.025),
        "rests for 0.0192 s, then flies to the end of 0.025 s",
    ),
    "disc that rolls": (
        Case(line(), disc(0.1, 1.0), (*BOUNCE, MU), Start(0.0, slip=1.0), 0.5),
        "slides forward for 0.068 s, then rolls to the end of 0.5 s",
    ),
    "thrown box": (
        Case(line(), BOX, (*BOUNCE, MU), Start(0.0, xi2=0.05, slip=1.0), 1.0),
        "plate/track and plate/track 2: slides forward for 0.204 s, then rests to the end of 1 s",
    ),
    "box on a belt": (
        Case(line(), BOX, (*BOUNCE, MU, Belt("t")), Start(0.0, xi2=0.05), 1.0),
        "plate/track and plate/track 2: sticks to the end of 1 s",
    ),
    "disc between floor and wall": (
        Case(line(), disc(0.1, 1.0), (*BOUNCE, CoulombFriction(0.2)), Start(0.0, slip=2.0), 1.0, supports=(WALL,)),
        "plate/track: slides forward for 0.34 s, then rolls for 0.1 s, then flies for 0.0544 s, then slides backward "
        "for 0.15 s, then rests to the end of 1 s; plate/wall: flies for 0.44 s, then slides backward for 0.204 s, "
        "then rests to the end of 1 s",
    ),
}


@pytest.mark.parametrize("name", SCENES)
def test_motion_in_words(name):
    case, words = SCENES[name]
    assert reference.simulate(case, method="dop853").in_words() == words
