"""A trajectory from a file is judged like any solver's; a file that cannot be judged gives one sentence."""

import json
import re

import numpy as np
import pandas as pd
import pytest

import cases
import reference
from adapters.common import motion_file, motion_table
from reports import compare, export
from reports.judging import diagnosis
from tests.adapters.engines import play
from tests.sampling import quick_every
from tests.taylor.conftest import default_method  # noqa: F401 - a fixture

NAME = "disc_in_circle[mu=0.1]"
MOTION = reference.simulate(cases.load(NAME), rtol=1e-12)
FULL = ("t", "x", "y", "theta", "vx", "vy", "omega", "slip", "normal_force", "friction_force")


def table(columns=FULL, motion=MOTION, samples=2501) -> pd.DataFrame:
    t = np.linspace(0.0, motion.t[-1], samples)
    return pd.DataFrame({"t": t, **motion(t)._asdict()})[list(columns)]


def judged(tmp_path, capsys, frame: pd.DataFrame, name: str = NAME) -> tuple[int, str, str]:
    file = tmp_path / "motion.csv"
    frame.to_csv(file, index=False)
    status = compare.main([name, str(file)])
    said = capsys.readouterr()
    return status, said.out, said.err


def ledger(text: str) -> list[list[str]]:
    return [line.split() for line in text.splitlines() if line.strip().endswith(("paired", "missed", "spurious"))]


@pytest.mark.parametrize(("columns", "tolerance"), [(FULL, 1e-8), (FULL[:7], 1e-6), (FULL[:4], 1e-3)])
def test_exported_reference_motion_is_excellent(tmp_path, capsys, columns, tolerance):
    # With poses alone, slip is differentiated: a step of 1 ms at the kink.
    status, text, _ = judged(tmp_path, capsys, table(columns))
    assert status == 0
    assert re.search(rf"{re.escape(NAME)}: off [^;]*: excellent;", text)
    assert "Laws broken\nnone" in text
    law = re.search(r"Friction force in slip: off by (\S+) of μN", text)
    assert law and float(law[1]) < max(10.0 * tolerance, 1e-5)
    rows = ledger(text)
    assert len(rows) == len(MOTION.transitions)
    for row, event in zip(rows, MOTION.transitions, strict=True):
        assert row[-1] == "paired"
        assert float(row[3]) == pytest.approx(event.time, abs=tolerance)


def test_transition_three_percent_late_is_told_with_its_error(tmp_path, capsys):
    first = MOTION.transitions[0].time
    frame = table()
    # The same motion, three percent slower throughout.
    slow = MOTION(frame["t"].to_numpy() / 1.03)
    frame = frame.assign(**{name: getattr(slow, name) for name in ("x", "y", "theta")})
    frame = frame.assign(**{name: getattr(slow, name) / 1.03 for name in ("vx", "vy", "omega", "slip")})
    status, text, _ = judged(tmp_path, capsys, frame)
    assert status == 0
    assert float(ledger(text)[0][5]) == pytest.approx(0.03 * first, rel=1e-6)


def _with(column: str, change):
    def spoil(frame):
        frame[column] = change(frame[column])
        return frame

    return spoil


# Of little friction, so that four percent too much speed is more than what it takes.
FAST = "disc_in_circle[mu=0.01]"


@pytest.mark.parametrize(
    ("spoil", "law"),
    [
        (_with("friction_force", lambda T: 1.2 * T), "friction exceeds its cone"),
        (_with("normal_force", lambda N: N - 5.0), "the track pulls"),
        (_with("friction_force", lambda T: -T), "friction drives the slip"),
        (_with("friction_force", lambda T: 0.5 * T), "the forces do not make the motion: m vx"),
        (_with("normal_force", lambda N: 1.1 * N), "the forces do not make the motion: m vy"),
        (
            lambda frame: frame.drop(columns="slip").assign(
                x=frame.x * (1 + 0.05 * frame.t), y=frame.y * (1 + 0.05 * frame.t)
            ),
            "overlaps",
        ),
        (lambda frame: frame.assign(vx=1.04 * frame.vx, vy=1.04 * frame.vy), "the energy grows"),
    ],
)
def test_broken_law_is_told(tmp_path, capsys, spoil, law):
    name = FAST if "energy" in law else NAME
    frame = table(motion=reference.simulate(cases.load(name), rtol=1e-12))
    status, text, _ = judged(tmp_path, capsys, spoil(frame), name)
    assert status == 0
    assert law in text.partition("Laws broken")[2]


