"""The verdict on motions whose fault is known, as a table: a fault, the bounds of off, and the grade or its reason.

Each row failed on version 0.2.0 in the way that its comment says, unless it has none.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import pandas as pd
import pytest

import cases
import reference
from adapters import Setting
from adapters.common import motion_table
from cases import Case, CoulombFriction, Flight, Impact, Trajectory
from reports.judging.grades import LIMITS, Grade, is_within
from reports.judging.null_motions import with_friction
from reports.running.external_motions import judge_motion, of_table
from reports.running.records import Run, Truth
from reports.running.tasks import find_truth, judge
from reports.running.true_motions import true_motion

ALL = ("x", "y", "theta", "vx", "vy", "omega", "slip", "normal_force", "friction_force")
RATES, POSES = ALL[:6], ALL[:3]
Columns = dict[str, np.ndarray]


@lru_cache(maxsize=8)
def truth_of(case: Case) -> tuple[Truth, Trajectory]:
    truth = find_truth(case)
    assert not truth.failure
    return truth, true_motion(case, truth.method)


def judgement(case: Case, hertz: float, names=ALL, fault: Callable[[Columns], Columns] | None = None) -> Run:
    """The judgement of the true motion at so many samples a second, with some columns and a fault."""
    truth, motion = truth_of(case)
    last = float(motion.t[-1])
    t = np.append(np.arange(0.0, last, 1.0 / hertz), last)
    state = motion(t)
    columns = {"t": t} | {name: np.asarray(getattr(state, name)) for name in names}
    columns = fault(columns) if fault else columns
    table = motion_table.parse(pd.DataFrame(columns).to_csv(index=False), "motion.csv")
    return judge_motion(of_table("file", case, table), 1, truth)


# --- faults -----------------------------------------------------------------------------------------------------------


def skin(columns: Columns, begin: float = 0.0) -> Columns:
    """An exact roll 5 mm above its ramp, as a skin leaves it: 5 % of the disc's radius."""
    after = columns["t"] > begin
    return columns | {"x": columns["x"] + 5e-3 * np.sin(0.2) * after, "y": columns["y"] + 5e-3 * np.cos(0.2) * after}


def skin_at_start(columns: Columns) -> Columns:
    """The same from the first pose on."""
    return skin(columns, begin=-1.0)


def drift(columns: Columns) -> Columns:
    """A plate that sinks by 0.2 µm although its velocity says that it does not."""
    return columns | {"y": columns["y"] - 2e-7 * columns["t"] / columns["t"][-1]}


def reversal(columns: Columns) -> Columns:
    """Friction that changes its direction every second step."""
    sign = (-1.0) ** np.arange(len(columns["t"]))
    return columns | {"vx": columns["vx"] + 0.02 * sign, "omega": columns["omega"] + 0.2 * sign}


def correction(columns: Columns) -> Columns:
    """Poses that are pushed up and sink again, with velocities that know nothing of it."""
    up = 1e-3 * (np.arange(len(columns["t"])) % 3 - 1.0) * (columns["t"] > 0.0)
    return columns | {"y": columns["y"] + up}


def tip(columns: Columns) -> Columns:
    """A box that tips by 2.9 degrees from 0.2 to 0.5 s, and back."""
    return columns | {"theta": columns["theta"] + 0.05 * np.sin(np.pi * np.clip((columns["t"] - 0.2) / 0.3, 0.0, 1.0))}


def other_forces(columns: Columns) -> Columns:
    """Forces that vanish in the middle of a roll that its velocities show."""
    away = (columns["t"] > 0.1) & (columns["t"] < 0.5)
    return columns | {name: np.where(away, 0.0, 3.0 * columns[name]) for name in ("normal_force", "friction_force")}


def rounding(columns: Columns) -> Columns:
    """A constant offset of 6e-17 rad."""
    return columns | {"theta": columns["theta"] + 6e-17}


@dataclass(frozen=True)
class Row:
    """A fault of an exported motion, the bounds of its off, a word of its reason and words that it must not have."""

    name: str
    scene: str | Case
    fault: Callable[[Columns], Columns]
    names: tuple[str, ...]
    low: float
    high: float
    phrase: str = ""
    absent: tuple[str, ...] = ("seem",)


