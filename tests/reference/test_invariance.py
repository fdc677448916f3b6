"""The same scene in other units, another direction, another parametrisation, and its mirror image."""

from dataclasses import replace
from math import cos, pi, sin, sqrt

import numpy as np
import pytest
import sympy as sp
from hypothesis import given

import cases
import reference
from cases import Case, CoulombFriction, Curve, Gravity, Mode, Plate, Start, Unilateral, disc
from cases import curves as c
from cases.formulas.expressions import PARAMETER
from reference.minimal.integrators import taylor
from tests.scenes.elliptic import elliptic_scenes, examples, numbers

pytestmark = pytest.mark.taylor

OTHER_HAND = {Mode.SLIP_FORWARD: Mode.SLIP_BACKWARD, Mode.SLIP_BACKWARD: Mode.SLIP_FORWARD}


def scene(
    length=1.0, mass=1.0, turn=0.0, mu=0.2, parameter=lambda s: s, unparameter=lambda s: s, g=None, duration=2.0
) -> Case:
    """A disc let go inside an ellipse, in other units and orientations; lengths in `length` metres."""
    A, B = 1.3 * length, 0.9 * length
    g = 9.81 * length if g is None else g  # times stay the same

    def track(s):
        s = parameter(s)
        x, y = A * c.cos(s), B * c.sin(s)
        return (cos(turn) * x - sin(turn) * y, sin(turn) * x + cos(turn) * y)

    effects = (Gravity(g, turn - pi / 2), CoulombFriction(mu), Unilateral())
    return Case(Curve(track), disc(0.1 * length, mass), effects, Start(unparameter(-0.5)), duration)


def times(case: Case, method: str | None = None):
    motion = reference.simulate(case, rtol=1e-13, method=method)
    return np.array([t.time for t in motion.transitions]), [t.after for t in motion.transitions], motion


@pytest.mark.sampled(5)
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


@given(length=numbers(1e-3, 1e3), pull=numbers(1e-3, 1e3))
@examples(4, 10)
def test_times_scale_with_the_root_of_length_over_gravity(length, pull):
    ours, modes, motion = times(scene())
    unit = sqrt(length / pull)
    theirs, other_modes, other = times(scene(length=length, g=9.81 * pull, duration=2.0 * unit))
    assert modes == other_modes
    assert theirs / unit == pytest.approx(ours, rel=1e-12)
    t = np.linspace(0.0, 1.999, 20)  # the two ends differ by a rounding
    assert other(t * unit).x / length == pytest.approx(motion(t).x, abs=1e-11)
    assert other(t * unit).omega * unit == pytest.approx(motion(t).omega, abs=1e-9)


@pytest.mark.parametrize("length", [1e3, 1e-3], ids=["millimetres", "kilometres"])
def test_the_papers_scene_in_other_units_has_the_same_digits(length):
    """Lengths are divided by the unit, speeds and accelerations with them; seconds and kilograms stay."""
    si = cases.load("disc_in_circle", mu=0.2)
    gravity = si.effect(Gravity)

    def told_in(curve: Curve) -> Curve:
        x, y = curve.expression
        return Curve(lambda s: (length * x.subs(PARAMETER, s), length * y.subs(PARAMETER, s)))

    plate = Plate(told_in(si.plate.outline), si.plate.mass, si.plate.inertia * length**2)
    effects = (Gravity(gravity.g * length, gravity.direction), *si.effects[1:])
    start = replace(si.start, slip=si.start.slip * length)
    ours, modes, motion = times(si)
    theirs, other_modes, other = times(Case(told_in(si.track), plate, effects, start, si.duration))
    assert modes == other_modes
    assert len(ours) == 4
    assert theirs == pytest.approx(ours, rel=1e-12)
    t = np.linspace(0.0, si.duration, 50)
    for quantity, unit in (("x", length), ("y", length), ("theta", 1.0)):
        expected = getattr(motion(t), quantity)
        found = getattr(other(t), quantity) / unit
        assert found == pytest.approx(expected, abs=1e-12 * np.abs(expected).max())


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
@examples(1, 4)
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


@pytest.mark.slow  # the catalogue's warped circle has both of its parameters changed in the quick tests
def test_another_parametrisation_of_the_outline_changes_nothing():
    def rolling(outline: Curve) -> Case:
        plate = Plate(outline, 1.0, 0.02)
        effects = (Gravity(9.81), CoulombFriction(0.2), Unilateral())
        return Case(scene().track, plate, effects, Start(-0.5), 2.0)

    def warped(s):
        return s + 0.3 * c.sin(2 * s)

    ours, modes, motion = times(rolling(Curve(lambda s: (0.2 * c.cos(s), 0.15 * c.sin(s)))))
    other = rolling(Curve(lambda s: (0.2 * c.cos(warped(s)), 0.15 * c.sin(warped(s)))))
    theirs, other_modes, other_motion = times(other)
    assert len(ours) >= 2
    assert modes == other_modes
    assert theirs == pytest.approx(ours, rel=1e-11)
    t = np.linspace(0.0, 2.0, 20)
    assert other_motion(t).theta == pytest.approx(motion(t).theta, abs=1e-10)


@pytest.mark.parametrize("method", reference.METHODS)
def test_the_instants_asked_for_change_no_bit_of_the_motion(method):
    _, _, motion = times(scene(), method)
    few, many = np.linspace(0.0, 2.0, 9), np.linspace(0.0, 2.0, 8001)
    for quantity in ("x", "theta", "omega", "slip", "normal_force"):
        in_company = getattr(motion(many), quantity)[::1000]
        assert np.array_equal(getattr(motion(few), quantity), in_company)
        assert np.array_equal(getattr(motion(few[::-1]), quantity)[::-1], in_company)
        assert [float(getattr(motion(float(t)), quantity)) for t in few] == in_company.tolist()


@pytest.mark.parametrize("method", reference.METHODS)
def test_a_longer_motion_begins_like_a_shorter_one(method):
    ours, modes, motion = times(scene(duration=1.9), method)
    theirs, longer_modes, longer = times(scene(duration=5.0), method)
    assert longer_modes[: len(modes)] == modes
    assert theirs[: len(ours)] == pytest.approx(ours, rel=1e-11)
    t = np.linspace(0.0, 1.9, 50)
    assert longer(t).x == pytest.approx(motion(t).x, abs=1e-10)


@given(elliptic_scenes)
@examples(1, 10)
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


@pytest.mark.skipif(not taylor.AVAILABLE, reason="heyoka is not installed")
def test_a_motion_is_the_same_to_its_last_bit_whatever_was_compiled_before(monkeypatch):
    case = cases.select("ellipse_on_line[mu=1]")[0]
    times, found = np.linspace(0.0, case.duration, 50), []
    for count in (99_900, *range(99_990, 100_000)):  # SymPy names its own symbols by a count, and sorts sums by names
        monkeypatch.setattr(sp.Dummy, "_count", count)
        taylor.integrators_of.cache_clear()
        found.append(np.array(reference.simulate(case, rtol=1e-11, method="taylor")(times)[:3]).tobytes())
    assert len(set(found)) == 1
