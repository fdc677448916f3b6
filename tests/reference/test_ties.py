"""Thresholds that are met exactly: the motion is the limit that both sides share, whatever the roundings are."""

from math import cos, sin, sqrt

import numpy as np
import pytest

import reference
from cases import (
    Belt,
    Case,
    CoulombFriction,
    Curve,
    Flight,
    Gravity,
    Impact,
    Load,
    Mode,
    Plate,
    Start,
    StartPose,
    Support,
    Unilateral,
    disc,
)
from cases.library import line
from tests.scenes import second as second_states
from tests.scenes.planted_motions import nearly_lifted
from tests.scenes.ties import KINDS, tie

G = 9.81
METHODS = pytest.mark.parametrize("method", reference.METHODS)
BOUNCE = Gravity(G), Unilateral(), Flight(), Impact(0.0)
CUBE = Plate.rectangle(0.1, 0.1, 1.0)


@METHODS
def test_pushed_cube_of_mu_one_slides_flat(method):
    """By 12 N: its acceleration is 12 - g, and all of its weight is on the leading corner."""
    case = Case(line(), CUBE, (*BOUNCE, CoulombFriction(1.0), Load(fx="12")), Start(0.0, xi2=0.05), 1.0)
    motion = reference.simulate(case, rtol=1e-12, method=method)
    assert (motion.status, motion.transitions) == ("completed", ())
    assert motion.x[-1] - motion.x[0] == pytest.approx(0.5 * (12.0 - G), abs=1e-13)
    normals = sorted(float(columns.normal_force[-1]) for columns in motion.contacts.values())
    assert normals == pytest.approx([0.0, G], abs=1e-12)
    np.testing.assert_allclose(motion.theta, motion.theta[0], atol=1e-14)


@METHODS
def test_thrown_cube_of_mu_one_slides_flat_to_rest(method):
    case = Case(line(), CUBE, (*BOUNCE, CoulombFriction(1.0)), Start(0.0, xi2=0.05, slip=1.0), 1.0)
    motion = reference.simulate(case, rtol=1e-12, method=method)
    assert motion.status == "completed"
    assert [change.time for change in motion.transitions] == pytest.approx([1.0 / G] * 2, abs=1e-14)


@METHODS
def test_a_plate_without_friction_lifts_off_where_its_load_is_its_weight(method):
    """g (1 + 1e-9) − 100 (t − 1/2)² = g at t = 1/2 − √(1e-11 g); it once ended as Painlevé's paradox."""
    case = nearly_lifted(1e-9)
    motion = reference.simulate(case, rtol=1e-12, method=method)
    assert motion.status == "lift_off" and reference.check(case, motion, 1e-12) == ()
    assert motion.t[-1] == pytest.approx(0.5 - sqrt(1e-11 * G), abs=1e-11)


@METHODS
def test_disc_that_rolls_into_a_wall_goes_up_it(method):
    """It rolls from v₀/(3 μ g) on; at the wall friction lifts it by 2 μ v₀/3, and it lands after that, over g/2."""
    wall = Support(Curve(lambda s: (0.8, s)), "wall")
    case = Case(line(), disc(0.1, 1.0), (*BOUNCE, CoulombFriction(0.2)), Start(0.0, slip=2.0), 1.0, supports=(wall,))
    motion = reference.simulate(case, rtol=1e-12, method=method)
    rolls = 2.0 / (3.0 * 0.2 * G)
    hits = rolls + (0.7 - 2.0 * rolls + 0.5 * 0.2 * G * rolls**2) / (4.0 / 3.0)
    lands = hits + 2.0 * 0.2 * (4.0 / 3.0) / G
    assert motion.status == "completed" and reference.check(case, motion, 1e-12) == ()
    track = [(change.after, change.time) for change in motion.of("plate/track").transitions][:3]
    assert [mode for mode, _ in track] == [Mode.ROLL, Mode.FLIGHT, Mode.SLIP_BACKWARD]
    assert [time for _, time in track] == pytest.approx([rolls, hits, lands], abs=1e-13)


