"""No verdict can be had by leaving out, jumping away or writing no numbers; the reference's own file breaks no law."""

from dataclasses import replace

import numpy as np
import pytest

import cases
import reference
from adapters.common import motion_file, motion_table
from cases import Mode, State, Transition
from reports.judging import residuals
from reports.running.records import Run
from tests.reports.test_compare import FULL, table
from tests.reports.test_tasks import bowling, line, performed  # noqa: F401 - a fixture


def changed(motion, **columns):
    """The motion with some of its samples changed by index."""
    values = {name: np.array(getattr(motion, name), dtype=float) for name in ("t", *State._fields)}
    for name, (where, value) in columns.items():
        values[name][where] = value
    return type(motion)(**values)


def teleported(case):
    motion = bowling(case)
    return changed(motion, x=(150, motion.x[150] + 5.0))


def gone(case):
    """It leaves for a place a metre off, little by little: no jump, and no way the truth went."""
    motion = bowling(case)
    return replace(motion, y=motion.y + 30.0 * motion.t)


def begun_late(case):
    motion = bowling(case, samples=3000)
    kept = motion.t >= 0.11
    return type(motion)(**{name: getattr(motion, name)[kept] for name in ("t", *State._fields)})


def with_a_hole(case):
    motion = bowling(case, samples=3000)
    kept = (motion.t < 0.5 * motion.t[-1]) | (motion.t > 0.6 * motion.t[-1])
    return type(motion)(**{name: getattr(motion, name)[kept] for name in ("t", *State._fields)})


def with_transition_at(time: float):
    def read(case):
        event = Transition(time, Mode.SLIP_FORWARD, Mode.ROLL)
        return replace(bowling(case), transitions=(event,), first_mode=Mode.SLIP_FORWARD)

    return read


@pytest.mark.parametrize(
    "read, outcome, reason",
    [
        (teleported, "answered", "jumps by 5 m"),
        (gone, "answered", "strays"),
        (begun_late, "answered", "begins at 0.11"),
        (with_a_hole, "answered", "has no samples between"),
        (lambda case: bowling(case, last=0.6), "answered", "ends at"),
        (lambda case: changed(bowling(case), x=(7, 1e300)), "crashed", "beyond all sizes"),
        (lambda case: changed(bowling(case), slip=(7, np.inf)), "crashed", "not finite"),
        (lambda case: changed(bowling(case), t=(7, 0.0)), "crashed", "times that do not grow"),
        (with_transition_at(np.nan), "crashed", "transition's time is nan"),
    ],
)
def test_a_motion_that_is_not_whole_is_never_excellent(monkeypatch, line, read, outcome, reason):  # noqa: F811
    run: Run = performed(monkeypatch, line, read)
    assert run.outcome == outcome and reason in run.reason
    assert run.grade in (("rough", "poor", "unusable") if outcome == "answered" else ("",)), run.score


def test_the_same_motions_untouched_are_excellent(monkeypatch, line):  # noqa: F811
    time = 1.0 / (3 * 0.1 * 9.81)
    for read in (bowling, with_transition_at(time), lambda case: bowling(case, samples=3000)):
        assert performed(monkeypatch, line, read).grade == "excellent"


def accusations(case, folder) -> list[str]:
    """What the reference's own motion, written to a file with all digits and read back, is accused of."""
    table(FULL, reference.simulate(case, rtol=1e-12), samples=1501).to_csv(folder / "own.csv", index=False)
    output = motion_file.trajectory_of(case, motion_table.read(folder / "own.csv"))
    gap = motion_file.follow_contact(case, {name: getattr(output, name) for name in motion_table.REQUIRED_COLUMNS})[2]
    return residuals.broken_laws(case, output, gap)


# At rest, without weight, at constant speed, on its way: all that a residual can be small beside.
SCENES = {
    "at rest": dict(start=cases.Start(0.0)),
    "without weight": dict(effects=(cases.CoulombFriction(0.3),), start=cases.Start(0.0, slip=1.0)),
    "rolling evenly": dict(start=cases.Start(0.0, omega=-2.0)),
    "slowly": dict(start=cases.Start(0.0, slip=1e-9)),
    "at rest on a slope": dict(
        track=cases.library.line(0.1), effects=(cases.Gravity(9.81), cases.CoulombFriction(0.3))
    ),
}


@pytest.mark.parametrize("name", SCENES)
def test_a_motion_of_nothing_but_rounding_breaks_no_law(tmp_path, name):
    given = dict(
        track=cases.library.line(0.0),
        plate=cases.disc(0.1, 1.0),
        effects=(cases.Gravity(9.81), cases.CoulombFriction(0.3), cases.Unilateral()),
        duration=1.0,
        start=cases.Start(0.0),
    )
    assert accusations(cases.Case(**(given | SCENES[name])), tmp_path) == []


@pytest.mark.slow
def test_no_exact_file_of_the_catalogue_is_accused(tmp_path):
    accused = {}
    for name in cases.names(hard=False):
        case = cases.select(name)[-1]
        if case.effect(cases.Flight) is None and accusations(case, tmp_path):
            accused[case.label] = accusations(case, tmp_path)
    assert accused == {}
