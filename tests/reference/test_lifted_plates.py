"""Plates at rest that are lifted off their tracks leave at the exact time, with all contacts at once.

Weight and load cancel there, and with them every force of the contact and every acceleration: nothing that vanishes may
be the scale of a decision (`reference.scales`).
"""

from math import asin, inf, sqrt

import pytest

import reference
from cases import Case, CoulombFriction, Drive, Flight, Gravity, Load, Mode, Plate, Start, Unilateral, disc
from cases.library import circle, line
from reference.certification.witnesses import _by_second
from tests.scenes.lifted_plates import lifted_plate

G = 9.81
METHODS = pytest.mark.parametrize("method", reference.METHODS)
WEIGHT = Gravity(G), Unilateral(), Flight()
TABLE = Drive(y="0.02*sin(30*t)")
LEAVES_TABLE = asin(G / (0.02 * 30.0**2)) / 30.0


def lifted(plate: Plate, *effects, end=0.2, **start) -> Case:
    """A plate at rest on a level line."""
    return Case(line(), plate, (*WEIGHT, *effects), Start(0.0, **start), end)


BOX, FRICTION = Plate.rectangle(0.2, 0.1, 1.0), CoulombFriction(0.5)
# Scenes, the time at which the plate leaves (s), and the number of its contacts.
SCENES = {
    "disc on a shaken table": (lifted(disc(0.1, 1.0), TABLE, end=0.1), LEAVES_TABLE, 1),
    "rough disc on a shaken table": (lifted(disc(0.1, 1.0), TABLE, FRICTION, end=0.1), LEAVES_TABLE, 1),
    "disc under a t**2": (lifted(disc(0.1, 2.0), Load(fy="2000*t**2")), sqrt(2.0 * G / 2000.0), 1),
    "weight in the load's formula": (
        Case(line(), disc(0.1, 1.0), (Unilateral(), Flight(), Load(fy="-9.81 + 79.52*t")), Start(0.0), 0.2),
        G / 79.52, 1,
    ),
    "load that is one vanishing term": (
        Case(line(), disc(0.1, 1.0), (Unilateral(), Flight(), Load(fy="-9.81*cos(30*t)")), Start(0.0), 0.1),
        3.141592653589793 / 60.0, 1,
    ),
    "box": (lifted(BOX, Load(fy="79.52*t"), xi2=0.1), G / 79.52, 2),
    "box not on its middle": (lifted(BOX, Load(fy="79.52*t"), xi2=0.03), G / 79.52, 2),
    "rough box": (lifted(BOX, Load(fy="79.52*t"), FRICTION, xi2=0.1), G / 79.52, 2),
}  # fmt: skip


def flights(changes) -> list[float]:
    return [change.time for change in changes if change.after is Mode.FLIGHT]


@METHODS
@pytest.mark.parametrize("name", SCENES)
def test_lifted_plate_leaves_at_the_exact_time(name, method):
    case, time, contacts = SCENES[name]
    motion = reference.simulate(case, rtol=1e-12, method=method)
    assert motion.status == "completed"
    assert flights(motion.transitions) == pytest.approx([time] * contacts, abs=1e-14)


@METHODS
def test_lift_a_billionth_above_the_weight_is_a_lift_off(method):
    """Without Flight: N = m (100 (t - 1/2)² - 1e-9 g) vanishes first at 1/2 - √(1e-11 g)."""
    load = Load(fy="9.81*(1 + 1e-9) - 100*(t - 0.5)**2")
    case = Case(line(), Plate(circle(0.1), 1.0, inf), (Gravity(G), Unilateral(), load), Start(0.0), 1.0)
    motion = reference.simulate(case, rtol=1e-12, method=method)
    assert motion.status == "lift_off"
    # The force has slope 2e-3 N/s there and a rounding of some 1e-15 N.
    assert motion.t[-1] == pytest.approx(0.5 - sqrt(1e-11 * G), abs=1e-11)


def check(seed: int) -> None:
    """Both formulations of a random scene leave at its exact time."""
    case, time, contacts = lifted_plate(seed)
    status = "completed" if case.effect(Flight) else "lift_off"
    motion, second = reference.simulate(case, rtol=1e-12, method="dop853"), _by_second(case, "second", 1e-13)
    # The second formulation predicts times to about 1e-9 s.
    for one, accuracy in ((motion, {"rel": 1e-10}), (second, {"rel": 0.0, "abs": 1e-9})):
        assert one.status == status, (seed, one)
        assert flights(one.transitions) == pytest.approx([time] * contacts, **accuracy), seed


# The first ten, and two boxes that had no mode.
QUICK = (*range(10), 19, 21)


@pytest.mark.parametrize("seed", QUICK)
def test_random_lifted_plates(seed):
    check(seed)
