"""A driven track with corners, or with several contacts: exact motions, inertial loads, and two formulations."""

from math import asin, cos, pi, tan

import numpy as np
import pytest
from scipy.optimize import brentq

from cases import (
    BadValue,
    Case,
    Chain,
    CoulombFriction,
    Curve,
    Drive,
    Flight,
    Gravity,
    Impact,
    PerfectlyRough,
    Plate,
    Start,
    StartPose,
    Support,
    Unilateral,
    disc,
)
from cases.library import line
from reports.judging.residuals import energy_residual
from tests.sampling import quick_every
from tests.scenes.agreement import agree

from .test_belts_and_supports import METHODS, motion_by

G = 9.81
EFFECTS = Gravity(G), Unilateral(), Flight(), Impact(0.0, "moreau")
# Where a rest ends, the second formulation notices accelerations of 1e-12 of their terms: of a g that grows by some
# 10 g in a second, this is 1e-12 s.
END_OF_REST = 5e-12


def box(width: float, height: float, mu: float, *more, duration: float = 1.0) -> Case:
    """A box of 1 kg on its flat side."""
    effects = (*EFFECTS, CoulombFriction(mu), *more)
    return Case(line(), Plate.rectangle(width, height, 1.0), effects, Start(0.0, xi2=0.5 * width), duration)


@quick_every(2)
@METHODS
def test_a_box_slips_where_the_table_s_acceleration_exceeds_friction(method):
    amplitude, rate, mu = 0.05, 9.0, 0.2
    motion = motion_by(box(0.4, 0.2, mu, Drive(x=f"{amplitude}*sin({rate}*t)"), duration=0.7), method)
    begin = asin(mu * G / (amplitude * rate**2)) / rate

    def slip(t: float) -> float:  # the box slows down by mu g, the table as it is driven
        return amplitude * rate * (cos(rate * begin) - cos(rate * t)) - mu * G * (t - begin)

    end = brentq(slip, begin + 0.1, 0.6, xtol=1e-15)
    times = [event.time for event in motion.transitions]
    assert times[:2] == pytest.approx([begin, begin], abs=END_OF_REST)
    assert times[2:] == pytest.approx([end, end], abs=END_OF_REST)


@quick_every(2)
@METHODS
def test_a_slender_box_tips_where_the_table_s_acceleration_exceeds_its_slenderness(method):
    amplitude, rate, width, height = 4.0 / 144.0, 12.0, 0.1, 0.4
    motion = motion_by(box(width, height, 0.9, Drive(x=f"{amplitude}*sin({rate}*t)"), duration=0.2), method)
    tips = asin(G * width / (height * amplitude * rate**2)) / rate
    assert motion.transitions[0].time == pytest.approx(tips, abs=END_OF_REST)
    # The corner ahead of the acceleration leaves the table.
    assert [str(event.after) for event in motion.transitions] == ["flight"]
    assert motion.transitions[0].contact == "plate/track 2"


def shaken(seed: int) -> Case:
    """A box, a triangle, or a disc in a valley, on a track that is shaken and tilted to and fro."""
    random = np.random.default_rng(seed)
    amplitudes, rates = random.uniform(0.01, 0.05, 3) * [1, 0.5, 5], random.uniform(4.0, 12.0, 3)
    drive = Drive(*(f"{a:.4f}*sin({w:.3f}*t)" for a, w in zip(amplitudes, rates, strict=True)))
    friction, kind = CoulombFriction(round(random.uniform(0.1, 0.9), 3)), seed % 3
    track: Curve = line(round(random.uniform(-0.2, 0.2), 3))
    if kind == 0:
        plate = Plate.rectangle(*random.uniform(0.1, 0.4, 2).round(3).tolist(), 1.0)
        start = Start(0.0, xi2=0.5 * plate.outline.vertices(0.1)[1], slip=round(random.uniform(-1.0, 1.0), 3))
    elif kind == 1:
        plate, start = Plate.polygon([(-0.2, -0.1), (0.2, -0.1), (0.1, 0.2)], 1.0), StartPose(0.0, 0.5, 0.3)
    else:
        track, plate, start = Curve(("s", "4*s**2"), (-2, 2)), disc(0.3, 1.0), StartPose(0.02, 0.75)
    return Case(track, plate, (*EFFECTS, friction, drive), start, 0.6)


