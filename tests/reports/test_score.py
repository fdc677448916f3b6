"""The score, checked with motions whose errors are known: exact ones, null motions, engines with a planted error."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import cases
import reference
from cases import Mode, State
from cases.contact import start_motion
from reports.judging import friction_sensitivity, grades, null_motions
from reports.judging.claims import claims_hold
from reports.judging.grades import Grade, grade, sequence_note
from tests.sampling import quick_every
from tests.scenes import planted_engines as planted
from tests.scenes.motions import sampled

PAPER = cases.load("disc_in_circle", mu=0.2)
# Slip to roll and back; no disc; a landing.
SAMPLE = (PAPER, cases.load("ellipse_on_line", mu=0.05), cases.load("disc_onto_incline", mu=0.1))
# Motions with several contacts have tests of their own (test_several_contacts, test_score_on_supports).
# `TIPPING`: supports, but one contact.
SEVERAL = "cases.catalogue.several_contacts"
NAMES = [name for name in cases.names() if cases.entry(name).function.__module__ != SEVERAL]
TIPPING = ("block_on_incline[slope=0.6,mu=0.9]", "block_on_incline[slope=0.6,mu=0.52]")
CATALOGUE = [
    case
    for name in NAMES
    for case in cases.select(name)
    if case not in SAMPLE and (not case.supports or case.label in TIPPING)
]
each_case = pytest.mark.parametrize(
    "case",
    [*SAMPLE, *(pytest.param(case, marks=pytest.mark.slow) for case in CATALOGUE)],
    ids=lambda case: case.label,
    scope="module",  # all tests of a case in a row, so that it is simulated once
)
# Score per 1 % of friction. Below, a case hardly depends on friction's law (mu is so large that more changes little);
# above, it hangs on it: a plate is about to slip or to turn over.
REGULAR = (0.005, 0.025)
# Rounding of scores that are zero.
ROUNDING = 1e-9


@quick_every(3)
@each_case
def test_null_motions_are_as_wrong_as_ignoring_friction(case):
    truth = planted.judged(case)
    assert truth.scale.null_motion or case.name == "balanced_on_its_tip"  # nothing moves there
    for name, motion in truth.nulls.items():
        score = truth.score(motion)
        is_truth = score.pose <= 1e-6
        assert score.off >= 1.0 - ROUNDING or is_truth, (name, score)
        # The nearest one is the scale.
        assert name != truth.scale.null_motion or score.pose == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("label", ["disc_on_line[mu=0.1]", "thrown_with_spin"])
def test_a_disc_that_rolls_from_the_start_keeps_the_speed_of_its_centre(label):
    [case] = cases.select(label)[:1]
    motion, start = null_motions.rolling(case), start_motion(case)
    assert case.start.slip != 0.0 == motion.slip[0]
    assert (motion.vx[0], motion.vy[0]) == pytest.approx((start.vx, start.vy), abs=1e-15)


@quick_every(2)
@each_case
def test_exact_motions_are_within_their_doubt(case):
    truth = planted.judged(case)
    for samples in (100, 300, 1000, 4000):
        for noise in (0.0, 1e-9, 1e-6, 1e-4):
            score = truth.score(planted.noisy(truth, samples, noise))
            assert score.off <= score.doubt + ROUNDING, (samples, noise, score)


@quick_every(3)
@each_case
def test_engines_with_a_planted_error_get_what_a_physicist_would_say(case):
    truth = planted.judged(case)
    off = {}
    for name, engine in planted.ENGINES.items():
        if case.effect(cases.CoulombFriction) is None and name.startswith("friction"):
            continue
        score = truth.score(engine(truth))
        off[name] = score.off
        # Where plates never slip faster than millimetres a second, 2e-5 m/s is no creep.
        if name == "creep" and planted.CREEP <= 0.005 * truth.scale.fastest_slip:
            assert score.off <= planted.CREEP / truth.scale.slip + score.doubt + ROUNDING
        if name == "6 µs of slip":
            # Each of its slips is 6 µs in another mode, before and after which nothing differs.
            slips = sum(event.after in (Mode.ROLL, Mode.REST) for event in truth.truth.transitions)
            assert score.off <= 2.0 * slips * planted.EXTRA_SLIP / truth.scale.time + ROUNDING
    if case in SAMPLE:
        assert grade(off["creep"]) is grade(off["6 µs of slip"]) is Grade.EXCELLENT, off
        assert off["half a step late"] <= 0.02 and off["damping"] <= 0.02, off
    if REGULAR[0] <= truth.sensitivity <= REGULAR[1] and case.plate.radius is None and not _slips_for_long(truth):
        # Rolling all the way is no null motion of a plate that is no disc, and here it is no bad one.
        assert 0.1 <= off["friction × 60"] and off["friction - 5 %"] <= 0.15, off
    elif REGULAR[0] <= truth.sensitivity <= REGULAR[1]:
        # At the edge of slipping less friction matters and more does not.
        if truth.score(planted.with_friction(case, 1.01)).off > friction_sensitivity.LEAST:
            assert grade(off["friction × 60"]) is Grade.UNUSABLE, off
        assert 0.02 <= off["friction - 5 %"] <= 0.15, off
    elif truth.sensitivity < friction_sensitivity.LEAST and "friction × 60" in off:
        # It rolls, or slides without a force: friction may be anything that is enough.
        assert off["friction × 60"] <= 1e-3, off


def _slips_for_long(truth: planted.Judged) -> bool:
    """Whether the truth slips for a quarter of its time at least."""
    slips = [p.duration for p in truth.scale.phases if p.mode in (Mode.SLIP_FORWARD, Mode.SLIP_BACKWARD)]
    return sum(slips) >= 0.25 * truth.scale.end


def test_the_scale_of_slip_is_that_of_the_nearest_null_motion():
    """A Reuleaux triangle at rest never slips, and the true one nearly never: a thousandth of a metre per second would
    count as much as ignoring friction."""
    truth = planted.judged(cases.load("reuleaux_on_slope"))
    slips = {name: float(np.mean(np.abs(motion.slip))) for name, motion in truth.nulls.items()}
    assert truth.scale.null_motion == "no friction"
    assert slips["never moves"] == 0.0 and truth.scale.slip == pytest.approx(slips["no friction"], rel=0.2)
    rough = replace(truth.truth, dense=None, first_mode=None)
    chatter = 0.001 * np.resize([1.0, -1.0], len(rough.t))
    assert truth.score(replace(rough, slip=rough.slip + chatter)).off < 0.25


@pytest.mark.slow
def test_slip_in_the_last_instant_is_no_scale_of_its_own():
    """A block tips for a second and slips in its last 1.4 ms, 39 nm altogether: the null motion never slips, and the
    truth's 0.04 µm/s would be as bad as ignoring friction. With 1 % less friction it slips some 0.4 ms earlier."""
    truth = planted.judged(cases.load("block_on_incline", slope=0.6, mu=0.9))
    (event,) = truth.truth.transitions
    less = planted.with_friction(truth.case, 0.99)
    score = truth.score(less)
    assert truth.scale.null_motion == "never moves"
    frictionless = truth.nulls["no friction"](np.linspace(0.0, truth.scale.end, 1001)).slip
    assert truth.scale.slip == pytest.approx(float(np.mean(np.abs(frictionless))), rel=0.01)
    assert score.pose < 1e-7 and score.slip < 1e-7
    assert grade(truth.score(planted.creeping(truth)).off) is Grade.EXCELLENT
    other = reference.simulate(null_motions.with_friction(truth.case, mu=0.99 * 0.9)).transitions
    assert truth.sensitivity == pytest.approx(abs(other[0].time - event.time) / truth.scale.time, rel=1e-3)
    assert 1e-3 < truth.sensitivity < 2e-3


