"""The atlas of hard scenes: what the reference does there, and what is known exactly of it."""

from dataclasses import replace
from functools import lru_cache
from math import atan, cos, exp, pi, sin, sqrt

import numpy as np
import pytest
from scipy.optimize import brentq

import cases
import reference
from cases import Mode, Start
from reports.judging import residuals
from tests.authorities.paper_application import FIRST_TRANSITION
from tests.benchmarks import hard_scenes
from tests.sampling import quick_every
from tests.scenes.limits import cpu_limit

# A hard scene of a second or so takes the reference well below a second; on a busy machine, and with the derivation of
# its equations, a few.
PATIENCE = 60

# The Taylor method's tolerance is one for all of the state; a flat plate's parameters differ by thousands. DOP853's is
# its own finest, where it meets rounding.
FINEST = {"taylor": 1e-14, "dop853": 1e-13}

# Where one unit in the last place decides what happens: nothing can be right there, and nothing is asked.
CHAOTIC = ("touching_slip[above=0]", "balanced_on_its_tip[duration=6]")
# Of these, the one that every method flags. In the other an integrator's own error in the lowest slip (DOP853: 6e-15
# m/s, 30 units in the last place of the inputs; Taylor: by heyoka's version) can be one that all neighbours share.
FLAGGED = CHAOTIC[1:]

# Their equations take ten seconds to derive, or their tracks have to be searched for second contacts.
TAKE_THEIR_TIME = ("flat_sided", "over_inflections", "released_at_an_inflection", "tightest_fit")


def variants() -> list:
    """Every variant of every hard case; the last of each family runs by default, if it takes seconds."""
    found = []
    for name in cases.names(hard=True):
        chosen = cases.select(name)
        for case in chosen:
            short = case is chosen[-1] and name not in TAKE_THEIR_TIME
            found.append(pytest.param(case, marks=() if short else pytest.mark.slow, id=case.label))
    return found


@lru_cache(maxsize=64)
def motion_of(label: str, method: str | None = None):
    with cpu_limit(PATIENCE):
        return reference.simulate(
            cases.load(label), rtol=FINEST.get(method or reference.METHODS[0], 1e-14), method=method
        )


@lru_cache(maxsize=64)
def last_bit(label: str) -> hard_scenes.Sensitivity:
    with cpu_limit(PATIENCE):
        return hard_scenes.spread(cases.load(label))


# --- every scene ------------------------------------------------------------------------------------------------------


def test_a_hard_case_says_what_makes_it_hard_and_what_is_right():
    assert len(cases.names(hard=True)) >= 20
    for name in cases.names(hard=True):
        entry = cases.entry(name)
        assert len(entry.hard) > 30 and len(entry.outcome) > 15
        assert "Source:" in entry.function.__doc__ and "Known exactly:" in entry.function.__doc__


@quick_every(4, first=1)
@pytest.mark.parametrize("case", variants())
def test_the_reference_keeps_contact_and_energy_and_tells_numbers(case):
    motion = motion_of(case.label)
    for name in ("x", "y", "theta", "vx", "vy", "omega", "slip", "normal_force", "friction_force", "xi1", "xi2"):
        assert np.all(np.isfinite(getattr(motion, name))), name
    found = residuals.examine(case, motion)
    # Poses are rounded to the last digit of the coordinates they lie at, over the plate's own size.
    far = max(float(np.abs([motion.x, motion.y]).max()), float(np.abs(motion.xi1).max())) / case.plate.reach
    rounding = 4 * np.finfo(float).eps * max(far, 1.0)
    assert found.gap <= 1e-12 + rounding
    assert found.tangency <= 1e-12 + rounding * max(1.0, float(np.abs(motion.theta).max()))
    # Energy is as sure as the equations are conditioned, and as the little that moves is of the coordinates' digits.
    if case.label not in CHAOTIC:
        condition = hard_scenes.conditioning(case, motion).dimensionless
        assert found.energy <= 1e-12 + 1e2 * np.finfo(float).eps * min(condition, 1e9)


