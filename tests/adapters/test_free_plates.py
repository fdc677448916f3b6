"""Several free plates in engines: motions compared with exact answers, and what is read and judged of them."""

from __future__ import annotations

from dataclasses import replace
from math import atan, cos, pi, sin, sqrt, tan

import numpy as np
import pytest

import cases
import reference
from adapters import EngineFailure, engine, gate, other_laws
from adapters.laws import judge
from cases import Case, CoulombFriction, Curve, FreePlate, Mode, StartPose, Support
from reports.judging import several_contacts
from reports.judging.distances import differences
from tests.sampling import quick_every

from .engines import play
from .mutants import Hashable

# Engines, and the error of a sum of momenta: rounding of velocities of 1 m/s in a hundred to 1,300 steps, and Newton's
# tolerance.
NATIVE = {"pymunk": 2e-13, "box2d": 1e-4, "exudyn": 1e-10}
EACH = pytest.mark.parametrize("name", NATIVE)
STEPPERS = pytest.mark.parametrize("name", ["pymunk", "box2d"])


# The weaker a contact, the more steps are between two pushes: 1.6 to 5.1 steps are measured; 1.9 ms of Exudyn.
@pytest.mark.parametrize(("name", "rung", "late"), [
    ("pymunk", 0, 0.0), ("pymunk", 3, 0.0), ("box2d", 0, 0.0), ("box2d", 3, 0.0), ("exudyn", 6, 4e-3),
])  # fmt: skip
def test_a_disc_leaves_a_free_disc_and_momentum_stays(name, rung, late):
    """It leaves after 0.444077645 s (derived in tests/reference/test_free_plates.py); the floor is without friction."""
    motion = play(name, "native", cases.load("disc_on_free_disc"), rung)
    assert np.abs(2.0 * motion.vx + motion.plate("upper").vx).max() < NATIVE[name]
    last = np.flatnonzero(np.isfinite(motion.contacts["upper/plate"].slip))[-1]
    assert abs(motion.t[last] - 0.444077645) < (late or 6.0 * motion.t[1])
    assert set(motion.contact_names) == {"plate/track", "upper/track", "upper/plate"}


