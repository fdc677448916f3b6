"""Random flights over ripples, and the searches that find their landings and second contacts."""

from __future__ import annotations

import itertools
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
    Trajectory,
    Unilateral,
    disc,
)
from cases.contact import find, start_motion
from tests.scenes.agreement import unlike_second
from tests.scenes.motions import energy
from tests.scenes.ripples import SIZE, G, closest, rippled

pytestmark = pytest.mark.taylor


# --- random flights ---------------------------------------------------------------------------------------------------

# CPU seconds that a flight over ripples may take with all that follows its landing, and what each transition may add: a
# plate that slides over ripples at 2 m/s may leave them and land a thousand times in a tenth of a second.
LIMIT, TRANSITION = 20.0, 0.05


def check(seed: int) -> None:
    """One random flight: it is answered in time, if not to its end, and a disc touches its track where it lands and
    nowhere before."""
    scene = rippled(seed)
    begun = time.process_time()
    motion = reference.simulate(scene.case)
    assert time.process_time() - begun < LIMIT + TRANSITION * len(motion.transitions), seed
    endings = ("completed", "landing", "second_contact", "no_fit", "track_end", "unfinished")
    assert motion.status in endings and motion.reason, (seed, motion.status)
    at = motion.transitions[0].time if motion.transitions else float(motion.t[-1])
    _energy(scene.case, motion, at, seed)
    if motion.transitions:
        place, state = motion.transitions[0], motion(at)
        contact = find(scene.case, state.x, state.y, state.theta, (place.xi1, place.xi2))
        assert abs(contact.gap) < 1e-14, seed
    if motion.status == "landing" and scene.shape == "disc":
        assert abs(closest(scene, at).apart) < 1e-14, seed
    if scene.shape == "disc":
        # A ten-millionth before, the gap is more than rounding.
        before = closest(scene, at * (1.0 - 1e-7) - 1e-13) if at > 1e-12 else None
        assert before is None or before.apart > -1e-14, (seed, at, before)
    else:
        _clear(scene.case, at, seed)


def _energy(case: Case, motion: Trajectory, at: float, seed: int) -> None:
    """The first flight keeps its energy; impacts and friction take some later, and nothing adds to it."""
    ends = np.unique([0.0, *(t.time for t in motion.transitions), float(motion.t[-1])])
    # At an instant of an impact velocities jump.
    times = np.unique([np.linspace(low, high, 9)[1:-1] for low, high in itertools.pairwise(ends)])
    if not len(times):
        return
    state = motion(times)
    energies = energy(case, state)
    moving = 0.5 * case.plate.mass * (state.vx**2 + state.vy**2) + 0.5 * case.plate.inertia * state.omega**2
    # Roundings of speeds and heights; contacts are integrated with a tolerance of 1e-10, and on ripples of a tenth of a
    # millimetre in thousands of steps (3e-10 after 6,400, and 7e-12 with a tolerance of 1e-12).
    growth = 1e-10 * max(1.0, motion.cost.steps / 1000.0)
    size = float(np.max(moving + case.plate.mass * G * (np.abs(state.y) + SIZE)))
    assert np.ptp(energies[times < at]) <= 1e-13 * size, seed
    assert np.all(np.diff(energies) <= growth * size), (seed, np.diff(energies).max() / size)


def _clear(case: Case, at: float, seed: int) -> None:
    """No point of the outline is below the ripples before the landing, at random times (tracks y = f(x) alone)."""
    x_of, f = case.track.expression
    if str(x_of) != "s":
        return
    begun, random = start_motion(case), np.random.default_rng(seed)
    t = at * (1.0 - 10.0 ** random.uniform(-9, 0, 300))
    u, v = case.plate.outline.point(np.linspace(*case.plate.outline.span, 6001))
    theta = (begun.theta + begun.omega * t)[:, None]
    x = begun.x + (begun.vx * t)[:, None] + np.cos(theta) * u - np.sin(theta) * v
    y = begun.y + (begun.vy * t - 0.5 * G * t * t)[:, None] + np.sin(theta) * u + np.cos(theta) * v
    low, high = case.track.span
    inside = (x > low) & (x < high)
    above = y[inside] - case.track.point(x[inside])[1]
    assert above.min(initial=1.0) > -1e-14, seed


@pytest.mark.sampled(6)
@pytest.mark.parametrize("seed", range(12))
def test_a_flight_over_ripples_ends_where_it_first_touches(seed):
    check(seed)


# 6 and 87: bounds on the curvature of ripples came from samples farther apart than a wavelength. A search of the second
# formulation never ended, and a landing came 0.4 µs late.
@pytest.mark.sampled(8)
@pytest.mark.parametrize("seed", [14, 6, 87, 12, 13, 15, 16, 18, 17, *range(19, 24)])
def test_both_formulations_find_the_same_landings_over_ripples(seed):
    case = rippled(seed).case
    assert unlike_second(case, reference.simulate(case, rtol=1e-13)) == ""


@pytest.mark.slow
@pytest.mark.parametrize("method, rtol", [("taylor", 1e-10), ("dop853", 1e-8)])
def test_a_contact_that_opens_more_slowly_than_its_gap_is_known_flies_off(method, rtol):
    """Flight 1947: an ellipse slides off a ripple. The gap after the first short step was a rounding of zero, or less
    than the error of DOP853's dense output, and the motion ended as an accumulation of changes of mode."""
    motion = reference.simulate(rippled(1947).case, rtol=rtol, method=method)
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
    motion = reference.simulate(rippled(seed).case)
    assert motion.status == "unfinished" and "search for" in motion.reason and len(motion.transitions) > 40


@pytest.mark.slow
def test_bouncing_over_ripples_rests_at_the_limit_of_its_impacts():
    """Flight 555: the disc passes a ripple while it bounces, whose length the extrapolation did not know: the limit was
    4.6e-7 s early. (Impacts computed one by one with 45 digits.)"""
    motion = reference.simulate(rippled(555).case, rtol=1e-13)
    assert motion.transitions[-1].time == pytest.approx(0.059447299434026, abs=1e-11)


@pytest.mark.slow
@pytest.mark.parametrize("lot", range(20))
def test_two_thousand_flights_over_ripples_end_where_they_first_touch(lot):
    for seed in range(100 * lot, 100 * (lot + 1)):
        check(seed)