INCLINE, LINE, BOX = "disc_on_incline[slope=0.2]", "disc_on_line[mu=0.1]", "sliding_box"
_ROLL = cases.select(INCLINE)[0]
FREE = replace(_ROLL, effects=(*_ROLL.effects, Flight(), Impact(0.0)), name="free_disc_on_incline")
ROWS = (
    Row("5 mm above", INCLINE, skin, RATES, 0.02, 0.05),  # "ends at 0.0167 s", 500 % off
    Row("5 mm above, with slip", INCLINE, skin, ALL, 0.01, 0.04),  # the same
    # "the centre of mass starts at", and of a plate that may fly a flight from the start: 100 % off.
    Row("5 mm above from the start", INCLINE, skin_at_start, RATES, 0.02, 0.05, "frame seems to be moved", ()),
    Row("5 mm above, may fly", FREE, skin, RATES, 0.02, 0.05),
    Row("5 mm above, may fly, with forces", FREE, skin, ALL, 0.01, 0.04),
    Row("5 mm above, may fly, poses only", FREE, skin_at_start, POSES, 0.02, 0.05, absent=()),
    Row("drift of 0.2 µm", BOX, drift, RATES, 0.0, 1e-4),
    Row(
        "corrected poses", LINE, correction, ALL, 0.0, 0.02, absent=("metres, radians",)
    ),  # "give both in metres, radians and seconds"
    Row("reversed friction", LINE, reversal, RATES, 0.0, 0.1),
    Row("tips", BOX, tip, RATES, 0.0, 1.0, "turns by up to 2.9 degrees between 0.2", ("seem",)),  # "in degrees"
    Row("other forces", LINE, other_forces, ALL, 0.0, 1e-4, "its forces do not make its motion"),
    Row("other forces, may fly", FREE, other_forces, ALL, 0.0, 1e-4, "its forces do not make its motion"),
    Row("6e-17 rad", BOX, rounding, RATES, 0.0, 1e-4),  # "theta seems to have the constant offset"
)


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.name)
def test_a_fault_is_judged_by_its_size(row):
    case = cases.select(row.scene)[0] if isinstance(row.scene, str) else row.scene
    run = judgement(case, 100.0, row.names, row.fault)
    assert run.score is not None, run.reason
    assert row.low <= run.score.off <= row.high, run.reason
    assert row.phrase in run.reason and not any(word in run.reason for word in row.absent), run.reason


# --- three values -----------------------------------------------------------------------------------------------------

SCENES = ("disc_in_circle[mu=0.2]", "bouncing_disc[e=0.5]", "ellipse_on_line[mu=0.05]", "disc_rolling_to_rest")


@pytest.mark.parametrize("label", SCENES)
@pytest.mark.parametrize("hertz", [60.0, 100.0, 1000.0])
def test_the_truth_is_never_worse_than_not_decided(label, hertz):
    # Without forces the bouncing disc was 2 % off at 100 Hz, with two transitions that the truth does not have.
    case = cases.select(label)[0]
    for names in (ALL, RATES, POSES):
        run = judgement(case, hertz, names)
        assert run.score is not None and run.grade in ("excellent", "not decided"), (names, run.reason)
        assert is_within(run.score, LIMITS[Grade.EXCELLENT]) is not False, (names, run.reason)
        assert not [row for row in run.ledger if row.pairing == "spurious"], names
        assert "its forces" not in run.reason, names


@pytest.mark.parametrize("samples", [2, 5, 11])
def test_few_samples_decide_nothing(samples):
    # Five were "excellent ± 280 %".
    case = cases.load("disc_in_circle", mu=0.2)
    truth, motion = truth_of(case)
    t = np.linspace(0.0, motion.t[-1], samples)
    few = Trajectory(t=t, **motion(t)._asdict())
    run = judge(Run(case.label, "one", "", Setting.of(), 0, outcome=""), case, few, motion, truth)
    assert run.grade == "not decided" and "give more of them" in run.reason