def test_a_case_that_an_engine_s_step_decides_is_not_ranked():
    """Rolling all the way over the edge is less than 0.1 mm away; friction measured by that says nothing."""
    truth = planted.judged(cases.load("disc_over_edge"))
    assert truth.scale.null_motion == "rolls from the start" and truth.scale.pose < 1e-4
    assert truth.sensitivity > friction_sensitivity.LEAST
    reason = friction_sensitivity.not_ranked(truth.sensitivity, truth.scale)
    assert reason == "ignoring friction's law moves the plate by 0.04 % of its path only"
    assert f"not ranked: {reason}" in grades.reason(truth.score(truth.truth), truth.scale, 1.0)
    paper = planted.judged(PAPER)
    assert friction_sensitivity.not_ranked(paper.sensitivity, paper.scale) == ""


def test_the_least_share_is_the_error_of_a_usual_step_without_friction():
    """Semi-implicit Euler from rest under g: x_n = g h² n (n + 1)/2, so x - x(t) = g h t/2."""
    h, end, g = 1 / 60, 2.0, 9.81
    n = np.arange(round(end / h) + 1)
    off = g * h**2 * n * (n + 1) / 2 - g * (n * h) ** 2 / 2
    share = np.sqrt(np.mean(off**2)) / (g * end**2 / 2)
    assert share == pytest.approx(h / (np.sqrt(3) * end), rel=0.01)
    assert share == pytest.approx(friction_sensitivity.LEAST_SHARE, rel=0.05)


