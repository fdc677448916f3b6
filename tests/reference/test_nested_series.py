"""Series of impacts that follow each other ever faster: off a wall, to rest on the floor, to the wall again."""

from math import cos, log, pi, sin, sqrt

import pytest

import reference
from cases import Case, Impact, Mode, StartPose, Support, disc
from cases.library import line
from cases.motion.trajectory import Transition
from reference.certification import certify
from reference.certification.witnesses import _by_second
from reference.witness import predict
from tests.reference.test_free_plates import random_scene
from tests.scenes.supports import FREE, G, agree, random_case, slow, with_restitution

SLOPE, LEAN, FLOOR, WALL, RADIUS, WAY, SPEED = 0.2, 0.35, 0.3, 0.5, 0.1, 0.3, 1.0


def disc_between_floor_and_wall() -> Case:
    """A frictionless disc slides down a floor to a wall whose normal points LEAN above the floor."""
    along = RADIUS * (1.0 - sin(LEAN)) / cos(LEAN) + WAY
    x, y = along * cos(SLOPE) - RADIUS * sin(SLOPE), along * sin(SLOPE) + RADIUS * cos(SLOPE)
    start = StartPose(x, y, vx=-SPEED * cos(SLOPE), vy=-SPEED * sin(SLOPE))
    wall = Support(line(pi / 2 - SLOPE - LEAN), "wall", (Impact(WALL),))
    return Case(line(-SLOPE), disc(RADIUS, 1.0), (*FREE, Impact(FLOOR)), start, 2.0, supports=(wall,))


def exact_times() -> tuple[list[float], float]:
    """The times (s) of the impacts on the wall that are listed, and of their end.

    The wall turns the normal part of a velocity u along the floor around: along the floor −u (1 − (1 + e) cos² LEAN)
    remains. Bouncing on the floor does not change that, and ends before the disc comes back, with the same speed, after
    2 u ρ/(g sin SLOPE): every impact is ρ times as fast as the one before.
    """
    pull, ratio = G * sin(SLOPE), (1.0 + WALL) * cos(LEAN) ** 2 - 1.0
    speed = sqrt(SPEED**2 + 2.0 * pull * WAY)
    time, times = (speed - SPEED) / pull, []
    for _ in range(1 + int(log(7e-4) / log(ratio))):
        times.append(time)
        end = time + 2.0 * speed * ratio / (pull * (1.0 - ratio))
        time, speed = time + 2.0 * speed * ratio / pull, speed * ratio
    return times, end


def check_wall(transitions: tuple[Transition, ...]) -> None:
    wall, (times, end) = [t for t in transitions if t.contact == "plate/wall"], exact_times()
    assert [t.after for t in wall] == [Mode.FLIGHT] * len(times) + [Mode.SLIDE]
    assert [t.time for t in wall[:-1]] == pytest.approx(times, abs=2e-13)
    assert wall[-1].time == pytest.approx(end, abs=1e-11)  # extrapolated
    assert transitions[-1] is wall[-1]


@pytest.mark.sampled(2, first=1)
@pytest.mark.parametrize("method", reference.METHODS)
def test_impacts_on_a_wall_after_rests_on_the_floor_end_in_the_exact_time(method):
    motion = reference.simulate(disc_between_floor_and_wall(), rtol=1e-13, method=method)
    assert motion.status == "completed"
    check_wall(motion.transitions)


@pytest.mark.slow
def test_the_second_formulation_ends_them_in_the_exact_time():
    second = _by_second(disc_between_floor_and_wall(), "second", 1e-13)
    assert second.status == "completed"
    check_wall(second.transitions)


# Rods and blocks on plane and wall. Before, the two formulations ended somewhere in hops of rounding: with different
# sequences, of up to 124 changes; 112 as `not_unique` in the second. 308 ends where one corner touches both planes.
@pytest.mark.parametrize("seed", [264, *slow(24, 112, 200, 261, 296)])
def test_plates_between_plane_and_wall_come_to_rest_in_both_formulations(seed):
    agree(with_restitution(random_case(seed), 0.4 if seed == 261 else 0.2), 5e-8)


@pytest.mark.slow
def test_series_may_end_where_the_motion_is_not_computed_any_more():
    case = with_restitution(random_case(308), 0.2)
    motion, second = reference.simulate(case, rtol=1e-14), _by_second(case, "second", 1e-13)
    assert motion.status == second.status == "breakdown" and "hold one point of the plate" in motion.reason
    assert second.end == pytest.approx(motion.t[-1], abs=1e-10)


# Discs that hit a third one, roll on the ground and hit it again; both formulations ended as `accumulation`.
@pytest.mark.slow
@pytest.mark.parametrize("seed", [2, 88, 183])
def test_discs_that_rattle_on_a_third_one_come_to_rest(seed):
    one, other = reference.simulate(random_scene(seed), rtol=1e-12), predict(random_scene(seed))
    assert one.status == other.status == "completed"
    assert [(t.contact, t.before, t.after) for t in one.transitions] == [
        (t.contact, t.before, t.after) for t in other.transitions
    ]
    assert [t.time for t in one.transitions] == pytest.approx([t.time for t in other.transitions], abs=1e-6)


@pytest.mark.slow
def test_a_series_ends_at_an_impact_that_others_follow_at_the_same_instant():
    """A disc rattles between two others and the track. Where it hits the track for the fourth time in the series, the
    gaps of the next impacts are rounding; the second formulation looked for the end after those, and went on."""
    one, other = reference.simulate(random_scene(268), rtol=1e-12), predict(random_scene(268))
    assert one.status == other.status == "completed" and len(one.transitions) == 52
    assert [(t.contact, t.before, t.after) for t in one.transitions] == [
        (t.contact, t.before, t.after) for t in other.transitions
    ]
    # The ends of both series are extrapolated; measured: 2.5e-12.
    assert [t.time for t in one.transitions] == pytest.approx([t.time for t in other.transitions], abs=5e-11)


@pytest.mark.slow
def test_such_a_motion_is_certified():
    certificate = certify(disc_between_floor_and_wall())
    (time, bar), (_, end) = certificate.transitions[-1][2], exact_times()
    assert abs(time - end) <= bar < 1e-9
