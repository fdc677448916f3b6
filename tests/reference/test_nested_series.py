"""Series of impacts that follow each other ever faster: off a wall, to rest on the floor, to the wall again."""

from math import cos, log, pi, sin, sqrt

import pytest

import reference
from cases import Case, Impact, Mode, StartPose, Support, disc
from cases.library import line
from cases.motion.trajectory import Transition
from reference.certification import certify
from reference.certification.witnesses import _by_second
from tests.sampling import quick_every
from tests.scenes.supports import FREE, G

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


@quick_every(2, first=1)
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


@pytest.mark.slow
def test_such_a_motion_is_certified():
    certificate = certify(disc_between_floor_and_wall())
    (time, bar), (_, end) = certificate.transitions[-1][2], exact_times()
    assert abs(time - end) <= bar < 1e-9
