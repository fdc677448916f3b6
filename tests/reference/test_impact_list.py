"""Which impacts the list of transitions has: those that close fast enough, whatever the plate does after them."""

from math import sqrt

import pytest

import reference
from cases import Case, Flight, Gravity, Impact, Mode, Start, Unilateral, disc
from cases.library import line
from tests.scenes import second as second_states

G = 9.81
IMPACT = (Mode.FLIGHT, Mode.FLIGHT)


def first(case: Case):
    return reference.simulate(case, rtol=1e-13)


def second(case: Case):
    return second_states.motion(case, rtol=1e-13)


FORMULATIONS = pytest.mark.parametrize("solve", [first, second])


@FORMULATIONS
@pytest.mark.parametrize("e", [5e-4, 1e-6])
def test_the_first_impact_is_listed_however_small_its_rebound_is(solve, e):
    height = 0.1
    case = Case(line(), disc(0.1, 1.0), (Gravity(G), Unilateral(), Flight(), Impact(e)), Start(0.0, gap=height), 0.5)
    motion = solve(case)
    falls = sqrt(2 * height / G)
    assert [(t.before, t.after) for t in motion.transitions] == [IMPACT, (Mode.FLIGHT, Mode.SLIDE)]
    # A rebound whose height drowns in the rounding of positions, 1e-16 m, is none: it would last 1e-8 s at most, and
    # what is left out here lasts 3.6e-11 s (e = 5e-4) and 2.9e-13 s.
    assert [t.time for t in motion.transitions] == pytest.approx([falls, falls * (1 + e) / (1 - e)], abs=4e-11)


@FORMULATIONS
def test_a_plate_that_does_not_get_off_its_track_has_no_impact(solve):
    # It rises by less than a rounding of its place; without a rebound it slides on.
    start = Start(0.0, slip=1.0, gap_rate=1e-12)
    case = Case(line(), disc(0.1, 1.0), (Gravity(G), Unilateral(), Flight(), Impact(0.5)), start, 0.1)
    assert [(t.before, t.after) for t in solve(case).transitions] == [(Mode.FLIGHT, Mode.SLIDE)]