@quick_every(4, first=1)
@pytest.mark.parametrize("case", variants())
def test_only_scenes_that_hang_on_the_last_bit_are_flagged(case):
    spread = last_bit(case.label)
    flagged = bool(spread.sequence) or spread.centre > 1e-6
    assert flagged <= (case.label in CHAOTIC), spread
    assert flagged >= (case.label in FLAGGED), spread


# --- what is known exactly --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", reference.METHODS)
@pytest.mark.parametrize("slip", [1e-12, -1e-12])
def test_a_slip_just_above_rounding_ends_and_does_not_lift_the_plate_off(slip, method):
    motion = reference.simulate(cases.load("almost_rolling", slip=slip), method=method)
    assert motion.status == "completed"
    assert [t.after for t in motion.transitions] == [Mode.ROLL]
    assert motion.transitions[0].time <= 1e-12


@pytest.mark.parametrize("slip", [1e-17, -1e-17])
def test_a_slip_below_rounding_is_none(slip):
    motion = motion_of(cases.load("almost_rolling", slip=slip).label)
    assert motion.first_mode is Mode.ROLL and not motion.transitions


@pytest.mark.parametrize("part", [1e-9, -1e-9])
def test_an_incline_at_the_cone_is_decided_to_a_billionth(part):
    case = cases.load("incline_at_the_cone", part=part)
    motion = motion_of(case.label)
    assert not motion.transitions
    assert motion.first_mode is (Mode.ROLL if part > 0 else Mode.SLIP_FORWARD)
    expected = 0.0 if part > 0 else -part * 9.81 * sin(0.3)
    assert motion(1.0).slip == pytest.approx(expected, abs=1e-14)


def test_the_cone_touched_from_inside_at_each_swing_begins_no_slip():
    motion = motion_of("pendulum_at_the_cone[part=1e-09]")
    assert motion.first_mode is Mode.ROLL and not motion.transitions
    use = np.abs(motion.friction_force / motion.normal_force) / (np.tan(0.8) / 3)
    assert use.max() == pytest.approx(1.0, abs=1e-6)


def test_the_lowest_slip_is_what_the_quadrature_says():
    motion = motion_of("touching_slip[above=1e-09]")
    around = motion(np.linspace(0.3202, 0.3203, 2001)).slip
    # At its steps' ends DOP853 is as exact; between them it is its interpolant of seventh order, 2.8e-13 m/s off here.
    allowed = {"taylor": 1e-13, "dop853": 1e-12}[reference.METHODS[0]]
    assert around.min() == pytest.approx(1e-9, abs=allowed)


@pytest.mark.parametrize("part", [1e-9, -1e-9])
def test_a_loop_at_the_critical_speed_is_decided_to_a_billionth(part):
    motion = motion_of(f"grazing_loop[part={part:g}]")
    if part > 0:
        assert motion.status == "completed" and not motion.transitions
        return
    assert motion.status == "lift_off"
    # It leaves where cos φ = −1 − 5 part/3, φ from the bottom: sqrt(10/3·1e-9) before the top. N's own error of 1e-15
    # moves that by 1e-15 over the slope of N, which is as small as the angle.
    from_top = pi - (motion.xi1[-1] + pi / 2)
    assert from_top == pytest.approx(sqrt(-10 * part / 3), rel=1e-5)


def test_a_slide_of_nine_hours_ends_to_the_last_digits():
    (end,) = motion_of("long_slide").transitions
    # A component of gravity along the line of 6e-17 of itself would show over nine hours.
    assert end.time == pytest.approx(1.0 / (3 * 1e-6 * 9.81), rel=1e-13)
    assert end.xi1 == pytest.approx(5.0 / (18 * 1e-6 * 9.81), rel=1e-10)


