"""Features with each other: exact motions of scenes in which two of them meet, and laws where no motion is known."""

from dataclasses import dataclass
from math import pi, sqrt

import numpy as np
import pytest

import reference
from cases import (
    Case,
    Chain,
    ContactEffect,
    ContactForce,
    CoulombFriction,
    Curve,
    DoesNotFit,
    Drive,
    EndCondition,
    Flight,
    FreePlate,
    Gravity,
    Impact,
    Load,
    Mode,
    Outline,
    Pair,
    Plate,
    RollingResistance,
    Start,
    StartPose,
    Support,
    Unilateral,
    disc,
)
from cases import curves as c
from cases.curves.corner import Edge
from cases.library import circle, line

G = 9.81
INELASTIC = Gravity(G), Unilateral(), Flight(), Impact(0.0, "moreau")
METHOD = pytest.mark.parametrize("method", reference.METHODS)
BOX = Plate.rectangle(0.2, 0.1, 1.0)


def hill(radius: float, x: float, y: float) -> Curve:
    """The outside of a circle."""
    return Curve(lambda s: (x + radius * c.sin(s), y + radius * c.cos(s)))


# --- exact motions ----------------------------------------------------------------------------------------------------


@METHOD
@pytest.mark.parametrize("support", [False, True])
def test_a_box_over_seams_in_line_keeps_its_speed(support, method):
    """It slows down by μ g alone: x = v t − μ g t²/2."""
    tiles = Chain.polyline([(-1.0, 0.0), (0.3, 0.0), (0.5, 0.0), (0.9, 0.0), (3.0, 0.0)])
    track, supports = (line(0.0), (Support(tiles, "tiles"),)) if support else (tiles, ())
    if support:
        track = Curve(lambda s: (s, -2.0 + 0.0 * s))
    effects = (*INELASTIC, CoulombFriction(0.3))
    case = Case(track, BOX, effects, StartPose(0.0, 0.05, vx=2.0), 0.5, supports=supports)
    motion = reference.simulate(case, method=method)
    assert motion.status == "completed" and not motion.transitions
    assert motion.x[-1] == pytest.approx(2.0 * 0.5 - 0.3 * G / 8.0, abs=1e-12)


@METHOD
def test_a_block_slips_on_a_table_that_tilts_from_the_start(method):
    """On y = 0 of a table that turns about the origin with w, the block at x = 0.5 slips where friction no longer
    carries g sin wt + 0.5 w² = 0.3 (g cos wt − 0.1 w²)."""
    effects = (*INELASTIC, CoulombFriction(0.3), Drive(angle="-0.2*t"))
    case = Case(line(), Plate.rectangle(0.2, 0.2, 1.0), effects, StartPose(0.5, 0.1, 0.0, 0.02, -0.1, -0.2), 2.0)
    motion = reference.simulate(case, method=method)
    assert [change.after for change in motion.transitions[:2]] == [Mode.SLIP_FORWARD] * 2
    assert motion.transitions[0].time == pytest.approx(1.446934363956, abs=1e-10)


@METHOD
def test_the_upper_of_two_boxes_slips_where_the_lower_one_is_pushed_too_hard(method):
    """A force k t at the lower one of 2 kg: both slide where k t > μ (m₁ + m₂) g, and the upper one stays behind where
    their acceleration k t/(m₁ + m₂) − μ g exceeds μ g."""
    mu, rate, mass = 0.3, 10.0, 3.0
    upper = FreePlate(Plate.rectangle(0.2, 0.2, 1.0), StartPose(0.0, 0.3), "upper")
    effects = (*INELASTIC, CoulombFriction(mu), Load(fx=f"{rate}*t"))
    case = Case(line(), Plate.rectangle(0.8, 0.2, 2.0), effects, StartPose(0.0, 0.1), 2.0, others=(upper,))
    motion = reference.simulate(case, rtol=1e-12, method=method)
    slides, slips = (
        next(t.time for t in motion.transitions if name in t.contact and t.after is not Mode.ROLL)
        for name in ("plate/track", "upper")
    )
    assert slides == pytest.approx(mu * mass * G / rate, abs=1e-10)
    assert slips == pytest.approx(2.0 * mu * mass * G / rate, abs=1e-10)
    assert not reference.check(case, motion)