@pytest.mark.parametrize(
    ("spoil", "sentence"),
    [
        (lambda frame: frame.drop(columns=["y", "theta"]), "has no column y, theta"),
        (lambda frame: frame.rename(columns=str.upper), "its first line is 'T,X,Y,THETA,"),
        (lambda frame: frame.assign(t=1e3 * frame.t), "and t in seconds"),
        (_with("slip", lambda slip: 1e3 * slip), "give it so, in m/s, or leave it out"),
        (_with("slip", lambda slip: -slip), "along the track's increasing parameter"),
        (lambda frame: frame.iloc[::-1], "does not increase"),
        (_with("t", lambda t: t.mask(t.index == 7, t[6])), "the time in line 9 of motion.csv does not increase"),
        (lambda frame: frame.iloc[:2], "give at least 3"),
        (lambda frame: frame.iloc[::200], "give at least 48, and t in seconds"),
        (lambda frame: frame.assign(x=-frame.x, vx=-frame.vx), "x is mirrored: give x to the right"),
        (lambda frame: frame.assign(creep=-1.0), "the creep is -1; give a speed in m/s"),
        (_with("x", lambda x: x.mask(x.index == 7)), "x in line 9 of motion.csv is not a finite number"),
        (lambda frame: frame.assign(x=1e3 * frame.x, y=1e3 * frame.y), "give metres"),
        (_with("theta", np.degrees), "radians"),
        (_with("theta", lambda theta: theta + 1.0), "subtract 1 rad, so that it begins as the case does"),
        (_with("omega", lambda omega: -omega), "omega is not the rate of theta"),
        (lambda frame: frame.iloc[100:], "begins at 0"),
        (_with("x", lambda x: x.mask(x.index == 7, 1e300)), "x in line 9 of motion.csv is too large"),
        (lambda frame: frame.reset_index(names=""), "column 1 of motion.csv has no name (an index?)"),
        (lambda frame: frame.reset_index(names="Unnamed: 0"), "column 1 of motion.csv has no name (an index?)"),
    ],
)
def test_unusable_file_is_told_in_one_sentence(tmp_path, capsys, spoil, sentence):
    status, text, error = judged(tmp_path, capsys, spoil(table()))
    assert (status, text) == (2, "")
    assert sentence in error
    assert len(error.splitlines()) == 1


@pytest.mark.parametrize("comments", [0, 3])
def test_a_repeated_line_has_the_number_that_an_editor_gives_it(comments):
    text = "# of the solver\n" * comments + "t,x,y,theta\n0,0,0,0\n1,0,0,0\n1,0,0,0\n"
    with pytest.raises(cases.CaseError, match=f"^line {comments + 4} of motion.csv repeats an earlier line"):
        motion_table.parse(text, "motion.csv")


def creeping(speed: float) -> pd.DataFrame:
    """The motion at a friction of a fifth, which sticks twice, with a slip in stick that is made of creep."""
    frame = table(motion=reference.simulate(cases.load("disc_in_circle[mu=0.2]"), rtol=1e-12))
    sticks = frame.slip.abs() < 1e-9
    return frame.assign(slip=frame.slip + np.where(sticks, speed * np.cos(40 * frame.t), 0.0))


@quick_every(3)
@pytest.mark.parametrize("how", ["option", "column", "comment"])
def test_creep_is_no_slip_declared_or_not(tmp_path, capsys, how):
    frame, name, file = creeping(5e-3), "disc_in_circle[mu=0.2]", tmp_path / "motion.csv"
    status, text, _ = judged(tmp_path, capsys, frame, name)
    assert status == 0 and [row[-1] for row in ledger(text)] == ["paired"] * 4
    assert "Creep where the truth rolls: 0.005 m/s (declared: 0 m/s)" in text
    words = [name, str(file)]
    if how == "option":
        words += ["--creep", "5e-3"]
    elif how == "column":
        frame.assign(creep=5e-3).to_csv(file, index=False)
    else:
        file.write_text("# made by hand\n# creep = 5e-3 m/s\n" + frame.to_csv(index=False))
    assert compare.main(words) == 0
    text = capsys.readouterr().out
    assert [row[-1] for row in ledger(text)] == ["paired"] * 4
    assert "Creep where the truth rolls: 0.005 m/s (declared: 0.005 m/s)" in text