@pytest.mark.parametrize("gap", [1e-2, 1e-4, 1e-6, 1e-8])
def test_a_shaft_in_its_bearing_moves_as_the_papers_disc(gap):
    case = cases.load("nearly_conforming", gap=gap)
    clear = 1.0 - case.plate.radius
    time, _, _ = FIRST_TRANSITION[0.2]
    first = motion_of(case.label).transitions[0]
    # Of the sixteen digits of R and r their difference keeps those of the gap.
    assert first.time / sqrt(clear / 0.9) == pytest.approx(time, rel=1e-13 + 1e-15 / gap)


def test_an_unstable_balance_grows_as_its_eigenvalue_says():
    case = cases.load("balanced_on_its_tip", duration=6.0)
    assert not motion_of(case.label)(6.0).omega
    motion = reference.simulate(replace(case, start=Start(0.0, xi2=0.0, omega=1e-15)))
    a, b = 0.2, 0.1
    rate = sqrt(9.81 * (a - b * b / a) / (a * a + (a * a + b * b) / 4))
    early, late = abs(motion(3.0).omega), abs(motion(4.0).omega)
    assert late / early == pytest.approx(exp(rate), rel=1e-3)


def paradox_angle(mu: float) -> float:
    """The rod's angle (rad) at which 1 + 3 cos²φ = 3 μ cos φ (sin φ + 2 tip/length) first."""
    return brentq(lambda f: 1 + 3 * cos(f) ** 2 - 3 * mu * cos(f) * (sin(f) + 2e-3), 0.0, atan(2.0), xtol=1e-15)


@quick_every(5)
@pytest.mark.parametrize("method", reference.METHODS)
@pytest.mark.parametrize("mu", [2.0, 5.0, 10.0])
def test_a_rod_runs_into_the_paradox_at_the_angle_of_the_formula(mu, method):
    with cpu_limit(PATIENCE):
        motion = reference.simulate(cases.load("rod_into_the_paradox", mu=mu), rtol=1e-10, method=method)
    assert motion.status == "paradox" and not motion.transitions
    assert motion.theta[-1] == pytest.approx(paradox_angle(mu), abs=1e-9)
    assert "Painlev" in motion.reason


@pytest.mark.parametrize("mu", [1.0, 1.3])
def test_below_four_thirds_a_rod_meets_no_paradox_at_any_angle(mu):
    # The threshold of the slender rod on a point; on a tip of a thousandth of its length it lies a little lower.
    for angle in np.linspace(0.05, 1.5, 12):
        with cpu_limit(PATIENCE):
            motion = reference.simulate(cases.load("rod_into_the_paradox", mu=mu, angle=float(angle)))
        assert motion.status != "paradox", angle


def test_above_four_thirds_the_paradox_begins_at_atan_two():
    with cpu_limit(PATIENCE):
        at_rest = [reference.simulate(cases.load("rod_into_the_paradox", mu=mu, angle=atan(2.0))) for mu in (1.3, 1.36)]
    assert [motion.status for motion in at_rest] == ["lift_off", "paradox"]


def test_energy_is_closed_over_a_hundred_transitions(accuracy):
    case = cases.load("limping_wheel", duration=14.0)
    motion = reference.simulate(case, rtol=1e-13)
    assert len(motion.transitions) >= 100
    error = residuals.examine(case, motion).energy
    common = dict(case=case.label, solver="reference", route="best")
    accuracy(**common, quantity="energy not accounted for, of what moves", error=error, tolerance=1e-9)


# --- what random scenes found -----------------------------------------------------------------------------------------


def test_a_thin_ellipse_keeps_its_energy_by_dop853():
    """Its curvature is 0.04 1/m to 5000 1/m; where the square of its speed had two forms, 1.4e-10 of the energy was
    lost. At this tolerance DOP853 keeps 2e-13 to 6e-13 of it."""
    case = cases.load("sliver", mu=0.5, omega=-12.0)
    assert residuals.examine(case, reference.simulate(case, rtol=1e-13, method="dop853")).energy <= 5e-12
