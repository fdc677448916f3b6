"""Motions that others hand in: the form is held, a motion of each kind is judged, the report has them."""

from __future__ import annotations

import json

import numpy as np
import pandas as pd
import pytest

import cases
import reference
from cases import CaseError
from reports import build, compare
from reports.running import submissions

CASE = cases.load("disc_on_line", mu=0.1)
HEAD = dict(engine="mine", version="1.0", who="Somebody", machine="a machine", settings="h = 1 ms")


@pytest.fixture(scope="module")
def poses() -> pd.DataFrame:
    motion = reference.simulate(CASE, rtol=1e-12)
    t = np.linspace(0.0, float(motion.t[-1]), 1501)
    state = motion(t)
    return pd.DataFrame({"t": t, "x": state.x, "y": state.y, "theta": state.theta})


@pytest.fixture
def hand_in(tmp_path):
    def write(table: pd.DataFrame, **head):
        words = HEAD | head
        folder = tmp_path / "submissions" / "mine" / "1.0"
        folder.mkdir(parents=True)
        lines = [f"{name} = {json.dumps(value)}" for name, value in words.items() if value is not None]
        (folder / "submission.toml").write_text("\n".join(lines))
        table.to_csv(folder / f"{CASE.label}.csv", index=False)
        return folder

    return write


def wrong(poses):
    """It rolls from the start at the speed it has at the end."""
    speed = (poses.x.iloc[-1] - poses.x.iloc[-2]) / (poses.t.iloc[-1] - poses.t.iloc[-2])
    return poses.assign(x=speed * poses.t, theta=-speed * poses.t / CASE.plate.radius + poses.theta.iloc[0])


def creeping(poses):
    """It goes on slipping at 5 mm/s where it should roll."""
    stuck = np.maximum(poses.t - reference.simulate(CASE).transitions[0].time, 0.0)
    return poses.assign(x=poses.x + 5e-3 * stuck)


def test_a_wrong_motion_is_a_result(hand_in, poses):
    _, (run,) = submissions.judge_all(hand_in(wrong(poses)))
    assert run.outcome == "answered" and any(row.pairing == "missed" for row in run.ledger)
    assert run.grade == "unusable"


def test_declared_creep_counts_as_rolling(hand_in, poses):
    _, (run,) = submissions.judge_all(hand_in(creeping(poses), creep=6e-3))
    assert [row.pairing for row in run.ledger] == ["paired"]
    assert run.score.creep == pytest.approx(5e-3, rel=1e-3)


@pytest.mark.parametrize(
    ("head", "said"),
    [
        ({"who": None}, "has no who"),
        ({"engine": "another"}, "give both the same name"),
        ({"engine": "=cmd()"}, "give letters"),
        ({"settings": ["h"]}, "has no settings"),
        ({"machine": "a\nb"}, "not a single line"),
        ({"machine": "a" * 400}, "shorten it"),
        ({"creep": "5e-3"}, "without quotation marks"),
        ({"creep": 10**400}, "give a speed"),
        ({"colour": "red"}, "unknown entry"),
    ],
)
def test_a_head_out_of_form_is_one_sentence(hand_in, poses, head, said, capsys):
    assert compare.main([str(hand_in(poses, **head))]) == 2
    output = capsys.readouterr().err
    assert said in output and output.count("\n") == 1


def test_a_folder_out_of_form_is_one_sentence(hand_in, poses, tmp_path):
    folder = hand_in(poses)
    (folder / f"{CASE.label}.csv").rename(folder / "disc_in_a_square.csv")
    with pytest.raises(CaseError, match="disc_in_a_square"):
        submissions.judge_all(folder)
    (folder / "disc_in_a_square.csv").unlink()
    with pytest.raises(CaseError, match=r"has no CASE\.csv"):
        submissions.read(folder)
    with pytest.raises(CaseError, match="there is no folder"):
        submissions.read(tmp_path / "nowhere")
    (folder / "submission.toml").write_bytes(b"who = \xff")
    with pytest.raises(CaseError, match="is no TOML text"):
        submissions.read(folder)
    for odd in ("creep = " + "[" * 8000, "creep = " + "9" * 5000):
        (folder / "submission.toml").write_text(odd)
        with pytest.raises(CaseError, match="is not TOML"):
            submissions.read(folder)
    (folder / "submission.toml").write_text("#" * 20_000)
    with pytest.raises(CaseError, match="larger than 16,384 bytes"):
        submissions.read(folder)


def test_two_files_of_one_case_are_refused(hand_in, poses):
    """Of two names of one case the better motion was ranked."""
    folder = hand_in(poses)
    copy = folder / f"{CASE.label.replace('0.1', '0.10')}.csv"
    copy.write_bytes((folder / f"{CASE.label}.csv").read_bytes())
    assert copy.stem != CASE.label
    with pytest.raises(CaseError, match="motions of one case"):
        submissions.read(folder)


def test_a_link_is_not_followed_to_what_is_not_the_strangers(hand_in, poses, tmp_path):
    folder, secret = hand_in(poses), tmp_path / "secret"
    secret.write_text("the first line of somebody's file\n")
    file = folder / f"{CASE.label}.csv"
    file.unlink()
    file.symlink_to(secret)
    with pytest.raises(CaseError, match="is a link") as problem:
        submissions.judge_all(folder)
    assert "first line" not in str(problem.value)
    head = folder / "submission.toml"
    head.unlink()
    head.symlink_to(secret)
    with pytest.raises(CaseError, match="is a link"):
        submissions.read(folder)


def test_a_report_has_it_as_a_solver_of_its_own(hand_in, poses, tmp_path, without_figures, in_process):
    root = hand_in(poses).parent.parent
    words = ["--quick", "--case", CASE.label, "--solver", "reference", "--submissions", str(root)]
    with without_figures(), in_process():
        assert build.main([*words, "--out", str(tmp_path / "report"), "--store", str(tmp_path / "store")]) == 0
    rows = pd.read_csv(tmp_path / "report" / "tables" / "trajectories.csv")
    (row,) = rows[rows.solver == "mine 1.0"].itertuples()
    assert (row.route, row.outcome) == ("submission", "answered")
