"""Several free plates in Exudyn, against exact motions; each law holds, and is broken by a wrong model."""

from __future__ import annotations

from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest

import cases
from adapters import other_laws, refusal
from adapters.laws import judge
from cases import CoulombFriction, Mode, StartPose
from reports.judging import several_contacts
from tests.adapters.mutants import Hashable
from tests.adapters.test_engine_effects import play
from tests.adapters.test_free_plates import pile_on_floor

exudyn = pytest.importorskip("adapters.exudyn")


def test_a_disc_leaves_a_free_disc_and_momentum_stays():
    """It leaves after 0.444077645 s (derived in tests/reference/test_free_plates.py); the floor is without friction."""
    motion = play("exudyn", "native", cases.load("disc_on_free_disc"), 6)
    upper = motion.plate("upper")
    assert np.abs(2.0 * motion.vx + upper.vx).max() < 1e-10  # Newton's tolerance
    last = np.flatnonzero(np.isfinite(motion.contacts["upper/plate"].slip))[-1]
    assert motion.t[last] == pytest.approx(0.444077645, abs=4e-3)  # measured: 1.9 ms


@pytest.mark.slow
def test_an_impact_goes_through_a_row_of_discs_that_are_apart():
    case = cases.load("row_of_discs")
    setting = exudyn.ladder(case, "native")[5]
    motion = play("exudyn", "native", case, setting=setting)
    assert [motion.plate(name).vx[-1] for name in motion.plate_names] == pytest.approx(
        [0.0, 0.0, 1.0], abs=2e-3
    )  # restitution is met to a thousandth
    # An impact is half a period of the spring (two discs: m/2), and the disc that is hit is late by half of it then.
    late = 0.5 * pi * sqrt(0.5 * case.plate.mass / setting["k"])
    for contact, time in (("second/plate", 0.3), ("third/second", 0.31 + late)):
        one = several_contacts.only(motion, contact)
        (impact,) = several_contacts.ContactReader(case, contact, several_contacts.gap_of(motion, contact))(
            case, one
        ).transitions
        assert (impact.before, impact.after, impact.cause) == (Mode.FLIGHT, Mode.FLIGHT, "impact")
        assert impact.time == pytest.approx(time, abs=2.0 * setting["h"])
    assert not other_laws(exudyn, case, "native")
    assert other_laws(exudyn, cases.load("row_of_discs", gap=0.0), "native")


@pytest.mark.parametrize("restitution", [1.0, 0.5])
def test_discs_that_meet_leave_with_their_restitution(restitution):
    """Wherever between two steps they meet: it was too large by up to 0.11, at 17 of 60 starts by over 0.05."""
    case = cases.load("row_of_discs", gap=2.0, restitution=restitution, duration=0.6)
    for distance in np.random.default_rng(0).uniform(0.5, 0.51, 5):
        motion = play("exudyn", "native", replace(case, start=StartPose(-distance, 0.1, vx=1.0)), 3)
        speed = motion.plate("second").vx[-1] - motion.vx[-1]
        # A thousandth: by the step that the contact misses (`MEETING_STEP`), and by the law's damping.
        assert speed == pytest.approx(restitution, abs=1e-3)


@pytest.mark.parametrize("seed", [0, 4, 6, 10])
def test_discs_in_flight_keep_the_law_of_collisions(seed):
    """Seeds of which it was broken: 0.84 instead of 0.78 and the like."""
    (verdict,) = judge(exudyn, ["collision_of_free_plates"], ["native"], seed)
    assert verdict.outcome == "kept", verdict.reason


def test_a_support_has_its_own_friction_under_free_plates():
    """The pile stands on a floor with more friction than (2 − √3)/3, and moves apart on one with less."""
    needed = (2.0 - sqrt(3.0)) / 3.0
    for share, stands in ((1.05, True), (0.95, False)):
        upper = play("exudyn", "native", pile_on_floor(share * needed), 4).plate("upper")
        # It moves by 10 mm where it slides; contacts give way by 0.6 mm.
        assert (np.abs(upper.y - upper.y[0]).max() < 1e-3) == stands


def test_a_plate_that_does_not_turn_is_held():
    motion = play("exudyn", "native", cases.load("disc_on_free_hemisphere"), 3)
    assert np.abs(motion.theta).max() < 1e-12 and motion.plate("upper").omega.min() < -1.0


def test_impacts_in_steps_longer_than_the_spring_s_period_break_a_law(monkeypatch):
    """A step through the contact's spring: restitution was 2.16 instead of 0.781."""
    monkeypatch.setattr(exudyn.adapter, "_needs_resolved_spring", lambda *_: False)
    fresh = Hashable(**{name: getattr(exudyn, name) for name in exudyn.__all__})
    (verdict,) = judge(fresh, ["collision_of_free_plates"], ["native"])
    assert verdict.outcome == "broken" and "restitution of Impact" in verdict.reason


def test_what_its_contacts_lack_is_rejected_in_a_sentence():
    case = cases.load("disc_on_free_disc", mu=0.5)
    static = tuple(CoulombFriction(0.5, 0.6) if isinstance(e, CoulombFriction) else e for e in case.effects)
    reason = refusal(exudyn, replace(case, effects=static), "native")
    assert reason == "Exudyn's contacts have one friction coefficient, for slip and stick and all slip velocities."
