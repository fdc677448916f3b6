"""Several free plates in engines: contacts computed from poses, and motions compared with exact answers."""

from __future__ import annotations

from dataclasses import replace
from math import atan, cos, sin, sqrt, tan

import numpy as np
import pytest

import cases
import reference
from adapters import EngineFailure, engine, gate, other_laws, refusal
from adapters.common.feature_contacts import with_plates
from cases import Case, CoulombFriction, Curve, FreePlate, Mode, StartPose, Support
from cases.scene.free_plates import names_of, plates_of
from reports.judging import several_contacts
from reports.judging.distances import differences
from reports.running.tasks import find_truth, perform
from tests.adapters.test_engine_effects import play

# Engines, and the rounding of their numbers.
NATIVE = {"pymunk": 2e-16, "box2d": 1e-7}
EACH = pytest.mark.parametrize("name", NATIVE)


@pytest.mark.slow
@pytest.mark.parametrize("label", [
    "disc_on_free_disc[mu=0.5]", "disc_on_free_hemisphere", "pile_of_discs[mu=0.08]", "disc_off_free_block",
    "disc_on_free_wedge[mu=0.12]",
])  # fmt: skip
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
                    # Shares of the friction on two corners of one plate are not unique, all along.
                    unique = off[np.isfinite(off)] if column == "friction_force" else off
                    assert not len(unique) or np.mean(unique < 2e-2) > 0.99


@EACH
def test_a_disc_leaves_a_free_disc_and_momentum_stays(name):
    """It leaves after 0.444077645 s (derived in tests/reference/test_free_plates.py); the floor is without friction."""
    case = cases.load("disc_on_free_disc")
    pytest.importorskip(f"adapters.{name}")
    for rung in (0, 3):
        motion = play(name, "native", case, rung)
        upper, lower = motion.plate("upper"), motion.plate("plate")
        # Rounding of velocities of 1 m/s, in a hundred to 1,300 steps.
        assert np.abs(2.0 * lower.vx + upper.vx).max() < 1e3 * NATIVE[name]
        last = np.flatnonzero(np.isfinite(motion.contacts["upper/plate"].slip))[-1]
        # The weaker a contact, the more steps are between two pushes: 1.6 to 5.1 steps are measured.
        assert abs(motion.t[last] - 0.444077645) < 6.0 * motion.t[1]
        assert set(motion.contact_names) == {"plate/track", "upper/track", "upper/plate"}