@METHOD
@pytest.mark.parametrize("height", [0.02, 0.05])
def test_a_disc_rolls_into_a_curb(height, method):
    """It turns about the edge without slip or rebound: of the angular momentum about it, ω⁺/ω = 1 − 2 h/(3 r)."""
    r, speed = 0.3, 1.0
    track = Chain.polyline([(-3.0, 0.0), (0.0, 0.0), (0.0, height), (3.0, height)])
    start = StartPose(-0.6, r, vx=speed, omega=-speed / r)
    case = Case(track, disc(r, 1.0), (*INELASTIC, CoulombFriction(2.0)), start, 1.0)
    motion = reference.simulate(case, method=method)
    time = (0.6 - sqrt(2.0 * r * height - height**2)) / speed
    assert motion.transitions[0].time == pytest.approx(time, abs=1e-11)
    after = motion(np.nextafter(motion.transitions[0].time, 2.0)).omega
    assert after == pytest.approx(-speed / r * (1.0 - 2.0 * height / (3.0 * r)), rel=1e-12)


@METHOD
def test_the_upper_of_two_boxes_on_an_accelerated_table_slips_by_the_friction_of_its_pair(method):
    """The table's acceleration 6 t exceeds μ₁ g, by which the upper box is held; the lower one stays on the table."""
    upper = FreePlate(BOX, StartPose(0.0, 0.15), "upper")
    effects, own = (*INELASTIC, CoulombFriction(0.6), Drive(x="t**3")), Pair("plate/upper", (CoulombFriction(0.2),))
    lower = Plate.rectangle(0.8, 0.1, 2.0)
    case = Case(line(), lower, effects, StartPose(0.0, 0.05), 0.5, others=(upper,), pairs=(own,))
    motion = reference.simulate(case, method=method)
    assert all(change.contact.startswith("plate/upper") for change in motion.transitions)
    assert motion.transitions[0].time == pytest.approx(0.2 * G / 6.0, abs=1e-11)
    assert motion.plate("plate")(0.5).x == pytest.approx(0.125, abs=1e-12)
    begin = 0.2 * G / 6.0
    speed = 3.0 * begin**2 + 0.2 * G * (0.5 - begin)
    assert motion.plate("upper")(0.5).vx == pytest.approx(speed, abs=1e-11)
    assert not reference.check(case, motion)


@METHOD
def test_a_disc_with_rolling_resistance_pushes_the_plank_on_which_it_rolls(method):
    """On a floor without friction. The friction T of the disc (mass m, radius r) obeys T (1/m + 1/M + 2/m) =
    −2 g arm/r, by the equal rates of both points that touch."""
    r, arm, mass, speed = 0.1, 0.004, 3.0, 1.2
    ball = FreePlate(disc(r, 1.0), StartPose(-0.5, 0.1 + r, vx=speed, omega=-speed / r), "disc")
    pairs = Pair("disc/plate", (CoulombFriction(0.6), RollingResistance(arm))), Pair("plate/track", ())
    plank = Plate.rectangle(4.0, 0.1, mass)
    case = Case(
        line(), plank, (*INELASTIC, CoulombFriction(0.6)), StartPose(0.0, 0.05), 1.0, others=(ball,), pairs=pairs
    )
    motion = reference.simulate(case, method=method)
    force = -2.0 * G * arm / r / (1.0 + 1.0 / mass + 2.0)
    assert motion.status == "completed" and not motion.transitions
    assert motion.plate("disc")(1.0).vx == pytest.approx(speed + force, abs=1e-12)
    assert motion(1.0).vx == pytest.approx(-force / mass, abs=1e-12)
    assert not reference.check(case, motion)


