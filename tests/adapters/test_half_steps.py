"""The one reader of engines whose velocities stand beside their poses, on rows whose motion is known exactly."""

from __future__ import annotations

from math import sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import cases
from adapters.common.half_steps import StepRecord, rates_at_poses, read
from cases import Case, Flight, Gravity, Impact, Start, Unilateral, disc, library

G = 9.81


def sides(function, rest: float, count: int = 12, h: float = 0.1):
    """Velocities as an engine notes them: `rest` of a step before the poses k·h, and the rest of it after."""
    t = h * np.arange(count)
    before = np.array([function(v) for v in np.concatenate([[0.0], t[1:] - rest * h])])
    after = np.array([function(v) for v in t + (1 - rest) * h])
    return t, before, after


@given(rest=st.floats(0.05, 0.5), c=st.lists(st.floats(-5.0, 5.0), min_size=9, max_size=9))
def test_velocities_that_are_parabolas_in_time_are_read_exactly(rest, c):
    def function(t):
        return [c[i] + c[i + 1] * t + c[i + 2] * t * t for i in (0, 3, 6)]

    t, before, after = sides(function, rest)
    exact = np.array([function(v) for v in t])
    assert rates_at_poses(before, after, 0.1, rest) == pytest.approx(exact, abs=1e-12)


def test_no_second_difference_reaches_across_a_jump_of_the_acceleration():
    """Speeds up until 0.55 s, then slows down; read exactly at every pose but those beside it."""
    t, before, after = sides(lambda t: [min(t, 1.1 - t), 0.0, 0.0], rest=0.5)
    read_back, exact = rates_at_poses(before, after, 0.1)[:, 0], np.minimum(t, 1.1 - t)
    off = np.abs(read_back - exact)
    assert off[np.abs(t - 0.55) > 0.06].max() < 1e-15


# --- an engine of six lines: semi-implicit Euler, a level floor, restitution ------------------------------------------


def dropped(case: Case, h: float, restitution: float) -> StepRecord:
    """A disc that falls onto a level line, without friction; in the step in which it would sink in it rebounds, or
    closes what is left of the gap."""
    start, steps = cases.contact.start_motion(case), round(case.duration / h)
    y, vy, radius, rows = start.y, start.vy, case.plate.radius, []
    for k in range(steps + 1):
        vy -= G * (h if k else 0.5 * h)
        if y + h * vy < radius:
            vy = -restitution * vy or (radius - y) / h
        rows.append((start.x + start.vx * k * h, y, 0.0, start.vx, vy, 0.0))
        y += h * vy
    return StepRecord(case, h, steps, np.array(rows))


def falling_onto_a_line(*effects, duration: float = 0.5) -> Case:
    start = Start(0.0, slip=0.3, gap=0.2)
    return Case(library.line(), disc(0.1, 2.0), (Gravity(G), Unilateral(), Flight(), *effects), start, duration)


LANDS, SPEED = sqrt(2 * 0.2 / G), sqrt(2 * G * 0.2)


@pytest.mark.parametrize("restitution", [0.0, 0.5])
def test_an_impact_is_read_with_the_velocities_of_both_its_sides(restitution):
    h = 1e-3
    motion = read(dropped(falling_onto_a_line(Impact(restitution)), h, restitution))
    at = int(np.flatnonzero(np.diff(motion.t) == 0.0)[0])
    # Where the impact lies within its step is not known.
    assert motion.t[at] == pytest.approx(LANDS, abs=h)
    assert motion.vy[at] == pytest.approx(-SPEED, abs=G * h)
    assert motion.vy[at + 1] == pytest.approx(restitution * SPEED, abs=2 * G * h)
    # The plate flies there, and flies on or stays; where it stays a step's impulse tells no force.
    assert np.isnan(motion.slip[at]) and motion.normal_force[at] == 0.0
    if restitution:
        assert np.isnan(motion.slip[at + 1]) and motion.normal_force[at + 1] == 0.0
    else:
        assert motion.slip[at + 1] == pytest.approx(0.3, abs=1e-12) and np.isnan(motion.normal_force[at + 1])
        # Such an impact takes two steps.
        assert motion.normal_force[at + 3 :] == pytest.approx(2.0 * G, rel=1e-9)
