"""Motions with several contacts compared with the truth contact by contact."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import cases
import reference
from adapters.common import several_contacts as from_poses
from cases import (
    Mode,
    State,
    Trajectory,
    Transition,
)
from cases.motion.sampled_contacts import SampledContacts
from cases.motion.trajectory import ContactColumns
from reports.judging import impacts, several_contacts
from reports.judging.ledger import LedgerRow
from reports.judging.null_motions import null_motions

ROCKING = cases.load("disc_rocking_in_groove")


@pytest.fixture(scope="module")
def truth() -> Trajectory:
    """The reference's motion."""
    return reference.simulate(ROCKING, rtol=1e-10)


@pytest.fixture(scope="module")
def scales(truth):
    """The scale of each contact."""
    return several_contacts.scales(ROCKING, truth, truth.transitions, null_motions(ROCKING))


def sampled(truth: Trajectory, count: int = 801, late: float = 0.0) -> Trajectory:
    """The poses of the truth, `late` seconds later, with contacts computed from them as of an engine."""
    t = np.linspace(0.0, truth.t[-1], count)
    motion = Trajectory(t=t, **truth(np.maximum(t - late, 0.0))._asdict(), case=ROCKING)
    return from_poses.with_contacts(ROCKING, motion, lambda xi1: np.full(len(xi1), 1e-6))


def judged(truth, scales, motion):
    return several_contacts.judge(ROCKING, motion, truth, scales, truth.transitions)


def test_the_truth_is_excellent_and_its_transitions_belong_to_contacts(truth, scales):
    result = judged(truth, scales, truth)
    assert result.score.off <= 1e-9
    assert [(row.event, row.contact, row.pairing) for row in result.ledger] == [
        (place, event.contact, "paired") for place, event in enumerate(truth.transitions, start=1)
    ]


def test_samples_of_the_truth_are_within_their_doubt(truth, scales):
    result = judged(truth, scales, sampled(truth))
    assert result.score.off <= result.score.doubt <= 0.02
    assert {row.pairing for row in result.ledger} == {"paired"}
    gap = truth.t[-1] / 800
    assert max(abs(row.error) for row in result.ledger) <= 2.0 * gap
    # A contact closes where its gap, extrapolated, vanishes: far more accurate than the samples.
    assert max(abs(row.error) for row in result.ledger if row.before is Mode.FLIGHT) <= 0.1 * gap


def test_contacts_are_matched_by_their_places_not_their_numbers(truth, scales):
    motion = sampled(truth)
    first, second = motion.contact_names
    columns = {first: motion.contacts[second], second: motion.contacts[first]}
    swapped = replace(motion, contact_columns=SampledContacts(motion.t, columns))
    assert several_contacts.same_contacts(swapped, truth) == {first: second, second: first}
    assert judged(truth, scales, swapped).score == judged(truth, scales, motion).score


def test_each_contact_is_read_by_its_own_friction():
    # The conveyor has friction, the wall has none: a contact without slip rolls on the one and slides on the other.
    case = cases.load("block_on_conveyor", speed=0.8, mu_static=0.0, stiffness=0.0)
    t = np.linspace(0.0, 1.0, 101)
    nothing = np.zeros(101)
    still = Trajectory(*(t, nothing, nothing, nothing, nothing, nothing, nothing, nothing), *[nothing] * 4)
    first = {
        contact: several_contacts.ContactReader(case, still, contact, np.zeros(len(still.t))).reading().first_mode
        for contact in ("plate/track", "plate/track 2", "plate/wall", "plate/wall 2")
    }
    assert list(first.values()) == [Mode.ROLL, Mode.ROLL, Mode.SLIDE, Mode.SLIDE]


def test_a_motion_that_never_touches_the_other_flank_misses_its_transitions(truth, scales):
    t = np.linspace(0.0, 4.0, 401)
    still = {name: np.full(401, getattr(truth(0.0), name)) for name in truth(0.0)._fields}
    result = judged(truth, scales, Trajectory(t=t, **still, case=ROCKING))
    other = [row for row in result.ledger if row.contact == "plate/track 2"]
    assert len(other) == 4 and all(row.pairing == "missed" for row in other)


