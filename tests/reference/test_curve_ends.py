"""Plates that meet an end of an open curve: exact times, ties with contacts of the curve, starts."""

from dataclasses import replace
from math import acos, cos, pi, sin, sqrt

import pytest

import cases
import reference
from cases import (
    Case,
    Chain,
    CoulombFriction,
    Curve,
    DoesNotFit,
    Drive,
    Flight,
    FreePlate,
    Gravity,
    Impact,
    Plate,
    Start,
    StartPose,
    Support,
    Unilateral,
    disc,
    library,
)
from cases.contact import start_motion
from reference.laws_check.broken_laws import OVERLAP
from reference.witness import predict

G = 9.81
FREE = (Unilateral(), Flight(), Impact(0.5))
HEAVY = (Gravity(G), *FREE)
ROUGH = (*HEAVY, CoulombFriction(0.3))
# Roundings of times of the order of one: of the dense output that is cut, and of two formulas.
TIGHT = 1e-13
R, D = 0.1, 0.06
UP = sqrt(R * R - D * D)
DISC, BOX = disc(R, 1.0), Plate.rectangle(0.4, 0.2, 1.0)
ELLIPSE = Plate.homogeneous(library.ellipse(0.2, 0.1), 1.0)
FLOOR, TABLE = library.line(), Curve(("s", "0"), (-1.0, 0.0))

SHELF = (Support(Curve(("s", "0.5"), (-1.0, 0.0)), "shelf"),)
WALL = (Support(Curve(("0", "s"), (0.15, 0.5)), "wall"),)
# A box that leans by 0.5 rad, with the end 0.02 m below its lower side, 0.05 m from the side's middle.
LEAN, LOW = 0.5, 0.02


def leaning(gap: float) -> StartPose:
    u, v, c, s = 0.05, -0.1 - gap, cos(LEAN), sin(LEAN)
    return StartPose(-(c * u + s * v), 0.5 - (c * v - s * u), theta=-LEAN)


def case(track, plate, start, effects, duration=2.0, **more) -> Case:
    return Case(track, plate, effects, start, duration, **more)


# Cases and the exact times at which they meet an end, and whether the second formulation has them.
ROWS = {
    # The centre falls to the height √(r² − d²) above the end.
    "disc falls beside a shelf": (
        case(FLOOR, DISC, StartPose(D, 1.0), HEAVY, supports=SHELF), sqrt(2 * (0.5 - UP) / G), True,
    ),
    "one of two plates does": (
        case(
            FLOOR, DISC, StartPose(1.0, R), HEAVY, supports=SHELF,
            others=(FreePlate(DISC, StartPose(D, 1.0), "ball"),),
        ),
        sqrt(2 * (0.5 - UP) / G), False,
    ),
    "disc moves along, below the track": (
        case(FLOOR, DISC, StartPose(0.7, 0.5 - D, vx=-2.0), FREE, supports=SHELF), (0.7 - UP) / 2.0, True,
    ),
    "disc slides under a wall": (
        case(FLOOR, DISC, Start(-0.5, slip=1.0), HEAVY, supports=WALL), 0.5 - sqrt(R * R - 0.05**2), True,
    ),
    "ellipse moves against the end": (
        case(FLOOR, ELLIPSE, StartPose(0.7, 0.5 - D, vx=-2.0), FREE, supports=SHELF),
        (0.7 - 0.2 * sqrt(1 - (D / 0.1) ** 2)) / 2.0, True,
    ),
    "side of a box against the end": (
        case(FLOOR, BOX, StartPose(0.7, 0.45, vx=-2.0), FREE, supports=SHELF), 0.25, False,
    ),
    # The end sinks by gap / cos θ relative to the side.
    "leaning box falls onto the end": (
        case(FLOOR, BOX, leaning(LOW), HEAVY, supports=SHELF), sqrt(2 * LOW / cos(LEAN) / G), False,
    ),
    # In the box's frame the end goes round at 0.15 m, until it is as high as the long side.
    "box turns into the end": (
        case(FLOOR, BOX, StartPose(0.15, 0.5, theta=pi / 2, omega=3.0), FREE, supports=SHELF),
        acos(0.1 / 0.15) / 3.0, False,
    ),
    # The centre flies to the height R/2 above the end of its own track: (√3/2) R beyond it.
    "disc flies past the end of its track": (
        case(TABLE, DISC, StartPose(-0.05, 0.3, vx=(0.05 + sqrt(0.75) * R) / sqrt(0.5 / G)), HEAVY),
        sqrt(0.5 / G), True,
    ),
    "the same track in pieces": (
        case(
            Chain.polyline([(-1.0, 0.5), (-0.5, 0.0), (0.0, 0.0)]), DISC,
            StartPose(-0.05, 0.3, vx=(0.05 + sqrt(0.75) * R) / sqrt(0.5 / G)), HEAVY,
        ),
        sqrt(0.5 / G), True,
    ),
    "the end moves to the disc": (
        case(FLOOR, DISC, StartPose(0.7, 0.5 - D), (*FREE, Drive(x="2*t")), supports=SHELF), (0.7 - UP) / 2.0, True,
    ),
    "disc that touches the end falls": (
        case(FLOOR, DISC, StartPose(D, 0.5 + UP), HEAVY, supports=SHELF), 0.0, True,
    ),
}  # fmt: skip


