"""Random flights over ripples, and the searches that find their landings and second contacts."""

from __future__ import annotations

import time

import numpy as np
import pytest

import reference
from cases import (
    Case,
    CoulombFriction,
    Curve,
    Flight,
    Gravity,
    Impact,
    Start,
    Unilateral,
    disc,
)
from cases.contact import find
from tests.sampling import quick_every
from tests.scenes.ripples import SIZE, G, rippled

# --- random flights ---------------------------------------------------------------------------------------------------

# CPU seconds that a flight over ripples may take with all that follows its landing, and what each transition may add: a
# plate that slides over ripples at 2 m/s may leave them and land a thousand times in a tenth of a second.
LIMIT, TRANSITION = 20.0, 0.05


def check(seed: int) -> None:
    """One random flight: it is answered in time, if not to its end, breaks no law, and touches where it lands."""
    case = rippled(seed)
    begun = time.process_time()
    motion = reference.simulate(case)
    assert time.process_time() - begun < LIMIT + TRANSITION * len(motion.transitions), seed
    endings = ("completed", "landing", "second_contact", "no_fit", "track_end", "unfinished")
    assert motion.status in endings and motion.reason, (seed, motion.status)
    assert not reference.check(case, motion), seed
    if motion.transitions:
        place = motion.transitions[0]
        state = motion(place.time)
        contact = find(case, state.x, state.y, state.theta, (place.xi1, place.xi2))
        assert abs(contact.gap) < 1e-14, seed


@quick_every(6)
@pytest.mark.parametrize("seed", range(12))
def test_a_flight_over_ripples_ends_where_it_first_touches(seed):
    check(seed)


# 6 and 87: bounds on the curvature of ripples came from samples farther apart than a wavelength. A search of the second
# formulation never ended, and a landing came 0.4 µs late.


@pytest.mark.slow
@pytest.mark.parametrize("method, rtol", [("taylor", 1e-10), ("dop853", 1e-8)])
def test_a_contact_that_opens_more_slowly_than_its_gap_is_known_flies_off(method, rtol):
    """Flight 1947: an ellipse slides off a ripple. The gap after the first short step was a rounding of zero, or less
    than the error of DOP853's dense output, and the motion ended as an accumulation of changes of mode."""
    motion = reference.simulate(rippled(1947), rtol=rtol, method=method)
    assert (len(motion.transitions), motion.status) == (23, "completed")


def test_a_hop_from_one_crest_may_end_on_the_next():
    """Flight 871: where ripples bend more than the disc, it may land elsewhere before its hop ends where it began. That
    was not searched for if the gap at the hop's end was a rounding below zero: here 1.7 µs and 0.6 nm too late."""
    track = Curve(("s", "1.585e-8*sin(52807.4*s+6.260769393)"), (0.025, 0.034))
    start = Start(0.02931086, 3.28121863, omega=-3.37083933, gap_rate=5.1e-5)
    effects = (Gravity(G), Unilateral(), Flight(), CoulombFriction(0.3), Impact(0.5))
    motion = reference.simulate(Case(track, disc(SIZE, 1.0), effects, start, 1.2e-5), rtol=1e-13)
    landing = motion.transitions[0]
    # Points 1e-8 m apart give a distance to 1e-15 m.
    x, y = track.point(np.linspace(0.0292, 0.0295, 30_001))
    for t in np.linspace(0.0, landing.time, 50):
        state = motion(t)
        apart = float(np.hypot(x - state.x, y - state.y).min()) - SIZE
        assert apart > -1e-15
    assert apart < 4e-15 and landing.xi1 > 0.0294


@pytest.mark.slow
@pytest.mark.parametrize("seed", [270, 522, 651])
def test_a_flight_that_hardly_goes_on_is_unfinished(seed):
    """Nine impacts in a millisecond, with a search of 60 ms after each, or a landing that no box excludes: these took
    more than 20 s of CPU time, 522 up to a `breakdown`."""
    motion = reference.simulate(rippled(seed))
    assert motion.status == "unfinished" and "search for" in motion.reason and len(motion.transitions) > 40


@pytest.mark.slow
def test_bouncing_over_ripples_rests_at_the_limit_of_its_impacts():
    """Flight 555: the disc passes a ripple while it bounces, whose length the extrapolation did not know: the limit was
    4.6e-7 s early. (Impacts computed one by one with 45 digits.)"""
    motion = reference.simulate(rippled(555), rtol=1e-13)
    assert motion.transitions[-1].time == pytest.approx(0.059447299434026, abs=1e-11)
