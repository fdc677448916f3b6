"""Motions of plates between walls obey the laws: no overlap, no energy from nothing, no event of roundings."""

from dataclasses import replace
from math import cos, hypot, inf, pi, sin, sqrt

import numpy as np
import pytest

import reference
from cases import (
    Case,
    CoulombFriction,
    Curve,
    Flight,
    FreePlate,
    Gravity,
    Impact,
    Load,
    Plate,
    Start,
    StartPose,
    Support,
    Unilateral,
    disc,
)
from cases.library import line
from tests.scenes.walled_plates import random_walled_plates

G = 9.81
WALL = Support(Curve(("0", "-s")), "wall")


def effects(mu: float = 0.3, e: float = 0.0) -> tuple:
    """Weight, friction and impacts by Moreau's law."""
    return (Gravity(G), *((CoulombFriction(mu),) if mu else ()), Unilateral(), Flight(), Impact(e, "moreau"))


def wedge(mu: float = 0.3, phi: float = 0.6, mass: float = 0.2) -> Case:
    """A disc between a wall and a larger disc on the floor, the line of the centres at φ from the vertical."""
    lower, upper = StartPose(0.1 + 0.3 * sin(phi), 0.2), StartPose(0.1, 0.2 + 0.3 * cos(phi))
    others = (FreePlate(disc(0.1, mass), upper, "b"),)
    return Case(line(), disc(0.2, 1.0), effects(mu), lower, 1.5, supports=(WALL,), others=others)


# --- contacts without force, and contacts that do not touch each other ------------------------------------------------

WEDGES = [(0.3, 0.6, 0.2), (0.6, 0.9, 0.5), (0.3, 0.9, 0.5)]


@pytest.mark.parametrize("wedge_of", WEDGES)
def test_a_disc_beside_a_wall_that_it_touches_without_force_lands_on_the_floor(wedge_of):
    motion = reference.simulate(wedge(*wedge_of), rtol=1e-12, method="dop853")
    assert motion.status == "completed"
    assert not reference.check(motion.case, motion)


def test_a_disc_falls_between_a_wall_and_a_disc_and_closes_at_the_known_time():
    """By two independent simulators in pose coordinates. It fell to 0.22 m below the floor."""
    motion = reference.simulate(wedge(), rtol=1e-12, method="dop853")
    landing = next(change for change in motion.transitions if change.contact == "b/track")
    assert landing.time == pytest.approx(0.9499508480753582, abs=5e-12)


def test_a_disc_at_rest_does_not_move_because_another_one_lands():
    others = (FreePlate(disc(0.1, 1.0), StartPose(0.1, 0.3), "b"),)
    case = Case(line(), disc(0.1, 1.0), effects(), StartPose(3.0, 0.1), 1.0, supports=(WALL,), others=others)
    motion = reference.simulate(case, method="dop853")
    assert motion.status == "completed" and not motion.vx.any() and not motion.omega.any()
    landing = next(change for change in motion.transitions if change.contact == "b/track")
    assert landing.time == pytest.approx(sqrt(2.0 * 0.2 / G), abs=1e-14)


# --- velocities of roundings ------------------------------------------------------------------------------------------


def _groove() -> Case:
    """A disc at rest on two flanks of 0.6 rad."""
    flank = Support(Curve((f"s*{cos(0.6)!r}", f"-s*{sin(0.6)!r}")), "flank")
    return Case(line(-0.6), disc(0.1, 1.0), effects(), StartPose(0.0, 0.1 / cos(0.6)), 1.0, supports=(flank,))


def _two_discs() -> Case:
    others = (FreePlate(disc(0.1, 1.0), StartPose(0.2, 0.1), "b"),)
    return Case(line(), disc(0.1, 1.0), effects(), StartPose(0.0, 0.1), 1.0, others=others)


AT_REST = {
    "box": lambda: Case(line(), Plate.rectangle(0.2, 0.1, 1.0), effects(), StartPose(0.0, 0.05), 1.0),
    "corner": lambda: Case(line(), disc(0.1, 1.0), effects(), StartPose(0.1, 0.1), 1.0, supports=(WALL,)),
    "two discs": _two_discs,
    "groove": _groove,
}


@pytest.mark.parametrize("speed", [1e-17, -1e-16, 1e-300])
@pytest.mark.parametrize("name", AT_REST)
def test_a_plate_with_a_velocity_of_roundings_rests(name, speed):
    """Compared with the fastest speed of the same state it was a motion, which ended as `accumulation` at 0 s."""
    case = AT_REST[name]()
    case = replace(case, start=StartPose(*_pose(case.start, case), speed, speed, 0.0))
    motion = reference.simulate(case, method="dop853")
    assert motion.status == "completed" and not motion.transitions
    assert not motion.vx[-1] and not motion.vy[-1] and not motion.omega[-1]


def _pose(start, case: Case) -> tuple[float, float, float]:
    at = start.motion(case.track, case.plate.outline)
    return float(at.x), float(at.y), float(at.theta)


# --- starts -----------------------------------------------------------------------------------------------------------


