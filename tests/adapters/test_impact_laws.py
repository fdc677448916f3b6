"""Which law of impact each engine has: single impacts, measured, and what the rows of the report say of it."""

from math import pi

import numpy as np
import pytest

import cases
import reference
from adapters import engine, other_laws
from adapters.interface import Meaning
from adapters.lookup import engines
from cases import (
    Case,
    CoulombFriction,
    Flight,
    Gravity,
    Impact,
    Plate,
    RollingResistance,
    Start,
    Unilateral,
    disc,
)
from cases.effects import IMPACT_LAWS
from cases.library import ellipse, line
from reports.running.tasks import find_truth, measure
from tests.sampling import quick_every

from .engines import play

DISC, PLATE = disc(0.1, 1.0), Plate(ellipse(0.2, 0.1), 1.0, 0.0125)


def thrown(plate: Plate, xi2: float, slip: float, omega: float, e: float, law: str) -> Case:
    """One impact on a level line, at about 0.04 s; nothing meets the line again before 0.06 s."""
    effects = (Gravity(9.81), CoulombFriction(0.3), Unilateral(), Flight(), Impact(e, law))
    return Case(line(), plate, effects, Start(0.0, xi2, gap=0.05, gap_rate=-1.0, slip=slip, omega=omega), 0.08)


def after(motion) -> np.ndarray:
    """(vx, vy, ω) of an engine's motion at its first sample from 0.06 s on."""
    place = int(np.searchsorted(motion.t, 0.06))
    return np.array([motion.vx[place], motion.vy[place], motion.omega[place]])


def true(case: Case) -> np.ndarray:
    """(vx, vy, ω) at 0.06 s."""
    state = reference.simulate(case)(0.06)
    return np.array([state.vx, state.vy, state.omega])


def played(name: str, route: str, case: Case) -> np.ndarray:
    return after(play(name, route, case))


def test_pymunks_law_is_moreaus():
    # An ellipse whose slip reverses by Routh's construction: the three laws are 0.05 m/s and 0.2 rad/s apart.
    truths = {law: true(thrown(PLATE, -1.9, 0.3, 3.0, 0.5, law)) for law in IMPACT_LAWS}
    found = played("pymunk", "native", thrown(PLATE, -1.9, 0.3, 3.0, 0.5, "poisson"))
    # Its polygon of 800 corners meets the line up to 1e-3 m beside the ellipse's point; the arm is 0.1 m.
    assert np.abs(found - truths["moreau"]).max() < 0.01
    for law in ("poisson", "newton"):
        assert np.abs(found - truths[law]).max() > 0.1


def test_the_contact_that_pymunk_is_told_closes_by_moreaus_law_without_restitution():
    case = thrown(PLATE, -1.2, 0.3, 3.0, 0.0, "moreau")
    assert played("pymunk", "assisted", case) == pytest.approx(true(case), abs=1e-3)


def test_box2d_adds_the_restitution_without_its_friction():
    case = thrown(DISC, -pi / 2, 2.0, 0.0, 0.5, "poisson")
    fall = np.sqrt(1.0 + 2 * 9.81 * 0.05)
    found, exact = played("box2d", "native", case), true(case)
    assert found[0] == pytest.approx(2.0 - 0.3 * fall, abs=1e-3)
    assert exact[0] == pytest.approx(2.0 - 0.3 * 1.5 * fall, abs=1e-9)


def test_exudyns_spring_gives_a_disc_the_same_impact():
    case = thrown(DISC, -pi / 2, 2.0, 0.0, 0.5, "poisson")
    # Restitution comes out to a thousandth, and the impact takes some periods of the spring.
    assert played("exudyn", "native", case) == pytest.approx(true(case), rel=5e-3)


@pytest.mark.parametrize(("name", "plate", "e", "law", "differs"), [
    ("pymunk", PLATE, 0.5, "poisson", True), ("pymunk", PLATE, 0.0, "newton", True),
    ("pymunk", PLATE, 0.5, "moreau", False), ("pymunk", DISC, 0.5, "poisson", False),
    ("box2d", DISC, 0.5, "moreau", True), ("box2d", DISC, 0.0, "poisson", False),
    ("box2d", PLATE, 0.0, "moreau", False), ("box2d", PLATE, 0.0, "poisson", True),
    ("exudyn", DISC, 0.5, "poisson", False),
])  # fmt: skip
def test_an_adapter_says_for_which_cases_its_law_is_another(name, plate, e, law, differs):
    pytest.importorskip(f"adapters.{name}")
    output = other_laws(engine(name), thrown(plate, -pi / 2, 0.5, 0.0, e, law), "native")
    assert bool(output) is differs
    assert all(phrase.startswith("Impact by another law: ") for phrase in output)


@pytest.mark.parametrize("name", engines())
def test_every_engine_tells_what_its_parameters_mean(name):
    pytest.importorskip(f"adapters.{name}")
    meanings = engine(name).MEANINGS
    assert all(isinstance(meaning, Meaning) and meaning.parameter and meaning.law for meaning in meanings)
    assert {CoulombFriction, Impact, RollingResistance} <= {meaning.effect for meaning in meanings}
    for meaning in meanings:
        has_impacts = meaning.effect is Impact and meaning.law != "not supported"
        assert bool(meaning.duration) is has_impacts, meaning


def run(name: str, route: str, label: str, rung: int = 3):
    pytest.importorskip(f"adapters.{name}")
    case, adapter = cases.load(label), engine(name)
    return measure(case, name, route, adapter.ladder(case, route)[rung], rung, find_truth(case))


@pytest.mark.slow
def test_where_its_law_is_asked_for_it_is_judged_as_any_other():
    row = run("pymunk", "native", "tumbling_ellipse_moreau")
    assert "another law" not in row.reason
    # What is left is its polygon's: with twice the corners, and half the step, nearer.
    assert run("pymunk", "native", "tumbling_ellipse_moreau", 5).distance.centre_max < 0.6 * row.distance.centre_max


# --- flights ----------------------------------------------------------------------------------------------------------

FLIES, SLOW = (Gravity(9.81), Unilateral(), Flight()), disc(0.1, 2.0, inertia=0.012)
FALL = (2 * 0.5 / 9.81) ** 0.5  # s, from 0.5 m


@quick_every(3)
@pytest.mark.parametrize("e", [0.0, 0.3, 0.8])
@pytest.mark.parametrize("name", ["exudyn", "pymunk", "box2d"])
def test_dropped_disc_bounces_with_its_restitution(name, e):
    case = Case(line(0.0), SLOW, (*FLIES, Impact(e)), Start(0.0, gap=0.5), 0.9)
    moved = play(name, "native", case, 4)
    # After the first landing it rises to e² of its height, or stays.
    most = 8e-3 if name == "box2d" else 4e-3
    assert (moved.y - 0.1)[moved.t > FALL + 2 * moved.t[1]].max() == pytest.approx(0.5 * e**2, abs=most)
    assert np.abs(moved.y - reference.simulate(case, rtol=1e-11)(moved.t).y).max() < most
