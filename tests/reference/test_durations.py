"""Scales come from the motion, never from how long one looks: the beginning of a motion is the same whatever its
duration, bouncing rests where it must, and what has no finite numbers ends in a sentence."""

from dataclasses import replace
from math import asin, cos, pi, sqrt

import numpy as np
import pytest

import cases
import reference
from cases import (
    Case,
    CaseError,
    CoulombFriction,
    Flight,
    Gravity,
    Impact,
    Load,
    Mode,
    PerfectlyRough,
    Plate,
    RollingResistance,
    Start,
    Unilateral,
    disc,
)
from cases.library import circle, ellipse, line
from reference.minimal.bouncing import LISTING_PART
from reference.solver import march
from tests.sampling import quick_every

G = 9.81
METHODS = pytest.mark.parametrize("method", reference.METHODS)
REBOUND = (Mode.FLIGHT, Mode.FLIGHT)


def dropped(e: float, height: float, duration: float) -> Case:
    effects = (Gravity(G), CoulombFriction(0.3), Unilateral(), Flight(), Impact(e))
    return Case(line(), disc(0.1, 1.0), effects, Start(0.0, gap=height), duration)


def hitting(e: float, law: str, speed: float, duration: float = 1.0, gap: float = 0.0) -> Case:
    effects = (Gravity(G), Unilateral(), Flight(), Impact(e, law))
    return Case(line(), disc(0.1, 1.0), effects, Start(0.0, gap=gap, gap_rate=-speed), duration)


def pairs(motion, until: float = np.inf):
    return [(t.before, t.after) for t in motion.transitions if t.time <= until]


# --- the beginning of a motion ----------------------------------------------------------------------------------------


@quick_every(2)
@METHODS
@pytest.mark.parametrize("duration", [200.0, pytest.param(1000.0, marks=pytest.mark.slow)])
def test_the_papers_disc_first_rolls_at_its_time_whatever_the_duration(method, duration):
    # 40-digit quadrature: 0.63005376392730307737 s. By the Taylor method it was 0.630073 with 400 s, 1.167 with 800 s.
    motion = reference.simulate(replace(cases.load("disc_in_circle", mu=0.2), duration=duration), method=method)
    assert motion.transitions[0].time == pytest.approx(0.63005376392730307737, abs=1e-10)
    assert motion.status == "completed"
    if duration == 1000.0:
        assert len(motion.transitions) == 1685


@quick_every(3)
@pytest.mark.skipif("taylor" not in reference.METHODS, reason="heyoka is not installed")
@pytest.mark.parametrize("rtol", [1e-7, 1e-10, 1e-13])
def test_a_release_from_a_symmetric_place_keeps_its_energy_from_the_first_step_on(rtol):
    # Only every fourth power of time is there: whichever order the tolerance asks for, two of them may vanish.
    motion = reference.simulate(cases.load("rough_disc_in_circle"), rtol=rtol, method="taylor")
    energy = 0.75 * (motion.vx**2 + motion.vy**2) + G * motion.y
    assert np.ptp(energy) <= 100 * rtol * G


FEW = ("disc_off_ramp", "tumbling_ellipse", "bouncing_disc[e=0.8]")


@quick_every(5)
@METHODS
@pytest.mark.parametrize("label", FEW)
@pytest.mark.parametrize("factor", [3.0, 30.0])
def test_the_beginning_of_a_motion_is_the_same_for_longer_durations(method, label, factor):
    case = cases.load(label)
    short, long = (
        reference.simulate(replace(case, duration=part * case.duration), method=method) for part in (1.0, factor)
    )
    end = float(short.t[-1])
    assert pairs(long, end) == pairs(short)
    for one, other in zip(short.transitions, long.transitions, strict=False):
        assert other.time == pytest.approx(one.time, rel=1e-12, abs=1e-11)
    for name in ("x", "y", "theta"):
        assert getattr(long(end), name) == pytest.approx(getattr(short(end), name), rel=1e-10, abs=1e-9)


# --- bouncing ---------------------------------------------------------------------------------------------------------


def rest(e: float, height: float) -> float:
    """√(2h/g) (1 + e)/(1 − e)."""
    return sqrt(2 * height / G) * (1 + e) / (1 - e)


@quick_every(5)
@METHODS
@pytest.mark.parametrize("duration", [10.0, 300.0, 3600.0])
def test_bouncing_rests_at_its_limit_whatever_the_duration(method, duration):
    # 6.066233139731 s; it was 2.6e-4 s less with 300 s and 2.9e-3 s less with 3600 s.
    motion = reference.simulate(dropped(0.9, 0.5, duration), method=method)
    assert motion.transitions[-1].cause == "bouncing came to rest"
    # A rounding of a flight's end counts 1/(1 − e) times: all that follows is later by as much.
    assert motion.transitions[-1].time == pytest.approx(rest(0.9, 0.5), abs=1e-12 / (1 - 0.9))