def test_a_file_has_fifty_lines_in_its_case_s_duration():
    case = cases.load("disc_on_line", mu=0.1)
    with pytest.raises(cases.DoesNotFit, match="give at least 50"):
        judgement(case, 48.0 / case.duration)
    assert judgement(case, 60.0 / case.duration).score is not None


# --- creep, and transitions with names -------------------------------------------------------------------------------


def with_creep(motion: Trajectory, scale, speed: float) -> Trajectory:
    """The motion with a creep where the truth rolls."""
    t = np.linspace(0.0, motion.t[-1], 2001)
    columns = motion(t)._asdict()
    for phase in scale.phases:
        if phase.mode is cases.Mode.ROLL:
            columns["slip"] = columns["slip"] + speed * ((t >= phase.begin) & (t <= phase.end))
    return Trajectory(t=t, **columns)


@pytest.mark.parametrize("speed", [0.0199, 0.0201, 0.05])
def test_creep_counts_by_its_size(speed):
    # 0.0199 m/s was 1.33 % off, 0.0201 m/s 100 %; with the truth's transitions with_events 0.05 m/s was 3.3 %.
    case = cases.load("disc_on_line", mu=0.1)
    truth, motion = truth_of(case)
    assert truth.scale is not None
    row, sampled = Run(case.label, "one", "", Setting.of(), 0, outcome=""), with_creep(motion, truth.scale, speed)
    rolls = sum(phase.duration for phase in truth.scale.phases if phase.mode is cases.Mode.ROLL)
    size = speed * rolls / case.duration / truth.scale.slip
    with_events = replace(sampled, first_mode=truth.first_mode, transitions=truth.transitions)
    for one in (sampled, with_events):
        run = judge(row, case, one, motion, truth)
        assert run.score is not None and run.score.off == pytest.approx(size, rel=0.01), run.reason


@pytest.mark.parametrize("label", ["disc_on_line[mu=0.1]", "disc_in_circle[mu=0.2]"])
def test_creep_counts_continuously(label):
    # Above half of the truth's fastest slip it jumped: from 33 to 100 % on the line.
    case = cases.select(label)[0]
    truth, motion = truth_of(case)
    assert truth.scale is not None
    row, step = Run(case.label, "one", "", Setting.of(), 0, outcome=""), 0.05
    offs = []
    for share in np.arange(0.3, 1.25, step):
        sampled = with_creep(motion, truth.scale, share * truth.scale.fastest_slip)
        run = judge(row, case, sampled, motion, truth)
        assert run.score is not None
        offs.append(run.score.off)
    # The steepest part is what a reading adds: 1 over half of the fastest slip.
    assert np.all(np.diff(offs) >= -1e-9) and max(np.diff(offs)) <= 2.0 * step + 1e-6, offs


def test_a_motion_has_one_score_dense_or_sampled():
    # 1 % less friction slips at all times, by less than its creep could be: 100 % off dense, 0.47 % sampled.
    case = cases.load("disc_on_incline", slope=0.29)
    truth, motion = truth_of(case)
    friction = case.effect(CoulombFriction)
    assert friction is not None
    other = reference.simulate(with_friction(case, mu=0.99 * friction.mu))
    t = np.linspace(0.0, other.t[-1], 2001)
    row = Run(case.label, "one", "", Setting.of(), 0, outcome="")
    offs = [
        run.score.off
        for one in (other, Trajectory(t=t, **other(t)._asdict()))
        if (run := judge(row, case, one, motion, truth)).score
    ]
    assert offs == pytest.approx([0.00473, 0.00473], rel=0.01)


@pytest.mark.parametrize("share", [1.0, 0.9])
def test_friction_of_a_box_is_its_share_of_the_law_s(share):
    # There was none with two contacts.
    case = cases.load("sliding_box")
    truth, motion = truth_of(case)
    friction = case.effect(CoulombFriction)
    assert friction is not None
    other = reference.simulate(with_friction(case, mu=share * friction.mu))
    run = judge(Run(case.label, "one", "", Setting.of(), 0, outcome=""), case, other, motion, truth)
    assert run.friction_factor == pytest.approx(share, rel=1e-3)