def basin(radius: float, low: float = 0.0, high: float = pi) -> Curve:
    """An arc of that radius with its lowest point in the origin, and ends."""
    return Curve((f"-{radius!r}*cos(s)", f"{radius!r}-{radius!r}*sin(s)"), domain=(low, high))


@pytest.mark.parametrize(
    "track,height", [(basin(2.0), 2.6), (basin(2.0), 3.0), (basin(2.5), 3.0), (basin(2.0, 0.2, 2.9), 2.0),
                     (Curve(("s-1", "(s-1)**2"), domain=(0, 2)), 3.0)],
)  # fmt: skip
def test_a_disc_falls_to_the_lowest_point_of_a_track_whose_nearest_points_are_beyond_its_ends(track, height):
    case = Case(track, disc(0.1, 1.0), effects(), StartPose(0.0, height), 1.0)
    motion = reference.simulate(case, method="dop853")
    assert motion.transitions[0].time == pytest.approx(sqrt(2.0 * (height - 0.1) / G), abs=1e-12)


def tube(tilt: float, mu: float, spin: float) -> Case:
    """A disc at rest or with a spin between two walls that are as far apart as it is wide, `tilt` (rad) from the
    vertical."""
    c, s, r = cos(tilt), sin(tilt), 0.1
    low, high = Curve((f"{s!r}*s", f"-{c!r}*s")), Curve((f"{2 * r * c!r}-{s!r}*s", f"{2 * r * s!r}+{c!r}*s"))
    start = StartPose(r * c, r * s, 0.0, 0.0, 0.0, spin)
    return Case(low, disc(r, 1.0), effects(mu), start, 1.0, supports=(Support(high, "high"),))


@pytest.mark.parametrize("method", reference.METHODS)
@pytest.mark.parametrize("tilt,spin", [(0.0, 0.0), (0.0, 3.0), (0.4, 0.0), (-0.4, -2.0)])
def test_a_smooth_disc_slides_through_a_tube_of_its_own_width(tilt, spin, method):
    """The walls' forces are not unique, and move nothing. The status was `breakdown` or, with a spin, `unfinished`."""
    case = tube(tilt, 0.0, spin)
    motion = reference.simulate(case, method=method)
    assert motion.status == "completed" and not motion.transitions
    last, fall = motion(1.0), 0.5 * G * cos(tilt)
    away = last.x - 0.1 * cos(tilt), last.y - 0.1 * sin(tilt), last.omega
    assert away == pytest.approx((fall * sin(tilt), -fall * cos(tilt), spin), abs=1e-13)
    assert not reference.check(case, motion)


@pytest.mark.parametrize("spin", [0.0, 3.0])
def test_friction_in_a_tube_of_its_own_width_is_not_unique(spin):
    """Walls may press on the disc as much as they like, which holds it or stops its spin."""
    motion = reference.simulate(tube(0.0, 0.3, spin), method="dop853")
    assert motion.status == "not_unique" and motion.t[-1] == 0.0


def test_drag_by_the_square_root_of_a_square_begins_at_rest():
    """v' = a − c v² has the solution √(a/c) tanh(√(a c) t)."""
    mass, slope, mu, drag = 80.0, 0.3, 0.03, 0.3
    load = Load(fx=f"-{drag}*vx*sqrt(vx**2+vy**2)", fy=f"-{drag}*vy*sqrt(vx**2+vy**2)")
    case = Case(
        line(-slope), disc(0.1, mass, inf), (Gravity(G), CoulombFriction(mu), Unilateral(), load), Start(0.0), 3.0
    )
    a, c = G * (sin(slope) - mu * cos(slope)), drag / mass
    for method in reference.METHODS:
        last = reference.simulate(case, rtol=1e-12, method=method)(3.0)
        assert hypot(last.vx, last.vy) == pytest.approx(sqrt(a / c) * np.tanh(sqrt(a * c) * 3.0), rel=1e-10)


# --- random scenes ----------------------------------------------------------------------------------------------------


def _of_mass(case: Case, unit: float) -> Case:
    """The same scene with all masses multiplied."""
    plates = [case.plate, *(other.plate for other in case.others)]
    first, *others = (replace(plate, mass=unit * plate.mass, inertia=unit * plate.inertia) for plate in plates)
    every = tuple(replace(other, plate=plate) for other, plate in zip(case.others, others, strict=True))
    return replace(case, plate=first, others=every)


@pytest.mark.parametrize("seed, unit", [(2474928891, 2.0**-30), (14, 2.0**-30), (3, 2.0**30), (14, 2.0**30)])
def test_motions_of_several_plates_do_not_depend_on_the_unit_of_mass(seed, unit):
    """With 1e-9 kg impacts were `not_unique`: impulses were compared with velocities. With 1e9 kg a disc that touches
    a wall without force was an `accumulation`: forces were compared with accelerations. Powers of two add no
    rounding: the times are equal to the last bit."""
    case = random_walled_plates(seed, duration=0.4)
    one, other = (reference.simulate(c, method="dop853") for c in (case, _of_mass(case, unit)))
    assert one.status == other.status == "completed"
    assert one.transitions == other.transitions
