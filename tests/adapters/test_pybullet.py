"""pybullet against exact values; the laws it obeys are those of test_laws."""

import numpy as np
import pytest

import cases
from cases import (
    Case,
    CoulombFriction,
    Curve,
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
from reports.judging.slip_phases import read_transitions
from tests.authorities.paper_application import FIRST_TRANSITION, SEQUENCE
from tests.scenes.elliptic import ellipse

pybullet = pytest.importorskip("adapters.pybullet")


def solve(case, rung):
    model = pybullet.build(case, "assisted", pybullet.ladder(case, "assisted")[rung])
    pybullet.run(model)
    return pybullet.read(model)


def test_first_transition_converges_with_the_square_of_the_step():
    case = cases.load("disc_in_circle", mu=0.1)
    steps, errors = [], []
    for rung in (2, 3, 4, 5):
        motion = solve(case, rung)
        steps.append(motion.t[1])
        errors.append(abs(read_transitions(motion, 0.1)[0].time - FIRST_TRANSITION[0.1][0]))
    order = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert order == pytest.approx(2.0, abs=0.3)
    # A second-order step is off by h² over the time scale of the motion, √(r/g) = 0.1 s; it was 1.1 h² per second.
    assert errors[-1] < steps[-1] ** 2 / 0.1


def test_four_transitions_at_a_friction_of_a_fifth_none_invented():
    motion = solve(cases.load("disc_in_circle", mu=0.2), 5)
    found = [event.time for event in read_transitions(motion, 0.2)]
    # The engine locates nothing inside a step.
    assert found == pytest.approx([time for time, _ in SEQUENCE], abs=motion.t[1])


def test_engine_as_it_comes_is_the_first_rung_and_told_so():
    first, *others = pybullet.ladder(cases.load("disc_in_circle"), "assisted")
    assert first["rung"] == "defaults"
    assert len(others) >= 5
    assert all(fine["h"] < coarse["h"] for coarse, fine in zip(others, others[1:], strict=False))


def test_plate_that_is_no_disc_and_bilateral_guide_are_refused():
    circle = Curve(lambda s: (1.0 * cases.curves.cos(s), 1.0 * cases.curves.sin(s)))
    guided = Case(circle, disc(0.1, 1.0), (Gravity(9.81),), Start(0.0), 1.0)
    plate = cases.Plate(ellipse(0.2, 0.1), 1.0, 0.0125)
    elliptic = Case(circle, plate, (Gravity(9.81), Unilateral()), Start(0.0, xi2=0.0), 1.0)
    assert "bilateral guide" in pybullet.refuses(guided, "assisted")
    assert "no circle" in pybullet.refuses(elliptic, "assisted")


@pytest.mark.parametrize(
    "effects",
    [(Load(fx=1.0),), (PerfectlyRough(),), (CoulombFriction(0.1), RollingResistance(0.01)), (Flight(), Impact(0.5))],
)
def test_effects_nobody_told_the_engine_are_refused_by_name(effects):
    case = Case(ellipse(1.0, 1.0), disc(0.1, 1.0), (Gravity(9.81), Unilateral(), *effects), Start(0.0), 1.0)
    reason = pybullet.refuses(case, "assisted")
    assert all(type(effect).__name__ in reason for effect in effects if not isinstance(effect, CoulombFriction))


def test_track_that_ends_ends_the_motion():
    track = Curve(lambda s: (s, -0.5 * s), domain=(-1.0, 1.0))
    motion = solve(Case(track, disc(0.1, 1.0), (Gravity(9.81), Unilateral()), Start(0.0), 2.0), 3)
    assert motion.status == "track_end"
    assert motion.xi1[-1] <= 1.0
