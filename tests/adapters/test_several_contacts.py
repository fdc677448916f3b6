"""Contacts computed from poses: a disc that rocks in a groove, compared with the reference and the law of impact."""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi

import numpy as np
import pytest

import adapters
import cases
import reference
from adapters import EngineFailure, gate, refusal_of_several_contacts
from adapters.common import several_contacts
from cases import Trajectory

ROCKING = cases.load("disc_rocking_in_groove")


@pytest.fixture(scope="module")
def truth() -> Trajectory:
    """The reference's motion."""
    return reference.simulate(ROCKING, rtol=1e-10)


def from_poses(truth: Trajectory, count: int = 801) -> Trajectory:
    """The motion with its contacts computed from poses and velocities alone."""
    t = np.linspace(0.0, truth.t[-1], count)
    poses = Trajectory(t=t, **truth(t)._asdict(), case=ROCKING)
    return several_contacts.with_contacts(ROCKING, poses, lambda xi1: np.full(len(xi1), 1e-9))


def test_contacts_follow_from_the_poses(truth):
    motion = from_poses(truth)
    assert motion.contact_names == truth.contact_names == ("plate/track", "plate/track 2")
    for name in motion.contact_names:
        own, exact = motion.contacts[name], truth.contact_columns(name, motion.t)
        closed = np.isfinite(exact.slip)
        assert np.array_equal(np.isfinite(own.slip), closed)
        # Poses are good to the integrator's 1e-10, and places on a groove's straight flanks as good as the poses.
        for column in ("slip", "normal_force", "friction_force", "xi1"):
            np.testing.assert_allclose(getattr(own, column)[closed], getattr(exact, column)[closed], atol=1e-7)
        np.testing.assert_allclose(np.sin(own.xi2 - exact.xi2)[closed], 0.0, atol=1e-7)


def test_forces_of_two_closed_contacts_are_unknown(truth):
    """The momentum gives their sum only."""
    motion = from_poses(truth)
    wide = several_contacts.with_contacts(ROCKING, motion, lambda xi1: np.full(len(xi1), 0.01))
    both = np.all([np.isfinite(columns.slip) for columns in wide.contacts.values()], axis=0)
    assert both.any() and not both.all()
    for columns in wide.contacts.values():
        assert np.isnan(columns.normal_force[both]).all() and np.isfinite(columns.normal_force[~both]).all()


@pytest.mark.parametrize("name", ["disc_in_circle", "disc_in_parabola", "tightest_fit"])
def test_a_disc_that_fits_everywhere_touches_once(name):
    """The track's curvature is less than the disc's: the search is not made, and the motion stays as it was."""
    assert not several_contacts.may_touch_twice(cases.load(name))
    assert several_contacts.may_touch_twice(ROCKING)


def test_a_route_without_several_contacts_says_so_in_one_sentence():
    pytest.importorskip("pymunk")
    pymunk = adapters.engine("pymunk")
    assert refusal_of_several_contacts(pymunk, ROCKING, "native") == ""
    sentence = "The plate touches its track in several places, which the assisted route does not support."
    assert refusal_of_several_contacts(pymunk, ROCKING, "assisted") == sentence
    ellipse = replace(ROCKING, plate=cases.load("ellipse_on_line").plate)
    assert (
        refusal_of_several_contacts(pymunk, ellipse, "native") == "Several contacts are computed for round plates only."
    )


def test_pymunk_rocks_as_the_law_of_impact_says(truth):
    """Each hand-over multiplies the spin by (1 + 2 cos 2α)/3, α the flanks' incline where they are touched."""
    pytest.importorskip("pymunk")
    from adapters import pymunk

    setting = pymunk.ladder(ROCKING, "native")[3]
    model = pymunk.build(ROCKING, "native", setting)
    pymunk.run(model)
    motion = pymunk.read(model)
    assert motion.contact_names == ("plate/track", "plate/track 2")
    impact = next(event.time for event in truth.transitions)
    closed = np.isfinite(motion.contacts["plate/track 2"].slip)
    first = int(np.argmax(closed))
    # Two steps: the engine sees an overlap at the end of one, and its contact acts in the next.
    assert abs(motion.t[first] - impact) <= 2.0 * setting["h"]
    before, after = motion.omega[first - 2], motion.omega[first + 3]
    slope = float(np.arctan2(*ROCKING.track.tangent(motion.contacts["plate/track 2"].xi1[first])[::-1]))
    assert 0.0 < slope < pi / 9
    # In the five steps between the two samples the spin changes by gravity: at most (2/3) g sin α/r each.
    gravity = 5.0 * setting["h"] * (2.0 / 3.0) * 9.81 * np.sin(slope) / 0.5
    assert after / before == pytest.approx((1.0 + 2.0 * cos(2.0 * slope)) / 3.0, abs=gravity / abs(before))


def test_the_gate_copies_the_columns_of_each_contact(truth):
    motion = from_poses(truth, 101)
    plain = gate.motion(motion, ROCKING)
    assert plain.contact_names == motion.contact_names
    assert plain.contact_columns is not motion.contact_columns
    for name, columns in motion.contacts.items():
        np.testing.assert_array_equal(plain.contacts[name].slip, columns.slip)
    short = {name: columns._replace(gap=columns.gap[1:]) for name, columns in motion.contacts.items()}
    broken = replace(motion, contact_columns=lambda name, times: short[name])
    with pytest.raises(EngineFailure, match="gap of plate/track has 100 samples and its t has 101"):
        gate.motion(broken, ROCKING)
    with pytest.raises(EngineFailure, match="names 2 contacts"):
        gate.motion(replace(motion, contact_names=("a", "a")), ROCKING)