@EACH
def test_a_free_wedge_gives_way_under_a_disc(name):
    """Without friction its acceleration is m g sin α cos α/(M + m sin²α): it comes from the force at the slope, whose
    direction is that of an edge."""
    pytest.importorskip(f"adapters.{name}")
    motion, slope = play(name, "native", cases.load("disc_on_free_wedge"), 3), atan(0.5)
    rate = 9.81 * sin(slope) * cos(slope) / (3.0 + sin(slope) ** 2)
    way = motion.plate("plate").x - motion.plate("plate").x[0]
    # At 1 and 2 ms the engines are 5e-6 and 4e-4 of the way off; with the mass of the disc alone it would be 15 %.
    assert abs(way[-1] / (-0.5 * rate * motion.t[-1] ** 2) - 1.0) < 1e-3
    assert set(motion.contact_names) == {"plate/track", "plate/track 3", "disc/plate"}
    columns, middle = motion.contacts, slice(len(motion.t) // 4, -(len(motion.t) // 4))
    push = columns["disc/plate"].normal_force[middle]
    np.testing.assert_allclose(np.mean(push), 3.0 * rate / sin(slope), rtol=1e-3)
    corners = [np.mean(columns[name].normal_force[middle]) for name in ("plate/track", "plate/track 3")]
    assert sum(corners) == pytest.approx(3.0 * 9.81 + 3.0 * rate / tan(slope), rel=1e-3) and min(corners) > 1.0
    # The two friction forces of one plate along one line cancel: their shares are not unique.
    assert np.isnan(columns["plate/track"].friction_force[middle]).all()


@EACH
def test_a_disc_pushes_a_block_and_rolls_at_the_exact_time(name):
    """As the catalogue derives them; both corners of the block slip alike."""
    pytest.importorskip(f"adapters.{name}")
    case = cases.load("disc_pushes_block")
    motion = play(name, "native", case, 3)
    push = 2.0 * 0.3 * 9.81 * cos(0.4) / (1.09 + 0.91 / 2.0)
    below = 9.81 * cos(0.4) - 0.3 * push
    rate = 9.81 * sin(0.4) + 0.3 * below - push
    rolls = 0.1 * 20.0 / (rate + 2.0 * 0.3 * (push + below))
    slips = (motion.t > 0.05) & (motion.t < 0.95 * rolls)
    for contact in ("plate/track", "plate/track 4"):
        # One step of acceleration at most: the velocities are those of the middle of a step.
        np.testing.assert_allclose(
            motion.contacts[contact].slip[slips], rate * motion.t[slips], atol=rate * motion.t[1]
        )
    one = several_contacts.only(motion, "disc/track")
    reader = several_contacts.ContactReader(case, "disc/track", several_contacts.gap_of(motion, "disc/track"))
    (change,) = reader(case, one).transitions
    # pymunk's disc is 1.9e-8 m wider than the case's, which slips by 5e-7 m/s where the engine's rolls.
    assert (change.before, change.after) == (Mode.SLIP_BACKWARD, Mode.ROLL)
    assert change.time == pytest.approx(rolls, abs=motion.t[1])


@pytest.mark.parametrize("name,gap,speeds", [
    ("pymunk", 0.01, (0.0, 0.0, 1.0)),
    ("pymunk", 0.0, (-1 / 3, 2 / 3, 2 / 3)),  # Moreau's law, as derived in test_impacts_of_bodies
    ("box2d", 0.01, (0.0, 0.0, 1.0)),
    ("box2d", 0.0, (-0.118, 0.236, 0.882)),  # measured: its own law
])  # fmt: skip
def test_an_impact_goes_through_a_row(name, gap, speeds):
    """Where discs touch, the law of impact decides; an engine with another one says so in its rows."""
    case = cases.load("row_of_discs", gap=gap)
    motion = play(name, "native", case, 2)
    tolerance = 1e-6 if name == "pymunk" else 2e-3
    assert [float(motion.plate(one).vx[-1]) for one in motion.plate_names] == pytest.approx(speeds, abs=tolerance)
    laws = other_laws(engine(name), case, "native")
    assert bool(laws) == (name == "box2d" and gap == 0.0)


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
        # It moves by 5 mm where it slides; contacts of Box2D give way by 0.1 mm.
        assert (np.abs(upper.y - upper.y[0]).max() < 1e-3) == stands
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


def test_impacts_within_a_row_are_read_at_each_contact():
    """Discs that are apart touch for an instant only: 0.3 and 0.31 s, each from one flight to the next. (In Box2D they
    touch for two steps.)"""
    case = cases.load("row_of_discs")
    motion = play("pymunk", "native", case, 2)
    for contact, time in (("second/plate", 0.3), ("third/second", 0.31)):
        one = several_contacts.only(motion, contact)
        reading = several_contacts.ContactReader(case, contact, several_contacts.gap_of(motion, contact))(case, one)
        (impact,) = reading.transitions
        assert (impact.before, impact.after, impact.cause) == (Mode.FLIGHT, Mode.FLIGHT, "impact")
        assert impact.time == pytest.approx(time, abs=2.0 * motion.t[1])
    # The truth is closed there between two of its instants only, so that a contact has no place by which to be found.
    truth = reference.simulate(case)
    scales = several_contacts.scales(case, truth, truth.transitions, {})
    judgement = several_contacts.judge(case, motion, truth, scales, truth.transitions)
    assert [row.pairing for row in judgement.ledger] == ["paired", "paired"]


@pytest.mark.slow
@EACH
def test_contacts_of_a_plate_that_does_not_turn_roll(name):
    """A disc that sticks to a hemisphere was read as at rest, since the hemisphere does not turn: 100 % off."""
    pytest.importorskip(f"adapters.{name}")
    case = cases.load("disc_on_free_hemisphere")
    truth, setting = find_truth(case), engine(name).ladder(case, "native")[-2]
    run = perform(case, name, "native", setting, 1, truth)
    assert run.score is not None and run.score.off < 0.02
    assert {"x of upper", "y of upper", "angle of upper"} <= run.off.keys()