@quick_every(2, first=1)
@pytest.mark.parametrize(
    ("friction", "omega"), [(CoulombFriction(0.4), -8.0), (PerfectlyRough(), -4.0)], ids=["slips", "rolls"]
)
def test_a_disc_rolls_over_the_bends_of_a_driven_track(friction, omega):
    track, drive = Chain.polyline([(-1, 0.3), (0, 0.3), (1, 0.0)]), Drive(x="0.05*sin(9*t)", angle="0.1*sin(5*t)")
    effects = Gravity(G), Unilateral(), friction, drive
    case = Case(track, disc(0.1, 1.0), effects, Start(xi1=0.95, omega=omega), 0.6)
    motion = agree(case)
    assert motion.t[-1] > 0.2 and len(motion.passages) >= 1
    if isinstance(friction, CoulombFriction):
        assert np.abs(energy_residual(case, motion)).max() < 1e-10


def in_v(*more, mu: float = 0.3, duration: float = 0.6) -> Case:
    """A disc of 1 kg in a V of two planes of 30°, of which the right one is a support."""
    effects, right = (*EFFECTS, *((CoulombFriction(mu),) if mu else ()), *more), Support(line(-pi / 6), "right")
    start = StartPose(0.0, 0.5 / cos(pi / 6))
    return Case(line(pi / 6), disc(0.5, 1.0), effects, start, duration, supports=(right,))


@quick_every(2, first=1)
@METHODS
def test_a_disc_leaves_one_side_of_a_v_that_is_driven_too_hard(method):
    """Without friction the disc stays in a V of angle α as long as the acceleration is below g tan α."""
    case = in_v(Drive(x="2*t**3"), mu=0.0)
    first = motion_by(case, method).transitions[0]
    assert first.time == pytest.approx(G * tan(pi / 6) / 12.0, abs=END_OF_REST)
    assert first.after.value == "flight" and first.contact == "plate/right"


@METHODS
def test_a_box_begins_at_rest_on_a_table_that_turns(method):
    """It slips where g sin a = mu (g cos a − w² h): its centre is at the height h above the axis."""
    mu, w, h = 0.3, 0.3, 0.1
    effects = (*EFFECTS, CoulombFriction(mu), Drive(angle=f"{w}*t"))
    plate = Plate.rectangle(0.4, 2 * h, 1.0)
    motion = motion_by(Case(line(), plate, effects, Start(0.0, omega=w), 1.0), method)
    slips = brentq(lambda a: G * np.sin(a) - mu * (G * cos(a) - w**2 * h), 0.1, 0.5) / w
    assert [change.time for change in motion.transitions] == pytest.approx([slips] * 2, abs=1e-11)
    with pytest.raises(BadValue, match=r"turns with its track; give omega=0.3 in Start, not -0.3"):
        Case(line(), plate, effects, Start(0.0, omega=-w), 1.0)


@pytest.mark.parametrize("omega", [0.0, 0.3, 0.7])
def test_a_box_above_a_table_that_turns_falls_from_a_start_as_from_the_same_pose(omega):
    """Its gap's rate at the corner is that of the turn against the table: 0.06 m/s in excess were 6 ms."""
    effects, plate = (*EFFECTS, CoulombFriction(0.3), Drive(angle="0.3*t")), Plate.rectangle(0.4, 0.2, 1.0)
    pose = Case(line(), plate, effects, StartPose(0.0, 0.2, omega=omega), 0.3)
    start = Case(line(), plate, effects, Start(0.0, slip=pose.start.slip, omega=omega, gap=0.1), 0.3)
    assert start.start.xi1 == pytest.approx(pose.start.xi1) and start.start.gap_rate == pytest.approx(
        pose.start.gap_rate, abs=1e-15
    )
