"""Where motions of the second formulation end early: at once, or when their work is used up."""

import re
from math import pi

import numpy as np
import pytest

import cases
import reference
from cases import Case, CoulombFriction, Flight, Gravity, Impact, Load, NotSupported, Plate, Start, Unilateral, disc
from cases.library import circle, ellipse, hill, line
from reference.witness import steps
from tests.sampling import quick_every
from tests.scenes import second as second_states

GRIP = (Gravity(9.81), Unilateral())
SLENDER = Plate(ellipse(0.3, 0.05), 1.0, 0.02)


def gains_energy() -> Case:
    effects = (*GRIP, Flight(), CoulombFriction(0.76), Impact(0.94, "newton"))
    return Case(line(), SLENDER, effects, Start(0.0, -2.9, slip=0.96, omega=-0.14, gap_rate=-2.7), 0.1)


def too_fast_for_its_hill() -> Case:
    return Case(hill(1.0), disc(0.1, 1.0), (*GRIP, CoulombFriction(0.3)), Start(0.0, omega=-100.0), 1.0)


@pytest.mark.parametrize(
    "make, status", [(gains_energy, "energy_gain"), (too_fast_for_its_hill, "lift_off")], ids=["gains", "leaves"]
)
def test_a_motion_that_ends_at_once_has_the_state_of_its_start(make, status):
    motion, answer = reference.simulate(make()), second_states.solve(make(), times=[0.0, 0.05])
    assert motion.status == answer.status == status
    assert answer.end == motion.t[-1] == 0.0 and answer.transitions == motion.transitions == ()
    begin = [getattr(motion, name)[0] for name in second_states.MOTION]
    assert answer.motions[:, 0] == pytest.approx(begin, abs=1e-14, nan_ok=True)
    assert np.isnan(answer.motions[:, 1]).all()


SCENES = {
    "contact": cases.load("disc_in_circle", mu=0.2, duration=100.0),
    "flight": Case(
        circle(9.0), disc(0.1, 1.0), (Unilateral(), Flight(), Load("sin(t)", "cos(2*t)")),
        Start(0.0, gap=0.5, slip=1.0), 1000.0,
    ),
    "hops": Case(line(), disc(0.1, 1.0), (*GRIP, Flight(), Impact(1.0)), Start(0.0, gap_rate=1e-6), 1000.0),
}  # fmt: skip


@pytest.mark.parametrize("name", SCENES)
def test_work_is_bounded_and_what_was_done_is_the_motions_beginning(name, monkeypatch):
    case = SCENES[name]
    monkeypatch.setattr(steps, "MOST_WORK", 20)
    short = second_states.motion(case)
    assert short.status == "unfinished" and 0.0 < short.end < case.duration
    monkeypatch.undo()
    whole = second_states.motion(case, until=1.1 * short.end)  # the first step of the last hop fits in
    assert whole.status == "completed"
    assert [t for t in whole.transitions if t.time <= short.end] == list(short.transitions)
    there = second_states.motion(case, until=short.end).last.motion[:6]
    # A hop may end there: before and after its impact, with restitution 1, speeds have the same size.
    assert np.abs(short.last.motion[:6]) == pytest.approx(np.abs(there), rel=1e-9, abs=1e-9)


def on_line(*effects, **start) -> Case:
    return Case(line(), disc(0.1, 2.0), (*GRIP, *effects), Start(0.0, **start), 2.0)


RING = Plate(ellipse(0.2, 0.1), 1.0, 0.0125)
# Where no double holds the motion any more, and the time (s).
BEYOND = {
    "spin": (Case(circle(1.0), RING, (*GRIP, Flight(), Impact(0.5)), Start(-0.5, 0.3, omega=1e30), 2.0), 0.0),
    "root": (on_line(Load(fx="sqrt(1 - t)")), 1.0),
    "root in flight": (on_line(Flight(), Load(fy="-sqrt(0.1 - t)"), gap=0.5), 0.1),
    "pole": (on_line(Load(fx="1/(1 - t)")), 1.0),
    "double pole": (on_line(CoulombFriction(0.3), Load(fx="1/(t - 1)**2")), 1.0),
    "pole of a tangent": (on_line(Load(fx="tan(3*t)")), pi / 6),
}


def end_of(case: Case) -> tuple[str, float]:
    """The status of a motion, or the sentence with which it ends, and the time."""
    try:
        answer = second_states.motion(case)
    except FloatingPointError as problem:
        time = re.search(r"t = (\S+) s", str(problem))
        return str(problem), float(time[1]) if time else np.nan
    return answer.status, answer.end


@quick_every(3, first=1)
@pytest.mark.parametrize("name", BEYOND)
def test_what_no_double_holds_ends_in_one_sentence_at_its_time(name):
    sentence, end = end_of(BEYOND[name][0])
    assert sentence == "breakdown" or "\n" not in sentence and len(sentence) > 30
    assert end == pytest.approx(BEYOND[name][1], abs=1e-6)


def test_a_side_on_a_track_with_corners_is_refused_and_not_ended():
    """It once ended as second_contact at 9 µs, where the first formulation goes on: the case had no certificate."""
    with pytest.raises(NotSupported, match="a curve has corners"):
        second_states.motion(cases.load("box_over_seams"))