@METHODS
@pytest.mark.parametrize("duration", [20.0, pytest.param(2000.0, marks=pytest.mark.slow)])
def test_a_plate_that_never_rests_lists_every_bounce(method, duration):
    motion = reference.simulate(dropped(1.0, 0.05, duration), method=method)
    fall = sqrt(2 * 0.05 / G)
    expected = np.arange(fall, duration, 2 * fall)
    assert pairs(motion) == [REBOUND] * len(expected)
    np.testing.assert_allclose([t.time for t in motion.transitions], expected, rtol=1e-11)


@pytest.mark.parametrize("e", [0.1, 0.5, 0.8, 0.9])
def test_impacts_are_listed_by_their_closing_speed(e):
    motion = reference.simulate(dropped(e, 0.2, 60.0))
    listed = 1 + int(np.floor(np.log(LISTING_PART) / np.log(e)))  # the n-th closes with eⁿ⁻¹ of the first speed
    assert pairs(motion) == [REBOUND] * listed + [(Mode.FLIGHT, Mode.ROLL)]


# --- starts and landings that hit -------------------------------------------------------------------------------------


@quick_every(5)
@METHODS
@pytest.mark.parametrize("law", ["poisson", "newton", "moreau"])
@pytest.mark.parametrize("e", [0.5, 0.9, 1.0])
@pytest.mark.parametrize("speed", [1e-6, 300.0])
def test_a_start_that_begins_with_an_impact_rebounds(method, law, e, speed):
    motion = reference.simulate(hitting(e, law, speed, duration=10 * speed / G), method=method)
    first = motion.transitions[0]
    assert (first.time, first.before, first.after) == (0.0, *REBOUND)
    soon = 1e-3 * speed / G
    assert motion(soon).vy == pytest.approx(e * speed - G * soon, rel=1e-12)


@METHODS
def test_a_rebound_lower_than_positions_are_known_is_none(method):
    motion = reference.simulate(hitting(0.5, "poisson", 1e-9), method=method)
    assert pairs(motion) == [(Mode.FLIGHT, Mode.SLIDE)]


@METHODS
@pytest.mark.parametrize("closing", [1.0, 0.05, 1e-6])
def test_a_start_that_closes_is_an_impact_though_the_plate_is_pulled_off(closing, method):
    """Under a ceiling: without the impact the gap would open again after 2u/g, a few milliseconds."""
    effects, start = (Gravity(G, pi / 2), Unilateral(), Flight(), Impact(0.5)), Start(0.0, gap_rate=-closing)
    motion = reference.simulate(Case(line(), disc(0.1, 1.0), effects, start, 0.5), method=method)
    assert [(t.time, t.after) for t in motion.transitions] == [(0.0, Mode.FLIGHT)]
    assert float(motion(0.5).vy) == pytest.approx(0.5 * closing + G * 0.5, rel=1e-13)


@METHODS
def test_a_leap_so_low_that_its_rebounds_drown_in_rounding_rests_at_its_limit(method):
    """1e-5 m/s up a slope: the ninth rebound rises by less than a position's rounding, with 20 ns of bouncing to go.

    Rebounds of e = 0.536 from a lift u under g cos α last 2u/(g cos α (1 - e)) in all.
    """
    slope, e, lift = 0.5717851550215713, 0.5360387281788312, 1e-5
    effects = Gravity(G), Unilateral(), Flight(), Impact(e, "newton")
    motion = reference.simulate(
        Case(line(slope), disc(0.1, 1.0), effects, Start(0.0, gap_rate=lift), 1.0), method=method
    )
    assert motion.transitions[-1].time == pytest.approx(2 * lift / (G * cos(slope) * (1 - e)), rel=1e-12)
    assert len(motion.transitions) == 9


@METHODS
@pytest.mark.parametrize("lift", [1e-245, 1e-20])
def test_a_leap_of_nothing_on_a_rough_track_ends_in_rolling(lift, method):
    """It comes down before double precision sees it rise; the impact takes the slip: a disc keeps a third of its spin
    and two thirds of its speed (from angular momentum about the contact)."""
    effects = Gravity(G), PerfectlyRough(), Unilateral(), Flight(), Impact(0.0343)
    start = Start(0.0, slip=0.3, omega=-1e-230, gap_rate=lift)
    motion = reference.simulate(Case(line(1e-6), disc(0.1, 1.0), effects, start, 1.0), method=method)
    assert (motion.status, [t.after for t in motion.transitions]) == ("completed", [Mode.ROLL])
    assert float(motion(1e-9).vx) == pytest.approx(0.2, rel=1e-7)


# --- a touch that is no departure -------------------------------------------------------------------------------------


