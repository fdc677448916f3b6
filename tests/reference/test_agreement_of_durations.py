"""Both formulations over durations of six decades: what happens in a motion's first second is the same in all of them.

The scenes begin with an impact, in a fall or in contact. A second is some ten times what a plate takes to fall by its
size; much later the smallest difference of two computations has grown to the size of the motion in a bowl.
"""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import reference
from cases import Case, CoulombFriction, Flight, Gravity, Impact, Mode, PerfectlyRough, Start, Unilateral, disc
from cases.library import line
from reference import METHODS
from tests.reference.test_random_effects import UNHURRIED
from tests.reference.test_two_formulations import ill_conditioned, sequence
from tests.scenes import second as second_states
from tests.scenes.elliptic import ellipse_in_ellipse, numbers

HORIZON = 1.0

# What grazing events make of two integrations at 1e-11, in parts of the horizon or of a shorter duration.
APART = 1e-6


def beginning(answer, until: float) -> list:
    """The transitions well before that time."""
    return [t for t in answer.transitions if t.time < until * (1.0 - 10 * APART)]


def differences(case: Case, looks: int) -> str:
    """What the formulations say differently of the motion's beginning; "" if nothing."""
    until = min(case.duration, HORIZON)
    ours = reference.simulate(case, rtol=1e-11)
    theirs = second_states.motion(case, rtol=1e-11, until=until)
    one, other = beginning(ours, until), beginning(theirs, until)
    if sequence(one) != sequence(other):
        return f"{[(t.time, str(t.after)) for t in one]}\n{[(t.time, str(t.after)) for t in other]}"
    apart = max((abs(a.time - b.time) for a, b in zip(one, other, strict=True)), default=0.0)
    if apart > APART * until:
        return f"times differ by {apart:.2e} s"
    ended = float(ours.t[-1]) < until * (1.0 - 10 * APART)
    if (ended or case.duration <= HORIZON) and ours.status != theirs.status:
        return f"{ours.status}, {theirs.status}"
    return ""


def check(case: Case) -> None:
    said = differences(case, 60) and differences(case, 2000)
    assert not said or ill_conditioned(replace(case, duration=min(case.duration, HORIZON))), (said, case)


def in_a_bowl(base: Case, law, e: float, restitution: str, gap: float, lift: float, duration: float) -> Case:
    """A plate in an elliptic bowl that begins with an impact (no gap, lift < 0), in a fall or with a leap."""
    effects = (base.effect(Gravity), *law, Unilateral(), Flight(), Impact(e, restitution))
    rough = PerfectlyRough() in law and gap == lift == 0.0
    start = Start(base.start.xi1, base.start.xi2, 0.0 if rough else base.start.slip, base.start.omega, gap, lift)
    return Case(base.track, base.plate, effects, start, duration)


def on_a_slope(slope, law, e, restitution, gap, lift, slip, omega, duration) -> Case:
    """A disc that falls or is thrown onto a line."""
    rough = PerfectlyRough() in law and gap == lift == 0.0
    effects = (Gravity(9.81), *law, Unilateral(), Flight(), Impact(e, restitution))
    start = Start(0.0, slip=0.0 if rough else slip, omega=omega, gap=gap, gap_rate=lift)
    return Case(line(slope), disc(0.1, 1.0), effects, start, duration)


