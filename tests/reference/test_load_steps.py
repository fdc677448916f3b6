"""Loads with a step in time: what follows from it is at the step, by every solver, and certified."""

import random

import pytest
import sympy as sp

import reference
from cases import (
    BadValue,
    Case,
    CoulombFriction,
    Flight,
    Gravity,
    Impact,
    Load,
    Plate,
    RollingResistance,
    Start,
    StartPose,
    Trajectory,
    Unilateral,
    block,
    disc,
    effects,
)
from cases.formulas.time_steps import RISE
from cases.library import circle, line

from .test_belts_and_supports import METHODS, motion_by

G, MU, PUSH, AT = 9.81, 0.3, 5.0, 0.5
T = effects.MOTION[0]
# The same push from 0.5 s to 1 s.
PUSHES = (
    f"{PUSH}*({AT} < t)*(t <= 1)",
    f"{PUSH}*({AT} < t < 1)",
    f"{PUSH} if {AT} < t < 1 else 0",
    f"{PUSH}*({AT} < t and not (t < 0 or t >= 1))",
    sp.Piecewise((0, T < AT), (PUSH, T < 1), (0, True)),
    PUSH * (sp.Heaviside(T - AT) - sp.Heaviside(T - 1)),
    sp.Piecewise((PUSH, (T > AT) & ~(T >= 1)), (0, True)),
)


def pushed(load, duration: float = 3.0, plate=None) -> Case:
    effects_of = (Gravity(G), CoulombFriction(MU), Unilateral(), Load(fx=load))
    return Case(line(), plate or block(0.4, 0.2, 1.0), effects_of, Start(0.0), duration)


@METHODS
@pytest.mark.parametrize("load", PUSHES, ids=range(len(PUSHES)))
def test_a_block_begins_to_slide_at_the_step_and_stops_by_newton(load, method):
    motion = motion_by(pushed(load), method)
    begins, stops = motion.transitions
    gain, loss = PUSH - MU * G, MU * G
    stop = 1.0 + gain * (1.0 - AT) / loss
    assert (str(begins.before), str(begins.after)) == ("rest", "slip_forward")
    assert [begins.time, stops.time] == pytest.approx([AT, stop], abs=3 * RISE)
    way = 0.5 * gain * (1.0 - AT) ** 2 * (1.0 + gain / loss)
    if isinstance(motion, Trajectory):  # the second formulation has its transitions alone
        assert motion(3.0).x == pytest.approx(way, abs=3 * RISE)


def test_its_transitions_are_certified_and_it_obeys_the_laws():
    pytest.importorskip("heyoka")
    case = pushed(PUSHES[0])
    certificate = reference.certify(case)
    assert [time.value for _, _, time, _ in certificate.transitions] == pytest.approx([AT, 1.349473326], abs=3 * RISE)
    assert max(time.bar for _, _, time, _ in certificate.transitions) < 1e-12
    assert not [*reference.check(case, reference.simulate(case))]


# In 74 a corner's impacts end, the other one closing before their end.
@pytest.mark.parametrize("number", [*range(0, 60, 4), 74])
def test_steps_between_random_scenes_end_nothing(number):
    """Discs that roll, slip and fly, boxes and rolling resistance, under steps of force and moment."""
    draw = random.Random(number)
    one, two = sorted((draw.uniform(0.05, 0.5), draw.uniform(0.5, 0.95)))
    load = Load(
        f"{draw.uniform(-8, 8)}*(t > {one}) + {draw.uniform(-8, 8)}*(t > {two})",
        f"{draw.uniform(-5, 15)}*(t > {two})", f"{draw.uniform(-0.2, 0.2)}*(t > {one})",
    )  # fmt: skip
    law = (
        Gravity(G),
        CoulombFriction(draw.uniform(0.05, 0.6)),
        Unilateral(),
        Flight(),
        Impact(draw.choice([0.0, 0.5])),
    )
    box, slip = Plate.rectangle(0.4, 0.2, 1.0), draw.choice([0.0, 1.0])
    case = [
        Case(line(draw.uniform(0, 0.3)), disc(0.1, 1.0), (*law, load), Start(0.0, slip=slip), 1.0),
        Case(line(), box, (*law, load), Start(0.0, slip=slip), 1.0),
        Case(circle(1.0), disc(0.1, 1.0), (*law, load), Start(draw.uniform(-2.5, -0.6)), 1.0),
        Case(line(), disc(0.1, 1.0), (*law, load, RollingResistance(0.01)), Start(0.0), 1.0),
        Case(line(), box, (*law, load), StartPose(0.0, 0.3, 0.3), 1.0),
    ][number % 5]
    assert reference.simulate(case).status == "completed"


@pytest.mark.parametrize(
    ("load", "words"),
    [
        ("5*(vx > 0.5)", "compares other than t with a number; write a step in time such as t > 0.5"),
        ("5*(t*t > 0.5)", "compares other than t with a number"),
        ("5*(t == 0.5)", "compares other than by <, <=, > or >="),
        (sp.Piecewise((5, T < 1)), "a Piecewise without a value at some times; end it with (0, True)"),
        (sp.Piecewise((5, effects.MOTION[4] < 1), (0, True)), "compares other than t"),
        (sp.Piecewise((5, sp.Eq(T, 1)), (0, True)), "write a step in time such as t > 0.5"),
    ],
)
def test_what_is_no_step_in_time_is_one_sentence(load, words):
    with pytest.raises(BadValue) as error:
        Load(fx=load)
    assert words in str(error.value) and "\n" not in str(error.value)