@METHOD
@pytest.mark.parametrize("arm", [0.0, 0.02])
def test_a_box_tips_where_its_weight_exceeds_the_couple_of_rolling_resistance(arm, method):
    """On an incline: h/2 tan a > w/2 + arm."""
    effects = CoulombFriction(2.0), *((RollingResistance(arm),) if arm else ())
    for off, count in ((-1e-6, 0), (1e-6, 1)):
        slope = np.arctan((0.1 + arm) / 0.2) + off
        load = Gravity(G, direction=-pi / 2 - slope)
        case = Case(line(), Plate.rectangle(0.2, 0.4, 1.0), (load, *INELASTIC[1:], *effects), StartPose(0.0, 0.2), 0.1)
        motion = reference.simulate(case, method=method)
        assert (abs(motion.theta[-1]) > 1e-9) == bool(count) and not reference.check(case, motion)


@METHOD
@pytest.mark.parametrize("law", ["poisson", "newton", "moreau"])
def test_an_impact_has_the_friction_of_the_slip_speed_before_it(law, method):
    """Twice: a disc (r = 0.1) slows down by μ(v) (1 + e) times its closing speed, and its slip three times as much."""
    e, speed, mu = 0.5, 2.0, lambda v: 0.1 + 0.2 * np.exp(-v / 0.5)
    effects = Gravity(G), Unilateral(), Flight(), CoulombFriction("0.1 + 0.2*exp(-v/0.5)"), Impact(e, law)
    case = Case(line(), disc(0.1, 1.0), effects, Start(0.0, slip=speed, gap=0.3), 0.6)
    motion = reference.simulate(case, method=method)
    closing = sqrt(2.0 * G * 0.3)
    first = mu(speed) * (1.0 + e) * closing
    second = mu(speed - 3.0 * first) * (1.0 + e) * e * closing
    assert motion(0.3).vx == pytest.approx(speed - first, abs=1e-13)
    assert motion(0.55).vx == pytest.approx(speed - first - second, abs=1e-13)
    assert not reference.check(case, motion)


def test_plates_without_an_impact_run_until_they_meet():
    ball = FreePlate(disc(0.1, 0.5), StartPose(0.0, 0.7), "ball")
    effects = Gravity(G), Unilateral(), Flight(), CoulombFriction(0.4)
    case = Case(line(), Plate.rectangle(0.4, 0.2, 1.0), effects, StartPose(0.0, 0.1), 1.0, others=(ball,))
    motion = reference.simulate(case)
    assert motion.status == "landing" and "The plate 'ball' meets the plate 'plate'" in motion.reason
    assert motion.t[-1] == pytest.approx(sqrt(0.8 / G), abs=1e-12)


@dataclass(frozen=True)
class Grease(ContactEffect):
    """A force against the slip, `drag` times as large (N s/m), at each contact."""

    drag: float

    def force(self) -> ContactForce:
        return ContactForce(along=f"-{self.drag!r}*slip")


@dataclass(frozen=True)
class Magnet(ContactEffect):
    """A force towards the track (N), and an end where the slip exceeds a speed (m/s)."""

    pull: float
    fastest: float = 10.0

    def force(self) -> ContactForce:
        return ContactForce(across=-self.pull)

    def ends(self) -> tuple[EndCondition, ...]:
        return (EndCondition("too_fast", f"{self.fastest**2!r} - slip**2", "It flew off."),)


@METHOD
def test_an_effect_of_a_package_acts_at_each_contact(method):
    """At both corners of a box: v = exp(−2 d t/m)."""
    drag, mass = 1.5, 2.0
    case = Case(
        line(), Plate.rectangle(0.4, 0.01, mass), (*INELASTIC, Grease(drag)), StartPose(0.0, 0.005, vx=1.0), 1.0
    )
    motion = reference.simulate(case, method=method)
    assert motion(1.0).vx == pytest.approx(np.exp(-2.0 * drag / mass), abs=1e-10)
    assert not reference.check(case, motion)


