"""Poses at supports, their pairs, and what is rejected in one sentence."""

from math import cos, pi, sin

import pytest

import adapters
import cases
import reference
from adapters import lookup
from cases import (
    BadValue,
    Case,
    CoulombFriction,
    Curve,
    DoesNotFit,
    Gravity,
    Impact,
    PerfectlyRough,
    Plate,
    StartPose,
    Support,
    disc,
)  # fmt: skip
from cases.contact import start_motion
from cases.library import ellipse, line
from cases.scene.contact_pairs import pairs
from tests.scenes.supports import INELASTIC, G


def test_a_pose_is_the_start_of_the_nearest_point():
    case = Case(line(0.2), disc(0.5, 1.0), INELASTIC, StartPose(0.1, 0.9, 0.3, 1.0, -0.5, 2.0), 1.0)
    begin = start_motion(case)
    assert (begin.x, begin.y, begin.vx, begin.vy, begin.omega) == pytest.approx((0.1, 0.9, 1.0, -0.5, 2.0), abs=1e-14)
    assert begin.theta == pytest.approx(0.3, abs=1e-14) and case.start.gap > 0.0
    touching = Case(line(0.2), disc(0.5, 1.0), INELASTIC, StartPose(0.5 * sin(0.2), 0.5 * cos(0.2)), 1.0)
    assert touching.start.gap == 0.0 and touching.start.xi1 == pytest.approx(0.0, abs=1e-15)
    with pytest.raises(DoesNotFit, match="overlaps its track"):
        Case(line(), disc(0.5, 1.0), INELASTIC, StartPose(0.0, 0.4), 1.0)


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


def test_pairs_are_the_supports_and_the_corners_in_order():
    case = cases.load("ladder_at_wall")
    assert [pair.support for pair in pairs(case)] == ["track"] * 4 + ["wall"] * 4
    assert all(pair.has_unique_points for pair in pairs(case))
    gaps = [pair.gap(3.0, 4.0, 0.0) for pair in pairs(case)]
    assert sorted(gaps) == pytest.approx([2.0, 2.0, 3.98, 3.98, 4.0, 4.0, 4.0, 4.0], abs=1e-14)


DISC, ROD = disc(0.5, 1.0), Plate.rectangle(1.0, 0.2, 1.0)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Support(line(), "track"), 'give a word such as "wall"'),
        (lambda: Support(3, "wall"), "give a Curve"),
        (lambda: Support(line(), "wall", (Gravity(9.81),)), "is no effect of one Support"),
        (lambda: Support(line(), "wall", 0.3), "give a tuple"),
        (lambda: _with(supports=line()), "give a tuple such as"),
        (lambda: _with(supports=(line(),)), 'give Support(curve, "name")'),
        (lambda: _with(supports=(Support(line(0.5), "a"), Support(line(0.4), "a"))), "give each its own"),
        (lambda: _with((Gravity(G),), supports=(Support(line(0.5), "a"),)), "add Unilateral"),
        (lambda: _with(supports=(Support(line(0.5), "a", (Impact(0.1, "newton"),)),)), "with the same law"),
        (lambda: _with(supports=(Support(line(0.5), "a", (CoulombFriction(1e5),)),)), "is 100000; give at most 10000"),
        (lambda: _with(supports=(Support(line(0.5), "a"),)), "overlaps support 'a'"),
        (lambda: _with(supports=(Support(Curve(lambda s: (s, s**2 + 3.0), (-2, 2)), "bowl"),)), "lies behind support"),
    ],
)
def test_what_supports_cannot_be_is_said_in_one_line(make, message):
    with pytest.raises((BadValue, DoesNotFit), match=message.replace("(", r"\(").replace(")", r"\)")) as output:
        make()
    assert "\n" not in str(output.value)


def _with(effects=INELASTIC, plate=DISC, track=None, supports=()) -> Case:
    return Case(track or line(), plate, effects, StartPose(0.0, 0.5), 1.0, supports=supports)


def test_the_method_augmented_is_rejected():
    with pytest.raises(cases.NotSupported, match="has one contact"):
        reference.simulate(cases.load("ladder_at_wall"), method="augmented")


@pytest.mark.parametrize("name", ["ladder_at_wall", "block_on_incline", "disc_spinning_in_v"])
def test_adapters_without_supports_reject_them_in_one_sentence(name):
    case, count = cases.load(name), 0
    for engine in lookup.engines():
        try:
            module = lookup.engine(engine)
        except Exception:  # not installed here
            continue
        for route in module.routes:
            if route not in getattr(module, "SUPPORTS", ()):
                reason = adapters.refusal(module, case, route)
                assert reason and reason.endswith(".") and "support" in reason
                count += 1
    assert count


def test_a_case_with_supports_travels_by_value():
    import pickle

    case = cases.load("ladder_at_wall", mu=0.1, mu_wall=0.2)
    again = pickle.loads(pickle.dumps(case))
    assert again == case and hash(again) == hash(case) and again.supports[0].name == "wall"
    motion = pickle.loads(pickle.dumps(reference.simulate(case)))
    assert motion.contact_names == ("plate/track", "plate/track 2", "plate/wall")
