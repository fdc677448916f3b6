"""Typical mistakes of exported motions: `reports.compare` names each, whether it judges the file or rejects it."""

import numpy as np
import pandas as pd
import pytest

import cases
import reference
from reports import compare
from tests.sampling import quick_every

CASE = "disc_in_circle[mu=0.2]"
STEP = 2e-3
POSES, RATES = ("x", "y", "theta"), ("vx", "vy", "omega")


@pytest.fixture(scope="module")
def truth():
    return reference.simulate(cases.load(CASE), rtol=1e-12)


def table(truth, t=None, at=None) -> pd.DataFrame:
    """Columns of the true motion at the times `at`, written with the times `t`."""
    t = np.arange(0.0, truth.t[-1], STEP) if t is None else t
    state = truth(np.clip(t if at is None else at, 0.0, truth.t[-1]))
    names = (*POSES, *RATES, "slip", "normal_force", "friction_force")
    return pd.DataFrame({"t": t, **{name: np.asarray(getattr(state, name)) for name in names}})


def poses_only(frame):
    return frame[["t", *POSES]]


def late(names, seconds):
    """The columns are those of an earlier time."""

    def spoil(truth):
        frame = table(truth)
        other = table(truth, at=frame.t.to_numpy() - seconds)
        return frame.assign(**{name: other[name] for name in names})

    return spoil


def times(factor, *names, keep=None):
    """The columns are multiplied by the factor; only those in `keep` are written."""

    def spoil(truth):
        frame = table(truth).assign(**{name: factor * table(truth)[name] for name in names})
        return frame if keep is None else frame[["t", *keep]]

    return spoil


def plus(value, *names, keep=(*POSES, *RATES)):
    """A constant is added to the columns."""

    def spoil(truth):
        frame = table(truth)
        return frame.assign(**{name: frame[name] + value for name in names})[["t", *keep]]

    return spoil


def body_frame(truth):
    frame = table(truth)
    c, s = np.cos(frame.theta), np.sin(frame.theta)
    return frame.assign(vx=c * frame.vx + s * frame.vy, vy=c * frame.vy - s * frame.vx).drop(columns="slip")


def wrapped(truth):
    frame = poses_only(table(truth))
    return frame.assign(theta=(frame.theta + np.pi) % (2 * np.pi) - np.pi)


def turned(angle):
    def spoil(truth):
        frame = poses_only(table(truth))
        x, y = np.cos(angle) * frame.x - np.sin(angle) * frame.y, np.sin(angle) * frame.x + np.cos(angle) * frame.y
        return frame.assign(x=x, y=y)

    return spoil


def at_the_contact(truth):
    frame = poses_only(table(truth))
    size = np.hypot(frame.x, frame.y)
    return frame.assign(x=frame.x / size, y=frame.y / size)


def point_of_the_plate(truth):
    frame = poses_only(table(truth))
    return frame.assign(x=frame.x + 0.02 * np.cos(frame.theta), y=frame.y + 0.02 * np.sin(frame.theta))


def slow_clock(truth):
    t = np.arange(0.0, truth.t[-1], STEP)
    return poses_only(table(truth, t, at=t / 1.02))


def centres_speed(truth):
    frame = table(truth)
    return frame.assign(slip=np.hypot(frame.vx, frame.vy))


def exchanged(truth):
    return poses_only(table(truth)).rename(columns={"x": "y", "y": "x"})


def four_decimals(truth):
    return poses_only(table(truth)).round(dict.fromkeys(POSES, 4))


