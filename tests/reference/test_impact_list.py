"""Which impacts the list of transitions has: those that close fast enough, whatever the plate does after them."""

from math import sqrt

import mpmath
import numpy as np
import pytest

import cases
import reference
from cases import Case, Flight, Gravity, Impact, Mode, Start, Unilateral, disc
from cases.library import line
from tests.sampling import quick_every
from tests.scenes import second as second_states

G = 9.81
IMPACT = (Mode.FLIGHT, Mode.FLIGHT)


def first(case: Case):
    return reference.simulate(case, rtol=1e-13)


def second(case: Case):
    return second_states.motion(case, rtol=1e-13)


FORMULATIONS = pytest.mark.parametrize("solve", [first, second])


def hoop() -> Case:
    """A loaded hoop whose weight comes over as it lands: the impact does not bounce, and nothing presses it down."""
    return cases.load("hopping_hoop", share=0.7, mu=0.4, push=2.0, angle=0.5, duration=1.4)


@quick_every(2)
@FORMULATIONS
def test_an_impact_without_a_rebound_is_listed_where_the_plate_leaves_at_once(solve):
    motion = solve(hoop())
    assert [(t.before, t.after) for t in motion.transitions][3:5] == [IMPACT, (Mode.FLIGHT, Mode.SLIP_FORWARD)]
    state = first(hoop())(1.0)  # in flight, between 0.411 s and the landing
    assert np.isnan(state.slip)
    offset, radius = 0.35, 0.5
    with mpmath.workdps(30):
        # The hoop's own centre is ahead of the centre of mass by the offset; it lands at the height of the radius.
        def height(t):
            turned = mpmath.mpf(state.theta) + mpmath.mpf(state.omega) * t
            return state.y + state.vy * t - G * t * t / 2 - offset * mpmath.sin(turned) - radius

        lands = 1.0 + float(mpmath.findroot(height, 0.0868))
    assert motion.transitions[3].time == pytest.approx(lands, abs=1e-12)


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
