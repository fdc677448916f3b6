"""A plate of infinite inertia with several contacts: exact forces and motions, two formulations, the paper's matrix."""

from itertools import product
from math import cos, inf, sin

import numpy as np
import pytest

from cases import Case, CoulombFriction, Flight, Gravity, Impact, Mode, StartPose, Support, Unilateral, disc
from cases.library import line
from tests.scenes.supports import events, simulated

from .test_belts_and_supports import METHODS, motion_by

pytestmark = pytest.mark.taylor

G, R = 9.81, 0.5
LEFT, RIGHT = 0.5, 0.3


def in_v(mu=0.0, mu_right=0.0, lift=0.0, left=LEFT, right=RIGHT, end=1.0) -> Case:
    """A plate of 1 kg in a V of two planes, at rest on both, or farther up on the left one by that length."""
    own, friction = ((CoulombFriction(value),) if value else () for value in (mu_right, mu))
    x, y = R * (cos(right) - cos(left)) / sin(left + right), R * (sin(left) + sin(right)) / sin(left + right)
    effects = (Gravity(G), Unilateral(), Flight(), Impact(0.0, "moreau"), *friction)
    start = StartPose(x - lift * cos(left), y + lift * sin(left))
    return Case(line(left), disc(R, 1.0, inf), effects, start, end, supports=(Support(line(-right), "right", own),))


def columns(motion, name: str, *times: float):
    return motion.contact_columns(f"plate/{name}", np.array(times))


# --- at rest ----------------------------------------------------------------------------------------------------------


def test_two_planes_with_friction_hold_it_by_a_range_of_forces():
    """No moment limits them: the extreme forces lie on one edge of each cone, R₁ + R₂ = −m g."""
    mu, mu_right = 0.15, 0.2
    motion, ends = simulated(in_v(mu, mu_right)), list[np.ndarray]()
    normals = [np.array([sin(LEFT), cos(LEFT)]), np.array([-sin(RIGHT), cos(RIGHT)])]
    tangents = [np.array([n[1], -n[0]]) for n in normals]
    for signs in product((-1.0, 1.0), repeat=2):
        edges = [n + s * m * t for n, t, s, m in zip(normals, tangents, signs, (mu, mu_right), strict=True)]
        ends.append(np.linalg.solve(np.array(edges).T, [0.0, G]))
    assert np.min(ends) > 0.0
    for k, name in enumerate(("track", "right")):
        at = columns(motion, name, 0.5)
        assert np.isnan(at.normal_force[0])
        assert at.normal_range[:, 0] == pytest.approx([min(e[k] for e in ends), max(e[k] for e in ends)], rel=1e-9)


# --- impacts ----------------------------------------------------------------------------------------------------------


@METHODS
def test_a_plate_slides_down_one_plane_and_up_the_other(method):
    """It slides over `lift` with g (sin α − μ cos α). With the angle α + β between the planes, e = 0, the impulse
    m v sin(α + β) stops it towards the other one, and its friction takes μ₂ times that from v cos(α + β)."""
    mu, mu_right, lift = 0.1, 0.2, 0.8
    motion = motion_by(in_v(mu, mu_right, lift, end=1.2), method)
    down = G * (sin(LEFT) - mu * cos(LEFT))
    hits, v = np.sqrt(2.0 * lift / down), np.sqrt(2.0 * lift * down)
    up = v * (cos(LEFT + RIGHT) - mu_right * sin(LEFT + RIGHT))
    tops = hits + up / (G * (sin(RIGHT) + mu_right * cos(RIGHT)))
    assert events(motion)[:2] == [
        ("plate/right", Mode.FLIGHT, Mode.SLIP_FORWARD), ("plate/track", Mode.SLIP_FORWARD, Mode.FLIGHT)
    ]  # fmt: skip
    times = [t.time for t in motion.transitions[:3]]
    assert times == pytest.approx([hits, hits, tops], abs=1e-12)