# A name, the spoiled table, and what the text or the message must say.
MISTAKES = {
    "x and y in millimetres": (times(1e3, "x", "y", keep=POSES), "x and y seem to be in millimetres"),
    "time in milliseconds": (times(1e3, "t", keep=POSES), "t seems to be in milliseconds"),
    "theta in degrees": (times(180 / np.pi, "theta", keep=POSES), "theta seems to be in degrees"),
    "theta in turns": (times(0.5 / np.pi, "theta", keep=POSES), "theta seems to be in turns"),
    "x mirrored": (times(-1.0, "x", keep=POSES), "x seems to be mirrored"),
    "y down": (times(-1.0, "y", keep=POSES), "y seems to be mirrored"),
    "y down, theta clockwise": (times(-1.0, "y", "theta", keep=POSES), "y and theta seem to be mirrored"),
    "theta clockwise": (times(-1.0, "theta", keep=POSES), "theta seems to be mirrored"),
    "x and y exchanged": (exchanged, "x and y seem to be exchanged"),
    "wrapped theta": (wrapped, "theta seems to jump by whole turns"),
    "theta with an offset": (plus(0.5, "theta"), "theta seems to have the constant offset 0.5 rad"),
    "theta with a small offset": (plus(4e-3, "theta"), "theta seems to have the constant offset 0.004 rad"),
    "poses 5 ms late": (late(POSES, 5e-3), "the poses seem to be 0.005"),
    "everything 5 ms late": (late((*POSES, *RATES, "slip"), 5e-3), "the poses seem to be 0.005"),
    "poses a step early": (late(POSES, -STEP), "the poses seem to be 0.002 s early"),
    "a late start": (lambda truth: table(truth).iloc[20:], "the first time is 0.04 s"),
    "a clock 2 % slow": (slow_clock, "the time seems to run 1.96 % slow"),
    "frame moved by 0.7 mm": (plus(7e-4, "x"), "the frame seems to be moved by (0.0007,"),
    "frame moved by half a metre": (plus(0.5, "y"), "the frame seems to be moved by"),
    "frame turned": (turned(0.3), "the frame seems to be turned by 17.19 degrees"),
    "the contact point": (at_the_contact, "that of the contact point"),
    "another point of the plate": (point_of_the_plate, "that of the plate's point (0.02,"),
    "four decimals": (four_decimals, "rounded to 4 decimals"),
    "velocities half a step early": (late(RATES, 0.5 * STEP), "half a step before the poses"),
    "velocities half a step ahead": (late(RATES, -0.5 * STEP), "half a step after the poses"),
    "velocities 5 ms late": (late(RATES, 5e-3), "steps (0.005 s) before the poses"),
    "velocities in the plate's frame": (body_frame, "components in the plate's frame"),
    "omega of the other sign": (times(-1.0, "omega"), "omega seems to be of the other sign"),
    "omega in degrees": (times(180 / np.pi, "omega"), "omega seems to be in degrees per second"),
    "omega in turns per minute": (times(30 / np.pi, "omega"), "omega seems to be in turns per minute"),
    "velocities in millimetres": (times(1e3, "vx", "vy"), "vx seems to be in millimetres"),
    "vy downwards": (times(-1.0, "vy"), "vy seems to be of the other sign"),
    "slip half a step early": (late(["slip"], STEP / 2), "slip seems to belong to times half a step before the poses"),
    "slip half a step ahead": (late(["slip"], -STEP / 2), "slip seems to belong to times half a step after the poses"),
    "slip of the other sign": (times(-1.0, "slip"), "slip seems to be of the other sign"),
    "slip in millimetres": (times(1e3, "slip"), "slip seems to be in millimetres"),
    "the centre's speed as slip": (centres_speed, "the speed of the centre"),
    "normal force downwards": (times(-1.0, "normal_force"), "the track pulls"),
    "friction of the other sign": (times(-1.0, "friction_force"), "friction drives the slip"),
}  # fmt: skip


def said(frame, tmp_path, capsys) -> str:
    """All that the command prints, on one of its two outputs."""
    file = tmp_path / "motion.csv"
    frame.to_csv(file, index=False)
    status = compare.main([CASE, str(file)])
    out = capsys.readouterr()
    assert (status, bool(out.out), bool(out.err)) in ((0, True, False), (2, False, True))
    assert status == 0 or out.err.count("\n") == 1
    return out.out + out.err


@quick_every(15)
@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_typical_mistake_is_named(mistake, truth, tmp_path, capsys):
    spoil, words = MISTAKES[mistake]
    assert words in said(spoil(truth), tmp_path, capsys)


@quick_every(3)
@pytest.mark.parametrize("columns", [("t", *POSES), ("t", *POSES, *RATES), ("t", *POSES, *RATES, "slip")])
def test_a_true_motion_is_accused_of_no_mistake(columns, truth, tmp_path, capsys):
    text = said(table(truth)[list(columns)], tmp_path, capsys)
    assert "seem" not in text


def test_a_constant_offset_is_not_called_another_unit(truth, tmp_path, capsys):
    for offset in (1.0, -2.0):
        text = said(plus(offset, "theta")(truth), tmp_path, capsys)
        assert "radians" not in text and "degrees" not in text and f"offset {offset:g} rad" in text


def test_friction_of_another_strength_is_no_mistake_of_the_export(tmp_path, capsys):
    motion = reference.simulate(cases.load("disc_in_circle[mu=0.15]"))
    text = said(table(motion)[["t", *POSES, *RATES]], tmp_path, capsys)
    assert "seem" not in text