def test_creep_of_a_tenth_of_the_fastest_slip_is_slip(tmp_path, capsys):
    frame = creeping(0.1 * float(np.abs(creeping(0.0).slip).max()))
    status, text, _ = judged(tmp_path, capsys, frame, "disc_in_circle[mu=0.2]")
    assert status == 0 and "spurious" in text


LINE, ROLLS = "disc_on_line[mu=0.1]", "disc_on_incline"
# What a liar, or another convention, makes of a slip column.
LIES = {
    "sign": lambda frame: -frame.slip,
    "millimetres": lambda frame: 1e3 * frame.slip,
    "kilometres": lambda frame: 1e-3 * frame.slip,
    "mirrored spin": lambda frame: 2 * frame.vx - frame.slip,
    "the centre's speed": lambda frame: np.hypot(frame.vx, frame.vy),
    "none below a tenth": lambda frame: frame.slip.where(frame.slip > 0.9 * frame.slip[0], 0.0),
}


@pytest.mark.parametrize("lie", LIES)
@pytest.mark.parametrize("rolling", [20, 200, 1800])
def test_a_slip_of_another_kind_is_refused_however_short_the_sliding(lie, rolling):
    """It slides for 200 samples, and the more of them follow in which it rolls, the less a median of all would see."""
    case = cases.load(LINE)
    exact = reference.simulate(case, rtol=1e-12)
    slides = exact.transitions[0].time
    t = np.unique(np.r_[np.linspace(0, slides, 200), np.linspace(slides, exact.t[-1], rolling)])
    frame = pd.DataFrame({"t": t, **exact(t)._asdict()})[list(FULL)]
    motion_file.trajectory_of(case, frame)
    with pytest.raises(cases.DoesNotFit, match="slip is not the velocity"):
        motion_file.trajectory_of(case, frame.assign(slip=LIES[lie](frame)))


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_slip_at_a_solvers_own_point_of_contact_is_honest_in_rolling(share):
    """A plate that lies deep in its track, or above it, has its contact between the two; one beyond them lies."""
    case, t = cases.load(ROLLS), np.linspace(0.0, 1.0, 501)
    exact = reference.simulate(case, rtol=1e-12)(t)
    tangent, normal = case.track.tangent(0.0), case.track.normal(0.0)
    for deep in (-5e-4, 5e-4):
        x, y = np.array([exact.x, exact.y]) + deep * normal[:, None]
        frame = pd.DataFrame({"t": t, "x": x, "y": y, "theta": exact.theta, "vx": exact.vx, "vy": exact.vy})
        frame = frame.assign(omega=exact.omega, slip=-(1 - share) * deep * exact.omega)
        assert np.abs(frame.slip).max() <= abs(deep * exact.omega).max()
        motion_file.trajectory_of(case, frame)
        # So far away no pose would be taken for the track's; and the centre's own speed is no slip.
        for lie in (4 * deep * exact.omega, -4 * deep * exact.omega, tangent @ [exact.vx, exact.vy]):
            with pytest.raises(cases.DoesNotFit, match="slip is not the velocity"):
                motion_file.trajectory_of(case, frame.assign(slip=lie))


@pytest.mark.parametrize("engine", ["exudyn", "pymunk"])
def test_sound_motion_of_an_engine_is_accused_of_nothing(engine):
    case = cases.load(NAME)
    motion = play(engine, "native", case, 2)
    columns = {name: getattr(motion, name) for name in FULL[:7]}
    assert diagnosis.mistakes(case, columns, MOTION) == []