@quick_every(3)
@METHODS
@pytest.mark.parametrize("rtol", [1e-3, 1e-6, 1e-10, 1e-14])
def test_frictionless_disc_that_comes_back_to_its_height_stays_on_its_track(method, rtol):
    # There N and v vanish together, at 1.12316596 s first.
    case = Case(circle(1.0), disc(0.1, 1.0), (Gravity(G), Unilateral()), Start(0.0), 6.0)
    motion = reference.simulate(case, rtol=rtol, method=method)
    assert motion.status == "completed" and not motion.transitions


@METHODS
@pytest.mark.parametrize("slip", [1e-3, 1e-2])
def test_a_little_more_speed_than_that_is_a_departure(method, slip):
    # It rises above the start's height to where N = 0: L ξ̇² = v₀²/L − 2 g sin δ is g sin δ.
    case = Case(circle(1.0), disc(0.1, 1.0), (Gravity(G), Unilateral()), Start(0.0, slip=-slip), 2.0)
    motion = reference.simulate(case, rtol=1e-13, method=method)
    assert motion.status == "lift_off"
    assert -pi - motion.transitions[-1].xi1 == pytest.approx(asin(slip**2 / (3 * G * 0.9)), rel=1e-5)


# --- too many, too large, none ----------------------------------------------------------------------------------------


def test_a_flight_too_fast_to_follow_says_how_far_it_was_followed(monkeypatch):
    # Near its track each of an ellipse's points may be the first to land, many times while it falls by its size.
    effects = (Gravity(G), Unilateral(), Flight(), Impact(0.5))
    spins = Case(line(), Plate(ellipse(0.1, 0.07), 1.0, 1e-3), effects, Start(0.0, 0.0, omega=1e6, gap=0.05), 1.0)
    monkeypatch.setattr(march, "MOST_STEPS", 1000)
    motion = reference.simulate(spins, rtol=1e-6)
    assert motion.status == "unfinished" and f"{motion.t[-1]:.9g}" in motion.reason
    fallen = 0.5 * G * motion.t**2
    assert 0.0 < motion.t[-1] < 0.01 and np.allclose(motion.y[0] - motion.y, fallen, atol=1e-12)


LARGE = {
    "friction of 1e9": lambda: Case(
        line(),
        cases.Plate(ellipse(0.2, 0.1), 1.0, 0.01),
        (Gravity(G), CoulombFriction(1e9), Unilateral(), Flight(), Impact(0.5)),
        Start(0.0, gap=0.3, slip=1.0, xi2=4.0),
        1.0,
    ),
    **{
        f"a circle of {size:g} m": lambda size=size: Case(
            circle(size), disc(0.1 * size, 1.0), (Gravity(G), CoulombFriction(0.2), Unilateral()), Start(0.0), 1.0
        )
        for size in (1e-100, 1e100, 1e150, 1e200)
    },
    **{
        f"a disc of {size:g} m on a line": lambda size=size: Case(
            line(), disc(size, 1.0), (Gravity(G), CoulombFriction(0.2), Unilateral()), Start(0.0, slip=1.0), 1.0
        )
        for size in (1e-100, 1e100, 1e150)
    },
    **{
        f"an impact at {speed:g} m/s": lambda speed=speed: hitting(0.5, "poisson", speed)
        for speed in (1e-100, 1e100, 1e200)
    },
}


@METHODS
@pytest.mark.parametrize("make", LARGE.values(), ids=LARGE)
def test_what_is_too_large_or_too_small_ends_in_a_sentence(make, method):
    try:
        motion = reference.simulate(make(), method=method)
    except CaseError as output:
        assert "\n" not in str(output)
        return
    assert motion.reason.count(".") >= 1
    assert all(np.isfinite(getattr(motion, name)).all() for name in ("x", "y", "theta", "vx", "vy", "omega"))


@quick_every(5)
@METHODS
@pytest.mark.parametrize("force", ["1/(0.5-t)", "log(0.5-t)", "sqrt(0.5-t)"])
@pytest.mark.parametrize("scene", ["slides", "flies", "rests"])
def test_a_load_with_a_singularity_inside_the_motion_ends_it_there(scene, force, method):
    more = {"slides": (), "flies": (Flight(), Impact(0.5)), "rests": (RollingResistance(0.05),)}[scene]
    start = Start(0.0, gap=0.5) if scene == "flies" else Start(0.0, slip=0.0 if scene == "rests" else 1.0)
    effects = (Gravity(G), CoulombFriction(0.9), Unilateral(), Load(fx=force), *more)
    motion = reference.simulate(Case(line(), disc(0.1, 1.0), effects, start, 1.0), method=method)
    assert motion.status == "breakdown" and "t = 0." in motion.reason
    assert motion.t[-1] == pytest.approx(0.5, abs=1e-6)
    assert all(np.isfinite(getattr(motion, name)).all() for name in ("x", "y", "theta", "vx", "vy", "omega"))
