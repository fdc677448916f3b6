"""Motions of any duration, size and force: the second formulation answers them alike, or ends in a sentence."""

import re
from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest

import cases
from cases import (
    Case,
    CoulombFriction,
    Flight,
    Impact,
    Load,
    Plate,
    Start,
    disc,
)
from cases.library import circle, ellipse, line
from reference.witness import motion
from tests.scenes import second as second_states

from .test_second_formulation import GRIP, modes, on_line, solve

G = 9.81


# --- whatever the duration --------------------------------------------------------------------------------------------


def check_the_beginning(case: Case, factors) -> None:
    """Asserts that the motion up to the case's end is the same, to the last bit, with other durations."""
    first = second_states.motion(case)
    for factor in factors:
        long = second_states.motion(replace(case, duration=factor * case.duration), until=case.duration)
        assert long[:3] == first[:3]
        assert np.array_equal(long.last.points, first.last.points, equal_nan=True)
        assert np.array_equal(long.last.motion, first.last.motion, equal_nan=True)


@pytest.mark.sampled(3)
@pytest.mark.parametrize("name", ["disc_in_circle", "guided_loop", "bouncing_disc", "disc_in_weightless_ring"])
def test_the_beginning_of_a_motion_is_the_same_whatever_its_duration(name):
    check_the_beginning(cases.select(name)[0], (1e6,))


@pytest.mark.slow
@pytest.mark.parametrize("name", cases.names(hard=False))
def test_every_case_of_the_catalogue_begins_alike_whatever_its_duration(name):
    for case in cases.select(name):
        check_the_beginning(case, (7.0, 1e3, 1e6))


@pytest.mark.sampled(2)
@pytest.mark.parametrize("factor", [10.0, 40.0])
def test_the_papers_first_transition_does_not_depend_on_how_long_the_motion_goes_on(factor):
    # Without `until`: the motion is followed to its end.
    case = cases.load("disc_in_circle", mu=0.2)
    exact = second_states.motion(case).transitions[0]
    long = second_states.motion(replace(case, duration=factor * case.duration))
    assert long.status == "completed" and long.end == factor * case.duration
    assert long.transitions[0].time == pytest.approx(exact.time, abs=1e-12)


@pytest.mark.slow
def test_a_limping_wheel_that_goes_on_and_on_is_no_accumulation():
    case = cases.load("limping_wheel", duration=800.0)
    answer = second_states.motion(case, rtol=1e-8)
    assert answer.status == "completed"
    assert len(answer.transitions) > motion.MOST_PHASES
    # Four transitions a turn, at a period that does not change.
    times = np.array([t.time for t in answer.transitions])
    turns = times[4::4] - times[:-4:4]
    assert turns[100:] == pytest.approx(turns[100], rel=1e-5)


def test_a_plate_at_rest_waits_for_its_load_however_soon_or_late_it_sets_in():
    # Nothing moves and nothing acts at time zero: m x = p t³/6 without friction, from a millisecond to a day.
    for p, duration in ((1e9, 1e-3), (1.0, 1.0), (1e-14, 1e5)):
        case = on_line(Load(fx=f"{p!r}*t"), duration=duration)
        answer = solve(case, [duration])
        assert answer.status == "completed"
        assert answer.motions[0, 0] == pytest.approx(p * duration**3 / 12.0, rel=1e-10)


# --- beyond what numbers hold -----------------------------------------------------------------------------------------


def in_a_ring(*effects, size=1.0, duration=2.0, **start) -> Case:
    plate = Plate(ellipse(0.2 * size, 0.1 * size), 1.0, 0.0125 * size**2)
    return Case(circle(size), plate, (*GRIP, *effects), Start(-0.5, 0.3, **start), duration)


@pytest.mark.slow
@pytest.mark.parametrize("start", [dict(omega=2.0), dict(slip=1.0)])
def test_the_strongest_friction_is_as_good_as_a_tenth_of_it(start):
    # Up there the motion changes by the inverse of the coefficient only; 1e4 is the largest that a case may have.
    answer, other = (in_a_ring(CoulombFriction(m), Flight(), Impact(0.3), **start) for m in (1e4, 1e3))
    answer, other = second_states.motion(answer), second_states.motion(other)
    assert (answer.status, modes(answer)) == (other.status, modes(other))
    assert answer.end == pytest.approx(other.end, abs=1e-2)


@pytest.mark.sampled(2)
@pytest.mark.parametrize("size", [1e-8, 1e8])
def test_a_plate_of_any_size_bounces_like_one_of_a_metre(size):
    # Lengths times L and times √L: the same motion.
    def bouncing(L: float):
        effects = (*GRIP, CoulombFriction(0.2), Flight(), Impact(0.5))
        start = Start(0.0, gap=0.3 * L, slip=sqrt(L))
        return solve(Case(line(), disc(0.1 * L, 1.0), effects, start, 2.0 * sqrt(L)))

    one, other = bouncing(1.0), bouncing(size)
    assert (modes(one), one.status) == (modes(other), other.status)
    assert [t.time / sqrt(size) for t in other.transitions] == pytest.approx([t.time for t in one.transitions])


@pytest.mark.sampled(4)
@pytest.mark.parametrize(
    "make",
    [
        lambda: in_a_ring(CoulombFriction(0.2), Flight(), Impact(0.5), omega=1e30),
        lambda: on_line(*GRIP, Load(fx="sqrt(1 - t)"), duration=2.0),
        lambda: on_line(*GRIP, CoulombFriction(0.3), Load(fx="log(1 - t)"), duration=2.0),
        lambda: on_line(*GRIP, Flight(), Load(fy="-sqrt(0.1 - t)"), gap=0.5, duration=2.0),
    ],
)
def test_what_no_double_holds_ends_in_one_sentence(make):
    case = make()
    with pytest.raises(FloatingPointError) as problem:
        second_states.motion(case)
    assert "\n" not in str(problem.value) and len(str(problem.value)) > 30


@pytest.mark.slow
@pytest.mark.parametrize("load, pole", [("1/(1 - t)", 1.0), ("1/(t - 1)**2", 1.0), ("tan(3*t)", pi / 6)])
@pytest.mark.parametrize("effects", [(), (CoulombFriction(0.3),)])
def test_a_load_with_a_pole_inside_the_motion_is_not_passed_over(load, pole, effects):
    case = on_line(*GRIP, *effects, Load(fx=load), duration=2.0)
    with pytest.raises(FloatingPointError) as problem:
        second_states.motion(case)
    stopped = re.search(r"t = (\S+) s", str(problem.value))
    assert stopped and float(stopped[1]) == pytest.approx(pole, abs=1e-6)
