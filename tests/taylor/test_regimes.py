"""What ends a regime or a motion, away from the paper's application."""

import subprocess
import sys
from dataclasses import replace
from math import pi

import numpy as np
import pytest

import cases
import reference
from cases import (
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
    Unilateral,
    disc,
)  # fmt: skip
from cases import curves as c
from tests.sampling import quick_every
from tests.scenes import second as second_states
from tests.scenes.elliptic import ellipse


def valley(depth: float) -> Curve:
    return Curve(lambda s: (s, -depth * c.cos(2 * s)), domain=(-3, 3))


@pytest.mark.parametrize("method", reference.METHODS)
def test_a_disc_too_wide_for_the_bottom_of_a_valley_stops_at_its_second_contact(method):
    # Curvature 2 1/m at the bottom, so a disc of 0.6 m touches both flanks at once when its centre is above the bottom.
    case = Case(valley(0.5), disc(0.6, 1.0), (Gravity(9.81), CoulombFriction(0.2), Unilateral()), Start(-1.2), 3.0)
    motion = reference.simulate(case, method=method)
    assert motion.status == "second_contact"
    assert motion.x[-1] == pytest.approx(0.0, abs=1e-9)
    assert f"{-motion.xi1[-1]:.6g}"[:6] in motion.reason


@pytest.mark.parametrize("method", reference.METHODS)
def test_the_end_of_an_open_track_is_told_with_its_time(method):
    track = Curve(lambda s: (s, 0), domain=(-0.5, 0.7))
    case = Case(track, disc(0.1, 1.0), (Gravity(9.81),), Start(0.0, slip=1.0, omega=0.0), 3.0)
    motion = reference.simulate(case, method=method)
    assert motion.status == "track_end"
    assert motion.t[-1] == pytest.approx(0.7, abs=1e-12)  # at 1 m/s, without friction


@pytest.mark.parametrize("rtol", [1e-3, 1e-4, 1e-5])
@pytest.mark.parametrize("method", reference.METHODS)
def test_a_guide_presses_from_its_other_side_at_a_coarse_tolerance(method, rtol):
    """Where the force vanishes along the step's polynomial, it has what the tolerance leaves: no paradox."""
    motion = reference.simulate(cases.load("guided_loop"), rtol=rtol, method=method)
    assert motion.status == "completed", motion.reason
    (only,) = motion.transitions
    assert only.after is Mode.SLIP_BACKWARD
    assert only.time == pytest.approx(0.558574238439291, rel=rtol)  # proved, see reference/proofs/catalogue.json


@pytest.mark.parametrize(
    ("method", "mu"),
    [("dop853", 0.3), *(pytest.param("taylor", mu, marks=pytest.mark.slow) for mu in (0.3, 0.5))],
)
def test_a_guide_changes_its_side_while_the_plate_slips_slowly(method, mu):
    """The slip is then less than the tolerance's part of the spin, but not zero: the plate continues to slip."""
    case = cases.load("guided_loop", ratio=8.0, mu=mu)
    rough, fine = reference.simulate(case, rtol=1e-2, method=method), reference.simulate(case, rtol=1e-12)
    assert rough.status == "completed", rough.reason
    assert [(e.before, e.after) for e in rough.transitions] == [(e.before, e.after) for e in fine.transitions]
    assert [e.time for e in rough.transitions] == pytest.approx([e.time for e in fine.transitions], rel=1e-2)


def test_a_motion_into_the_paradox_is_told_as_such():
    outline = Curve(lambda s: (-0.5 + 0.01 * c.cos(s), 0.01 * c.sin(s)))
    rod = Plate(outline, 1.0, 1 / 12)
    effects = (Gravity(9.81), CoulombFriction(3.0), Unilateral())
    statuses = set()
    for omega in (-2.0, 0.0, 2.0):
        for slip in (-2.0, 2.0):
            case = Case(
                Curve(lambda s: (s, 0)), rod, effects, Start(0.0, xi2=-pi / 2 - 1.1, slip=slip, omega=omega), 1.0
            )
            motion = reference.simulate(case)
            assert np.all(np.isfinite(motion.x))
            statuses.add(motion.status)
    assert "paradox" in statuses


@pytest.mark.slow
def test_without_heyoka_everything_works_and_says_once_which_method_it_used():
    program = (
        "import sys, logging; sys.modules['heyoka'] = None\n"
        "logging.basicConfig(format='%(message)s')\n"
        "import cases, reference\n"
        "for _ in range(2): motion = reference.simulate(cases.load('disc_in_circle', mu=0.2))\n"
        "print(reference.METHODS, motion.transitions[0].time)\n"
        "reference.simulate(cases.load('disc_in_circle'), method='dop853')\n"
    )
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert run.stdout.startswith("('dop853',) 0.63005376")
    assert run.stderr.count("dop853") == 1


@quick_every(2, first=1)
@pytest.mark.parametrize("method", reference.METHODS)
def test_a_loose_tolerance_does_not_change_what_follows_a_transition(method):
    # An elliptic plate in a cosine valley: its slip reverses, and a coarse motion must not mistake that for a lift-off.
    plate = Plate(ellipse(0.15, 0.1), 1.0, 0.008)
    case = Case(valley(0.3), plate, (Gravity(9.81), CoulombFriction(0.1), Unilateral()), Start(-1.0), 3.0)
    fine = [t.after for t in reference.simulate(case, rtol=1e-10, method=method).transitions]
    coarse = reference.simulate(case, rtol=1e-3, method=method)
    assert [t.after for t in coarse.transitions] == fine


def test_a_plate_with_corners_that_a_load_lifts_from_the_start_flies():
    """Its start was rejected, as "a curve with corners has no single formula"."""
    case = cases.load("half_disc_rocking")
    kept = tuple(e for e in case.effects if not isinstance(e, Flight | Impact))
    case = replace(case, effects=(*kept, Load(fy="30"), Flight(), Impact(0.3)))
    motion, other = reference.simulate(case), second_states.motion(case, until=1.0)
    assert motion.first_mode is Mode.FLIGHT and not motion.transitions and not other.transitions
    assert motion(1.0).y == pytest.approx(other.last.motion[1], abs=1e-9)
    # Weightless but for 30 N upwards.
    assert motion(1.0).vy == pytest.approx(30.0 / case.plate.mass - 9.81 + motion(0.0).vy, abs=1e-11)