def test_plate_that_leaves_its_track_ends_there(tmp_path, catalogue, capsys):
    (tmp_path / "hill.py").write_text(
        "from cases import *\nfrom cases import curves\n"
        '@case\ndef hilltop():\n    """A disc let go on a hill."""\n'
        "    track = Curve(lambda s: (curves.sin(s), curves.cos(s)))\n"
        "    return Case(track, disc(0.1, 1.0), (Gravity(9.81), Unilateral()), Start(0.2), duration=1.2)\n"
    )
    cases.load_file(tmp_path / "hill.py")
    motion = reference.simulate(cases.load("hilltop"), rtol=1e-12)
    frame, end = table(motion=motion), motion.t[-1]
    # The flight, written as a solver would that goes on without contact.
    later = np.linspace(end, 1.0, 200)[1:]
    last = motion(end)
    flight = pd.DataFrame(dict(
        t=later, x=last.x + last.vx * (later - end), theta=last.theta, vx=last.vx, omega=last.omega, slip=last.slip,
        y=last.y + last.vy * (later - end) - 4.905 * (later - end) ** 2, vy=last.vy - 9.81 * (later - end),
        normal_force=0.0, friction_force=0.0,
    ))  # fmt: skip
    status, text, _ = judged(tmp_path, capsys, pd.concat([frame, flight])[list(FULL)], "hilltop")
    assert status == 0
    # An exact motion: what it is off is within the doubt of its samples, and no mistake is suspected.
    off, doubt = re.search(r"off ([\d.]+) % ± ([\d.]+) %", text).groups()
    assert float(off) <= float(doubt) < 0.2
    assert "seem" not in text
    (row,) = ledger(text)
    # The last sample that is pressed, of 2500 in the motion.
    assert float(row[5]) == pytest.approx(0.0, abs=1e-3)


def test_a_force_that_is_nowhere_told_ends_no_motion_with_a_crash():
    case = cases.load("disc_rolling_off_hill")
    names, rows = export.motion(export.true_motion(case))
    table = pd.DataFrame(rows, columns=list(names)).assign(normal_force=0.0)
    assert motion_file.trajectory_of(case, table).status == "lift_off"


def test_impulses_of_impacts_stand_beside_the_truths_in_text_and_json(tmp_path, capsys):
    case = cases.load("bouncing_disc")
    motion, file = reference.simulate(case), tmp_path / "soft.csv"
    frame = table(FULL, motion, samples=4001).fillna(0.0)
    first = motion.impacts[0]
    # Half of the first impact's friction is missing: of its change of velocity and of rotation.
    later = frame.t > first.time
    turn = motion(first.time + 1e-6).omega - motion(first.time - 1e-6).omega
    for rate, pose, change in (("vx", "x", first.friction), ("omega", "theta", turn)):
        frame.loc[later, rate] -= 0.5 * change
        frame.loc[later, pose] -= 0.5 * change * (frame.t - first.time)
    frame.drop(columns="slip").to_csv(file, index=False)
    assert compare.main(["bouncing_disc", str(file)]) == 0
    text = capsys.readouterr().out
    (line,) = [line.split() for line in text.splitlines() if line.startswith("plate/track") and "0.319275428" in line]
    assert line[2:6] == ["4.698", "4.698", "-0.3333", "-0.1667"]
    assert compare.main(["bouncing_disc", str(file), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    one = found["impacts"][0]
    assert one["reference_friction"] == pytest.approx(first.friction) and one["normal"] == pytest.approx(first.normal)
    assert one["friction"] == pytest.approx(0.5 * first.friction, rel=1e-6)
    assert found["grade"] and found["transitions"][0]["pairing"] == "paired"
    # With poses alone the velocities at an impact are differences over it.
    frame[["t", "x", "y", "theta"]].to_csv(file, index=False)
    assert (
        compare.judgement(case, file)["impacts"][0]["normal"] != compare.judgement(case, file)["impacts"][0]["normal"]
    )


def test_the_exported_impacts_are_those_of_the_motion(tmp_path):
    case = cases.load("dropped_box")
    export.export(case, tmp_path)
    rows, true = pd.read_csv(tmp_path / "impacts.csv"), export.true_motion(case).impacts
    assert rows["contact"].tolist() == [one.contact for one in true] and len(rows) == 3
    for name in ("time", "normal", "friction", "work"):
        assert rows[name].tolist() == pytest.approx([getattr(one, name) for one in true], rel=1e-15, nan_ok=True)


def test_two_reports_are_compared_as_json(tmp_path, capsys):
    for folder in (tmp_path / "a", tmp_path / "b"):
        (folder / "tables").mkdir(parents=True)
        (folder / "manifest.json").write_text('{"format": 2}')
        off = "0.1" if folder.name == "a" else "0.2"
        head = "case,solver,route,setting,outcome,off,off_doubt,rung"
        (folder / "tables" / "trajectories.csv").write_text(f"{head}\nball,mine,native,h=1,answered,{off},0,1\n")
    assert compare.main([str(tmp_path / "a"), str(tmp_path / "b"), "--json"]) == 3
    found = json.loads(capsys.readouterr().out)
    assert [(d["column"], d["one"], d["other"]) for d in found["results"]] == [("off", "0.1", "0.2")]
