"""A plate of infinite inertia with several contacts: exact forces and motions, two formulations, the paper's matrix."""

from itertools import product
from math import asin, cos, inf, pi, sin

import numpy as np
import pytest

import reference
from cases import Belt, Case, CoulombFriction, Flight, Gravity, Impact, Load, Mode, StartPose, Support, Unilateral, disc
from cases.library import line
from tests.reference.test_belts_and_supports import METHODS, motion_by
from tests.sampling import quick_every
from tests.scenes.supports import events, simulated

G, R = 9.81, 0.5
LEFT, RIGHT = 0.5, 0.3


def in_v(mu=0.0, mu_right=0.0, lift=0.0, left=LEFT, right=RIGHT, end=1.0) -> Case:
    """A plate of 1 kg in a V of two planes, at rest on both, or farther up on the left one by that length."""
    own, friction = ((CoulombFriction(value),) if value else () for value in (mu_right, mu))
    x, y = R * (cos(right) - cos(left)) / sin(left + right), R * (sin(left) + sin(right)) / sin(left + right)
    effects = (Gravity(G), Unilateral(), Flight(), Impact(0.0, "moreau"), *friction)
    start = StartPose(x - lift * cos(left), y + lift * sin(left))
    return Case(line(left), disc(R, 1.0, inf), effects, start, end, supports=(Support(line(-right), "right", own),))


def between_floor_and_wall(*effects, mu_wall=0.3, belt=(), end=1.0, start=None, e=0.5) -> Case:
    """A plate on the floor next to a wall on its left."""
    wall = Support(line(pi / 2), "wall", (CoulombFriction(mu_wall), *belt))
    every = (Gravity(G), Unilateral(), Flight(), Impact(e, "moreau"), *effects)
    return Case(line(), disc(R, 1.0, inf), every, start or StartPose(R, R), end, supports=(wall,))


def columns(motion, name: str, *times: float):
    return motion.contact_columns(f"plate/{name}", np.array(times))


# --- at rest ----------------------------------------------------------------------------------------------------------


def test_two_planes_without_friction_hold_a_plate_by_unique_forces():
    """N₁ sin α = N₂ sin β and N₁ cos α + N₂ cos β = m g."""
    motion = simulated(in_v())
    assert motion.status == "completed" and not motion.transitions
    for name, own in (("track", RIGHT), ("right", LEFT)):
        assert columns(motion, name, 0.5).normal_force == pytest.approx(G * sin(own) / sin(LEFT + RIGHT), rel=1e-12)


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


@quick_every(2, first=1)
@METHODS
def test_a_load_pulls_it_from_the_wall_where_it_exceeds_friction(method):
    """It rests while the load to the right, 8 sin 4t − 3, is below μ m g."""
    load = Load(fx="8*sin(4*t) - 3")
    motion = motion_by(between_floor_and_wall(CoulombFriction(0.2), load, end=0.4), method)
    assert events(motion) == [
        ("plate/track", Mode.ROLL, Mode.SLIP_FORWARD), ("plate/wall", Mode.ROLL, Mode.FLIGHT)
    ]  # fmt: skip
    # The second formulation notices the limit by rates of 1e-12 of the load's.
    within = 1e-11 if method == "second" else 1e-13
    assert [t.time for t in motion.transitions] == pytest.approx([asin((3.0 + 0.2 * G) / 8.0) / 4.0] * 2, abs=within)


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


# --- both formulations, the paper's matrix, and engines ---------------------------------------------------------------


def test_a_slip_vanishes_where_a_belt_turns_under_a_plate_that_is_still():
    """The rounding of this slip shows in no speed of the plate, only in the belts' speeds. By DOP853 the motion ended
    there, as `accumulation`."""
    case = between_floor_and_wall(CoulombFriction(0.1), Belt("0.48*sin(7.4*t)"), belt=(Belt(1.3),))
    motion = reference.simulate(case, rtol=1e-10, method="dop853")
    assert (motion.status, len(motion.transitions)) == ("completed", 2)
