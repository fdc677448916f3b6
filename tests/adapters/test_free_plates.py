"""Several free plates in engines: contacts computed from poses, and motions compared with exact answers."""

from __future__ import annotations

from dataclasses import replace
from math import sqrt

import numpy as np
import pytest

import cases
import reference
from adapters import EngineFailure, gate, refusal
from adapters.common.plate_contacts import with_plates
from cases import Case, CoulombFriction, Curve, FreePlate, StartPose, Support
from cases.free_plates import names_of, plates_of
from reports.judging.distances import differences
from tests.adapters.test_engine_effects import play

NATIVE = ("pymunk",)
EACH = pytest.mark.parametrize("name", NATIVE)


@pytest.mark.slow
@pytest.mark.parametrize("label", ["disc_on_free_disc[mu=0.5]", "disc_on_free_hemisphere", "pile_of_discs[mu=0.08]"])
def test_contacts_of_free_plates_follow_from_the_poses(label):
    """The true motion's poses give its gaps, slips and parameters, and its momentum gives the forces."""
    case = cases.load(label)
    truth = reference.simulate(case, rtol=1e-10)
    t = np.linspace(0.0, truth.t[-1], 4001)
    state = np.array([np.array(truth.plate(name)(t)[:6]) for name in names_of(case)])
    poses, rates = state[:, :3].transpose(2, 0, 1), state[:, 3:].transpose(2, 0, 1)
    inertia = np.array([(p.mass, p.mass, p.inertia if p.turns else 1.0) for p in plates_of(case)])
    torsor = inertia * (np.gradient(rates, t, axis=0) + [0.0, 9.81, 0.0])
    for given in (None, torsor):
        motion = with_plates(case, t, poses, rates, 1e-7, given)
        assert set(motion.contact_names) >= set(truth.contact_names)
        for name in truth.contact_names:
            own, exact = motion.contacts[name], truth.contact_columns(name, t)
            closed, is_closed = np.isfinite(exact.slip), np.isfinite(own.slip)
            assert np.mean(is_closed == closed) > 0.98
            both = closed & is_closed
            for column in ("gap", "slip", "xi1", "xi2"):
                np.testing.assert_allclose(getattr(own, column)[both], getattr(exact, column)[both], atol=1e-7)
            if given is not None:
                # Differences of samples 0.3 ms apart; at a change of mode they are of both sides.
                for column in ("normal_force", "friction_force"):
                    off = np.abs(getattr(own, column) - getattr(exact, column))[both]
                    assert np.mean(off[np.isfinite(off)] < 2e-2) > 0.99


@EACH
def test_a_disc_leaves_a_free_disc_and_momentum_stays(name):
    """It leaves after 0.444077645 s (derived in tests/reference/test_free_plates.py); the floor is without friction."""
    case = cases.load("disc_on_free_disc")
    for rung, error in ((0, 3e-2), (3, 8e-3)):  # a push every few steps: an error of order √h, on the early side
        motion = play(name, "native", case, rung)
        upper, lower = motion.plate("upper"), motion.plate("plate")
        assert np.abs(2.0 * lower.vx + upper.vx).max() < 1e-12
        last = np.flatnonzero(np.isfinite(motion.contacts["upper/plate"].slip))[-1]
        assert -error < motion.t[last] - 0.444077645 < 1e-3
        assert set(motion.contact_names) == {"plate/track", "upper/track", "upper/plate"}


@EACH
@pytest.mark.parametrize("gap,speeds", [(0.01, (0.0, 0.0, 1.0)), (0.0, (-1 / 3, 2 / 3, 2 / 3))])
def test_an_impact_goes_through_a_row_as_moreaus_law_says(name, gap, speeds):
    """Discs that touch are one contact problem: −1/3, 2/3, 2/3 of the speed, as derived in test_bodies."""
    motion = play(name, "native", cases.load("row_of_discs", gap=gap), 2)
    assert [float(motion.plate(one).vx[-1]) for one in motion.plate_names] == pytest.approx(speeds, abs=1e-6)


def pile_on_floor(mu_floor: float) -> Case:
    """The pile with friction 0.5 between discs, on a floor with its own friction; the track is far below."""
    case = cases.load("pile_of_discs", mu=0.5)
    floor = Support(Curve(lambda s: (s, 10.0 + 0 * s)), "floor", (CoulombFriction(mu_floor),))

    def raised(pose: StartPose) -> StartPose:
        return replace(pose, y=pose.y + 10.0)

    others = tuple(FreePlate(one.plate, raised(one.start), one.name) for one in case.others)
    return replace(case, start=StartPose(-0.5, 10.5), supports=(floor,), others=others, duration=0.5)


@EACH
def test_a_support_has_its_own_friction_under_free_plates(name):
    """The pile stands on a floor with more friction than (2 − √3)/3, and moves apart on one with less."""
    needed = (2.0 - sqrt(3.0)) / 3.0
    for share, stands in ((1.05, True), (0.95, False)):
        motion = play(name, "native", pile_on_floor(share * needed), 2)
        upper = motion.plate("upper")
        assert (np.abs(upper.y - upper.y[0]).max() < 1e-4) == stands
        assert motion.contact_names[0] == "plate/floor"


def test_the_other_routes_reject_free_plates():
    from adapters import pymunk

    case = cases.load("row_of_discs")
    assert refusal(pymunk, case, "native") is None
    assert refusal(pymunk, case, "assisted") == "The assisted route does not support several plates (others)."


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
