"""Impacts on supports: series of them end at their limits, and what closes for microseconds is one."""

from math import cos, pi, sin, sqrt

import numpy as np
import pytest

import reference
from cases import Case, Impact, Load, Mode, StartPose, Support, disc
from cases.library import line
from reference.certification.witnesses import _by_second
from tests.sampling import quick_every
from tests.scenes import second as second_states
from tests.scenes.supports import FREE, G


@quick_every(3)
@pytest.mark.parametrize("method", [*reference.METHODS, "second"])
def test_bouncing_ends_on_each_support_at_the_limit_of_its_own_series(method):
    """A disc falls on a floor (e = 0.2), and a load pulls it to a wall (e = 0.8): without friction neither bouncing
    knows of the other. That on the wall ends 4e-4 s later, in hops of 1e-9 m when the other one ends."""
    radius, a, e, e_wall = 0.3, 1.0, 0.2, 0.8
    first = 5e-4 / (
        8.0 * e_wall**34
    )  # so that a hop on the wall lasts 1e-4 s and begins 0.85e-4 s before the floor's end
    wall_end = first * (1.0 + 2.0 * e_wall / (1.0 - e_wall))
    fall = (wall_end - 4.15e-4) / (1.0 + 2.0 * e / (1.0 - e))
    wall = Support(line(pi / 2), "wall", (Impact(e_wall, "moreau"),))
    start = StartPose(radius + 0.5 * a * first**2, radius + 0.5 * G * fall**2)
    effects = (*FREE, Impact(e, "moreau"), Load(fx=-a))
    case = Case(line(), disc(radius, 1.0), effects, start, 1.3, supports=(wall,))
    motion = _by_second(case, "second", 1e-13) if method == "second" else reference.simulate(case, 1e-14, method)
    last = {t.contact: t for t in motion.transitions}
    assert {t.after for t in last.values()} == {Mode.SLIDE} and len(last) == 2
    # Gaps have roundings of 1e-16 m, and the impacts before the end close with 1e-6 m/s.
    assert last["plate/track"].time == pytest.approx(wall_end - 4.15e-4, abs=1e-9)
    assert last["plate/wall"].time == pytest.approx(wall_end, abs=1e-9)


@pytest.mark.parametrize("method", [*reference.METHODS, "second"])
def test_a_contact_that_closes_where_a_series_ends_lands_at_that_instant(method):
    """A frictionless disc bounces on a floor (e = 0.2), and reaches a wall where that ends. The second formulation
    ended it 1e-8 s early, and `dop853` 2e-12 s: the wall closed a rounding before the end.

    With friction (found at random) a block's corner bounces on a wall until its side lies on the wall."""
    radius, e, speed, height = 0.3, 0.2, 1.3, 0.2
    end = sqrt(2.0 * height / G) * (1.0 + 2.0 * e / (1.0 - e))
    wall = Support(line(pi / 2), "wall", (Impact(0.5, "moreau"),))
    start = StartPose(radius + speed * end, radius + height, vx=-speed)
    case = Case(line(), disc(radius, 1.0), (*FREE, Impact(e, "moreau")), start, 1.0, supports=(wall,))
    motion = _by_second(case, "second", 1e-13) if method == "second" else reference.simulate(case, 1e-14, method)
    floor, side = motion.transitions[-2:]
    assert (floor.contact, floor.after) == ("plate/track", Mode.SLIDE)
    assert (side.contact, side.after) == ("plate/wall", Mode.FLIGHT)
    # The last impact used closes with 3e-4 m/s, and its gap has a rounding of 1e-16 m.
    assert floor.time == side.time == pytest.approx(end, abs=1e-12)


@quick_every(4)
@pytest.mark.parametrize("method", [*reference.METHODS, "second"])
@pytest.mark.parametrize(("lowest", "after"), [(-1e-10, 1e-5), (1e-10, 1e-5), (-1e-10, 4e-3)])
def test_a_gap_that_closes_for_microseconds_is_an_impact(lowest, after, method):
    # Gravity pulls a thrown disc away from a wall that leans over it by 0.3: its gap is h - v t + g sin(0.3) t²/2, with
    # the least value `lowest` at the time `after`.
    lean, radius = 0.3, 0.3
    away = G * sin(lean)
    speed, gap = away * after, 0.5 * away * after**2 + lowest
    wall = Support(line(pi / 2 + lean), "wall")
    normal, along = np.array([cos(lean), -sin(lean)]), np.array([sin(lean), cos(lean)])
    x, y = (radius + gap) * normal + along
    start = StartPose(float(x), float(y), 0.0, *(-speed * normal).tolist(), 0.0)
    case = Case(line(), disc(radius, 1.0), (*FREE, Impact(0.5, "moreau")), start, 0.02, supports=(wall,))
    if method == "second":
        transitions = _by_second(case, "second", 1e-13).transitions
    else:
        transitions = reference.simulate(case, rtol=1e-14, method=method).transitions
    if lowest > 0.0:
        assert not transitions
        return
    assert [(t.contact, t.before, t.after) for t in transitions] == [("plate/wall", Mode.FLIGHT, Mode.FLIGHT)]
    # The place's rounding of 1e-16 m at the closing speed of 1e-5 m/s.
    exact = after - sqrt(-2.0 * lowest / away)
    assert transitions[0].time == pytest.approx(exact, abs=1e-10)


@quick_every(4)
@pytest.mark.parametrize("method", [*reference.METHODS, "second"])
@pytest.mark.parametrize("e", [0.3, 0.8])
def test_bouncing_on_one_support_ends_at_the_limit_of_its_series(e, method):
    # A disc falls for T = sqrt(2 h/g); its bounces take 2 e T, 2 e² T, ...: 2 T e/(1 - e) in all. It keeps its speed
    # along the plane.
    radius, height, vx = 0.3, 0.05, 0.1
    wall = Support(line(pi / 2), "wall")
    start = StartPose(1.2, radius + height, 0.0, vx, 0.0, 0.0)
    case = Case(line(0.0), disc(radius, 1.0), (*FREE, Impact(e, "moreau")), start, 1.5, supports=(wall,))
    if method == "second":
        motion = _by_second(case, "second", 1e-13)
        x = float(second_states.poses(case, [1.4])[0, 0])
    else:
        motion = reference.simulate(case, rtol=1e-14, method=method)
        x = float(motion(1.4).x)
    last = motion.transitions[-1]
    assert (last.before, last.after) == (Mode.FLIGHT, Mode.SLIDE)
    assert last.time == pytest.approx(sqrt(2.0 * height / G) * (1.0 + 2.0 * e / (1.0 - e)), abs=2e-10)
    assert x == pytest.approx(1.2 + vx * 1.4, abs=1e-12)
