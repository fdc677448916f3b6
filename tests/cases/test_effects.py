"""What a case may ask for, and what makes no sense together."""

import pytest

import cases
from cases import (
    BadValue,
    Case,
    CoulombFriction,
    DoesNotFit,
    Flight,
    Gravity,
    Impact,
    Load,
    PerfectlyRough,
    RollingResistance,
    Start,
    Unilateral,
    disc,
)
from cases.contact import find, start_motion
from cases.library import line

ROUGH = (Gravity(9.81), CoulombFriction(0.2), Unilateral())


class Sandpaper(PerfectlyRough):
    """A class of an author's own; it must not pass for another kind of effect than PerfectlyRough."""


class Sticky(CoulombFriction):
    """The same of CoulombFriction."""


def level(effects, **start):
    return Case(line(), disc(0.5, 2.0), effects, Start(xi1=0.0, **start), 1.0)


@pytest.mark.parametrize(
    "make, says",
    [
        (lambda: level((Gravity(9.81), RollingResistance(0.01))), "CoulombFriction or PerfectlyRough"),
        (lambda: level((Gravity(9.81), Flight())), "add it or remove Flight"),
        (lambda: level((Gravity(9.81), Unilateral(), Impact(0.5))), "needs Flight"),
        (lambda: level((CoulombFriction(0.1), PerfectlyRough())), "contradict"),
        (lambda: level((CoulombFriction(0.1), Sandpaper())), "give PerfectlyRough"),
        (lambda: level((CoulombFriction(0.1), Sticky(0.3))), "give CoulombFriction"),
        (lambda: level((PerfectlyRough(), Sticky(0.3))), "give CoulombFriction"),
        (lambda: level(ROUGH, gap=0.1), "add Flight"),
        (lambda: level(ROUGH, gap_rate=0.1), "add Flight"),
        (lambda: level((*ROUGH, Flight()), gap_rate=-0.1), "add Impact"),
        (lambda: level((Gravity(9.81), PerfectlyRough()), slip=0.1), "slip=0"),
        (lambda: Impact(1.5), "between 0 and 1"),
        (lambda: Impact(0.5, law="hertz"), "poisson"),
        (lambda: RollingResistance(0.0), "arm"),
        (lambda: Load(), "leave Load out"),
        (lambda: Load(fx="2*w"), "use t, x, y, theta, vx, vy, omega"),
        (lambda: Load(fx=float("nan")), "finite"),
        (lambda: Load(fx="__import__('os')"), "fx of Load"),
        (lambda: Load(fx=[1.0]), "fx of Load"),
        (lambda: level(ROUGH, gap=-0.1), "gap"),
    ],
)
def test_nonsense_is_refused_in_one_sentence_that_names_it(make, says):
    with pytest.raises((BadValue, DoesNotFit)) as output:
        make()
    assert says in str(output.value) and "\n" not in str(output.value)


def test_load_is_a_number_a_text_or_an_expression():
    t, *_, vx, _, omega = cases.effects.MOTION
    load = Load(fx="-0.5*vx + sin(2*t)", moment=-0.1 * omega)
    assert load.at(0.25, 0, 0, 0, 2.0, 0, 3.0) == pytest.approx([-1.0 + 0.479425538604203, 0.0, -0.3], abs=1e-15)
    assert load == Load(fx=-0.5 * vx + cases.curves.sin(2 * t), moment=-0.1 * omega)


def test_start_off_the_track_has_its_gap_and_its_point_its_velocity():
    case = level((*ROUGH, Flight()), gap=0.3, gap_rate=0.7, slip=-0.2, omega=1.5)
    start = start_motion(case)
    assert (start.x, start.y) == (0.0, 0.8)
    assert find(case, start.x, start.y, start.theta, (0.0, start.xi2)).gap == pytest.approx(0.3, abs=1e-15)
    # The lowest point of the disc moves with the centre and ω × arm, the arm being (0, −1/2).
    assert start.vx + 0.5 * start.omega == pytest.approx(-0.2, abs=1e-15)
    assert start.vy == pytest.approx(0.7, abs=1e-15)
