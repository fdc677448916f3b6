"""The same scene told differently: other units, another direction, another parametrisation, another hand."""

from math import cos, pi, sin

import numpy as np
import pytest
from hypothesis import given, settings

import reference
from cases import Case, CoulombFriction, Curve, Gravity, Mode, Plate, Start, Unilateral, disc
from cases import curves as c
from cases.curves import PARAMETER
from tests.scenes import elliptic_scenes, numbers

OTHER_HAND = {Mode.SLIP_FORWARD: Mode.SLIP_BACKWARD, Mode.SLIP_BACKWARD: Mode.SLIP_FORWARD}


def scene(length=1.0, mass=1.0, turn=0.0, mu=0.2, parameter=lambda s: s, unparameter=lambda s: s) -> Case:
    """A disc let go inside an ellipse, in other units and orientations; lengths in `length` metres."""
    A, B = 1.3 * length, 0.9 * length
    g = 9.81 * length  # times stay the same

    def track(s):
        s = parameter(s)
        x, y = A * c.cos(s), B * c.sin(s)
        return (cos(turn) * x - sin(turn) * y, sin(turn) * x + cos(turn) * y)

    effects = (Gravity(g, turn - pi / 2), CoulombFriction(mu), Unilateral())
    return Case(Curve(track), disc(0.1 * length, mass), effects, Start(unparameter(-0.5)), 2.0)


def times(case: Case, method: str | None = None):
    motion = reference.simulate(case, rtol=1e-13, method=method)
    return np.array([t.time for t in motion.transitions]), [t.after for t in motion.transitions], motion


@pytest.mark.parametrize("method", reference.METHODS)
@pytest.mark.parametrize("length", [1e-6, 1e-3, 1e3])
def test_units_of_length_change_no_digit(length, method):
    ours, modes, motion = times(scene(), method)
    theirs, other_modes, other = times(scene(length=length), method)
    assert len(ours) >= 2
    assert modes == other_modes
    assert theirs == pytest.approx(ours, rel=1e-11 if method == "dop853" else 1e-12)
    t = np.linspace(0.0, 2.0, 20)
    assert other(t).x / length == pytest.approx(motion(t).x, abs=1e-10 if method == "dop853" else 1e-11)


@pytest.mark.parametrize("mass", [1e-9, 1e9])
def test_mass_drops_out(mass):
    ours, modes, motion = times(scene())
    theirs, other_modes, other = times(scene(mass=mass))
    assert modes == other_modes
    assert theirs == pytest.approx(ours, rel=1e-12)
    assert other(0.3).normal_force / mass == pytest.approx(motion(0.3).normal_force, rel=1e-11)


def test_units_of_a_line_change_no_digit():
    def bowling(length):
        effects = (Gravity(9.81 * length), CoulombFriction(0.1), Unilateral())
        return Case(Curve(lambda s: (s, 0)), disc(0.1 * length, 1.0), effects, Start(0.0, slip=length), 1.0)

    for length in (1e-6, 1.0, 1e3):
        for method in reference.METHODS:
            assert times(bowling(length), method)[0] == pytest.approx([1 / (3 * 0.1 * 9.81)], rel=1e-13)


@given(turn=numbers(-3.0, 3.0))
@settings(max_examples=4, deadline=None)
def test_turning_the_scene_with_its_gravity_changes_nothing(turn):
    ours, modes, motion = times(scene())
    theirs, other_modes, other = times(scene(turn=turn))
    assert modes == other_modes
    assert theirs == pytest.approx(ours, rel=1e-11)
    assert other(1.7).slip == pytest.approx(motion(1.7).slip, abs=1e-10)


def test_another_parametrisation_of_the_track_changes_nothing():
    ours, modes, motion = times(scene())
    # s -> 2 s + 0.3 sin(2 s) grows everywhere; its inverse at the start is found by bisection.
    low, high = -2.0, 2.0
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if 2 * middle + 0.3 * sin(2 * middle) < -0.5 else (low, middle)
    other = scene(parameter=lambda s: 2 * s + 0.3 * c.sin(2 * s), unparameter=lambda _: 0.5 * (low + high))
    theirs, other_modes, other_motion = times(other)
    assert modes == other_modes
    assert theirs == pytest.approx(ours, rel=1e-11)
    t = np.linspace(0.0, 2.0, 20)
    assert other_motion(t).x == pytest.approx(motion(t).x, abs=1e-10)


@given(elliptic_scenes)
@settings(max_examples=10, deadline=None)
def test_the_mirror_image_of_a_scene_moves_as_the_mirror_image(case):
    s = case.start
    gravity = case.effect(Gravity)

    def mirrored(curve):
        x, y = curve.expression
        return Curve(lambda p: (-x.subs(PARAMETER, -p), y.subs(PARAMETER, -p)))

    effects = (Gravity(gravity.g, pi - gravity.direction), *case.effects[1:])
    plate = Plate(mirrored(case.plate.outline), case.plate.mass, case.plate.inertia)
    start = Start(-s.xi1, -s.xi2, -s.slip, -s.omega)
    ours = reference.simulate(case, rtol=1e-12)
    theirs = reference.simulate(Case(mirrored(case.track), plate, effects, start, case.duration), rtol=1e-12)
    assert theirs.status == ours.status
    assert [OTHER_HAND.get(t.after, t.after) for t in theirs.transitions] == [t.after for t in ours.transitions]
    assert [t.time for t in theirs.transitions] == pytest.approx([t.time for t in ours.transitions], abs=1e-9)


@pytest.mark.parametrize("method", reference.METHODS)
def test_a_motion_can_be_taken_up_again_at_any_instant(method):
    case = scene()
    _, _, whole = times(case, method)
    for t in (0.2, 0.9, 1.5):
        now = whole(t)
        slip = 0.0 if abs(now.slip) < 1e-12 else now.slip
        start = Start(now.xi1, now.xi2, slip, now.omega)
        rest = Case(case.track, case.plate, case.effects, start, 2.0 - t)
        _, _, again = times(rest, method)
        later = [q.time - t for q in whole.transitions if q.time > t]
        assert [q.time for q in again.transitions] == pytest.approx(later, abs=1e-10)
        assert again(2.0 - t).x == pytest.approx(whole(2.0).x, abs=1e-9)