@STEPPERS
def test_a_free_wedge_gives_way_under_a_disc(name):
    """Without friction its acceleration is m g sin α cos α/(M + m sin²α): it comes from the force at the slope, whose
    direction is that of an edge."""
    motion, slope = play(name, "native", cases.load("disc_on_free_wedge"), 3), atan(0.5)
    rate = 9.81 * sin(slope) * cos(slope) / (3.0 + sin(slope) ** 2)
    way = motion.plate("plate").x - motion.plate("plate").x[0]
    # At 1 and 2 ms the engines are 5e-6 and 4e-4 of the way off; with the mass of the disc alone it would be 15 %.
    assert abs(way[-1] / (-0.5 * rate * motion.t[-1] ** 2) - 1.0) < 1e-3
    assert set(motion.contact_names) == {"plate/track", "plate/track 2", "disc/plate"}
    columns, middle = motion.contacts, slice(len(motion.t) // 4, -(len(motion.t) // 4))
    push = columns["disc/plate"].normal_force[middle]
    np.testing.assert_allclose(np.mean(push), 3.0 * rate / sin(slope), rtol=1e-3)
    corners = [np.mean(columns[name].normal_force[middle]) for name in ("plate/track", "plate/track 2")]
    assert sum(corners) == pytest.approx(3.0 * 9.81 + 3.0 * rate / tan(slope), rel=1e-3) and min(corners) > 1.0
    # The two friction forces of one plate along one line cancel: their shares are not unique.
    assert np.isnan(columns["plate/track"].friction_force[middle]).all()


def read_at(case: Case, motion, contact: str):
    """The transitions that are read at one contact."""
    one, gap = several_contacts.only(motion, contact), several_contacts.gap_of(motion, contact)(motion.t)
    return several_contacts.ContactReader(case, one, contact, gap).reading().transitions


@quick_every(2)
@pytest.mark.parametrize("name,gap,rung,speeds,most", [
    ("pymunk", 0.01, 2, (0.0, 0.0, 1.0), 1e-6),
    ("pymunk", 0.0, 2, (-1 / 3, 2 / 3, 2 / 3), 1e-6),  # Moreau's law, as derived in test_impacts_of_bodies
    ("box2d", 0.01, 2, (0.0, 0.0, 1.0), 2e-3),
    ("box2d", 0.0, 2, (-0.118, 0.236, 0.882), 2e-3),  # measured: its own law
    ("exudyn", 0.01, 5, (0.0, 0.0, 1.0), 2e-3),  # restitution is met to a thousandth
])  # fmt: skip
def test_an_impact_goes_through_a_row(name, gap, rung, speeds, most):
    """Where discs touch, the law of impact decides; an engine with another one says so in its rows."""
    case = cases.load("row_of_discs", gap=gap)
    motion = play(name, "native", case, rung)
    assert [float(motion.plate(one).vx[-1]) for one in motion.plate_names] == pytest.approx(speeds, abs=most)
    assert bool(other_laws(engine(name), case, "native")) == (name == "box2d" and gap == 0.0)
    if name == "box2d" or gap == 0.0:  # in Box2D they touch for two steps
        return
    # Discs that are apart touch for an instant only: 0.3 and 0.31 s, each from one flight to the next. An impact of
    # Exudyn's is half a period of the spring (two discs: m/2), and the disc that is hit is late by half of it then.
    setting = engine(name).ladder(case, "native")[rung]
    late = 0.5 * pi * sqrt(0.5 * case.plate.mass / setting["k"]) if "k" in setting else 0.0
    for contact, time in (("second/plate", 0.3), ("third/second", 0.31 + late)):
        (impact,) = read_at(case, motion, contact)
        assert (impact.before, impact.after, impact.cause) == (Mode.FLIGHT, Mode.FLIGHT, "impact")
        assert impact.time == pytest.approx(time, abs=2.0 * motion.t[1])
    # The truth is closed there between two of its instants only, so that a contact has no place by which to be found.
    truth = reference.simulate(case)
    scales = several_contacts.scales(case, truth, truth.transitions, {})
    judgement = several_contacts.judge(case, motion, truth, scales, truth.transitions)
    assert [row.pairing for row in judgement.ledger] == ["paired", "paired"]


def pile_on_floor(mu_floor: float) -> Case:
    """The pile with friction 0.5 between discs, on a floor with its own friction; the track is far below."""
    case = cases.load("pile_of_discs", mu=0.5)
    floor = Support(Curve(lambda s: (s, 10.0 + 0 * s)), "floor", (CoulombFriction(mu_floor),))
    others = tuple(FreePlate(o.plate, replace(o.start, y=o.start.y + 10.0), o.name) for o in case.others)
    return replace(case, start=StartPose(-0.5, 10.5), supports=(floor,), others=others, duration=0.5)


@EACH
def test_a_support_has_its_own_friction_under_free_plates(name):
    """The pile stands on a floor with more friction than (2 − √3)/3, and moves apart on one with less."""
    needed = (2.0 - sqrt(3.0)) / 3.0
    for share, stands in ((1.05, True), (0.95, False)):
        motion = play(name, "native", pile_on_floor(share * needed), 4 if name == "exudyn" else 2)
        upper = motion.plate("upper")
        # It moves by 5 mm where it slides; contacts give way by 0.1 (Box2D) and 0.6 mm (Exudyn).
        assert (np.abs(upper.y - upper.y[0]).max() < 1e-3) == stands
        assert motion.contact_names[0] == "plate/floor"


# --- impacts of Exudyn's springs --------------------------------------------------------------------------------------


def test_impacts_in_steps_longer_than_the_spring_s_period_break_a_law(monkeypatch):
    """A step through the contact's spring: restitution was 2.16 instead of 0.781."""
    exudyn = pytest.importorskip("adapters.exudyn")
    monkeypatch.setattr(exudyn.adapter, "_needs_resolved_spring", lambda *_: False)
    fresh = Hashable(**{name: getattr(exudyn, name) for name in exudyn.__all__})
    (verdict,) = judge(fresh, ["collision_of_free_plates"], ["native"])
    assert verdict.outcome == "broken" and "restitution of Impact" in verdict.reason


# --- what is made of their motions ------------------------------------------------------------------------------------


def test_the_farthest_plate_is_the_error_of_the_pose():
    case = cases.load("row_of_discs")
    motion = play("pymunk", "native", case, 2)
    other = replace(case, others=(case.others[0], replace(case.others[1], start=StartPose(0.23, 0.1))))
    off = differences(play("pymunk", "native", other, 2), motion, case)
    assert off["pose"][0] == pytest.approx(0.02, abs=1e-9) and off["x"][0] == 0.0


def test_a_motion_without_its_free_plates_is_a_failure_of_the_engine():
    case = cases.load("row_of_discs")
    motion = play("pymunk", "native", case, 1)
    assert gate.motion(motion, case).plate_names == ("plate", "second", "third")
    with pytest.raises(EngineFailure, match="gives the plates plate; give plate, second, third"):
        gate.motion(replace(motion, plate_names=("plate",), plate_columns=None), case)
