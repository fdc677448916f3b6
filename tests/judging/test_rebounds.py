"""The restitution of each impact as rows, next to the truth's: by gravity, under a load, and on a track that moves."""

from __future__ import annotations

import numpy as np
import pytest

import cases
import reference
from adapters import Setting, pymunk
from cases import Case, CoulombFriction, Drive, Flight, Gravity, Impact, Load, Mode, Start, Trajectory, Unilateral, disc
from cases.library import line
from reports.judging import impacts
from reports.judging.ledger import LedgerRow
from reports.running.records import Run
from reports.running.tasks import find_truth, judge
from reports.running.true_motions import true_motion

LAW = 0.6
# What gives the plate a push besides gravity: a gust that changes within a flight, and a track that shakes and turns.
EFFECTS = {
    "gravity": (),
    "load": (Load(fx="0.5*sin(9*t)", fy="3*sin(15*t)", moment="0.01*cos(5*t)"),),
    "drive": (Drive(x="0.01*sin(6*t)", y="0.02*sin(11*t)", angle="0.05*sin(4*t)"),),
}


def thrown(name: str, e: float = LAW) -> Case:
    effects = (Gravity(9.81), CoulombFriction(0.3), Unilateral(), Flight(), Impact(e), *EFFECTS[name])
    return Case(line(0.0), disc(0.1, 1.0), effects, Start(0.0, gap=0.3, slip=0.4), 0.9, name=f"thrown_by_{name}")


@pytest.mark.parametrize("name", EFFECTS)
@pytest.mark.parametrize("e", [LAW, 0.3])
def test_each_impact_shows_its_restitution(name, e):
    # Under a load or a drive there was none; with poses only it was 1.9 to 2.8 for a law of 0.5.
    motion = reference.simulate(thrown(name, e))
    bounces = [event.time for event in motion.transitions if event.cause == "impact"]
    own = impacts.rebounds(thrown(name, e), motion, tuple(motion.transitions))
    count = min(len(own), len(bounces))  # one without a sample in flight on both sides is omitted
    assert count >= 2 and [one.time for one in own][:count] == bounces[:count]
    # Samples of a dense motion are 0.2 ms apart: a load changes by 1 % in that, and later flights last for a few.
    assert [one.restitution for one in own[:2]] == pytest.approx([e, e], rel=1e-3)


@pytest.mark.parametrize("name", EFFECTS)
def test_rows_have_the_restitution_of_both(name):
    case = thrown(name)
    truth = find_truth(case)
    motion = true_motion(case, truth.method)
    other = reference.simulate(thrown(name, 0.5))
    t = np.linspace(0.0, other.t[-1], 4001)
    row = Run(case.label, "one", "", Setting.of(), 0, outcome="")
    run = judge(row, case, Trajectory(t=t, **other(t)._asdict()), motion, truth)
    first = run.impacts[0]
    assert first.closing == pytest.approx(first.reference_closing, rel=1e-3)
    assert (first.restitution, first.reference_restitution) == pytest.approx((0.5, LAW), rel=2e-3)
    assert [one.event for one in run.impacts] == list(range(1, len(run.impacts) + 1))
    assert [one.reference_normal for one in run.impulses] == [one.normal for one in motion.impacts]
    hit = run.impulses[0]
    if name == "drive":  # no velocities against the track
        assert np.isnan(hit.normal)
    else:
        # Closing at the same speed, impulses are as 1 + e; samples are 0.2 ms apart.
        assert hit.normal / hit.reference_normal == pytest.approx(1.5 / (1.0 + LAW), rel=2e-3)
        assert hit.friction == pytest.approx(-0.3 * hit.normal, rel=2e-3) or hit.friction == pytest.approx(
            hit.reference_friction, rel=2e-3
        )


def test_an_impact_whose_landing_has_another_mode_has_its_impulses():
    """A slip of 6 µs that only the solver has after the landing is no other landing."""
    case = cases.load("disc_onto_incline")
    motion = reference.simulate(case)
    (exact,) = motion.impacts
    t = np.linspace(0.0, motion.t[-1], 4001)
    events = [
        LedgerRow(1, Mode.FLIGHT, Mode.ROLL, np.nan, exact.time, np.nan, "unresolved"),
        LedgerRow(1, Mode.FLIGHT, Mode.SLIP_FORWARD, exact.time, np.nan, np.nan, "unresolved"),
    ]
    (own,) = impacts.impulses(case, Trajectory(t=t, **motion(t)._asdict()), motion, events)
    assert own.normal == pytest.approx(exact.normal, rel=1e-2)
    (none,) = impacts.impulses(case, Trajectory(t=t, **motion(t)._asdict()), motion, events[:1])
    assert np.isnan(none.normal) and none.reference_normal == exact.normal


def test_the_reference_has_its_own_impulses():
    case = cases.load("bouncing_disc")
    truth = find_truth(case)
    motion, coarse = true_motion(case, truth.method), reference.simulate(case, rtol=1e-6)
    run = judge(Run(case.label, "one", "", Setting.of(), 0, outcome=""), case, coarse, motion, truth)
    own, listed = [one.normal for one in run.impulses], [e for e in coarse.transitions if e.cause == "impact"]
    # The last impact of a spell of bouncing is no transition.
    assert own[: len(listed)] == [one.normal for one in coarse.impacts[: len(listed)]] and len(listed) > 8


def test_impulses_from_velocities_are_the_engines_own():
    """Where a disc touches in impacts only, what pymunk's contacts have done between two samples is the impulse of its
    velocities."""
    case = cases.load("rebound_with_spin")
    truth = find_truth(case)
    setting = pymunk.ladder(case, "native")[2]
    model, own = pymunk.build(case, "native", setting), list[tuple[float, float]]()
    if not hasattr(model.space, "on_collision"):
        pytest.skip("pymunk before 7 has no on_collision")
    model.space.on_collision(post_solve=lambda arbiter, *_: own.append(arbiter.total_impulse))
    pymunk.run(model)
    row = Run(case.label, "pymunk", "native", setting, 2, outcome="")
    run = judge(row, case, pymunk.read(model), true_motion(case, truth.method), truth)
    read = [(one.friction, one.normal) for one in run.impulses]
    assert len(read) == 2 and np.array(read) == pytest.approx(np.array(own), rel=1e-9, abs=1e-12)
    assert read[0][1] != pytest.approx(run.impulses[0].reference_normal, rel=1e-3)
