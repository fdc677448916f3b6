"""Poses at supports."""

from math import cos, pi, sin

import pytest

import cases
import reference
from cases import Case, Gravity, PerfectlyRough, Plate, StartPose, disc  # fmt: skip
from cases.contact import start_motion
from cases.library import ellipse, line
from tests.scenes.supports import INELASTIC, G


def test_a_pose_is_the_start_of_the_nearest_point():
    case = Case(line(0.2), disc(0.5, 1.0), INELASTIC, StartPose(0.1, 0.9, 0.3, 1.0, -0.5, 2.0), 1.0)
    begin = start_motion(case)
    assert (begin.x, begin.y, begin.vx, begin.vy, begin.omega) == pytest.approx((0.1, 0.9, 1.0, -0.5, 2.0), abs=1e-14)
    assert begin.theta == pytest.approx(0.3, abs=1e-14) and case.start.gap > 0.0
    touching = Case(line(0.2), disc(0.5, 1.0), INELASTIC, StartPose(0.5 * sin(0.2), 0.5 * cos(0.2)), 1.0)
    assert touching.start.gap == 0.0 and touching.start.xi1 == pytest.approx(0.0, abs=1e-15)


def test_a_pose_may_touch_at_the_seam_of_its_outline():
    """The ellipse stands on the point of its parameter 0, where its samples begin and end."""
    plate = Plate(ellipse(0.2, 0.1), 1.0, 0.02)
    start = Case(line(), plate, INELASTIC, StartPose(0.3, 0.2, -0.5 * pi), 1.0).start
    assert (start.gap, start.xi1, sin(0.5 * start.xi2)) == pytest.approx((0.0, 0.3, 0.0), abs=1e-14)


@pytest.mark.parametrize("v", [0.1, 0.3, 0.7])
def test_a_pose_that_rolls_has_no_slip_of_rounding(v):
    # 1e-17 m/s was one, with which a rough contact cannot begin.
    pose = StartPose(0.3 * sin(0.3), 0.3 * cos(0.3), 0.0, v * cos(0.3), -v * sin(0.3), -v / 0.3)
    assert Case(line(0.3), disc(0.3, 1.0), (Gravity(G), PerfectlyRough()), pose, 1.0).start.slip == 0.0


def test_a_case_with_supports_travels_by_value():
    import pickle

    case = cases.load("ladder_at_wall", mu=0.1, mu_wall=0.2)
    again = pickle.loads(pickle.dumps(case))
    assert again == case and hash(again) == hash(case) and again.supports[0].name == "wall"
    motion = pickle.loads(pickle.dumps(reference.simulate(case)))
    assert motion.contact_names == ("plate/track", "plate/track 2", "plate/wall")