# Flank angles, their coefficients of friction, the speed of the first flank's belt and when it turns back (s).
GROOVES = [
    (0.8, 0.8, 0.3, 0.1, "cos(5*t)", (np.pi / 10, 3 * np.pi / 10)),
    (0.5, 0.7063807239032265, 0.3, 0.3, "cos(5*t)", (np.pi / 10, 3 * np.pi / 10)),
    (0.5, 0.5, 0.1, 0.1, "sin(6*t)", (np.pi / 6,)),
    (0.6, 0.9927917158950521, 0.2, 0.3, "0.3*sin(4*t)", (np.pi / 4,)),
    (0.6, 0.6, 0.3, 0.3, "0.5 - t", (0.5,)),
]


@METHODS
@pytest.mark.parametrize("groove", GROOVES, ids=str)
def test_belt_that_turns_back_under_a_disc_in_a_groove(groove, method):
    """The disc keeps its place, and its slip changes sign at the belt's own zeros."""
    first, second, mu, other, speed, turns = groove
    x, y = np.linalg.solve([[sin(first), cos(first)], [-sin(second), cos(second)]], [0.1, 0.1]).tolist()
    flank = Support(line(-second), "flank", (CoulombFriction(other),))
    effects = (*BOUNCE, CoulombFriction(mu), Belt(speed))
    case = Case(line(first), disc(0.1, 1.0), effects, StartPose(x, y), 1.0, supports=(flank,))
    motion = reference.simulate(case, rtol=1e-12, method=method)
    assert motion.status == "completed"
    assert abs(motion.x[-1] - x) + abs(motion.y[-1] - y) < 1e-13
    times = np.array([change.time for change in motion.transitions])
    assert all(np.abs(times - turn).min() < 1e-12 for turn in turns)


def check(seed: int, method: str = "dop853") -> None:
    """A random tie ends where it should; its changes of mode have their times, and others last for nothing."""
    case, moved, changes = tie(seed)
    motion = reference.simulate(case, rtol=1e-12, method=method)
    assert motion.status == "completed", (seed, motion)
    distance = motion.x[-1] - motion.x[0] - moved[0], motion.y[-1] - motion.y[0] - moved[1]
    assert max(map(abs, distance)) <= 1e-9, seed
    times = np.array([change.time for change in motion.transitions])
    # The square root of rounding: a force of 1e-15 that grows with the square of time.
    assert all(np.abs(times - change).min() <= 1e-7 for change in changes), seed


# A load of exactly the weight, at all times, of a smooth plate without corners: its force is a rounding, and both
# formulations opened and closed the contact for ever where that is negative.
FLOATING = (49, 60, 82, 126, 203)


@pytest.mark.parametrize("seed", FLOATING)
def test_a_plate_under_a_load_of_its_weight_stays_on_its_track(seed):
    """Also in the second formulation and by the paper's matrix, without a change of mode."""
    motion = second_states.motion(tie(seed).case, 1e-12)
    assert (motion.status, motion.transitions) == ("completed", ())
    for method in (None, "augmented"):
        motion = reference.simulate(tie(seed).case, rtol=1e-12, method=method)
        assert motion.status == "completed" and not motion.transitions


@pytest.mark.parametrize("method", reference.METHODS)
def test_a_plate_that_floats_on_its_track_leaves_where_its_lift_grows(method):
    """Its lift is more than the weight by 1 + tanh u, u = 40 (t − 1/2), which is a rounding first. The integral of that
    is log(1 + exp 2u)/40, and the height (2u² + π²/6)/3200 at the end, where exp(−2u) has vanished."""
    load = Load(fy="9.81 + (1 + tanh(40*(t - 0.5)))")
    motion = reference.simulate(Case(line(), disc(0.1, 1.0), (*BOUNCE, load), Start(0.0), 1.0), method=method)
    assert [change.after for change in motion.transitions] == [Mode.FLIGHT]
    assert motion.y[-1] == pytest.approx(0.1 + (800.0 + np.pi**2 / 6.0) / 3200.0, abs=1e-9)


@pytest.mark.parametrize("seed", (*range(len(KINDS)), *FLOATING))
def test_random_ties(seed):
    check(seed)
