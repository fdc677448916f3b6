"""Changes of mode at one instant are one per contact, in the order of the names."""

from __future__ import annotations

from cases import Mode, Transition
from cases.motion.instants import one_per_instant

FLIGHT, ROLL, SLIP, SLIDE = Mode.FLIGHT, Mode.ROLL, Mode.SLIP_FORWARD, Mode.SLIDE


def _listed(*changes: tuple[float, str, Mode, Mode]) -> list[tuple[float, str, Mode, Mode]]:
    some = [Transition(t, before, after, 0.0, 0.0, "", name) for t, name, before, after in changes]
    return [(one.time, one.contact, one.before, one.after) for one in one_per_instant(some)]


def test_impacts_found_one_after_the_other_are_listed_as_if_found_together():
    one_by_one = [(1.0, "b", FLIGHT, SLIP), (1.0, "a", ROLL, FLIGHT), (1.0, "b", SLIP, ROLL), (1.0, "a", FLIGHT, SLIP)]
    assert _listed(*one_by_one) == [(1.0, "a", ROLL, SLIP), (1.0, "b", FLIGHT, ROLL)]


def test_a_contact_that_ends_as_it_began_is_left_out_unless_it_was_hit_in_flight():
    changes = [(1.0, "a", ROLL, FLIGHT), (1.0, "b", FLIGHT, SLIDE), (1.0, "a", FLIGHT, ROLL), (1.0, "b", SLIDE, FLIGHT)]
    assert _listed(*changes) == [(1.0, "b", FLIGHT, FLIGHT)]


def test_other_instants_stay_as_they_are():
    changes = [(1.0, "b", FLIGHT, ROLL), (2.0, "a", FLIGHT, FLIGHT), (2.0 + 1e-15, "a", FLIGHT, ROLL)]
    assert _listed(*changes) == changes