begins = dict(
    law=st.just(()) | st.just((PerfectlyRough(),)) | st.builds(lambda mu: (CoulombFriction(mu),), numbers(0.01, 1.0)),
    e=st.sampled_from([0.0, 0.5, 0.9, 1.0]) | numbers(0.0, 0.95),
    restitution=st.sampled_from(["poisson", "poisson", "newton"]),
    gap=st.just(0.0) | numbers(1e-3, 0.1),
    lift=numbers(-2.0, -1e-3) | numbers(-2.0, 1.0),
    # 0.1 ms to 100 s.
    duration=numbers(-4.0, 2.0).map(lambda power: 10.0**power),
)
plates = st.builds(
    ellipse_in_ellipse,
    A=numbers(1.0, 1.2), B=numbers(0.8, 1.0), a=numbers(0.18, 0.3), b=numbers(0.18, 0.3), xi1=numbers(-3.0, 3.0),
    xi2=numbers(-3.0, 3.0), mu=st.just(0.0), slip=st.just(0.0) | numbers(0.01, 2.0) | numbers(-2.0, -0.01),
    omega=numbers(-5.0, 5.0), direction=numbers(-3.0, 3.0), shift=numbers(-0.05, 0.05),
)  # fmt: skip
bowls = st.builds(in_a_bowl, plates, **begins)
slopes = st.builds(on_a_slope, numbers(0.0, 1.2), slip=numbers(-2.0, 2.0), omega=numbers(-20.0, 20.0), **begins)


@settings(max_examples=6, **UNHURRIED)
@given(slopes.filter(lambda case: case.duration <= 3.0))
def test_both_formulations_begin_alike_on_a_slope(case):
    check(case)


def test_a_leap_so_low_that_its_rebounds_drown_in_rounding_rests_at_its_limit():
    """1e-5 m/s up a slope: the ninth rebound rises by less than a position's rounding, with 20 ns of bouncing to go.

    Rebounds of e = 0.536 from a lift u under g cos α last 2u/(g cos α (1 - e)) in all.
    """
    slope, e, lift = 0.5717851550215713, 0.5360387281788312, 1e-5
    case = on_a_slope(slope, (), e, "newton", 0.0, lift, 0.0, 0.0, 1.0)
    rest = 2 * lift / (9.81 * cos(slope) * (1 - e))
    for answer in (*(reference.simulate(case, method=m) for m in METHODS), second_states.motion(case)):
        assert answer.transitions[-1].time == pytest.approx(rest, rel=1e-12)
        assert len(answer.transitions) == 9


@pytest.mark.parametrize("closing", [1.0, 0.05, 1e-6])
def test_a_start_that_closes_is_an_impact_though_the_plate_is_pulled_off(closing):
    """Under a ceiling: without the impact the gap would open again after 2u/g, a few milliseconds."""
    case = Case(
        line(0.0), disc(0.1, 1.0), (Gravity(9.81, pi / 2), Unilateral(), Flight(), Impact(0.5)),
        Start(0.0, gap=0.0, gap_rate=-closing), 0.5,
    )  # fmt: skip
    for answer in (*(reference.simulate(case, method=m) for m in METHODS), second_states.motion(case)):
        assert [(t.time, t.after) for t in answer.transitions] == [(0.0, Mode.FLIGHT)]
    assert float(reference.simulate(case)(0.5).vy) == pytest.approx(0.5 * closing + 9.81 * 0.5, rel=1e-14)


@pytest.mark.parametrize("lift", [1e-245, 1e-20])
def test_a_leap_of_nothing_on_a_rough_track_ends_in_rolling(lift):
    """It comes down before double precision sees it rise; the impact takes the slip: a disc keeps a third of its spin
    and two thirds of its speed (from angular momentum about the contact)."""
    case = on_a_slope(1e-6, (PerfectlyRough(),), 0.0343, "poisson", 0.0, lift, 0.3, -1e-230, 1.0)
    second = second_states.motion(case, until=1e-9)
    for answer in (*(reference.simulate(case, method=m) for m in METHODS), second):
        assert (answer.status, [t.after for t in answer.transitions]) == ("completed", [Mode.ROLL])
    assert float(reference.simulate(case)(1e-9).vx) == pytest.approx(0.2, rel=1e-7)
    assert second.last.motion[3] == pytest.approx(0.2, rel=1e-7)


@pytest.mark.slow
@settings(max_examples=1000, **UNHURRIED)
@given(bowls | slopes)
def test_both_formulations_begin_alike_in_a_thousand_scenes_of_any_duration(case):
    check(case)