def test_swings_and_the_time_of_rest_are_those_of_the_motion():
    """A plate turns as Σ sin²-humps whose size falls by 1/10: it rests after the fourth, with 1e-6 of its energy."""
    t = np.linspace(0.0, 5.0, 5001)
    size = 0.5 * 0.1 ** np.floor(t)
    theta = np.where(t < 5.0, size * np.sin(np.pi * t) ** 2, 0.0)
    nothing = np.zeros(len(t))
    state = {name: nothing for name in ("x", "y", "vx", "vy", "slip", "normal_force", "friction_force", "xi1", "xi2")}
    motion = Trajectory(t=t, theta=theta, omega=np.gradient(theta, t), **state)
    events = [Transition(float(k), Mode.FLIGHT, Mode.ROLL, contact="a") for k in range(1, 4)]
    pairs = [LedgerRow(k, e.before, e.after, e.time, e.time, 0.0, "paired", "a") for k, e in enumerate(events, 1)]
    rest, *rows = impacts.rows(ROCKING, motion, motion, pairs)
    assert [row.swing for row in rows] == pytest.approx([0.05, 0.005, 0.0005], rel=1e-3)
    # The kinetic energy of hump k is 1e-2 of that before: it is below 1e-4 within hump 2, at its top first.
    assert rest.event == 0 and 2.0 < rest.time <= 3.0 and rest.time == rest.reference_time
    assert np.isnan(impacts.rest_time(ROCKING, replace(motion, omega=np.ones(len(t)))))


def test_impacts_are_compared_in_their_order_at_each_contact():
    """The run's third impact at a is nearest in time to the truth's fourth, with which the ledger pairs it."""
    times, exact = [1.0, 1.5, 2.9], [1.0, 2.0, 2.5, 3.0]
    kinds = Mode.FLIGHT, Mode.ROLL
    both = [(1.0, 1.0), (1.5, 2.0), (np.nan, 2.5), (2.9, 3.0)]
    pairs = [LedgerRow(k, *kinds, own, true, own - true, "paired", "a") for k, (own, true) in enumerate(both, 1)]
    pairs.insert(2, LedgerRow(9, *kinds, 2.2, 2.2, 0.0, "paired", "b"))
    t = np.linspace(0.0, 4.0, 401)
    motion = Trajectory(t=t, **dict.fromkeys(State._fields, np.ones(len(t))))  # it never rests: no row says when
    rows = impacts.rows(ROCKING, motion, motion, pairs)
    assert [(row.contact, row.time) for row in rows if row.contact == "b"] == [("b", 2.2)]
    assert [row.time for row in rows if row.contact == "a"][:3] == times and np.isnan(rows[-1].time)
    assert [row.reference_time for row in rows if row.contact == "a"] == exact
    assert [row.event for row in rows] == [1, 2, 3, 4, 5]


def test_a_contact_without_transitions_has_the_mode_of_its_slip():
    """Next to a first contact that rolls one may slip all the time, and next to one that slips one may stick: they had
    the first contact's mode, or slipped backwards."""
    t, zeros = np.linspace(0.0, 1.0, 5), np.zeros(5)
    columns = {
        name: ContactColumns(zeros, slip, zeros, zeros, zeros, zeros, np.zeros((2, 5)), np.zeros((2, 5)))
        for name, slip in (("a", 0.0 * t), ("b", t), ("c", -t), ("d", 1e-17 * t), ("e", np.full(5, np.nan)))
    }
    motion = Trajectory(t, t, *np.zeros((2, 5)), np.ones(5), *np.zeros((7, 5)), first_mode=Mode.ROLL,
                        contact_names=tuple(columns), contact_columns=SampledContacts(t, columns))  # fmt: skip
    slips = replace(motion, first_mode=Mode.SLIP_FORWARD)
    assert [motion.of(name).first_mode for name in columns] == [
        Mode.ROLL, Mode.SLIP_FORWARD, Mode.SLIP_BACKWARD, Mode.ROLL, Mode.FLIGHT
    ]  # fmt: skip
    assert [slips.of(name).first_mode for name in "bcd"] == [Mode.SLIP_FORWARD, Mode.SLIP_BACKWARD, Mode.ROLL]
    smooth = replace(motion, first_mode=Mode.SLIDE)
    assert smooth.of("b").first_mode is Mode.SLIDE