def test_extrapolations_are_within_their_doubt():
    # Few samples before each end of slip: the error is 1.02 times the smallest spread.
    truth = planted.judged(cases.load("disc_in_catenary"))
    score = truth.score(sampled(truth.truth, 100))
    assert 0.0 < score.off <= score.doubt


def test_a_motion_that_locates_its_transitions_leaves_no_doubt():
    truth = planted.judged(PAPER)
    score = truth.score(truth.truth)  # few samples, known at every time
    assert score.off == score.doubt == 0.0
    assert truth.friction(truth.truth) == pytest.approx(1.0, abs=1e-4)


def test_creep_is_estimated_and_never_asked_for():
    truth = planted.judged(PAPER)
    motion = planted.creeping(truth)
    assert motion.slip_resolution == 0.0
    score = truth.score(motion)
    assert score.creep == pytest.approx(planted.CREEP, rel=1e-6)
    assert sequence_note(score, truth.scale) == "same sequence"
    # Declared or not, too large or too small, it makes no difference.
    for declared in (1e-6, 2e-5, 1e-3):
        assert truth.score(replace(motion, slip_resolution=declared)).off == pytest.approx(score.off, abs=1e-7)


def test_slip_of_microseconds_in_an_impact_is_reported_and_does_not_count():
    truth = planted.judged(cases.load("disc_onto_incline", mu=0.5))
    score = truth.score(planted.slipping_in_an_impact(truth))
    assert sequence_note(score, truth.scale) == "same sequence down to 6 µs"
    assert score.mode * truth.scale.time == pytest.approx(planted.EXTRA_SLIP, rel=1e-6)


# --- each score grows with its own kind of error ----------------------------------------------------------------------


def test_pose_score_is_the_error_over_that_of_the_nearest_null_motion():
    truth = planted.judged(PAPER)
    exact = sampled(truth.truth, 1000)
    for shift in (1e-6, 1e-4, 1e-2):
        assert truth.score(replace(exact, x=exact.x + shift)).pose == pytest.approx(shift / truth.scale.pose)
    turned = truth.score(replace(exact, theta=exact.theta + 2.0 * np.pi))
    assert turned.pose <= ROUNDING  # whole turns are a matter of where rotation is counted from


def test_mode_score_is_the_time_in_another_mode():
    truth = planted.judged(PAPER)
    exact = sampled(truth.truth, 1000)
    # Later ones are more than 0.01 % off: then the samples count too, and these are exact.
    for late in (1e-7, 1e-6, 1e-5):
        score = truth.score(_with_transitions(truth, exact, late))
        assert score.mode * truth.scale.time == pytest.approx(late * len(truth.truth.transitions), rel=1e-6)
        assert score.off == score.mode


def test_transitions_that_a_motion_contradicts_are_not_used():
    """They are 20 ms late, and the slip at 15 samples says so: the modes are those of the samples."""
    truth = planted.judged(PAPER)
    exact = sampled(truth.truth, 2000)
    wrong = _with_transitions(truth, exact, 0.02)
    assert claims_hold(exact) and claims_hold(_with_transitions(truth, exact, 0.0)) and not claims_hold(wrong)
    assert truth.score(wrong) == truth.score(exact)


def _with_transitions(truth, motion, late):
    """The motion with the truth's transitions, so much later (s)."""
    events = [replace(event, time=event.time + late) for event in truth.truth.transitions]
    return replace(motion, transitions=tuple(events), first_mode=truth.truth.first_mode)


def test_slip_score_is_the_mean_error_of_slip():
    truth = planted.judged(cases.load("disc_on_line", mu=0.1))
    exact = sampled(truth.truth, 4000)
    for part in (0.01, 0.1):
        slower = truth.score(replace(exact, slip=(1.0 - part) * exact.slip))
        size = np.abs(exact.slip)
        mean = float(np.mean(0.5 * (size[1:] + size[:-1])))  # trapezoids: the times are even
        assert slower.slip == pytest.approx(part * mean / truth.scale.slip, rel=1e-6)
        assert slower.off >= slower.slip > max(slower.pose, slower.mode)


def test_score_has_no_unit():
    offs = []
    for case in cases.select("at_any_size"):
        truth = planted.judged(case)
        offs.append(truth.score(planted.less_friction(truth)).off)
    assert len(offs) == 3 and np.ptp(offs) <= 1e-6 * offs[0]


# --- what a motion leaves out counts as standing still ----------------------------------------------------------------


def part(motion, kept):
    """The motion with some of its samples."""
    return replace(motion, **{name: getattr(motion, name)[kept] for name in ("t", *State._fields)})