@pytest.mark.parametrize("method", reference.METHODS)
@pytest.mark.parametrize("row", ROWS)
def test_a_plate_that_meets_an_end_of_a_curve_ends_its_motion_there(row, method):
    scene, exact, is_predicted = ROWS[row]
    motion = reference.simulate(scene, method=method)
    assert motion.status == "track_end" and "make the curve longer" in motion.reason
    assert motion.t[-1] == pytest.approx(exact, abs=TIGHT) and not motion.transitions
    assert reference.check(scene, motion) == ()
    if is_predicted:
        end = predict(scene)
        assert (end.status, end.transitions) == ("track_end", ()) and end.end == pytest.approx(exact, abs=TIGHT)


NEXT = (Support(Curve(("s", "0"), (0.0, 1.0)), "next"),)
DOWN = (Support(Curve(("s", "-s"), (0.0, 1.0)), "down"),)
ENDED = "The contact reached the end of the track's domain"
MET = "The plate meets the end of its track at xi1 = 0"
LOW_WALL = (Support(Curve(("0", "s"), (0.05, 0.15)), "wall"),)
PLASTIC = (*HEAVY[:-1], Impact(0.0))
# Contacts of a curve at its end, or of a side that lies flat on it: statuses, the beginnings of sentences, and the
# number of transitions.
TIES = {
    "disc rolls off": ("track_end", ENDED, 1, case(TABLE, DISC, Start(-0.3, slip=1.0), ROUGH)),
    "disc rolls to a slope": ("track_end", ENDED, 1, case(TABLE, DISC, Start(-0.3, slip=1.0), ROUGH, supports=DOWN)),
    "side rests on a joint": ("completed", "", 0, case(TABLE, BOX, StartPose(-0.05, 0.1), ROUGH, supports=NEXT)),
    "side slides to a joint": (
        "track_end", ENDED, 0, case(TABLE, BOX, StartPose(-0.5, 0.1, vx=2.0), ROUGH, supports=NEXT)
    ),
    "side falls flat on a joint": (
        "completed", "", 2, case(TABLE, BOX, StartPose(-0.05, 0.3), PLASTIC, 0.5, supports=NEXT)
    ),
    # The corner rebounds, and the side goes into the end at once.
    "side falls flat over the end": ("track_end", MET, 1, case(TABLE, BOX, StartPose(-0.1, 0.3), HEAVY)),
    "side lies down over the end": ("track_end", MET, 1, case(TABLE, BOX, StartPose(-0.1, 0.2, theta=0.2), ROUGH)),
    "side hits both ends of a wall": (
        "track_end", "The plate meets the end of the support 'wall'", 0,
        case(FLOOR, BOX, StartPose(-0.5, 0.1, vx=3.0), ROUGH, supports=LOW_WALL),
    ),
    # A chute begins on the corner of a conveyor, which has the contacts there.
    "end on another curve": ("completed", "", 7, cases.load("box_off_conveyor")),
}  # fmt: skip


@pytest.mark.parametrize("method", reference.METHODS)
@pytest.mark.parametrize("tie", TIES)
def test_a_contact_at_the_end_of_its_curve_is_no_meeting_with_that_end(tie, method):
    status, reason, count, scene = TIES[tie]
    motion = reference.simulate(scene, method=method)
    assert (motion.status, len(motion.transitions)) == (status, count) and motion.reason.startswith(reason)
    assert reference.check(scene, motion) == ()


def test_a_disc_that_lands_at_the_very_end_of_its_track_bounces_there():
    scene = case(TABLE, DISC, StartPose(0.0, 0.3), HEAVY, duration=0.3)
    motion = reference.simulate(scene, method="dop853")
    assert [event.time for event in motion.transitions] == pytest.approx([sqrt(2 * 0.2 / G)], abs=TIGHT)
    assert motion.status == "completed" and predict(scene).status == "completed"


@pytest.mark.parametrize(
    "row", ["disc falls beside a shelf", "side of a box against the end", "the same track in pieces"]
)
def test_a_motion_that_goes_on_through_an_end_breaks_a_law(row):
    scene, exact, _ = ROWS[row]
    track = FLOOR if scene.track is FLOOR else Curve(("s", "-2"))
    through = replace(scene, track=track, supports=(), start=StartPose(*start_motion(scene)[:6]), duration=exact + 0.05)
    motion = reference.simulate(through, method="dop853")
    assert motion.status == "completed"
    assert OVERLAP in [one.law for one in reference.check(scene, motion)]


# Poses at which a plate does, or does not, overlap an end of its track or of a support.
STARTS = {
    "disc": (
        TABLE,
        DISC,
        StartPose(D, UP - 1e-4),
        (),
        "overlaps the end of its track at xi1 = 0 by 7.9982e-05",
    ),
    "disc touches": (FLOOR, DISC, StartPose(D, 0.5 + UP), SHELF, None),
    "disc and shelf": (FLOOR, DISC, StartPose(D, 0.5 + UP - 1e-7), SHELF, "overlaps support 'shelf'"),
    "leaning box": (FLOOR, BOX, leaning(-1e-6), SHELF, "overlaps support 'shelf'"),
    "leaning box touches": (FLOOR, BOX, leaning(0.0), SHELF, None),
    "small overlap of an ellipse": (FLOOR, ELLIPSE, StartPose(0.2 - 1e-7, 0.5), SHELF, "overlaps support 'shelf'"),
}


@pytest.mark.parametrize("row", STARTS)
def test_a_start_that_overlaps_an_end_is_rejected_in_one_sentence(row):
    track, plate, start, supports, sentence = STARTS[row]
    if sentence is None:
        assert reference.simulate(case(track, plate, start, HEAVY, supports=supports)).status == "track_end"
        return
    with pytest.raises(DoesNotFit, match=sentence):
        case(track, plate, start, HEAVY, supports=supports)