@METHOD
def test_a_magnet_between_two_plates_pulls_both(method):
    """A disc that slides on a plank at rest rolls after v/(3 μ (g + F/m)), and the condition of its effect ends it."""
    ball = FreePlate(disc(0.1, 1.0), StartPose(0.0, 0.2, vx=1.0), "disc")
    for fastest, status in ((10.0, "completed"), (0.5, "too_fast")):
        effects = (*INELASTIC, CoulombFriction(0.3), Magnet(2.0, fastest))
        case = Case(line(), Plate.rectangle(4.0, 0.1, 3.0), effects, StartPose(0.0, 0.05), 0.5, others=(ball,))
        motion = reference.simulate(case, method=method)
        assert motion.status == status
        if status == "completed":
            assert motion.transitions[0].time == pytest.approx(1.0 / (0.9 * (G + 2.0)), abs=1e-12)
            assert not reference.check(case, motion)


# --- laws -------------------------------------------------------------------------------------------------------------

HALF_ELLIPSE = Plate.homogeneous(
    Outline((Curve(lambda s: (0.5 * c.cos(s), 0.3 * c.sin(s)), (-pi, 0)), Edge.between((0.5, 0), (-0.5, 0)))), 1.0
)
CAPSULE, HALF_DISC = Plate.rectangle(0.6, 0.4, 1.0, radius=0.1), Plate.half_disc(0.4, 1.0)
STEPS = Chain.polyline([(-3.0, 0.0), (0.0, 0.0), (0.0, -0.4), (5.0, -0.4)])
WAVE = Curve(lambda s: (s, 0.1 * c.cos(2.0 * s) - 0.1), (-6, 6))
RUBS = (*INELASTIC, CoulombFriction(0.3))
SCENES = {
    "box down a step": Case(STEPS, Plate.rectangle(0.2, 0.2, 1.0), RUBS, StartPose(-0.6, 0.1, vx=3.0), 1.5),
    "half ellipse on a line": Case(line(), HALF_ELLIPSE, RUBS, StartPose(0.0, 0.5, 3.0), 1.0),
    "half disc in a bowl": Case(circle(3.0), HALF_DISC, RUBS, StartPose(0.0, -2.0), 1.0),
    "capsule on a wave": Case(WAVE, CAPSULE, RUBS, StartPose(0.0, 0.5), 1.0),
    "capsule on a hill in a bowl": Case(
        circle(3.0), CAPSULE, RUBS, StartPose(0.0, -1.0), 1.0, supports=(Support(hill(0.3, -2.0, -2.0), "hill"),)
    ),
    "dominoes": Case(
        line(), Plate.rectangle(0.02, 0.2, 1.0), RUBS, StartPose(0.0, 0.1, omega=-1.5), 0.6,
        others=(FreePlate(Plate.rectangle(0.02, 0.2, 1.0), StartPose(0.1, 0.1), "second"),),
    ),
    "disc and half disc on a wave": Case(
        WAVE, disc(0.1, 1.0), RUBS, StartPose(0.5, 0.3), 1.0,
        others=(FreePlate(HALF_DISC, StartPose(1.8, 0.8), "second"),),
    ),
    "wheel in a moving bowl with a load": Case(
        circle(1.0), disc(0.1, 1.0), (*RUBS, Drive(x="0.1*sin(5*t)"), Load(fx="0.5*sin(3*t)")), Start(-pi / 2, 0.0), 1.0
    ),
}  # fmt: skip


@pytest.mark.parametrize("at", [(0.5, 0.3, 0.0), (0.52, 0.31, 1.0), (0.5, 0.58, 0.0)])
def test_plates_of_any_shape_that_overlap_where_they_begin_are_rejected(at):
    """A disc inside a half disc, the other way round, and a half disc that another one enters."""
    for plate in (disc(0.05, 1.0), HALF_DISC):
        with pytest.raises(DoesNotFit, match="overlap where they begin"):
            other = FreePlate(plate, StartPose(*at), "second")
            Case(WAVE, HALF_DISC, RUBS, StartPose(0.5, 0.4), 1.0, others=(other,))


@pytest.mark.parametrize("name", SCENES)
def test_scenes_of_several_features_run_and_obey_the_laws(name):
    motion = reference.simulate(SCENES[name], method="dop853")
    assert motion.status == "completed"
    assert not reference.check(SCENES[name], motion)
